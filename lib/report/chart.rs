//! Charts of a recovery, as drawings within the page.

use super::Moment;
use super::text::{brief, escape, fixed};
use crate::anneal::Parameter;
use crate::anneal::linear::Symmetric;

/// Size of a chart, and the margins of its plot: left, right, top, bottom.
const SIZE: (f64, f64) = (320.0, 150.0);
const MARGINS: [f64; 4] = [54.0, 10.0, 10.0, 24.0];

/// More moments than this are a cloud, in which only the best so far is a line.
const CLOUD: usize = 60;
/// The most points of a cloud.
const MOST_POINTS: usize = 1500;

/// How many of its last standard errors to each side are shown of a value.
const SHOWN: f64 = 6.0;

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

/// What is drawn over the moments of a search.
pub struct Course<'a> {
    /// What it is called.
    pub title: &'a str,
    /// The class by which it is coloured.
    pub class: &'a str,
    /// What it was at each moment, and its standard error; not a number where it was not known.
    pub points: Vec<(f64, Option<f64>)>,
    /// At which moments the best so far was found.
    pub best: &'a [usize],
    /// Whether equal factors are equally high.
    pub logarithmic: bool,
    /// What the moments are called.
    pub unit: &'a str,
}

/// The moments at which the best so far was found.
pub fn best(trail: &[Moment]) -> Vec<usize> {
    let mut least = f64::INFINITY;
    (0..trail.len()).filter(|&i| trail[i].misfit().is_some_and(|c| c < least && std::mem::replace(&mut least, c) > c)).collect()
}

impl Course<'_> {
    /// The drawing.
    pub fn draw(&self) -> String {
        let [left, right, top, bottom] = MARGINS;
        let ((width, height), cloud) = (SIZE, self.points.len() > CLOUD);
        let seen = || self.points.iter().enumerate().filter(|(_, p)| p.0.is_finite());
        let logarithmic = self.logarithmic && seen().all(|(_, p)| p.0 > 0.0);
        let scale = |v: f64| if logarithmic { v.log10() } else { v };
        // The last error sets the scale, if it is known: how it began may lie beyond.
        let (mut low, mut high) = match self.points.last() {
            Some(&(v, Some(e))) if e.is_finite() && e > 0.0 => (v - SHOWN * e, v + SHOWN * e),
            _ => seen().map(|(_, p)| scale(p.0)).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v))),
        };
        if low > high {
            return String::new();
        }
        let room = (0.06 * (high - low)).max(1e-9 * high.abs()).max(1e-12);
        (low, high) = (low - room, high + room);
        let last = self.points.len().saturating_sub(1).max(1) as f64;
        let inset = if cloud { 0.0 } else { 14.0 };
        let x = |i: usize| left + inset + (width - left - right - 2.0 * inset) * if self.points.len() > 1 { i as f64 / last } else { 0.5 };
        let height_of = |v: f64| top + (height - top - bottom) * (high - v.clamp(low, high)) / (high - low);
        let y = |v: f64| height_of(scale(v));
        let mut out = format!(
            "<figure class=\"course {}\"><figcaption>{}</figcaption><svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{1}\">",
            self.class,
            escape(self.title)
        );
        for (tick, label) in ticks(low, high, logarithmic) {
            let y = height_of(tick);
            out += &format!("<line class=\"grid\" x1=\"{left}\" x2=\"{}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>", width - right);
            out += &format!("<text class=\"end\" x=\"{}\" y=\"{:.1}\">{label}</text>", left - 6.0, y + 4.0);
        }
        if cloud {
            let step = self.points.len().div_ceil(MOST_POINTS);
            let dots: String = seen().step_by(step).map(|(i, p)| format!("M{:.1} {:.1}h0", x(i), y(p.0))).collect();
            out += &format!("<path class=\"cloud\" d=\"{dots}\"/>");
            let mut line = String::new();
            for &i in self.best {
                let (x, y) = (x(i), y(self.points[i].0));
                line += &if line.is_empty() { format!("M{x:.1} {y:.1}") } else { format!("H{x:.1}V{y:.1}") };
            }
            out += &format!("<path class=\"line\" d=\"{line}H{:.1}\"/>", width - right);
        } else {
            // Lines end where they leave the plot.
            let known: Vec<(f64, f64)> = seen().map(|(i, p)| (x(i), scale(p.0))).collect();
            let line: String = known
                .windows(2)
                .filter_map(|two| inside(two[0], two[1], (low, high)))
                .map(|[a, b]| format!("M{:.1} {:.1}L{:.1} {:.1}", a.0, height_of(a.1), b.0, height_of(b.1)))
                .collect();
            out += &format!("<path class=\"line\" d=\"{line}\"/>");
            for (i, &(v, error)) in seen().filter(|(_, p)| (low..=high).contains(&scale(p.0))) {
                let at = x(i);
                if let Some(e) = error.filter(|e| e.is_finite()) {
                    out += &format!("<line class=\"error\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{:.1}\" y2=\"{:.1}\"/>", y(v - e), y(v + e));
                }
                out += &format!("<circle class=\"dot\" cx=\"{at:.1}\" cy=\"{:.1}\" r=\"3\"/>", y(v));
            }
        }
        let below = height - 6.0;
        if self.points.len() > 1 {
            out += &format!("<text class=\"middle\" x=\"{:.1}\" y=\"{below}\">1</text>", x(0));
            out += &format!(
                "<text class=\"middle\" x=\"{:.1}\" y=\"{below}\">{}</text>",
                x(self.points.len() - 1).min(width - 16.0),
                self.points.len()
            );
        }
        out += &format!(
            "<text class=\"middle\" x=\"{:.1}\" y=\"{below}\">{}</text></svg></figure>\n",
            (left + width - right) / 2.0,
            self.unit
        );
        out
    }
}

