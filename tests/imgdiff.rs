//! imgdiff as a program: what it prints, how it ends, and its agreement with RADIANCE's own tools where they are installed.

use crate::fed::fed;
use crate::skipped::skipped;
use inverad::picture::exr::{Plane, Planes};
use inverad::picture::{Header, Picture};
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// Runs imgdiff in `directory` with the words of `line`, and `input` on its standard input.
fn imgdiff(directory: &TempDir, line: &str, input: &[u8]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_imgdiff"));
    fed(command.args(line.split_whitespace()).current_dir(directory), input)
}

/// The status, the output, and what was said.
fn told(output: Output) -> (i32, String, String) {
    (output.status.code().unwrap(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
}

fn ok(directory: &TempDir, line: &str) -> String {
    let (status, out, said) = told(imgdiff(directory, line, b""));
    assert_eq!((status, said.as_str()), (0, ""), "{line}");
    out
}

fn fails(directory: &TempDir, line: &str) -> String {
    let (status, out, said) = told(imgdiff(directory, line, b""));
    assert_eq!((status, out.as_str()), (2, ""), "{line}");
    assert!(said.starts_with("imgdiff: error: ") && said.ends_with('\n') && said.lines().count() == 1, "{said}");
    said
}

fn picture(width: usize, pixels: &[[f32; 3]]) -> Picture {
    Picture { width, height: pixels.len() / width, header: Header::default(), pixels: pixels.to_vec() }
}

/// A directory with pictures of 2 × 2 pixels: a, b = a but for one pixel, 2 larger in each channel; m counts that pixel not, h half.
fn pictures() -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, pixels: &[[f32; 3]]| fs::write(directory.path().join(name), picture(2, pixels).write_exr().unwrap()).unwrap();
    write("a.exr", &[[1.0, 2.0, 3.0], [4.0; 3], [5.0; 3], [6.0; 3]]);
    write("b.exr", &[[1.0, 2.0, 3.0], [4.0; 3], [7.0; 3], [6.0; 3]]);
    write("m.exr", &[[1.0; 3], [1.0; 3], [0.0; 3], [1.0; 3]]);
    write("h.exr", &[[1.0; 3], [1.0; 3], [0.5; 3], [1.0; 3]]);
    write("nan.exr", &[[1.0, 2.0, 3.0], [4.0; 3], [f32::NAN; 3], [6.0; 3]]);
    write("black.exr", &[[0.0; 3]; 4]);
    fs::write(directory.path().join("wide.exr"), picture(4, &[[1.0; 3]; 4]).write_exr().unwrap()).unwrap();
    directory
}

#[test]
fn chi_squared_is_one_number_on_one_line() {
    let directory = pictures();
    assert_eq!(ok(&directory, "a.exr b.exr"), "12.0\n");
    assert_eq!(ok(&directory, "a.exr a.exr"), "0.0\n");
    assert_eq!(ok(&directory, "--metric max a.exr b.exr"), "2.0\n");
}

#[test]
fn several_measures_are_named() {
    let directory = pictures();
    assert_eq!(ok(&directory, "a.exr b.exr --metric chi2,mse,max"), "chi2 12.0\nmse 1.0\nmax 2.0\n");
    let all = ok(&directory, "--all a.exr b.exr");
    let names: Vec<_> = all.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(names, ["chi2", "mse", "rmse", "relmse", "mape", "psnr", "max"]);
    let json: serde_json::Value = serde_json::from_str(&ok(&directory, "--json --all a.exr b.exr")).unwrap();
    assert_eq!((json["chi2"].as_f64(), json["rmse"].as_f64(), json["pixels"].as_u64()), (Some(12.0), Some(1.0), Some(4)));
    assert_eq!((json["max_at"]["x"].as_u64(), json["max_at"]["y"].as_u64()), (Some(0), Some(1)));
    let same: serde_json::Value = serde_json::from_str(&ok(&directory, "--json --metric psnr a.exr a.exr")).unwrap();
    assert!(same["psnr"].is_null(), "what is infinite is null in JSON");
}

#[test]
fn masks_leave_pixels_out_or_count_them_in_part() {
    let directory = pictures();
    assert_eq!(ok(&directory, "--mask m.exr a.exr b.exr"), "0.0\n");
    assert_eq!(ok(&directory, "--mask h.exr a.exr b.exr"), "6.0\n");
    assert_eq!(ok(&directory, "--mask m.exr a.exr nan.exr"), "0.0\n", "what does not count need not be a number");
    assert!(fails(&directory, "--mask black.exr a.exr b.exr").contains("leaves no pixel"));
    assert!(fails(&directory, "--mask wide.exr a.exr b.exr").contains("wide.exr is 4 × 1 pixels"));
}

#[test]
fn a_picture_may_come_from_standard_input() {
    let directory = pictures();
    let b = fs::read(directory.path().join("b.exr")).unwrap();
    for line in ["a.exr -", "a.exr", "- a.exr"] {
        assert_eq!(told(imgdiff(&directory, line, &b)), (0, "12.0\n".into(), "".into()), "{line}");
    }
    let (status, _, said) = told(imgdiff(&directory, "- -", &b));
    assert_eq!((status, said.as_str()), (2, "imgdiff: error: standard input can be read only once; write - for one input only\n"));
}

#[test]
fn the_status_tells_whether_the_limit_was_exceeded() {
    let directory = pictures();
    for (line, status) in [("--fail-above 11.9", 1), ("--fail-above 12", 0), ("--fail-above 1.9 --metric max", 1), ("--fail-above=-1", 1)] {
        let (got, out, said) = told(imgdiff(&directory, &format!("{line} a.exr b.exr"), b""));
        assert_eq!((got, out.is_empty(), said.as_str()), (status, false, ""), "{line}");
    }
    assert!(fails(&directory, "--fail-above 1 --all a.exr b.exr").contains("--metric"));
    assert!(fails(&directory, "--fail-above nan a.exr b.exr").contains("nan"));
    assert!(fails(&directory, "--fail-above 1 --metric psnr a.exr b.exr").contains("psnr"));
}

#[test]
fn the_exposure_is_fitted_and_printed() {
    let directory = pictures();
    let bright = picture(2, &[[2.0, 4.0, 6.0], [8.0; 3], [10.0; 3], [12.0; 3]]);
    fs::write(directory.path().join("bright.exr"), bright.write_exr().unwrap()).unwrap();
    assert_eq!(ok(&directory, "--fit-exposure a.exr bright.exr"), "0.0\nscale 0.5\n");
    assert!(fails(&directory, "--fit-exposure a.exr black.exr").contains("no exposure fits"));
}

#[test]
fn variance_makes_chi_squared_statistical() {
    let directory = pictures();
    let mut planes = Planes::of(&picture(2, &[[9.0; 3]; 4]));
    planes.push_picture("variance", &[[0.25; 3]; 4]);
    planes.planes.push(Plane::new("depth", vec![1.0; 4]));
    fs::write(directory.path().join("v.exr"), planes.write().unwrap()).unwrap();
    assert_eq!(ok(&directory, "--variance v.exr a.exr b.exr"), "48.0\ndof 12.0\n");
    fs::write(directory.path().join("plain.exr"), picture(2, &[[2.0; 3]; 4]).write_exr().unwrap()).unwrap();
    assert_eq!(ok(&directory, "--variance plain.exr a.exr b.exr"), "6.0\ndof 12.0\n");
    let (status, out, said) = told(imgdiff(&directory, "--variance m.exr a.exr b.exr", b""));
    assert_eq!((status, out.as_str()), (0, "0.0\ndof 9.0\n"));
    assert!(said.contains("warning: 3 values have no variance"), "{said}");
}

#[test]
fn an_independent_rendering_makes_products_of_differences() {
    let directory = pictures();
    let (status, out, said) = told(imgdiff(&directory, "--unbiased b.exr a.exr b.exr", b""));
    assert_eq!((status, out.as_str()), (0, "12.0\n"));
    assert!(said.starts_with("imgdiff: warning: b.exr and b.exr are the same, noise and all"), "{said}");
    assert_eq!(ok(&directory, "--unbiased a.exr a.exr b.exr"), "0.0\n");
    assert_eq!(ok(&directory, "--unbiased a.exr --all a.exr b.exr").lines().count(), 3);
    assert!(fails(&directory, "--unbiased a.exr --metric max a.exr b.exr").contains("--unbiased"));
}

#[test]
fn pictures_to_look_at_are_png_files() {
    let directory = pictures();
    assert_eq!(ok(&directory, "a.exr b.exr --heatmap heat.png --side-by-side side.png"), "12.0\n");
    for (name, width) in [("heat.png", 2), ("side.png", 14)] {
        let file = std::io::BufReader::new(fs::File::open(directory.path().join(name)).unwrap());
        let reader = png::Decoder::new(file).read_info().unwrap();
        assert_eq!((reader.info().width, reader.info().height), (width, 2));
    }
}

#[test]
fn trouble_is_one_line_that_says_what_to_do() {
    let directory = pictures();
    assert!(fails(&directory, "a.exr absent.exr").contains("absent.exr: no such file or directory"));
    assert!(fails(&directory, "a.exr wide.exr").contains("a.exr is 2 × 2 pixels, wide.exr is 4 × 1 pixels"));
    assert!(fails(&directory, "a.exr nan.exr").contains("nan.exr: the pixel in column 0 and row 1"));
    assert!(fails(&directory, "a.exr b.exr --metric chi").contains("chi"));
    assert!(fails(&directory, "a.exr b.exr --frobnicate").contains("--frobnicate"));
    assert!(fails(&directory, "a.exr b.exr -zz").contains("-zz"));
    assert!(fails(&directory, "").contains("required"));
    fs::write(directory.path().join("text"), "no picture\n").unwrap();
    assert!(fails(&directory, "a.exr text").contains("text: "));
}

#[test]
fn the_number_may_go_to_a_file() {
    let directory = pictures();
    assert_eq!(ok(&directory, "-o out.txt a.exr b.exr"), "");
    assert_eq!(fs::read_to_string(directory.path().join("out.txt")).unwrap(), "12.0\n");
    assert!(fails(&directory, "-o no/such/out.txt a.exr b.exr").contains("no/such/out.txt"));
}

#[test]
fn help_version_manual_and_completions_go_to_standard_output() {
    let directory = pictures();
    assert!(ok(&directory, "--help").contains("--fit-exposure"));
    assert_eq!(ok(&directory, "--version"), concat!("imgdiff ", env!("CARGO_PKG_VERSION"), "\n"));
    assert!(ok(&directory, "--man").contains(".TH imgdiff 1"));
    for shell in ["bash", "zsh", "fish"] {
        assert!(ok(&directory, &format!("--completions {shell}")).contains("fit-exposure"));
    }
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_quiet_and_a_full_device_is_not() {
    let directory = pictures();
    for line in ["a.exr b.exr", "--progress a.exr b.exr", "--help"] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = Command::new(env!("CARGO_BIN_EXE_imgdiff"));
        let output = command.args(line.split(' ')).current_dir(&directory).stdout(writer).stderr(Stdio::piped()).output().unwrap();
        assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), b"".as_slice()), "{line}");
    }
    // Nor does it matter that nobody listens to a message.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = Command::new(env!("CARGO_BIN_EXE_imgdiff")).args(["absent", "absent"]).stderr(writer).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    if Path::new("/dev/full").exists() {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_imgdiff"));
        let output = command.args(["a.exr", "b.exr"]).current_dir(&directory).stdout(full).stderr(Stdio::piped()).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(String::from_utf8(output.stderr).unwrap(), "imgdiff: error: standard output: no space left on device\n");
    }
}

