//! Rays in, records out: what `rtrace-rs` says, letter by letter, is what the real `rtrace` says.
//!
//! `tests/rays/recorded.json` holds scenes and what RADIANCE 6.0a said: `oconv SCENE > s.oct; rtrace -w ARGS s.oct < INPUT`; binary
//! output is in hexadecimal. Its Fresnel constant is that of releases before June 2026.

use crate::fed::fed;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// The options by which RADIANCE leaves nothing to chance.
const EXACT: &str = "-u- -h -ab 0 -lr 12 -lw 1e-9 -dt 0 -dj 0 -ds 0 -st 0 -ss 0";

/// RADIANCE computes with light in single precision.
const TOLERANCE: f64 = 2e-5;

fn run(directory: &Path, args: &[&str], input: &[u8]) -> Output {
    fed(Command::new(env!("CARGO_BIN_EXE_rtrace-rs")).args(args).current_dir(directory).env("RAYPATH", "."), input)
}

/// Runs the program on a scene, and expects it to work.
fn records(scene: &str, args: &str, input: &str) -> Vec<u8> {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("scene.rad"), scene).unwrap();
    let mut args: Vec<&str> = args.split_whitespace().collect();
    args.extend(["--fresnel-offset", "0.00202943064", "scene.rad"]);
    let output = run(directory.path(), &args, input.as_bytes());
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= TOLERANCE * b.abs() + 1e-12 || a.abs().max(b.abs()) < 2e-7
}

fn same_text(found: &str, wanted: &str) -> bool {
    let fields = |text: &str| text.split(['\t', '\n']).map(str::to_string).collect::<Vec<_>>();
    let (found, wanted) = (fields(found), fields(wanted));
    found.len() == wanted.len()
        && found.iter().zip(&wanted).all(|(f, w)| match (f.parse(), w.parse()) {
            (Ok(f), Ok(w)) => near(f, w),
            _ => f == w,
        })
}

/// Numbers and names of binary records, by the letters of `-o`.
fn fields(bytes: &[u8], letters: &str, double: bool) -> Vec<String> {
    let mut rest = bytes;
    let mut found = Vec::new();
    while !rest.is_empty() {
        for letter in letters.chars() {
            let count = match letter {
                's' | 'm' | 'M' => {
                    let end = rest.iter().position(|&b| b == b'\t').unwrap();
                    found.push(String::from_utf8(rest[..end].to_vec()).unwrap());
                    rest = &rest[end + 1..];
                    continue;
                }
                'v' | 'N' => 3,
                _ => 1,
            };
            for _ in 0..count {
                let (number, size) = match double {
                    true => (f64::from_ne_bytes(rest[..8].try_into().unwrap()), 8),
                    false => (f32::from_ne_bytes(rest[..4].try_into().unwrap()) as f64, 4),
                };
                found.push(number.to_string());
                rest = &rest[size..];
            }
        }
    }
    found
}

#[test]
fn every_letter_says_what_rtrace_says() {
    let recorded: Value = serde_json::from_str(include_str!("rays/recorded.json")).unwrap();
    let mut failures = Vec::new();
    for case in recorded["cases"].as_array().unwrap() {
        let text = |key: &str| case[key].as_str().unwrap_or_default();
        let found = records(recorded["scenes"][text("scene")].as_str().unwrap(), text("args"), text("input"));
        let good = match case["hex"].as_str() {
            None => same_text(&String::from_utf8_lossy(&found), text("output")),
            Some(hex) => {
                let wanted: Vec<u8> = (0..hex.len()).step_by(2).map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap()).collect();
                let letters = text("args").split_whitespace().find_map(|w| w.strip_prefix("-o")).unwrap_or("v");
                match text("args").split_whitespace().find_map(|w| w.strip_prefix("-f")).unwrap() {
                    "ac" => found == wanted,
                    form => {
                        let [found, wanted] = [&found, &wanted].map(|bytes| fields(bytes, letters, form.ends_with('d')).join("\t"));
                        same_text(&found, &wanted)
                    }
                }
            }
        };
        if !good {
            failures.push(format!("{}\n--- found\n{}--- wanted\n{}", text("args"), String::from_utf8_lossy(&found), text("output")));
        }
    }
    assert!(failures.is_empty(), "{} failures\n{}", failures.len(), failures.join("\n"));
}

