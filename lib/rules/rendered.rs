//! How a picture was rendered, by its header, and what that means for whoever recovers a material from it.

use super::defaults::{SIZE, radiances};
use super::{Rules, UNWEIGHTED, Ward};
use crate::color::Rgb;
use crate::picture::command_words;
use crate::rad::Number;
use std::f64::consts::PI;
use std::ops::Range;
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
        match self.after(name) {
            Some(words) => words.first().copied(),
            None => self.0.iter().rev().find_map(|word| word.strip_prefix(name)?.strip_prefix('=')),
        }
    }

    /// What follows an option, if it is given.
    fn after(&self, name: &str) -> Option<&[&'a str]> {
        self.0.iter().rposition(|word| *word == name).map(|at| &self.0[at + 1..])
    }

    /// The colour that an option has, if it is given.
    fn color(&self, name: &str) -> Option<Rgb> {
        let number = |word: &&str| word.parse::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
        let numbers: Vec<f64> = self.after(name)?.iter().take(3).map_while(number).collect();
        <[f64; 3]>::try_from(numbers).ok().map(Rgb::from)
    }

    /// Whether an option is on that is if it is not given: by itself it turns to the other, and by what follows it on or off.
    fn on(&self, name: &str) -> bool {
        self.0.iter().filter_map(|word| word.strip_prefix(name)).fold(true, |on, rest| match rest.as_bytes() {
            [] => !on,
            [b'+' | b'1' | b'y' | b'Y' | b't' | b'T'] => true,
            [b'-' | b'0' | b'n' | b'N' | b'f' | b'F'] => false,
            _ => on,
        })
    }

    /// By how many times `-x /N` makes a picture smaller, if it says so.
    pub fn times<N: FromStr>(&self) -> Option<N> {
        self.word("-x")?.strip_prefix('/')?.parse().ok()
    }

    /// The number that an option has, if it is given.
    pub fn given(&self, name: &str) -> Option<f64> {
        self.word(name)?.parse().ok()
    }

    /// What one of RADIANCE's programs takes for an option that is not given.
    fn default(&self, name: &str) -> f64 {
        radiances(name)[(self.program() == "rpict") as usize]
    }

    /// The number that an option has, and the words for it.
    fn option(&self, name: &str) -> (f64, String) {
        let (given, default) = (self.given(name), self.default(name));
        (given.unwrap_or(default), format!("{name} {}", given.map_or(format!("{default}, its default"), |value| value.to_string())))
    }
}

/// The programs that render pictures.
const PROGRAMS: [&str; 3] = ["rpict", "rtrace", "rtrace-rs"];

/// What the last of RADIANCE's renderers in a picture's header changed of the light of a scene with so many lamps: a sentence each. Of rough reflection
/// only if something rough is sought, whose specularity may be as small as `least`. By how much, `rpict` told: of a metal ball in light from everywhere,
/// `-st 0 -ab 1` with `-ss 1` and `-ss 8`; of a floor in a room, `-ab 2 -ad 1024` with `-aa .1` and `-aa 0`; of a shade with one lamp in it and three
/// beside, `-dt .05` and `-dt 0`.
pub fn shortcuts<'a>(lines: impl IntoIterator<Item = &'a str>, least: Option<f64>, lamps: usize) -> Vec<String> {
    let Some(command) = Command::last(lines, &["rpict", "rtrace"]) else { return vec![] };
    let mut found = Vec::new();
    let mut say = |option: String, harm: &str, remedy: &str| {
        found.push(format!("the target was rendered by {} with {option}: {harm}; render it with {remedy}", command.program()));
    };
    if let Some(least) = least {
        let ((threshold, st), (sampling, ss)) = (command.option("-st"), command.option("-ss"));
        if threshold > least {
            say(st, "a specularity up to that mirrors nothing but lamps there, and comes out too small", "-st 0");
        }
        if sampling == 0.0 {
            say(ss, "rough surfaces reflect like mirrors there", "-ss 2");
        } else if sampling <= UNWEIGHTED {
            say(ss, "rough surfaces reflect too much there, 3 % at a roughness of .1 and 8 % at .2", "-ss 2");
        }
    }
    let (accuracy, aa) = command.option("-aa");
    if accuracy > 0.0 && command.given("-ab").is_some_and(|bounces| bounces > 0.0) {
        say(aa, "light that bounces is interpolated there, up to 1 % off by .1", "-aa 0");
    }
    if let Some(weight) = command.given("-aw").filter(|weight| *weight > 0.0) {
        say(format!("-aw {weight}"), "what stands for the bounces left out changes there from place to place, and does not here", "-aw 0");
    }
    let (tested, dt) = command.option("-dt");
    if tested > 0.0 && lamps > 1 {
        say(dt, "shadows of the fainter of several lamps are guessed there, which is up to .8 % of the light", "-dt 0");
    }
    found
}

