//! What a picture leaves open: which parameters, and which combinations of them, it does not determine, and what would.
//!
//! A parameter is measured by what its bounds alone would say of it: a value anywhere between them has the standard deviation range/√12. A
//! picture that does not make it much less does not determine it. Nor does one that would, if its errors were independent from pixel to
//! pixel, but not with a small error that many pixels have in common.

use super::misfit::Misfit;
use super::sheet::COMMON;
use super::words::{by, combination, list, percent};
use super::{Blur, clear};
use crate::anneal::Parameter;
use crate::anneal::linear::Symmetric;
use crate::render::WIDEST;
use crate::unknown::{COLORS, EXPOSURES, ROUGHNESSES, SHARES, Unknown};

/// What is known of the errors of some values.
pub struct Known<'a> {
    /// Their covariance.
    pub covariance: Symmetric,
    /// What an error of `COMMON` that the pixels have in common does to them, if pixels were looked at.
    pub common: Option<&'a Symmetric>,
    /// Which of them surely would go on if a bound did not keep them; none if that is not known.
    pub pressed: &'a [bool],
    /// And how large an error they have seems to be.
    pub misfit: Misfit,
    /// How the picture is blurred, if there is any saying.
    pub blur: Option<Blur>,
}

impl Known<'_> {
    /// Whether a value surely would go on if a bound did not keep it.
    pub fn presses(&self, i: usize) -> bool {
        self.pressed.get(i).copied().unwrap_or(false)
    }
}

/// What there is to think of some values.
pub struct Judgement {
    /// The standard error of each; of what is not determined, and of all where the picture is not explained, with the errors that pixels have in common.
    pub errors: Vec<f64>,
    /// The correlation of those errors.
    pub correlations: Symmetric,
    /// How far the picture determines each.
    pub standings: Vec<Standing>,
    /// What is not determined, why, and what would help: a sentence each.
    pub doubts: Vec<String>,
}

/// How far a picture determines a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// It does.
    Determined,
    /// It does together with others.
    Together,
    /// It does not.
    Open,
}

/// What an error that only neighbours have in common does to values, in terms of one of as much that all pixels have: of 27 pictures whose view, shape or
/// map was a little off, colours and shares were off by a sixth of that on the average, and once by nine tenths, roughnesses by up to 1.2 times, and
/// indices by up to 5 times.
const BESIDE: f64 = 0.5;
const BESIDE_ROUGH: f64 = 1.0;
const BESIDE_INDEX: f64 = 3.0;
/// By how many times as much neighbours are off as areas where it is they that it is said of.
const MOSTLY: f64 = 2.0;
/// What is not determined has a standard error of at least this part of the one that bounds alone would give it.
pub const UNDETERMINED: f64 = 0.3;
/// Values that are known only together are correlated at least so much.
pub const TOGETHER: f64 = 0.9;
/// Off by so much of its light, a picture is not explained at all.
pub const ASTRAY: f64 = 0.1;
/// And by so much, it is of something else, and tells nothing.
const ELSEWHERE: f64 = 1.0;
/// A picture that a filter of a smaller radius would make, in pixels, is as if each pixel were looked at in its middle.
const CENTRED: f64 = 0.05;
/// Beyond this part of what bounds alone would say, they alone say it.
const ANYWHERE: f64 = 0.9;

/// What there is to think of the values of an unknown, by what is known of their errors.
pub fn judge(unknown: &Unknown, values: &[f64], known: &Known) -> Judgement {
    let errors = Errors::new(unknown, values, known);
    let n = values.len();
    let (standings, mut doubts) = errors.doubts(unknown, values);
    let explained = known.misfit.is_noise();
    if !explained {
        doubts.insert(0, errors.unexplained(&standings));
    }
    if let Some(blur) = known.blur.filter(Blur::is_sure) {
        doubts.insert(0, misjudged(&blur, explained));
    }
    let (seen, whole) = (&known.covariance, &errors.whole);
    let correlated = whole.correlations();
    // Where an error that pixels have in common leaves a colour open, it moves the others too.
    let colour = |i: usize| COLORS.1.contains(&&unknown.parameters()[i].name[..]);
    let moved = |j: usize| colour(j) && errors.scaled(seen, j, j).sqrt() < UNDETERMINED;
    let swayed = |i: usize| colour(i) && (0..n).any(|j| standings[j] != Standing::Determined && moved(j));
    let plain = |i: usize| explained && standings[i] == Standing::Determined && !swayed(i);
    let error = |i: usize| {
        let whole = whole.at(i, i).sqrt() * errors.units[i];
        if plain(i) { seen.at(i, i).max(0.0).sqrt().min(whole) } else { whole }
    };
    let alike = seen.correlations();
    let correlations = Symmetric::of(n, |i, j| if plain(i) && plain(j) { alike.at(i, j) } else { correlated.at(i, j) });
    Judgement { errors: (0..n).map(error).collect(), correlations, standings, doubts }
}

