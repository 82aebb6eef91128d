//! Pictures as patterns: the value at a place (u, v), u to the right, v up, the shorter side from 0 to 1.

use super::table::cell;
use crate::error::{Error, Result};
use crate::picture::hdr::values;
use crate::picture::{Format, Picture, hdr};

/// A picture to be looked up. Its exposure is ignored, as RADIANCE ignores it.
#[derive(Debug)]
pub struct Raster {
    height: usize,
    /// Samples per unit of u and v.
    density: [f64; 2],
    /// Rows from the bottom; at least two rows and columns.
    samples: Samples,
    stride: usize,
}

/// Red, green and blue of pixels. The smaller, the more of them the processor has at hand.
#[derive(Debug)]
enum Samples {
    /// As a RADIANCE picture stores them, if that is what they are.
    Stored(Vec<hdr::Rgbe>),
    /// As they are, and nothing.
    Plain(Vec<[f32; 4]>),
}

impl Raster {
    /// The picture with that content.
    ///
    /// # Errors
    /// It is no picture, or its values are CIE XYZ.
    pub fn read(bytes: &[u8], name: &str) -> Result<Self> {
        Self::of(&Picture::read(bytes, name)?, name)
    }

    /// The picture; `name` is for messages.
    ///
    /// # Errors
    /// Its values are CIE XYZ.
    pub fn of(picture: &Picture, name: &str) -> Result<Self> {
        if picture.header.format == Format::Xyz {
            return Err(Error::new(format!("{name}: a pattern cannot use a picture in XYZ; convert it with `ra_xyze -r`")));
        }
        let (width, height) = (picture.width, picture.height);
        let (x, y, aspect) = (width as f64, height as f64, picture.header.pixel_aspect());
        // The greatest u and v: the outermost pixels lie at 0 and there.
        let range = if x <= y * aspect { [1.0, aspect * y / x] } else { [x / y / aspect, 1.0] };
        // Give a picture of a single row or column a second one, which the densities of 0 keep out.
        let (stride, rows) = (width.max(2), height.max(2));
        let pixels = || (0..rows * stride).map(|k| picture.at((k % stride).min(width - 1), height - 1 - (k / stride).min(height - 1)));
        let stored = |pixel: [f32; 3]| hdr::encode(pixel).filter(|stored| hdr::decode(*stored) == pixel);
        let samples = match pixels().map(stored).collect() {
            Some(samples) => Samples::Stored(samples),
            None => Samples::Plain(pixels().map(|[r, g, b]| [r, g, b, 0.0]).collect()),
        };
        Ok(Self { height, density: [(x - 1.0) / range[0], (y - 1.0) / range[1]], samples, stride })
    }

    /// Red, green and blue at a place: bilinear, and extrapolated beyond the picture as data files are.
    #[inline]
    pub fn value(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let (i, [left, right]) = cell(u * self.density[0], self.stride);
        let (j, [below, above]) = cell(v * self.density[1], self.height.max(2));
        let (low, high) = match &self.samples {
            Samples::Stored(samples) => self.around(samples, j * self.stride + i, values),
            Samples::Plain(samples) => self.around(samples, j * self.stride + i, |sample| sample.map(f64::from)),
        };
        let mix = |k: usize| below * (left * low[0][k] + right * low[1][k]) + above * (left * high[0][k] + right * high[1][k]);
        [mix(0), mix(1), mix(2)]
    }

