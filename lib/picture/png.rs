//! Pictures to look at: radiance made fit for a screen, and PNG files.

use super::Picture;
use crate::color::{Rgb, bright, of_pixel};
use crate::error::{Error, Result};

/// The brightness that the average of a picture is given, of the screen's white (Reinhard et al. 2002, section 3: middle grey).
const KEY: f64 = 0.18;

/// The share of pixels that may be burnt out to white.
const BURNT: f64 = 0.002;

/// How radiance is shown on a screen: exposure, and the brightness that becomes white.
#[derive(Clone, Copy, Debug)]
pub struct Tone {
    /// Multiplies the radiance.
    exposure: f64,
    /// The exposed brightness shown as white, at least 1.
    white: f64,
}

impl Tone {
    /// The tone in which a picture (in radiance) looks natural, by the logarithmic average of its brightness (Reinhard et al.
    /// 2002, "Photographic Tone Reproduction for Digital Images", equation 1). Black pixels do not count.
    pub fn of(picture: &Picture) -> Self {
        let brightness = picture.pixels.iter().map(|&pixel| bright(of_pixel(pixel))).filter(|v| v.is_finite() && *v > 0.0);
        let mut brightness: Vec<_> = brightness.collect();
        if brightness.is_empty() {
            return Self { exposure: 1.0, white: 1.0 };
        }
        let average = (brightness.iter().map(|v| v.ln()).sum::<f64>() / brightness.len() as f64).exp();
        let last = brightness.len() - 1 - (brightness.len() as f64 * BURNT) as usize;
        let (_, &mut white, _) = brightness.select_nth_unstable_by(last, f64::total_cmp);
        let exposure = KEY / average;
        Self { exposure, white: (white * exposure).max(1.0) }
    }

    /// The sRGB colour of a radiance (Reinhard et al. 2002, equation 4, on brightness; IEC 61966-2-1). What is not a number is
    /// magenta, which nothing else is by chance in a photograph.
    pub fn map(&self, pixel: [f32; 3]) -> [u8; 3] {
        if pixel.iter().any(|v| v.is_nan()) {
            return [255, 0, 255];
        }
        let color = (of_pixel(pixel) * self.exposure).clamp(Rgb::ZERO, Rgb::splat(1e9));
        let brightness = bright(color);
        let factor = (1.0 + brightness / (self.white * self.white)) / (1.0 + brightness);
        (color * factor).to_array().map(srgb)
    }
}

/// The sRGB byte of a linear value, 0 to 1 (IEC 61966-2-1).
pub fn srgb(linear: f64) -> u8 {
    let v = linear.clamp(0.0, 1.0);
    let curve = if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (curve * 255.0 + 0.5) as u8
}

/// The bytes of a PNG file, row after row from the top.
pub fn write(width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<Vec<u8>> {
    let failed = |e: png::EncodingError| Error::new(format!("cannot write PNG: {e}"));
    let side = |n: usize| u32::try_from(n).map_err(|_| Error::new("too large for a PNG file"));
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, side(width)?, side(height)?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(pixels.as_flattened()).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::super::Header;
    use super::*;

    #[test]
    fn an_even_picture_is_middle_grey_at_any_exposure() {
        for level in [1e-6f32, 1.0, 1e6] {
            let picture = Picture { width: 2, height: 1, header: Header::default(), pixels: vec![[level; 3]; 2] };
            // Equation 4 with L = .18 and white = 1: .18 (1 + .18) / (1 + .18) = .18.
            assert_eq!(Tone::of(&picture).map([level; 3]), [srgb(0.18); 3]);
        }
    }

    #[test]
    fn srgb_follows_its_standard() {
        // sRGB bytes of linear 0, 0.5 and 1 are 0, 188 and 255 (IEC 61966-2-1).
        assert_eq!((srgb(0.0), srgb(0.5), srgb(1.0), srgb(7.0), srgb(f64::NAN)), (0, 188, 255, 255, 0));
    }

    #[test]
    fn a_png_file_holds_what_was_written() {
        let pixels = [[1, 2, 3], [4, 5, 6]];
        let bytes = write(1, 2, &pixels).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut read = [0; 6];
        reader.next_frame(&mut read).unwrap();
        assert_eq!(read, pixels.as_flattened());
        assert_eq!((reader.info().width, reader.info().height), (1, 2));
    }

    #[test]
    fn what_is_not_a_number_is_seen() {
        let tone = Tone::of(&Picture { width: 1, height: 1, header: Header::default(), pixels: vec![[f32::NAN; 3]] });
        assert_eq!(tone.map([f32::NAN, 0.0, 0.0]), [255, 0, 255]);
        assert_eq!(tone.map([f32::INFINITY, 0.0, 0.0])[0], 255);
    }
}
