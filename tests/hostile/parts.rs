//! Broken parts of pictures, rays, places of environments, files of options.

use super::bytes::{cuts, named};
use super::harness::{Case, Content};
use super::texts::{SCENE, SEE, nonsense, unread};
use inverad::picture::exr::{Plane, Planes, Samples};
use std::process::Command;

/// The part of a small picture with these samples.
fn part(samples: &str, width: &str) -> Vec<u8> {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(
        directory.path().join("main.rad"),
        SCENE.replace("m sphere", "void glow e 0 0 4 1 1 1 0\ne source sky 0 0 4 0 0 1 90\nm sphere"),
    )
    .unwrap();
    let words = ["-n", "1", "-vp", "0", "-5", "0", "-x", width, "-y", "4", "--samples", samples, "-o", "part.exr", "main.rad"];
    let status = Command::new(env!("CARGO_BIN_EXE_rtrace-rs")).args(words).current_dir(directory.path()).status().unwrap();
    assert!(status.success());
    std::fs::read(directory.path().join("part.exr")).unwrap()
}

/// A part whose planes are changed.
fn with(part: &[u8], change: impl Fn(&mut Planes)) -> Content {
    let mut planes = Planes::read(part, "part").unwrap();
    change(&mut planes);
    Content::Bytes(planes.write().unwrap())
}

/// What these programs accept.
pub fn whole() -> Vec<Case> {
    let (first, second) = (part("0..2", "4"), part("2..4", "4"));
    vec![
        Case::new("parts", "rtrace-rs --merge first bad", "").with("first", &first[..]).with("bad", &second[..]),
        Case::new("rays", "rtrace-rs -h main.rad", "").with("main.rad", SCENE).reading(b"0 -5 0 0 1 0\n"),
    ]
}

pub fn parts() -> Vec<Case> {
    let (first, second) = (part("0..2", "4"), part("2..4", "4"));
    let of = |planes: &mut Planes, name: &str, value: u32| {
        let found = planes.planes.iter_mut().find(|plane| plane.name == name).expect("is there");
        if let Samples::U32(values) = &mut found.samples {
            values.fill(value);
        }
    };
    let says = |planes: &mut Planes, range: &str| {
        let line = planes.header.lines.iter_mut().find(|line| line.starts_with("SAMPLES=")).expect("is there");
        *line = format!("SAMPLES= {range}");
    };
    let without = |planes: &mut Planes, name: &str| planes.planes.retain(|plane| plane.name != name);
    let mut broken = cuts(&second, 12);
    broken.extend(named(nonsense()));
    broken.extend(named(vec![
        (
            "an option that goes on with other letters",
            with(&second, |p| {
                let line = &mut p.header.lines[0];
                *line = line.replace("--samples ", "--samples\u{e9} ");
                says(p, "4");
            }),
        ),
        ("no samples", with(&second, |p| without(p, "samples"))),
        ("no surfaces", with(&second, |p| without(p, "surface"))),
        ("half of a sum", with(&second, |p| without(p, "sum0.00.R.low"))),
        (
            "samples of another kind",
            with(&second, |p| {
                without(p, "samples");
                p.planes.push(Plane::new("samples", vec![2.0; 16]));
            }),
        ),
        ("more samples than there are", with(&second, |p| of(p, "samples", u32::MAX))),
        ("a sum that is no number", with(&second, |p| of(p, "sum0.00.R.high", 0x7ff8_0000))),
        ("a sum without end", with(&second, |p| of(p, "sum0.00.R.high", 0x7ff0_0000))),
        ("a range of words", with(&second, |p| says(p, "some"))),
        ("a range backwards", with(&second, |p| says(p, "4..2"))),
        ("an empty range", with(&second, |p| says(p, "2..2"))),
        ("a range beyond all numbers", with(&second, |p| says(p, "2..99999999999999"))),
        ("a range that it does not hold", with(&second, |p| says(p, "2..9"))),
        ("no range", with(&second, |p| p.header.lines.retain(|line| !line.starts_with("SAMPLES=")))),
        ("another command", with(&second, |p| p.header.lines[0].push_str(" other.rad"))),
        ("another size", Content::Bytes(part("2..4", "5"))),
        ("the same samples", Content::Bytes(first.clone())),
    ]));
    let case = |label: &str, content: &Content| {
        Case::new(label, "rtrace-rs --merge first bad", "bad").with("first", &first[..]).with("bad", content.clone())
    };
    let mut cases: Vec<Case> = broken.iter().map(|(label, content)| case(label, content)).collect();
    cases.push(Case::new("a gap", "rtrace-rs --merge bad", "0..2").with("bad", &second[..]));
    cases.extend(unread(&["rtrace-rs --merge bad"]));
    cases
}