/// A picture of 40 × 30 pixels with waves, brighter by `level`.
fn waves(level: f32) -> Picture {
    let value = |x: usize, y: usize, c: usize| level * (1.0 + (x as f32 * 0.3 + c as f32).sin() * (y as f32 * 0.2).cos()) + 0.01;
    picture(40, &(0..1200).map(|i| std::array::from_fn(|c| value(i % 40, i / 40, c))).collect::<Vec<_>>())
}

/// What a program of RADIANCE prints, or nothing, aloud, if it is not installed.
fn radiance(directory: &TempDir, program: &str, line: &str, output: &str) -> Option<()> {
    let spawned = Command::new(program).args(line.split_whitespace()).current_dir(directory).stderr(Stdio::null()).output();
    let Ok(out) = spawned else {
        skipped(&format!("{program} is not on PATH"));
        return None;
    };
    assert!(out.status.success(), "{program} {line}");
    fs::write(directory.path().join(output), out.stdout).unwrap();
    Some(())
}

#[test]
fn the_sum_is_that_of_the_values_that_radiance_prints() {
    let directory = tempfile::tempdir().unwrap();
    for (name, level) in [("a.hdr", 1.0), ("b.hdr", 1.1)] {
        let mut picture = waves(level);
        picture.header.push(&format!("EXPOSURE={level}"));
        fs::write(directory.path().join(name), picture.write_hdr().unwrap()).unwrap();
        if radiance(&directory, "pvalue", &format!("-h -H -d -df -o {name}"), &format!("{name}.f")).is_none() {
            return;
        }
    }
    let floats = |name: &str| -> Vec<f64> {
        let bytes = fs::read(directory.path().join(name)).unwrap();
        bytes.chunks_exact(4).map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap()))).collect()
    };
    let theirs: f64 = floats("a.hdr.f").iter().zip(floats("b.hdr.f")).map(|(a, b)| (a - b) * (a - b)).sum();
    let ours: f64 = ok(&directory, "a.hdr b.hdr").trim().parse().unwrap();
    assert!((ours - theirs).abs() < 1e-5 * theirs, "{ours} {theirs}");
}