/// The errors of some values, in terms of what bounds alone would say of each, which is 1.
struct Errors<'a> {
    parameters: &'a [Parameter],
    known: &'a Known<'a>,
    /// What bounds alone would say.
    units: Vec<f64>,
    /// Of what the picture cannot tell anything.
    unseen: Vec<bool>,
    /// The covariance, with the errors that pixels have in common.
    whole: Symmetric,
}

impl<'a> Errors<'a> {
    fn new(unknown: &'a Unknown, values: &[f64], known: &'a Known<'a>) -> Self {
        let (parameters, seen) = (unknown.parameters(), &known.covariance);
        let n = parameters.len();
        let dull = lusterless(unknown, values, seen);
        // Where the picture is not explained, what only a bound keeps from going on may be anything.
        let held = |i: usize| known.misfit.off() >= ASTRAY && at_bound(&parameters[i], values[i], None).is_some();
        // What few samples made seems smoother than it is.
        let rough = |i: usize| is_roughness(&parameters[i]) && (dull || known.misfit.singles > 0.0);
        let unseen = |i: usize| !seen.at(i, i).is_finite() || rough(i) || known.misfit.areas >= ELSEWHERE || held(i);
        let (units, unseen) = (parameters.iter().map(Parameter::anywhere).collect(), (0..n).map(unseen).collect());
        let mut errors = Self { parameters, known, units, unseen, whole: Symmetric::diagonal(&[]) };
        let whole = Symmetric::of(n, |i, j| errors.scaled(seen, i, j) + errors.moved(i, j));
        errors.whole = whole.with_eigenvalues(|v| v.clamp(1e-18, 1.0));
        errors
    }

    fn scaled(&self, covariance: &Symmetric, i: usize, j: usize) -> f64 {
        let one = f64::from(i == j);
        let scaled = covariance.at(i, j) / (self.units[i] * self.units[j]);
        if self.unseen[i] || self.unseen[j] || !scaled.is_finite() { one } else { scaled }
    }

    /// The error that the pixels are taken to have in common, as far as it moves a value.
    fn off(&self, i: usize) -> f64 {
        let Misfit { neighbours, .. } = self.known.misfit;
        let beside = neighbours
            * match &self.parameters[i].name[..] {
                name if ROUGHNESSES.contains(&name) => BESIDE_ROUGH,
                "ior" => BESIDE_INDEX,
                _ => BESIDE,
            };
        self.known.misfit.alike().max(beside).max(COMMON)
    }

    /// What that makes of the covariance.
    fn moved(&self, i: usize, j: usize) -> f64 {
        self.known.common.map_or(0.0, |common| self.scaled(common, i, j) * self.off(i) * self.off(j) / (COMMON * COMMON))
    }

