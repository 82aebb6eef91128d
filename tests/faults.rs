//! What goes wrong around the programs: kills at any moment, full disks, closed pipes, slow writers, Ctrl-C. Files are old or whole and
//! new, a search goes on to the same bytes, memory stays what it was.
//!
//! `FAULTS=200 cargo test --release --test suite faults:: -- --nocapture` (`make faults`) kills more often and soaks longer.

#![cfg(target_os = "linux")]

use inverad::sampling::mix64;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const START: &str = "void metal m\n0\n0\n5 .5 .5 .5 .5 .1\nm sphere s 0 0 4 0 0 0 1\n";

/// A quadratic in the material's numbers.
const FAKE: &str = r#"awk '/^5 /{printf "%.17g\n", .02+($2-.8)^2+($3-.6)^2+($4-.3)^2+($5-.9)^2+10*($6-.01)^2}' $MATERIAL"#;

/// How often to kill.
fn faults() -> u64 {
    std::env::var("FAULTS").ok().and_then(|count| count.parse().ok()).unwrap_or(12)
}

fn directory() -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("start.rad"), START).unwrap();
    directory
}

fn command(program: &str, directory: &Path, words: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.current_dir(directory).env("TMPDIR", directory).args(words).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

const ANNEAL: &str = env!("CARGO_BIN_EXE_anneal");
const RPARSE: &str = env!("CARGO_BIN_EXE_rparse");
const IMGDIFF: &str = env!("CARGO_BIN_EXE_imgdiff");
const RTRACE: &str = env!("CARGO_BIN_EXE_rtrace-rs");

/// A part of a span of time that differs from time to time, the same way in each run.
fn moment(round: u64, span: Duration) -> Duration {
    span.mul_f64(mix64(round + 1) as f64 / u64::MAX as f64)
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Waits for its end, but not longer.
fn ends_within(child: &mut Child, time: Duration) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < time {
        if child.try_wait().unwrap().is_some() {
            return true;
        }
        sleep(Duration::from_millis(2));
    }
    child.try_wait().unwrap().is_some()
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("sh").args(["-c", &format!("kill -{name} {}", child.id())]).status().unwrap();
    assert!(sent.success());
}

fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(directory).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_search_that_is_killed_goes_on_to_the_same_bytes() {
    let directory = directory();
    let at = |name: &str| directory.path().join(name);
    let words = |state: &'static str, log: &'static str| {
        ["--exec", FAKE, "--steps", "400", "--state", state, "--log", log, "start.rad"].map(String::from)
    };
    let run = |state, log| command(ANNEAL, directory.path(), &words(state, log).each_ref().map(String::as_str));
    let whole = run("whole", "whole.jsonl").output().unwrap();
    assert!(whole.status.success(), "{}", said(&whole));
    // What was not kept is done again: some rounds must last longer than the half second between two savings.
    let span = Duration::from_millis(1000);
    let (mut kills, mut ends) = (0, 0);
    while kills < faults() || ends == 0 {
        let mut child = run("cut", "cut.jsonl").spawn().unwrap();
        if !ends_within(&mut child, moment(kills + 1000 * ends, span)) {
            child.kill().unwrap();
            child.wait().unwrap();
            kills += 1;
            if at("cut").exists() {
                let best = command(ANNEAL, directory.path(), &["best", "cut"]).output().unwrap();
                let fresh = said(&best).contains("nothing was evaluated yet");
                assert!(best.status.success() || fresh, "after kill {kills}: {}", said(&best));
            }
            continue;
        }
        let cut = child.wait_with_output().unwrap();
        assert!(
            cut.stdout == whole.stdout,
            "{} instead of {}",
            String::from_utf8_lossy(&cut.stdout),
            String::from_utf8_lossy(&whole.stdout)
        );
        for (a, b) in [("whole", "cut"), ("whole.jsonl", "cut.jsonl")] {
            assert_eq!(fs::read(at(a)).unwrap(), fs::read(at(b)).unwrap(), "{a}");
            fs::remove_file(at(b)).unwrap();
        }
        ends += 1;
    }
    eprintln!("{kills} kills of anneal --state, {ends} searches ended with the same bytes");
}

#[test]
fn a_file_is_old_or_whole_and_new_when_its_writer_is_killed() {
    let directory = directory();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("big.rad"), "m sphere s 0 0 4 0 0 0 1 # a comment that takes some room\n".repeat(100_000)).unwrap();
    let words = ["--keep", "-o", "out.rad", "big.rad"];
    let begin = Instant::now();
    assert!(command(RPARSE, directory.path(), &words).status().unwrap().success());
    let (span, new) = (begin.elapsed().mul_f64(1.1), fs::read(at("out.rad")).unwrap());
    let (mut kills, mut olds, mut round) = (0, 0, 0);
    while kills < faults() {
        round += 1;
        fs::write(at("out.rad"), "old").unwrap();
        let mut child = command(RPARSE, directory.path(), &words).spawn().unwrap();
        if !ends_within(&mut child, moment(round, span)) {
            child.kill().unwrap();
            kills += 1;
        }
        child.wait().unwrap();
        let found = fs::read(at("out.rad")).unwrap();
        assert!(found == b"old" || found == new, "{} bytes", found.len());
        olds += u64::from(found == b"old");
        // What a killed program leaves can be told by its name.
        for name in names(directory.path()).iter().filter(|name| name.starts_with(".inverad-")) {
            fs::remove_file(at(name)).unwrap();
        }
        assert_eq!(names(directory.path()), ["big.rad", "out.rad", "start.rad"]);
    }
    eprintln!("{kills} kills of a program with -o in {round} runs: {olds} old files, the others whole and new");
}