/// What is to be said of a rendering in which only some surfaces gather indirect light, or that shows irradiance; of the first if it was not `typed`
/// which those are.
pub fn otherwise<'a>(lines: impl IntoIterator<Item = &'a str>, typed: bool) -> Option<String> {
    let command = Command::last(lines, &PROGRAMS)?;
    let given = |names: &[&'static str]| names.iter().copied().find(|name| command.after(name).is_some());
    let (what, harm, remedy) = if let Some(option) = given(&["-i", "-i+"]) {
        (option, "it shows irradiance, not what surfaces reflect", "render it without")
    } else {
        let option = given(&["-ae", "-aE", "-ai", "-aI"]).filter(|_| !typed)?;
        (option, "only some surfaces gather indirect light there", "give the same option here")
    };
    Some(format!("the target was rendered by {} with {what}: {harm}; {remedy}", command.program()))
}

/// Of what light is reckoned with, what was typed: the header then does not count.
#[derive(Clone, Copy, Debug, Default)]
pub struct Typed {
    /// `-ab`.
    pub bounces: bool,
    /// `-av`.
    pub ambient: bool,
    /// `-dj`.
    pub jitter: bool,
    /// `-ds`.
    pub division: bool,
    /// `-dr`.
    pub mirrors: bool,
    /// `-me`.
    pub medium: bool,
    /// `-bv`.
    pub backs: bool,
    /// `--ward`.
    pub lobe: bool,
    /// `--fresnel-offset`.
    pub fresnel: bool,
}

/// How the program that rendered a picture reckoned with light.
#[derive(Clone, Debug, PartialEq)]
pub struct Reckoning {
    program: String,
    /// How often light bounces.
    bounces: u32,
    /// The radiance that stands for what the bounces left out.
    ambient: Rgb,
    /// `-dj` and `-ds`, if lamps are taken for points.
    lamps: Option<[f64; 2]>,
    /// How many mirrors a light may be seen through.
    mirrors: u32,
    /// The extinction of what fills the scene.
    medium: Rgb,
    /// Whether backs of surfaces are there.
    backs: bool,
    /// The form of the rough reflection lobe.
    lobe: Ward,
    /// What the Fresnel term of polished surfaces is lowered by, if it is not as usual.
    fresnel_offset: Option<f64>,
}

impl Reckoning {
    /// What the header of a picture says of it; `None` if it is no rendering's.
    pub fn of<'a>(lines: impl Iterator<Item = &'a str> + Clone) -> Option<Self> {
        let command = Command::last(lines.clone(), &PROGRAMS)?;
        let default = Rules::default();
        let ours = command.program() == "rtrace-rs";
        let (jitter, division, bounces, mirrors) = if ours {
            (None, default.light_division, default.ambient_bounces, default.mirror_levels)
        } else {
            let count = |name: &str| command.default(name) as u32;
            (Some(command.default("-dj")), command.default("-ds"), count("-ab"), count("-dr"))
        };
        let count = |name: &str, other: u32| command.given(name).map_or(other, |count| count.max(0.0) as u32);
        let jitter = command.given("-dj").filter(|dj| (0.0..=1.0).contains(dj)).or(jitter);
        let division = command.given("-ds").filter(|ds| *ds >= 0.0).unwrap_or(division);
        Some(Self {
            program: command.program().into(),
            bounces: count("-ab", bounces),
            ambient: command.color("-av").unwrap_or(default.ambient_value),
            lamps: jitter.map(|jitter| [jitter, division]),
            mirrors: count("-dr", mirrors),
            medium: command.color("-me").unwrap_or(default.extinction),
            backs: command.on("-bv"),
            lobe: if ours && command.word("--ward").is_some() { Ward::Original } else { default.lobe },
            fresnel_offset: command.given("--fresnel-offset").or_else(|| lines.filter_map(offset_of_release).last()),
        })
    }

    /// These rules with what it has of them, where nothing was typed of that.
    pub fn taken_into(&self, mut rules: Rules, typed: Typed) -> Rules {
        if !typed.bounces {
            rules.ambient_bounces = self.bounces;
        }
        if !typed.ambient {
            rules.ambient_value = self.ambient;
        }
        if let Some([jitter, division]) = self.lamps {
            if !typed.jitter {
                rules.light_jitter = Some(jitter);
            }
            if !typed.division {
                rules.light_division = rules.light_jitter.map_or(division, |jitter| no_finer(division, jitter));
            }
        }
        if !typed.mirrors {
            rules.mirror_levels = self.mirrors;
        }
        if !typed.medium {
            rules.extinction = self.medium;
        }
        if !typed.backs {
            rules.back_visible = self.backs;
        }
        if !typed.lobe {
            rules.lobe = self.lobe;
        }
        if let Some(offset) = self.fresnel_offset.filter(|_| !typed.fresnel) {
            rules.fresnel_offset = offset;
        }
        rules
    }

    /// That the picture `name` is taken to be rendered so, by `rules` that have it, where nothing was typed of that; `None` where that says nothing.
    pub fn note(&self, name: &str, rules: &Rules, typed: Typed) -> Option<String> {
        let number = |option: &str, value: f64| format!("{option} {}", Number(value));
        let color = |option: &str, color: Rgb| {
            (color != Rgb::ZERO).then(|| format!("{} {} {}", number(option, color.x), Number(color.y), Number(color.z)))
        };
        let lamp = |option: &str, value: Option<f64>| self.lamps.and(value).map(|value| format!("{option} {}", Number::rounded(value, 3)));
        let said = [
            (typed.bounces, self.limit()),
            (typed.ambient, color("-av", self.ambient)),
            (typed.medium, color("-me", self.medium)),
            (typed.mirrors, Some(format!("-dr {}", self.mirrors))),
            (typed.backs, (!self.backs).then(|| "-bv-".into())),
            (typed.lobe, (self.lobe == Ward::Original).then(|| "--ward 1992".into())),
            (typed.jitter, lamp("-dj", rules.light_jitter)),
            (typed.division, lamp("-ds", Some(rules.light_division))),
        ];
        let options: Vec<String> = said.into_iter().filter_map(|(typed, option)| option.filter(|_| !typed)).collect();
        let note = || format!("{name} was rendered by {} with {}, and so it is here", self.program, options.join(" "));
        (!options.is_empty()).then(note)
    }

    /// What is to be said if light bounces more often, or less often, by these rules.
    pub fn bounces_otherwise(&self, rules: &Rules) -> Option<String> {
        let said = self.limit().unwrap_or_else(|| "all bounces".into());
        let remark = || format!("the target was rendered by {} with {said}, and here light bounces otherwise: leave -ab out", self.program);
        (rules.ambient_bounces != self.bounces).then(remark)
    }

    /// How often light bounces; `None` if that is not limited.
    fn limit(&self) -> Option<String> {
        (self.bounces != Rules::default().ambient_bounces).then(|| format!("-ab {}", self.bounces))
    }
}