    /// How far each parameter is determined, and a sentence on each that is not, or on those that are so only together.
    fn doubts(&self, unknown: &Unknown, values: &[f64]) -> (Vec<Standing>, Vec<String>) {
        let (parameters, whole, n) = (self.parameters, &self.whole, values.len());
        let (inverse, correlations) = (whole.with_eigenvalues(|v| 1.0 / v), whole.correlations());
        // What would be known if all others were.
        let alone = |i: usize| inverse.at(i, i).sqrt().recip() >= UNDETERMINED;
        let mut left: Vec<usize> = (0..n).filter(|&i| whole.at(i, i).sqrt() >= UNDETERMINED).collect();
        left.sort_by(|&a, &b| whole.at(b, b).total_cmp(&whole.at(a, a)));
        let (mut standings, mut doubts) = (vec![Standing::Determined; n], vec![]);
        for pivot in left {
            if standings[pivot] != Standing::Determined {
                continue;
            }
            let goes = |i: &usize| {
                *i != pivot && standings[*i] == Standing::Determined && !alone(*i) && correlations.at(*i, pivot).abs() >= TOGETHER
            };
            let partners: Vec<usize> = if alone(pivot) { vec![] } else { (0..n).filter(goes).collect() };
            let exposure = |i: &&usize| EXPOSURES.contains(&&parameters[**i].name[..]);
            let help = remedy(unknown, values, partners.iter().find(exposure).copied().unwrap_or(pivot));
            if partners.is_empty() {
                standings[pivot] = Standing::Open;
                // Where nothing explains the picture, no other light or view would; nor for what is held by a bound, which is said of it.
                let p = &parameters[pivot];
                let bound = at_bound(p, values[pivot], None).filter(|_| self.known.presses(pivot));
                let held = bound.is_some_and(|(_, bound)| may_exceed(unknown, p, bound));
                if self.known.misfit.off() < ASTRAY && !held {
                    doubts.push(format!("{} is not determined: {}; {help}", p.name, self.why(pivot)));
                }
            } else {
                partners.iter().chain([&pivot]).for_each(|&i| standings[i] = Standing::Together);
                let covariance = Symmetric::of(n, |i, j| whole.at(i, j) * self.units[i] * self.units[j]);
                doubts.push(format!("{}; {help}", together(parameters, values, &covariance, pivot, &partners)));
            }
        }
        (standings, doubts)
    }

    /// Why a parameter is not determined.
    fn why(&self, i: usize) -> String {
        if self.scaled(&self.known.covariance, i, i).sqrt() < UNDETERMINED {
            let part = self.whole.at(i, i).sqrt();
            let far = if part > ANYWHERE { "anywhere between its bounds".to_string() } else { by(part * self.units[i]) };
            format!("an error of {} % in the light, the shape or the picture could move it {far}", percent(self.off(i)))
        } else if is_roughness(&self.parameters[i]) && self.known.misfit.singles > 0.0 {
            "it seems smoother than it is where few samples made a picture".to_string()
        } else if self.known.common.is_some() {
            "this picture and this light say next to nothing of it".to_string()
        } else {
            "the chi-squareds that were seen are too few, or too noisy, or say little of it".to_string()
        }
    }

    /// That the picture is not explained, how far that could move what is determined, and what it leaves open.
    fn unexplained(&self, standings: &[Standing]) -> String {
        let of = |standing: Standing| (0..standings.len()).filter(move |&i| standings[i] == standing);
        let far = |i: usize| format!("{} {}", self.parameters[i].name, by(self.moved(i, i).sqrt() * self.units[i]));
        let far: Vec<String> = of(Standing::Determined).map(far).collect();
        let harm = if far.is_empty() {
            String::new()
        } else {
            format!("; so large an error could move {}, as the standard errors say", list(&far))
        };
        let open: Vec<&str> = of(Standing::Open).map(|i| self.parameters[i].name.as_str()).collect();
        let astray = self.known.misfit.off() >= ASTRAY;
        let lost = if astray && !open.is_empty() { format!("; {} cannot be told by it", list(&open)) } else { String::new() };
        let Misfit { areas, neighbours, singles, around } = self.known.misfit;
        if around > areas.max(neighbours).max(singles) {
            let part = percent(around);
            return format!(
                "the light that the unknown is found by may be off by {part} % too, as what is around it is, or as its renderer left it{harm}{lost}"
            );
        }
        if areas.max(neighbours) < singles {
            return format!(
                "single pixels hold {} % of the light too much or too little: few samples of a small bright light, such as a sun in the map, made the picture (render it with more, or with the sun as a light of its own), or the view, the shape or the light are not those of the photograph{harm}{lost}",
                percent(singles)
            );
        }
        if MOSTLY * areas < neighbours {
            return format!(
                "neighbouring pixels are {} % brighter or darker together than any noise explains: the view, the shape, the light or the type may not quite be those of the photograph{harm}{lost}",
                percent(neighbours)
            );
        }
        let exposed = self.parameters.iter().any(|p| EXPOSURES.contains(&p.name.as_str()));
        let exposure = if exposed { "" } else { "the exposure (--param exposure=1:.5:2), " };
        format!(
            "whole areas of the picture are {} brighter or darker than any noise explains: the light, {exposure}the view, the shape, the type or a bound may not be those of the photograph{harm}{lost}",
            match areas {
                areas @ ..ELSEWHERE => format!("{} %", percent(areas)),
                areas @ ..10.0 => format!("{areas:.1} times"),
                areas => format!("{areas:.0} times"),
            }
        )
    }
}

