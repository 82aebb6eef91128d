//! What is said of a recovery.

/// The value of a parameter and its standard error, as they are printed.
pub fn said(out: &str, name: &str) -> (f64, f64) {
    let line = out.lines().find(|line| line.starts_with(&format!("# {name} "))).unwrap();
    let words: Vec<&str> = line.split(' ').collect();
    (words[2].parse().unwrap(), words[4].trim_end_matches(':').parse().unwrap())
}