const GLOW: &str = "void glow g 0 0 4 1 2 3 0\ng source sky 0 0 4 0 0 1 360\n";

#[test]
fn the_header_names_what_follows() {
    // As rtrace's, but for the dates.
    for (args, wanted) in [
        ("-x 2 -y 1", "NCOMP=3\nFORMAT=ascii\n\n-Y        1 +X        2\n"),
        ("-odsN -x 1 -y 1", "NCOMP=7\nFORMAT=ascii\n\n-Y        1 +X        1\n"),
        ("-faf", "NCOMP=3\nBigEndian=0\nFORMAT=float\n\n"),
        ("-fad -pY", "NCOMP=1\nBigEndian=0\nFORMAT=double\n\n"),
        ("-fac", "NCOMP=3\nFORMAT=32-bit_rle_rgbe\n\n"),
        ("-fac -pXYZ", "NCOMP=3\nPRIMARIES= 1.0000 0.0000 0.0000 1.0000 0.0000 0.0000 0.3333 0.3333\nFORMAT=32-bit_rle_xyze\n\n"),
        ("-otv", "FORMAT=ascii\n\n"),
    ] {
        let found = records(GLOW, args, "");
        let text = String::from_utf8_lossy(&found);
        let first = format!("#?RADIANCE\nrtrace-rs {args} --fresnel-offset 0.00202943064 scene.rad\nSOFTWARE= inverad ");
        assert!(text.starts_with(&first), "{text}");
        assert!(text.split_once(char::is_whitespace).is_some() && text.ends_with(wanted), "{args}: {text}");
    }
}

#[test]
fn what_rays_cannot_be_is_said_in_one_line() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("s.rad"), GLOW).unwrap();
    for (args, input, wanted) in [
        (&["-h", "s.rad"][..], "0 0 0 0 0 1 0 0 x", "rtrace-rs: error: <stdin>: ray 2: `x` is not a number"),
        (&["-ovq", "s.rad"], "", "rtrace-rs: error: unknown option '-ovq'"),
        (&["-fca", "s.rad"], "", "rtrace-rs: error: -fca: give the form of the rays"),
        (&["-ffc", "-oL", "s.rad"], "", "rtrace-rs: error: answers are colours (-f…c) with -ov, -or or -ox alone"),
        (&["-"], "", "rtrace-rs: error: standard input holds the rays; name the files of the scene, or give a view"),
        (&["-h"], "", "rtrace-rs: error: standard input holds the rays; name the files of the scene, or give a view"),
        (&["-te", "a", "-ti", "b", "-otv", "s.rad"], "", "rtrace-rs: error: -te and -ti exclude each other"),
    ] {
        let output = run(directory.path(), args, input.as_bytes());
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && message.starts_with(wanted) && message.lines().count() == 1, "{args:?}: {message}");
    }
    // What came before the fault is answered.
    let output = run(directory.path(), &["-h", "s.rad"], b"0 0 0 0 0 1 0 0 x");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "1.000000e+00\t2.000000e+00\t3.000000e+00\t\n");
}

#[test]
fn a_view_alone_sees_the_scene_on_standard_input() {
    let directory = tempfile::tempdir().unwrap();
    // oconv scene.rad '!echo void glow g 0 0 4 1 1 1 0' > plain.oct
    let octree = include_bytes!("import/plain.oct");
    for (name, bytes) in [("s.rad", GLOW.as_bytes()), ("scene.rad", GLOW.as_bytes()), ("s.oct", octree)] {
        std::fs::write(directory.path().join(name), bytes).unwrap();
    }
    let view: Vec<&str> = "-vp 0 0 0 -vd 0 0 1 -vu 0 1 0 -x 4 -y 4 --spp 1 -n 1".split(' ').collect();
    let pixels = |named: &[&str], input: &[u8]| {
        let output = run(directory.path(), &[&view, named].concat(), input);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let end = output.stdout.windows(2).position(|w| w == b"\n\n").unwrap();
        output.stdout[end..].to_vec()
    };
    let wanted = pixels(&["s.rad"], b"");
    assert!(wanted == pixels(&[], GLOW.as_bytes()) && wanted == pixels(&["-"], GLOW.as_bytes()) && wanted == pixels(&[], octree));
}