/// That the picture is blurred otherwise than was taken for given; where it is not `explained`, what is elsewhere than it should be seems blurred too.
fn misjudged(blur: &Blur, explained: bool) -> String {
    let (how, passes) = if blur.more > 0.0 { ("more", "rougher") } else { ("less", "smoother") };
    let radius = blur.radius().0;
    let cause = if !explained {
        "as where the view, the shape or the light are not those of the photograph; if they are, --filter auto reckons with it".into()
    } else if radius < CENTRED {
        "as samples of the pixels' centres are (-pj 0); --filter auto reckons with it".into()
    } else if radius <= WIDEST {
        format!("a filter of radius {radius:.2} makes such pixels (pfilt -r); --filter auto reckons with it")
    } else {
        "no filter blurs so much; the view, the shape or the light may not be those of the photograph".into()
    };
    format!("the picture is {how} blurred than its pixels are taken to be, and things seem {passes} by that: {cause}")
}

fn is_roughness(p: &Parameter) -> bool {
    ROUGHNESSES.contains(&p.name.as_str())
}

/// The bound that a value is at, if it is at one: nearer than a part of the range, and than its error, if that is known.
pub fn at_bound(p: &Parameter, value: f64, error: Option<f64>) -> Option<(&'static str, f64)> {
    let near = |(_, end): &(&str, f64)| (value - end).abs() <= (AT_BOUND * p.range()).min(error.unwrap_or(f64::INFINITY));
    [("lower", p.low), ("upper", p.high)].into_iter().find(near)
}

/// Whether what is at a bound may lie beyond it: no number of a material is less than nothing, no share of light more than all, nor what passes glass.
pub fn may_exceed(unknown: &Unknown, p: &Parameter, bound: f64) -> bool {
    let passes = clear::KINDS.contains(&unknown.material().kind.as_str()) && COLORS.1.contains(&&p.name[..]);
    bound != 0.0 && !(bound == 1.0 && (passes || SHARES.contains(&&p.name[..])))
}

/// A value nearer to a bound than this part of the range is at it.
const AT_BOUND: f64 = 1e-5;

/// Whether there may be no specular reflection, which would be of any roughness; whatever the exposure, which makes none of some.
pub fn lusterless(unknown: &Unknown, values: &[f64], seen: &Symmetric) -> bool {
    let named = |name: &str| unknown.parameters().iter().position(|p| p.name == name);
    let transmits = unknown.material().type_of().and_then(|t| t.parameter("tspec")).is_some();
    named("spec").filter(|_| !transmits).is_some_and(|i| {
        let by_exposure = EXPOSURES.iter().filter_map(|name| named(name)).map(|e| seen.at(i, e).powi(2) / seen.at(e, e));
        let variance = seen.at(i, i) - by_exposure.filter(|part| part.is_finite()).fold(0.0, f64::max);
        values[i] <= FAINT * variance.max(0.0).sqrt()
    })
}

/// A specularity of so many standard errors may be none.
pub const FAINT: f64 = 2.0;

/// A specularity below this is hardly any.
const DULL: f64 = 0.003;

/// `red, green and spec are not determined by themselves, only together: red + 0.41 spec = 0.641 ± 0.012, green + …`.
fn together(parameters: &[Parameter], values: &[f64], covariance: &Symmetric, pivot: usize, partners: &[usize]) -> String {
    let name = |i: usize| parameters[i].name.as_str();
    let mut names: Vec<usize> = partners.iter().copied().chain([pivot]).collect();
    names.sort_unstable();
    let known = |&i: &usize| {
        let two = [i, pivot];
        combination(two.map(name), two.map(|k| values[k]), two.map(|k| covariance.at(k, k)), covariance.at(i, pivot))
    };
    let known: Vec<String> = partners.iter().map(known).collect();
    format!(
        "{} are not determined by themselves, only together: {}",
        list(&names.into_iter().map(name).collect::<Vec<_>>()),
        known.join(", ")
    )
}

