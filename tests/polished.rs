//! A surface whose roughness is up to .001 is a mirror with a Fresnel term in RADIANCE: what is found of it must be that.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};

/// A lamp under a sky, and the ball.
const SCENE: &str = "void light lamp 0 0 3 100 90 80\nlamp sphere l 0 0 4 3 -4 5 .2\nvoid glow sky 0 0 4 .5 .6 .9 0\nsky source above 0 0 4 0 0 1 180\n\
                     void glow ground 0 0 4 .2 .1 .1 0\nground source below 0 0 4 0 0 -1 180\nit sphere s 0 0 4 0 0 0 1\n";

/// Errors unless each value is within three standard errors of the truth, and these are less than the `most` there may be.
fn assert_near(out: &str, truth: &[(&str, f64)], most: f64) {
    for (name, truth) in truth {
        let (value, error) = said(out, name);
        assert!((value - truth).abs() < 3.0 * error && error < most, "{name} {value} ± {error}, not {truth}");
    }
}

fn check(material: &str, arguments: &str, truth: &[(&str, f64)]) {
    let directory = photographed(material, SCENE, "-x 48 -y 48 --spp 128 --seed 3 -o target.exr");
    let out = recovered(directory.path(), &format!("--seed 1 --scene scene.rad --target target.exr {arguments} start.rad"));
    assert_near(&out, truth, 0.003);
    assert!(!out.contains("warning"), "{out}");
}

/// Without the Fresnel term, the specularity came out as .068 ± .002.
#[test]
fn polished_plastic_is_found() {
    check("plastic it 0 0 5 .2 .1 .05 .04 0", "", &[("red", 0.2), ("green", 0.1), ("blue", 0.05), ("spec", 0.04), ("rough", 0.0)]);
}

#[test]
fn polished_metal_is_found_where_its_roughness_is_known() {
    check(
        "metal it 0 0 5 .8 .6 .4 .9 .0009",
        "--param rough=.0005:0:.001 --fix rough",
        &[("red", 0.8), ("green", 0.6), ("blue", 0.4), ("spec", 0.9)],
    );
}

/// Shadow rays go on through polished trans, and end at what is rough, as START.rad is here, or lets nothing through: by those of another start red was
/// .856 ± .001.
#[test]
fn polished_trans_is_found_from_any_start() {
    let truth = [("red", 0.8), ("green", 0.6), ("blue", 0.4), ("spec", 0.05), ("trans", 0.6), ("rough", 0.0)];
    for (start, told) in [("rough=.1:0:.3", 6), ("rough=0:0:.3 --param trans=0:0:1", 6), ("rough=0:0:.001 --fix rough", 5)] {
        let known = format!("--param tspec=.5:0:1 --fix tspec --param {start}");
        check("trans it 0 0 7 .8 .6 .4 .05 0 .6 .5", &known, &truth[..told]);
    }
}

/// RADIANCE leaves the Fresnel term of metal as it is, however dark a pattern: without that, red was .8115 ± .0009.
#[test]
fn polished_metal_is_found_under_a_pattern() {
    check(
        "brightfunc spots 2 .25+.75*if(sin(12*Pz)*sin(9*Px),1,0) . 0 0\nspots metal it 0 0 5 .8 .6 .4 .9 0",
        "--param rough=0:0:.001 --fix rough",
        &[("red", 0.8), ("green", 0.6), ("blue", 0.4), ("spec", 0.9)],
    );
}

/// What is mirrored has sharp edges, which a picture of few samples shows roughly: the pixels that tell most of a roughness are those that are worst.
/// By these alone it was a lobe of .0041 ± .0014, with a blue of .413 ± .002.
#[test]
fn a_mirror_of_sharp_edges_is_no_narrow_lobe() {
    let scene = "void brightfunc spots 2 if(sin(31*Dx)*sin(29*Dz+3*Dy)-.5,8,.3) . 0 0\nspots glow sky 0 0 4 1 1.1 1.2 0\n\
                 sky source sky 0 0 4 0 0 1 360\nit sphere s 0 0 4 0 0 0 1\n";
    for rough in [0.0, 0.005] {
        let material = format!("metal it 0 0 5 .7 .8 .4 .6 {rough}");
        let directory = photographed(&material, scene, "-ab 1 -x 80 -y 80 --spp 9 --seed 75 -o target.exr");
        let out = recovered(directory.path(), "--seed 1 -ab 1 --scene scene.rad --target target.exr start.rad");
        assert_near(&out, &[("red", 0.7), ("green", 0.8), ("blue", 0.4), ("spec", 0.6), ("rough", rough)], 0.01);
        assert_eq!(said(&out, "rough").0 > 0.001, rough > 0.001);
    }
}

/// Most pixels lack the light of a sun that few samples found, a few hold it all: a mirror comes nearest to that, of which 0 ± .005 was said.
#[test]
fn a_sun_that_few_samples_found_makes_no_mirror() {
    let scene = "void brightfunc day 2 1+.5*sin(5*Dx)*Dz+20000*if(Dx*.6-Dy*.64+Dz*.48-.9998,1,0) . 0 0\nday glow sky 0 0 4 1 1 1 0\n\
                 sky source all 0 0 4 0 0 1 360\nit sphere s 0 0 4 0 0 0 1\n";
    let directory = photographed("metal it 0 0 5 .8 .8 .8 .9 .15", scene, "-x 48 -y 48 --spp 16 -ss 1 -ab 1 -o target.exr");
    let out = recovered(directory.path(), "-ab 1 --scene scene.rad --target target.exr start.rad");
    assert!(out.contains("warning: single pixels hold"), "{out}");
    assert_near(&out, &[("red", 0.8), ("spec", 0.9), ("rough", 0.15)], f64::INFINITY);
}

/// Where small lamps are seen in a mirror, a few pixels make most of what chance does: 0 ± .002 to .006, and of a finer picture a lobe of .009 ± .0016
/// with colours of .904 .809 .714.
#[test]
fn a_mirror_among_lamps_is_no_lobe_nor_a_lobe_a_mirror() {
    let scene = "void plastic wall 0 0 5 .6 .58 .5 0 0\n!genbox wall room 8 9 6 -i | xform -t -4 -6 -1\n\
                 void light lamp 0 0 3 120 110 90\nlamp sphere one 0 0 4 -1.8 -2 2.6 .12\nlamp sphere two 0 0 4 2 -1.4 2.2 .09\n\
                 it sphere ball 0 0 4 -.5 0 0 .6\n!genbox it box .6 .6 .7 | xform -rz 25 -t .35 -.1 -.6\n";
    for rough in [0.0, 0.003] {
        let directory =
            photographed(&format!("metal it 0 0 5 .9 .8 .7 1 {rough}"), scene, "-ab 0 -av .3 .3 .3 -x 64 -y 64 --spp 64 -o target.exr");
        let out = recovered(directory.path(), "--seed 1 --scene scene.rad --target target.exr start.rad");
        assert_near(&out, &[("red", 0.9), ("green", 0.8), ("blue", 0.7), ("spec", 1.0), ("rough", rough)], f64::INFINITY);
        let (found, error) = said(&out, "rough");
        assert!(if rough > 0.0 { found > 0.001 } else { error < 0.001 }, "{out}");
    }
}
