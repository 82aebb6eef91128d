//! Data files: numbers on a grid of up to five dimensions, interpolated.

use crate::error::{Result, Source, Span};

/// A grid of numbers.
#[derive(Debug)]
pub struct Table {
    axes: Vec<Axis>,
    /// The last axis varies fastest.
    values: Vec<f64>,
}

/// The most dimensions of a data file.
pub(super) const MAX_DIMENSIONS: usize = 5;

/// The most values of a data file.
const MAX_VALUES: usize = 1 << 28;

/// Where the samples along one dimension lie.
#[derive(Debug)]
enum Axis {
    /// So many at equal distances from the first position to the second.
    Even(f64, f64, usize),
    /// At these positions, ascending or descending.
    At(Vec<f64>),
}

impl Table {
    /// Reads a data file: the number of dimensions; for each its begin, end and count, or, if begin and end are equal, the count and
    /// that many positions; then the values. `#` begins a comment. What follows is ignored.
    ///
    /// # Errors
    /// A word is missing or no number, or there are more dimensions or values than are allowed.
    pub fn read(bytes: &[u8], name: &str) -> Result<Self> {
        let source = Source::new(name, String::from_utf8_lossy(bytes));
        let mut words = Words { source: &source, at: 0 };
        let dimensions = words.count("the number of dimensions")?;
        if !(1..=MAX_DIMENSIONS).contains(&dimensions) {
            return Err(words.before(format!("{dimensions} dimensions; a data file has 1 to {MAX_DIMENSIONS}")));
        }
        let (mut axes, mut size) = (Vec::new(), 1usize);
        for _ in 0..dimensions {
            let (begin, end) = (words.number("where a dimension begins")?, words.number("where a dimension ends")?);
            let count = words.count("the number of positions")?;
            if count < 2 {
                return Err(words.before("a dimension needs at least 2 positions"));
            }
            size = size.checked_mul(count).filter(|size| *size <= MAX_VALUES).ok_or_else(|| words.before("too many values"))?;
            axes.push(if begin == end {
                let positions: Vec<f64> = (0..count).map(|_| words.number("a position")).collect::<Result<_>>()?;
                if !positions.is_sorted_by(|a, b| a < b) && !positions.is_sorted_by(|a, b| a > b) {
                    return Err(words.before("the positions along a dimension must all ascend or all descend"));
                }
                Axis::At(positions)
            } else {
                Axis::Even(begin, end, count)
            });
        }
        let values = (0..size).map(|_| words.number("a value")).collect::<Result<_>>()?;
        Ok(Self { axes, values })
    }

    /// How many coordinates a place has.
    pub fn dimensions(&self) -> usize {
        self.axes.len()
    }

    /// The value at a place; further coordinates are ignored. Beyond the grid it is extrapolated linearly for one step, then fades.
    pub fn value(&self, place: &[f64]) -> f64 {
        self.below(&self.axes, place, &self.values)
    }

    fn below(&self, axes: &[Axis], place: &[f64], values: &[f64]) -> f64 {
        let [axis, rest @ ..] = axes else { return values[0] };
        let stride = values.len() / axis.count();
        let (i, [c0, c1]) = axis.cell(place[0]);
        let (near, far) = values[i * stride..(i + 2) * stride].split_at(stride);
        c0 * self.below(rest, &place[1..], near) + c1 * self.below(rest, &place[1..], far)
    }
}

/// Between which samples of `count` at 0, 1, 2, … the position `x` lies, and their weights: linear, also for one step beyond the ends,
/// then fading to nothing (measured on rtrace; beyond the last sample the weights jump there).
#[inline]
pub(super) fn cell(x: f64, count: usize) -> (usize, [f64; 2]) {
    let i = (x as usize).min(count.saturating_sub(2));
    let offset = x - i as f64;
    if (-1.0..=2.0).contains(&offset) {
        (i, [1.0 - offset, offset])
    } else if offset > 0.0 {
        let c = 1.0 / (-1.0 - offset);
        (i, [c, -2.0 * c])
    } else {
        let c = 1.0 / offset;
        (i, [-2.0 * c, c])
    }
}

impl Axis {
    fn count(&self) -> usize {
        match self {
            Self::Even(_, _, count) => *count,
            Self::At(positions) => positions.len(),
        }
    }

    fn cell(&self, x: f64) -> (usize, [f64; 2]) {
        match self {
            Self::Even(begin, end, count) => cell((x - begin) / (end - begin) * (count - 1) as f64, *count),
            Self::At(positions) => {
                let ascending = positions[1] > positions[0];
                let before = positions.partition_point(|&p| if ascending { p <= x } else { p >= x });
                let i = before.saturating_sub(1).min(positions.len() - 2);
                cell(i as f64 + (x - positions[i]) / (positions[i + 1] - positions[i]), positions.len())
            }
        }
    }
}

/// The words of a data file.
struct Words<'a> {
    source: &'a std::sync::Arc<Source>,
    at: usize,
}