pub fn rays() -> Vec<Case> {
    let single = |numbers: &[f32]| numbers.iter().flat_map(|v| v.to_ne_bytes()).collect::<Vec<u8>>();
    let long = [b"0 0 0 0 1 ".to_vec(), vec![b'1'; 100_000]].concat();
    let rows: Vec<(&str, &str, Vec<u8>)> = vec![
        ("a word", "-h", b"0 -5 0 0 one 0".to_vec()),
        ("cut", "-h", b"0 -5 0 0".to_vec()),
        ("not a number", "-h", b"0 -5 0 nan 1 0".to_vec()),
        ("without end", "-h", b"0 inf 0 0 1 0".to_vec()),
        ("beyond all numbers", "-h", b"0 1e999 0 0 1 0".to_vec()),
        ("a long word", "-h", long),
        ("a line without an end", "-h", vec![b'x'; 1_000_000]),
        ("zero bytes", "-h", vec![0; 4096]),
        ("single precision, cut", "-h -ff", single(&[0.0, -5.0, 0.0, 0.0])),
        ("double precision, cut", "-h -fd", vec![0; 47]),
        ("single precision, not a number", "-h -ff", single(&[0.0, -5.0, 0.0, f32::NAN, 1.0, 0.0])),
        ("single precision, without end", "-h -ff", single(&[f32::INFINITY, -5.0, 0.0, 0.0, 1.0, 0.0])),
    ];
    let case = |(label, option, bytes): &(&str, &str, Vec<u8>)| {
        Case::new(*label, &format!("rtrace-rs {option} main.rad"), "<stdin>: ray 1").with("main.rad", SCENE).reading(bytes)
    };
    rows.iter().map(case).collect()
}

pub fn probes() -> Vec<Case> {
    let glow = "void glow e 0 0 4 1 1 1 0\ne source sky 0 0 4 0 0 1 360\n";
    ["", "0", "0 0 0", "0 0 0 e e", "x 0 0 e", "0 0 nan e", "0 0 inf e", "0 0 1e999 e", "0 0 0 none", "0 0 0 m", "0,0,0 e", "0 0 0 void"]
        .into_iter()
        .flat_map(|words| {
            [(SEE, 2), ("rparse --check", 1)].map(|(line, status)| {
                let case = Case::new(format!("#@probe {words}"), &format!("{line} bad"), "bad:12:1").ending(status);
                case.with("bad", format!("{SCENE}{glow}#@probe {words}\n").as_str())
            })
        })
        .collect()
}

pub fn options() -> Vec<Case> {
    let mut cases = Vec::new();
    for (label, content) in nonsense() {
        if label != "empty" {
            cases.push(Case::new(label, &format!("{SEE} @bad main.rad"), "").with("main.rad", SCENE).with("bad", content));
        }
    }
    for (label, text, place) in [
        ("an option that is none", "-ab 1 -zz", "-zz"),
        ("an option cut", "-av 1 1", "-av"),
        ("a value of words", "-ab many", "many"),
        ("another file", "@none", "none"),
        ("itself", "@bad", "bad"),
    ] {
        cases.push(Case::new(label, &format!("{SEE} @bad main.rad"), place).with("main.rad", SCENE).with("bad", text));
    }
    cases.extend(unread(&[&format!("{SEE} @bad main.rad")]));
    cases
}
