//! What RADIANCE's options come to here: each that was given, in words, and all of them as `rtrace -defaults` lists them.

use super::{Arguments, Light, Tuning};
use crate::color::Rgb;
use crate::error::Result;
use crate::rays::Space;
use crate::rules::defaults::radiances;
use crate::rules::{Rules, single};
use std::fmt::Display;
use std::fmt::Write;

/// What each given option does, and which defaults differ from RADIANCE's, a line each.
pub fn explain(arguments: &Arguments) -> String {
    let mut said = Said(String::new());
    said.light(&arguments.light);
    said.picture(arguments);
    said.rays(arguments);
    said.tuning(&arguments.light.tuning);
    if said.0.is_empty() {
        said.0.push_str("No option of RADIANCE's is given.\n");
    }
    said.0.push_str("Defaults that are not RADIANCE's, where the option is not given:\n");
    for (_, option, here) in differing(&arguments.light).into_iter().filter(|(given, ..)| !given) {
        let [rtrace, rpict] = radiances(option);
        let there = if rpict == rtrace { rtrace.to_string() } else { format!("{rtrace}, rpict {rpict}") };
        let _ = writeln!(said.0, "  {option} (there {there}): {here}");
    }
    said.0
}

/// What was said so far.
struct Said(String);

impl Said {
    /// A line for an option, if it was given.
    fn option<T: Display>(&mut self, name: &str, value: Option<T>, does: impl FnOnce(T) -> String) {
        if let Some(value) = value {
            let shown = value.to_string();
            let _ = writeln!(self.0, "{name} {shown}: {}", does(value));
        }
    }

    /// A line for what was given.
    fn say(&mut self, name: &str, does: &str) {
        let _ = writeln!(self.0, "{name}: {does}");
    }

    /// A line for a switch, if it was given.
    fn switch(&mut self, name: &str, value: Option<bool>, on: &str, off: &str) {
        if let Some(value) = value {
            let _ = writeln!(self.0, "{name}{}: {}", if value { '+' } else { '-' }, if value { on } else { off });
        }
    }

    /// A line for a list of words, if it has any.
    fn list(&mut self, name: &str, values: &[String], does: &str) {
        for value in values {
            let _ = writeln!(self.0, "{name} {value}: {does}");
        }
    }

    fn light(&mut self, light: &Light) {
        self.option("-ab", light.ab, |n| match n {
            ..=0 => "no diffuse bounce is followed; -av stands for all indirect diffuse light".into(),
            n => {
                format!("light is followed through {n} diffuse bounce{}, unbiased; -av stands for the rest", if n == 1 { "" } else { "s" })
            }
        });
        self.option("-av", words(&light.av), |_| "radiance from everywhere in place of the diffuse bounces that -ab leaves out".into());
        self.list("-ae", &light.ae, "its surfaces gather no indirect light, but -av");
        self.list("-aE", &light.ae_files, "surfaces of the modifiers listed there gather no indirect light, but -av");
        self.list("-ai", &light.ai, "its surfaces gather indirect light; those of modifiers not named gather -av");
        self.list("-aI", &light.ai_files, "surfaces of the modifiers listed there gather indirect light; others gather -av");
        self.option("-lr", light.lr, |n| match n {
            1.. => format!("a path ends after {n} reflections"),
            0 => "paths end by roulette below the weight -lw, which is unbiased".into(),
            n => format!("paths end by roulette below the weight -lw, which is unbiased, and after {} reflections", n.unsigned_abs()),
        });
        self.option("-lw", light.lw, |w| match light.lr {
            Some(1..) => format!("a path ends where its weight falls below {w}"),
            _ => format!("below the weight {w} roulette decides whether a path goes on, which is unbiased"),
        });
        self.option("-st", light.st, |st| {
            format!("rough reflection and transmission of {st} or less count as diffuse, except for highlights of lamps")
        });
        self.option("-ss", light.ss, |s| match s {
            0.0 => "rough surfaces reflect like mirrors".into(),
            s if s < 1.0 => "RADIANCE's unweighted sample of rough reflection, narrowed".into(),
            s if single(s) => "RADIANCE's unweighted sample of rough reflection".into(),
            _ => "the rough lobe itself, which RADIANCE approaches with many samples".into(),
        });
        self.option("-dj", light.dj, |j| match (j, light.ds) {
            (0.0, Some(0.0)) => "each lamp is one sample at its centre".into(),
            (0.0, _) => "each part of a lamp (-ds) is one sample at its middle".into(),
            _ => format!("each part of a lamp (-ds) is a sample jittered over {j} of its extent"),
        });
        self.option("-ds", light.ds, |s| match light.dj {
            Some(_) => format!("lamps are divided until their parts are smaller than {s} of their distance"),
            None => "nothing: without -dj lamps are integrated over all their extent, which no division can improve".into(),
        });
        self.option("-dr", light.dr, |n| format!("lamps are seen through up to {n} flat mirrors, one after another"));
        self.switch("-dv", light.dv, "lamps are seen", "lamps are not seen, though they light");
        self.switch("-bv", light.bv, "backs of surfaces are there", "backs of surfaces are not there");
        self.switch("-i", light.irradiance, "irradiance of the first surface instead of its radiance", "radiance");
        self.option("-me", words(&light.me), |_| "what fills the scene absorbs so much of the light per unit of length".into());
        self.option("--field", light.field.as_ref(), |field| match field.as_str() {
            "nearest" => "around each point the light is that of the nearest #@probe, if the scene has any".into(),
            _ => "around each point the light is that of the two nearest #@probe, by 1/distance², if the scene has any".into(),
        });
        self.option("--fresnel-offset", light.fresnel_offset, |_| "the Fresnel term of polished surfaces is lowered by that".into());
        self.option("--ward", light.ward.as_ref(), |_| "the rough lobe of the 2002 paper instead of RADIANCE's present one".into());
    }