impl Words<'_> {
    fn next(&mut self, what: &str) -> Result<(&str, Span)> {
        let text = &self.source.text;
        loop {
            let rest = text[self.at..].trim_start();
            self.at = text.len() - rest.len();
            match rest.strip_prefix('#') {
                Some(comment) => self.at = text.len() - comment.find('\n').map_or(0, |end| comment.len() - end),
                None if rest.is_empty() => return Err(self.before(format!("the file ends where {what} is expected"))),
                None => break,
            }
        }
        let length = text[self.at..].find(char::is_whitespace).unwrap_or(text.len() - self.at);
        let span = Span::new(self.source, self.at, self.at + length);
        self.at += length;
        Ok((&text[span.start..span.end], span))
    }

    fn number(&mut self, what: &str) -> Result<f64> {
        let (word, span) = self.next(what)?;
        let known = word.bytes().all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
        match word.parse::<f64>() {
            Ok(value) if known && value.is_finite() => Ok(value),
            _ => Err(span.error(format!("{what} is expected, found `{word}`"))),
        }
    }

    fn count(&mut self, what: &str) -> Result<usize> {
        let (word, span) = self.next(what)?;
        word.parse().map_err(|_| span.error(format!("{what} is expected, found `{word}`")))
    }

    /// An error at the last word that was read.
    fn before(&self, message: impl Into<String>) -> crate::error::Error {
        let read = self.source.text[..self.at].trim_end();
        let word = read.rsplit(char::is_whitespace).next().unwrap_or(read);
        Span::new(self.source, read.len() - word.len(), read.len()).error(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(file: &str, expected: &[(&[f64], f64)]) {
        let table = Table::read(file.as_bytes(), "t.dat").unwrap();
        for (place, expected) in expected {
            let found = table.value(place);
            assert!((found - expected).abs() <= 1e-6 * expected.abs().max(1.0), "{place:?}: {found}, not {expected}");
        }
    }

    // A brightdata of noop and this file at the place, on a glow that `rtrace -h -faa` sees (Radiance 6.0a); negative radiance
    // shows as it is.

    #[test]
    fn even_positions() {
        let file = "# a comment\n1\n0 4 3\n10 20 # inline\n40\n";
        let beyond: [(&[f64], f64); 4] = [(&[6.5], 18.46154), (&[7.0], 17.14286), (&[20.0], 6.0), (&[-2.5], 0.0)];
        check(file, &[(&[0.0], 10.0), (&[1.0], 15.0), (&[3.5], 35.0), (&[5.0], 50.0), (&[-1.0], 5.0), (&[-9.0], 0.0)]);
        check(file, &beyond);
    }

    #[test]
    fn descending_positions() {
        let expected: [(&[f64], f64); 8] = [
            (&[0.0], 40.0),
            (&[3.5], 11.66667),
            (&[5.0], 6.666667),
            (&[6.5], 1.666667),
            (&[20.0], 0.0),
            (&[-1.0], 60.0),
            (&[-2.5], 13.33333),
            (&[-9.0], 5.454545),
        ];
        check("1\n0 0 3\n4 1 0\n10 20 40\n", &expected);
        check("1 4 0 3 10 20 40", &[(&[3.5], 12.5), (&[-2.5], 18.46154), (&[7.0], 0.0)]);
    }

    #[test]
    fn two_dimensions() {
        let expected: [(&[f64], f64); 8] = [
            (&[0.5, 1.5], 3.5),
            (&[1.2, 3.0], 7.5),
            (&[1.9, 7.5], 15.725),
            (&[-0.5, 3.0], 0.5),
            (&[2.7, 12.0], 28.0),
            (&[-3.0, 30.0], -0.04444445),
            (&[3.9, -8.0], 0.5698006),
            (&[1.0, 0.5], 4.5),
        ];
        check("2\n0 2 3\n0 0 4\n1 2 4 8\n1 2 3 4\n5 6 7 9\n11 10 13 17\n", &expected);
    }

    #[test]
    fn errors_name_the_place() {
        for (file, expected) in [
            ("1\n0 4 3\n10 20\n", "t.dat:3:4: error: the file ends where a value is expected"),
            ("1\n0 4 3\n10 x 20\n", "t.dat:3:4: error: a value is expected, found `x`"),
            ("6\n", "t.dat:1:1: error: 6 dimensions"),
            ("1 0 4 1 5", "at least 2 positions"),
            ("1 0 4 99999999999999999999 5", "the number of positions is expected"),
            ("1 0 4 999999999999 5", "too many values"),
            ("1 0 0 3 1 2 2 5 6 7", "all ascend"),
            ("1 0 nan 3 1 2 2", "where a dimension ends is expected, found `nan`"),
            ("", "the file ends where the number of dimensions is expected"),
        ] {
            let error = Table::read(file.as_bytes(), "t.dat").unwrap_err().to_string();
            assert!(error.contains(expected), "{file}: {error}");
        }
    }

    proptest::proptest! {
        #[test]
        fn no_file_panics(text in "([0-9] |-?[0-9.e]{1,4}[ \n#]){0,30}", x in -1e300..1e300f64) {
            if let Ok(table) = Table::read(text.as_bytes(), "t.dat") {
                table.value(&[x; MAX_DIMENSIONS]);
            }
        }
    }
}
