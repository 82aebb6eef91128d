//! The examples of the manual pages of rtrace, rpict and vwrays run as printed, `rtrace` and `rpict` being `rtrace-rs`.
//!
//! They need RADIANCE's other programs (`vwrays`, `rcalc`, `cnt`, `oconv`, `pvalue`, `pfilt`), on PATH or from the Python package pyradiance;
//! without them they are skipped. Where the real `rtrace` is there too, it says what must come out.

#![cfg(unix)]

use crate::skipped::skipped;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A scene that both programs see alike where no diffuse light is asked for: its only light is a sun.
const SCENE: &str = "void light sun_mat 0 0 3 1e4 9e3 8e3 sun_mat source sun 0 0 4 1 .5 2 .5\n\
    void mirror mirror_mat 0 0 3 .9 .8 .7 mirror_mat polygon wall 0 0 12 4 -8 -2 4 -8 8 4 8 8 4 8 -2\n\
    void glass pane_mat 0 0 3 .9 .9 .8 pane_mat polygon pane 0 0 12 6 -6 0 6 6 0 6 6 6 6 -6 6\n\
    void plastic floor_mat 0 0 5 .5 .4 .3 0 0 floor_mat polygon floor 0 0 12 -20 -20 -3 20 -20 -3 20 20 -3 -20 20 -3\n";

const VIEW: &str = "rvu -vtv -vp 9 -3 3 -vd .6 1 -.2 -vu 0 0 1 -vh 70 -vv 60\n";

/// A fisheye of one's own, as the manual page of rtrace has it: pixels counted from the top.
const UNUSUAL: &str = "x=($2+.5)/xr; y=($1+.5)/yr; $1=8; $2=-1; $3=3; $4=cos(3*x); $5=sin(3*x); $6=.5-y;";

/// Where RADIANCE's programs are.
fn radiance() -> Option<PathBuf> {
    let from_path = std::env::var_os("PATH").and_then(|path| std::env::split_paths(&path).find(|d| d.join("vwrays").is_file()));
    from_path.or_else(|| {
        let script = "import pyradiance,os;print(os.path.dirname(pyradiance.__file__)+'/bin')";
        let output = Command::new("python3").args(["-c", script]).output().ok().filter(|o| o.status.success())?;
        let directory = PathBuf::from(String::from_utf8(output.stdout).ok()?.trim());
        directory.join("vwrays").is_file().then_some(directory)
    })
}

/// Two shells: in one `rtrace` and `rpict` are ours, in the other RADIANCE's.
struct Bench {
    directory: tempfile::TempDir,
    ours: OsString,
    theirs: OsString,
    raypath: OsString,
}

