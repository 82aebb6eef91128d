//! RADIANCE's picture format: identities over all bytes, bytes that RADIANCE wrote, and RADIANCE itself where it is installed.

use crate::skipped::skipped;
use inverad::picture::hdr::{Rgbe, decode, encode};
use inverad::picture::{Format, Header, Picture};
use proptest::prelude::*;
use std::io::Write;
use std::process::{Command, Stdio};

/// The orientations, each with the places (x from the left, y from the bottom) of its six pixels in the order of the file.
/// Recorded: `pvalue -h -H -b` on a picture of 3 × 2 pixels with that resolution line, RADIANCE 6.0a.
const ORIENTATIONS: [(&str, [(usize, usize); 6]); 8] = [
    ("-Y 2 +X 3", [(0, 1), (1, 1), (2, 1), (0, 0), (1, 0), (2, 0)]),
    ("-Y 2 -X 3", [(2, 1), (1, 1), (0, 1), (2, 0), (1, 0), (0, 0)]),
    ("+Y 2 +X 3", [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)]),
    ("+Y 2 -X 3", [(2, 0), (1, 0), (0, 0), (2, 1), (1, 1), (0, 1)]),
    ("+X 3 -Y 2", [(0, 1), (0, 0), (1, 1), (1, 0), (2, 1), (2, 0)]),
    ("-X 3 -Y 2", [(2, 1), (2, 0), (1, 1), (1, 0), (0, 1), (0, 0)]),
    ("+X 3 +Y 2", [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)]),
    ("-X 3 +Y 2", [(2, 0), (2, 1), (1, 0), (1, 1), (0, 0), (0, 1)]),
];

fn file(header: &str, resolution: &str, data: &[u8]) -> Vec<u8> {
    [format!("#?RADIANCE\n{header}\n{resolution}\n").as_bytes(), data].concat()
}

fn read(bytes: &[u8]) -> Picture {
    Picture::read(bytes, "test.hdr").unwrap()
}

fn error(bytes: &[u8]) -> String {
    Picture::read(bytes, "test.hdr").unwrap_err().message
}

fn picture(width: usize, pixels: &[Rgbe]) -> Picture {
    let pixels: Vec<_> = pixels.iter().map(|&p| decode(p)).collect();
    Picture { width, height: pixels.len() / width, header: Header::default(), pixels }
}

#[test]
fn pixels_decode_with_half_a_step_and_encode_cut_off() {
    // (1, .5, .25) is stored as 128 64 32 129 by `pvalue -r`, RADIANCE 6.0a; the values are (m + .5) 2^(e - 136).
    assert_eq!(encode([1.0, 0.5, 0.25]), Some([128, 64, 32, 129]));
    assert_eq!(decode([128, 64, 32, 129]), [257.0 / 256.0, 129.0 / 256.0, 65.0 / 256.0]);
    // `pvalue -d` prints 1.378e-40 for a pixel 1 1 1 3.
    assert_eq!(decode([1, 1, 1, 3]), [1.5 * 2f32.powi(-133); 3]);
    assert_eq!(decode([255, 0, 0, 255])[0], 255.5 * 2f32.powi(119));
    assert_eq!(decode([255, 255, 255, 0]), [0.0; 3]);
    assert_eq!(encode([1e-32, -1.0, 0.0]), Some([0; 4]));
    assert_eq!(encode([-1.0, 2.0, f32::NEG_INFINITY]), Some([0, 128, 0, 130]));
    assert_eq!(encode([f32::NAN, 1.0, 1.0]), None);
    assert_eq!(encode([f32::INFINITY, 1.0, 1.0]), None);
}

#[test]
fn steps_lie_between_the_values_that_can_be_stored() {
    let mut picture = picture(3, &[[128, 64, 32, 129], [200, 0, 3, 120], [0; 4]]);
    let next = decode([129, 65, 33, 129])[0] - decode([128, 64, 32, 129])[0];
    assert_eq!(picture.steps(), [[next; 3], [2f32.powi(-16); 3], [0.0; 3]]);
    picture.header.push("EXPOSURE=4");
    picture.header.push("COLORCORR=1 2 .5");
    assert_eq!(picture.steps()[0], [next / 4.0, next / 8.0, next / 2.0]);
    picture.pixels[0][1] = 0.3;
    assert_eq!(picture.steps()[0], [0.0; 3]);
    picture.header.format = Format::Xyz;
    assert_eq!(picture.steps(), [[0.0; 3]; 3]);
}

#[test]
fn every_pixel_that_radiance_writes_survives() {
    // Its largest mantissa is at least 128; values to 1e-32, all below 2^-106, are cut to black.
    for e in 23..=255 {
        for m in 0..=255 {
            for pixel in [[m.max(128), m, 0, e], [m, 255, m / 2, e], [1, m, 128.max(m), e], [127.min(m), 0, 128, e]] {
                assert_eq!(encode(decode(pixel)), Some(pixel), "{pixel:?}");
            }
        }
    }
}