/// The part of a line between two points whose second coordinates are within bounds.
fn inside(a: (f64, f64), b: (f64, f64), (low, high): (f64, f64)) -> Option<[(f64, f64); 2]> {
    let at = |t: f64| (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
    let [from, to] = [low, high].map(|bound| (bound - a.1) / (b.1 - a.1));
    let (first, last) = if a.1 == b.1 {
        if (low..=high).contains(&a.1) { (0.0, 1.0) } else { return None }
    } else {
        (from.min(to).max(0.0), from.max(to).min(1.0))
    };
    (first < last).then(|| [at(first), at(last)])
}

/// Round numbers between two, with what they are called; logarithms of round numbers if `logarithmic`.
fn ticks(low: f64, high: f64, logarithmic: bool) -> Vec<(f64, String)> {
    if logarithmic && high - low > 1.0 {
        let step = ((high - low) / 3.0).ceil().max(1.0);
        let first = (low / step).ceil() * step;
        return (0..5).map(|i| first + i as f64 * step).filter(|&t| t <= high).map(|t| (t, plain(10f64.powf(t)))).collect();
    }
    let (from, to) = if logarithmic { (10f64.powf(low), 10f64.powf(high)) } else { (low, high) };
    let unit = 10f64.powf((to - from).log10().floor());
    let two = |step: &f64| (to / step).floor() - (from / step).ceil() >= 1.0;
    let step = [5.0, 2.0, 1.0, 0.5, 0.2, 0.1].map(|m| m * unit).into_iter().find(two).unwrap_or(0.1 * unit);
    let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 9.0) as usize;
    let first = (from / step).ceil() as i64;
    let marks = (0..8).map(|i| (first + i) as f64 * step).filter(|&t| t <= to && (!logarithmic || t > 0.0));
    marks.map(|t| (if logarithmic { t.log10() } else { t }, if step >= 1e5 { plain(t) } else { fixed(t, decimals) })).collect()
}

/// Two digits without markup.
fn plain(x: f64) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_ends_where_it_leaves_the_plot() {
        assert_eq!(inside((0.0, 0.0), (2.0, 4.0), (1.0, 2.0)), Some([(0.5, 1.0), (1.0, 2.0)]));
        assert_eq!(inside((0.0, 1.5), (1.0, 1.5), (1.0, 2.0)), Some([(0.0, 1.5), (1.0, 1.5)]));
        assert_eq!(inside((0.0, 3.0), (1.0, 4.0), (1.0, 2.0)), None);
    }

    #[test]
    fn a_scale_has_round_numbers_two_at_least() {
        let labels = |low, high, logarithmic| ticks(low, high, logarithmic).into_iter().map(|t| t.1).collect::<Vec<_>>();
        assert_eq!(labels(0.7967, 0.8055, false), ["0.800", "0.805"]);
        assert_eq!(labels(-0.1, 1.05, false), ["0", "1"]);
        assert_eq!(labels(-1.2, 2.1, true), ["1", "100"]);
    }
}
