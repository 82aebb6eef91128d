//! What the fuzzers run: each function takes any bytes and must end soon, without a panic, and without a lie in what it answers.
//!
//! Shared by the libFuzzer targets of this folder and by `tests/fuzz.rs`, which replays the corpus.

// Each libFuzzer target uses one of these.
#![allow(dead_code)]

use inverad::accel::{Accel, Geometry, Surface};
use inverad::anneal::Annealer;
use inverad::args::{self, Typed};
use inverad::cal::{Library, Ray as Context};
use inverad::check::check;
use inverad::color::Rgb;
use inverad::error::{Error, Source};
use inverad::expand::{expand, expand_all_errors};
use inverad::geometry::Ray;
use inverad::import;
use inverad::integrator::{Integrator, Radiance};
use inverad::picture::{Picture, exr, exr::Planes, hdr};
use inverad::rad::{Document, decode};
use inverad::rays::{Form, Reader, is_still};
use inverad::render;
use inverad::resolve::Files;
use inverad::rules::Rules;
use inverad::sampling::Sampler;
use inverad::scene::{Reading, Scene};
use inverad::vector::{Affine, Vec3};
use inverad::view::View;
use inverad::world::World;
use std::sync::Arc;

/// A target by its name.
pub type Target = (&'static str, fn(&[u8]));

/// All of them.
pub const ALL: [Target; 13] = [
    ("hdr", hdr),
    ("exr", exr),
    ("rad", rad),
    ("cal", cal),
    ("rtm", rtm),
    ("oct", oct),
    ("obj", obj),
    ("view", view),
    ("state", state),
    ("arguments", arguments),
    ("rays", rays),
    ("parts", parts),
    ("scene", scene),
];

/// Pictures: what is written and read is written as the same again.
pub fn hdr(data: &[u8]) {
    // A few bytes may stand for a large picture of one colour; that is no finding, but takes its time.
    if let Ok(picture) = hdr::read(data, "a.hdr")
        && picture.pixels.len() < 1 << 20
    {
        // Mantissas that are all below 128 are scaled up the first time.
        let bytes = picture.write_hdr().expect("what was read can be written");
        let again = Picture::read(&bytes, "b.hdr").expect("what was written can be read");
        assert_eq!(again.write_hdr().expect("what was read can be written"), bytes);
        assert_eq!(again.header.exposure(), picture.header.exposure());
        assert!(picture.into_radiance().pixels.iter().flatten().all(|v| !v.is_nan()));
    }
}

/// OpenEXR files.
pub fn exr(data: &[u8]) {
    let bytes = [&exr::MAGIC, data].concat();
    if let Ok(picture) = Picture::read(&bytes, "a.exr")
        && picture.pixels.len() < 1 << 16
    {
        let again = Picture::read(&picture.write_exr().expect("can be written"), "b.exr").expect("can be read");
        let bits = |p: &Picture| p.pixels.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&again), bits(&picture));
    }
}

/// Scene descriptions: kept byte for byte; what is printed flat stays as it is.
pub fn rad(data: &[u8]) {
    let source = || Source::new("a.rad", decode(data.to_vec()));
    let (document, errors) = Document::parse_all_errors(source());
    shown(&errors);
    assert_eq!(document.bytes(), data);
    let files = Files::of([("b.rad", &b"void plastic m 0 0 5 1 1 1 0 0\nm sphere s 0 0 4 0 0 0 1\n"[..]), ("a.rad", data)]);
    let (flat, errors) = expand_all_errors(vec![document], &files);
    shown(&errors);
    shown(&check(&flat, &files).errors);
    if errors.is_empty() && flat.primitives.len() < 10_000 {
        let text = flat.to_string();
        let again = Document::parse(Source::new("b.rad", text.clone())).expect("what is printed can be read");
        assert_eq!(expand(vec![again], &files).expect("can be read").to_string(), text);
    }
}

/// Function files: evaluated at a few places.
pub fn cal(data: &[u8]) {
    let files = Files::of([("a.cal", data)]);
    let mut library = Library::new();
    let file = match library.load("a.cal", &files) {
        Ok(file) => file,
        Err(error) => return shown(&[error]),
    };
    for (name, arguments) in [("f", &[0.5][..]), ("g", &[]), ("x", &[1.0, 2.0])] {
        match library.compile(file, &[(name, None)], arguments) {
            Ok(program) => {
                for at in [Vec3::ZERO, Vec3::new(0.3, -1.5, 1e6)] {
                    let context = Context::new(Vec3::Z, -Vec3::Z, at);
                    let _ = program.eval(&context.context());
                }
            }
            Err(error) => shown(&[error]),
        }
    }
}

