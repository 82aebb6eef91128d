//! Lamps that are hard to find: the sun, which covers a part of a pixel, images of a lamp in mirrors that do not face the place, and a window that
//! is seen in a polished floor.

use inverad::picture::Picture;
use std::f64::consts::PI;
use std::process::Command;

/// A picture of a scene as `OpenEXR`, and the error that it is said to have.
fn picture(scene: &str, options: &str) -> (Picture, f64) {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("s.rad"), scene).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_rtrace-rs"));
    let output = command.current_dir(directory.path()).args(options.split_whitespace()).args(["--exr", "s.rad"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let picture = Picture::read(&output.stdout, "<stdout>").unwrap();
    let noise = picture.header.values("NOISE").last().unwrap().trim().parse().unwrap();
    (picture, noise)
}

/// The green of all pixels together.
fn sum(picture: &Picture) -> f64 {
    picture.pixels.iter().map(|p| f64::from(p[1])).sum()
}

#[test]
fn a_sun_of_a_part_of_a_pixel_is_as_bright_as_it_is_large() {
    let sun = "void light l 0 0 3 1e6 1e6 1e6\nl source s 0 0 4 .3 .2 1 .533\n";
    let half = f64::to_radians(0.533 / 2.0);
    let views = [
        // Angles are distances from the middle, and half the picture is a right angle.
        ("-vta -vp 0 0 0 -vd .3 .2 1 -vh 180 -vv 180 -x 63 -y 63", PI * (half / PI * 63.0).powi(2)),
        // A disk of the radius tan(half), where half the picture is tan 22.5°.
        ("-vtv -vp 0 0 0 -vd .3 .2 1 -vh 45 -vv 45 -x 200 -y 200", PI * (half.tan() / (PI / 8.0).tan() * 100.0).powi(2)),
    ];
    for (view, pixels) in views {
        for seed in 0..4 {
            let found = sum(&picture(sun, &format!("{view} -n 1 --seed {seed}")).0) / 1e6;
            assert!((found / pixels - 1.0).abs() < 0.03, "{view}: {found} pixels instead of {pixels}");
        }
        // By few samples of each pixel, and behind a ball in the way.
        let found = sum(&picture(sun, &format!("{view} -n 1 --spp 256")).0) / 1e6;
        assert!((found / pixels - 1.0).abs() < 0.05, "{view}: {found} pixels instead of {pixels}");
        let hidden = format!("{sun}void plastic p 0 0 5 0 0 0 0 0\np sphere b 0 0 4 3 2 10 1\n");
        assert_eq!(sum(&picture(&hidden, &format!("{view} -n 1 -ab 0")).0), 0.0);
    }
}

#[test]
fn mirrors_that_show_no_lamp_here_do_no_harm() {
    let room = "void plastic p 0 0 5 .5 .5 .5 0 0\np ring f 0 0 8 0 0 0 0 0 1 0 5\nvoid light l 0 0 3 100 100 100\n\
                l sphere a 0 0 4 0 0 3 .02\nvoid mirror m 0 0 3 .8 .8 .8\n";
    // Twelve mirrors around, far off, each of which shows the lamp to a part of the floor that is not seen.
    let mirrors: String = (0..12)
        .map(|i| {
            let (sin, cos) = (f64::from(i) * PI / 6.0).sin_cos();
            let corner = |along: f64, z: f64| format!("{} {} {z} ", 4.9 * cos - along * sin, 4.9 * sin + along * cos);
            format!("m polygon m{i} 0 0 12 {}\n", [corner(0.1, 2.0), corner(0.1, 2.2), corner(-0.1, 2.2), corner(-0.1, 2.0)].concat())
        })
        .collect();
    let view = "-vp 0 0 2.5 -vd 0 0 -1 -vu 0 1 0 -vh 30 -vv 30 -x 16 -y 16 -ab 0 -n 1 --spp 64";
    let ((without, noise), (with, own)) = (picture(room, view), picture(&(room.to_string() + &mirrors), view));
    assert!(own < 1.5 * noise + 1e-4, "{own} instead of {noise}");
    assert!((sum(&with) / sum(&without) - 1.0).abs() < 0.01);
}

#[test]
fn a_window_of_illum_lights_a_glossy_floor_as_one_of_light_does() {
    let window = |material: &str| {
        let scene = format!(
            "void plastic p 0 0 5 .2 .2 .2 .05 .05\np polygon f 0 0 12 -3 -3 0 3 -3 0 3 3 0 -3 3 0\nvoid {material} w 0 0 3 14 16 20\n\
             w polygon pane 0 0 12 -3 -1.5 .8 -3 1.5 .8 -3 1.5 2.3 -3 -1.5 2.3\n"
        );
        picture(&scene, "-vp 2.5 0 1.5 -vd -1 0 -.7 -vh 40 -vv 30 -x 24 -y 18 -ab 0 -n 1 --spp 64")
    };
    let ((illum, own), (light, noise)) = (window("illum"), window("light"));
    assert!(own < 1.1 * noise, "{own} instead of {noise}");
    assert!((sum(&illum) / sum(&light) - 1.0).abs() < 0.01);
}

/// Where RADIANCE takes a single sample of what a sheet reflects (`-ss 1`), what goes through it is the same: half of it was lost.
#[test]
fn a_patch_of_sun_is_seen_through_a_rough_sheet() {
    let scene = "void light solar 0 0 3 1e6 1e6 1e6\nsolar source sun 0 0 4 2 0 1 .5\nvoid plastic wall 0 0 5 .5 .5 .5 .05 .1\n\
                 wall ring floor 0 0 8 0 0 0 0 0 1 0 3\nwall ring roof 0 0 8 0 0 2 0 0 -1 .15 3\nwall cylinder round 0 0 7 0 0 0 0 0 2 3\n\
                 void trans veil 0 0 7 .9 .9 .9 .04 .2 .95 .9\nveil polygon sheet 0 0 12 -1 -.3 .5 -1 .3 .5 -1 .3 1.1 -1 -.3 1.1\n";
    let seen = |rules: &str| {
        let (picture, _) = picture(scene, &format!("-vp 1 0 1 -vd -1 0 -.3 -vh 120 -vv 120 -x 48 -y 48 -ab 2 --spp 256 {rules}"));
        (17..22).flat_map(|y| (21..27).map(move |x| (x, y))).map(|(x, y)| f64::from(picture.at(x, y)[1])).sum::<f64>()
    };
    let (all, single) = (seen(""), seen("-ss 1"));
    assert!((single / all - 1.0).abs() < 0.15, "{single}, {all}");
}
