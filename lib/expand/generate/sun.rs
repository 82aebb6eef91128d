//! Where the sun stands, for `gensky` and `gendaylit`: from date, hour and place, or from two angles.

use super::number;
use crate::error::{Error, Result};
use crate::rad::real;
use crate::vector::Vec3;
use std::f64::consts::PI;

/// Time zones that `gensky` knows, and their standard meridians in degrees west.
const ZONES: [(&str, f64); 27] = [
    ("YST", 135.0),
    ("YDT", 120.0),
    ("PST", 120.0),
    ("PDT", 105.0),
    ("MST", 105.0),
    ("MDT", 90.0),
    ("CST", 90.0),
    ("CDT", 75.0),
    ("EST", 75.0),
    ("EDT", 60.0),
    ("AST", 60.0),
    ("ADT", 45.0),
    ("NST", 52.5),
    ("NDT", 37.5),
    ("GMT", 0.0),
    ("BST", -15.0),
    ("CET", -15.0),
    ("CEST", -30.0),
    ("EET", -30.0),
    ("EEST", -45.0),
    ("GST", -60.0),
    ("GDT", -75.0),
    ("IST", -82.5),
    ("IDT", -97.5),
    ("JST", -135.0),
    ("NZST", -180.0),
    ("NZDT", -195.0),
];

/// How the sun's place is told.
pub enum Moment {
    /// Altitude and azimuth (from south, positive westward), radians.
    Angles(f64, f64),
    /// A date and an hour at a place.
    Date(Date),
}

/// A date and an hour at a place.
pub struct Date {
    month: usize,
    day: usize,
    /// Local standard time, or solar time.
    hour: f64,
    solar: bool,
    /// Standard meridian of a time zone that the hour names, radians west.
    zone: Option<f64>,
    year: Option<i32>,
    latitude: f64,
    longitude: f64,
    meridian: f64,
}

impl Moment {
    /// Takes the place of the sun from the head of the arguments, where `hour` reads that; the options are left.
    pub fn parse(arguments: &[String], hour: fn(&str) -> Result<Hour>) -> Result<(Self, &[String])> {
        if arguments.first().is_some_and(|a| a == "-ang") {
            let angle = |i: usize| number("-ang", arguments.get(i)).map(f64::to_radians);
            return Ok((Self::Angles(angle(1)?, angle(2)?), &arguments[3..]));
        }
        let [month, day, time, options @ ..] = arguments else {
            return Err(Error::new("needs month, day and hour, or -ang and two angles"));
        };
        let whole = |word: &str, what: &str, limit: usize| {
            let number = real(word).map(|x| x as usize).filter(|n| (1..=limit).contains(n));
            number.ok_or_else(|| Error::new(format!("`{word}` is not a {what}, 1 to {limit}")))
        };
        let (month, day) = (whole(month, "month", 12)?, whole(day, "day", 31)?);
        let (hour, solar, zone) = hour(time)?;
        let zone = zone.map(f64::to_radians);
        // RADIANCE's default place is in California.
        let (latitude, longitude, meridian) = (0.66, 2.13, 120f64.to_radians());
        Ok((Self::Date(Date { month, day, hour, solar, zone, year: None, latitude, longitude, meridian }), options))
    }

    /// Takes an option of the place or the year, if `option` is one.
    pub fn option<'a>(&mut self, option: &str, values: &mut impl Iterator<Item = &'a String>) -> Result<bool> {
        let place = match (self, option) {
            (Self::Date(d), "-a") => &mut d.latitude,
            (Self::Date(d), "-o") => &mut d.longitude,
            (Self::Date(d), "-m") => &mut d.meridian,
            (Self::Date(d), "-y") => {
                d.year = Some(number(option, values.next())? as i32);
                return Ok(true);
            }
            (Self::Angles(..), "-a" | "-o" | "-m" | "-y") => {
                values.next();
                return Ok(true);
            }
            _ => return Ok(false),
        };
        *place = number(option, values.next())?.to_radians();
        Ok(true)
    }

    /// Altitude and azimuth, radians.
    pub fn angles(&self) -> (f64, f64) {
        match self {
            Self::Angles(altitude, azimuth) => (*altitude, *azimuth),
            Self::Date(date) => date.angles(),
        }
    }

    /// Whether a date's hour is before sunrise or after sunset; never where the sun does not rise or set.
    pub fn is_night(&self) -> bool {
        let Self::Date(date) = self else { return false };
        let half_day = (-date.latitude.tan() * date.declination().tan()).acos() * 12.0 / PI;
        (date.simple_time() - 12.0).abs() > half_day
    }

    /// The day's number in the year, from 1; 0 when no day is told.
    pub fn day(&self) -> usize {
        match self {
            Self::Angles(..) => 0,
            Self::Date(date) => date.number(false),
        }
    }
}

