//! How the program that rendered a picture reckoned with light, which is how it is reckoned with here where nothing else was typed.

use super::release::offset_of_release;
use super::{Command, PROGRAMS};
use crate::color::Rgb;
use crate::rad::Number;
use crate::rules::{Rules, Ward, lowers_fresnel, single};
use std::f64::consts::PI;

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
    /// `-dv`.
    pub lamps: bool,
    /// `-lr`.
    pub reflections: bool,
    /// `-ss`.
    pub sampling: bool,
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
    /// Whether lamps are seen.
    lit: bool,
    /// After how many reflections light is left out, if that is so.
    reflections: Option<i32>,
    /// `-ss`, if rough reflection is that of [`Rules::single`] samples.
    sampling: Option<f64>,
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
        let ours = command.is_ours();
        let (jitter, division, bounces, mirrors) = if ours {
            (None, default.light_division, default.ambient_bounces, default.mirror_levels)
        } else {
            let count = |name: &str| command.default(name) as u32;
            (Some(command.default("-dj")), command.default("-ds"), count("-ab"), count("-dr"))
        };
        let count = |name: &str, other: u32| command.given(name).map_or(other, |count| count.max(0.0) as u32);
        let bounces = command.bounces().map_or(bounces, |most| most.max(0.0) as u32);
        let jitter = command.given("-dj").filter(|dj| (0.0..=1.0).contains(dj)).or(jitter);
        let division = command.given("-ds").filter(|ds| *ds >= 0.0).unwrap_or(division);
        Some(Self {
            program: command.program().into(),
            bounces,
            ambient: command.color("-av").unwrap_or(default.ambient_value),
            lamps: jitter.map(|jitter| [jitter, division]),
            mirrors: count("-dr", mirrors),
            medium: command.color("-me").unwrap_or(default.extinction),
            backs: command.on("-bv"),
            lit: command.on("-dv"),
            reflections: command.option("-lr").map(|(most, _)| (most as i32).saturating_abs()).filter(|most| *most > 0),
            sampling: command.option("-ss").map(|(sampling, _)| sampling).filter(|s| single(*s)),
            lobe: if ours && command.word("--ward").is_some() { Ward::Original } else { default.lobe },
            fresnel_offset: command
                .given("--fresnel-offset")
                .filter(|offset| lowers_fresnel(*offset))
                .or_else(|| lines.filter_map(offset_of_release).last()),
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
        if !typed.lamps {
            rules.lights_visible = self.lit;
        }
        // What RADIANCE ends by roulette, and below a weight, hardly counts.
        if !typed.reflections {
            rules.limit_reflections = self.reflections.map(|most| -most);
        }
        if !typed.sampling {
            rules.specular_sampling = self.sampling;
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
            (typed.lamps, (!self.lit).then(|| "-dv-".into())),
            (typed.reflections, self.reflections.map(|most| format!("-lr {most}"))),
            (typed.sampling, self.sampling.map(|sampling| number("-ss", sampling))),
            (typed.lobe, (self.lobe == Ward::Original).then(|| "--ward 1992".into())),
            (typed.jitter, lamp("-dj", rules.light_jitter)),
            (typed.division, lamp("-ds", Some(rules.light_division))),
        ];
        let options: Vec<String> = said.into_iter().filter_map(|(typed, option)| option.filter(|_| !typed)).collect();
        let note = || format!("{name} was rendered by {} with {}, and so it is here", self.program, options.join(" "));
        (!options.is_empty()).then(note)
    }

    /// What is to be said if light is reckoned with otherwise by these rules, in what a picture's brightness depends on.
    pub fn otherwise(&self, rules: &Rules) -> Option<String> {
        let color = |option: &str, color: Rgb| format!("{option} {} {} {}", Number(color.x), Number(color.y), Number(color.z));
        let sampling = || self.sampling.map_or_else(|| "weighted rough samples".into(), |sampling| format!("-ss {}", Number(sampling)));
        let lobe = || if self.lobe == Ward::Original { "--ward 1992" } else { "RADIANCE's lobe" }.to_string();
        let all = [
            ("-ab", self.limit().unwrap_or_else(|| "all bounces".into()), rules.ambient_bounces != self.bounces),
            ("-av", color("-av", self.ambient), rules.ambient_value != self.ambient),
            ("-me", color("-me", self.medium), rules.extinction != self.medium),
            ("-ss", sampling(), rules.single() != self.sampling.is_some()),
            ("--ward", lobe(), rules.lobe != self.lobe),
        ];
        let (options, said): (Vec<&str>, Vec<String>) =
            all.into_iter().filter_map(|(option, said, differs)| differs.then_some((option, said))).unzip();
        let remark = || {
            let (said, options) = (said.join(", "), options.join(", "));
            format!(
                "the target was rendered by {} with {said}, and here light is reckoned with otherwise: leave {options} out",
                self.program
            )
        };
        (!said.is_empty()).then(remark)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rules::FRESNEL_OFFSET;

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
        assert_eq!(rules(&["rtrace-rs -ab 2 -ad 0 a.rad"], [false; 3]), Some((0, None, division)));
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
        assert_eq!(
            note("rpict -ab 2 a.oct").unwrap(),
            "a.hdr was rendered by rpict with -ab 2 -dr 1 -lr 7 -ss 1 -dj 0 -ds 0.25, and so it is here"
        );
        assert!(note("rpict -ab 2 -av .1 .2 .3 -dj 1 a.oct").unwrap().contains("with -ab 2 -av 0.1 0.2 0.3 -dr 1 -lr 7 -ss 1 -dj 1 "));
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
    }

    #[test]
    fn light_ends_after_as_many_reflections_as_the_header_has() {
        let most =
            |line: &str, typed: Typed| Reckoning::of([line].into_iter()).unwrap().taken_into(Rules::default(), typed).limit_reflections;
        let default = Typed::default();
        for (line, limit) in [
            ("rpict a.oct", Some(-7)),
            ("rtrace a.oct", Some(-10)),
            ("rpict -lr -12 a.oct", Some(-12)),
            ("rpict -lr 0 a.oct", None),
            ("rtrace-rs a.rad", None),
        ] {
            assert_eq!(most(line, default), limit, "{line}");
        }
        assert_eq!(most("rpict a.oct", Typed { reflections: true, ..default }), None);
    }

    #[test]
    fn single_samples_are_those_of_the_header() {
        let single = |line: &str, typed: Typed| Reckoning::of([line].into_iter()).unwrap().taken_into(Rules::default(), typed).single();
        let default = Typed::default();
        assert!(single("rpict a.oct", default) && single("rtrace -ss 1.5 a.oct", default) && single("rtrace-rs -ss 1 a.rad", default));
        for line in ["rpict -ss 2 a.oct", "rpict -ss .5 a.oct", "rtrace-rs a.rad"] {
            assert!(!single(line, default), "{line}");
        }
        assert!(!single("rpict a.oct", Typed { sampling: true, ..default }));
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
    }

    #[test]
    fn light_that_bounces_otherwise_is_told() {
        let said = |line: &str, bounces: u32| {
            let reckoning = Reckoning::of([line].into_iter()).unwrap();
            let rules = Rules { ambient_bounces: bounces, ..reckoning.taken_into(Rules::default(), Typed::default()) };
            reckoning.otherwise(&rules).unwrap_or_default()
        };
        assert_eq!(said("rpict -ab 2 a.oct", 2), "");
        assert!(said("rpict -ab 2 a.oct", 3).ends_with("by rpict with -ab 2, and here light is reckoned with otherwise: leave -ab out"));
        assert!(said("rpict a.oct", 2).contains("with -ab 0, and here"));
        assert!(said("rtrace-rs a.rad", 2).contains("with all bounces, and here"));
        let other = Rules { ambient_bounces: 2, extinction: Rgb::ONE, lobe: Ward::Original, ..Rules::default() };
        let said = Reckoning::of(["rpict -ab 2 a.oct"].into_iter()).unwrap().otherwise(&other).unwrap();
        assert!(
            said.contains("with -me 0 0 0, -ss 1, RADIANCE's lobe, and here") && said.ends_with("leave -me, -ss, --ward out"),
            "{said}"
        );
    }

    #[test]
    fn the_fresnel_term_is_that_of_the_header() {
        let offset = |lines: &[&str], fresnel| {
            let typed = Typed { fresnel, ..Typed::default() };
            Reckoning::of(lines.iter().copied()).unwrap().taken_into(Rules::default(), typed).fresnel_offset
        };
        let release = ["rpict a.oct", "SOFTWARE= RADIANCE 6.0a"];
        assert!(offset(&release, false) < FRESNEL_OFFSET);
        assert_eq!(offset(&release, true), FRESNEL_OFFSET);
        assert_eq!(offset(&["rpict a.oct"], false), FRESNEL_OFFSET);
        assert_eq!(offset(&["rtrace-rs --fresnel-offset .003 a.rad"], false), 0.003);
    }
}
