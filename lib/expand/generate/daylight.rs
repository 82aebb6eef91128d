//! `gendaylit`: the all-weather sky of Perez et al., as the function that `perezlum.cal` describes.

use super::number;
use super::sky::{HIGHEST, OVERCAST_GROUND, clear_ground, intermediate_ground};
use super::sun::{Moment, direction, plain_hour};
use crate::color::WHITE_EFFICACY;
use crate::error::{Error, Result};
use crate::expand::printf::e;
use crate::vector::Vec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Extraterrestrial irradiance, W/m², and illuminance, lux.
const SOLAR_CONSTANT: f64 = 1367.0;
const SOLAR_CONSTANT_LUX: f64 = 127500.0;
/// Half the angle that the sun takes, degrees.
const SUN_HALF_ANGLE: f64 = 0.2665;
/// Precipitable water in the atmosphere, cm.
const WATER: f64 = 2.0;
/// Where the sun lights the ground: its solid angle, sr, as `gensky` once had it.
const SUN_ON_GROUND: f64 = 6.8e-5;
/// From this clearness on the ground is lit as under the CIE's clear sky, at the lowest as under its overcast one, else as under an intermediate one.
const CLEAR: f64 = 6.0;

/// Lower ends of the eight bins of sky clearness (Perez et al. 1990, table 1), and the end of the last.
const CLEARNESS: [f64; 9] = [1.0, 1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2, 12.01];

/// Perez et al. 1993, "All-weather model for sky luminance distribution", table 1: for each bin the coefficients of a, b, c, d, e.
const COEFFICIENTS: [[[f32; 4]; 5]; 8] = [
    [
        [1.3525, -0.2576, -0.2690, -1.4366],
        [-0.7670, 0.0007, 1.2734, -0.1233],
        [2.8000, 0.6004, 1.2375, 1.0000],
        [1.8734, 0.6297, 0.9738, 0.2809],
        [0.0356, -0.1246, -0.5718, 0.9938],
    ],
    [
        [-1.2219, -0.7730, 1.4148, 1.1016],
        [-0.2054, 0.0367, -3.9128, 0.9156],
        [6.9750, 0.1774, 6.4477, -0.1239],
        [-1.5798, -0.5081, -1.7812, 0.1080],
        [0.2624, 0.0672, -0.2190, -0.4285],
    ],
    [
        [-1.1000, -0.2515, 0.8952, 0.0156],
        [0.2782, -0.1812, -4.5000, 1.1766],
        [24.7219, -13.0812, -37.7000, 34.8438],
        [-5.0000, 1.5218, 3.9229, -2.6204],
        [-0.0156, 0.1597, 0.4199, -0.5562],
    ],
    [
        [-0.5484, -0.6654, -0.2672, 0.7117],
        [0.7234, -0.6219, -5.6812, 2.6297],
        [33.3389, -18.3000, -62.2500, 52.0781],
        [-3.5000, 0.0016, 1.1477, 0.1062],
        [0.4659, -0.3296, -0.0876, -0.0329],
    ],
    [
        [-0.6000, -0.3566, -2.5000, 2.3250],
        [0.2937, 0.0496, -5.6812, 1.8415],
        [21.0000, -4.7656, -21.5906, 7.2492],
        [-3.5000, -0.1554, 1.4062, 0.3988],
        [0.0032, 0.0766, -0.0656, -0.1294],
    ],
    [
        [-1.0156, -0.3670, 1.0078, 1.4051],
        [0.2875, -0.5328, -3.8500, 3.3750],
        [14.0000, -0.9999, -7.1406, 7.5469],
        [-3.4000, -0.1078, -1.0750, 1.5702],
        [-0.0672, 0.4016, 0.3017, -0.4844],
    ],
    [
        [-1.0000, 0.0211, 0.5025, -0.5119],
        [-0.3000, 0.1922, 0.7023, -1.6317],
        [19.0000, -5.0000, 1.2438, -1.9094],
        [-4.0000, 0.0250, 0.3844, 0.2656],
        [1.0468, -0.3788, -2.4517, 1.4656],
    ],
    [
        [-1.0500, 0.0289, 0.4260, 0.3590],
        [-0.3250, 0.1156, 0.7781, 0.0025],
        [31.0625, -14.5000, -46.1148, 55.3750],
        [-7.2312, 0.4050, 13.3500, 0.6234],
        [1.5000, -0.6426, 1.8564, 0.5636],
    ],
];