#[test]
fn a_mesh_with_a_modifier_needs_none_of_the_materials_that_its_file_names() {
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(directory.path().join(name), text).unwrap();
    write("t.obj", "v -1 -1 0\nv 1 -1 0\nv 0 2 0\ng front\nusemtl red\nf 1 2 3\n");
    write("own.rad", "void plastic m 0 0 5 .5 .5 .5 0 0\nm mesh t 1 t.obj 0 0\n");
    write("none.rad", "void plastic m 0 0 5 .5 .5 .5 0 0\nm mesh t 1 t.obj 0 0\nvoid mesh u 5 t.obj -t 0 0 -1 0 0\n");
    let told = |scene: &str| run(directory.path(), &["-h", "-ab", "0", "-oLm", scene], b"0 0 5 0 0 -1");
    // rtrace -h -ab 0 -oLm own.oct, with the mesh made by obj2mesh.
    assert_eq!(String::from_utf8(told("own.rad").stdout).unwrap(), "5.000000e+00\tm\t\n");
    let refused = String::from_utf8(told("none.rad").stderr).unwrap();
    assert!(refused.contains("none.rad:3:15: error: it uses the material `red`, which is not defined"), "{refused}");
}

#[test]
fn what_a_mesh_file_names_is_what_that_means_where_the_mesh_stands() {
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(directory.path().join(name), text).unwrap();
    write("t.obj", "v -1 -1 0\nv 1 -1 0\nv 0 2 0\nusemtl body\nf 1 2 3\n");
    write(
        "s.rad",
        "void glow body 0 0 4 1 0 0 0\nvoid mesh a 1 t.obj 0 0\nvoid glow body 0 0 4 0 1 0 0\nvoid mesh b 5 t.obj -t 5 0 0 0 0\n",
    );
    let told = run(directory.path(), &["-h", "-ab", "0", "s.rad"], b"0 0 5 0 0 -1 5 0 5 0 0 -1").stdout;
    assert_eq!(
        String::from_utf8(told).unwrap(),
        "1.000000e+00\t0.000000e+00\t0.000000e+00\t\n0.000000e+00\t1.000000e+00\t0.000000e+00\t\n"
    );
}

#[test]
fn an_instance_with_a_modifier_shows_what_has_none_itself() {
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(directory.path().join(name), bytes).unwrap();
    // Octrees that name one file each, and a glow that nothing has: oconv scene.rad '!echo void glow g 0 0 4 1 1 1 0' > inner.oct
    let inner = include_bytes!("import/plain.oct");
    let outer: Vec<u8> = String::from_utf8_lossy(inner).replace("scene.rad", "outer.rad").into_bytes();
    write("inner.oct", inner);
    write("outer.oct", &outer);
    write("scene.rad", b"void sphere b 0 0 4 0 0 0 1\nvoid mesh t 1 t.obj 0 0\n");
    write("outer.rad", b"void instance w 1 inner.oct 0 0\n");
    write("t.obj", b"v 4 -1 0\nv 6 -1 0\nv 5 2 0\nf 1 2 3\n");
    write(
        "main.rad",
        b"void plastic m 0 0 5 .5 .5 .5 0 0\nm instance i 1 inner.oct 0 0\nm instance o 5 outer.oct -t 0 20 0 0 0\n\
          void instance v 5 inner.oct -t 0 40 0 0 0\n",
    );
    let rays = b"0 0 5 0 0 -1 5 0 5 0 0 -1 0 20 5 0 0 -1 5 20 5 0 0 -1 0 40 5 0 0 -1";
    let output = run(directory.path(), &"-h -ab 0 -av 1 1 1 -ovLsm main.rad".split(' ').collect::<Vec<_>>(), rays);
    // rtrace -h -ab 0 -av 1 1 1 -ovLsm main.oct, with the mesh made by obj2mesh; the last one sees through what is void: no light.
    let half = "5.000000e-01\t5.000000e-01\t5.000000e-01";
    let wanted =
        format!("{half}\t4.000000e+00\ti\tm\t\n{half}\t5.000000e+00\ti\tm\t\n{half}\t4.000000e+00\to\tm\t\n{half}\t5.000000e+00\to\tm\t\n");
    let found = String::from_utf8(output.stdout).unwrap();
    let rest = found.strip_prefix(wanted.as_str());
    assert!(rest.is_some_and(|rest| rest.starts_with("0.000000e+00\t0.000000e+00\t0.000000e+00\t")), "{found}");
}

