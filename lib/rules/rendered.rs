//! How a picture was rendered, by its header, and what that means for whoever recovers a material from it.

use super::{FRESNEL_OFFSET, Rules, UNWEIGHTED};
use crate::picture::command_words;
use std::str::FromStr;

/// A command in a picture's header: the program's name without its directory, and its options.
pub struct Command<'a>(Vec<&'a str>);

impl<'a> Command<'a> {
    /// What a line of a header says.
    pub fn of(line: &'a str) -> Self {
        Self(command_words(line))
    }

    /// The last of these programs in the lines of a header; `None` if it is none of them that made the picture.
    fn last(lines: impl IntoIterator<Item = &'a str>, programs: &[&str]) -> Option<Self> {
        lines.into_iter().map(Self::of).filter(|command| programs.contains(&command.program())).last()
    }

    /// The program; empty in an empty line.
    pub fn program(&self) -> &str {
        self.0.first().copied().unwrap_or_default()
    }

    /// The word after an option, or after its `=`, if it is given.
    pub fn word(&self, name: &str) -> Option<&str> {
        match self.0.iter().rposition(|word| *word == name) {
            Some(at) => self.0.get(at + 1).copied(),
            None => self.0.iter().rev().find_map(|word| word.strip_prefix(name)?.strip_prefix('=')),
        }
    }

    /// By how many times `-x /N` makes a picture smaller, if it says so.
    pub fn times<N: FromStr>(&self) -> Option<N> {
        self.word("-x")?.strip_prefix('/')?.parse().ok()
    }

    /// The number that an option has, if it is given.
    pub fn given(&self, name: &str) -> Option<f64> {
        self.word(name)?.parse().ok()
    }

    /// The number that an option has, and the words for it.
    fn option(&self, name: &str, default: f64) -> (f64, String) {
        let given = self.given(name);
        (given.unwrap_or(default), format!("{name} {}", given.map_or(format!("{default}, its default"), |value| value.to_string())))
    }
}

/// What of rough reflection the last of RADIANCE's renderers in a picture's header changed, where a specularity may be as small as `least`: a sentence
/// each. How much too bright: a metal ball in light from everywhere by `rpict -st 0 -ab 1`, with `-ss 1` and with `-ss 8`.
pub fn shortcuts<'a>(lines: impl IntoIterator<Item = &'a str>, least: f64) -> Vec<String> {
    let Some(command) = Command::last(lines, &["rpict", "rtrace"]) else { return vec![] };
    let ((threshold, st), (sampling, ss)) = (command.option("-st", 0.15), command.option("-ss", 1.0));
    let mut found = Vec::new();
    let mut say = |option: String, harm: &str, remedy: &str| {
        found.push(format!("the target was rendered by {} with {option}: {harm}; render it with {remedy}", command.program()));
    };
    if threshold > least {
        say(st, "a specularity up to that mirrors nothing but lamps there, and comes out too small", "-st 0");
    }
    if sampling == 0.0 {
        say(ss, "rough surfaces reflect like mirrors there", "-ss 2");
    } else if sampling <= UNWEIGHTED {
        say(ss, "rough surfaces reflect too much there, 3 % at a roughness of .1 and 8 % at .2", "-ss 2");
    }
    found
}

/// What is to be said if light bounces more often, or less often, by these rules than where a picture with this header was made.
pub fn bounces<'a>(lines: impl IntoIterator<Item = &'a str>, rules: &Rules) -> Option<String> {
    let all = Rules::default().ambient_bounces;
    let here = rules.ambient_bounces;
    let command = Command::last(lines, &["rpict", "rtrace", "rtrace-rs"])?;
    let (program, given) = (command.program(), command.given("-ab"));
    let there = match given {
        Some(bounces) => bounces.max(0.0) as u32,
        None if program == "rtrace-rs" => all,
        None => 0,
    };
    let remedy = if there == all { "leave -ab out".into() } else { format!("give -ab {there}") };
    let said = if given.is_some() { format!("-ab {there}") } else { "no -ab".into() };
    (here != there).then(|| format!("the target was rendered by {program} with {said}, and here light bounces otherwise: {remedy}"))
}