    fn picture(&mut self, arguments: &Arguments) {
        let picture = &arguments.picture;
        if arguments.view.words.is_empty() {
            self.option("-x", picture.x, |x| match (x, picture.y) {
                (0, _) => "answers are written as it suits".into(),
                (x, None | Some(0)) => format!("{x} rays are answered before more are read"),
                (x, Some(_)) => format!("{x} rays make a line of the picture"),
            });
            self.option("-y", picture.y, |y| match y {
                0 => "all rays are answered".into(),
                y => format!("the program ends after {y} lines of -x rays"),
            });
        } else {
            self.say(&arguments.view.words.join(" "), "the view, as for rpict; a picture is rendered");
            self.option("-x", picture.x, |_| "largest width in pixels".into());
            self.option("-y", picture.y, |_| "largest height in pixels".into());
        }
        self.option("-pa", picture.pa, |_| {
            "height of a pixel over its width, by which -x and -y are fitted to the view; 0: they stay as they are".into()
        });
        self.option("-pj", picture.pj, |j| format!("a pixel is sampled over {j} of its width (box filter)"));
        self.option("-pd", picture.pd, |_| "diameter of the lens; things are in focus at the length of -vd".into());
        self.option("-z", picture.z.as_ref().map(|z| z.display()), |_| "the lengths of the pixels' central rays are written there".into());
        for (given, name, does) in [
            (picture.rgb, "-pRGB", "red, green and blue"),
            (picture.xyz, "-pXYZ", "CIE X, Y and Z, times 179"),
            (picture.luminance, "-pY", "luminance, times 179"),
            (picture.scotopic, "-pS", "scotopic luminance"),
            (picture.melanopic, "-pM", "melanopic luminance"),
        ] {
            if given {
                self.say(name, does);
            }
        }
        self.option("-pc", words(&picture.pc), |_| "RADIANCE's own primaries, as always".into());
    }

    fn rays(&mut self, arguments: &Arguments) {
        let rays = &arguments.rays;
        if let Some(format) = &rays.format {
            self.say(&format!("-f{format}"), "the form of the rays and of the answers");
        }
        if let Some(letters) = &rays.specifiers {
            self.say(&format!("-o{letters}"), "what is said of each ray, letter by letter (see --help)");
        }
        self.switch("-ld", rays.limit, "a ray ends where the vector of its direction does", "rays have no end");
        self.switch("-I", rays.point_irradiance, "irradiance at the point of each ray, on the side of its direction", "radiance");
        self.switch("-h", rays.header, "the answers have a header", "the answers have no header");
        self.list("-te", &rays.exclude, "rays that meet it are not told of after -ot");
        self.list("-tE", &rays.exclude_files, "rays that meet the modifiers listed there are not told of after -ot");
        self.list("-ti", &rays.include, "rays that meet it are told of after -ot, others not");
        self.list("-tI", &rays.include_files, "rays that meet the modifiers listed there are told of after -ot, others not");
        self.list("-e", &arguments.reading.definitions, "a definition that expressions in the scene may use");
        self.list("-f", &arguments.reading.function_files, "definitions that expressions in the scene may use");
    }

