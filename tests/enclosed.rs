//! The paint of all walls of a closed room. Light meets the unknown again and again: half of what is seen met it more often than products of its
//! coefficients tell.

mod photograph;
#[path = "photograph/said.rs"]
mod said;

use photograph::photographed;
use said::{recovered, said};

const ROOM: &str = "void light warm 0 0 3 20 18 14\nwarm sphere bulb 0 0 4 .3 .2 .6 .1\n!genbox it room 2 2 2 -i | xform -t -1 -1 -1\n\
                    void plastic grey 0 0 5 .3 .3 .3 0 0\ngrey sphere ball 0 0 4 -.3 .5 -.6 .35\n";

#[test]
fn walls_that_light_each_other_are_as_white_as_they_are() {
    let view = "-vp 0 -.95 .3 -vd .1 1 -.3 -vh 75 -vv 75";
    for (material, names, truth) in [
        ("plastic it 0 0 5 .8 .8 .8 .1 .1", ["red", "spec", "rough"], [0.8, 0.1, 0.1]),
        ("plastic it 0 0 5 .9 .7 .4 0 0", ["red", "green", "blue"], [0.9, 0.7, 0.4]),
    ] {
        let directory = photographed(material, ROOM, &format!("{view} -x 32 -y 32 --spp 1024 --seed 6 -o target.hdr"));
        let out = recovered(directory.path(), &format!("{view} --scene scene.rad --target target.hdr start.rad"));
        for (name, truth) in names.iter().zip(truth) {
            let (value, error) = said(&out, name);
            assert!((value - truth).abs() < 3.0 * error + 0.001 && error < 0.01, "{material}: {name} {value} ± {error}");
        }
    }
}
