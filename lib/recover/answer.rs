//! The answer: the file with the values that were found, after what is to be said of them.

use super::doubts::{Judgement, Known, Standing, at_bound, judge, lusterless, may_exceed};
use super::words::{decimals, digits, list};
use crate::anneal::Parameter;
use crate::anneal::linear::Symmetric;
use crate::error::Result;
use crate::rad::Number;
use crate::unknown::{ROUGHNESSES, Unknown};

/// Values of an unknown, and what there is to say of them.
pub struct Answer<'a> {
    unknown: &'a Unknown,
    values: Vec<f64>,
    judgement: Option<Judgement>,
    doubts: Vec<String>,
}

/// Correlations from this on are told.
const TOLD: f64 = 0.5;
/// Digits that a file keeps of a value beyond those that its error leaves it: nothing is lost by rounding.
const KEPT: usize = 2;

impl<'a> Answer<'a> {
    /// What there is to say of some values, by what is known of their errors, if anything is.
    pub fn new(unknown: &'a Unknown, values: &[f64], known: Option<&Known>) -> Self {
        let judgement = known.map(|known| judge(unknown, values, known));
        let mut doubts = judgement.as_ref().map_or_else(Vec::new, |j| j.doubts.clone());
        let explained = known.is_none_or(|known| known.misfit.is_noise());
        let dull = known.is_some_and(|known| lusterless(unknown, values, &known.covariance));
        let mut rounded = values.to_vec();
        for (i, (p, value)) in unknown.parameters().iter().zip(&mut rounded).enumerate() {
            if let Some((side, bound)) = at_bound(p, *value, judgement.as_ref().map(|j| j.errors[i])) {
                *value = bound;
                let open = judgement.as_ref().is_some_and(|j| j.standings[i] == Standing::Open);
                // What may be anything is at a bound by chance, unless it surely would go on.
                let any = open && explained || dull && ROUGHNESSES.contains(&&p.name[..]);
                if may_exceed(unknown, p, bound) && (!any || known.is_some_and(|known| known.presses(i))) {
                    let beyond = "if it may lie beyond, give --param";
                    doubts.push(format!("{} is at its {side} bound {}; {beyond} {0}=START:LOW:HIGH", p.name, Number(bound)));
                }
            } else if let Some(judgement) = judgement.as_ref().filter(|j| j.errors[i] > 0.0) {
                *value = format!("{value:.0$}", decimals(judgement.errors[i]) + KEPT).parse().unwrap_or(*value).clamp(p.low, p.high);
            }
        }
        Self { unknown, values: rounded, judgement, doubts }
    }

    /// The same with one more doubt, if there is one.
    pub fn and(mut self, doubt: Option<String>) -> Self {
        self.doubts.extend(doubt);
        self
    }

    /// The values, without the digits that mean nothing.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Their standard errors, if they are known.
    pub fn errors(&self) -> Option<&[f64]> {
        self.judgement.as_ref().map(|j| &j.errors[..])
    }

    /// The correlation of each pair of errors, if they are known.
    pub fn correlations(&self) -> Option<&Symmetric> {
        self.judgement.as_ref().map(|j| &j.correlations)
    }

    /// What there is to doubt.
    pub fn doubts(&self) -> &[String] {
        &self.doubts
    }

    /// What is to be said, line by line: each value with its standard error, the pairs whose errors go together, what there is to doubt.
    pub fn lines(&self) -> Vec<String> {
        let parameters = self.unknown.parameters();
        let mut lines = Vec::new();
        for (i, (p, &value)) in parameters.iter().zip(&self.values).enumerate() {
            lines.push(match &self.judgement {
                Some(j) if j.errors[i].is_finite() => {
                    let (value, error) = digits(value, j.errors[i]);
                    let standing = match j.standings[i] {
                        Standing::Determined => "",
                        Standing::Together => ": not determined by itself",
                        Standing::Open => ": not determined",
                    };
                    format!("{} {value} ± {error}{standing}", p.name)
                }
                _ => format!("{} {}", p.name, Number(value)),
            });
        }
        if let Some(j) = &self.judgement {
            let pairs = (0..parameters.len()).flat_map(|i| (0..i).map(move |k| (k, i)));
            let mut pairs: Vec<(f64, usize, usize)> = pairs.map(|(a, b)| (j.correlations.at(a, b), a, b)).collect();
            pairs.retain(|(r, ..)| r.abs() >= TOLD);
            pairs.sort_by(|x, y| y.0.abs().total_cmp(&x.0.abs()));
            let told = pairs.iter().map(|(r, a, b)| format!("{} {} {r:.2}", parameters[*a].name, parameters[*b].name));
            if !pairs.is_empty() {
                lines.push(format!("correlations: {}", told.collect::<Vec<_>>().join(", ")));
            }
        }
        lines.extend(self.doubts.iter().map(|doubt| warning(doubt)));
        lines
    }

    /// The file with these values, preceded by comment lines: the title's, its own, and one that says where they end.
    pub fn file(&self, title: &[String]) -> Result<Vec<u8>> {
        let lines = self.lines();
        let said = title.iter().chain(&lines).map(|line| format!("# {line}\n"));
        let mut bytes = said.chain([format!("{END}\n")]).collect::<String>().into_bytes();
        let file = self.unknown.document(&self.values)?.bytes();
        bytes.extend_from_slice(&file[said_before(&file)..]);
        Ok(bytes)
    }
}

/// The line for a doubt.
pub fn warning(doubt: &str) -> String {
    format!("warning: {doubt}")
}

/// The line after those that an answer says: what follows is the file's own.
const END: &str = "# end of what anneal says";

/// How many bytes at the beginning of a file are comments that an answer said before.
fn said_before(file: &[u8]) -> usize {
    let lines = file.split_inclusive(|&b| b == b'\n').take_while(|line| line.starts_with(b"#"));
    let ends = lines.scan(0, |end, line| {
        *end += line.len();
        Some((*end, line.trim_ascii_end() == END.as_bytes()))
    });
    ends.filter(|(_, last)| *last).map(|(end, _)| end).last().unwrap_or(0)
}

/// Which standard errors are above a tolerance, if any are.
pub fn missed(parameters: &[Parameter], errors: &[f64], tolerance: f64) -> Option<String> {
    let large = parameters.iter().zip(errors).filter(|(_, error)| !(**error <= tolerance));
    let names: Vec<&str> = large.map(|(parameter, _)| parameter.name.as_str()).collect();
    (!names.is_empty()).then(|| format!("--tolerance {} is not reached by {}", Number(tolerance), list(&names)))
}

/// A number with six digits: all that mean anything in a χ².
pub fn six(x: f64) -> Number {
    Number::rounded(x, 6)
}
