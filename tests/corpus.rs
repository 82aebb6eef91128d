//! Real scene files, one by one: those that oconv accepts are loaded and rendered.

pub mod files;

use files::corpus;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The longest that a picture of 64 × 64 single samples may take.
const PATIENCE: Duration = Duration::from_secs(20);

/// What became of a scene.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Fate {
    Rendered,
    /// It holds something that is not rendered.
    Unsupported,
    /// A file or a command that it needs is not there.
    Incomplete,
    /// It is refused for another reason.
    Refused,
    Late,
    Crashed,
}

/// A program that finds library files in the directory of a scene and above it, as far as the corpus goes.
fn command(program: &str, scene: &Path, corpus: &Path) -> Command {
    let directories = scene.ancestors().skip(1).take_while(|d| *d != corpus).map(|d| d.display().to_string());
    let path: Vec<String> = directories.chain(std::env::var("RAYPATH")).collect();
    let mut command = Command::new(program);
    command.current_dir(scene.parent().unwrap()).env("RAYPATH", path.join(":")).stdin(Stdio::null()).stdout(Stdio::null());
    command
}

/// A view of all that a scene holds, from outside; of what is around the origin where it has no bounds.
fn view(scene: &Path, corpus: &Path) -> String {
    let stats = command(env!("CARGO_BIN_EXE_rparse"), scene, corpus).arg("--stats").arg(scene).stdout(Stdio::piped()).output().unwrap();
    let text = String::from_utf8_lossy(&stats.stdout).into_owned();
    let bounds = text.lines().find_map(|line| line.strip_prefix("bounds "));
    let numbers: Vec<f64> = bounds.into_iter().flat_map(str::split_whitespace).filter_map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [x0, y0, z0, x1, y1, z1, ..] => {
            let size = (x1 - x0).hypot(y1 - y0).hypot(z1 - z0);
            let [x, y, z] = [(x0 + x1) / 2.0 + 0.6 * size, (y0 + y1) / 2.0 - 0.9 * size, (z0 + z1) / 2.0 + 0.4 * size];
            format!("-vtv -vp {x} {y} {z} -vd -.6 .9 -.4 -vh 60 -vv 60")
        }
        _ => "-vta -vp 0 0 1.6 -vd 0 1 0 -vh 180 -vv 180".into(),
    }
}

/// Loads and renders a scene; what became of it and what was said.
fn render(scene: &Path, corpus: &Path) -> (Fate, String) {
    let directory = tempfile::tempdir().unwrap();
    let picture = directory.path().join("picture.hdr");
    let mut child = command(env!("CARGO_BIN_EXE_rtrace-rs"), scene, corpus)
        .args(format!("-n 1 --spp 1 -x 64 -y 64 {}", view(scene, corpus)).split_whitespace())
        .arg("-o")
        .args([&picture, scene])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if begin.elapsed() > PATIENCE {
            child.kill().unwrap();
            child.wait().unwrap();
            return (Fate::Late, String::new());
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let mut said = Vec::new();
    child.stderr.take().unwrap().read_to_end(&mut said).unwrap();
    let said = String::from_utf8_lossy(&said).into_owned();
    let fate = match status.code() {
        Some(0) if picture.exists() => Fate::Rendered,
        Some(2) if said.contains("is not rendered (") => Fate::Unsupported,
        Some(2) if said.contains(": not found in ") || said.contains("command not run") => Fate::Incomplete,
        Some(2) => Fate::Refused,
        _ => Fate::Crashed,
    };
    (fate, said)
}

#[test]
fn real_scenes_are_rendered() {
    let Some((corpus, files)) = corpus(&["oconv"]) else { return };
    let accepted = |scene: &&PathBuf| command("oconv", scene, &corpus).arg(scene).stderr(Stdio::null()).status().unwrap().success();
    let fates: Vec<(&PathBuf, Fate, String)> = files
        .par_iter()
        .filter(accepted)
        .map(|scene| {
            let (fate, said) = render(scene, &corpus);
            (scene, fate, said)
        })
        .collect();
    let mut repositories: BTreeMap<String, BTreeMap<Fate, usize>> = BTreeMap::new();
    for (scene, fate, said) in &fates {
        let inside = scene.strip_prefix(&corpus).unwrap();
        let repository = inside.iter().next().unwrap().to_string_lossy().into_owned();
        *repositories.entry(repository).or_default().entry(*fate).or_default() += 1;
        if *fate != Fate::Rendered {
            eprintln!("{fate:?} {}: {}", inside.display(), said.lines().next().unwrap_or(""));
        }
    }
    let share = |counts: &BTreeMap<Fate, usize>, fate| *counts.get(&fate).unwrap_or(&0) as f64 / counts.values().sum::<usize>() as f64;
    for (repository, counts) in &repositories {
        eprintln!("{repository}: {counts:?}");
    }
    for fate in [Fate::Rendered, Fate::Unsupported, Fate::Incomplete, Fate::Refused, Fate::Late, Fate::Crashed] {
        let count = fates.iter().filter(|(_, f, _)| *f == fate).count();
        let weighted = repositories.values().map(|counts| share(counts, fate)).sum::<f64>() / repositories.len() as f64;
        eprintln!("{fate:?}: {count} of {} scenes; {:.2} % with equal weights of repositories", fates.len(), 100.0 * weighted);
        match fate {
            Fate::Rendered => assert!(weighted >= 0.94),
            Fate::Refused | Fate::Late | Fate::Crashed => assert_eq!(count, 0),
            _ => {}
        }
    }
}