    /// What a pixel, those to its right, above, and above to its right are.
    #[inline]
    fn around<T: Copy>(&self, samples: &[T], at: usize, value: impl Fn(T) -> [f64; 4]) -> ([[f64; 4]; 2], [[f64; 4]; 2]) {
        let (low, high) = (&samples[at..at + 2], &samples[at + self.stride..at + self.stride + 2]);
        ([value(low[0]), value(low[1])], [value(high[0]), value(high[1])])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Header;

    const P: [[f32; 3]; 6] = [[10., 20., 30.], [40., 50., 60.], [70., 80., 90.], [15., 25., 35.], [200., 100., 50.], [5., 6., 7.]];

    /// The mantissas with the exponent 129, each byte standing for the middle of its step.
    fn raster(width: usize, height: usize, pixels: &[[f32; 3]], lines: &[&str]) -> Raster {
        let header = Header { lines: lines.iter().map(|line| line.to_string()).collect(), ..Header::default() };
        let pixels = pixels.iter().map(|pixel| pixel.map(|m| (m + 0.5) / 128.0)).collect();
        Raster::of(&Picture { width, height, header, pixels }, "p.hdr").unwrap()
    }

    /// A colorpict `noop noop noop p.hdr . U V` on a glow that `rtrace -h -faa` sees (Radiance 6.0a).
    #[test]
    fn places_inside_and_outside_are_rtrace_s() {
        let wide = raster(3, 2, &P, &[]);
        let tall = raster(2, 3, &P, &[]);
        let stretched = raster(3, 2, &P, &["PIXASPECT=2.0", "EXPOSURE=3"]);
        let flipped = raster(3, 2, &[P[3], P[4], P[5], P[0], P[1], P[2]], &[]);
        let narrow = raster(1, 2, &[P[0], P[4]], &[]);
        #[rustfmt::skip]
        let recorded: [(&Raster, [f64; 2], [f64; 3]); 35] = [
            (&wide, [0.0, 0.0], [1.210938e-1, 1.992188e-1, 2.773438e-1]),
            (&wide, [0.2, 0.3], [3.979167e-1, 3.156250e-1, 3.062500e-1]),
            (&wide, [0.7, 1.3], [-5.000000e-2, 2.687500e-1, 4.781250e-1]),
            (&wide, [0.5, 1.9], [-5.234375e-1, 7.031250e-2, 4.296875e-1]),
            (&wide, [0.5, 2.3], [-1.842645e-1, 1.302083e-2, 1.313920e-1]),
            (&wide, [0.5, 3.5], [-1.351273e-1, 9.548611e-3, 9.635416e-2]),
            (&wide, [0.5, -0.9], [1.846354, 8.359375e-1, 3.203125e-1]),
            (&wide, [0.5, -2.4], [8.045790e-1, 3.597005e-1, 1.318359e-1]),
            (&wide, [1.4, 0.4], [3.554688e-1, 3.282813e-1, 3.323438e-1]),
            (&wide, [4.3, 0.4], [-1.001544e-1, -1.130996e-2, 3.665516e-2]),
            (&wide, [-3.2, -4.1], [-1.426883e-1, -3.997058e-2, 1.808725e-2]),
            (&tall, [0.0, 0.0], [1.566406, 7.851562e-1, 3.945312e-1]),
            (&tall, [0.2, 0.3], [9.429687e-1, 6.001562e-1, 4.448437e-1]),
            (&tall, [0.7, 1.3], [2.471354e-1, 3.252604e-1, 4.033854e-1]),
            (&tall, [0.5, 1.9], [1.263021e-1, 2.044271e-1, 2.825521e-1]),
            (&tall, [0.5, 2.3], [2.038044e-2, 4.585598e-2, 7.133152e-2]),
            (&tall, [0.5, 3.5], [1.339286e-2, 3.013393e-2, 4.687500e-2]),
            (&tall, [0.5, -2.4], [3.979492e-1, 1.318359e-1, -1.220703e-2]),
            (&tall, [1.4, 0.4], [-2.914062e-1, -9.880208e-2, 2.088542e-2]),
            (&tall, [-3.2, -4.1], [2.972114e-1, 1.132128e-1, 1.853385e-2]),
            (&stretched, [0.2, 0.3], [5.814453e-1, 3.931641e-1, 3.259766e-1]),
            (&stretched, [0.7, 1.3], [4.238282e-1, 4.883594e-1, 5.587500e-1]),
            (&stretched, [0.5, 1.9], [-2.148437e-1, 2.285156e-1, 5.058594e-1]),
            (&stretched, [0.5, 3.5], [-2.575431e-1, 1.077586e-3, 1.519397e-1]),
            (&stretched, [0.5, -2.4], [1.564670, 6.532118e-1, 1.757812e-1]),
            (&stretched, [1.4, 0.4], [-6.015625e-1, -1.307813e-1, 1.212500e-1]),
            (&flipped, [0.2, 0.3], [2.531250e-1, 2.625000e-1, 3.031250e-1]),
            (&flipped, [0.5, 1.9], [1.846354, 8.359375e-1, 3.203125e-1]),
            (&flipped, [4.3, 0.4], [-2.112100e-2, 4.265080e-2, 7.916970e-2]),
            (&narrow, [0.0, 0.0], [1.566406, 7.851562e-1, 3.945312e-1]),
            (&narrow, [0.2, 0.3], [1.343750, 6.914062e-1, 3.710938e-1]),
            (&narrow, [0.7, 1.3], [6.015625e-1, 3.789062e-1, 2.929688e-1]),
            (&narrow, [0.5, 3.5], [-1.031250, -3.085938e-1, 1.210938e-1]),
            (&narrow, [0.5, -2.4], [2.542318, 1.175130, 4.589844e-1]),
            (&narrow, [4.3, 0.4], [1.269531, 6.601562e-1, 3.632812e-1]),
        ];
        for (raster, place, expected) in recorded {
            let found = raster.value(place);
            for k in 0..3 {
                assert!((found[k] - expected[k]).abs() < 2e-6, "{place:?}: {found:?}, not {expected:?}");
            }
        }
    }
}
