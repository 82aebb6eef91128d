//! Views: the rays that RADIANCE's vwrays gives, recorded and live; sizes; view files and headers.

use crate::fed::fed;
use crate::photograph::{photographed, run};
use crate::skipped::skipped;
use inverad::error::{Error, Result};
use inverad::view::{Camera, View, ViewKind};
use proptest::prelude::*;
use std::process::Command;

/// What all recorded views share: oblique, shifted, with pixels of any shape.
const COMMON: &str = "-vp 1 -2 3 -vd 1 2 -.5 -vu .1 0 1 -vs .2 -vl -.1";

/// Recorded: `vwrays -fd VIEW COMMON -pa 0 -x 3 -y 2`, RADIANCE 6.0a: origin and direction of six rays from the upper left, 0 where there is
/// none. With an aft plane the length of the direction is how far the ray sees.
#[rustfmt::skip]
const RECORDED: [(&str, [[f64; 6]; 6]); 6] = [
    (
        "-vtv -vh 60 -vv 40 -vo .5 -va 8",
        [
            [1.1600448, -1.5195149, 2.9507421, 2.4006714, 7.2072765, -0.73886913],
            [1.3297757, -1.6086236, 2.933769, 4.9466351, 5.8706455, -0.99346551],
            [1.4995066, -1.6977324, 2.9167959, 7.4925989, 4.5340145, -1.2480619],
            [1.1276473, -1.5475343, 2.7738695, 1.9147096, 6.7869852, -3.3919574],
            [1.2973782, -1.636643, 2.7568964, 4.4606734, 5.4503543, -3.6465538],
            [1.4671091, -1.7257518, 2.7399233, 7.0066372, 4.1137233, -3.9011502],
        ],
    ),
    (
        "-vtl -vh 6 -vv 4 -vo .5 -va 8",
        [
            [0.61947322, -1.1007669, 3.5445909, 3.2732684, 6.5465367, -1.6366342],
            [2.3833687, -2.026812, 3.3682013, 3.2732684, 6.5465367, -1.6366342],
            [4.1472641, -2.9528572, 3.1918118, 3.2732684, 6.5465367, -1.6366342],
            [0.26342819, -1.4086978, 1.6007775, 3.2732684, 6.5465367, -1.6366342],
            [2.0273236, -2.3347429, 1.4243879, 3.2732684, 6.5465367, -1.6366342],
            [3.7912191, -3.260788, 1.2479984, 3.2732684, 6.5465367, -1.6366342],
        ],
    ),
    (
        "-vtc -vh 160 -vv 40 -vo .5 -va 8",
        [
            [1.0525615, -1.5008409, 2.9674713, 0.78842224, 7.4873871, -0.48793014],
            [1.428459, -1.7441579, 2.9371641, 6.4268857, 3.8376311, -0.94253882],
            [1.4669851, -2.1868301, 3.0002336, 7.0047771, -2.802452, 0.0035041298],
            [1.020164, -1.5288603, 2.7905988, 0.30246052, 7.0670959, -3.1410185],
            [1.3960616, -1.7721773, 2.7602915, 5.940924, 3.4173398, -3.5956271],
            [1.4345877, -2.2148495, 2.8233611, 6.5188154, -3.2227432, -2.6495842],
        ],
    ),
    (
        "-vth -vh 170 -vv 120 -vo .5 -va 8",
        [
            [1.108574, -1.5133103, 3.036672, 1.6286105, 7.3003451, 0.55008072],
            [1.390791, -1.6883577, 3.0127091, 5.8618646, 4.6746338, 0.19063696],
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.99247458, -1.6580062, 2.6353308, -0.11288135, 5.129907, -5.4700376],
            [1.2719509, -1.8385348, 2.6127382, 4.0792637, 2.4219777, -5.8089269],
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ],
    ),
    (
        "-vta -vh 260 -vv 150 -vo .5",
        [
            [0.95160159, -1.5163462, 3.1172031, -0.096796828, 0.96730767, 0.23440617],
            [1.4875696, -1.9120911, 3.0674379, 0.97513926, 0.17581789, 0.13487584],
            [1.1177263, -2.4742417, 3.1059967, 0.23545262, -0.94848345, 0.21199342],
            [0.81689672, -1.7448894, 2.610909, -0.36620656, 0.51022116, -0.77818194],
            [1.2979196, -2.0879935, 2.6082079, 0.59583918, -0.17598701, -0.78358423],
            [1.0146957, -2.4994085, 2.9806297, 0.029391337, -0.99881695, -0.038740692],
        ],
    ),
    (
        "-vts -vh 200 -vv 150 -va 8",
        [
            [1.0, -2.0, 3.0, -0.75825453, 7.650976, 2.2107954],
            [1.0, -2.0, 3.0, 7.7294746, 1.6103294, 1.2892097],
            [1.0, -2.0, 3.0, 6.0916163, -5.0663055, 1.1066883],
            [1.0, -2.0, 3.0, -2.7944793, 3.8101818, -6.4554938],
            [1.0, -2.0, 3.0, 4.5440303, -0.97197461, -6.5120699],
            [1.0, -2.0, 3.0, 4.562041, -5.872538, -2.9497591],
        ],
    ),
];

fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_string).collect()
}

fn no_files(name: &str) -> Result<Vec<u8>> {
    Err(Error::new(format!("{name}: no such file")))
}

fn view(line: &str) -> View {
    let mut view = View::default();
    view.apply(&words(line), &no_files).unwrap();
    view
}

fn error(line: &str) -> String {
    let mut view = View::default();
    view.apply(&words(line), &no_files).and_then(|()| view.ready()).unwrap_err().message
}

/// The rays through the centres of all pixels as vwrays writes them: from the upper left, row by row.
fn rays(camera: &Camera, width: usize, height: usize) -> Vec<[f64; 6]> {
    let ray = |i: usize| {
        let (x, y) = ((i % width) as f64 + 0.5, (height - 1 - i / width) as f64 + 0.5);
        let Some((o, d, limit)) = camera.ray(x / width as f64, y / height as f64) else { return [0.0; 6] };
        assert!((d.length() - 1.0).abs() < 1e-14);
        let d = if limit.is_finite() { d * limit } else { d };
        [o.x, o.y, o.z, d.x, d.y, d.z]
    };
    (0..width * height).map(ray).collect()
}

#[test]
fn rays_are_those_of_vwrays() {
    for (line, recorded) in RECORDED {
        let camera = view(&format!("{line} {COMMON}")).ready().unwrap();
        for (ours, theirs) in rays(&camera, 3, 2).into_iter().zip(recorded) {
            // Recorded to eight digits.
            assert!(ours.iter().zip(theirs).all(|(a, b)| (a - b).abs() <= 1e-7 * b.abs().max(0.1)), "{line}\n{ours:?}\n{theirs:?}");
        }
    }
}

#[test]
fn rays_are_those_of_the_vwrays_that_is_installed() {
    let kinds =
        [('v', 179.0, 179.0), ('l', 50.0, 50.0), ('c', 360.0, 179.0), ('h', 180.0, 180.0), ('a', 360.0, 360.0), ('s', 350.0, 350.0)];
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    for i in 0..60 {
        let (kind, widest, highest) = kinds[i % 6];
        let mut n = |low: f64, high: f64| low + (high - low) * next();
        // Every kind once at its limits, then anything; crops are shifts in a smaller view.
        let (h, v) = if i < 6 { (widest, highest) } else { (n(1.0, widest), n(1.0, highest)) };
        let mut line = format!("-vt{kind} -vh {h} -vv {v} -vp {} {} {}", n(-9.0, 9.0), n(-9.0, 9.0), n(-9.0, 9.0));
        line += &format!(" -vd {} {} {} -vu {} {} {}", n(-2.0, 2.0), n(-2.0, 2.0), n(-2.0, 2.0), n(-1.0, 1.0), n(-1.0, 1.0), n(1.0, 2.0));
        if i >= 6 {
            let fore = n(0.0, 3.0);
            line +=
                &format!(" -vs {} -vl {} -vo {fore} -va {}", n(-1.5, 1.5), n(-1.5, 1.5), if i % 2 == 0 { fore + n(0.1, 5.0) } else { 0.0 });
        }
        let arguments = format!("-fd {line} -pa 0 -x 13 -y 7");
        let Ok(output) = Command::new("vwrays").args(arguments.split(' ')).output() else {
            skipped("vwrays is not on PATH");
            return;
        };
        let camera = view(&line).ready().unwrap();
        let theirs: Vec<f64> = output.stdout.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(theirs.len(), 13 * 7 * 6, "{arguments}");
        for (ours, theirs) in rays(&camera, 13, 7).iter().zip(theirs.chunks_exact(6)) {
            let size = theirs[3..].iter().fold(1f64, |m, v| m.max(v.abs()));
            assert!(ours.iter().zip(theirs).all(|(a, b)| (a - b).abs() <= 2e-12 * size), "{line}\n{ours:?}\n{theirs:?}");
        }
    }
}

