//! A picture: pixels and their trail (the header). Bytes become pictures and pictures bytes in its formats, [`hdr`] and [`exr`].
//!
//! Rows stand top to bottom, pixels left to right, whatever the order in the file. Values are as stored: RADIANCE's pictures
//! say in their header by what the radiance was multiplied, and [`Picture::radiance`] undoes it.

use crate::color::{WHITE_EFFICACY, of_pixel, to_pixel};
use crate::error::{Error, Result};
use crate::vector::{Mat3, Vec3};

pub mod exr;
pub mod hdr;
pub mod png;

/// The most pixels of a picture, 2^28; checked before memory is taken.
pub const MAX_PIXELS: usize = 1 << 28;
/// So many pixels, or numbers, a file may promise whatever its length.
const FREE: usize = 1 << 22;

/// The name of this program in the headers of its pictures.
pub const SOFTWARE: &str = concat!("SOFTWARE= inverad ", env!("CARGO_PKG_VERSION"));

/// Red, green, blue and white of RADIANCE's colours, CIE (x, y).
pub const PRIMARIES: [[f64; 2]; 4] = [[0.64, 0.33], [0.29, 0.6], [0.15, 0.06], [1.0 / 3.0, 1.0 / 3.0]];

/// Pixels, and what is known of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// How the picture was made.
    pub header: Header,
    /// Three values a pixel, row after row from the top, each from the left; as stored, in the header's format.
    pub pixels: Vec<[f32; 3]>,
}

/// The trail of a picture: the lines of a RADIANCE header between its first and its `FORMAT`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Header {
    /// Command lines, `NAME=value` lines, and the indented lines of pictures that this one was made of.
    pub lines: Vec<String>,
    /// What the three values of a pixel are.
    pub format: Format,
}

/// What the three values of a pixel are, once exposure and colour correction are undone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Red, green and blue in W/(sr·m²).
    #[default]
    Rgb,
    /// CIE X, Y and Z, with Y in cd/m².
    Xyz,
}

/// The lines of a header without those of the second and further of the pictures that one was made of: each has its name, and what it says further in.
fn first_of_each<'a>(lines: &[&'a str]) -> Vec<&'a str> {
    let (mut told, mut rest, mut first) = (Vec::new(), lines, true);
    while let [line, after @ ..] = rest {
        let within = after.iter().take_while(|line| line.starts_with('\t')).count();
        let is_name = line.ends_with(':');
        if !is_name {
            told.push(*line);
        }
        if first || !is_name {
            let inner: Vec<&str> = after[..within].iter().map(|line| &line[1..]).collect();
            told.extend(first_of_each(&inner));
        }
        (rest, first) = (&after[within..], !is_name);
    }
    told
}

/// The words of a command line in a header, the program without its path.
pub fn command_words(line: &str) -> Vec<&str> {
    let mut words: Vec<&str> = line.split_whitespace().collect();
    if let Some(program) = words.first_mut() {
        *program = program.rsplit('/').next().unwrap_or(program);
    }
    words
}

/// How pictures begin that hold no radiance, or hardly ever.
const TONED: [(&[u8], &str); 7] = [
    (b"\x89PNG", "PNG"),
    (b"\xff\xd8\xff", "JPEG"),
    (b"P5\n", "PGM"),
    (b"P6\n", "PPM"),
    (b"GIF8", "GIF"),
    (b"II*\0", "TIFF"),
    (b"MM\0*", "TIFF"),
];

/// How those of bare floats begin, in colour and in grey.
const FLOATS: [&[u8]; 2] = [b"PF\n", b"Pf\n"];

impl Header {
    /// The header of a picture that `command` makes. The date is left out: the same command gives the same bytes.
    pub fn new(command: &str) -> Self {
        let mut header = Self::default();
        header.push(command);
        header.push(SOFTWARE);
        let primaries: Vec<_> = PRIMARIES.iter().flatten().map(|v| format!("{v:.4}")).collect();
        header.push(&format!("PRIMARIES= {}", primaries.join(" ")));
        header
    }

