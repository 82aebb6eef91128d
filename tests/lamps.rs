//! A picture that was rendered with its lamps taken for points, as RADIANCE takes them, and with one bounce: its header says so, and that suffices.

use crate::photograph::said::{recovered, said};
use crate::photograph::{photographed, run};

const ROOM: &str = "it sphere ball 0 0 4 0 0 0 .8\nvoid plastic floor 0 0 5 .3 .3 .3 0 0\nfloor ring ground 0 0 8 0 0 -.8 0 0 1 0 4\n\
                    void light panel 0 0 3 20 20 20\npanel polygon lamp 0 0 12 -.3 -1.3 2 -.3 -.7 2 .3 -.7 2 .3 -1.3 2\n";

#[test]
fn lamps_and_bounces_are_those_of_the_rendering() {
    let view = "-dj 0 -ds .25 -ab 1 -x 60 -y 60 --spp 64 --seed 4 -o target.hdr";
    let directory = photographed("plastic it 0 0 5 .5 .3 .1 .05 .05", ROOM, view);
    let arguments = "--scene scene.rad --target target.hdr start.rad";
    let out = recovered(directory.path(), arguments);
    for (name, truth) in [("red", 0.5), ("green", 0.3), ("blue", 0.1), ("spec", 0.05), ("rough", 0.05)] {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 3.0 * error && error < 0.01 * truth + 0.001, "{name}: {value} ± {error}, not {truth}");
    }
    // What is typed holds: of a lamp that is seen in all its extent, the same picture is one of a smoother ball.
    let (value, error) = said(&recovered(directory.path(), &format!("-dj 1 -ds .05 {arguments}")), "rough");
    assert!(value + 5.0 * error < 0.05, "{value} ± {error}");
}

#[test]
fn that_is_said() {
    let directory = photographed("plastic it 0 0 5 .5 .3 .1 .05 .05", ROOM, "-dj 0 -ds .25 -ab 1 -x 60 -y 60 --spp 1 -o target.hdr");
    let remarks = |options: &str| {
        let arguments = format!("{options} --fix red,spec,rough --time .01 --scene scene.rad --target target.hdr start.rad");
        let out = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), &arguments);
        [out.stderr, out.stdout].map(|said| String::from_utf8(said).unwrap())
    };
    assert!(
        remarks("")[0].starts_with("anneal: note: target.hdr was rendered by rtrace-rs with -ab 1 -dj 0 -ds 0.25, and so it is here\n")
    );
    // A doubt stands in the answer's file too.
    for said in remarks("-ab 2 -dj 0") {
        assert!(said.contains(
            "warning: the target was rendered by rtrace-rs with -ab 1, and here light is reckoned with otherwise: leave -ab out"
        ));
    }
}
