//! The paint of a wall in a room that daylight enters by a window. Few samples find the window: the rendering is noisy all over, and nothing of that
//! noise may be taken for a fault of the picture.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};

const ROOM: &str = "void plastic white 0 0 5 .75 .75 .75 0 0\nvoid plastic carpet 0 0 5 .25 .2 .15 0 0\n\
                    it polygon back 0 0 12 0 4 0 4 4 0 4 4 3 0 4 3\n\
                    white polygon left 0 0 12 0 0 0 0 4 0 0 4 3 0 0 3\n\
                    white polygon ceiling 0 0 12 0 0 3 0 4 3 4 4 3 4 0 3\n\
                    white polygon front 0 0 12 0 0 0 0 0 3 4 0 3 4 0 0\n\
                    carpet polygon floor 0 0 12 0 0 0 4 0 0 4 4 0 0 4 0\n\
                    white polygon right 0 0 30 4 0 0 4 0 3 4 4 3 4 4 0 4 0 0 4 1 1 4 3 1 4 3 2.4 4 1 2.4 4 1 1\n\
                    void glow day 0 0 4 5 6 8 0\nday source sky 0 0 4 0 0 1 180\n\
                    void glow lawn 0 0 4 1 .9 .7 0\nlawn source ground 0 0 4 0 0 -1 180\n";

#[test]
fn paint_is_known_and_nothing_is_suspected() {
    let view = "-vp 1 .3 1.5 -vd .4 1 0 -vh 60 -vv 50 -x 64 -y 64 --spp 512 --seed 6 -ab 3 -o target.hdr";
    let directory = photographed("plastic it 0 0 5 .7 .6 .45 .03 .15", ROOM, view);
    let out = recovered(directory.path(), "-ab 3 -vp 1 .3 1.5 -vd .4 1 0 -vh 60 -vv 50 --scene scene.rad --target target.hdr start.rad");
    for (name, truth) in [("red", 0.7), ("green", 0.6), ("blue", 0.45), ("spec", 0.03)] {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 3.0 * error && error < 0.02, "{name}: {value} ± {error}, not {truth}");
    }
    assert!(!out.contains("whole areas") && !out.contains("blurred"), "a warning of what is not so");
}

#[test]
fn a_patch_of_sun_on_the_floor_lights_what_is_in_the_shade() {
    // The sun comes in by a hole in the wall; few directions from the ball find where it shines.
    let scene = "void light solar 0 0 3 5e6 5e6 4.5e6\nsolar source sun 0 0 4 0 -1 1 .5\n\
                 void plastic wall 0 0 5 .6 .6 .55 0 0\nvoid plastic carpet 0 0 5 .3 .2 .2 0 0\n\
                 carpet polygon floor 0 0 12 0 0 0 4 0 0 4 5 0 0 5 0\nwall polygon ceiling 0 0 12 0 0 3 0 5 3 4 5 3 4 0 3\n\
                 wall polygon back 0 0 12 0 5 0 4 5 0 4 5 3 0 5 3\nwall polygon left 0 0 12 0 0 0 0 5 0 0 5 3 0 0 3\n\
                 wall polygon right 0 0 12 4 0 0 4 0 3 4 5 3 4 5 0\n\
                 wall polygon front 0 0 30 0 0 0 0 0 3 4 0 3 4 0 0 0 0 0 1.7 0 1.8 2 0 1.8 2 0 2.1 1.7 0 2.1 1.7 0 1.8\n\
                 it sphere ball 0 0 4 2.9 3.2 .5 .4\n";
    let view = "-vp 1.2 .6 1.6 -vd 1.7 2.4 -1 -vh 24 -vv 24 -ab 3";
    let directory =
        photographed("plastic it 0 0 5 .5 .3 .2 .05 .1", scene, &format!("{view} -x 40 -y 40 --spp 1000 --seed 6 -o target.hdr"));
    let out = recovered(directory.path(), &format!("{view} --scene scene.rad --target target.hdr start.rad"));
    for (name, truth) in [("red", 0.5), ("green", 0.3), ("blue", 0.2), ("spec", 0.05), ("rough", 0.1)] {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 4.0 * error && error < 0.01, "{name}: {value} ± {error}, not {truth}");
    }
}
