//! Numbers as C's `printf` writes them: RADIANCE's generators print a limited number of digits.

use std::io::Write;

/// `%.{digits}g`.
pub fn g(x: f64, digits: usize) -> String {
    let digits = digits.max(1);
    if x == 0.0 || !x.is_finite() {
        return if x.is_finite() && x.is_sign_negative() { "-0".into() } else { format!("{x}") };
    }
    let scientific = format!("{x:.*e}", digits - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if exponent < -4 || exponent >= digits as i32 {
        let sign = if exponent < 0 { '-' } else { '+' };
        return format!("{}e{sign}{:02}", trimmed(mantissa), exponent.abs());
    }
    trimmed(&format!("{x:.*}", (digits as i32 - 1 - exponent).max(0) as usize)).to_string()
}

/// `%.{digits}e`.
pub fn e(x: f64, digits: usize) -> String {
    let mut text = Vec::new();
    put_e(&mut text, x, digits);
    String::from_utf8_lossy(&text).into_owned()
}

/// Appends `%.{digits}e` to a text.
pub fn put_e(text: &mut Vec<u8>, x: f64, digits: usize) {
    let start = text.len();
    // A vector takes all that is written.
    let _ = write!(text, "{x:.digits$e}");
    // Of an exponent, C writes the sign, and two digits at the least.
    let Some(mark) = text[start..].iter().rposition(|&b| b == b'e') else { return };
    let mut at = start + mark + 1;
    if text[at] != b'-' {
        text.insert(at, b'+');
    }
    at += 1;
    if text.len() - at < 2 {
        text.insert(at, b'0');
    }
}

/// The number without zeros at the end of its fraction.
fn trimmed(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn general_format_agrees_with_c() {
        // printf '%.12g %.6g …' in the shell.
        for (x, digits, text) in [
            (0.1 + 0.2, 12, "0.3"),
            (1e10, 12, "10000000000"),
            (1e-7, 12, "1e-07"),
            (1234567.0, 6, "1.23457e+06"),
            (0.0001, 6, "0.0001"),
            (999999.5, 6, "1e+06"),
            (-0.0, 6, "-0"),
            (std::f64::consts::FRAC_1_SQRT_2, 6, "0.707107"),
        ] {
            assert_eq!(g(x, digits), text);
        }
    }

    #[test]
    fn scientific_format_agrees_with_c() {
        // printf '%.3e …' in the shell.
        let numbers = [7177000.0, 0.0, -2.5e-7, 1e10, 1.5e-300, f64::INFINITY];
        assert_eq!(numbers.map(|x| e(x, 3)).join(" "), "7.177e+06 0.000e+00 -2.500e-07 1.000e+10 1.500e-300 inf");
    }
}