#[test]
fn views_are_alike_that_show_about_the_same() {
    let own = view("-vp 0 -5 1 -vd 0 1 -.2 -vh 26 -vv 26");
    for (line, alike) in [
        ("-vp 0 -5 1 -vd 0 5 -1 -vh 26 -vv 26.1", true),
        ("-vp 0 -5 1.2 -vd 0 1 -.2 -vh 26 -vv 26", false),
        ("-vp 0 -5 1 -vd 0 1 -.3 -vh 26 -vv 26", false),
        ("-vp 0 -5 1 -vd 0 1 -.2 -vh 30 -vv 26", false),
        ("-vp 0 -5 1 -vd 0 1 -.2 -vh 26 -vv 26 -vs .2", false),
        ("-vp 0 -5 1 -vd 0 1 -.2 -vu 1 0 1 -vh 26 -vv 26", false),
        ("-vta -vp 0 -5 1 -vd 0 1 -.2 -vh 26 -vv 26", false),
    ] {
        assert_eq!(own.is_like(&view(line)), alike, "{line}");
    }
}

#[test]
fn pictures_keep_their_shape_and_never_grow() {
    // Recorded: `vwrays -d … -x X -y Y`, RADIANCE 6.0a.
    for (line, x, y, aspect, size) in [
        ("-vh 40 -vv 40", 100, 50, 1.0, (50, 50)),
        ("-vh 40 -vv 20", 100, 100, 1.0, (100, 48)),
        ("-vh 60 -vv 40", 101, 50, 0.9, (71, 50)),
        ("-vth -vh 180 -vv 90", 64, 64, 1.0, (64, 45)),
        ("-vtc -vh 360 -vv 90", 64, 64, 1.0, (64, 20)),
        ("-vts -vh 180 -vv 90", 64, 64, 1.0, (64, 27)),
        ("-vh 40 -vv 40", 100, 50, 0.0, (100, 50)),
    ] {
        assert_eq!(view(line).ready().unwrap().resolution(x, y, aspect), size, "{line}");
    }
    // RADIANCE would make this one empty.
    assert_eq!(view("-vh 90 -vv 1").ready().unwrap().resolution(4, 4, 1.0), (4, 1));
    assert_eq!(view("-vh 40 -vv 40").ready().unwrap().pixel_aspect(100, 50), 2.0);
}

#[test]
fn a_view_file_is_read_like_a_header() {
    // `rpict -vf FILE`, RADIANCE 6.0a, makes of this file
    // VIEW= -vtl -vp 1 2 3 -vd 1 2 3 -vu 1 0 0 -vh 10 -vv 20 -vo 0 -va 0 -vs 0.5 -vl 0.
    let file = "rvu -vtl -vp 1 2 3 -vx 5 -vh 10\n/usr/bin/rpict -vv 20 foo -vs .5\n\tVIEW= -vl 9\n VIEW= -vl 9\nrpict2 -vu 1 0 0\n\
                VIEW= -vh bad -vd 1 2 3\nVIEW=-vd 3 2 1\nxVIEW= -vs 99\n\nVIEW= -vl 9\n";
    let read = |name: &str| if name == "cam.vf" { Ok(file.as_bytes().to_vec()) } else { Ok(b"nothing\n".to_vec()) };
    let mut from_file = View::default();
    from_file.apply(&words("-vp 9 9 9 -vf cam.vf -vl .25"), &read).unwrap();
    let expected = view("-vtl -vp 1 2 3 -vd 1 2 3 -vu 1 0 0 -vh 10 -vv 20 -vo 0 -va 0 -vs 0.5 -vl .25");
    assert_eq!(from_file, expected);
    assert!(from_file.apply(&words("-vf other.vf"), &read).unwrap_err().message.starts_with("other.vf: no view in this file"));
}