/// Luminous efficacy of the sky's light (Perez et al. 1990, "Modeling daylight availability", table 4).
const SKY_EFFICACY: [[f64; 4]; 8] = [
    [97.24, -0.46, 12.00, -8.91],
    [107.22, 1.15, 0.59, -3.95],
    [104.97, 2.96, -5.53, -8.77],
    [102.39, 5.59, -13.95, -13.90],
    [100.71, 5.94, -22.75, -23.74],
    [106.42, 3.83, -36.15, -28.83],
    [141.88, 1.90, -53.24, -14.03],
    [152.23, 0.35, -45.27, -7.98],
];

/// Luminous efficacy of the sun's light (the same, table 4).
const SUN_EFFICACY: [[f64; 4]; 8] = [
    [57.20, -4.55, -2.98, 117.12],
    [98.99, -3.46, -1.21, 12.38],
    [109.83, -4.90, -1.71, -8.81],
    [110.34, -5.84, -1.99, -4.56],
    [106.36, -3.97, -1.75, -6.16],
    [107.19, -1.25, -1.51, -26.73],
    [105.75, 0.77, -1.26, -34.44],
    [101.18, 1.58, -1.10, -8.29],
];

/// What is known of the sky.
#[derive(Clone, Copy)]
enum Known {
    /// Clearness and brightness.
    Perez(f64, f64),
    /// Irradiance from the sun, normal to it, and from the sky on the ground.
    Normal(f64, f64),
    /// Irradiance from the sun and from the sky on the ground.
    Horizontal(f64, f64),
    /// Irradiance from both on the ground.
    Global(f64),
}

/// The scene text that `gendaylit` prints for these arguments.
pub fn gendaylit(arguments: &[String]) -> Result<String> {
    let (mut moment, options) = Moment::parse(arguments, plain_hour)?;
    let (mut known, mut unit, mut reflectance, mut sunny) = (Known::Perez(1.0, 0.01), 0, 0.2, true);
    let mut options = options.iter();
    while let Some(option) = options.next() {
        if moment.option(option, &mut options)? {
            continue;
        }
        let mut value = || number(option, options.next());
        match option.as_str() {
            "-P" => known = Known::Perez(value()?, value()?),
            "-W" => known = Known::Normal(value()?.max(0.0), value()?.max(0.0)),
            "-G" => known = Known::Horizontal(value()?.max(0.0), value()?.max(0.0)),
            "-E" => known = Known::Global(value()?.max(0.0)),
            "-O" => unit = value()? as i32,
            "-g" => reflectance = value()?,
            "-t" => _ = value()?,
            "-s" => sunny = false,
            "+s" => sunny = true,
            "-w" => {}
            _ => return Err(Error::new(format!("unknown option `{option}`"))),
        }
    }
    if !(0..=2).contains(&unit) {
        return Err(Error::new("`-O` is 0 (visible W/m²/sr), 1 (solar W/m²/sr) or 2 (cd/m²)"));
    }
    let (altitude, azimuth) = moment.angles();
    let altitude = altitude.min(HIGHEST);
    let toward = direction(altitude, azimuth);
    let sky = (!moment.is_night()).then(|| Sky::new(known, altitude, toward.z, moment.day())).flatten();

    let mut out = String::new();
    let header = "\nvoid brightfunc skyfunc\n2 skybright perezlum.cal\n0\n";
    let sun = format!("{:.6} {:.6} {:.6}", toward.x, toward.y, toward.z);
    // Where the model does not hold the original prints a black sky.
    let Some(sky) = sky else { return Ok(format!("{header}10 0.00 0.00  0.000 0.000 0.000 0.000 0.000  {sun}\n")) };
    let (sky_efficacy, sun_efficacy) = match unit {
        0 => (sky.sky_efficacy() / WHITE_EFFICACY, sky.sun_efficacy() / WHITE_EFFICACY),
        1 => (1.0, 1.0),
        _ => (sky.sky_efficacy(), sky.sun_efficacy()),
    };
    let factor = sky.diffuse * sky_efficacy / sky.integral();
    let radiance = sky.direct * sun_efficacy / (2.0 * PI * (1.0 - SUN_HALF_ANGLE.to_radians().cos()));
    let lit = match sky.clearness {
        _ if sky.clearness >= CLEAR => clear_ground(altitude),
        _ if sky.clearness > CLEARNESS[0] => intermediate_ground(altitude),
        _ => OVERCAST_GROUND,
    };
    let direct = if sunny { SUN_ON_GROUND / PI * radiance * toward.z } else { 0.0 };
    let ground = (factor * sky.relative(0.0, sky.zenith_angle) * lit + direct) * reflectance;
    if sunny {
        let radiance = if sky.diffuse > 0.0 && sky.direct <= 0.0 { "0.0".into() } else { e(radiance, 3) };
        out += &format!("\nvoid light solar\n0\n0\n3 {radiance} {radiance} {radiance}\n");
        out += &format!("\nsolar source sun\n0\n0\n4 {sun} {:.6}\n", 2.0 * SUN_HALF_ANGLE);
    }
    let shape = sky.shape.map(|x| format!("{x:.6}")).join(" ");
    Ok(format!("{out}{header}10 {} {} {shape} {sun}\n", e(factor, 3), e(ground, 3)))
}

