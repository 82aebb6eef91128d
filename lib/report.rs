//! A recovery as one page to look at: what was found, how sure it is, how it was found, what it looks like.
//!
//! The page holds all that it shows: pictures as PNG, charts as SVG, no script, nothing to fetch.

mod chart;
mod course;
mod text;
mod views;

pub use views::{Setting, Views};

use crate::anneal::Parameter;
use crate::anneal::linear::Symmetric;
use crate::error::Result;
use crate::metric::{Comparison, Loss, Named};
use crate::picture::Picture;
use crate::picture::png::Tone;
use crate::rad::Number;
use crate::recover::answer::six;
use crate::recover::model::{Kind, parts};
use crate::recover::words::combination;
use chart::{class, matrix, place};
use course::{Course, best};
use serde::{Deserialize, Serialize};
use text::{brief, data_uri, escape, fixed, rounded};

/// What a page tells.
pub struct Report<'a> {
    /// The identifier of the material.
    pub name: &'a str,
    /// Its type.
    pub kind: &'a str,
    /// What was searched for.
    pub parameters: &'a [Parameter],
    /// The real arguments of the material that was found.
    pub reals: &'a [f64],
    /// The values that were found.
    pub values: &'a [f64],
    /// Their standard errors, if they are known; infinite for what nothing determines.
    pub errors: Option<Vec<f64>>,
    /// The part of the standard errors that the noise of the rendering makes, if that is known.
    pub own: Option<Vec<f64>>,
    /// Correlations of the errors, if they are known.
    pub correlations: Option<Symmetric>,
    /// How far what was found is off, and by which measure.
    pub measure: (Loss, f64),
    /// How many pixels counted, if pixels were looked at.
    pub pixels: Option<usize>,
    /// What was found of the filter of the picture's pixels, if that was sought.
    pub filter: Option<String>,
    /// What there is to doubt.
    pub doubts: &'a [String],
    /// How it was found.
    pub trail: &'a [Moment],
    /// By which measure.
    pub followed: Loss,
    /// What a moment of it is called: `round`, `evaluation`.
    pub unit: &'a str,
    /// What can be seen, if the scene is known.
    pub views: Option<&'a Views>,
    /// The file that was recovered.
    pub file: &'a str,
    /// The command line.
    pub command: &'a str,
}

/// A moment of a search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// The values of the parameters.
    pub values: Vec<f64>,
    /// Their standard errors, if they were known.
    pub errors: Option<Vec<f64>>,
    /// How far off they are, if that was known: χ², or the loss that was followed.
    pub chi2: Option<f64>,
    /// Over how many pixels, if not always the same.
    pub pixels: Option<usize>,
}

impl Moment {
    /// The same, or that of a pixel: what can be compared with another moment's.
    fn misfit(&self) -> Option<f64> {
        self.chi2.map(|chi2| chi2 / self.pixels.unwrap_or(1) as f64)
    }
}

/// Correlations beyond this are told in words.
const STRONG: f64 = 0.9;