#[test]
fn every_pixel_of_all_is_what_it_is_after_one_writing() {
    // All exponents with all mantissas in each channel, beside others: in memory, and in files of either colour space.
    let all = |rest: u8| {
        (0..=255u8).flat_map(move |e| (0..=255u8).flat_map(move |m| [[m, rest, rest, e], [rest, m, rest, e], [rest, rest, m, e]]))
    };
    for rest in [0, 1, 127, 128, 255] {
        for pixel in all(rest) {
            let value = decode(pixel);
            let written = encode(value).unwrap();
            // As it was, if RADIANCE writes such; else scaled up, and off by no more than a step; what is at most 1e-32 is black.
            let largest = pixel[0].max(pixel[1]).max(pixel[2]);
            if largest >= 128 && pixel[3] >= 23 {
                assert_eq!(written, pixel);
            } else if value.iter().all(|&v| v <= 1e-32) {
                assert_eq!(written, [0; 4]);
            }
            let again = decode(written);
            assert_eq!(encode(again), Some(written), "{pixel:?}");
            let step = (pixel[3] as f32 - 136.0).exp2();
            assert!(written == [0; 4] || again.iter().zip(value).all(|(a, v)| (a - v).abs() <= step), "{pixel:?}: {value:?}, {again:?}");
        }
        for format in ["rgbe", "xyze"] {
            let pixels: Vec<u8> = all(rest).filter(|&p| encode(decode(p)) == Some(p)).flatten().collect();
            let resolution = format!("-Y 1 +X {}", pixels.len() / 4);
            let bytes = file(&format!("FORMAT=32-bit_rle_{format}\n"), &resolution, &pixels);
            let picture = read(&bytes);
            assert_eq!(picture.header.format == Format::Xyz, format == "xyze");
            assert!(picture.pixels.iter().zip(pixels.chunks_exact(4)).all(|(v, p)| *v == decode([p[0], p[1], p[2], p[3]])));
            assert!(read(&picture.write_hdr().unwrap()) == picture);
        }
    }
}

#[test]
fn a_line_is_encoded_as_radiance_encodes_it() {
    // Recorded: `pvalue -r -df -h -y 1 +x 24` of RADIANCE 6.0a on these values (red has runs of 2, 3, 5 and 3 equal bytes).
    let red = [128, 128, 130, 131, 132, 133, 133, 133, 134, 134, 134, 134, 134, 140, 141, 142, 142, 143, 143, 143, 150, 151, 151, 151];
    let line: Vec<Rgbe> = red.iter().enumerate().map(|(x, &r)| [r, 64, 128 + x as u8, 129]).collect();
    let recorded = [
        0x02, 0x02, 0x00, 0x18, 0x08, 0x80, 0x80, 0x82, 0x83, 0x84, 0x85, 0x85, 0x85, 0x85, 0x86, 0x0b, 0x8c, 0x8d, 0x8e, 0x8e, 0x8f, 0x8f,
        0x8f, 0x96, 0x97, 0x97, 0x97, 0x98, 0x40, 0x18, 0x80, 0x81, 0x82, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88, 0x89, 0x8a, 0x8b, 0x8c, 0x8d,
        0x8e, 0x8f, 0x90, 0x91, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x81,
    ];
    let bytes = picture(24, &line).write_hdr().unwrap();
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y        1 +X       24\n";
    assert_eq!(bytes, [header.as_slice(), &recorded].concat());
}

#[test]
fn all_eight_orientations_mean_what_radiance_means() {
    for (resolution, places) in ORIENTATIONS {
        let data: Vec<u8> = (0..6).flat_map(|i| [128 + i, 0, 0, 129]).collect();
        let picture = read(&file("FORMAT=32-bit_rle_rgbe\n", resolution, &data));
        assert_eq!((picture.width, picture.height), (3, 2));
        for (i, (x, y)) in places.into_iter().enumerate() {
            assert_eq!(picture.at(x, 1 - y), decode([128 + i as u8, 0, 0, 129]), "{resolution}");
        }
    }
}

