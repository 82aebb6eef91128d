//! Which Fresnel term a release of RADIANCE has.

use std::ops::Range;

/// RADIANCE's Fresnel term was larger than today's from March 2023 to June 2026, by the history of its `normal.c`, and what made it so.
const LARGER: Range<[u32; 2]> = [2023, 3]..[2026, 6];
const LARGER_OFFSET: f64 = 0.00202943064;

/// What became the releases 5.4 and 6.1 was called so before and after such a change: a date in the header tells them apart.
const SNAPSHOTS: [&str; 2] = ["5.4a", "6.1a"];

/// What the Fresnel term is lowered by in the release that a line of a header names, if that is another than today's.
pub fn offset_of_release(line: &str) -> Option<f64> {
    let mut words = line.strip_prefix("SOFTWARE= RADIANCE ")?.split_ascii_whitespace();
    let release = words.next()?;
    let larger = if SNAPSHOTS.contains(&release) {
        month(words).is_some_and(|month| LARGER.contains(&month))
    } else {
        release == "5.4" || release.starts_with("6.0")
    };
    larger.then_some(LARGER_OFFSET)
}

/// The year and the month of a date: `2024-12-07`, or `Sat Dec  7 18:22:07 PST 2024`.
fn month<'a>(words: impl Iterator<Item = &'a str>) -> Option<[u32; 2]> {
    const MONTHS: [&str; 12] = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
    let mut month = None;
    for word in words {
        if let [year, month, _] = word.split('-').filter_map(|n| n.parse().ok()).collect::<Vec<_>>()[..] {
            return Some([year, month]);
        }
        month = (1..).zip(MONTHS).find(|(_, name)| *name == word).map(|(n, _)| n).or(month);
        if let (Some(month), 4, Ok(year)) = (month, word.len(), word.parse()) {
            return Some([year, month]);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fresnel_term_is_that_of_the_release() {
        let offset = |release: &str| offset_of_release(&format!("SOFTWARE= RADIANCE {release}"));
        let larger = [
            "5.4 official release",
            "6.0a",
            "6.0.2 official",
            "5.4a lastmod Tue Mar  7 09:47:10 PST 2023 by x on y",
            "6.1a 2026-05-31 LBNL (a1b2c3)",
        ];
        for release in larger {
            assert_eq!(offset(release), Some(LARGER_OFFSET), "{release}");
        }
        let usual = [
            "5.3",
            "5.4a lastmod Mon Apr 25 09:47:10 PDT 2022 by x on y",
            "5.4a",
            "6.1a 2026-08-19 LBNL (a1b2c3)",
            "6.1",
            "rtrace, box filter",
        ];
        for release in usual {
            assert_eq!(offset(release), None, "{release}");
        }
        assert_eq!(offset_of_release("VIEW= -vtv"), None);
    }
}
