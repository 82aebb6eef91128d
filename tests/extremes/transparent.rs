//! dielectric, interface and glass: at a point, exactly; as bodies in a white furnace, on the average.

use super::table::{ABOVE, FURNACE, Room, Table, flat};
use inverad::bsdf::{Bsdf, Point};
use inverad::color::Rgb;
use inverad::geometry::Ray;
use inverad::material::{Material, Medium};
use inverad::rules::Rules;
use inverad::vector::Vec3;

const INDICES: [f64; 9] = [0.2, 0.75, 1.0 - 1e-7, 1.0, 1.0 + 1e-7, 1.5, 4.0, 1e3, 1e-3];
const COSINES: [f64; 5] = [1.0, 0.5, 1e-2, 1e-5, 1e-7];

/// What a material reflects and lets through toward a viewer at the cosine `cos` on its front or back.
fn at(material: &Material, cos: f64, front: bool) -> [f64; 2] {
    let to_viewer = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let (geometric, shading) = (Vec3::Z, Vec3::Z);
    let (perturbation, orientation) = (Vec3::ZERO, Vec3::ZERO);
    let point = Point { to_viewer, geometric, shading, perturbation, front, flat: true, orientation, bends: false };
    Bsdf::new(material, &point, Rgb::ONE, &Rules::default()).deltas.map(|delta| delta.map_or(0.0, |d| d.coefficient.y))
}

fn medium(transmissivity: f64, index: f64) -> Medium {
    Medium { transmissivity: Rgb::splat(transmissivity), index }
}

/// cos² beyond a boundary with relative index `n`, without cancellation.
fn beyond(cos: f64, n: f64) -> f64 {
    ((n - 1.0) * (n + 1.0) + cos * cos) / (n * n)
}

/// Fresnel's reflectances across and along the plane of incidence, in forms that lose nothing where `n` is near 1. All is reflected
/// where RADIANCE says so: cos² < 1e-6 beyond.
fn fresnel(cos: f64, n: f64) -> [f64; 2] {
    let square = beyond(cos, n);
    if square < 1e-6 {
        return [1.0; 2];
    }
    let (other, sin2) = (square.sqrt(), 1.0 - cos * cos);
    let across = ((n - 1.0) * (n + 1.0) / (cos + n * other).powi(2)).powi(2);
    [across, across * ((cos * other - sin2 / n) / (cos * other + sin2 / n)).powi(2)]
}

/// What a pane reflects and lets through, bounce by bounce.
fn pane(cos: f64, n: f64, transmissivity: f64) -> [f64; 2] {
    let square = beyond(cos, n);
    if square <= 0.0 {
        return [1.0, 0.0];
    }
    let inside = square.sqrt();
    let through = transmissivity.max(1e-15).powf(1.0 / inside);
    let mut sum = [0.0; 2];
    let across = ((cos - n * inside) / (cos + n * inside)).powi(2);
    let along = ((inside - n * cos) / (inside + n * cos)).powi(2);
    for r in [across, along] {
        sum[0] += r / 2.0;
        let mut light = (1.0 - r) * through;
        if through == 1.0 {
            // The series in its limit: what enters goes one way or the other in the ratio of 1 to r.
            sum[0] += (1.0 - r) * r / (1.0 + r) / 2.0;
            sum[1] += 4.0 * cos * n * inside
                / (1.0 + r)
                / 2.0
                / if r == across { (cos + n * inside).powi(2) } else { (inside + n * cos).powi(2) };
            continue;
        }
        while light > 1e-18 {
            sum[1] += light * (1.0 - r) / 2.0;
            light *= r * through;
            sum[0] += light * (1.0 - r) / 2.0;
            light *= r * through;
        }
    }
    sum
}

pub fn fill(table: &mut Table) {
    boundaries(table);
    panes(table);
    bodies(table);
}

fn boundaries(table: &mut Table) {
    for n in INDICES {
        for cos in COSINES {
            let [across, along] = fresnel(cos, n);
            let reflected = f64::midpoint(across, along);
            let [mirrored, refracted] = at(&Material::Dielectric(medium(1.0, n)), cos, true);
            table.near(format!("dielectric {n} reflects at cos {cos:e}"), reflected, mirrored, 1e-8);
            // Radiance is concentrated by the square of the index: what comes from inside is what goes there.
            table.near(format!("dielectric {n} lets through at cos {cos:e}"), (1.0 - reflected) / (n * n), refracted, 1e-8);
            // But at the angle where RADIANCE says that all is reflected.
            if reflected < 1.0 && cos * cos > 1e-6 && n < 1e3 {
                let [back, _] = at(&Material::Dielectric(medium(1.0, n)), beyond(cos, n).sqrt(), false);
                table.near(format!("dielectric {n} reflects from inside what cos {cos:e} becomes"), reflected, back, 1e-8);
            }
        }
    }
    for (inside, outside) in [(1.5, 1.5), (1.5, 1.5 + 1e-7), (4.0, 0.2), (0.2, 4.0), (1.0, 1.33)] {
        for cos in [1.0, 0.5, 1e-2] {
            let [across, along] = fresnel(cos, inside / outside);
            let [mirrored, _] = at(&Material::Interface(medium(1.0, inside), medium(1.0, outside)), cos, true);
            table.near(format!("interface {inside} in {outside} reflects at cos {cos}"), f64::midpoint(across, along), mirrored, 1e-8);
        }
    }
    // Indices that are none reflect everything.
    for n in [0.0, -1.5, 1e-300] {
        let [mirrored, refracted] = at(&Material::Dielectric(medium(1.0, n)), 0.5, true);
        table.within(format!("dielectric {n}: reflected and let through"), 0.0, 1.0 + 1e-9, mirrored + refracted * n * n);
    }
}

