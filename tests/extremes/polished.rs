//! plastic, metal and trans without roughness, and mirror: what they scatter in a white furnace is a sum of coefficients.

use super::table::{FURNACE, Table, above, below, flat};

/// RADIANCE's K since June 2026.
const K: f64 = 0.00287989916;

/// Cosines of the view, from the normal to the last that meets a flat surface.
const COSINES: [f64; 4] = [1.0, 0.5, 1e-3, 2e-6];

/// The albedo of plastic, metal or trans of one grey: rs, its Fresnel term, and the diffuse and straight parts.
fn albedo(kind: &str, [color, specularity, transmission]: [f64; 3], cos: f64) -> f64 {
    let fresnel = if specularity >= 0.017999 { (-5.85 * cos.max(0.001)).exp() - K } else { 0.0 };
    let reflected = specularity + fresnel * (1.0 - specularity);
    let specular = match kind {
        "metal" if fresnel > 1e-6 => fresnel + color * specularity * (1.0 - fresnel),
        "metal" => color * reflected,
        _ => reflected,
    };
    let transmitted = transmission * (1.0 - reflected);
    specular + color * transmitted + color * (1.0 - reflected - transmitted)
}

pub fn fill(table: &mut Table) {
    // Colours at and above their ends, specularity on both sides of where Fresnel begins, roughness that is none.
    let looks = [[0.0, 0.0], [1.0, 0.0], [0.5, below(0.017999)], [0.5, 0.017999], [1.0, 1.0], [0.0, 1.0], [1.5, 0.5], [0.7, 1.0 - 1e-9]];
    let (mut cosines, roughnesses) = (COSINES.into_iter().cycle(), [0.0, 1e-8, below(1e-3), 1e-3]);
    for kind in ["plastic", "metal"] {
        for [color, specularity] in looks {
            for roughness in roughnesses {
                let cos = cosines.next().unwrap();
                let room = flat(FURNACE, &format!("{kind} m 0 0 5 {color} {color} {color} {specularity} {roughness:e}"));
                let case = format!("{kind} {color} spec {specularity} rough {roughness:.16e} cos {cos:e}");
                table.near(case, albedo(kind, [color, specularity, 0.0], cos), room.seen(cos, 1), 3e-6);
            }
            cosines.next();
        }
    }
    for (transmission, straight) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (1e-9, 1.0), (1.0 - 1e-9, 0.5)] {
        for [color, specularity] in [[1.0, 0.0], [0.5, 0.018], [1.0, 1.0], [1.5, 0.1]] {
            let cos = cosines.next().unwrap();
            let room = flat(FURNACE, &format!("trans m 0 0 7 {color} {color} {color} {specularity} 0 {transmission} {straight}"));
            let case = format!("trans {color} spec {specularity} trans {transmission} tspec {straight} cos {cos:e}");
            table.near(case, albedo("trans", [color, specularity, transmission], cos), room.seen(cos, 1), 3e-6);
        }
        cosines.next();
    }
    // Beyond the ends: what is left for the other parts is nothing, and never less.
    for (material, bound) in [
        ("plastic m 0 0 5 .5 .5 .5 1.5 0", 1.6),
        ("plastic m 0 0 5 .5 .5 .5 -.5 0", 0.75),
        ("metal m 0 0 5 1 1 1 2 .2", 2.0),
        ("plastic m 0 0 5 .5 .5 .5 .1 -.2", 1.0),
        ("trans m 0 0 7 .5 .5 .5 .1 0 1.5 .5", 1.0),
        ("trans m 0 0 7 .5 .5 .5 .1 .1 .5 1.5", 1.0),
        ("trans m 0 0 7 .5 .5 .5 .1 .1 -.5 -.5", 1.5),
    ] {
        for cos in [1.0, 1e-3] {
            table.within(format!("{material} cos {cos:e}"), 0.0, bound, flat(FURNACE, material).seen(cos, 64));
        }
    }
    for color in [0.0, 1e-30, 1.0, above(1.0), 1.5, 1e30] {
        for cos in COSINES {
            let room = flat(FURNACE, &format!("mirror m 0 0 3 {color:e} {color:e} {color:e}"));
            table.near(format!("mirror {color:e} cos {cos:e}"), color, room.seen(cos, 1), 1e-12);
        }
    }
    // Nearer to the plane than 1e-6 a ray runs along it.
    for cos in [1e-6, 1e-7, 0.0] {
        table.near(format!("a ring, missed at cos {cos:e}"), 1.0, flat(FURNACE, "plastic m 0 0 5 0 0 0 0 0").seen(cos, 1), 0.0);
    }
}
