//! Which function files ship with the project: our own text for RADIANCE's names.

/// The text of the function file of that name.
pub fn shipped(name: &str) -> Option<&'static str> {
    SHIPPED.iter().find(|(file, _)| *file == name).map(|(_, text)| *text)
}

macro_rules! files {
    ($($name:literal),* $(,)?) => { &[$(($name, include_str!($name))),*] };
}

pub(super) const SHIPPED: &[(&str, &str)] = files![
    "angular.cal",
    "curves.cal",
    "latlong.cal",
    "rayinit.cal",
    "skybright.cal",
    "perezlum.cal",
    "perezlum_c.cal",
    "illum.cal",
    "rev.cal",
    "surf.cal",
    "tmesh.cal",
    "source.cal",
    "tilt.cal",
    "glaze1.cal",
    "glaze2.cal",
    "window.cal",
];

#[cfg(test)]
mod tests {
    use crate::cal::{FileId, Library, Ray};
    use crate::error::Error;
    use crate::resolve::Files;
    use crate::vector::Vec3;
    use crate::view::View;
    use std::f64::consts::PI;

    /// Checks values in a file for a direction of travel, the point 1 2 3 and a normal against it.
    fn check(file: &str, arguments: &[f64], direction: [f64; 3], expected: &[(&str, f64)]) {
        let mut library = Library::new();
        let id = library.load(file, &Files::default()).unwrap();
        assert_ne!(id, FileId::GLOBAL);
        let direction = Vec3::from_array(direction);
        let ray = Ray::new(direction, -direction, Vec3::new(1.0, 2.0, 3.0));
        for (expression, expected) in expected {
            let program = library.compile(id, &[(expression, None)], arguments).unwrap();
            let found = program.eval(&ray.context()).unwrap();
            assert!((found - expected).abs() <= 2e-6 * expected.abs().max(1e-3), "{file} {expression}: {found}, not {expected}");
        }
    }

    // All numbers of RADIANCE's own files: a brightfunc of the expression with RADIANCE's own file and these arguments, on a glow source of 360°,
    // `echo 1 2 3 DIRECTION | rtrace -h -faa` (Radiance 6.0a).

    const UP: [f64; 3] = [0.6, 0.0, 0.8];
    const LEVEL: [f64; 3] = [-0.6, 0.8, 0.0];
    const DOWN: [f64; 3] = [0.36, 0.48, -0.8];
    const ASIDE: [f64; 3] = [0.48, -0.6, 0.64];

    #[test]
    fn skies_of_gensky() {
        let recorded = [[11.71874, 7.895984, 3.0], [8.666627, 3.183196, 3.0], [9.999950, 6.847117, 3.0], [14.71224, 5.244818, 3.0]];
        for (i, row) in recorded.iter().enumerate() {
            for (direction, value) in [UP, LEVEL, DOWN].into_iter().zip(row) {
                check("skybright.cal", &[i as f64 + 1.0, 10.0, 3.0, 0.9, 0.36, 0.48, 0.8], direction, &[("skybr", *value)]);
            }
        }
    }

    #[test]
    fn skies_of_gendaylit() {
        let perez = [10.0, 3.0, -1.0, -0.3, 2.0, -3.0, 0.4, 0.36, 0.48, 0.8];
        let colour = [3.0, -4.6070e9, 2.9678e6, 99.11, 0.244063, -2.0064e9, 1.9018e6, 247.48, 0.237040, -3.0, 2.87, -0.275];
        let all: Vec<f64> = perez.into_iter().chain(colour).collect();
        for (direction, luminance, [r, g, b]) in [
            (UP, 5.269084, [3.857538, 5.614303, 6.809350]),
            (LEVEL, 7.073007, [4.941898, 7.545028, 10.01533]),
            (DOWN, 3.0, [2.420479, 3.177508, 3.157732]),
        ] {
            check("perezlum.cal", &perez, direction, &[("skybright", luminance)]);
            check("perezlum_c.cal", &all, direction, &[("skybright_r", r), ("skybright_g", g), ("skybright_b", b)]);
        }
    }

    #[test]
    fn distributions_of_mkillum() {
        let axes = [1.0, 0.0, 0.0, 0.0, 0.6, 0.8, 0.0, -0.8, 0.6];
        check("illum.cal", &axes, ASIDE, &[("il_alt", 0.64), ("il_azi", 5.387130), ("il_alth", 0.7464960), ("il_azih", 3.448269)]);
    }