fn panes(table: &mut Table) {
    for n in [0.2, 1.0 - 1e-7, 1.0, 1.0 + 1e-7, 1.52, 4.0] {
        for transmissivity in [0.0, 1e-15, 0.5, 1.0] {
            for cos in [1.0, 0.5, 1e-3, 1e-7] {
                let [reflected, through] = pane(cos, n, transmissivity);
                let [mirrored, straight] = at(&Material::Glass(medium(transmissivity, n)), cos, true);
                let through = if transmissivity <= 1e-15 { 0.0 } else { through };
                let case = format!("glass {transmissivity:e} {n} at cos {cos:e}");
                table.near(format!("{case} reflects"), reflected, mirrored, 1e-6);
                if n == 1.52 || transmissivity == 1.0 {
                    table.near(format!("{case} lets through"), through, straight, 1e-6);
                }
                if transmissivity == 1.0 {
                    table.near(format!("{case} keeps"), 1.0, mirrored + straight, 1e-12);
                }
            }
        }
    }
    // More than everything let through: the sum over bounces may have no limit; light stays light.
    for transmissivity in [1.0 + 1e-9, 1.5, 1e30] {
        for cos in COSINES {
            let [mirrored, straight] = at(&Material::Glass(medium(transmissivity, 1.52)), cos, true);
            table.within(format!("glass {transmissivity:e} 1.52 at cos {cos:e}"), 0.0, f64::MAX, mirrored + straight);
            table.within(format!("glass {transmissivity:e} 1.52 at cos {cos:e} reflects"), 0.0, f64::MAX, mirrored);
        }
    }
    for n in [0.0, 1e-300, 1e9, -1.52] {
        for cos in [1.0, 1e-7] {
            let [mirrored, straight] = at(&Material::Glass(medium(0.5, n)), cos, true);
            table.within(format!("glass .5 {n:e} at cos {cos:e}"), 0.0, 1.0 + 1e-12, mirrored + straight);
        }
    }
}

fn bodies(table: &mut Table) {
    // A clear body cannot be seen in a white furnace, wherever it is looked at.
    let aside = |x: f64| Ray::new(Vec3::new(x, -3.0, 0.0), Vec3::Y);
    for n in [0.2, 0.75, 1.0 - 1e-7, 1.0, 1.0 + 1e-7, 1.5, 4.0] {
        for material in [format!("dielectric m 0 0 5 1 1 1 {n} 0"), format!("interface m 0 0 8 1 1 1 {n} 1 1 1 1")] {
            let room = Room::of(&format!("{FURNACE}void {material}\nm sphere s 0 0 4 0 0 0 1\n"));
            for x in [0.0, 0.5, 0.99, 1.0 - 1e-9, 1.0 - 1e-15] {
                table.near(format!("{material}: ball seen {x:e} aside"), 1.0, room.light(aside(x), 4096).y, 0.02);
            }
        }
    }
    // A black one shows its first reflection only, one that would amplify is taken for clear.
    for x in [0.0, 0.5, 0.99] {
        let cos = f64::sqrt(1.0 - x * x);
        let [across, along] = fresnel(cos, 1.5);
        for (transmissivity, expected) in [(0.0, f64::midpoint(across, along)), (1e-40, f64::midpoint(across, along)), (1.5, 1.0)] {
            let text = format!("{FURNACE}void dielectric m 0 0 5 1 {transmissivity:e} 1 1.5 0\nm sphere s 0 0 4 0 0 0 1\n");
            table.near(
                format!("dielectric {transmissivity:e} 1.5: ball seen {x} aside"),
                expected,
                Room::of(&text).light(aside(x), 1024).y,
                0.01,
            );
        }
    }
    // Beer: a body of index 1 lets through t^length.
    for (transmissivity, radius) in [(0.5, 1e-6), (0.5, 1e-3), (0.5, 1.0), (0.5, 20.0), (1.0 - 1e-12, 1e6), (1e-30, 0.01)] {
        let text = format!("{FURNACE}void dielectric m 0 0 5 1 {transmissivity} 1 1 0\nm sphere s 0 0 4 0 0 0 {radius}\n");
        let found = Room::of(&text).light(Ray::new(Vec3::new(0.0, -3.0 * radius, 0.0), Vec3::Y), 1).y;
        let case = format!("dielectric {transmissivity:e} 1: ball of radius {radius:e}");
        table.near(case, f64::powf(transmissivity, 2.0 * radius), found, 2e-6);
    }
    // Light from above only: a boundary shows what it reflects.
    for n in [0.75, 1.5, 4.0] {
        for cos in [1.0, 0.5, 1e-2, 2e-6] {
            let [across, along] = fresnel(cos, n);
            let room = flat(ABOVE, &format!("dielectric m 0 0 5 1 1 1 {n} 0"));
            table.near(
                format!("dielectric {n} under light from above, cos {cos:e}"),
                f64::midpoint(across, along),
                room.seen(cos, 1),
                1e-8,
            );
        }
    }
}