#[test]
fn an_interrupted_writer_leaves_the_old_file_and_nothing_else() {
    let directory = directory();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("big.rad"), "m sphere s 0 0 4 0 0 0 1 # a comment that takes some room\n".repeat(100_000)).unwrap();
    let words = ["--keep", "-o", "out.rad", "big.rad"];
    let begin = Instant::now();
    assert!(command(RPARSE, directory.path(), &words).status().unwrap().success());
    let (span, new) = (begin.elapsed(), fs::read(at("out.rad")).unwrap());
    for round in 0..faults().div_ceil(4) {
        fs::write(at("out.rad"), "old").unwrap();
        let mut child = command(RPARSE, directory.path(), &words).spawn().unwrap();
        if !ends_within(&mut child, moment(round + 7, span)) {
            signal(&child, "INT");
        }
        child.wait().unwrap();
        let found = fs::read(at("out.rad")).unwrap();
        assert!(found == b"old" || found == new, "{} bytes", found.len());
        assert_eq!(names(directory.path()), ["big.rad", "out.rad", "start.rad"]);
    }
}

#[test]
fn a_search_that_is_interrupted_twice_ends_at_once_and_leaves_nothing() {
    let directory = directory();
    let mut child = command(ANNEAL, directory.path(), &["--exec", "sleep 2; echo 1", "start.rad"]).spawn().unwrap();
    for wait in [300, 500] {
        sleep(Duration::from_millis(wait));
        signal(&child, "INT");
    }
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(directory.path()), ["start.rad"]);
}

