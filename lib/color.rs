//! What a radiance is: red, green and blue in W/(sr·m²), with RADIANCE's primaries.

/// Red, green and blue: a radiance in W/(sr·m²), or a dimensionless coefficient of one.
pub type Rgb = crate::vector::Vec3;

/// The achromatic brightness RADIANCE gives a colour: the Y of its default primaries, for an equal-energy white of 1.
pub fn bright(c: Rgb) -> f64 {
    0.265074126 * c.x + 0.670114631 * c.y + 0.064811243 * c.z
}

/// A colour as a pixel of a picture.
pub fn to_pixel(c: Rgb) -> [f32; 3] {
    c.to_array().map(|v| v as f32)
}

/// The colour of a pixel.
pub fn of_pixel(pixel: [f32; 3]) -> Rgb {
    Rgb::from(pixel.map(f64::from))
}

/// Luminous efficacy of RADIANCE's white, lm/W: cd/m² = 179 × [`bright`].
pub const WHITE_EFFICACY: f64 = 179.0;
