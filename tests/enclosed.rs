//! The paint of all walls of a closed room. Light meets the unknown again and again: half of what is seen met it more often than products of its
//! coefficients tell.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};

const ROOM: &str = "void light warm 0 0 3 20 18 14\nwarm sphere bulb 0 0 4 .3 .2 .6 .1\n!genbox it room 2 2 2 -i | xform -t -1 -1 -1\n\
                    void plastic grey 0 0 5 .3 .3 .3 0 0\ngrey sphere ball 0 0 4 -.3 .5 -.6 .35\n";

#[test]
fn walls_that_light_each_other_are_as_white_as_they_are() {
    let view = "-vp 0 -.95 .3 -vd .1 1 -.3 -vh 75 -vv 75";
    let directory = photographed("plastic it 0 0 5 .9 .7 .4 .1 .1", ROOM, &format!("{view} -x 24 -y 24 --spp 512 --seed 7 -o target.hdr"));
    let out = recovered(directory.path(), &format!("{view} --fix spec --fix rough --scene scene.rad --target target.hdr start.rad"));
    for (name, truth) in [("red", 0.9), ("green", 0.7), ("blue", 0.4)] {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 3.0 * error + 0.0005 && error < 0.003, "{name}: {value} ± {error}, not {truth}");
    }
    assert!(!out.contains("exposure"), "a warning of what is not so");
}

#[test]
fn walls_of_metal_are_as_bright_as_they_are_whatever_their_roughness_was_taken_for() {
    // Two fifths of what is seen met the walls more often than products tell, and lobes lose light at grazing angles: how much, their roughness says.
    let view = "-vp -.95 -.3 .2 -vd 1 .3 -.2 -vh 75 -vv 75";
    let directory = photographed("metal it 0 0 5 .85 .8 .7 .5 .2", ROOM, &format!("{view} -x 20 -y 20 --spp 1024 --seed 7 -o target.hdr"));
    let found = |options: &str| {
        let arguments = format!("{view} --fix spec --param spec=.5:0:1 --scene scene.rad --target target.hdr {options} start.rad");
        recovered(directory.path(), &arguments)
    };
    let (out, hurried) = (found(""), found("--time .5"));
    for (name, truth, most) in [("red", 0.85, 0.002), ("green", 0.8, 0.002), ("blue", 0.7, 0.002), ("rough", 0.2, 0.006)] {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 3.0 * error + 0.0005 && error < most, "{name}: {value} ± {error}, not {truth}");
        // Where there is no time to look again by what was found, errors hold that.
        let (value, error) = said(&hurried, name);
        assert!((value - truth).abs() < 3.0 * error, "in a hurry, {name}: {value} ± {error}, not {truth}");
    }
}
