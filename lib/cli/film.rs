//! What a program makes of a rendering: a picture file, and beside it variance and other pictures of the same pixels.

use super::stream::input;
use super::{Outcome, Output};
use crate::args::rtrace::{Arguments, ends_in};
use crate::color::{WHITE_EFFICACY, of_pixel, to_pixel};
use crate::error::{Error, Result};
use crate::picture::exr::{Plane, Planes};
use crate::picture::{Format, Header, Picture, rgb_to_xyz};
use crate::render::{self, Features, Film, Rendering};
use crate::vector::Vec3;
use crate::view::View;
use std::path::Path;

/// The header of what `command` makes of a view.
pub fn header(command: &str, view: &View, film: &Film) -> Header {
    let mut header = Header::new(command);
    header.push(&view.header_line());
    let aspect = film.camera.pixel_aspect(film.width, film.height);
    if !(0.995..=1.005).contains(&aspect) {
        header.push(&format!("PIXASPECT= {aspect:.6}"));
    }
    header
}

/// A picture of these values, so wide and so high.
pub fn picture((width, height): (usize, usize), header: Header, values: impl Iterator<Item = Vec3>) -> Picture {
    Picture { width, height, header, pixels: values.map(to_pixel).collect() }
}

/// The same picture in CIE XYZ, Y in cd/m².
fn in_xyz(mut picture: Picture) -> Picture {
    let matrix = rgb_to_xyz() * WHITE_EFFICACY;
    picture.pixels.iter_mut().for_each(|pixel| *pixel = to_pixel(matrix * of_pixel(*pixel)));
    picture.header.lines.retain(|line| !line.starts_with("PRIMARIES="));
    picture.header.format = Format::Xyz;
    picture
}

/// Writes a picture: OpenEXR if that is wanted or the name ends so, PNG if it ends so, else RADIANCE's.
pub fn write(picture: &Picture, path: Option<&Path>, exr: bool) -> Outcome<()> {
    let ends = |extension: &str| path.is_some_and(|path| ends_in(path, &[extension]));
    let bytes = if exr || ends("exr") {
        picture.write_exr()
    } else if ends("png") {
        picture.write_png()
    } else {
        picture.write_hdr()
    };
    Output::whole(path, &bytes?)
}

/// How far a rendering is, in words.
pub fn reached(rendering: &Rendering) -> String {
    let noise = Some(100.0 * rendering.noise()).filter(|noise| noise.is_finite());
    let error = noise.map_or("not known yet".into(), |noise| format!("{noise:.2} %"));
    let samples = rendering.samples().round();
    format!("{samples} sample{} a pixel, error {error}", if samples == 1.0 { "" } else { "s" })
}

/// Writes a finished rendering, and its variance where that is asked for.
pub fn finish(arguments: &Arguments, size: (usize, usize), mut header: Header, rendering: &Rendering) -> Outcome<()> {
    if rendering.noise().is_finite() {
        header.push(&format!("NOISE= {:.6}", rendering.noise()));
    }
    let options = &arguments.picture;
    if let Some(path) = &options.variance {
        let variances = rendering.variances(size.0).into_iter().map(to_pixel);
        let mut planes = empty(size, &header);
        planes.push_picture("variance", &variances.collect::<Vec<_>>());
        Output::whole(Some(path), &planes.write()?)?;
    }
    let picture = picture(size, header, rendering.pixels.iter().map(|p| p.mean()));
    write(&if options.xyz { in_xyz(picture) } else { picture }, arguments.common.output.as_deref(), options.exr)
}

/// Joins the parts that are named, and writes the whole.
pub fn merge(arguments: &Arguments) -> Outcome<()> {
    let named = arguments.scenes();
    let parts = named.iter().map(|name| {
        let (name, bytes) = input(name)?;
        let planes = Planes::read(&bytes, &name)?;
        Ok((name, planes))
    });
    let (width, height, header, rendering) = render::join(parts)?;
    finish(arguments, (width, height), header, &rendering)
}

/// A file of depths, as rpict -z writes it: a number of 4 bytes for each pixel.
pub fn depths(lengths: &[f64]) -> Vec<u8> {
    lengths.iter().flat_map(|&v| (v as f32).to_ne_bytes()).collect()
}

/// Other pictures of the same pixels that can be kept.
const AOVS: [&str; 5] = ["normal", "depth", "albedo", "direct", "indirect"];

/// The names of other pictures in a list with commas.
pub fn aovs(list: &str) -> Result<Vec<&'static str>> {
    let mut names = Vec::new();
    for name in list.split(',') {
        let known = AOVS.into_iter().find(|known| *known == name.trim());
        match known {
            Some(known) if names.contains(&known) => {
                return Err(Error::new(format!("--aov {list}: `{known}` is there twice; name it once")));
            }
            Some(known) => names.push(known),
            None => return Err(Error::new(format!("--aov {list}: there is no `{name}`; name some of {}", AOVS.join(",")))),
        }
    }
    Ok(names)
}

/// Those pictures, as planes.
pub fn features(film: &Film, header: &Header, names: &[&str], features: &[Features]) -> Result<Vec<u8>> {
    let mut planes = empty((film.width, film.height), header);
    let mut color = |name: &str, of: fn(&Features) -> Vec3| {
        let values: Vec<[f32; 3]> = features.iter().map(|f| to_pixel(of(f))).collect();
        planes.push_picture(name, &values);
    };
    for &name in names {
        match name {
            "albedo" => color(name, |f| f.albedo),
            "direct" => color(name, |f| f.direct),
            "indirect" => color(name, |f| f.indirect),
            _ => {}
        }
    }
    if names.contains(&"normal") {
        for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
            planes.planes.push(Plane::new(&format!("normal.{letter}"), features.iter().map(|f| f.normal[axis] as f32).collect()));
        }
    }
    if names.contains(&"depth") {
        planes.planes.push(Plane::new("depth.Z", features.iter().map(|f| f.depth as f32).collect()));
    }
    planes.write()
}

fn empty((width, height): (usize, usize), header: &Header) -> Planes {
    Planes { width, height, header: header.clone(), planes: Vec::new() }
}