/// What would tell a parameter.
fn remedy(unknown: &Unknown, values: &[f64], i: usize) -> &'static str {
    let parameters = unknown.parameters();
    let spec = unknown.material().type_of().and_then(|t| t.parameter("spec")).map(|at| unknown.reals(values)[at]);
    match parameters[i].name.as_str() {
        name if ROUGHNESSES.contains(&name) && spec.is_some_and(|spec| spec < DULL) => {
            "hardly any specular reflection is found to tell it by"
        }
        name if name == "spec" || ROUGHNESSES.contains(&name) => {
            "a small lamp whose highlight the camera sees, or other light with sharp edges, would tell"
        }
        "trans" | "tspec" => "a small lamp or something with sharp edges seen through it would tell",
        "ior" => "something with sharp edges seen through it, or a small lamp, would tell",
        name if COLORS.1.contains(&name) => "light of that colour where the camera sees the object, or through it, would tell",
        name if EXPOSURES.contains(&name) => {
            "a grey card in the picture would tell the exposure, and something that is known of the material would"
        }
        _ => "another light or another view may tell",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;
    use crate::rad::Document;
    use crate::unknown::Wishes;

    /// What there is to think of a plastic, by the part of its parameters' ranges that the errors are, and a correlation of two of them.
    fn plastic(seen: [f64; 5], common: [f64; 5], (i, j, r): (usize, usize, f64), areas: f64) -> Judgement {
        let misfit = Misfit { areas, ..Misfit::default() };
        let document = Document::parse(Source::new("m.rad", "void plastic m 0 0 5 .6 .4 .2 .1 .1")).unwrap();
        let unknown = Unknown::new(document, &Wishes::default()).unwrap();
        let ranges: Vec<f64> = unknown.parameters().iter().map(Parameter::range).collect();
        let matrix = |e: [f64; 5]| {
            let r = |a, b| if a == b { 1.0 } else { r * f64::from((a, b) == (j.max(i), i.min(j))) };
            Symmetric::of(5, |a, b| r(a, b) * e[a] * ranges[a] * e[b] * ranges[b])
        };
        judge(
            &unknown,
            &[0.6, 0.4, 0.2, 0.6, 0.1],
            &Known { covariance: matrix(seen), common: Some(&matrix(common)), pressed: &[], misfit, blur: None },
        )
    }

    #[test]
    fn errors_hold_what_neighbours_or_things_around_are_off_by() {
        let judged = |misfit: Misfit| {
            let unknown =
                Unknown::new(Document::parse(Source::new("m.rad", "void dielectric m 0 0 5 .5 .5 .5 1.5 0")).unwrap(), &Wishes::default());
            let (covariance, common) = (Symmetric::diagonal(&[1e-8; 4]), Symmetric::diagonal(&[1e-6; 4]));
            judge(&unknown.unwrap(), &[0.5, 0.5, 0.5, 1.5], &Known { covariance, common: Some(&common), pressed: &[], misfit, blur: None })
        };
        // As much as what all pixels have in common does to the colours, by half; of the index three times as much.
        let found = judged(Misfit { neighbours: 0.06, ..Misfit::default() });
        assert!(found.doubts[0].starts_with("neighbouring pixels are 6 % brighter or darker together than any noise explains: "));
        assert!((found.errors[0] - 0.002).abs() < 1e-5 && (found.errors[3] - 0.012).abs() < 1e-5, "{:?}", found.errors);
        let found = judged(Misfit { around: 0.06, neighbours: 0.02, ..Misfit::default() });
        assert!(found.doubts[0].starts_with(
            "the light that the unknown is found by may be off by 6 % too, as what is around it is, or as its renderer left it; "
        ));
        assert!((found.errors[0] - 0.004).abs() < 1e-5, "{:?}", found.errors);
    }

    #[test]
    fn what_the_picture_determines_is_not_doubted() {
        let found = plastic([0.001; 5], [0.02; 5], (0, 3, -0.9), 0.0);
        assert!(found.doubts.is_empty() && found.standings == [Standing::Determined; 5]);
        assert!((found.errors[4] - 0.0004).abs() < 1e-12 && (found.correlations.at(0, 3) + 0.9).abs() < 1e-9);
    }

    #[test]
    fn what_it_does_not_is_named_with_what_would() {
        // Of the third nothing is seen, the fifth stands and falls with a small error that the pixels have in common.
        let found = plastic([0.001, 0.001, f64::INFINITY, 0.001, 0.01], [0.01, 0.01, 0.01, 0.01, 0.1], (0, 1, 0.0), 0.0);
        assert_eq!(found.doubts.len(), 2, "{:?}", found.doubts);
        assert!(found.doubts[0].starts_with("blue is not determined: this picture and this light say next to nothing of it; "));
        assert!(found.doubts[1].starts_with(
            "rough is not determined: an error of 1.5 % in the light, the shape or the picture could move it by 0.04; a small lamp"
        ));
        assert!((found.errors[2] - 12f64.sqrt().recip()).abs() < 1e-9 && (found.errors[4] - 0.4 * 0.01f64.hypot(0.1)).abs() < 1e-9);
        assert_eq!((found.errors[0], found.standings[4]), (0.001, Standing::Open));
        // A colour stands and falls with one that the same error leaves open.
        let found = plastic([0.001; 5], [0.1, 0.01, 0.01, 0.01, 0.01], (0, 3, -0.9), 0.0);
        assert_eq!(found.standings[..4], [Standing::Open, Standing::Determined, Standing::Determined, Standing::Determined]);
        assert!(found.errors[1] > 0.01 && found.errors[3] < 0.002 && found.errors[4] < 0.001, "{:?}", found.errors);
    }

    #[test]
    fn what_is_known_only_together_is_named_with_what_is_known() {
        let found = plastic([0.2, 0.001, 0.001, 0.25, 0.001], [0.0; 5], (0, 3, -0.999), 0.0);
        let [doubt] = &found.doubts[..] else { panic!("{:?}", found.doubts) };
        assert!(
            doubt.starts_with("red and spec are not determined by themselves, only together: red + 0.80 spec = 1.0794 ± 0.0089; "),
            "{doubt}"
        );
        assert_eq!((found.standings[0], found.standings[1]), (Standing::Together, Standing::Determined));
    }

    #[test]
    fn what_may_reflect_nothing_is_of_any_roughness() {
        let standing = |part| plastic([0.001, 0.001, 0.001, part, 0.001], [0.0; 5], (0, 3, 0.0), 0.0).standings[4];
        assert_eq!([0.25, 0.35].map(standing), [Standing::Determined, Standing::Open]);
    }

    #[test]
    fn a_picture_that_the_model_does_not_explain_is_doubted() {
        assert!(plastic([0.001; 5], [0.01; 5], (0, 1, 0.0), 0.01).doubts.is_empty());
        let found = plastic([0.001; 5], [0.01; 5], (0, 1, 0.0), 0.03);
        let [doubt] = &found.doubts[..] else { panic!("{:?}", found.doubts) };
        assert!(doubt.starts_with("whole areas of the picture are 3 % brighter or darker than any noise explains: "), "{doubt}");
        assert!(
            doubt.ends_with(
                "could move red by 0.02, green by 0.02, blue by 0.02, spec by 0.02 and rough by 0.008, as the standard errors say"
            ),
            "{doubt}"
        );
        assert!((found.errors[4] - 0.4 * 0.001f64.hypot(0.02)).abs() < 1e-9, "{:?}", found.errors);
        // That of another unit of light has values that fit it best too.
        let found = plastic([0.001; 5], [0.0; 5], (0, 1, 0.0), 179.0);
        assert!(found.standings.iter().all(|standing| *standing == Standing::Open), "{:?}", found.standings);
        assert!(found.doubts[0].starts_with("whole areas of the picture are 179 times brighter or darker"), "{}", found.doubts[0]);
        assert!(found.doubts[0].ends_with("; red, green, blue, spec and rough cannot be told by it"), "{}", found.doubts[0]);
    }

    #[test]
    fn no_filter_is_named_that_there_is_not() {
        let said = |more: f64| {
            let document = Document::parse(Source::new("m.rad", "void glass m 0 0 3 .6 .4 .2")).unwrap();
            let unknown = Unknown::new(document, &Wishes::default()).unwrap();
            let blur = Some(Blur { taken: 0.0, sought: false, more, error: 1e-3 });
            let covariance = Symmetric::of(3, |i, j| 1e-6 * f64::from(i == j));
            judge(&unknown, &[0.6, 0.4, 0.2], &Known { covariance, common: None, pressed: &[], misfit: Misfit::default(), blur })
                .doubts
                .remove(0)
        };
        assert!(said(1.0).contains("a filter of radius"), "{}", said(1.0));
        let far = said(1e6);
        assert!(far.contains("no filter blurs so much; the view, the shape or the light") && !far.contains("radius"), "{far}");
    }
}