    /// Appends a line, but none that ends the header or says its format anew. What would end the line early becomes blanks.
    pub fn push(&mut self, line: &str) {
        if !line.is_empty() && !line.starts_with("FORMAT=") {
            self.lines.push(line.replace(['\n', '\r', '\0'], " "));
        }
    }

    /// What became of the picture, line by line: of several that were put together, as pcomb does, of the first.
    pub fn trail(&self) -> Vec<&str> {
        first_of_each(&self.lines.iter().map(String::as_str).collect::<Vec<_>>())
    }

    /// The values of all lines `NAME=value` that begin at the margin.
    pub fn values<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a str> {
        self.lines.iter().filter_map(move |line| line.strip_prefix(name)?.strip_prefix('=')).map(str::trim)
    }

    /// By how much the radiance was multiplied to give the stored values: the product of all `EXPOSURE` lines.
    pub fn exposure(&self) -> f64 {
        self.product::<1>("EXPOSURE")[0]
    }

    /// By how much each channel was multiplied beyond the exposure: the product of all `COLORCORR` lines.
    pub fn colorcorr(&self) -> [f64; 3] {
        self.product("COLORCORR")
    }

    /// Height over width of a pixel: the product of all `PIXASPECT` lines.
    pub fn pixel_aspect(&self) -> f64 {
        self.product::<1>("PIXASPECT")[0]
    }

    /// CIE (x, y) of red, green, blue and white, if a `PRIMARIES` line says; the last one counts.
    pub fn primaries(&self) -> Option<[[f64; 2]; 4]> {
        let [a, b, c, d, e, f, g, h] = numbers::<8>(self.values("PRIMARIES").last()?)?;
        Some([[a, b], [c, d], [e, f], [g, h]])
    }

    /// Whether every line that changes the meaning of the values can be understood.
    pub(crate) fn check(&self, name: &str) -> Result<()> {
        for (key, count) in [("EXPOSURE", 1), ("COLORCORR", 3), ("PIXASPECT", 1)] {
            for value in self.values(key) {
                let good = if count == 1 {
                    numbers::<1>(value).map(|n| n[0] > 0.0)
                } else {
                    numbers::<3>(value).map(|n| n.iter().all(|&v| v > 0.0))
                };
                if good != Some(true) {
                    return Err(Error::new(format!(
                        "{name}: {key}={value} in the header is not {count} positive number{}",
                        if count == 1 { "" } else { "s" }
                    )));
                }
            }
        }
        if ![self.exposure(), self.pixel_aspect()].iter().chain(&self.colorcorr()).all(|&v| v.is_finite() && v > 0.0) {
            return Err(Error::new(format!(
                "{name}: the exposures, colour corrections or aspects in the header multiply to no positive number"
            )));
        }
        Ok(())
    }

    fn product<const N: usize>(&self, key: &str) -> [f64; N] {
        self.values(key).filter_map(numbers::<N>).fold([1.0; N], |product, value| std::array::from_fn(|i| product[i] * value[i]))
    }
}

/// How messages tell where a pixel of a picture of this width lies.
pub fn place(number: usize, width: usize) -> String {
    format!("column {} and row {} (from the upper left, from 0)", number % width, number / width)
}

impl Picture {
    /// A black picture. Errors if it would have no pixel or more than [`MAX_PIXELS`].
    pub fn new(width: usize, height: usize, header: Header) -> Result<Self> {
        let count = pixel_count(width, height)?;
        let mut pixels = Vec::new();
        reserve(&mut pixels, count)?;
        pixels.resize(count, [0.0; 3]);
        Ok(Self { width, height, header, pixels })
    }

