//! What RADIANCE's programs take for an option of light that is not given.

/// The option, and what it is in rtrace, which traces each of its pixels, and in rpict (`rtrace -defaults` and `rpict -defaults`, RADIANCE 6.0a).
const DEFAULTS: [(&str, [f64; 2]); 12] = [
    ("-aa", [0.1, 0.2]),
    ("-ab", [0.0, 0.0]),
    ("-as", [512.0, 128.0]),
    ("-dj", [0.0, 0.0]),
    ("-dr", [2.0, 1.0]),
    ("-ds", [0.2, 0.25]),
    ("-dt", [0.03, 0.05]),
    ("-lr", [-10.0, 7.0]),
    ("-lw", [1e-4, 1e-4]),
    ("-ps", [1.0, 4.0]),
    ("-ss", [1.0, 1.0]),
    ("-st", [0.15, 0.15]),
];

/// What an option is in rtrace and in rpict where it is not given.
///
/// # Panics
/// Of an option that has none here.
pub fn radiances(option: &str) -> [f64; 2] {
    DEFAULTS.iter().find(|(name, _)| *name == option).expect("an option with a default of RADIANCE's").1
}

/// The part of a pixel's width that rpict samples, where no `-pj` says another.
pub const PIXEL_JITTER: f64 = 0.67;

/// The width and the height of a picture in pixels, at the most.
pub const SIZE: usize = 512;
