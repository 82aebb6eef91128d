//! A dielectric whose normals point into it: the commonest mistake with one, which nothing in the picture gives away.

use crate::photograph::{photographed, run};
use std::fs;

const SKY: &str = "void brightfunc lights 2 1+if(sin(7*Dx+1)*sin(6*Dy+2)-.7,9,0) . 0 0\n\
                   lights glow sky 0 0 4 1 1.1 1.2 0\nsky source sky 0 0 4 0 0 1 360\n";
const PRISM: &str = "!genprism it p 3 0 .7 .6 -.3 -.5 -.4 -l 0 0 .9";

/// What is said of a picture of a prism of this material, if it is taken for one that is turned inside out, and if it is not.
fn said(material: &str) -> [(Option<i32>, String); 2] {
    let directory = photographed(material, &format!("{SKY}{PRISM}\n"), "-x 32 -y 32 --spp 64 -ab 1 -o target.exr");
    fs::write(directory.path().join("inside_out.rad"), format!("{SKY}{PRISM} | xform -I\n")).unwrap();
    fs::write(directory.path().join("start.rad"), "void dielectric it 0 0 5 .5 .5 .5 1.4 0\n").unwrap();
    ["inside_out", "scene"].map(|scene| {
        let arguments = format!("-ab 1 --scene {scene}.rad --target target.exr start.rad");
        let done = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), &arguments);
        (done.status.code(), String::from_utf8([done.stderr, done.stdout].concat()).unwrap())
    })
}

#[test]
fn a_prism_that_is_inside_out_is_named() {
    let [(_, wrong), (_, right)] = said("dielectric it 0 0 5 .8 .9 .95 1.5 0");
    assert!(wrong.contains("most of `it` is seen from its back") && wrong.contains("xform -I"), "{wrong}");
    assert!(!right.contains("its back"), "{right}");
}

#[test]
fn what_is_black_but_at_its_edges_tells_nothing() {
    let [wrong, right] = said("plastic it 0 0 5 0 0 0 0 0");
    assert_eq!([wrong.0, right.0], [Some(2); 2]);
    assert!(wrong.1.contains("black wherever it shows `it`: most of `it` is seen from its back"), "{}", wrong.1);
    assert!(right.1.contains("black wherever it shows `it`: check that it is the right one"), "{}", right.1);
}