    /// What is wrong with some of its pixels, if one of them is not finite: the first of them, by its place, and how many more.
    pub fn infinite(&self, numbers: impl Iterator<Item = usize>) -> Option<String> {
        let mut bad = numbers.filter(|&n| self.pixels[n].iter().any(|v| !v.is_finite()));
        let first = bad.next()?;
        let others = match bad.count() {
            0 => "is".to_string(),
            more => format!("and {more} more are"),
        };
        Some(format!("pixel in {} {others} not finite", place(first, self.width)))
    }

    /// Reads a RADIANCE picture or an OpenEXR file, told apart by their content. `name` is for messages.
    pub fn read(bytes: &[u8], name: &str) -> Result<Self> {
        if bytes.starts_with(&exr::MAGIC) {
            return exr::Planes::read(bytes, name)?.into_picture("", name);
        }
        if let Some((_, kind)) = TONED.iter().find(|(begin, _)| bytes.starts_with(begin)) {
            let remedy = "give a RADIANCE picture or OpenEXR, as raw files and series of exposures make them";
            return Err(Error::new(format!("{name}: a {kind} file is made for the eye and holds no radiance; {remedy}")));
        }
        if FLOATS.iter().any(|begin| bytes.starts_with(begin)) {
            return Err(Error::new(format!("{name}: a PFM file is not read; make a RADIANCE picture or OpenEXR of it")));
        }
        hdr::read(bytes, name)
    }

    /// The pixel in column `x` from the left and row `y` from the top.
    pub fn at(&self, x: usize, y: usize) -> [f32; 3] {
        self.pixels[y * self.width + x]
    }

    /// The same picture in radiance: red, green and blue in W/(sr·m²) with RADIANCE's primaries, exposure and colour
    /// correction undone and no longer in the header. CIE XYZ is converted with RADIANCE's matrix and 179 lm/W.
    pub fn into_radiance(mut self) -> Self {
        let (exposure, correction) = (self.header.exposure(), self.header.colorcorr());
        let mut matrix = Mat3::from_diagonal(Vec3::from(correction.map(|c| 1.0 / (exposure * c))));
        if self.header.format == Format::Xyz {
            matrix = xyz_to_rgb() * matrix * (1.0 / WHITE_EFFICACY);
            self.header.lines.retain(|line| !line.starts_with("PRIMARIES="));
        }
        self.header.format = Format::Rgb;
        self.header.lines.retain(|line| !line.starts_with("EXPOSURE=") && !line.starts_with("COLORCORR="));
        if matrix != Mat3::IDENTITY {
            self.pixels.iter_mut().for_each(|pixel| *pixel = to_pixel(matrix * of_pixel(*pixel)));
        }
        self
    }

    /// In radiance, the distance between each value and the next that a RADIANCE picture could hold; 0 for those of pixels that are none of its,
    /// and of CIE XYZ.
    pub fn steps(&self) -> Vec<[f32; 3]> {
        let scale = self.header.colorcorr().map(|c| 1.0 / (self.header.exposure() * c));
        let step = |&pixel: &[f32; 3]| if self.header.format == Format::Rgb { hdr::step(pixel) } else { 0.0 };
        self.pixels.iter().map(|pixel| scale.map(|s| (f64::from(step(pixel)) * s) as f32)).collect()
    }

    /// [`Picture::into_radiance`] of a copy.
    pub fn radiance(&self) -> Self {
        self.clone().into_radiance()
    }

    /// The bytes of a RADIANCE picture. Errors if a value is not finite or too bright for the format.
    pub fn write_hdr(&self) -> Result<Vec<u8>> {
        hdr::write(self)
    }

    /// The bytes of an OpenEXR file with the channels R, G and B and the header.
    pub fn write_exr(&self) -> Result<Vec<u8>> {
        exr::Planes::of(self).write()
    }

    /// The bytes of a PNG file to look at, tone-mapped.
    pub fn write_png(&self) -> Result<Vec<u8>> {
        let shown = self.radiance();
        let tone = png::Tone::of(&shown);
        png::write(self.width, self.height, &shown.pixels.iter().map(|&pixel| tone.map(pixel)).collect::<Vec<_>>())
    }
}