#[test]
fn old_runs_repeat_the_pixel_before_them() {
    // 3 and then 1 · 256 repeats: `pvalue -h -H -d` of RADIANCE 6.0a prints 260 equal pixels and one other.
    let old = read(&file("", "-Y 1 +X 261", &[200, 100, 50, 130, 1, 1, 1, 3, 1, 1, 1, 1, 9, 200, 9, 130]));
    assert!(old.pixels[..260].iter().all(|&p| p == decode([200, 100, 50, 130])) && old.pixels[260] == decode([9, 200, 9, 130]));
    // The first pixel of a line is never a repeat (`pvalue` prints 1.378e-40 for it).
    let first = read(&file("", "-Y 1 +X 2", &[1, 1, 1, 3, 200, 100, 50, 130]));
    assert_eq!(first.pixels[0], decode([1, 1, 1, 3]));
    // Repeats beyond the end of the line are dropped.
    assert_eq!(read(&file("", "-Y 1 +X 3", &[200, 100, 50, 130, 1, 1, 1, 255])).pixels[2], decode([200, 100, 50, 130]));
    assert!(
        error(&file("", "-Y 1 +X 9", &[9, 200, 9, 130, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0, 1, 1, 1, 0]))
            .contains("repeat counts")
    );
}

#[test]
fn headers_are_kept_and_understood() {
    let bytes =
        file("rpict -vp 0 0 0 x.oct\r\nEXPOSURE=2\n\tEXPOSURE=100\nFORMAT= 32-bit_rle_xyze\r\n\r", "-Y 1 +X 1\r", &[128, 128, 128, 129]);
    let picture = read(&bytes);
    assert_eq!(picture.header.lines, ["rpict -vp 0 0 0 x.oct", "EXPOSURE=2", "\tEXPOSURE=100"]);
    assert_eq!((picture.header.format, picture.header.exposure()), (Format::Xyz, 2.0));
    assert_eq!(read(&picture.write_hdr().unwrap()), picture);
    // No first line #?…, no format: what old programs wrote.
    assert_eq!(read(b"rpict\n\n-Y 1 +X 1\n\x80\x80\x80\x81").header.lines, ["rpict"]);
}

#[test]
fn what_is_no_picture_is_refused_with_a_reason() {
    let pixel = [128, 128, 128, 129];
    assert_eq!(error(b""), "test.hdr: the file is empty");
    assert!(
        error(b"\x89PNG\r\n\x1a\n").starts_with("test.hdr: a PNG file is made for the eye and holds no radiance; give a RADIANCE picture")
    );
    assert_eq!(error(b"\x89NIX\r\n"), "test.hdr: neither a RADIANCE picture nor OpenEXR");
    assert_eq!(error(b"PF\n1 1\n-1.0\n"), "test.hdr: a PFM file is not read; make a RADIANCE picture or OpenEXR of it");
    assert_eq!(error(b"#?RADIANCE\nFORMAT="), "test.hdr: the file ends in its header; is it a RADIANCE picture?");
    assert_eq!(error(&[b'a'; 1 << 17]), "test.hdr: no end of the header within 64 KiB; is it a RADIANCE picture?");
    assert!(error(&file("FORMAT=Radiance_spectra\n", "-Y 1 +X 1", &pixel)).contains("spectral"));
    assert!(error(&file("FORMAT=float\n", "-Y 1 +X 1", &pixel)).contains("FORMAT=float"));
    assert!(error(&file("EXPOSURE=0\n", "-Y 1 +X 1", &pixel)).contains("EXPOSURE=0"));
    assert!(error(&file("EXPOSURE=nan\n", "-Y 1 +X 1", &pixel)).contains("EXPOSURE=nan"));
    for resolution in ["", "-Y 1", "-Y 0 +X 1", "-Y 1 -Y 1", "-Y 1x +X 1", "-Y 99999999999999999999 +X 1", "-Y 1 +X 1 1"] {
        assert!(error(&file("", resolution, &pixel)).contains("resolution line"), "{resolution}");
    }
    assert!(error(&file("", "-Y 40000 +X 40000", &pixel)).contains("more than 2^28"));
    assert_eq!(error(&file("", "-Y 2 +X 1", &pixel)), "test.hdr: the file ends in line 2 of 2 of the picture");
    assert!(error(&file("", "-Y 1 +X 20", &[2, 2, 0, 21])).contains("another length"));
    assert!(error(&file("", "-Y 1 +X 20", &[2, 2, 0, 20, 149, 0])).contains("beyond the end"));
    // A run of no bytes is read, as RADIANCE reads it.
    let runs = [2, 2, 0, 20, 0, 148, 200, 148, 100, 148, 50, 148, 130];
    assert_eq!(read(&file("", "-Y 1 +X 20", &runs)).pixels, [decode([200, 100, 50, 130]); 20]);
}