/// Compiled meshes: rays through what is read.
pub fn rtm(data: &[u8]) {
    mesh([b"#?RADIANCE\n", data].concat());
}

/// Wavefront meshes.
pub fn obj(data: &[u8]) {
    mesh(data.to_vec());
}

fn mesh(bytes: Vec<u8>) {
    match import::mesh(bytes, "a") {
        Err(error) => shown(&[error]),
        Ok(file) => {
            assert!(file.mesh.positions.iter().all(|p| p.is_finite()), "a vertex is not finite");
            let count = file.mesh.positions.len() as u32;
            assert!(file.mesh.triangles.iter().flatten().all(|&v| v < count), "a triangle without vertex");
            assert!((0..file.mesh.triangles.len() as u32).all(|t| (file.mesh.material(t) as usize) < file.materials.len()));
            if let Ok(accel) = Accel::build(vec![Surface::from(Geometry::Mesh(Arc::new(file.mesh), Affine::IDENTITY))]) {
                for direction in [Vec3::X, Vec3::new(-0.6, 0.0, 0.8)] {
                    if let Some(hit) = accel.nearest(&Ray { origin: Vec3::new(-5.0, 0.1, 0.2), direction }, 0.0, f64::INFINITY) {
                        assert!(hit.t.is_finite() && hit.point.is_finite() && !hit.normal.is_nan());
                    }
                }
            }
        }
    }
}

/// Octrees.
pub fn oct(data: &[u8]) {
    match import::octree(&[b"#?RADIANCE\n", data].concat(), "a.oct") {
        Err(error) => shown(&[error]),
        Ok(import::Octree::Files(_)) => {}
        Ok(import::Octree::Scene(document)) => shown(&expand_all_errors(vec![document], &Files::default()).1),
    }
}

/// Views: one that can be used is written and read as the same, and its rays are rays.
pub fn view(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let mut view = View::default();
    let words: Vec<String> = text.split_whitespace().map(str::to_string).collect();
    let _ = view.apply(&words, &|_| Ok(data.to_vec()));
    view.apply_header(text.lines());
    match view.ready() {
        Err(error) => shown(&[error]),
        Ok(camera) => {
            let line = view.header_line();
            let mut again = View::default();
            assert!(again.apply_header([line.as_str()]) && again.header_line() == line, "{line}");
            let (width, height) = camera.resolution(512, 512, 1.0);
            assert!((1..=512).contains(&width) && (1..=512).contains(&height), "{width} × {height} of {line}");
            for (x, y) in [(0.5, 0.5), (0.0, 1.0), (0.9, 0.1)] {
                if let Some((_, direction, limit)) = camera.ray(x, y) {
                    assert!((direction.length() - 1.0).abs() < 1e-6 && !limit.is_nan(), "{direction:?} {limit} of {line}");
                }
            }
        }
    }
}

/// States of a search: one that is taken up can go on.
pub fn state(data: &[u8]) {
    let Ok(mut annealer) = serde_json::from_slice::<Annealer>(data) else { return };
    if !annealer.is_consistent() {
        return;
    }
    for step in 0..20 {
        let Some(values) = annealer.propose().map(<[f64]>::to_vec) else { break };
        let inside = annealer.parameters().iter().zip(&values).all(|(p, v)| (p.low..=p.high).contains(v));
        assert!(inside && values.len() == annealer.parameters().len(), "{values:?}");
        annealer.tell(values.iter().map(|v| v * v).sum::<f64>() + f64::from(step % 3));
    }
    let _ = (annealer.best(), annealer.standard_errors(), annealer.end(), annealer.is_flat());
    let text = serde_json::to_vec(&annealer).expect("can be kept");
    assert!(serde_json::from_slice::<Annealer>(&text).expect("can be taken up").is_consistent());
}