/// From CIE XYZ to RADIANCE's red, green and blue, equal-energy white being (1, 1, 1) in both.
fn xyz_to_rgb() -> Mat3 {
    rgb_to_xyz().inverse()
}

/// From RADIANCE's red, green and blue to CIE XYZ, equal-energy white being (1, 1, 1) in both.
pub fn rgb_to_xyz() -> Mat3 {
    let xyz = |[x, y]: [f64; 2]| Vec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let [red, green, blue, white] = PRIMARIES.map(xyz);
    // Scale the primaries so that together they give white (SMPTE RP 177-1993, section 3).
    let primaries = Mat3::from_cols(red, green, blue);
    let scale = primaries.inverse() * white;
    primaries * Mat3::from_diagonal(scale)
}

/// The number of pixels, if there are some and not too many.
pub(crate) fn pixel_count(width: usize, height: usize) -> Result<usize> {
    match width.checked_mul(height) {
        Some(0) => Err(Error::new(format!("a picture of {width} × {height} pixels has none"))),
        Some(count) if count <= MAX_PIXELS => Ok(count),
        _ => Err(Error::new(format!("{width} × {height} pixels are more than 2^28, the most of a picture"))),
    }
}

/// Pixels row by row, `from` in a row, as `width` × `height` means of the finite ones that are in the same part of the whole.
pub fn shrunk<const N: usize>(pixels: &[[f32; N]], from: usize, width: usize, height: usize) -> Vec<[f32; N]> {
    let rows = pixels.len() / from;
    let mut sums = vec![([0.0; N], 0.0); width * height];
    for (n, pixel) in pixels.iter().enumerate().filter(|(_, pixel)| pixel.iter().all(|v| v.is_finite())) {
        let (sum, count) = &mut sums[n / from * height / rows * width + n % from * width / from];
        (0..N).for_each(|c| sum[c] += pixel[c]);
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| sum.map(|v| v / f32::max(count, 1.0))).collect()
}

/// Takes memory for `count` elements, or says that there is not enough.
pub(crate) fn reserve<T>(list: &mut Vec<T>, count: usize) -> Result<()> {
    list.try_reserve_exact(count).map_err(|_| Error::new(format!("not enough memory for {count} pixels")))
}

