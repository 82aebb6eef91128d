//! The paint of a wall in a room that daylight enters by a window. Few samples find the window: the rendering is noisy all over, and nothing of that
//! noise may be taken for a fault of the picture.

mod photograph;
#[path = "photograph/said.rs"]
mod said;

use photograph::photographed;
use said::{recovered, said};

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
    let view = "-vp 1 .3 1.5 -vd .4 1 0 -vh 60 -vv 50 -x 80 -y 80 --spp 512 --seed 6 -ab 3 -o target.hdr";
    let directory = photographed("plastic it 0 0 5 .7 .6 .45 .03 .15", ROOM, view);
    let out = recovered(directory.path(), "-ab 3 -vp 1 .3 1.5 -vd .4 1 0 -vh 60 -vv 50 --scene scene.rad --target target.hdr start.rad");
    for (name, truth) in [("red", 0.7), ("green", 0.6), ("blue", 0.45), ("spec", 0.03)] {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 3.0 * error && error < 0.02, "{name}: {value} ± {error}, not {truth}");
    }
    assert!(!out.contains("whole areas") && !out.contains("blurred"), "a warning of what is not so");
}