    #[test]
    fn luminaires_of_ies2rad() {
        let expected = [
            ("src_theta", 50.20818),
            ("src_phi", 128.6598),
            ("src_phi2", 128.6598),
            ("src_phi4", 51.34019),
            ("srcB_vert", -36.86990),
            ("srcB_horiz", -43.15239),
            ("srcB_vert2", 36.86990),
            ("srcB_horiz2", 43.15239),
            ("corr(7)", 14.0),
            ("flatcorr(7)", 14.0),
            ("boxcorr(7)", 53.27245),
            ("cylcorr(7)", 101.8597),
        ];
        check("source.cal", &[2.0, 0.3, 0.4, 0.5], ASIDE, &expected);
    }

    #[test]
    fn smooth_normals_of_the_generators() {
        check("rev.cal", &[2.0, 0.3, 0.4, 0.5], UP, &[("rev_dx", 0.6236068), ("rev_dy", 1.247214), ("rev_dz", 6.3)]);
        let matrix: Vec<f64> = (1..=12).map(|i| f64::from(i) / 10.0).collect();
        for (axis, [x, y, z]) in [(0.0, [4.5, 5.7, 6.9]), (1.0, [3.2, 4.0, 4.8]), (2.0, [3.0, 3.6, 4.2])] {
            let arguments: Vec<f64> = std::iter::once(axis).chain(matrix.iter().copied()).collect();
            check("surf.cal", &arguments, UP, &[("surf_dx", x), ("surf_dy", y), ("surf_dz", z)]);
        }
        let arguments: Vec<f64> = std::iter::once(1.0).chain(matrix.into_iter().take(9)).collect();
        let expected = [("dx", 0.7772533), ("dy", 0.5096034), ("dz", 1.641953), ("u", 0.8), ("v", 0.3)];
        check("tmesh.cal", &arguments, UP, &expected);
    }

    #[test]
    fn panes_of_glaze() {
        let mut arguments = vec![0.0; 9];
        arguments.extend([1.0, 0.3, 0.2, 0.1, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]);
        let bare = [("sr_frit_r", 0.076), ("st_frit_g", 0.6181), ("sr_clear_r", 0.3), ("sr_clear_b", 0.1), ("st_clear_g", 0.8)];
        check("glaze1.cal", &arguments, ASIDE, &bare);
        arguments[9] = -1.0;
        check("glaze1.cal", &arguments, ASIDE, &[("sr_frit_r", 0.0532), ("sr_clear_b", 0.6)]);
        let terms = [("fr(.3)", 0.3), ("ft(.3)", 0.3), ("rclr", 0.076), ("tclr", 0.883), ("cr(.1,.2,.3)", 0.112)];
        check("glaze2.cal", &[], ASIDE, &terms);
    }

    #[test]
    fn an_angular_map_is_what_the_angular_view_sees() {
        let mut view = View::default();
        let words = "-vta -vd 0 1 0 -vu 0 0 1 -vh 360 -vv 360".split(' ').map(String::from).collect::<Vec<_>>();
        view.apply(&words, &|name| Err(Error::new(name))).unwrap();
        let camera = view.ready().unwrap();
        let grid = (0..100).map(|i| [f64::from(i % 10) * 0.097 + 0.031, f64::from(i / 10) * 0.097 + 0.031]);
        let seen: Vec<_> = grid.filter_map(|[x, y]| Some((x, y, camera.ray(x, y)?.1))).collect();
        assert!(seen.len() > 70);
        for (x, y, direction) in seen {
            check("angular.cal", &[], direction.to_array(), &[("ang_u", x), ("ang_v", y)]);
        }
        check("angular.cal", &[], [0.0, 1.0, 0.0], &[("ang_u", 0.5), ("ang_v", 0.5)]);
        check("angular.cal", &[], [0.0, -1.0, 0.0], &[("ang_u", 1.0), ("ang_v", 0.5)]);
    }

    #[test]
    fn latitude_and_longitude() {
        // u = 1 + atan2(y, x)/π, v = 1 − acos(z)/π.
        let (u, v) = (1.0 + 0.48f64.atan2(0.36) / PI, 1.0 - (-0.8f64).acos() / PI);
        for (direction, u, v) in [([1.0, 0.0, 0.0], 1.0, 0.5), ([0.0, -1.0, 0.0], 0.5, 0.5), ([-1.0, 0.0, 0.0], 2.0, 0.5), (DOWN, u, v)] {
            check("latlong.cal", &[], direction, &[("ll_u", u), ("ll_v", v)]);
        }
        check("latlong.cal", &[], [0.0, 0.0, 1.0], &[("ll_v", 1.0)]);
    }
}
