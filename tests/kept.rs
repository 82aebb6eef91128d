//! anneal --state and --log with a photograph: nothing is lost, and nothing is taken for what it is not.

#![cfg(unix)]

use crate::photograph::photographed;
use inverad::picture::Picture;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const SCENE: &str = "void light bulb 0 0 3 200 200 200\nbulb sphere lamp 0 0 4 -3 -4 4 .3\nvoid glow even 0 0 4 1 1 1 0\n\
                     even source sky 0 0 4 0 0 1 360\nit sphere s 0 0 4 0 0 0 1\n";
const ASKED: &str = "-ab 1 --scene scene.rad --target target.hdr --state state --log log.jsonl";

/// A directory with a photograph of a ball in it.
fn ball() -> TempDir {
    photographed("plastic it 0 0 5 .6 .4 .2 .1 .15", SCENE, "-x 40 -y 40 --spp 100 -ab 1 -o target.hdr")
}

fn anneal(directory: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_anneal"));
    command.current_dir(directory).args(arguments.split(' ')).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// What is printed and logged when it ends well, and how long that took.
fn done(directory: &Path, arguments: &str) -> (String, String, Duration) {
    let begin = Instant::now();
    let done = anneal(directory, arguments).output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    (String::from_utf8(done.stdout).unwrap(), fs::read_to_string(directory.join("log.jsonl")).unwrap(), begin.elapsed())
}

fn trouble(directory: &Path, arguments: &str) -> String {
    let done = anneal(directory, arguments).output().unwrap();
    assert_eq!((done.status.code(), done.stdout.len()), (Some(2), 0));
    String::from_utf8(done.stderr).unwrap()
}

#[test]
fn an_interrupted_recovery_says_what_is_known_by_then_and_keeps_nothing() {
    let directory = ball();
    let path = directory.path();
    let child = anneal(path, &format!("{ASKED} --tolerance 1e-9 start.rad")).spawn().unwrap();
    // From the first round on there is something to say.
    let begin = Instant::now();
    while fs::read_to_string(path.join("log.jsonl")).unwrap_or_default().is_empty() {
        assert!(begin.elapsed() < Duration::from_secs(120), "no round has ended");
        sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let done = child.wait_with_output().unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.contains("interrupted: "), "{said}");
    let text = String::from_utf8(done.stdout).unwrap();
    assert!(text.contains("# red 0.6") && text.contains("void plastic it"), "{text}");
    assert!(!path.join("state").exists());
}

#[test]
fn a_killed_recovery_ends_at_the_same_bytes_and_a_finished_one_is_not_done_again() {
    let directory = ball();
    let path = directory.path();
    let (whole, log, long) = done(path, &format!("{ASKED} start.rad"));
    fs::remove_file(path.join("state")).unwrap();
    // SIGKILL: the program cannot do anything about it.
    for share in [0.2, 0.5, 0.8] {
        let mut child = anneal(path, &format!("{ASKED} start.rad")).spawn().unwrap();
        sleep(long.mul_f64(share));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    for _ in 0..2 {
        let (again, lines, _) = done(path, &format!("{ASKED} start.rad"));
        assert_eq!((again, lines), (whole.clone(), log.clone()));
    }
    // No light is traced for an answer that is kept: it is what the state has.
    let mut state: serde_json::Value = serde_json::from_slice(&fs::read(path.join("state")).unwrap()).unwrap();
    state["found"]["recovery"]["chi2"] = 123.0.into();
    fs::write(path.join("state"), state.to_string()).unwrap();
    let (kept, ..) = done(path, &format!("{ASKED} start.rad"));
    let after_chi2 = |text: &str| text.split_once(" over ").unwrap().1.to_string();
    assert!(kept.starts_with("# chi2 123 over ") && after_chi2(&kept) == after_chi2(&whole), "{kept}");
    // Each round is a line.
    let lines: Vec<serde_json::Value> = log.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    for (i, line) in lines.iter().enumerate() {
        assert_eq!(line["round"].as_u64(), Some(i as u64 + 1));
        assert!(line["chi2"].is_f64() && line["values"]["rough"].is_f64() && line["errors"]["spec"].is_f64(), "{line}");
    }
    assert!(!lines.is_empty());
}

#[test]
fn a_state_is_not_taken_for_another_recovery() {
    let directory = ball();
    let path = directory.path();
    done(path, &format!("{ASKED} start.rad"));
    assert!(trouble(path, &format!("{ASKED} --fix rough start.rad")).contains("state: it keeps a recovery with other options; remove it"));
    for other in ["--seed 1", "--time 60"] {
        assert!(trouble(path, &format!("{ASKED} {other} start.rad")).contains("other options"));
    }
    // A round that knows the errors of some values only; an answer that has one value only.
    let state: serde_json::Value = serde_json::from_slice(&fs::read(path.join("state")).unwrap()).unwrap();
    let (mut round, mut answer) = (state.clone(), state);
    round["rounds"][1]["errors"].as_array_mut().unwrap().pop();
    answer["rounds"] = serde_json::json!([]);
    answer["found"]["recovery"]["values"].as_array_mut().unwrap().truncate(1);
    for matrix in ["covariance", "own", "common"] {
        answer["found"]["recovery"][matrix] = serde_json::json!({"size": 1, "cells": [0.01]});
    }
    for state in [round, answer] {
        fs::write(path.join("bent"), state.to_string()).unwrap();
        let bent = ASKED.replace("state state", "state bent");
        assert!(
            trouble(path, &format!("{bent} --report page.html start.rad")).contains("bent: not a recovery that anneal keeps (its parts")
        );
    }
    fs::write(path.join("scene.rad"), SCENE.replace("200", "201")).unwrap();
    assert!(trouble(path, &format!("{ASKED} start.rad")).contains("state: it keeps a recovery from other files"));
    fs::write(path.join("state"), "{}").unwrap();
    assert!(trouble(path, &format!("{ASKED} start.rad")).contains("state: not a recovery that anneal keeps"));
}

#[test]
fn a_search_by_renderings_is_not_taken_up_for_another_picture() {
    let directory = ball();
    let path = directory.path();
    let asked = "-ab 1 --scene scene.rad --target target.hdr --direct --steps 3 --no-polish --log log.jsonl --state direct";
    done(path, &format!("{asked} start.rad"));
    done(path, &format!("{asked} start.rad"));
    let other = asked.replace("-ab 1", "-ab 0");
    assert!(trouble(path, &format!("{other} start.rad")).contains("direct: it keeps a search with another picture, scene or view"));
    let mut picture = fs::read(path.join("target.hdr")).unwrap();
    *picture.last_mut().unwrap() ^= 1;
    fs::write(path.join("target.hdr"), picture).unwrap();
    assert!(trouble(path, &format!("{asked} start.rad")).contains("it keeps a search with another picture"));
}

#[test]
fn pixels_that_are_no_numbers_are_said() {
    let directory = ball();
    let path = directory.path();
    let mut picture = Picture::read(&fs::read(path.join("target.hdr")).unwrap(), "target.hdr").unwrap();
    for n in [0, 20 * 40 + 20] {
        picture.pixels[n] = [f32::NAN; 3];
    }
    fs::write(path.join("target.exr"), picture.write_exr().unwrap()).unwrap();
    let asked = "-ab 1 --scene scene.rad --target target.exr start.rad";
    assert!(trouble(path, asked).contains("the picture's pixel in column 20 and row 20 (from the upper left, from 0) is not finite"));
}

#[test]
fn pixels_that_were_left_out_stay_out_of_the_page() {
    let directory = ball();
    let path = directory.path();
    let mut picture = Picture::read(&fs::read(path.join("target.hdr")).unwrap(), "target.hdr").unwrap();
    picture.pixels.iter_mut().step_by(11).for_each(|p| *p = [0.0; 3]);
    fs::write(path.join("target.hdr"), picture.write_hdr().unwrap()).unwrap();
    let page = || {
        let (out, ..) = done(path, &format!("{ASKED} --report page.html start.rad"));
        assert!(out.contains("as a camera's dead ones are"), "{out}");
        fs::read_to_string(path.join("page.html")).unwrap()
    };
    assert!(page() == page());
}

#[test]
fn the_type_that_was_chosen_is_kept_too() {
    let directory = ball();
    let asked = format!("{ASKED} --type auto start.rad");
    let (first, ..) = done(directory.path(), &asked);
    assert!(first.starts_with("# type plastic"), "{first}");
    assert_eq!(done(directory.path(), &asked).0, first);
}
