//! Where values lie and how they go together, as drawings within the page.

use super::text::{brief, escape, fixed};
use crate::anneal::Parameter;
use crate::anneal::linear::Symmetric;

/// The class by which the page colours what belongs to a parameter.
pub fn class(name: &str) -> &'static str {
    match name {
        "red" => "r",
        "green" => "g",
        "blue" => "b",
        _ => "k",
    }
}

/// Where a value and its error lie between the bounds, and where the search started.
pub fn place(parameter: &Parameter, value: f64, error: Option<f64>) -> String {
    const WIDTH: f64 = 260.0;
    let Parameter { name, low, high, start } = parameter;
    let x = |v: f64| 6.0 + (WIDTH - 12.0) * ((v - low) / (high - low)).clamp(0.0, 1.0);
    let mut out = format!("<svg class=\"place {}\" viewBox=\"0 0 {WIDTH} 31\" role=\"img\" aria-label=\"{}\">", class(name), escape(name));
    let end = WIDTH - 6.0;
    out += &format!("<path class=\"axis\" d=\"M6 10H{end}M6 6v8M{end} 6v8\"/>");
    out += &format!("<path class=\"start\" d=\"M{:.2} 5l-3.5 -5h7z\"/>", x(*start));
    if let Some(e) = error.filter(|e| !e.is_nan()) {
        out += &format!("<path class=\"error\" d=\"M{:.2} 10H{:.2}\"/>", x(value - e), x(value + e));
    }
    out += &format!("<circle class=\"dot\" cx=\"{:.2}\" cy=\"10\" r=\"4\"/>", x(value));
    out += &format!(
        "<text x=\"2\" y=\"28\">{}</text><text class=\"end\" x=\"{}\" y=\"28\">{}</text></svg>",
        plain(*low),
        WIDTH - 2.0,
        plain(*high)
    );
    out
}

/// Two digits without markup.
pub fn plain(x: f64) -> String {
    if (0.001..100_000.0).contains(&x.abs()) || x == 0.0 { brief(x) } else { format!("{x:.0e}").replace('-', "−") }
}

/// The correlations of pairs of parameters; `None` if there are none.
pub fn matrix(parameters: &[Parameter], correlations: &Symmetric) -> Option<String> {
    const CELL: f64 = 50.0;
    const LABEL: f64 = 74.0;
    let n = parameters.len();
    if n < 2 {
        return None;
    }
    let (width, height) = (LABEL + (n - 1) as f64 * CELL, (n - 1) as f64 * CELL * 0.64 + 22.0);
    let mut out = format!(
        "<svg class=\"matrix\" viewBox=\"0 0 {width} {height:.1}\" style=\"max-width:{width}px\" role=\"img\" aria-label=\"Correlations\">"
    );
    for i in 1..n {
        let y = (i - 1) as f64 * CELL * 0.64;
        out += &format!("<text class=\"end\" x=\"{}\" y=\"{:.1}\">{}</text>", LABEL - 8.0, y + 20.0, escape(&parameters[i].name));
        for j in 0..i {
            let (r, x) = (correlations.at(i, j), LABEL + j as f64 * CELL);
            let side = if r < 0.0 { "cold" } else { "warm" };
            let strength = if r.is_finite() { r.abs().min(1.0) } else { 0.0 };
            out += &format!(
                "<rect class=\"{side}\" x=\"{:.1}\" y=\"{:.1}\" width=\"{}\" height=\"{:.1}\" rx=\"2\" fill-opacity=\"{strength:.2}\"/><text \
                 class=\"middle{}\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                x + 1.0,
                y + 1.0,
                CELL - 2.0,
                CELL * 0.64 - 2.0,
                if strength > 0.6 { " on" } else { "" },
                x + CELL / 2.0,
                y + 20.5,
                if r.is_finite() { fixed(r, 2) } else { "–".into() },
            );
        }
    }
    for (j, parameter) in parameters[..n - 1].iter().enumerate() {
        let x = LABEL + (j as f64 + 0.5) * CELL;
        out += &format!("<text class=\"middle\" x=\"{x:.1}\" y=\"{:.1}\">{}</text>", height - 6.0, escape(&parameter.name));
    }
    Some(out + "</svg>")
}
