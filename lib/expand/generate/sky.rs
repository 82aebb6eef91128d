//! `gensky`: the CIE's standard skies, as the functions that `skybright.cal` describes.

use super::number;
use super::sun::{Moment, direction, hour};
use crate::error::{Error, Result};
use crate::expand::printf::e;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Luminous efficacy of daylight from the sky and from the sun, lm/W.
const SKY_EFFICACY: f64 = 203.0;
const SUN_EFFICACY: f64 = 208.0;
/// Solid angle of the sun, sr, where an irradiance is turned to a radiance; and where a radiance lights the ground.
const SUN_SOLID_ANGLE: f64 = 5.98e-5;
const SUN_ON_GROUND: f64 = 6e-5;

#[derive(Clone, Copy, PartialEq)]
enum Sky {
    Clear,
    Intermediate,
    Overcast,
    Uniform,
}

/// The scene text that `gensky` prints for these arguments.
pub fn gensky(arguments: &[String]) -> Result<String> {
    let (mut moment, options) = Moment::parse(arguments, hour)?;
    let (mut sky, mut sunny, mut reflectance, mut turbidity) = (Sky::Clear, true, 0.2, 2.45);
    let (mut zenith, mut irradiance, mut sun, mut sun_irradiance) = (None, None, None, None);
    let mut options = options.iter();
    while let Some(option) = options.next() {
        if moment.option(option, &mut options)? {
            continue;
        }
        match option.as_str() {
            "-s" | "+s" => (sky, sunny) = (Sky::Clear, option == "+s"),
            "-i" | "+i" => (sky, sunny) = (Sky::Intermediate, option == "+i"),
            "-c" | "+c" => sky = Sky::Overcast,
            "-u" | "+u" => sky = Sky::Uniform,
            "-g" => reflectance = number(option, options.next())?,
            "-t" => turbidity = number(option, options.next())?,
            "-b" => (zenith, irradiance) = (Some(number(option, options.next())?), None),
            "-B" => (zenith, irradiance) = (None, Some(number(option, options.next())?)),
            "-r" => (sun, sun_irradiance) = (Some(number(option, options.next())?), None),
            "-R" => (sun, sun_irradiance) = (None, Some(number(option, options.next())?)),
            _ => return Err(Error::new(format!("unknown option `{option}`"))),
        }
    }
    let (altitude, azimuth) = moment.angles();
    let directional = matches!(sky, Sky::Clear | Sky::Intermediate);
    let altitude = if directional { altitude.min(HIGHEST) } else { altitude };
    let toward = direction(altitude, azimuth);

    // Zenith luminance: Karayel et al. 1984 for clear skies, Krochmann and Seidl 1974 for overcast ones, their mean between.
    let clear = ((1.376 * turbidity - 1.81) * altitude.tan() + 0.38) * 1000.0 / SKY_EFFICACY;
    let overcast = (8.6 * toward.z + 0.123) * 1000.0 / SKY_EFFICACY;
    let model = match sky {
        Sky::Clear => clear,
        Sky::Intermediate => (clear + overcast) / 2.0,
        _ => overcast,
    };
    // Ground irradiance divided by π and by the zenith's radiance.
    let ground = match sky {
        Sky::Clear => clear_ground(altitude),
        Sky::Intermediate => intermediate_ground(altitude),
        Sky::Overcast => OVERCAST_GROUND,
        Sky::Uniform => 1.0,
    };
    let zenith = zenith.or(irradiance.map(|x: f64| x / PI / ground)).unwrap_or(model.max(0.0));
    let radiance = if !directional || toward.z <= 0.0 {
        0.0
    } else {
        let model = 1.5e9 / SUN_EFFICACY * (1.147 - 0.147 / toward.z.max(0.16)) * if sky == Sky::Clear { 1.0 } else { 0.15 };
        sun.or(sun_irradiance.map(|x: f64| x / toward.z / SUN_SOLID_ANGLE)).unwrap_or(model)
    };
    let ground = (zenith * ground + SUN_ON_GROUND / PI * radiance * toward.z.max(0.0)) * reflectance;

    let mut out = String::new();
    if sunny && radiance > 0.0 {
        let radiance = e(radiance, 3);
        out += &format!("\nvoid light solar\n0\n0\n3 {radiance} {radiance} {radiance}\n");
        out += &format!("\nsolar source sun\n0\n0\n4 {:.6} {:.6} {:.6} 0.5\n", toward.x, toward.y, toward.z);
    }
    let (zenith, ground) = (e(zenith, 3), e(ground, 3));
    let sun = format!("{:.6} {:.6} {:.6}", toward.x, toward.y, toward.z);
    out += "\nvoid brightfunc skyfunc\n2 skybr skybright.cal\n0\n";
    out += &match sky {
        Sky::Clear => format!("7 1 {zenith} {ground} {} {sun}\n", e(clear_relative(altitude), 3)),
        Sky::Intermediate => format!("7 4 {zenith} {ground} {} {sun}\n", e(intermediate_relative(altitude), 3)),
        Sky::Overcast => format!("3 2 {zenith} {ground}\n"),
        Sky::Uniform => format!("3 3 {zenith} {ground}\n"),
    };
    Ok(out)
}

/// The highest altitude of the sun at which the formulas for the zenith hold, radians.
pub const HIGHEST: f64 = 87.0 * PI / 180.0;

/// Ground irradiance divided by π and by the zenith's radiance, overcast sky (Moon and Spencer 1942).
pub const OVERCAST_GROUND: f64 = 7.0 / 9.0;

/// Ground irradiance divided by π and by the zenith's radiance, clear sky: an integral fitted by a polynomial.
pub fn clear_ground(altitude: f64) -> f64 {
    polynomial(altitude, [2.766521, 0.547665, -0.369832, 0.009237, 0.059229]) / clear_relative(altitude) / PI
}

/// The same for the intermediate sky.
pub fn intermediate_ground(altitude: f64) -> f64 {
    polynomial(altitude, [3.5556, -2.7152, -1.3081, 1.0660, 0.60227]) / intermediate_relative(altitude) / PI
}

/// Relative luminance of the zenith of the CIE's clear sky (CIE 22, 1973).
fn clear_relative(altitude: f64) -> f64 {
    0.274 * (0.91 + 10.0 * (-3.0 * (FRAC_PI_2 - altitude)).exp() + 0.45 * altitude.sin().powi(2))
}

/// Relative luminance of the zenith of the intermediate sky (Matsuura 1987).
fn intermediate_relative(altitude: f64) -> f64 {
    (2.739 + 0.9891 * (0.3119 + 2.6 * altitude).sin()) * (-(FRAC_PI_2 - altitude) * (0.4441 + 1.48 * altitude)).exp()
}

/// A polynomial in the altitude that runs from −1 at the horizon to 1 at the zenith.
fn polynomial(altitude: f64, coefficients: [f64; 5]) -> f64 {
    let x = (altitude - FRAC_PI_4) / FRAC_PI_4;
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}
