//! Broken bytes: pictures, OpenEXR files, meshes and octrees, states of a search.

use super::harness::{Case, Content};
use super::texts::{SCENE, nonsense, refused_as, unread, unread_in, used_as};
use inverad::picture::{Header, Picture};

const RTM: &[u8] = include_bytes!("../import/sheet.rtm");
const OCT: &[u8] = include_bytes!("../import/frozen.oct");
const PLAIN: &[u8] = include_bytes!("../import/plain.oct");

/// A picture with long runs and without.
fn picture() -> Picture {
    let mut picture = Picture::new(40, 12, Header::new("made")).unwrap();
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        let v = if i % 40 < 20 { 1.0 } else { (i * 37 % 101) as f32 / 50.0 };
        *pixel = [v, v * 0.5, v + 0.25];
    }
    picture
}

/// Cut at so many places, the last of them one byte before the end.
pub fn cuts(bytes: &[u8], count: usize) -> Vec<(String, Content)> {
    let at = (1..=count).map(|i| if i == count { bytes.len() - 1 } else { bytes.len() * i / count });
    at.map(|end| (format!("cut to {end} of {} bytes", bytes.len()), Content::from(&bytes[..end]))).collect()
}

/// The bytes with `to` in the place of the first `from`.
fn changed(bytes: &[u8], from: &[u8], to: &[u8]) -> Content {
    let at = bytes.windows(from.len()).position(|window| window == from).expect("is there");
    Content::Bytes([&bytes[..at], to, &bytes[at + from.len()..]].concat())
}

pub fn named(rows: Vec<(&str, Content)>) -> Vec<(String, Content)> {
    rows.into_iter().map(|(label, content)| (label.to_string(), content)).collect()
}

/// What these programs accept.
pub fn whole() -> Vec<Case> {
    let (hdr, exr) = (picture().write_hdr().unwrap(), picture().write_exr().unwrap());
    let case = |label: &str, line: &str, bytes: &[u8]| Case::new(label, line, "").with("good", &hdr[..]).with("bad", bytes);
    vec![
        case("picture", "imgdiff good bad", &hdr),
        case("mask", "imgdiff --mask bad good good", &hdr),
        case("exr", "imgdiff good bad", &exr),
        case("variance", "imgdiff --variance bad good good", &exr),
        used_as("hdr", "picture", &hdr[..], ""),
        used_as("mesh", "compiled mesh", RTM, ""),
        Case::new("state", "anneal propose bad", "").with("bad", &state()[..]),
    ]
}

