//! The corpus of the fuzzers, replayed; and each of its files damaged at random, the same way each time.
//!
//! `FUZZ_RUNS=100000 cargo test --release --test suite fuzz:: -- --nocapture` damages more of them.

#[path = "../fuzz/targets.rs"]
mod targets;

use inverad::sampling::mix64;
use rayon::prelude::*;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Damaged files a target, when nothing is said.
const RUNS: u32 = 400;

/// The seeds of a target, each at most a few kilobytes.
fn corpus(name: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(name);
    let mut files: Vec<_> = fs::read_dir(&folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .collect();
    files.sort();
    files
}

#[test]
fn the_corpus_holds_no_surprise() {
    for (name, target) in targets::ALL {
        let seeds = corpus(name);
        assert!(!seeds.is_empty(), "{name} has no corpus");
        for (file, bytes) in &seeds {
            eprintln!("{name}/{file}");
            target(bytes);
        }
    }
}

#[test]
fn damage_at_random_holds_no_surprise() {
    let runs = std::env::var("FUZZ_RUNS").ok().and_then(|runs| runs.parse().ok()).unwrap_or(RUNS);
    let mut found = Vec::new();
    for (name, target) in targets::ALL {
        let (seeds, begin) = (corpus(name), Instant::now());
        let surprise = |run: u32| {
            let damaged = damaged(&seeds, run);
            std::panic::catch_unwind(|| target(&damaged)).err().map(|_| {
                let path = std::env::temp_dir().join(format!("fuzz-{name}-{run}"));
                let kept = fs::write(&path, &damaged).is_ok();
                format!("{name}, run {run}{}", if kept { format!(": {}", path.display()) } else { String::new() })
            })
        };
        found.par_extend((0..runs).into_par_iter().filter_map(surprise));
        eprintln!("{name}: {runs} damaged files in {:.1?}", begin.elapsed());
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// A seed with a few changes: bytes, stretches that move, go or come again, numbers at their ends, words of other seeds.
fn damaged(seeds: &[(String, Vec<u8>)], run: u32) -> Vec<u8> {
    let mut state = u64::from(run) << 32;
    let mut random = |below: usize| {
        state += 1;
        (mix64(state) % below as u64) as usize
    };
    let mut bytes = seeds[random(seeds.len())].1.clone();
    for _ in 0..1 + random(6) {
        let at = random(bytes.len() + 1);
        let length = random(17).min(bytes.len() - at);
        match random(8) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..at + length)),
            2 => {
                let stretch = bytes[at..at + length].to_vec();
                let to = random(bytes.len() + 1);
                bytes.splice(to..to, stretch);
            }
            3 => {
                const WORDS: [&[u8]; 12] =
                    [b"0", b"-1", b"1e999", b"nan", b"99999999999", b"\0", b"\xff\xff\xff\xff", b"\x7f\xff", b" ", b"\n", b"(", b"-a 9"];
                bytes.splice(at..at + length, WORDS[random(WORDS.len())].iter().copied());
            }
            4 => {
                let other = &seeds[random(seeds.len())].1;
                let from = random(other.len() + 1);
                let end = (from + random(65)).min(other.len());
                bytes.splice(at..at, other[from..end].iter().copied());
            }
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = if random(2) == 0 { *byte ^ (1 << random(8)) } else { random(256) as u8 };
                }
            }
        }
    }
    bytes
}