impl Report<'_> {
    /// The page.
    pub fn page(&self) -> Result<String> {
        let title = format!("{}: {}", escape(self.name), escape(self.kind));
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, \
             initial-scale=1\"/>\n<meta name=\"color-scheme\" content=\"light dark\"/>\n<meta name=\"generator\" content=\"Inverad {}\"/>\n\
             <title>{title}</title>\n<style>\n{}</style>\n</head>\n<body>\n<main>\n",
            VERSION,
            include_str!("report/style.css")
        );
        out += &self.head();
        out += &self.found();
        if let Some(views) = self.views {
            out += &self.appearance(views)?;
            out += &comparison(views)?;
        }
        out += &self.course();
        out += &self.correlated();
        out += &self.digits();
        Ok(out + "</main>\n</body>\n</html>\n")
    }

    /// What it is, in a sentence, and what to beware of.
    fn head(&self) -> String {
        let size = self.pixels.map_or_else(String::new, |n| format!(" over {} pixels", thousands(n)));
        let filter = self.filter.as_ref().map_or_else(String::new, |filter| format!(", {}", escape(filter)));
        let values = if self.parameters.len() == 1 { "value" } else { "values" };
        let mut out = format!(
            "<header>\n<h1>{}</h1>\n<p class=\"kind\">{}, recovered: {} {values}, {} = {}{size}{filter}</p>\n</header>\n",
            escape(self.name),
            escape(self.kind),
            self.parameters.len(),
            symbol(self.measure.0),
            brief(self.measure.1)
        );
        if !self.doubts.is_empty() {
            out += "<section class=\"doubts\">\n<h2>Beware</h2>\n<ul>\n";
            self.doubts.iter().for_each(|doubt| out += &format!("<li>{}</li>\n", escape(doubt)));
            out += "</ul>\n</section>\n";
        }
        out
    }

    /// The values, and where they lie between their bounds.
    fn found(&self) -> String {
        let mut out = String::from(
            "<section>\n<h2>What was found</h2>\n<table class=\"found\">\n<thead><tr><th>parameter</th><th class=\"number\">value</th>",
        );
        let column = |given: bool, title: &str| if given { format!("<th class=\"number\">{title}</th>") } else { String::new() };
        out += &column(self.errors.is_some(), "± standard error");
        out += &column(self.own.is_some(), "from our noise");
        out += "<th>between its bounds</th></tr></thead>\n<tbody>\n";
        for (i, (parameter, &value)) in self.parameters.iter().zip(self.values).enumerate() {
            let error = self.errors.as_ref().map(|e| e[i]);
            let (shown, uncertain) = rounded(value, error);
            out += &format!(
                "<tr class=\"{}\"><th>{}</th><td class=\"number value\">{shown}</td>",
                class(&parameter.name),
                escape(&parameter.name)
            );
            out += &uncertain.map_or_else(String::new, |e| format!("<td class=\"number\">{e}</td>"));
            if let (Some(own), Some(error)) = (&self.own, error) {
                // Both are estimates.
                let share = (own[i] / error).powi(2);
                out += &format!(
                    "<td class=\"number\">{}</td>",
                    if share.is_finite() { format!("{} %", fixed(100.0 * share.min(1.0), 0)) } else { "–".into() }
                );
            }
            out += &format!("<td>{}</td></tr>\n", place(parameter, value, error));
        }
        out += "</tbody>\n</table>\n<p class=\"note\">A dot is the value, the bar through it one standard error to each side, the triangle where the search began.";
        if self.own.is_some() {
            out += " “From our noise” is the part of the variance that the rendering makes, and more samples would remove; the rest is the photograph's noise and what errors are held for.";
        }
        out + "</p>\n</section>\n"
    }

    /// Spheres of the material, and what it does with light.
    fn appearance(&self, views: &Views) -> Result<String> {
        let mut out = String::from("<section>\n<h2>What it looks like</h2>\n<div class=\"pictures three\">\n");
        for (picture, caption) in [(&views.there, "A sphere of it in its place"), (&views.lamp, "A sphere of it in a studio")] {
            let tone = Tone::of(picture);
            out += &figure(picture.width, picture.height, &picture.pixels.iter().map(|&p| tone.map(p)).collect::<Vec<_>>(), caption)?;
        }
        Ok(out + &self.budget() + "</div>\n</section>\n")
    }

    /// What becomes of the light that falls on it.
    fn budget(&self) -> String {
        let Some(kind) = Kind::named(self.kind) else { return String::new() };
        let [diffuse, through, specular, straight] = parts(kind, self.reals);
        let angle = |a: &f64| format!("±{}°", brief(2.0 * a.abs().atan().to_degrees()));
        let roughness = &self.reals[kind.roughnesses()];
        let lobe = roughness.iter().map(angle).collect::<Vec<_>>().join(" and ");
        let mut rows = vec![("scattered evenly".to_string(), diffuse), (format!("mirrored within {lobe}"), specular)];
        if kind.transmits {
            rows.extend([("let through, scattered".into(), through), ("let through, straight".into(), straight)]);
        }
        let kept = std::array::from_fn(|c| 1.0 - rows.iter().map(|row| row.1[c]).sum::<f64>());
        rows.push(("absorbed".into(), kept));
        let mut out = String::from("<div class=\"budget\">\n<table>\n<thead><tr><th>of the light, %</th>");
        ["red", "green", "blue"].iter().for_each(|c| out += &format!("<th class=\"number {}\">{c}</th>", class(c)));
        out += "</tr></thead>\n<tbody>\n";
        for (what, shares) in rows {
            out += &format!("<tr><th>{what}</th>");
            shares.iter().for_each(|share| out += &format!("<td class=\"number\">{}</td>", fixed(100.0 * share, 1)));
            out += "</tr>\n";
        }
        out + "</tbody>\n</table>\n<p class=\"note\">Without the Fresnel effect. The angle is where the lobe has fallen to 1/e.</p>\n</div>\n"
    }

    /// How it was found.
    fn course(&self) -> String {
        if self.trail.len() < 2 {
            return String::new();
        }
        let best = best(self.trail);
        let mut out = String::from("<section>\n<h2>How it was found</h2>\n<div class=\"courses\">\n");
        let misfits: Vec<(f64, Option<f64>)> = self.trail.iter().map(|m| (m.misfit().unwrap_or(f64::NAN), None)).collect();
        let title = match (self.followed, self.trail.iter().any(|m| m.pixels.is_some())) {
            (Loss::Chi2, true) => "chi-squared a pixel",
            (Loss::Chi2, false) => "chi-squared",
            _ => "loss",
        };
        let course = |title, class, points, logarithmic| Course { title, class, points, best: &best, logarithmic, unit: self.unit };
        out += &course(title, "k", misfits, true).draw();
        for (i, parameter) in self.parameters.iter().enumerate() {
            let points = self.trail.iter().map(|m| (m.values[i], m.errors.as_ref().map(|e| e[i]))).collect();
            out += &course(&parameter.name, class(&parameter.name), points, false).draw();
        }
        out + "</div>\n</section>\n"
    }

    /// How the errors go together.
    fn correlated(&self) -> String {
        let Some((matrix, r)) = self.correlations.as_ref().and_then(|r| Some((matrix(self.parameters, r)?, r))) else {
            return String::new();
        };
        let mut out = format!("<section>\n<h2>What goes together</h2>\n<div class=\"pair\">\n{matrix}\n<div class=\"note\">\n");
        out += "<p>Correlations of the errors. At 1 two values can rise together, at −1 one can rise as the other falls, and the picture hardly tells.</p>\n";
        let strong: Vec<(usize, usize)> =
            (0..r.size()).flat_map(|i| (0..i).map(move |j| (i, j))).filter(|&(i, j)| r.at(i, j).abs() > STRONG).collect();
        for (i, j) in strong {
            let [a, b] = [i, j].map(|k| escape(&self.parameters[k].name));
            out += &format!("<p><b>{b}</b> and <b>{a}</b> are hardly told apart ({})", fixed(r.at(i, j), 3));
            if let Some(errors) = self.errors.as_ref() {
                let two = if errors[i] > errors[j] { [j, i] } else { [i, j] };
                let [variances, values] = [&errors[..], self.values].map(|of| two.map(|k| of[k]));
                let covariance = r.at(i, j) * errors[i] * errors[j];
                let names = two.map(|k| self.parameters[k].name.as_str());
                out += &format!(": {}", escape(&combination(names, values, variances.map(|error| error * error), covariance)));
            }
            out += ".</p>\n";
        }
        out + "</div>\n</div>\n</section>\n"
    }

    /// All digits, the file, the command.
    fn digits(&self) -> String {
        let mut out = String::from("<section class=\"digits\">\n<h2>All digits</h2>\n<table>\n<thead><tr><th>parameter</th>");
        for title in ["value", "standard error", "of it rendering", "start", "low", "high"] {
            out += &format!("<th class=\"number\">{title}</th>");
        }
        out += "</tr></thead>\n<tbody>\n";
        for (i, p) in self.parameters.iter().enumerate() {
            let all = |values: &Option<Vec<f64>>| values.as_ref().map_or_else(|| "–".into(), |v| Number(v[i]).to_string());
            out += &format!("<tr><th>{}</th>", escape(&p.name));
            let numbers = [p.start, p.low, p.high].map(|v| Number(v).to_string());
            for text in [Number(self.values[i]).to_string(), all(&self.errors), all(&self.own)].iter().chain(&numbers) {
                out += &format!("<td class=\"number\">{text}</td>");
            }
            out += "</tr>\n";
        }
        let (measure, value) = (symbol(self.measure.0), six(self.measure.1));
        out += &format!("<tr><th>{measure}</th><td class=\"number\">{value}</td>{}</tr>\n</tbody>\n</table>\n", "<td></td>".repeat(5));
        out += &format!(
            "<h2>The file</h2>\n<pre>{}</pre>\n<h2>The command</h2>\n<pre>{}</pre>\n</section>\n",
            escape(self.file),
            escape(self.command)
        );
        out + &format!(
            "<footer>Inverad {VERSION}. {CHI2} is the sum over pixels and channels of the squared differences of radiance (Sun and Wu 2002, equation 11).</footer>\n"
        )
    }
}