/// The unit vector toward the sun: y is north, x east.
pub fn direction(altitude: f64, azimuth: f64) -> Vec3 {
    Vec3::new(-azimuth.sin() * altitude.cos(), -azimuth.cos() * altitude.cos(), altitude.sin())
}

impl Date {
    /// Solar altitude and azimuth (IES Lighting Handbook 1981, Reference Volume, equations 7-3 and 7-4).
    fn angles(&self) -> (f64, f64) {
        let (declination, time) = match self.year {
            Some(year) => self.almanac(year),
            None => (self.declination(), self.simple_time()),
        };
        let time = if self.solar { self.hour } else { time } * PI / 12.0;
        let ((sin_l, cos_l), (sin_d, cos_d)) = (self.latitude.sin_cos(), declination.sin_cos());
        let altitude = (sin_l * sin_d - cos_l * cos_d * time.cos()).clamp(-1.0, 1.0).asin();
        (altitude, -(cos_d * time.sin()).atan2(-cos_l * sin_d - sin_l * cos_d * time.cos()))
    }

    fn number(&self, leap: bool) -> usize {
        const BEFORE: [usize; 12] = [0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334];
        BEFORE[self.month - 1] + self.day + usize::from(leap && self.month > 2)
    }

    fn meridian(&self) -> f64 {
        self.zone.unwrap_or(self.meridian)
    }

    /// Cooper 1969, "The absorption of radiation in solar stills".
    fn declination(&self) -> f64 {
        0.4093 * (2.0 * PI / 365.0 * (self.number(false) as f64 - 81.0)).sin()
    }

    /// Solar time in hours, with the equation of time of the IES Lighting Handbook 1981, equation 7-1.
    fn simple_time(&self) -> f64 {
        if self.solar {
            return self.hour;
        }
        let day = self.number(false) as f64;
        let equation = 0.170 * (4.0 * PI / 373.0 * (day - 80.0)).sin() - 0.129 * (2.0 * PI / 355.0 * (day - 8.0)).sin();
        self.hour + equation + 12.0 * (self.meridian() - self.longitude) / PI
    }

    /// Declination and solar time by the Astronomical Almanac's approximation (Michalsky 1988, Solar Energy 40 (3), appendix).
    fn almanac(&self, year: i32) -> (f64, f64) {
        let universal = self.hour + self.meridian().to_degrees() / 15.0;
        let years = i64::from(year) - 1949;
        let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
        let date = 32916.5 + (years * 365 + years / 4) as f64 + self.number(leap) as f64 + universal / 24.0;
        let n = date - 51545.0;
        let longitude = 280.460 + 0.9856474 * n;
        let anomaly = (357.528 + 0.9856003 * n).to_radians();
        let ecliptic = (longitude + 1.915 * anomaly.sin() + 0.020 * (2.0 * anomaly).sin()).to_radians();
        let obliquity = (23.439 - 0.0000004 * n).to_radians();
        let ascension = (obliquity.cos() * ecliptic.sin()).atan2(ecliptic.cos());
        let declination = (obliquity.sin() * ecliptic.sin()).asin();
        let sidereal = 6.697375 + 0.0657098242 * n + universal - self.longitude.to_degrees() / 15.0;
        (declination, sidereal - ascension.to_degrees() / 15.0 + 12.0)
    }
}

/// Hours, whether they are solar time, and the standard meridian of their time zone, if they name one, in degrees west.
pub type Hour = (f64, bool, Option<f64>);

/// An hour as `gensky` reads it: `14.5`, `14:30`, `+12` (solar time), `9:30PDT`.
pub fn hour(word: &str) -> Result<Hour> {
    let bad = || Error::new(format!("`{word}` is not an hour; write 14.5, 14:30, 14:30EST or +12 for solar time"));
    let end = word.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(word.len());
    let (digits, zone) = word.split_at(end);
    let (hours, minutes) = digits.split_once(':').unwrap_or((digits, "0"));
    let hour = real(hours).ok_or_else(bad)? + real(minutes).ok_or_else(bad)? / 60.0;
    if zone.is_empty() {
        return Ok((hour, digits.starts_with('+'), None));
    }
    let known = ZONES.iter().find(|(name, _)| name.eq_ignore_ascii_case(zone));
    let names: Vec<&str> = ZONES.iter().map(|(name, _)| *name).collect();
    let meridian = known.ok_or_else(|| Error::new(format!("unknown time zone `{zone}`; known are {}", names.join(" "))))?.1;
    Ok((hour, false, Some(meridian)))
}

/// An hour as `gendaylit` reads it: a number, and nothing of what follows it: `9:30PDT` is 9.
pub fn plain_hour(word: &str) -> Result<Hour> {
    let end = word.find(|c: char| c == ':' || c.is_ascii_alphabetic()).unwrap_or(word.len());
    hour(&word[..end]).map_err(|_| Error::new(format!("`{word}` is not an hour; write 14.5, or +12 for solar time")))
}