/// Arguments: the first byte chooses the program, lines are words.
pub fn arguments(data: &[u8]) {
    let Some((&program, text)) = data.split_first() else { return };
    let text = String::from_utf8_lossy(text);
    let words = || ["program"].into_iter().chain(text.lines()).map(Into::into).collect();
    let read = |name: &str| if name == "loop" { Ok(text.to_string()) } else { Err(Error::new(format!("{name}: no such file"))) };
    fn judge<A>(typed: Result<Typed<A>, Error>) -> Option<A> {
        match typed {
            Ok(Typed::Run(arguments, _)) => Some(arguments),
            Ok(Typed::Print(_)) => None,
            Err(error) => {
                shown(&[error]);
                None
            }
        }
    }
    match program % 4 {
        0 => drop(judge(args::parse::<args::rparse::Args>(words(), &read))),
        1 => drop(judge(args::parse::<args::imgdiff::Args>(words(), &read)).map(|a| a.metrics())),
        2 => drop(judge(args::parse::<args::anneal::Arguments>(words(), &read)).map(|a| (a.job(), a.options(), a.wishes()))),
        _ => drop(judge(args::parse::<args::rtrace::Arguments>(words(), &read)).map(|a| {
            let none = |name: &str| Err(Error::new(format!("{name}: no such file")));
            (a.accuracy.budget(), a.light.rules(&none))
        })),
    }
}

/// Rays on standard input: the first byte chooses their form.
pub fn rays(data: &[u8]) {
    let Some((&form, stream)) = data.split_first() else { return };
    let mut reader = Reader::new(stream, [Form::Ascii, Form::Single, Form::Double][form as usize % 3]);
    let mut rays = Vec::new();
    loop {
        if let Err(error) = reader.read(&mut rays, 3) {
            return shown(&[error]);
        }
        let Some((_, before)) = rays.split_last() else { return };
        assert!(rays.len() <= 3 && !before.iter().any(is_still) && rays.iter().flatten().all(|v| v.is_finite()), "{rays:?}");
        rays.clear();
    }
}

/// Parts of a rendering, joined: what they give is as large as they say.
pub fn parts(data: &[u8]) {
    let part = Planes::read(&[&exr::MAGIC, data].concat(), "a.exr").map(|planes| ("a.exr".to_string(), planes));
    match render::join([part].into_iter()) {
        Ok((width, height, _, rendering)) => assert_eq!(rendering.pixels.len(), width * height),
        Err(error) => shown(&[error]),
    }
}

/// Whole scenes with the files they need: the light along a few rays is a light. A line `%% NAME` begins another file.
pub fn scene(data: &[u8]) {
    let mut parts = split(data);
    let text = parts.remove(0).1;
    let files = Files(parts.into_iter().map(|(name, bytes)| (name, bytes.to_vec())).collect());
    let found = Document::read("a.rad", text.to_vec()).and_then(|document| expand(vec![document], &files));
    let flat = match found {
        Ok(flat) if flat.primitives.len() < 1000 => flat,
        Ok(_) => return,
        Err(error) => return shown(&[error]),
    };
    let rules = Rules { ambient_bounces: 2, ..Rules::default() };
    let world = match Scene::new(&flat, &files, &Reading::default()).and_then(|scene| World::new(scene, &rules)) {
        Ok(world) => world,
        Err(error) => return shown(&[error]),
    };
    let mut integrator = Integrator::new(&world, &rules);
    for (number, direction) in [Vec3::Y, Vec3::new(0.05, 1.0, -0.1).normalize()].into_iter().enumerate() {
        for sample in 0..2 {
            let mut light = Radiance { rules: &rules, sum: Rgb::ZERO };
            let sampler = Sampler::new(0, number as u64, 0, sample);
            integrator.trace(&mut light, Ray { origin: Vec3::new(0.0, -5.0, 0.0), direction }, f64::INFINITY, sampler);
            assert!(!light.sum.is_nan(), "{:?}", light.sum);
        }
    }
}

/// The text before the first line `%% NAME`, and the files after it.
fn split(data: &[u8]) -> Vec<(String, &[u8])> {
    let mut parts = Vec::new();
    let (mut name, mut rest) = (String::new(), data);
    while let Some(at) = rest.windows(4).position(|window| window == b"\n%% ") {
        parts.push((name, &rest[..at + 1]));
        let line = &rest[at + 4..];
        let end = line.iter().position(|&b| b == b'\n').unwrap_or(line.len());
        name = String::from_utf8_lossy(&line[..end]).into_owned();
        rest = &line[(end + 1).min(line.len())..];
    }
    parts.push((name, rest));
    parts
}

/// Messages are one line, or one with its place shown below, and of a length to read.
fn shown(errors: &[Error]) {
    for error in errors {
        let text = error.to_string();
        assert!(text.lines().count() <= 3 && text.len() < 10_000 && text.contains("error: "), "{text}");
    }
}