#[cfg(unix)]
#[test]
fn names_that_are_no_utf_8_are_found_and_told_byte_for_byte() {
    use std::os::unix::ffi::OsStrExt;
    let directory = tempfile::tempdir().unwrap();
    let named = |end: &[u8]| directory.path().join(std::ffi::OsStr::from_bytes(&[b"caf\xe9", end].concat()));
    std::fs::write(named(b".rad"), b"void brightfunc f 2 half caf\xe9.cal 0 0\nf plastic caf\xe9 0 0 5 1 1 1 0 0\n").unwrap();
    std::fs::write(named(b".cal"), b"half = .5;").unwrap();
    std::fs::write(named(b".obj"), b"v -1 -1 0\nv 1 -1 0\nv 0 2 0\nf 1 2 3\n").unwrap();
    std::fs::write(directory.path().join("s.rad"), b"!cat caf\xe9.rad\ncaf\xe9 mesh m 1 caf\xe9.obj 0 0\n").unwrap();
    let output = run(directory.path(), &"-h -ab 0 -av 1 1 1 -ovm s.rad".split(' ').collect::<Vec<_>>(), b"0 0 5 0 0 -1");
    // rtrace -h -ab 0 -av 1 1 1 -ovm s.oct, with the mesh made by obj2mesh.
    let wanted = b"5.000000e-01\t5.000000e-01\t5.000000e-01\tcaf\xe9\t\n";
    assert!(output.stdout == wanted, "{output:?}");
    // Named on the command line; JSON can hold such bytes only as characters.
    let json = Command::new(env!("CARGO_BIN_EXE_rparse")).arg("--json").arg(named(b".rad")).output().unwrap();
    let text = String::from_utf8(json.stdout).unwrap();
    assert!(text.contains(r#""id":"café""#) && text.contains(r#"["half","café.cal"]"#), "{text}");
}

#[test]
fn answers_do_not_depend_on_threads_and_meet_the_error_asked_for() {
    // A Lambertian plane under a hemisphere of radiance 1: .5 at every ray.
    let scene = "void glow g 0 0 4 1 1 1 0\ng source sky 0 0 4 0 0 1 180\nvoid plastic p 0 0 5 .5 .5 .5 0 0\np ring r 0 0 8 0 0 0 0 0 1 0 9\n\
                 p sphere s 0 0 4 0 0 2 .5\n";
    let rays: String = (0..40).map(|i| format!("{} .1 1 0 0 -1\n", i as f64 * 0.1 - 2.0)).collect();
    let answer = |more: &str| records(scene, &format!("-h {more}"), &rays);
    assert_eq!(answer("-n 1"), answer("-n 3"));
    assert_ne!(answer("--seed 1"), answer("--seed 2"));
    let numbers = |bytes: Vec<u8>| -> Vec<f64> {
        String::from_utf8(bytes).unwrap().lines().map(|l| l.split('\t').next().unwrap().parse().unwrap()).collect()
    };
    let (rough, fine) = (numbers(answer("--error .02")), numbers(answer("--error .001")));
    let off = rough.iter().zip(&fine).map(|(a, b)| (a / b - 1.0).powi(2)).sum::<f64>() / rough.len() as f64;
    assert!(off.sqrt() < 0.02 && rough != fine, "{}", off.sqrt());
}

#[test]
fn a_ray_is_as_bright_whether_its_ways_are_told_or_not() {
    // A bulb that most samples miss, behind a shade.
    let scene = "void plastic p 0 0 5 .6 .6 .6 0 0\np bubble room 0 0 4 0 0 0 3\np ring shade 0 0 8 0 0 1.5 0 0 1 0 .6\n\
                 void light l 0 0 3 1000 1000 1000\nl sphere lamp 0 0 4 0 0 1.9 .02\n";
    let rays: String = (0..40).map(|i| format!("{} .1 -1 .1 .2 -1\n", f64::from(i) * 0.04 - 0.8)).collect();
    let brightness = |letters: &str| -> Vec<f64> {
        let said = String::from_utf8(records(scene, &format!("-h {letters}"), &rays)).unwrap();
        said.lines().map(|line| line.split('\t').next().unwrap().parse().unwrap()).collect()
    };
    let plain = brightness("-ov");
    assert!(plain.iter().all(|light| *light > 0.0));
    for letters in ["-ovr", "-ovl"] {
        assert!(brightness(letters).iter().zip(&plain).all(|(a, b)| near(*a, *b)), "{letters}");
    }
}

#[test]
fn a_glow_without_a_radius_is_not_seen_where_light_sources_are_not() {
    // What `rtrace -ab 0 -dv-` of RADIANCE 6.0a says of a ball and of a distant source, for glows of several radii.
    for (radius, wanted) in [("-1", [0.0, 0.0]), ("0", [1.0, 1.0]), (".5", [1.0, 1.0]), ("5", [0.0, 1.0])] {
        for (surface, wanted) in ["sphere s 0 0 4 0 0 0 1", "source s 0 0 4 0 1 0 30"].into_iter().zip(wanted) {
            let said = records(&format!("void glow g 0 0 4 1 1 1 {radius}\ng {surface}\n"), "-h -ab 0 -dv-", "0 -5 0 0 1 0\n");
            let said = String::from_utf8(said).unwrap();
            assert_eq!(said.split('\t').next().unwrap().parse::<f64>().unwrap(), wanted, "{radius} {surface}");
        }
    }
}

#[test]
fn a_ray_through_many_panes_is_told_of() {
    let said = |panes: usize, letters: &str| {
        let ball = "void glow w 0 0 4 1 1 1 0\nw sphere s 0 0 4 0 0 -3 1\nvoid glass g 0 0 4 1 1 1 1";
        let scene = format!("{ball}\n!echo g ring r 0 0 8 0 0 0 0 0 1 0 1 | xform -a {panes} -t 0 0 .01\n");
        let origin = format!("0 0 {}.5 0 0 -1\n", panes / 100);
        String::from_utf8(records(&scene, &format!("-h -u- -ab 0 -lr 1000000 -lw 1e-9 -o{letters}"), &origin)).unwrap()
    };
    assert!(near(said(40_000, "Ll").split_whitespace().nth(1).unwrap().parse().unwrap(), 402.5));
    // Each of them has a record.
    assert_eq!(said(2000, "tL").lines().count(), 2001);
}

#[test]
fn every_sample_of_a_tree_is_told_if_a_number_is_given() {
    let scene =
        "void glow g 0 0 4 1 1 1 0\ng source sky 0 0 4 0 0 1 360\nvoid plastic p 0 0 5 .5 .5 .5 0 0\np ring r 0 0 8 0 0 0 0 0 1 0 9\n";
    let lines =
        |more: &str| records(scene, &format!("{EXACT} -ab 1 {more} -ots"), "0 0 1 0 0 -1\n").iter().filter(|&&b| b == b'\n').count();
    assert!(lines("") >= 2 && lines("--spp 3") >= 3 * 2, "{} {}", lines(""), lines("--spp 3"));
}