/// How large a lamp may be, in terms of its distance, to be much like a point; and behind trans, whose lobe it widens more. (Roughnesses of .15 and .05
/// before spheres .06 times as large as they are far came out as .155 and .059.)
const LARGE: [f64; 2] = [0.25, 0.05];

/// What is to be said if lamps are not taken for points by these rules, as they were where RADIANCE made a picture with this header. `large` says
/// how large those are, in terms of their distance, that it divides where it is asked to, and those that it does not divide well.
pub fn lamps<'a>(
    lines: impl IntoIterator<Item = &'a str>,
    rules: &Rules,
    behind_trans: bool,
    large: impl FnOnce() -> [f64; 2],
) -> Option<String> {
    let command = Command::last(lines, &["rpict", "rtrace"]).filter(|_| rules.light_jitter.is_none())?;
    let [flat, round] = large();
    let division = if command.program() == "rpict" { 0.25 } else { 0.2 };
    let [dj, ds] = [("-dj", 0.0), ("-ds", division)].map(|(name, default)| command.given(name).unwrap_or(default));
    let large = if ds > 0.0 { round.max(flat.min(ds)) } else { round.max(flat) };
    (large > LARGE[behind_trans as usize]).then(|| {
        format!(
            "the target was rendered by {}, which takes lamps for points, and one is {large:.2} times as large as it is far from what is unknown; \
             here they are integrated over all their extent: give -dj {dj} -ds {ds} for its picture of them",
            command.program()
        )
    })
}

/// The releases of RADIANCE, from the first to before the second, whose Fresnel term is larger than that of its sources of today, and what makes it so.
const LARGER: [[u32; 2]; 2] = [[5, 4], [6, 1]];
const LARGER_OFFSET: f64 = 0.00202943064;

/// What is to be said of something polished in a picture with this header that such a release made, if these rules are those of today.
pub fn fresnel<'a>(lines: impl IntoIterator<Item = &'a str>, rules: &Rules) -> Option<String> {
    let release = lines.into_iter().filter_map(|line| line.strip_prefix("SOFTWARE= RADIANCE ")).last()?.split(' ').next()?;
    let mut numbers = release.split(|c: char| !c.is_ascii_digit()).map_while(|n| n.parse().ok());
    let release_of: [u32; 2] = [numbers.next()?, numbers.next()?];
    (LARGER[0] <= release_of && release_of < LARGER[1] && rules.fresnel_offset == FRESNEL_OFFSET).then(|| {
        format!(
            "the target was rendered by RADIANCE {release}, by which polished surfaces mirror {:.5} more than by its sources of today: \
             give --fresnel-offset {LARGER_OFFSET}",
            FRESNEL_OFFSET - LARGER_OFFSET
        )
    })
}