/// A state of the sky.
struct Sky {
    /// Angle between sun and zenith, radians; at most a right one.
    zenith_angle: f64,
    clearness: f64,
    brightness: f64,
    /// Index of the clearness among the bins.
    bin: usize,
    /// Irradiance from the sun, normal to it, and from the sky on the ground, W/m².
    direct: f64,
    diffuse: f64,
    /// The five parameters of the luminance distribution.
    shape: [f64; 5],
}

impl Sky {
    /// The sky of what is known, with the sun at this altitude (and its sine) on this day of the year; `None` when the
    /// model does not hold for it.
    fn new(known: Known, altitude: f64, height: f64, day: usize) -> Option<Self> {
        let z = (FRAC_PI_2 - altitude).min(FRAC_PI_2);
        let extraterrestrial = SOLAR_CONSTANT * eccentricity(day);
        // Kasten 1966, "A new table and approximation formula for the relative optical air mass".
        let air_mass = 1.0 / (z.cos() + 0.15 * (93.885 - z.to_degrees()).powf(-1.253));
        // Perez et al. 1990, equations 1 and 2.
        let k = 1.041 * z.powi(3);
        let ([direct, diffuse], told) = match known {
            Known::Perez(clearness, brightness) => {
                let diffuse = brightness * extraterrestrial / air_mass;
                ([diffuse * ((1.0 + k) * clearness - k - 1.0), diffuse], Some((clearness, brightness)))
            }
            Known::Normal(direct, diffuse) => ([direct, diffuse], None),
            // From below the horizon nothing falls on the ground.
            Known::Horizontal(..) | Known::Global(_) if height < 0.0 => ([0.0, 0.0], Some((f64::INFINITY, 0.0))),
            Known::Horizontal(direct, diffuse) => ([direct / height, diffuse], None),
            Known::Global(global) => {
                // Erbs et al. 1982, "Estimation of the diffuse radiation fraction", equation 1; no more than reaches the atmosphere.
                let most = extraterrestrial * height;
                let global = if global > most { 0.999 * most } else { global };
                let kt = global / most;
                let fraction = match kt {
                    _ if kt <= 0.22 => 1.0 - 0.09 * kt,
                    _ if kt <= 0.80 => 0.9511 - 0.1604 * kt + 4.388 * kt.powi(2) - 16.638 * kt.powi(3) + 12.336 * kt.powi(4),
                    _ => 0.165,
                };
                ([global * (1.0 - fraction) / height, global * fraction], None)
            }
        };
        if !direct.is_finite() || direct > SOLAR_CONSTANT || direct <= 0.0 && diffuse <= 0.0 && told.is_none() {
            return None;
        }
        let (clearness, brightness) = told.unwrap_or_else(|| {
            let clearness = if diffuse > 0.0 { ((diffuse + direct) / diffuse + k) / (1.0 + k) } else { f64::INFINITY };
            (clearness, diffuse * air_mass / extraterrestrial)
        });
        let (clearness, brightness) = (clearness.clamp(1.0, CLEARNESS[8] - 0.001), brightness.clamp(0.01, 0.6));
        let bin = CLEARNESS.partition_point(|&low| low <= clearness).clamp(1, 8) - 1;
        let shape = shape(bin, z, clearness, brightness);
        let sky = Self { zenith_angle: z, clearness, brightness, bin, direct: direct.max(0.0), diffuse, shape };
        // Toward the horizon the luminance must stay finite.
        (shape[1] <= 0.0 && sky.direct * sky.sun_efficacy() <= SOLAR_CONSTANT_LUX).then_some(sky)
    }