/// The version of the programs.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// χ² as the page writes it.
const CHI2: &str = "<i>χ</i>²";

/// A measure as the page writes it.
fn symbol(measure: Loss) -> &'static str {
    if measure == Loss::Chi2 { CHI2 } else { measure.name() }
}

/// Target, rendering, difference.
fn comparison(views: &Views) -> Result<String> {
    let Views { target, rendering, counts, .. } = views;
    let counts: Vec<f32> = counts.iter().map(|&c| if c > 0.0 { 1.0 } else { 0.0 }).collect();
    let weights = counts.contains(&1.0).then_some(&counts[..]);
    let named = |picture| Named { name: "picture", picture };
    let comparison = Comparison::new(named(target), named(rendering), None, weights)?;
    let (heat, range) = (comparison.heatmap(), comparison.heat_range());
    let tone = Tone::of(target);
    let (width, height) = (target.width, target.height);
    let shown = |picture: &Picture| picture.pixels.iter().map(|&p| tone.map(p)).collect::<Vec<_>>();
    let mut out = String::from("<section>\n<h2>Against the photograph</h2>\n<div class=\"pictures three\">\n");
    out += &figure(width, height, &shown(target), "The photograph")?;
    out += &figure(width, height, &shown(rendering), "Rendered with what was found")?;
    out += &figure(width, height, &heat, "Their difference")?;
    let scale: Vec<[u8; 3]> = (0..129).map(|i| crate::metric::heat::heat(i as f64 / 64.0 - 1.0)).collect();
    out += &format!(
        "</div>\n<div class=\"scale\"><span>photograph brighter by {0} W/(sr·m²)</span><img src=\"{1}\" alt=\"\"/><span>rendering brighter by {0}</span></div>\n</section>\n",
        brief(range),
        data_uri(129, 1, &scale)?
    );
    Ok(out)
}

/// A picture with a caption.
fn figure(width: usize, height: usize, pixels: &[[u8; 3]], caption: &str) -> Result<String> {
    let uri = data_uri(width, height, pixels)?;
    Ok(format!(
        "<figure><img src=\"{uri}\" width=\"{width}\" height=\"{height}\" alt=\"{caption}\"/><figcaption>{caption}</figcaption></figure>\n"
    ))
}

/// A count with thin spaces between thousands.
fn thousands(n: usize) -> String {
    let digits = n.to_string();
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().map(|g| std::str::from_utf8(g).unwrap_or_default()).collect();
    groups.join("\u{202f}")
}
