//! Numbers and lists in words.

/// Words as a list: `a, b and c`.
pub fn list(words: &[impl AsRef<str>]) -> String {
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    match &words[..] {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        _ => words.concat(),
    }
}

/// `1 evaluation`, `2 evaluations`.
pub fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

/// How far something moves, to the first digit.
pub fn by(far: f64) -> String {
    format!("by {far:.0$}", decimals(far) - 1)
}

/// A part in percent, to a tenth.
pub fn percent(part: f64) -> f64 {
    (1000.0 * part).round() / 10.0
}

/// How many decimals show two digits of an error: of .0996, which is .10, two.
pub fn decimals(error: f64) -> usize {
    if error > 0.0 { (1 - (error / 0.995).log10().floor() as i32).clamp(1, 12) as usize } else { 6 }
}

/// A value with the digits that its error leaves it, and the error with two.
pub fn digits(value: f64, error: f64) -> (String, String) {
    let decimals = decimals(error);
    (format!("{value:.decimals$}"), format!("{error:.decimals$}"))
}

/// `red + 0.41 spec = 0.641 ± 0.012`: what is known of two values that go together, of their names, the values, their variances and covariance.
pub fn combination(names: [&str; 2], values: [f64; 2], variances: [f64; 2], covariance: f64) -> String {
    let slope = covariance / variances[1];
    let error = (variances[0] - slope * covariance).max(0.0).sqrt();
    let (sum, error) = digits(values[0] - slope * values[1], error);
    let sign = if slope < 0.0 { '+' } else { '-' };
    format!("{} {sign} {:.2} {} = {sum} ± {error}", names[0], slope.abs(), names[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_shown_with_two_digits() {
        for (error, shown) in
            [(0.0996, "0.10"), (0.0994, "0.099"), (0.1, "0.10"), (0.0123, "0.012"), (0.00095, "0.00095"), (0.0009951, "0.0010")]
        {
            assert_eq!(digits(0.5, error).1, shown, "{error}");
        }
    }
}
