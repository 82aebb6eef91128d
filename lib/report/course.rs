//! How a value went over the moments of a search, as a drawing within the page.

use super::Moment;
use super::chart::plain;
use super::text::{escape, fixed};

/// Size of a drawing, and where its plot begins and ends.
const SIZE: (f64, f64) = (320.0, 150.0);
const LEFT: f64 = 54.0;
const RIGHT: f64 = SIZE.0 - 10.0;
const TOP: f64 = 10.0;
const BOTTOM: f64 = SIZE.1 - 24.0;

/// More moments than this are a cloud, in which only the best so far is a line.
const CLOUD: usize = 60;
/// The most points of a cloud.
const MOST_POINTS: usize = 1500;

/// How many of its last standard errors to each side are shown of a value.
const SHOWN: f64 = 6.0;

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
    /// The drawing; nothing where nothing is known.
    pub fn draw(&self) -> String {
        let Some(plot) = Plot::of(self) else { return String::new() };
        let (width, height) = SIZE;
        let drawn = if plot.cloud { self.cloud(&plot) } else { self.line(&plot) };
        format!(
            "<figure class=\"course {}\"><figcaption>{}</figcaption><svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{1}\">{}{drawn}{}</svg></figure>\n",
            self.class,
            escape(self.title),
            plot.grid(),
            self.moments(&plot)
        )
    }

    /// Where it is known: the moment, the value and its error.
    fn known(&self) -> impl Iterator<Item = (usize, &(f64, Option<f64>))> {
        self.points.iter().enumerate().filter(|(_, point)| point.0.is_finite())
    }

    /// All moments as a cloud, in which only the best so far is a line.
    fn cloud(&self, plot: &Plot) -> String {
        let step = self.points.len().div_ceil(MOST_POINTS);
        let dots: String = self.known().step_by(step).map(|(i, p)| format!("M{:.1} {:.1}h0", plot.x(i), plot.y(p.0))).collect();
        let mut line = String::new();
        for &i in self.best {
            let (x, y) = (plot.x(i), plot.y(self.points[i].0));
            line += &if line.is_empty() { format!("M{x:.1} {y:.1}") } else { format!("H{x:.1}V{y:.1}") };
        }
        format!("<path class=\"cloud\" d=\"{dots}\"/><path class=\"line\" d=\"{line}H{RIGHT:.1}\"/>")
    }

    /// A line through all moments, with their errors. It ends where it leaves the plot.
    fn line(&self, plot: &Plot) -> String {
        let known: Vec<(f64, f64)> = self.known().map(|(i, p)| (plot.x(i), plot.scale(p.0))).collect();
        let line: String = known
            .windows(2)
            .filter_map(|two| inside(two[0], two[1], plot.range))
            .map(|[a, b]| format!("M{:.1} {:.1}L{:.1} {:.1}", a.0, plot.height_of(a.1), b.0, plot.height_of(b.1)))
            .collect();
        let mut out = format!("<path class=\"line\" d=\"{line}\"/>");
        let (low, high) = plot.range;
        for (i, &(v, error)) in self.known().filter(|(_, p)| (low..=high).contains(&plot.scale(p.0))) {
            let at = plot.x(i);
            if let Some(e) = error.filter(|e| e.is_finite()) {
                let (y1, y2) = (plot.y(v - e), plot.y(v + e));
                out += &format!("<line class=\"error\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{y1:.1}\" y2=\"{y2:.1}\"/>");
            }
            out += &format!("<circle class=\"dot\" cx=\"{at:.1}\" cy=\"{:.1}\" r=\"3\"/>", plot.y(v));
        }
        out
    }

    /// The numbers of the first and the last moment, and what they are called.
    fn moments(&self, plot: &Plot) -> String {
        let label = |x: f64, text: &str| format!("<text class=\"middle\" x=\"{x:.1}\" y=\"{}\">{text}</text>", SIZE.1 - 6.0);
        let unit = label((LEFT + RIGHT) / 2.0, self.unit);
        match self.points.len() {
            0 | 1 => unit,
            count => label(plot.x(0), "1") + &label(plot.x(count - 1).min(SIZE.0 - 16.0), &count.to_string()) + &unit,
        }
    }
}

/// Where moments and values lie in the drawing.
struct Plot {
    /// The lowest and the highest that is shown, on the scale.
    range: (f64, f64),
    /// Whether that is logarithmic.
    logarithmic: bool,
    /// Whether there are too many moments for a line.
    cloud: bool,
    /// How many there are.
    count: usize,
}

impl Plot {
    /// A plot of all that is known; `None` if nothing is.
    fn of(course: &Course) -> Option<Self> {
        let count = course.points.len();
        let logarithmic = course.logarithmic && course.known().all(|(_, p)| p.0 > 0.0);
        let mut plot = Self { range: (0.0, 1.0), logarithmic, cloud: count > CLOUD, count };
        // The last error sets the scale, if it is known: how it began may lie beyond.
        let (low, high) = match course.points.last() {
            Some(&(v, Some(e))) if e.is_finite() && e > 0.0 => (v - SHOWN * e, v + SHOWN * e),
            _ => course.known().map(|(_, p)| plot.scale(p.0)).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v))),
        };
        let room = (0.06 * (high - low)).max(1e-9 * high.abs()).max(1e-12);
        plot.range = (low - room, high + room);
        (low <= high).then_some(plot)
    }

    fn scale(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }

    fn x(&self, moment: usize) -> f64 {
        let inset = if self.cloud { 0.0 } else { 14.0 };
        let along = if self.count > 1 { moment as f64 / (self.count - 1) as f64 } else { 0.5 };
        LEFT + inset + (RIGHT - LEFT - 2.0 * inset) * along
    }

    /// The height of what is `scaled`.
    fn height_of(&self, scaled: f64) -> f64 {
        let (low, high) = self.range;
        TOP + (BOTTOM - TOP) * (high - scaled.clamp(low, high)) / (high - low)
    }

    fn y(&self, value: f64) -> f64 {
        self.height_of(self.scale(value))
    }

    /// Lines at round numbers, with what they are called.
    fn grid(&self) -> String {
        let line = |(tick, label): (f64, String)| {
            let y = self.height_of(tick);
            let text = format!("<text class=\"end\" x=\"{}\" y=\"{:.1}\">{label}</text>", LEFT - 6.0, y + 4.0);
            format!("<line class=\"grid\" x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>{text}")
        };
        ticks(self.range.0, self.range.1, self.logarithmic).into_iter().map(line).collect()
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
