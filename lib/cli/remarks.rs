//! What the file of a picture says of itself that does not go with what was typed.

use crate::args::rtrace::Light;
use crate::picture::{Format, PRIMARIES, Picture};
use crate::rad::Number;
use crate::render::Film;
use crate::rules::rendered::{otherwise, reduced, shortcuts};
use crate::unknown::Unknown;
use crate::view::View;

/// The shape of pixels is told to so much, and colours in terms of CIE (x, y): sRGB's primaries differ by .01 from RADIANCE's.
const SHAPE: f64 = 0.01;
const COLORS: f64 = 0.02;

/// What is to be said of a picture that says that it was taken from elsewhere.
pub fn elsewhere(name: &str, own: &View, asked: &View) -> Option<String> {
    let remark =
        || format!("{name} says that it was taken from elsewhere ({}): leave out -vf and the like for that view", own.header_line());
    (!own.is_like(asked)).then(remark)
}

/// What is to be said of a picture on a film.
pub fn remarks(name: &str, target: &Picture, film: &Film) -> Vec<String> {
    [misshapen(name, target, film), coloured(name, target), cut_off(target, film)].into_iter().flatten().collect()
}

/// What is to be said of a picture that RADIANCE rendered, as its header says, of a scene with so many lamps.
pub fn of_rendering(target: &Picture, unknown: &Unknown, typed: &Light, lamps: usize) -> Vec<String> {
    let spec = unknown.material().type_of().and_then(|t| t.parameter("spec")).filter(|_| typed.st.or(typed.ss).is_none());
    let least = spec.map(|spec| {
        let lowest: Vec<f64> = unknown.bounds().iter().map(|bound| bound.0).collect();
        unknown.reals(&lowest)[spec]
    });
    let lines = || target.header.trail();
    let chosen = [&typed.ae, &typed.ai, &typed.ae_files, &typed.ai_files].iter().any(|names| !names.is_empty());
    otherwise(lines(), chosen).into_iter().chain(shortcuts(lines(), least, lamps)).collect()
}

/// Of pixels that are not of the shape that the header says, by more than rounding rows or columns makes.
fn misshapen(name: &str, target: &Picture, film: &Film) -> Option<String> {
    let (said, seen) = (target.header.pixel_aspect(), film.camera.pixel_aspect(target.width, target.height));
    let rounded = 1.0 / target.width.min(target.height) as f64;
    let off = (seen / said).ln().abs() > SHAPE.max(rounded);
    off.then(|| {
        let seen = Number::rounded(seen, 3);
        format!(
            "{name} is {} x {} pixels, each {seen} times as high as wide by this view: if they are square, -vh or -vv is another, \
             or the picture was cropped (-vs, -vl); if not, a line PIXASPECT={seen} in its header says so",
            target.width, target.height
        )
    })
}

/// Of a rendering that pfilt made smaller by a number of times that its rows or columns are no multiple of: it leaves some out, and the others are not
/// where they seem to be.
fn cut_off(target: &Picture, film: &Film) -> Option<String> {
    let ([x, y, aspect], times) = reduced(target.header.trail())?;
    let (width, height) = film.camera.resolution(x as usize, y as usize, aspect);
    let left = [("columns", width, target.width), ("rows", height, target.height)].into_iter().find(|(_, from, to)| {
        let over = from.abs_diff(to.saturating_mul(times));
        over > 0 && over < times
    });
    left.map(|(what, from, to)| {
        format!(
            "the target was rendered with {from} {what}, which pfilt made {to} of, {times} of each: the picture is shifted by up to a part of a pixel, \
             which sharp edges tell; render it with a multiple of {times} of them"
        )
    })
}

/// Of colours that are mixed of other primaries than RADIANCE's.
fn coloured(name: &str, target: &Picture) -> Option<String> {
    let far = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) > COLORS;
    // Those of CIE XYZ are known.
    let own = target.header.primaries().filter(|_| target.header.format == Format::Rgb);
    let other = own.is_some_and(|own| own[..3].iter().zip(&PRIMARIES[..3]).any(far));
    other.then(|| {
        format!("{name} has other PRIMARIES than RADIANCE's, and is taken as it is: what is found is in its colours, if those of the light are too")
    })
}