    fn tuning(&mut self, tuning: &Tuning) {
        let Tuning { aa, ar, ad, r#as, aw, af, ps, pt, t, dt, dc, dp, ma, mg, ms, u, w, cs, cw, am, pm, co, .. } = tuning;
        let cached = "nothing: indirect light is not interpolated, but computed where it is needed";
        self.option("-aa", *aa, |_| cached.into());
        self.option("-ar", *ar, |_| cached.into());
        self.option("-af", af.as_ref(), |_| "nothing: no indirect light is kept, so the file is neither read nor written".into());
        self.option("-ad", *ad, |n| match n {
            0 => "no diffuse bounce is followed".into(),
            _ => "nothing: as many samples are taken as --error, --spp or --time ask for".into(),
        });
        self.option("-as", *r#as, |_| "nothing: as many samples are taken as --error, --spp or --time ask for".into());
        self.option("-aw", *aw, |_| "nothing: -av stays what it is, as with -aw 0".into());
        self.option("-ps", *ps, |_| "nothing: every pixel is sampled".into());
        self.option("-pt", *pt, |_| "nothing: every pixel is sampled".into());
        self.option("-pm", *pm, |_| "nothing moves".into());
        self.option("-t", *t, |_| "nothing: progress is shown on a terminal, or with --progress".into());
        self.option("-dt", *dt, |_| "nothing: no lamp goes untested, as with -dt 0".into());
        self.option("-dc", *dc, |_| "nothing: no lamp goes untested, as with -dt 0".into());
        self.option("-dp", *dp, |_| "nothing: every path by way of a mirror is followed".into());
        self.option("-ma", words(ma), |_| "nothing: what fills the scene only absorbs".into());
        self.option("-mg", *mg, |_| "nothing: what fills the scene only absorbs".into());
        self.option("-ms", *ms, |_| "nothing: what fills the scene only absorbs".into());
        self.option("-am", *am, |_| "nothing: there are no photon maps".into());
        self.option("-cs", *cs, |_| "three colours, as always".into());
        self.option("-cw", words(cw), |_| "nothing: there are three colours".into());
        self.switch("-u", *u, "nothing: --seed fixes every random choice", "nothing: --seed fixes every random choice");
        self.switch("-co", *co, "nothing: there are three colours", "three colours, as always");
        self.switch("-w", *w, "warnings are shown", "warnings are not shown");
    }
}

/// Numbers in a row.
fn words(values: &Option<Vec<f64>>) -> Option<String> {
    values.as_ref().map(|v| v.iter().map(f64::to_string).collect::<Vec<_>>().join(" "))
}

/// Options whose defaults differ from RADIANCE's: whether it was given, its name, what holds here.
fn differing(light: &Light) -> [(bool, &'static str, String); 9] {
    let Rules { light_division, mirror_levels, .. } = Rules::default();
    [
        (light.ab.is_some(), "-ab", "all diffuse bounces, ended by roulette without bias".into()),
        (light.lr.is_some(), "-lr", "no limit of reflections".into()),
        (light.lw.is_some(), "-lw", "no smallest weight: roulette without bias".into()),
        (light.st.is_some(), "-st", "0: all rough reflection is followed".into()),
        (light.ss.is_some(), "-ss", "the rough lobe itself, as with a high -ss".into()),
        (light.dj.is_some(), "-dj", "lamps are integrated over all their extent".into()),
        (light.ds.is_some() || light.dj.is_none(), "-ds", light_division.to_string()),
        (light.dr.is_some(), "-dr", mirror_levels.to_string()),
        (light.tuning.aa.is_some(), "-aa", "0: indirect light is not interpolated".into()),
    ]
}

/// What holds for every option, as `rtrace -defaults` lists it. Where there is no number for it, the line is a comment.
pub fn defaults(arguments: &Arguments) -> Result<String> {
    let (rays, picture, tuning) = (&arguments.rays, &arguments.picture, &arguments.light.tuning);
    let rules = arguments.light.rules(&|_| Ok(vec![]))?;
    let mut out = String::new();
    let mut line = |option: String, what: &str| {
        let _ = writeln!(out, "{option:<24}\t# {what}");
    };
    let switch = |name: &str, on: bool| format!("{name}{}", if on { '+' } else { '-' });
    let number = |name: &str, value: Option<f64>, otherwise: &str| match value {
        Some(v) => format!("{name} {v}"),
        None => format!("# {name}: {otherwise}"),
    };
    let color = |name: &str, value: Rgb| format!("{name} {} {} {}", value.x, value.y, value.z);
    let bounces = Some(rules.ambient_bounces).filter(|n| *n < u32::MAX).map(f64::from);
    line(switch("-w", tuning.w.unwrap_or(true)), "warning messages");
    let (x, y) = picture.lines();
    line(format!("-x {x}"), "flush interval");
    line(format!("-y {y}"), "y resolution");
    line(switch("-ld", rays.limited()), "limit distance");
    line(switch("-h", rays.header()), "output header");
    line(format!("-f{}", rays.format()), "format input/output");
    line(format!("-o{}", rays.specifiers()), "output values");
    let space = match picture.space() {
        Space::Rgb => "-pRGB",
        Space::Xyz => "-pXYZ",
        Space::Photopic => "-pY",
        Space::Scotopic => "-pS",
        Space::Melanopic => "-pM",
    };
    line(space.into(), "color output");
    line(switch("-i", rules.irradiance), "irradiance calculation");
    line(switch("-I", rays.point_irradiance()), "immediate irradiance calculation");
    line(switch("-u", tuning.u.unwrap_or(false)), "uncorrelated sampling (--seed fixes every choice)");
    line(switch("-bv", rules.back_visible), "back face visibility");
    line("-dt 0".into(), "direct threshold");
    line("-dc 1".into(), "direct certainty");
    line(number("-dj", rules.light_jitter, "lamps are integrated"), "direct jitter");
    line(format!("-ds {}", rules.light_division), "direct sampling (with -dj)");
    line(format!("-dr {}", rules.mirror_levels), "direct relays");
    line("-dp 0".into(), "direct pretest density");
    line(switch("-dv", rules.lights_visible), "direct visibility");
    line(number("-ss", rules.specular_sampling, "the lobe itself"), "specular sampling");
    line(format!("-st {}", rules.specular_threshold), "specular threshold");
    line(color("-av", rules.ambient_value), "ambient value");
    line("-aw 0".into(), "ambient value weight");
    line(number("-ab", bounces, "all"), "ambient bounces");
    line("-aa 0".into(), "ambient accuracy");
    line(color("-me", rules.extinction), "extinction coefficient of the medium");
    line("-ma 0 0 0".into(), "scattering albedo of the medium");
    line(number("-lr", rules.limit_reflections.map(f64::from), "no limit"), "limit reflection");
    line(number("-lw", rules.limit_weight, "no limit, roulette"), "limit weight");
    Ok(out)
}

/// Whether these are all among [`FEATURES`].
pub fn has(names: &[String]) -> bool {
    names.iter().all(|name| FEATURES.lines().any(|line| line.split('=').next() == Some(name)))
}

/// RADIANCE's names of the features there are, a line each, as `rtrace -features` lists them.
pub const FEATURES: &str = "\
VirtualSources
SecondarySources
SourceSubsampling
SourceVisibility
AmbientModifierSelection
PathTracing
RussianRoulette
LowDiscrepancySeq
SpecularSampling
MaterialMixtures
Antimatter
BackFaceVisibility
ScatteringModels=WGMD,Ashikhmin-Shirley
Instancing=Octree,TriangleMesh
Aliases
Multiprocessing
IrradianceCalc
ImmediateIrradiance
DistanceLimiting
InputFormats=a,f,d
OutputFormats=a,f,d,c
Outputs=o,d,v,V,w,W,l,L,c,p,n,N,s,m,M,r,x,R,X,~
OutputCS=RGB,XYZ,Y,S,M
";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Typed, parse};

    #[test]
    fn what_holds_is_listed_and_not_what_was_typed() {
        let line = ["rtrace-rs", "-defaults", "-pS", "-ad", "0", "-av", ".1", ".2", ".3"];
        let typed = parse::<Arguments>(line.map(Into::into).into(), &|name| Err(crate::error::Error::new(name))).unwrap();
        let Typed::Run(arguments, _) = typed else { panic!() };
        let listed = defaults(&arguments).unwrap();
        for option in ["-pS", "-ab 0", "-av 0.1 0.2 0.3", "-dr 2", "# -lr: no limit"] {
            assert!(listed.lines().any(|line| line.split('\t').next().unwrap().trim() == option), "{option}: {listed}");
        }
    }
}