impl Bench {
    fn new() -> Option<Self> {
        let Some(radiance) = radiance() else {
            skipped("RADIANCE's programs are not on PATH");
            return None;
        };
        let directory = tempfile::tempdir().unwrap();
        let bin = directory.path().join("bin");
        std::fs::create_dir(&bin).unwrap();
        for name in ["rtrace", "rpict"] {
            std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_rtrace-rs"), bin.join(name)).unwrap();
        }
        let stub = bin.join("ximage");
        std::fs::write(&stub, "#!/bin/sh\nprintf '9 -3 3 .6 1 -.6\\n9 -3 3 0 .2 -1\\n'\n").unwrap();
        std::fs::set_permissions(&stub, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
        let after = |first: &[&Path]| {
            let old = std::env::var_os("PATH").unwrap_or_default();
            std::env::join_paths(first.iter().map(|p| p.to_path_buf()).chain(std::env::split_paths(&old))).unwrap()
        };
        let stubs = directory.path().join("stubs");
        std::fs::create_dir(&stubs).unwrap();
        std::fs::copy(&stub, stubs.join("ximage")).unwrap();
        let raypath = std::env::var_os("RAYPATH").unwrap_or_else(|| format!(".:{}", radiance.join("../lib").display()).into());
        let bench = Self { ours: after(&[&bin, &radiance]), theirs: after(&[&stubs, &radiance]), raypath, directory };
        for (name, text) in [("scene.rad", SCENE), ("view1.vf", VIEW), ("unusual_view.cal", UNUSUAL)] {
            std::fs::write(bench.directory.path().join(name), text).unwrap();
        }
        std::fs::write(bench.directory.path().join("samples.inp"), "8 0 3 1 .1 0\n8 0 3 -1 .1 0\n0 0 1 1 .5 2\n8 0 3 1 0 -1\n").unwrap();
        bench.shell(&bench.theirs, "oconv scene.rad > scene.oct && rpict -vf view1.vf -x 64 -y 64 scene.oct > scene.hdr");
        Some(bench)
    }

    fn shell(&self, path: &OsString, script: &str) -> Vec<u8> {
        let mut shell = Command::new("sh");
        shell.args(["-c", script]).current_dir(self.directory.path()).env("PATH", path).env("RAYPATH", &self.raypath);
        let output = shell.output().unwrap();
        assert!(output.status.success(), "{script}: {}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    }

    /// What a script prints, ours and theirs.
    fn both(&self, script: &str) -> [Vec<u8>; 2] {
        [&self.ours, &self.theirs].map(|path| self.shell(path, script))
    }
}

/// The words of a text after its header, if it has one.
fn words(text: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(text);
    let body = if text.starts_with("#?") { text.split_once("\n\n").unwrap().1 } else { &text };
    body.split_whitespace().map(str::to_string).collect()
}

fn assert_alike(found: &[u8], wanted: &[u8], tolerance: f64) {
    let (found, wanted) = (words(found), words(wanted));
    assert_eq!(found.len(), wanted.len());
    assert!(!found.is_empty());
    for (f, w) in found.iter().zip(&wanted) {
        match (f.parse::<f64>(), w.parse::<f64>()) {
            (Ok(f), Ok(w)) => assert!((f - w).abs() <= tolerance * w.abs() + 1e-9, "{f} instead of {w}"),
            _ => assert_eq!(f, w),
        }
    }
}

/// The pixels of an uncompressed picture, resolution line first, in two halves.
fn pixels(picture: &[u8]) -> (&[u8], Vec<&[u8]>) {
    let end = picture.windows(2).position(|w| w == b"\n\n").unwrap() + 2;
    let line = picture[end..].iter().position(|&b| b == b'\n').unwrap();
    (&picture[end..end + line], picture[end + line + 1..].chunks_exact(4).collect())
}

/// Pixels that differ by more than a step of a mantissa, as a fraction of all.
fn apart(found: &[u8], wanted: &[u8]) -> f64 {
    let ((size, found), (wanted_size, wanted)) = (pixels(found), pixels(wanted));
    assert_eq!(size, wanted_size);
    assert_eq!(found.len(), wanted.len());
    let differs = |f: &[u8], w: &[u8]| f[3] != w[3] || f.iter().zip(w).any(|(a, b)| a.abs_diff(*b) > 1);
    found.iter().zip(&wanted).filter(|(f, w)| differs(f, w)).count() as f64 / found.len() as f64
}

#[test]
fn rtrace_radiance_of_samples() {
    let Some(bench) = Bench::new() else { return };
    let [ours, theirs] = bench.both("rtrace -ab 0 -dj 0 -ov scene.oct < samples.inp > radiance.out; cat radiance.out");
    assert_alike(&ours, &theirs, 1e-4);
    assert_eq!(words(&bench.shell(&bench.ours, "rtrace -ov scene.oct < samples.inp > radiance.out; cat radiance.out")).len(), 12);
    // The octree of a command, a frozen one.
    for scene in ["'!oconv scene.rad'", "frozen.oct", "scene.rad"] {
        let script = format!("oconv -f scene.rad > frozen.oct; rtrace -h -ab 0 -dj 0 {scene} < samples.inp");
        assert_alike(&bench.shell(&bench.ours, &script), &theirs, 1e-4);
    }
}

#[test]
fn rtrace_irradiance_at_places_in_a_picture() {
    let Some(bench) = Bench::new() else { return };
    let example = "ximage scene.hdr | rtrace -h -x 1 -i scene.oct | rcalc -e '$1=47.4*$1+120*$2+11.6*$3'";
    assert_eq!(words(&bench.shell(&bench.ours, example)).len(), 2);
    let [ours, theirs] = bench.both(&example.replace("-x 1", "-x 1 -ab 0 -dj 0"));
    assert_alike(&ours, &theirs, 1e-4);
}

#[test]
fn rtrace_object_of_each_pixel() {
    let Some(bench) = Bench::new() else { return };
    let [ours, theirs] = bench.both("vwrays -fd scene.hdr | rtrace -fda `vwrays -d scene.hdr` -os scene.oct");
    assert_eq!(words(&ours), words(&theirs));
}

#[test]
fn rtrace_unusual_view() {
    let Some(bench) = Bench::new() else { return };
    let script = "cnt 480 640 | rcalc -e 'xr:640;yr:480' -f unusual_view.cal | rtrace\n\
                  -x 640 -y 480 -ab 0 -dj 0 -fac scene.oct > unusual.hdr; cat unusual.hdr"
        .replace("rtrace\n", "rtrace ");
    let [ours, theirs] = bench.both(&script);
    assert!(apart(&ours, &theirs) < 2e-3, "{}", apart(&ours, &theirs));
}

#[test]
fn vwrays_picture_by_rtrace() {
    let Some(bench) = Bench::new() else { return };
    let script = "vwrays -ff -vf view1.vf -x 1024 -y 1024 |\n\
                  rtrace -ab 0 -dj 0 `vwrays -d -vf view1.vf -x 1024 -y 1024` -ffc scene.oct > view1.hdr; cat view1.hdr";
    let [ours, theirs] = bench.both(script);
    assert!(apart(&ours, &theirs) < 2e-3, "{}", apart(&ours, &theirs));
    // The picture is one that other programs read.
    let sums = "pfilt -1 -x /4 -y /4 view1.hdr | pvalue -h -H -df | rcalc -if3 -e '$1=$1+$2+$3'";
    assert!(words(&bench.shell(&bench.ours, sums)).iter().all(|v| v.parse::<f64>().is_ok_and(|v| v >= 0.0)));
    let size = bench.shell(&bench.ours, "getinfo -d < view1.hdr");
    assert!(String::from_utf8_lossy(&size).contains("+X     1024"), "{}", String::from_utf8_lossy(&size));
}

#[test]
fn rpict_picture_of_a_view() {
    let Some(bench) = Bench::new() else { return };
    bench.shell(&bench.ours, "rpict -vp 10 5 3 -vd 1 -.5 0 scene.oct > scene.hdr");
    let ours = bench.shell(&bench.ours, "vwrays -ff scene.hdr | head -c 2400; vwrays -d scene.hdr");
    let wanted = bench.shell(&bench.theirs, "vwrays -ff -vp 10 5 3 -vd 1 -.5 0 | head -c 2400; vwrays -d -vp 10 5 3 -vd 1 -.5 0");
    assert_eq!(ours, wanted);
}

#[test]
fn vwrays_dimensions() {
    let Some(bench) = Bench::new() else { return };
    // What vwrays says of a view is the size of our picture of it.
    for view in [
        "-vtv -vh 40 -vv 20",
        "-vth -vh 180 -vv 90",
        "-vtc -vh 360 -vv 90",
        "-vts -vh 180 -vv 90",
        "-vta -vh 180 -vv 180",
        "-vtl -vh 3 -vv 2",
    ] {
        let view = format!("{view} -vp 9 -3 3 -vd .6 1 -.2 -x 100 -y 90");
        let said = String::from_utf8(bench.shell(&bench.theirs, &format!("vwrays -d {view}"))).unwrap();
        let made = bench.shell(&bench.ours, &format!("rpict {view} -ab 0 --spp 1 scene.oct | getinfo -d"));
        let number = |name: &str, text: &str| text.split(name).nth(1).unwrap().split_whitespace().next().unwrap().to_string();
        let made = String::from_utf8(made).unwrap();
        assert_eq!([number("-x", &said), number("-y", &said)], [number("+X", &made), number("-Y", &made)], "{view}");
    }
}