#[test]
fn values_that_cannot_be_stored_are_named() {
    let mut picture = picture(2, &[[128, 128, 128, 129]; 4]);
    picture.pixels[3] = [1.0, f32::NAN, 1.0];
    let message = picture.write_hdr().unwrap_err().message;
    assert_eq!(message, "the pixel in column 1 and row 1 (from the upper left, from 0) is 1 NaN 1, which a RADIANCE picture cannot hold");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn pictures_survive_a_round_trip(width in 1usize..70, seed: u64, alphabet in 1u8..60) {
        // A small alphabet makes runs of all lengths.
        let mut state = seed;
        let mut next = || { state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407); (state >> 33) as u8 % alphabet };
        let pixels: Vec<Rgbe> = (0..3 * width).map(|_| [128 + next(), next(), next(), 120 + next() % 20]).collect();
        let picture = picture(width, &pixels);
        prop_assert_eq!(read(&picture.write_hdr().unwrap()), picture);
    }

    #[test]
    fn long_lines_survive_too(width in 126usize..700, runs in prop::collection::vec((0u8..128, 1usize..300), 1..20)) {
        let line: Vec<Rgbe> = runs.iter().flat_map(|&(v, n)| std::iter::repeat_n([128 + v, v, 0, 128], n)).cycle().take(width).collect();
        let picture = picture(width, &line);
        prop_assert_eq!(read(&picture.write_hdr().unwrap()), picture);
    }

    #[test]
    fn no_bytes_panic(orientation in 0usize..8, data in prop::collection::vec(prop_oneof![any::<u8>(), 0u8..4], 0..200)) {
        let _ = Picture::read(&data, "test.hdr");
        let _ = Picture::read(&file("", ORIENTATIONS[orientation].0, &data), "test.hdr");
        let _ = Picture::read(&file("", "-Y 3 +X 20", &[&[2, 2, 0, 20], data.as_slice()].concat()), "test.hdr");
        let _ = Picture::read(&[b"#?RADIANCE\n", data.as_slice()].concat(), "test.hdr");
    }

    #[test]
    fn an_encoded_value_is_stored_within_a_step(r in 0f32..1e6, g in 0f32..1e6, b in 0f32..1e6) {
        let stored = encode([r, g, b]).unwrap();
        let step = decode([0, 0, 0, stored[3]])[0] * 2.0;
        for (value, decoded) in [r, g, b].into_iter().zip(decode(stored)) {
            prop_assert!((value - decoded).abs() <= step / 2.0 || stored == [0; 4]);
        }
        // Once stored, a value stays.
        prop_assert_eq!(encode(decode(stored)), Some(stored));
    }
}

/// The output of a program of RADIANCE, or nothing, aloud, if it is not installed.
fn radiance(program: &str, arguments: &[&str], input: &[u8]) -> Option<Vec<u8>> {
    let spawned = Command::new(program).args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
    let Ok(mut child) = spawned else {
        skipped(&format!("{program} is not on PATH"));
        return None;
    };
    let mut stdin = child.stdin.take().unwrap();
    std::thread::scope(|scope| {
        scope.spawn(move || stdin.write_all(input));
        Some(child.wait_with_output().unwrap().stdout)
    })
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn radiance_writes_the_same_bytes() {
    for width in [1, 8, 16, 17, 40, 400] {
        // Values with long and short runs, dim and bright, some negative.
        let values = |x: usize, c: usize| ((x / (1 + 3 * c)) as f32 * 0.37).sin() * 10f32.powi((x / 29) as i32 % 5 - 2 * c as i32);
        let pixels: Vec<[f32; 3]> = (0..3 * width).map(|x| std::array::from_fn(|c| values(x, c))).collect();
        let input: Vec<u8> = pixels.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        let size = ["-y", "3", "+x", &width.to_string()].map(str::to_string);
        let arguments: Vec<_> = ["-r", "-df", "-h"].into_iter().chain(size.iter().map(String::as_str)).collect();
        let Some(theirs) = radiance("pvalue", &arguments, &input) else { return };
        let header = Header { lines: vec![format!("pvalue {}", arguments.join(" "))], ..Header::default() };
        let ours = Picture { width, height: 3, header, pixels }.write_hdr().unwrap();
        assert!(ours == theirs, "width {width}:\n{}\n{}", ours.escape_ascii(), theirs.escape_ascii());
    }
}

#[test]
fn radiance_reads_the_same_values() {
    for width in [3, 20, 300] {
        let line: Vec<Rgbe> =
            (0..2 * width).map(|x| [128 + (x / 5 % 90) as u8, (x * x % 251) as u8, 7, 100 + (x / 9 % 60) as u8]).collect();
        let mut picture = picture(width, &line);
        picture.header.lines = vec!["EXPOSURE=2".into(), "COLORCORR=1 2 4".into(), "EXPOSURE=3".into()];
        let Some(theirs) = radiance("pvalue", &["-h", "-H", "-d", "-df", "-o"], &picture.write_hdr().unwrap()) else { return };
        let ours = picture.radiance();
        for (ours, theirs) in ours.pixels.as_flattened().iter().zip(floats(&theirs)) {
            assert!((ours - theirs).abs() <= 3e-7 * theirs, "{ours} {theirs}");
        }
    }
}