#[test]
fn a_picture_that_is_interrupted_is_whole_with_fewer_samples() {
    let directory = directory();
    let words = ["-vp", "0", "-5", "0", "-x", "40", "-y", "40", "--spp", "4000000", "-o", "out.hdr", "start.rad"];
    let mut child = command(RTRACE, directory.path(), &words).spawn().unwrap();
    sleep(Duration::from_millis(700));
    signal(&child, "INT");
    // The first signal asks; the second one does not wait for the round to end.
    if !ends_within(&mut child, Duration::from_secs(5)) {
        signal(&child, "INT");
    }
    assert!(ends_within(&mut child, Duration::from_secs(5)), "it does not end");
    let done = child.wait_with_output().unwrap();
    match done.status.code() {
        // It is not what was asked for: make must not take it for done.
        Some(1) => {
            assert_eq!(names(directory.path()), ["out.hdr", "start.rad"]);
            let said = said(&done);
            assert!(said.starts_with("rtrace-rs: note: interrupted at ") && said.lines().count() == 1, "{said}");
            assert!(said.contains(" samples a pixel, error ") && said.ends_with("; the picture is the best so far\n"), "{said}");
        }
        Some(130) => assert_eq!(names(directory.path()), ["start.rad"]),
        other => panic!("{other:?}: {}", said(&done)),
    }
}

/// What a line of the shell printed and said, with its exit status.
fn shell(directory: &Path, line: &str) -> (Option<i32>, String, String) {
    let mut command = Command::new("bash");
    command.args(["-c", line]).current_dir(directory);
    for (name, program) in [("ANNEAL", ANNEAL), ("RPARSE", RPARSE), ("IMGDIFF", IMGDIFF), ("RTRACE", RTRACE)] {
        command.env(name, program);
    }
    let output = command.output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned(), said(&output))
}

#[test]
fn a_closed_pipe_is_a_quiet_end() {
    let directory = directory();
    fs::write(directory.path().join("big.rad"), START.repeat(20_000)).unwrap();
    let picture = "$RTRACE -vp 0 -5 0 -x 300 -y 300 --spp 1 -pa 1 start.rad";
    for line in [
        "$RPARSE big.rad | head -c 10 > /dev/null; echo ${PIPESTATUS[0]}",
        "$RPARSE --json big.rad | head -1 > /dev/null; echo ${PIPESTATUS[0]}",
        "$RPARSE --help | true; echo ${PIPESTATUS[0]}",
        &format!("{picture} | head -c 10 > /dev/null; echo ${{PIPESTATUS[0]}}"),
        &format!("{picture} > a.hdr; {{ sleep .1; $IMGDIFF a.hdr a.hdr; }} | true; echo ${{PIPESTATUS[0]}}"),
        "$ANNEAL --exec 'sleep .02; echo 1' --steps 3 -q start.rad | true; echo ${PIPESTATUS[0]}",
    ] {
        assert_eq!(shell(directory.path(), line), (Some(0), "0\n".into(), String::new()), "{line}");
    }
    // The answer stands although nobody reads the number.
    let line = format!("{picture} > b.hdr; {{ sleep .1; $IMGDIFF --fail-above -1 a.hdr b.hdr; }} | true; echo ${{PIPESTATUS[0]}}");
    assert_eq!(shell(directory.path(), &line).1, "1\n");
}

#[test]
fn a_full_disk_is_said_and_harms_no_file() {
    let directory = directory();
    fs::write(directory.path().join("big.rad"), START.repeat(20_000)).unwrap();
    fs::write(directory.path().join("out"), "old").unwrap();
    for line in [
        "$RPARSE big.rad > /dev/full",
        "$RTRACE -vp 0 -5 0 -x 30 -y 30 --spp 1 start.rad > /dev/full",
        "$RTRACE -vp 0 -5 0 -x 9 -y 9 --spp 1 start.rad > a.hdr && $IMGDIFF a.hdr a.hdr > /dev/full",
        "$ANNEAL --exec 'echo 1' --steps 3 -q start.rad > /dev/full",
        "$ANNEAL --exec 'echo 1' --steps 3 -q --state /dev/full start.rad",
        "$ANNEAL --exec 'echo 1' --steps 3 -q --log /dev/full start.rad",
    ] {
        let (status, printed, said) = shell(directory.path(), line);
        assert_eq!((status, printed.as_str(), said.lines().count()), (Some(2), "", 1), "{line}: {said}");
        assert!(said.contains("no space left on device") || said.contains("/dev/full"), "{line}: {said}");
    }
    // No file may grow beyond 8 blocks: the writer dies, the old file stays.
    let (status, ..) = shell(directory.path(), "ulimit -f 8; $RPARSE big.rad -o out");
    assert!(status != Some(0) && fs::read_to_string(directory.path().join("out")).unwrap() == "old", "{status:?}");
}