pub fn pictures() -> Vec<Case> {
    let good = picture().write_hdr().unwrap();
    let text = |header: &str, pixels: &[u8]| Content::Bytes([header.as_bytes(), pixels].concat());
    let whole = |size: &str, pixels: &[u8]| text(&format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n"), pixels);
    let start = [2, 2, 0, 40];
    let mut broken = cuts(&good, 12);
    broken.extend(named(nonsense()));
    broken.extend(named(vec![
        ("another format", changed(&good, b"32-bit_rle_rgbe", b"ascii")),
        ("a spectral format", changed(&good, b"32-bit_rle_rgbe", b"Radiance_spectra")),
        ("no empty line", changed(&good, b"\n\n", b"\n")),
        ("an exposure of words", changed(&good, b"FORMAT", b"EXPOSURE=much\nFORMAT")),
        ("an exposure of 0", changed(&good, b"FORMAT", b"EXPOSURE=0\nFORMAT")),
        ("exposures beyond all numbers", changed(&good, b"FORMAT", b"EXPOSURE=1e200\nEXPOSURE=1e200\nFORMAT")),
        ("a negative exposure", changed(&good, b"FORMAT", b"EXPOSURE=-1\nFORMAT")),
        ("an exposure that is not a number", changed(&good, b"FORMAT", b"EXPOSURE=nan\nFORMAT")),
        ("a colour correction of two", changed(&good, b"FORMAT", b"COLORCORR=1 1\nFORMAT")),
        ("a header without an end", text(&format!("#?RADIANCE\n{}", "A=1\n".repeat(40_000)), &[])),
        ("no resolution", whole("", &[])),
        ("one axis", whole("-Y 12", &[])),
        ("the same axis twice", whole("-Y 12 +Y 40", &[])),
        ("axes without signs", whole("Y 12 X 40", &[])),
        ("no width", whole("-Y 12 +X 0", &[])),
        ("a negative width", whole("-Y 12 +X -40", &[])),
        ("a width of words", whole("-Y 12 +X wide", &[])),
        ("a huge width", whole("-Y 1 +X 4294967295", &start)),
        ("a huge size", whole("-Y 65536 +X 65536", &start)),
        ("a size beyond all numbers", whole("-Y 99999999999999999999 +X 2", &start)),
        ("a product beyond all numbers", whole("-Y 4294967296 +X 4294967296", &start)),
        ("the largest size, and nothing in it", whole("-Y 16384 +X 16384", &start)),
        ("a large size of one run", whole("-Y 16384 +X 16384", &[1, 1, 1, 255].repeat(40))),
        ("one long line", whole("-Y 1 +X 268435456", &[9, 9, 9, 128, 1, 1, 1, 255, 1, 1, 1, 255, 1, 1, 1, 255])),
        ("a run beyond the line", whole("-Y 1 +X 40", &[&start[..], &[255, 7]].concat())),
        ("a stretch beyond the line", whole("-Y 1 +X 40", &[&start[..], &[64], &[1; 64]].concat())),
        ("an empty stretch", whole("-Y 1 +X 40", &[&start[..], &[0; 200]].concat())),
        ("an old run with nothing before", whole("-Y 1 +X 4", &[1, 1, 1, 3, 9, 9, 9, 128])),
        ("old runs without an end", whole("-Y 1 +X 4", &[&[9, 9, 9, 128][..], &[1, 1, 1, 0].repeat(1000)].concat())),
        ("a line of another width", whole("-Y 1 +X 40", &[2, 2, 0, 41, 168, 1, 168, 1, 168, 1, 168, 1])),
    ]));
    let mut cases = Vec::new();
    for (label, content) in &broken {
        let case = |line: &str| Case::new(label.as_str(), line, "bad").with("good", &good[..]).with("bad", content.clone());
        cases.extend([case("imgdiff bad good"), case("imgdiff good bad"), case("imgdiff --mask bad good good")]);
        cases.extend(refused_as("hdr", label, content.clone(), "bad"));
        if let Content::Bytes(bytes) = content {
            cases.push(Case::new(label.as_str(), "imgdiff good", "<stdin>").with("good", &good[..]).reading(bytes));
        }
    }
    let mut other = picture();
    other.width = 12;
    other.height = 40;
    let other = other.write_hdr().unwrap();
    cases.push(Case::new("another size", "imgdiff good bad", "bad").with("good", &good[..]).with("bad", &other[..]));
    cases.push(Case::new("a mask of another size", "imgdiff --mask bad good good", "bad").with("good", &good[..]).with("bad", &other[..]));
    cases.extend(unread_in("hdr"));
    cases.extend(unread(&["imgdiff main.rad bad", "imgdiff bad main.rad"]).into_iter().map(|mut case| {
        case.files[0].1 = Content::from(&good[..]);
        case
    }));
    cases
}

pub fn exr() -> Vec<Case> {
    let good = picture().write_exr().unwrap();
    let magic = &good[..4];
    let mut broken = cuts(&good, 16);
    let noise: Vec<u8> = (0..4096u32).map(|i| (i.wrapping_mul(2654435761) >> 11) as u8).collect();
    // The two windows hold xMin yMin xMax yMax as little-endian integers.
    let corner = [39u32.to_le_bytes(), 11u32.to_le_bytes()].concat();
    let size = |x: i32, y: i32| changed(&good, &corner, &[x.to_le_bytes(), y.to_le_bytes()].concat());
    let windows = |x: i32, y: i32| {
        let Content::Bytes(once) = size(x, y) else { return size(x, y) };
        changed(&once, &corner, &[x.to_le_bytes(), y.to_le_bytes()].concat())
    };
    broken.extend(named(vec![
        ("nothing but the magic number", Content::from(magic)),
        ("noise after the magic number", Content::Bytes([magic, &noise].concat())),
        ("zeros after the magic number", Content::Bytes([magic, &[0; 4096]].concat())),
        ("version 77", Content::Bytes([magic, &[77, 0, 0, 0], &good[8..]].concat())),
        ("no channels", changed(&good, b"channels", b"shannels")),
        ("a channel less", changed(&good, b"\0B\0", b"\0Q\0")),
        (
            "an unknown compression",
            changed(&good, b"compression\0compression\0\x01\0\0\0\x03", b"compression\0compression\0\x01\0\0\0\x63"),
        ),
        ("windows of two sizes", size(79, 11)),
        ("a huge window", windows(i32::MAX - 1, i32::MAX - 1)),
        ("a wide window", windows(1 << 28, 0)),
        ("a large window with nothing in it", windows(16383, 16383)),
        ("a negative window", windows(-5, -5)),
        ("the least window", windows(i32::MIN, i32::MIN)),
        ("an attribute of 4 GB", changed(&good, b"compression\0compression\0\x01\0\0\0", b"compression\0compression\0\xff\xff\xff\xff")),
        ("an attribute of 2 GB", changed(&good, b"compression\0compression\0\x01\0\0\0", b"compression\0compression\0\xff\xff\xff\x7f")),
    ]));
    let flat = picture().write_hdr().unwrap();
    let mut cases = Vec::new();
    for (label, content) in &broken {
        let case = |line: &str| Case::new(label.as_str(), line, "bad").with("good", &flat[..]).with("bad", content.clone());
        cases.extend([case("imgdiff good bad"), case("imgdiff bad good"), case("imgdiff --variance bad good good")]);
    }
    cases
}

pub fn meshes() -> Vec<Case> {
    let mut broken = cuts(RTM, 16);
    broken.extend(named(nonsense().into_iter().filter(|(label, _)| label.contains("signature")).collect()));
    broken.extend(named(vec![
        ("another format", changed(RTM, b"Radiance_tmesh", b"Radiance_tmash")),
        ("an octree", Content::from(OCT)),
        ("another magic number", changed(RTM, b"\n\n\x01\x43", b"\n\n\x01\x7f")),
        ("object numbers of no width", changed(RTM, b"\n\n\x01\x43", b"\n\n\x01\x3f")),
        ("a size of words", changed(RTM, b"2.90002", b"big....")),
        ("a size that is not a number", changed(RTM, b"2.90002", b"nan\0\0\0\0")),
        ("a string without an end", changed(RTM, b"2.90002\0", &[b'1'; 5000])),
        ("cells without an end", changed(RTM, b"2.90002\0", &[&b"2.90002\0"[..], &[0; 20], &[2; 100_000]].concat())),
        ("a patch of parts unknown", last_patch(0, 0xff)),
        ("a patch without vertices", last_patch(0, 0)),
        ("a patch of too many vertices", last_patch(1, 0x7f)),
        ("a patch of negative vertices", last_patch(1, 0xff)),
    ]));
    let mut cases: Vec<Case> = broken.iter().flat_map(|(label, content)| refused_as("mesh", label, content.clone(), "bad")).collect();
    // What --check says of a file that is none at all.
    for (label, content) in nonsense().into_iter().filter(|(label, _)| !label.contains("signature")) {
        let main = Case::new(label, "rparse --check main.rad", "bad").with("bad", content).ending(1);
        cases.push(main.with("main.rad", format!("{SCENE}m instance b 1 ./bad 0 0\n").as_str()));
    }
    cases
}

/// The mesh with one byte of its first patch changed: flags, then the number of vertices.
fn last_patch(at: usize, to: u8) -> Content {
    // The number of patches and the first one's flags and count stand right after the scene, which ends with type −1.
    let patch = (0..RTM.len() - 7)
        .rev()
        .find(|&i| RTM[i] == 0xff && RTM[i + 1..i + 5] == [0, 0, 0, RTM[i + 4]] && RTM[i + 5] == 7)
        .expect("a patch");
    let mut bytes = RTM.to_vec();
    bytes[patch + 5 + at] = to;
    Content::Bytes(bytes)
}

pub fn octrees() -> Vec<Case> {
    let mut broken = cuts(OCT, 16);
    broken.extend(named(nonsense()));
    broken.extend(named(vec![
        ("another format", changed(OCT, b"Radiance_octree", b"Radiance_octrex")),
        ("a mesh", Content::from(RTM)),
        ("another magic number", changed(OCT, b"\n\n\x01\x1f", b"\n\n\x01\x7f")),
        ("an unknown type", changed(OCT, b"polygon\0", b"polyg\xfen\0")),
        ("scene files that are not there", Content::from(PLAIN)),
    ]));
    let place = |label: &str| if label.starts_with("scene files") { "scene.rad" } else { "bad" };
    broken.iter().flat_map(|(label, content)| refused_as("instance", label, content.clone(), place(label))).collect()
}

/// What `anneal propose` keeps of a search.
fn state() -> Vec<u8> {
    let directory = tempfile::tempdir().unwrap();
    let anneal = |words: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_anneal"));
        let output = command.args(words).current_dir(directory.path()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    std::fs::write(directory.path().join("start.rad"), SCENE).unwrap();
    anneal(&["propose", "s", "start.rad"]);
    for chi2 in ["4", "3", "5"] {
        anneal(&["tell", "s", chi2]);
        anneal(&["propose", "s"]);
    }
    std::fs::read(directory.path().join("s")).unwrap()
}

pub fn states() -> Vec<Case> {
    let good = state();
    let text = String::from_utf8(good.clone()).unwrap();
    let swap = |from: &str, to: &str| {
        assert!(text.contains(from), "{from} in {text}");
        Content::from(text.replacen(from, to, 1).as_str())
    };
    let mut broken = cuts(&good, 12);
    broken.extend(named(nonsense()));
    broken.extend(named(vec![
        ("brackets without an end", Content::Bytes(vec![b'['; 100_000])),
        ("objects without an end", Content::from("{\"a\":".repeat(50_000).as_str())),
        ("nothing in it", Content::from("{}")),
        ("a number", Content::from("7")),
        ("a start of words", swap("void plastic", "plain words")),
        ("another material", swap("void plastic", "void dielectric")),
        ("fewer numbers", swap("5 .5 .5 .5 0 0", "4 .5 .5 .5 0")),
        ("a number less", swap("5 .5 .5 .5 0 0", "5 .5 .5 .5 0")),
        ("trailing words", Content::from(format!("{text} x").as_str())),
        ("a negative count", swap("\"told\":3", "\"told\":-3")),
        ("more evaluations than there are", swap("\"told\":3", "\"told\":4")),
        ("huge counts", swap("\"told\":3", "\"told\":18446744073709551615")),
        ("counts beyond all numbers", swap("\"told\":3", "\"told\":99999999999999999999999")),
        ("a number beyond all numbers", swap("\"told\":3", "\"told\":1e999")),
    ]));
    let mut cases = Vec::new();
    for (label, content) in &broken {
        for line in ["anneal propose bad", "anneal tell bad 1", "anneal best bad", "anneal --exec echo~1 --state bad start.rad"] {
            cases.push(Case::new(label.as_str(), line, "bad").with("bad", content.clone()).with("start.rad", SCENE));
        }
    }
    cases
}