/// The first `N` numbers of a text, if they are finite numbers.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let mut words = text.split_whitespace();
    let mut found = [0.0; N];
    for number in &mut found {
        *number = words.next()?.parse().ok().filter(|v: &f64| v.is_finite())?;
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_pictures_that_were_put_together_the_first_is_told() {
        let told = |text: &str| {
            let header = Header { lines: text.lines().map(String::from).collect(), ..Header::default() };
            header.trail().join("|")
        };
        let inner = "a.hdr:\n\tb.hdr:\n\t\trpict -ab 1\n\tc.hdr:\n\t\trpict -ab 2\n\tpcomb b.hdr c.hdr\n";
        let combined = format!("{inner}mask.hdr:\n\trpict\npcomb a.hdr mask.hdr\nVIEW= -vtv");
        assert_eq!(told(&combined), "rpict -ab 1|pcomb b.hdr c.hdr|pcomb a.hdr mask.hdr|VIEW= -vtv");
        // A photograph says nothing, whatever it was put together with.
        assert_eq!(told("a.hdr:\nmask.hdr:\n\trpict\npcomb a.hdr mask.hdr"), "pcomb a.hdr mask.hdr");
        assert_eq!(told("rpict -ab 2\n\tpfilt -x /2\npfilt -r .6"), "rpict -ab 2|pfilt -x /2|pfilt -r .6");
    }

    #[test]
    fn exposures_multiply_and_indented_lines_do_not_count() {
        let mut header = Header::default();
        for line in ["EXPOSURE=2", "EXPOSURE= 4", "\tEXPOSURE=100", " EXPOSURE=100", "COLORCORR=1 2 4", "COLORCORR= 1 2 4 ", "PIXASPECT=2"]
        {
            header.push(line);
        }
        assert_eq!((header.exposure(), header.colorcorr(), header.pixel_aspect()), (8.0, [1.0, 4.0, 16.0], 2.0));
        let picture = Picture { width: 1, height: 1, header, pixels: vec![[8.0, 32.0, 128.0]] };
        let radiance = picture.radiance();
        assert_eq!(radiance.pixels, [[1.0; 3]]);
        assert_eq!((radiance.header.exposure(), radiance.header.lines.len()), (1.0, 3));
    }

    #[test]
    fn xyz_becomes_rgb_as_in_radiance() {
        // Recorded: the five pixels below in an XYZE picture, through `rcomb -h -ff -c RGB`, RADIANCE 6.0a.
        let stored = [[255, 0, 0, 129], [0, 255, 0, 129], [0, 0, 255, 129], [200, 100, 50, 130], [100, 200, 50, 137]];
        let recorded: [[f64; 3]; 5] = [
            [0.028572572, -0.01135377, 0.00085347047],
            [-0.012964676, 0.02203924, -0.0027821485],
            [-0.0044128895, 0.00050953636, 0.0131236855],
            [0.032904543, -0.00034059875, 0.004286983],
            [0.041767627, 3.3087997, 0.1837462],
        ];
        let header = Header { format: Format::Xyz, ..Header::default() };
        let picture = Picture { width: 5, height: 1, header, pixels: stored.map(hdr::decode).to_vec() };
        for (pixel, expected) in picture.radiance().pixels.iter().zip(recorded) {
            let largest = expected.iter().fold(0f64, |m, v| m.max(v.abs()));
            for (value, expected) in pixel.iter().zip(expected) {
                assert!((f64::from(*value) - expected).abs() < 3e-7 * largest, "{value} {expected}");
            }
        }
        // `bright` is the middle row of the matrix to XYZ, for white at .3333 instead of 1/3.
        let to_xyz = xyz_to_rgb().inverse();
        for (channel, axis) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
            assert!((to_xyz.col(channel).y - crate::color::bright(axis)).abs() < 4e-5);
        }
    }

    #[test]
    fn a_header_line_cannot_break_out() {
        let mut header = Header::new("rtrace-rs a.rad\nEXPOSURE=2");
        let lines = header.lines.len();
        for line in ["", "FORMAT=32-bit_rle_xyze"] {
            header.push(line);
        }
        assert_eq!((header.exposure(), header.lines.len()), (1.0, lines));
        // What rpict writes, with the digits it writes.
        assert!(header.lines.contains(&"PRIMARIES= 0.6400 0.3300 0.2900 0.6000 0.1500 0.0600 0.3333 0.3333".to_string()));
        assert_eq!(header.primaries().map(|p| p[2]), Some([0.15, 0.06]));
    }

    #[test]
    fn sizes_are_checked_before_memory_is_taken() {
        assert!(pixel_count(1 << 14, 1 << 14).is_ok() && pixel_count(1 << 14, (1 << 14) + 1).is_err());
        assert!(pixel_count(usize::MAX, 2).is_err() && pixel_count(0, 5).is_err());
    }

    #[test]
    fn a_shrunk_picture_holds_the_means_of_what_is_finite() {
        let pixels: Vec<[f32; 1]> = (0..15).map(|n| [if n == 6 { f32::NAN } else { n as f32 }]).collect();
        // Five in a row: three of the first three and two of the last two go together, and two rows of three.
        assert_eq!(shrunk(&pixels, 5, 2, 2), [[(0.0 + 1.0 + 2.0 + 5.0 + 7.0) / 5.0], [(3.0 + 4.0 + 8.0 + 9.0) / 4.0], [11.0], [13.5]]);
        assert_eq!(shrunk(&pixels[..5], 5, 5, 1), pixels[..5]);
    }
}