#[test]
fn a_slow_writer_is_waited_for() {
    let directory = directory();
    let slow = |file: &str| format!("{{ head -c 20 {file}; sleep .2; tail -c +21 {file} | head -c 30; sleep .2; tail -c +51 {file}; }}");
    let (_, direct, _) = shell(directory.path(), "$RPARSE start.rad");
    assert_eq!(shell(directory.path(), &format!("{} | $RPARSE -", slow("start.rad"))), (Some(0), direct, String::new()));
    shell(directory.path(), "$RTRACE -vp 0 -5 0 -x 9 -y 9 --spp 1 start.rad > a.hdr");
    let differs = format!("{} | $IMGDIFF a.hdr -", slow("a.hdr"));
    assert_eq!(shell(directory.path(), &differs), (Some(0), "0.0\n".into(), String::new()));
    let piped = format!("{} | $RTRACE -vp 0 -5 0 -x 9 -y 9 --spp 1 - | tail -c 100 | cksum; tail -c 100 a.hdr | cksum", slow("start.rad"));
    let (_, printed, _) = shell(directory.path(), &piped);
    let sums: Vec<&str> = printed.lines().collect();
    assert!(sums.len() == 2 && sums[0] == sums[1], "{printed}");
}

/// Runs a search of so many steps: its memory in the first fifth of its time must be what it takes at most.
fn soak(directory: &Path, count: u64, words: &[&str]) {
    let steps = count.to_string();
    let words: Vec<&str> = ["-q", "--no-polish", "--steps", &steps, "start.rad"].iter().chain(words).copied().collect();
    let mut child = command(ANNEAL, directory, &words).spawn().unwrap();
    let (mut seen, begin) = (Vec::new(), Instant::now());
    // It is looked at before it is waited for: however quick the machine, it has been seen once.
    loop {
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let size = status.lines().find_map(|line| line.strip_prefix("VmRSS:")?.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok());
        seen.extend(size);
        if ends_within(&mut child, Duration::from_millis(5)) {
            break;
        }
    }
    let done = child.wait_with_output().unwrap();
    assert!(done.status.success(), "{}", said(&done));
    let most = |sizes: &[u64]| *sizes.iter().max().unwrap();
    let (early, late) = (most(&seen[..seen.len().div_ceil(5)]), most(&seen));
    eprintln!("{steps} steps of {} in {:.1?}: {early} KiB in the first fifth, {late} KiB at most", words[5], begin.elapsed());
    // What is kept of an evaluation is some hundred bytes.
    assert!(late <= early + early / 10 + 2 * (count * 300 / 1024) + 1024, "{early} KiB early, {late} KiB late");
}

#[test]
fn a_long_search_takes_no_more_memory_late_than_early() {
    let directory = directory();
    let (count, direct) = if faults() > 20 { (10_000, 10_000) } else { (300, 600) };
    // The shell alone is quick. What it prints changes, so that the search has something to do.
    soak(directory.path(), count, &["--exec", "read a < /proc/uptime; a=${a%% *}; echo ${a#*.}", "--state", "state"]);
    let sky = "void glow g 0 0 4 1 1 1 0\ng source sky 0 0 4 0 0 1 360\n";
    fs::write(directory.path().join("sky.rad"), sky).unwrap();
    shell(directory.path(), "$RTRACE -vp 0 -5 0 -x 3 -y 3 --spp 64 start.rad sky.rad > target.hdr");
    soak(directory.path(), direct, &["--direct", "-ab", "0", "-vp", "0", "-5", "0", "--target", "target.hdr", "--scene", "sky.rad"]);
}