#[test]
fn what_radiance_turns_scales_or_converts_is_the_same_picture() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("a.hdr"), waves(1.0).write_hdr().unwrap()).unwrap();
    // Pixels are doubled and the header says so; stored as runs of another kind; multiplied by an exact quarter.
    for (program, line) in [("pfilt", "-1 -e 2 a.hdr"), ("ra_rgbe", "-r a.hdr"), ("pcomb", "-s .25 -o a.hdr")] {
        if radiance(&directory, program, line, "b.hdr").is_none() {
            return;
        }
        let (a, b) = if program == "pcomb" { ("quarter.hdr", "b.hdr") } else { ("a.hdr", "b.hdr") };
        let mut quarter = waves(1.0);
        quarter.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|v| v / 4.0));
        fs::write(directory.path().join("quarter.hdr"), quarter.write_hdr().unwrap()).unwrap();
        assert_eq!(ok(&directory, &format!("{a} {b}")), "0.0\n", "{program} {line}");
    }
    // XYZE rounds again: a step of 1/128 of the largest channel, in each of 3600 values below 2.02.
    if radiance(&directory, "ra_xyze", "a.hdr", "xyz.hdr").is_some() {
        let rms: f64 = ok(&directory, "--metric rmse a.hdr xyz.hdr").trim().parse().unwrap();
        assert!(rms > 0.0 && rms < 2.02 / 128.0, "{rms}");
    }
}