#[cfg(unix)]
#[test]
fn a_view_may_come_through_a_pipe() {
    let directory = photographed(
        "plastic it 0 0 5 .6 .4 .2 .1 .2",
        "void glow sky 0 0 4 1 1 1 0\nsky source all 0 0 4 0 0 1 360\nit sphere s 0 0 4 0 0 0 1\n",
        "-x 16 -y 16 --spp 4 -o target.hdr",
    );
    let mut anneal = Command::new(env!("CARGO_BIN_EXE_anneal"));
    anneal.current_dir(directory.path()).args("--time .01 --scene scene.rad --target target.hdr".split(' '));
    let view = b"VIEW= -vp 0 -5 1 -vd 0 1 -.2 -vh 26 -vv 26\n";
    let done = fed(anneal.args(["-vf", "/dev/stdin", "start.rad"]), view);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    // A name where a number is missing is told, and is no file that is waited for.
    let words = "--scene scene.rad --target target.hdr -vp 0 0 start.rad";
    let done = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), words);
    assert_eq!((done.status.code(), &done.stderr[..]), (Some(2), &b"anneal: error: -vp needs 3 numbers, not 0 0 start.rad\n"[..]));
}

#[test]
fn what_was_cut_out_of_a_picture_has_another_view() {
    let lines = ["rpict -x 320 a.oct", "VIEW= -vtv -vp 2 -1 1 -vd -2 1 -1 -vh 28 -vv 21", "pfilt -x /4 -y /4"];
    assert_eq!(View::said(lines).unwrap().horizontal, 28.0);
    let part = [&lines[..], &["pcompos -x 40 -y 36 a.hdr -10 -20"]].concat();
    assert!(View::said(part.iter().copied()).is_none());
    assert_eq!(View::said([&part[..], &["VIEW= -vh 14 -vs .3"]].concat()).unwrap().horizontal, 14.0);
}

#[test]
fn impossible_views_say_why() {
    // All refused by vwrays, RADIANCE 6.0a.
    for (line, word) in [
        ("-vd 0 0 0", "-vd"),
        ("-vu 0 0 0", "-vu"),
        ("-vd 0 0 1", "parallel"),
        ("-vh 180", "below 180"),
        ("-vh 0", "-vh 0"),
        ("-vh -10", "-vh -10"),
        ("-vh 1e-7", "-vh"),
        ("-vo 2 -va 1", "aft"),
        ("-vo 2 -va 2", "aft"),
        ("-vtl -vo -2", "-vo -2"),
        ("-va -1", "-va -1"),
        ("-vth -vh 181 -vv 180", "at most 180"),
        ("-vta -vh 361", "at most 360"),
        ("-vts -vh 360", "below 360"),
        ("-vtc -vh 360 -vv 180", "below 180"),
        ("-vtl -vh 0", "-vh 0"),
        ("-vtx", "-vtx"),
        ("-vp 1 2", "-vp needs 3 numbers, not 1 2"),
        ("-vp 1 2 x", "-vp"),
        ("-vh nan", "-vh"),
        ("-vf absent.vf", "absent.vf: no such file"),
        // Taken by vwrays, whose rays of the first have directions of length 0.
        ("-vs -4e172", "-vs -4e172: the numbers of a view go up to 1e30"),
        ("-vp 0 -1e31 0", "-vp 1e31"),
    ] {
        assert!(error(line).contains(word), "{line}: {}", error(line));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_header_line_keeps_a_view_exactly(n in prop::collection::vec(-1e3f64..1e3, 15), kind in "[vlchas]") {
        let point = |i: usize| inverad::vector::Vec3::new(n[i], n[i + 1], n[i + 2]);
        let kept = View {
            kind: ViewKind::of(kind.chars().next().unwrap()).unwrap(), point: point(0), direction: point(3), up: point(6),
            horizontal: n[9], vertical: n[10], fore: n[11], aft: n[12] * 1e-9, shift: n[13], lift: n[14] * 1e20,
        };
        let mut read = View::default();
        prop_assert!(read.apply_header([kept.header_line().as_str()]));
        prop_assert_eq!(read, kept);
    }

    #[test]
    fn no_words_panic(line in "(VIEW=|-v[tfpduhvoasl][vlchas]?|[0-9.e-]{1,4}|é| ){0,20}", x in 0f64..1.0, y in 0f64..1.0) {
        let mut view = View::default();
        view.apply_header([format!("VIEW= {line}").as_str()]);
        let _ = view.apply(&words(&line), &no_files);
        if let Ok(camera) = view.ready() {
            camera.ray(x, y);
            camera.resolution(100, 100, 1.0);
        }
    }
}