    /// Perez et al. 1990, equation 7.
    fn sky_efficacy(&self) -> f64 {
        let [a, b, c, d] = SKY_EFFICACY[self.bin];
        a + b * WATER + c * self.zenith_angle.cos() + d * self.brightness.ln()
    }

    /// Perez et al. 1990, equation 8.
    fn sun_efficacy(&self) -> f64 {
        let [a, b, c, d] = SUN_EFFICACY[self.bin];
        (a + b * WATER + c * (5.73 * self.zenith_angle - 5.0).exp() + d * self.brightness).max(0.0)
    }

    /// The relative luminance of a direction, by its angles to the zenith and to the sun (Perez et al. 1993, equation 1).
    fn relative(&self, zenith: f64, sun: f64) -> f64 {
        let [a, b, c, d, e] = self.shape;
        (1.0 + a * (b / zenith.cos()).exp()) * (1.0 + c * (d * sun).exp() + e * sun.cos().powi(2))
    }

    /// The horizontal illuminance of the relative luminance: a sum over Tregenza's 145 directions (Tregenza 1987).
    fn integral(&self) -> f64 {
        const ROWS: [(f64, usize); 8] = [(84.0, 30), (72.0, 30), (60.0, 24), (48.0, 24), (36.0, 18), (24.0, 12), (12.0, 6), (0.0, 1)];
        let sun = Vec3::new(self.zenith_angle.sin(), 0.0, self.zenith_angle.cos());
        let mut sum = 0.0;
        for (zenith, count) in ROWS {
            let (sin, cos) = zenith.to_radians().sin_cos();
            for i in 0..count {
                let azimuth = 2.0 * PI * i as f64 / count as f64;
                let to_sun = sun.dot(Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)).clamp(-1.0, 1.0).acos();
                sum += self.relative(zenith.to_radians(), to_sun) * cos;
            }
        }
        sum * 2.0 * PI / 145.0
    }
}

/// The five parameters of the luminance distribution (Perez et al. 1993, equations 6 to 8).
fn shape(bin: usize, z: f64, clearness: f64, brightness: f64) -> [f64; 5] {
    // RADIANCE keeps the thinner skies out of where the model has none.
    let brightness = if clearness > 1.065 && clearness < 2.8 { brightness.max(0.2) } else { brightness };
    let table = COEFFICIENTS[bin].map(|row| row.map(f64::from));
    let mut shape = table.map(|[p, q, r, s]| p + q * z + brightness * (r + s * z));
    if bin == 0 {
        let [p, q, r, s] = table[2];
        shape[2] = (brightness * (p + q * z)).powf(r).exp() - s;
        let [p, q, r, s] = table[3];
        shape[3] = -(brightness * (p + q * z)).exp() + r + brightness * s;
    }
    shape
}

/// The square of the sun's mean distance over its distance on a day of the year (Spencer 1971).
fn eccentricity(day: usize) -> f64 {
    let angle = 2.0 * PI * (day as f64 - 1.0) / 365.0;
    1.00011 + 0.034221 * angle.cos() + 0.00128 * angle.sin() + 0.000719 * (2.0 * angle).cos() + 0.000077 * (2.0 * angle).sin()
}
