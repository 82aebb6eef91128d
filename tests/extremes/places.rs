//! The same picture, whatever the size of the scene and wherever it is; the same albedo on every shape.

use super::table::{FURNACE, Room, Table};
use inverad::geometry::Ray;
use inverad::vector::Vec3;

/// Everything a path can meet, around a ball of the material `m`.
const SCENE: &str = "void glow sky_glow 0 0 4 .3 .3 .3 0\nsky_glow source sky 0 0 4 0 0 1 360\nvoid light lamp 0 0 3 40 30 20\n\
    lamp sphere bulb 0 0 4 2 -1 3 .2\nvoid plastic ground 0 0 5 .5 .4 .3 0 0\nground ring floor 0 0 8 0 0 -1.2 0 0 1 0 5\n\
    void metal dull 0 0 5 .6 .6 .6 .9 .1\ndull polygon wall 0 0 12 -4 3 -1.2 4 3 -1.2 4 3 3 -4 3 3\nm sphere ball 0 0 4 0 0 0 1\n";

/// One of each type.
const MATERIALS: [&str; 11] = [
    "plastic m 0 0 5 .5 .4 .3 .05 .1",
    "plastic m 0 0 5 .5 .4 .3 .05 0",
    "metal m 0 0 5 .9 .6 .2 .9 .05",
    "trans m 0 0 7 .8 .6 .4 .05 .1 .6 .4",
    "plastic2 m 4 0 0 1 . 0 6 .5 .4 .3 .05 .05 .2",
    "metal2 m 4 0 0 1 . 0 6 .5 .4 .3 .05 .05 .2",
    "trans2 m 4 0 0 1 . 0 8 .8 .6 .4 .05 .1 .3 .6 .5",
    "dielectric m 0 0 5 .999999 .99999 .99998 1.5 0",
    "interface m 0 0 8 .999999 .99999 .99998 1.5 1 1 .99999 1.33",
    "glass m 0 0 3 .9 .8 .7",
    "mirror m 0 0 3 .9 .8 .7",
];

/// The lights of a grid of rays at the scene, enlarged and then moved.
fn picture(material: &str, scale: f64, shift: Vec3) -> Vec<f64> {
    let scene = format!("void {material}\n{SCENE}");
    let line = format!("!xform -s {scale:e} -t {} {} {} scene_at_home.rad\n", shift.x, shift.y, shift.z);
    let room = Room::with(&line, &[("scene_at_home.rad", scene.as_bytes())]);
    let eye = Vec3::new(0.3, -6.0, 1.0);
    let rays = (0..144).map(|i| Vec3::new((i % 12) as f64 / 3.0 - 1.8, 0.0, (i / 12) as f64 / 3.0 - 1.9) - eye);
    rays.map(|to| room.light(Ray::new(eye * scale + shift, to.normalize()), 1).y).collect()
}

pub fn fill(table: &mut Table) {
    for material in MATERIALS {
        let home = picture(material, 1.0, Vec3::ZERO);
        let sum: f64 = home.iter().sum();
        let mut same = |case: String, pixels: &[f64], allowed: f64| {
            let off: f64 = home.iter().zip(pixels).map(|(a, b)| (a - b).abs()).sum();
            table.near(format!("{material}, {case}"), sum, sum + off, allowed);
        };
        for scale in [1e-6, 1e-3, 1e3, 1e6] {
            same(format!("scaled by {scale:e}"), &picture(material, scale, Vec3::ZERO), 1e-6);
        }
        for shift in [Vec3::X, -Vec3::Y, Vec3::new(0.6, 0.0, 0.8)] {
            same(format!("moved by 1e5 along {shift}"), &picture(material, 1.0, shift * 1e5), 1e-6);
        }
        same("scaled by 1e-3, moved by 1e2".into(), &picture(material, 1e-3, Vec3::ONE * 1e2), 1e-6);
    }
    shapes(table);
}

fn shapes(table: &mut Table) {
    // A shape of albedo .5 in the furnace, seen from the right distance along +y.
    let mut seen = |shape: String, from: Vec3| {
        let room = Room::of(&format!("{FURNACE}void plastic m 0 0 5 .5 .5 .5 0 0\nm {shape}\n"));
        table.near(format!("albedo 1/2: {shape}"), 0.5, room.light(Ray::new(from, Vec3::Y), 4).y, 1e-9);
    };
    for r in [1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9] {
        let from = Vec3::new(0.1 * r, -3.0 * r, 0.2 * r);
        seen(format!("sphere s 0 0 4 0 0 0 {r:e}"), from);
        seen(format!("cylinder s 0 0 7 0 0 {:e} 0 0 {r:e} {r:e}", -r), from);
        seen(format!("cone s 0 0 8 0 0 {:e} 0 0 {r:e} {r:e} 0", -r), from);
        seen(format!("ring s 0 0 8 0 0 0 0 -1 0 0 {r:e}"), from);
        seen(format!("polygon s 0 0 9 {:e} 0 {:e} {r:e} 0 {:e} 0 0 {r:e}", -r, -r, -r), from);
    }
    // Out of proportion.
    seen("cylinder s 0 0 7 0 0 -1e6 0 0 1e6 1e-3".into(), Vec3::new(0.0005, -1.0, 7.0));
    seen("cylinder s 0 0 7 -1e6 0 0 1e6 0 0 1e-6".into(), Vec3::new(0.0, -1.0, 0.0));
    seen("ring s 0 0 8 0 0 0 0 -1 0 .999999999 1".into(), Vec3::new(0.9999999995, -1.0, 0.0));
    seen("cone s 0 0 8 0 0 -1 0 0 1 1 .9999".into(), Vec3::new(0.2, -3.0, 0.0));
    seen("polygon s 0 0 12 -1e-5 0 -1e5 1e-5 0 -1e5 1e-5 0 1e5 -1e-5 0 1e5".into(), Vec3::new(0.0, -1.0, 3.0));
    seen("sphere s 0 0 4 0 1e6 0 1e6".into(), Vec3::new(0.0, -1.0, 0.0));
    seen("sphere s 0 0 4 1e5 1e5 1e5 1e-3".into(), Vec3::new(1e5, 1e5 - 1.0, 1e5));
    // Grazing a ball: so near to its rim that the cosine is 1e-7.
    for cos in [1e-3, 1e-5, 1e-7] {
        seen("sphere s 0 0 4 0 0 0 1".into(), Vec3::new(f64::sqrt(1.0 - cos * cos), -3.0, 0.0));
    }
}