/// The width, height and aspect of pixels that the last rpict in the lines of a header was asked for, and by how many times `pfilt -x /N` made the
/// picture smaller since; `None` if it did not.
pub fn reduced<'a>(lines: impl IntoIterator<Item = &'a str>) -> Option<([f64; 3], usize)> {
    let mut reduced = None;
    for command in lines.into_iter().map(Command::of) {
        match command.program() {
            "rpict" => {
                reduced =
                    Some(([("-x", 512.0), ("-y", 512.0), ("-pa", 1.0)].map(|(name, default)| command.given(name).unwrap_or(default)), 1))
            }
            "pfilt" => {
                reduced = reduced.map(|(size, before)| (size, usize::saturating_mul(before, command.times().unwrap_or(1))));
            }
            _ => {}
        }
    }
    reduced.filter(|(_, times)| *times > 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shortcuts_of_renderings_are_read_off_their_headers() {
        let said = |lines: &[&str], least| shortcuts(lines.iter().copied(), least);
        assert!(said(&["rpict -st 0 -ss 8 -vf a.vf a.oct", "pfilt -x /2"], 0.0).is_empty());
        assert!(said(&["rtrace-rs -ab 2", "SOFTWARE= RADIANCE rtrace, -st .15"], 0.0).is_empty());
        let defaults = said(&["/usr/bin/rpict -vf a.vf a.oct", "\tpfilt -x /2"], 0.0);
        assert!(defaults[0].starts_with("the target was rendered by rpict with -st 0.15, its default: "), "{defaults:?}");
        assert!(defaults[1].starts_with("the target was rendered by rpict with -ss 1, its default: "), "{defaults:?}");
        let [only] = &said(&["rtrace -st .3 -ss 0 -st .1 a.oct"], 0.2)[..] else { panic!() };
        assert_eq!(only, "the target was rendered by rtrace with -ss 0: rough surfaces reflect like mirrors there; render it with -ss 2");
    }

    #[test]
    fn how_much_smaller_a_rendering_was_made_is_read_off_its_header() {
        let lines = ["oconv a.rad", "rpict -x 400 -y 320 a.oct", "VIEW= -vtv", "", "pfilt -1 -x /2 -y /2", "\tpfilt -x /2 -y /2"];
        assert_eq!(reduced(lines), Some(([400.0, 320.0, 1.0], 4)));
        assert_eq!(reduced(lines[..3].iter().copied()), None);
        assert_eq!(reduced(["pfilt -x /2"]), None);
    }

    #[test]
    fn lamps_that_are_no_points_are_told() {
        let said = |line: &str, jitter: Option<f64>, large: [f64; 2]| {
            lamps([line], &Rules { light_jitter: jitter, ..Rules::default() }, false, || large).unwrap_or_default()
        };
        for (line, large, remedy) in
            [("rpict -dj .9 a.oct", [0.1, 0.5], "-dj 0.9 -ds 0.25"), ("rtrace -ds 0 a.oct", [0.5, 0.1], "-dj 0 -ds 0")]
        {
            assert!(said(line, None, large).ends_with(&format!("give {remedy} for its picture of them")));
            assert_eq!(said(line, Some(0.0), large), "");
        }
        for (line, large) in [("rpict a.oct", [0.1, 0.1]), ("rpict a.oct", [0.5, 0.1]), ("rtrace-rs a.rad", [0.5, 0.5])] {
            assert_eq!(said(line, None, large), "");
        }
        let behind = |large: f64| lamps(["rpict a.oct"], &Rules::default(), true, || [0.0, large]);
        assert!(behind(0.04).is_none() && behind(0.06).is_some_and(|said| said.contains("0.06 times as large")));
    }

    #[test]
    fn releases_of_another_fresnel_term_are_told() {
        let said = |line: &str, fresnel_offset| fresnel(["rpict a.oct", line], &Rules { fresnel_offset, ..Rules::default() });
        for release in ["5.4a lastmod", "6.0a", "6.0.2 official"] {
            let line = format!("SOFTWARE= RADIANCE {release}");
            assert!(said(&line, FRESNEL_OFFSET).is_some_and(|said| said.contains("mirror 0.00085 more")), "{release}");
            assert_eq!(said(&line, LARGER_OFFSET), None);
        }
        for line in ["SOFTWARE= RADIANCE 5.3", "SOFTWARE= RADIANCE 6.1a", "SOFTWARE= RADIANCE rtrace, box filter", "VIEW= -vtv"] {
            assert_eq!(said(line, FRESNEL_OFFSET), None, "{line}");
        }
    }

    #[test]
    fn light_that_bounces_otherwise_is_told() {
        let said = |lines: &[&str], ab: Option<u32>| {
            let rules = Rules { ambient_bounces: ab.unwrap_or(Rules::default().ambient_bounces), ..Rules::default() };
            bounces(lines.iter().copied(), &rules).unwrap_or_default()
        };
        for (lines, ab) in
            [(vec!["rpict -ab 2 a.oct", "\tpfilt -x /2"], Some(2)), (vec!["rtrace-rs a.rad"], None), (vec!["hdrgen a.jpg"], None)]
        {
            assert_eq!(said(&lines, ab), "");
        }
        assert!(said(&["rpict -ab 2 a.oct"], None).ends_with("by rpict with -ab 2, and here light bounces otherwise: give -ab 2"));
        assert!(said(&["rpict a.oct"], Some(2)).ends_with("by rpict with no -ab, and here light bounces otherwise: give -ab 0"));
        assert!(said(&["rtrace-rs a.rad"], Some(2)).ends_with("by rtrace-rs with no -ab, and here light bounces otherwise: leave -ab out"));
    }
}
