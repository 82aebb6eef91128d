//! Words, numbers and pictures as a page holds them.

use crate::error::Result;
use crate::picture::png::write;
use crate::recover::words::decimals;

/// Text as HTML shows it, in an element or a quoted attribute. Characters that no page may hold are shown as replaced.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            '\n' | '\t' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// A number with so many digits behind the point, and a minus sign that is one.
pub fn fixed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.into(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// Three digits, whatever the size.
pub fn brief(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || (0.001..100_000.0).contains(&size) {
        let text = fixed(x, if size == 0.0 { 0 } else { (2 - size.log10().floor() as i32).clamp(0, 6) as usize });
        return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text };
    }
    if !x.is_finite() {
        return if x.is_nan() { "–".into() } else { fixed(x, 0).replace("inf", "∞") };
    }
    let text = format!("{x:.2e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    format!("{}·10<sup>{}</sup>", digits.replace('-', "−"), exponent.replace('-', "−"))
}

/// A value with the digits that its error leaves it, and the error with two.
pub fn rounded(value: f64, error: Option<f64>) -> (String, Option<String>) {
    match error {
        Some(error) if error > 0.0 && error.is_finite() => {
            let decimals = decimals(error);
            (fixed(value, decimals), Some(fixed(error, decimals)))
        }
        Some(0.0) => (fixed(value, 4), Some("0".into())),
        Some(_) => (fixed(value, 2), Some("∞".into())),
        None => (fixed(value, 4), None),
    }
}

/// A picture as an address that holds it all.
pub fn data_uri(width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<String> {
    Ok(format!("data:image/png;base64,{}", base64(&write(width, height, pixels)?)))
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let word = three.iter().fold(0u32, |w, &b| w << 8 | b as u32) << (8 * (3 - three.len()));
        for i in 0..4 {
            out.push(if i <= three.len() { LETTERS[(word >> (18 - 6 * i)) as usize & 63] as char } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        let wanted = ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"];
        wanted.iter().enumerate().for_each(|(n, wanted)| assert_eq!(base64(&b"foobar"[..n]), *wanted));
    }

    #[test]
    fn values_have_the_digits_that_their_errors_leave() {
        let shown = |value, error| rounded(value, error);
        assert_eq!(shown(0.80163, Some(0.00036)), ("0.80163".into(), Some("0.00036".into())));
        assert_eq!(shown(-12.3, Some(4.0)), ("−12.3".into(), Some("4.0".into())));
        assert_eq!(shown(0.5, Some(f64::INFINITY)), ("0.50".into(), Some("∞".into())));
        assert_eq!(shown(0.123456, None), ("0.1235".into(), None));
        assert_eq!(
            [brief(0.0), brief(1234.5), brief(0.25), brief(-0.00012)],
            ["0", "1234", "0.25", "−1.20·10<sup>−4</sup>"].map(String::from)
        );
        assert_eq!(fixed(-0.0001, 2), "0.00");
    }

    #[test]
    fn nothing_that_was_named_becomes_a_tag() {
        assert_eq!(escape("<a href=\"x\">'&\u{0}"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;\u{fffd}");
    }
}
