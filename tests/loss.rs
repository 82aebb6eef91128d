//! What a search by renderings follows, and that it tells chi-squared all the same.

use crate::photograph::said::{recovered, said};
use crate::photograph::{photographed, run};
use std::fs;

const SCENE: &str = "void glow sky 0 0 4 1 1.2 1.5 0\nsky source all 0 0 4 0 0 1 360\nit sphere ball 0 0 4 0 0 0 1\n";

#[test]
fn what_is_followed_may_be_relative_and_what_is_told_is_chi_squared() {
    let directory = photographed("plastic it 0 0 5 .2 .4 .6 0 0", SCENE, "-x 24 -y 24 --spp 64 --seed 3 -ab 1 -o target.exr");
    let path = directory.path();
    let judged = |options: &str, measure: &str| {
        let words = format!("-ab 1 --scene scene.rad --target target.exr --log log {options} start.rad");
        let out = run(env!("CARGO_BIN_EXE_anneal"), path, &words);
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let log = fs::read_to_string(path.join("log")).unwrap();
        fs::remove_file(path.join("log")).unwrap();
        let first: serde_json::Value = serde_json::from_str(log.lines().next().unwrap()).unwrap();
        (String::from_utf8(out.stdout).unwrap(), first[measure].as_f64().unwrap(), String::from_utf8(out.stderr).unwrap())
    };
    let followed = [("chi2", "chi2"), ("relative", "loss"), ("log", "loss")]
        .map(|(loss, measure)| judged(&format!("--direct --steps 1 --no-polish --loss {loss}"), measure));
    let [told, others @ ..] = followed.each_ref().map(|(out, ..)| out.lines().next().unwrap());
    assert_eq!([told; 2], others, "of the same values, chi-squared is the same");
    // The ball is darker than 1, so that relative squares are larger; logarithms tell less of what is far off.
    let [chi2, relative, log] = followed.each_ref().map(|(_, followed, _)| *followed);
    assert!(relative > 2.0 * log && log > 2.0 * chi2 && followed[0].0.contains(&format!("chi2 {chi2:.3}")), "{followed:?}");
    // What is interrupted has no chi-squared yet.
    judged("--direct --steps 1 --no-polish --loss log --state state", "loss");
    let best = || String::from_utf8(run(env!("CARGO_BIN_EXE_anneal"), path, "best state").stdout).unwrap();
    assert!(best().starts_with("# chi2 "), "{}", best());
    let state = path.join("state");
    let mut kept: serde_json::Value = serde_json::from_slice(&fs::read(&state).unwrap()).unwrap();
    kept["chi2"] = serde_json::Value::Null;
    fs::write(&state, kept.to_string()).unwrap();
    assert!(best().starts_with("# loss "), "{}", best());
    let (_, _, said) = judged("--loss log --time 1", "chi2");
    assert!(said.contains("--loss is for --direct; it does nothing here"), "{said}");
    let out = run(env!("CARGO_BIN_EXE_anneal"), path, "--exec true --loss log start.rad");
    assert_eq!(out.status.code(), Some(2));
}

/// All renderings have the same noise, so that chi-squared is smooth: by its scatter alone red would be known to 1e-6.
#[test]
fn errors_hold_the_noise_that_all_renderings_share() {
    let lamp = "void light bulb 0 0 3 90 90 90\nbulb sphere lamp 0 0 4 -3 -4 4 .3\n";
    let directory =
        photographed("plastic it 0 0 5 .2 .4 .6 .1 .15", &format!("{lamp}{SCENE}"), "-x 24 -y 24 --spp 64 --seed 3 -ab 1 -o target.exr");
    let out = recovered(directory.path(), "-ab 1 --scene scene.rad --target target.exr --direct --steps 300 start.rad");
    for (name, truth) in [("red", 0.2), ("green", 0.4), ("blue", 0.6), ("spec", 0.1), ("rough", 0.15)] {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 4.0 * error && (1e-4..0.02).contains(&error), "{name}: {value} ± {error}, not {truth}");
    }
}
