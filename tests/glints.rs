//! Clear glass among small bright lights: few samples of a pixel find them, so that most pixels of a photograph are a little too dark. What holds
//! back the few that are far too bright must not make the glass darker for that.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};

const SCENE: &str = "void brightfunc lights 2 1+if(sin(7*Dx+1)*sin(6*Dy+2)*sin(8*Dz)-.97,400,0) . 0 0\n\
                     lights glow sky 0 0 4 1 1.1 1.2 0\nsky source sky 0 0 4 0 0 1 360\n\
                     it sphere s1 0 0 4 -.8 0 0 .5\nit sphere s2 0 0 4 .4 .6 .2 .6\nit sphere s3 0 0 4 .3 -.8 -.3 .4\n";
const PHOTOGRAPHS: u32 = 6;

#[test]
fn hartmanns_constant_stays_apart_from_the_index() {
    let directory =
        photographed("dielectric it 0 0 5 .8 .7 .6 1.5 10", &SCENE.replace(",400,0)", ",4,0)"), "-x 48 -y 48 --spp 64 -ab 1 -o target.exr");
    std::fs::write(directory.path().join("start.rad"), "void dielectric it 0 0 5 .5 .5 .5 1.4 10\n").unwrap();
    let out = recovered(directory.path(), "-ab 1 --scene scene.rad --target target.exr start.rad");
    for (name, truth) in [("red", 0.8), ("green", 0.7), ("blue", 0.6), ("ior", 1.5)] {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 3.0 * error && error < 0.01, "{name}: {value} ± {error}, not {truth}");
    }
}

#[test]
fn the_unit_of_length_does_not_matter() {
    for size in [0.1, 1.0, 50.0f64] {
        let truth = [0.8f64, 0.5, 0.3].map(|through| through.powf(0.5 / size));
        let material = format!("dielectric it 0 0 5 {} {} {} 1.5 0", truth[0], truth[1], truth[2]);
        let sky = SCENE.split("it sphere").next().unwrap().replace(",400,0)", ",4,0)");
        let view = format!("-x 40 -y 40 --spp 256 -ab 1 -vp 0 {} {size} -o target.exr", -5.0 * size);
        let directory = photographed(&material, &format!("{sky}it sphere s 0 0 4 0 0 0 {size}\n"), &view);
        let out = recovered(directory.path(), "-ab 1 --scene scene.rad --target target.exr start.rad");
        for (name, truth) in ["red", "green", "blue"].into_iter().zip(truth) {
            let (value, error) = said(&out, name);
            assert!((value - truth).abs() < 3.0 * error && error < 0.02 * (1.0 - truth), "{size}: {name}: {value} ± {error}, not {truth}");
        }
        let (index, error) = said(&out, "ior");
        assert!((index - 1.5).abs() < 3.0 * error && error < 0.001, "{size}: {index} ± {error}");
    }
}

#[test]
fn clear_glass_is_not_too_dark() {
    let mut sums = [0.0; 3];
    for seed in 0..PHOTOGRAPHS {
        let view = format!("-x 48 -y 48 --spp 16 --seed {} -ab 1 -o target.exr", 100 + seed);
        let directory = photographed("dielectric it 0 0 5 .95 .9 .8 1.5 0", SCENE, &view);
        let arguments = "-ab 1 --fix ior --scene scene.rad --target target.exr start.rad";
        let out = recovered(directory.path(), arguments);
        for (sum, (name, truth)) in sums.iter_mut().zip([("red", 0.95), ("green", 0.9), ("blue", 0.8)]) {
            let (value, error) = said(&out, name);
            let off = (value - truth) / error;
            assert!(off.abs() < 3.0, "{name}: {value} ± {error}, not {truth}");
            *sum += off;
        }
    }
    // Independent photographs err to both sides: of a mean of six, .4 is one standard error.
    let means = sums.map(|sum| sum / f64::from(PHOTOGRAPHS));
    assert!(means.iter().all(|mean| mean.abs() < 1.0), "off by {means:.2?} standard errors on the average");
}
