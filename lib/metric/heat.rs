//! Where two pictures differ, to look at.

use super::Comparison;
use crate::color::{bright, of_pixel};
use crate::picture::png::{Tone, srgb};

/// The colour of pixels that do not count, and of the gap between pictures.
const ASIDE: [u8; 3] = [64, 64, 64];

/// Pixels between pictures that stand side by side.
const GAP: usize = 4;

impl Comparison<'_> {
    /// A colour for each pixel: the darker the smaller the difference, warm where the second picture is brighter, cold where the
    /// reference is. The brightest colours stand for the difference that one pixel in a hundred exceeds.
    pub fn heatmap(&self) -> Vec<[u8; 3]> {
        let range = self.heat_range();
        self.differences().map(|difference| difference.map_or(ASIDE, |d| heat(d / range))).collect()
    }

    /// The difference in radiance that the brightest colours of [`Comparison::heatmap`] stand for.
    pub fn heat_range(&self) -> f64 {
        let mut sizes: Vec<f64> = self.differences().flatten().map(|d| d.abs()).filter(|&d| d > 0.0).collect();
        let top = sizes.len() - sizes.len().min(1 + sizes.len() / 100);
        if sizes.is_empty() { 1.0 } else { *sizes.select_nth_unstable_by(top, f64::total_cmp).1 }
    }

    /// The size of each pixel's difference, negative where the reference is brighter; `None` for what does not count.
    fn differences(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        (0..self.reference.pixels.len()).map(move |i| {
            let difference = of_pixel(self.image.pixels[i]) * self.scale - of_pixel(self.reference.pixels[i]);
            let counts = self.weights.is_none_or(|weights| weights[i] > 0.0);
            counts.then(|| difference.length().copysign(bright(difference)))
        })
    }

    /// Reference, second picture and heat map beside each other, in the tone of the reference: width, height and pixels.
    pub fn side_by_side(&self) -> (usize, usize, Vec<[u8; 3]>) {
        let (width, height) = (self.reference.width, self.reference.height);
        let tone = Tone::of(self.reference);
        let heat = self.heatmap();
        let mut out = Vec::with_capacity((3 * width + 2 * GAP) * height);
        for y in 0..height {
            let row = y * width..(y + 1) * width;
            out.extend(self.reference.pixels[row.clone()].iter().map(|&pixel| tone.map(pixel)));
            out.extend([ASIDE; GAP]);
            out.extend(self.image.pixels[row.clone()].iter().map(|pixel| tone.map(pixel.map(|v| (f64::from(v) * self.scale) as f32))));
            out.extend([ASIDE; GAP]);
            out.extend(&heat[row]);
        }
        (3 * width + 2 * GAP, height, out)
    }
}

/// The colour of a difference: black at 0, through red and orange to light yellow at 1, through blue and cyan to light blue at −1.
pub fn heat(difference: f64) -> [u8; 3] {
    let size = difference.abs().min(1.0);
    let [bright, middle, dim] = [size, size.powi(2), size.powi(4)].map(srgb);
    if difference > 0.0 { [bright, middle, dim] } else { [dim, middle, bright] }
}

#[cfg(test)]
mod tests {
    use super::super::{Comparison, Named};
    use super::*;
    use crate::picture::{Header, Picture};

    #[test]
    fn heat_tells_which_picture_is_brighter() {
        let picture = |pixels: &[[f32; 3]]| Picture { width: 4, height: 1, header: Header::default(), pixels: pixels.to_vec() };
        let (a, b) = (picture(&[[1.0; 3]; 4]), picture(&[[1.0; 3], [3.0; 3], [0.0; 3], [9.0; 3]]));
        let named = |picture| Named { name: "", picture };
        let comparison = Comparison::new(named(&a), named(&b), None, Some(&[1.0, 1.0, 1.0, 0.0])).unwrap();
        let heat = comparison.heatmap();
        assert_eq!((heat[0], heat[1], heat[3]), ([0; 3], [255; 3], ASIDE));
        assert!(heat[2][2] > heat[2][0], "the reference is brighter: blue");
        let (width, height, pixels) = comparison.side_by_side();
        assert_eq!((width, height, pixels.len()), (20, 1, 20));
    }
}