/// A division of lamps, no finer than is worth its time with so much jitter: one that widens the square of a roughness by `WIDENED` at the most, as
/// parts of a lamp do by their solid angle over 4π, as far as they are not jittered. 0, which divides none, stays.
fn no_finer(division: f64, jitter: f64) -> f64 {
    let finest = (4.0 * PI * WIDENED / (1.0 - jitter.min(MOST_JITTER))).sqrt();
    if division > 0.0 { division.max(finest) } else { division }
}

const WIDENED: f64 = 1e-4;
const MOST_JITTER: f64 = 0.99;

/// RADIANCE's Fresnel term was larger than today's from March 2023 to June 2026, by the history of its `normal.c`, and what made it so.
const LARGER: Range<[u32; 2]> = [2023, 3]..[2026, 6];
const LARGER_OFFSET: f64 = 0.00202943064;

/// What became the releases 5.4 and 6.1 was called so before and after such a change: a date in the header tells them apart.
const SNAPSHOTS: [&str; 2] = ["5.4a", "6.1a"];

/// What the Fresnel term is lowered by in the release that a line of a header names, if that is another than today's.
fn offset_of_release(line: &str) -> Option<f64> {
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

/// The width, height and aspect of pixels that the last rpict in the lines of a header was asked for, and by how many times `pfilt -x /N` made the
/// picture smaller since; `None` if it did not.
pub fn reduced<'a>(lines: impl IntoIterator<Item = &'a str>) -> Option<([f64; 3], usize)> {
    let mut reduced = None;
    for command in lines.into_iter().map(Command::of) {
        match command.program() {
            "rpict" => {
                reduced = Some((
                    [("-x", SIZE as f64), ("-y", SIZE as f64), ("-pa", 1.0)].map(|(name, default)| command.given(name).unwrap_or(default)),
                    1,
                ))
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
    use crate::rules::FRESNEL_OFFSET;

    #[test]
    fn shortcuts_of_renderings_are_read_off_their_headers() {
        let said = |lines: &[&str], least, lamps| shortcuts(lines.iter().copied(), Some(least), lamps);
        assert!(said(&["rpict -st 0 -ss 8 -vf a.vf a.oct", "pfilt -x /2"], 0.0, 1).is_empty());
        assert!(said(&["rpict -st 0 -ss 8 -ab 1 -aa 0 -dt 0 a.oct"], 0.0, 2).is_empty());
        assert!(said(&["rtrace-rs -ab 2", "SOFTWARE= RADIANCE rtrace, -st .15"], 0.0, 2).is_empty());
        let defaults = said(&["/usr/bin/rpict -ab 1 -vf a.vf a.oct", "\tpfilt -x /2"], 0.0, 2);
        assert_eq!(defaults.len(), 4);
        for (said, option) in defaults.iter().zip(["-st 0.15", "-ss 1", "-aa 0.2", "-dt 0.05"]) {
            assert!(said.starts_with(&format!("the target was rendered by rpict with {option}, its default: ")), "{said}");
        }
        let [only] = &said(&["rtrace -st .3 -ss 0 -st .1 a.oct"], 0.2, 1)[..] else { panic!() };
        assert_eq!(only, "the target was rendered by rtrace with -ss 0: rough surfaces reflect like mirrors there; render it with -ss 2");
        // Where nothing rough is sought, nothing is said of it.
        assert!(shortcuts(["rpict a.oct"], None, 1).is_empty());
    }

    #[test]
    fn how_much_smaller_a_rendering_was_made_is_read_off_its_header() {
        let lines = ["oconv a.rad", "rpict -x 400 -y 320 a.oct", "VIEW= -vtv", "", "pfilt -1 -x /2 -y /2", "\tpfilt -x /2 -y /2"];
        assert_eq!(reduced(lines), Some(([400.0, 320.0, 1.0], 4)));
        assert_eq!(reduced(lines[..3].iter().copied()), None);
        assert_eq!(reduced(["pfilt -x /2"]), None);
    }

    #[test]
    fn light_is_reckoned_with_as_the_header_has_it() {
        let rules = |lines: &[&str], [bounces, jitter, division]: [bool; 3]| {
            let reckoning = Reckoning::of(lines.iter().copied());
            let typed = Typed { bounces, jitter, division, ..Typed::default() };
            let rules = reckoning.map(|reckoning| reckoning.taken_into(Rules::default(), typed));
            rules.map(|rules| (rules.ambient_bounces, rules.light_jitter, rules.light_division))
        };
        let (all, division) = (Rules::default().ambient_bounces, Rules::default().light_division);
        assert_eq!(rules(&["rpict -ab 2 a.oct", "\tpfilt -x /2"], [false; 3]), Some((2, Some(0.0), 0.25)));
        assert_eq!(rules(&["rpict -ab 2 -dj .7 -ds .1 a.oct"], [true, false, false]), Some((all, Some(0.7), 0.1)));
        assert_eq!(rules(&["rpict -ab 2 -ds 0 a.oct"], [false; 3]), Some((2, Some(0.0), 0.0)));
        // Parts of .112 of their distance, jittered over nine tenths of it, widen by .1 · .112² / 4π.
        let (_, _, coarser) = rules(&["rpict -ab 2 -dj .9 -ds .02 a.oct"], [false; 3]).unwrap();
        assert!((coarser - 0.112).abs() < 1e-3, "{coarser}");
        assert_eq!(rules(&["rtrace -ab 2 -dj .9 a.oct"], [false, true, true]), Some((2, None, division)));
        // Who types one of both has the other from the header.
        assert_eq!(rules(&["rpict -ab 2 a.oct"], [false, false, true]), Some((2, Some(0.0), division)));
        assert_eq!(rules(&["rpict -ab 2 -dj .7 a.oct"], [false, true, false]), Some((2, None, 0.25)));
        assert_eq!(rules(&["/usr/bin/rtrace a.oct"], [false; 3]), Some((0, Some(0.0), 0.2)));
        assert_eq!(rules(&["rtrace-rs a.rad"], [false; 3]), Some((all, None, division)));
        assert_eq!(rules(&["hdrgen a.jpg"], [false; 3]), None);
        let noted = |line, typed: Typed| {
            let reckoning = Reckoning::of([line].into_iter()).unwrap();
            reckoning.note("a.hdr", &reckoning.taken_into(Rules { light_jitter: Some(0.9), ..Rules::default() }, typed), typed)
        };
        let note = |line| noted(line, Typed::default());
        // The division is told that is used.
        let typed = Typed { jitter: true, ..Typed::default() };
        assert!(!noted("rpict -ab 2 -ds .02 a.oct", typed).unwrap().contains("-ds 0.02"));
        assert!(note("rpict -ab 2 -ds .02 a.oct").unwrap().contains("-dj 0 -ds 0.0354, and"));
        assert_eq!(note("rpict -ab 2 a.oct").unwrap(), "a.hdr was rendered by rpict with -ab 2 -dr 1 -dj 0 -ds 0.25, and so it is here");
        assert!(note("rpict -ab 2 -av .1 .2 .3 -dj 1 a.oct").unwrap().contains("with -ab 2 -av 0.1 0.2 0.3 -dr 1 -dj 1 "));
        assert!(note("rtrace-rs -me .1 .1 .1 --ward 1992 a.rad").unwrap().contains("with -me 0.1 0.1 0.1 -dr 2 --ward 1992, "));
    }

    #[test]
    fn mirrors_the_medium_and_the_lobe_are_those_of_the_header() {
        let rules = |line: &str| Reckoning::of([line].into_iter()).unwrap().taken_into(Rules::default(), Typed::default());
        for (line, levels) in
            [("rpict a.oct", 1), ("rtrace a.oct", 2), ("rpict -dr 0 a.oct", 0), ("rtrace-rs a.rad", 2), ("rtrace-rs -dr 3 a.rad", 3)]
        {
            assert_eq!(rules(line).mirror_levels, levels, "{line}");
        }
        assert_eq!(rules("rpict -me .1 .2 .3 a.oct").extinction.to_array(), [0.1, 0.2, 0.3]);
        assert_eq!([rules("rtrace-rs --ward 1992 a.rad").lobe, rules("rpict a.oct").lobe], [Ward::Original, Ward::Bounded]);
        for (line, visible) in
            [("rpict a.oct", true), ("rpict -bv- a.oct", false), ("rpict -bv0 -bv a.oct", true), ("rpict -bv a.oct", false)]
        {
            assert_eq!(rules(line).back_visible, visible, "{line}");
        }
        let typed = Typed { mirrors: true, medium: true, backs: true, lobe: true, ..Typed::default() };
        let line = "rtrace-rs -dr 1 -me 1 1 1 -bv- --ward 1992 a.rad";
        assert_eq!(Reckoning::of([line].into_iter()).unwrap().taken_into(Rules::default(), typed), Rules::default());
        let said = |line: &'static str, typed| otherwise([line], typed).unwrap_or_default();
        assert!(said("rpict -ae floor a.oct", false).contains("rpict with -ae: only some surfaces"));
        assert!(said("rtrace-rs -i a.rad", true).contains("rtrace-rs with -i: it shows irradiance"));
        assert!(said("rpict -ae floor a.oct", true).is_empty() && said("rpict -ab 1 a.oct", false).is_empty());
    }

    #[test]
    fn what_stands_for_the_bounces_left_out_is_that_of_the_header() {
        let value = |line: &str, ambient: bool| {
            let rules = Rules { ambient_value: Rgb::ONE, ..Rules::default() };
            Reckoning::of([line].into_iter()).unwrap().taken_into(rules, Typed { ambient, ..Typed::default() }).ambient_value.to_array()
        };
        assert_eq!(value("rpict -ab 1 -av .18 .17 .16 -ad 64 a.oct", false), [0.18, 0.17, 0.16]);
        assert_eq!(value("rpict -av .18 .17 .16 a.oct", true), [1.0; 3]);
        for none in ["rpict -ab 1 a.oct", "rpict -av .1 .2", "rpict -av .1 nan .1", "rpict -av -1 -1 -1", "rtrace-rs -av 0 0 0 a.rad"] {
            assert_eq!(value(none, false), [0.0; 3], "{none}");
        }
        assert!(shortcuts(["rpict -ab 1 -aa 0 -dt 0 -av .1 .1 .1 -aw 16 a.oct"], None, 1)[0].contains("with -aw 16: "));
    }

    #[test]
    fn the_fresnel_term_is_that_of_the_release() {
        let offset = |line: &str, typed| {
            let lines = ["rpict a.oct", line];
            let typed = Typed { fresnel: typed, ..Typed::default() };
            Reckoning::of(lines.into_iter()).unwrap().taken_into(Rules::default(), typed).fresnel_offset
        };
        let larger = [
            "5.4 official release",
            "6.0a",
            "6.0.2 official",
            "5.4a lastmod Tue Mar  7 09:47:10 PST 2023 by x on y",
            "6.1a 2026-05-31 LBNL (a1b2c3)",
        ];
        for release in larger {
            let line = format!("SOFTWARE= RADIANCE {release}");
            assert_eq!([false, true].map(|typed| offset(&line, typed)), [LARGER_OFFSET, FRESNEL_OFFSET], "{release}");
        }
        let usual = [
            "5.3",
            "5.4a lastmod Mon Apr 25 09:47:10 PDT 2022 by x on y",
            "5.4a",
            "6.1a 2026-08-19 LBNL (a1b2c3)",
            "6.1",
            "rtrace, box filter",
        ];
        for line in usual.map(|release| format!("SOFTWARE= RADIANCE {release}")).iter().map(String::as_str).chain(["VIEW= -vtv"]) {
            assert_eq!(offset(line, false), FRESNEL_OFFSET, "{line}");
        }
        assert_eq!(offset("rtrace-rs --fresnel-offset .003 a.rad", false), 0.003);
    }

    #[test]
    fn light_that_bounces_otherwise_is_told() {
        let said = |line: &str, bounces: u32| {
            let rules = Rules { ambient_bounces: bounces, ..Rules::default() };
            Reckoning::of([line].into_iter()).and_then(|reckoning| reckoning.bounces_otherwise(&rules)).unwrap_or_default()
        };
        assert_eq!(said("rpict -ab 2 a.oct", 2), "");
        assert!(said("rpict -ab 2 a.oct", 3).ends_with("by rpict with -ab 2, and here light bounces otherwise: leave -ab out"));
        assert!(said("rpict a.oct", 2).contains("with -ab 0, and here"));
        assert!(said("rtrace-rs a.rad", 2).contains("with all bounces, and here"));
    }
}
