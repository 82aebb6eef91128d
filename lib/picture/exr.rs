//! OpenEXR files: named planes of numbers over one grid of pixels, and the same header as a RADIANCE picture.
//!
//! The header stands in one text attribute, `radiance`, a line to a line. Planes named `R`, `G` and `B` are the picture; others are
//! named `what.R`, `what.G`… as OpenEXR's layers are.

use super::{FREE, Format, Header, Picture, pixel_count, reserve};
use crate::error::{Error, Result};
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Chromaticities, IntegerBounds, LineOrder, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{Compression, ReadChannels, ReadLayers, WritableImage};
use std::io::Cursor;

/// The first bytes of an OpenEXR file.
pub const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The attribute that holds the header.
const HEADER: &str = "radiance";

/// The most numbers that a byte of a file stands for beyond the first [`FREE`] ones: deflate, the densest of the compressions, makes at most
/// 1032 bytes of one, which are no more numbers than that.
const NUMBERS_PER_BYTE: usize = 1032;

/// The aspects of pixels that OpenEXR allows.
const ASPECTS: std::ops::RangeInclusive<f32> = 1e-6..=1e6;

/// The most numbers that are read, over all planes.
const MAX_SAMPLES: usize = 1 << 31;

/// Planes over one grid of pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Planes {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// How they were made.
    pub header: Header,
    /// The planes, by name in the order of the alphabet when read.
    pub planes: Vec<Plane>,
}

/// One number for each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// `R`, `variance.R`, `depth`…
    pub name: String,
    /// Row after row from the top, each from the left.
    pub samples: Samples,
}

/// The numbers of a plane.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Single precision; half precision is read as this.
    F32(Vec<f32>),
    /// Whole numbers.
    U32(Vec<u32>),
}

impl Plane {
    /// A plane of single precision.
    pub fn new(name: &str, values: Vec<f32>) -> Self {
        Self { name: name.into(), samples: Samples::F32(values) }
    }
}

impl Planes {
    /// The planes `R`, `G`, `B` of a picture: red, green and blue as stored, or as radiance if it is in XYZ.
    pub fn of(picture: &Picture) -> Self {
        let mut planes =
            Self { width: picture.width, height: picture.height, header: picture.header.clone(), planes: Vec::with_capacity(3) };
        match picture.header.format {
            Format::Rgb => planes.push_picture("", &picture.pixels),
            Format::Xyz => {
                let radiance = picture.radiance();
                planes.header = radiance.header;
                planes.push_picture("", &radiance.pixels);
            }
        }
        planes
    }

    /// Adds three planes `what.R`, `what.G`, `what.B`, or `R`, `G`, `B` if `what` is empty.
    pub fn push_picture(&mut self, what: &str, pixels: &[[f32; 3]]) {
        for (channel, letter) in ["R", "G", "B"].into_iter().enumerate() {
            self.planes.push(Plane::new(&named(what, letter), pixels.iter().map(|pixel| pixel[channel]).collect()));
        }
    }

    /// The plane of that name.
    pub fn plane(&self, name: &str) -> Option<&Plane> {
        self.planes.iter().find(|plane| plane.name == name)
    }

    /// The planes `what.R`, `what.G`, `what.B` as a picture. If `what` is empty: `R`, `G`, `B`; else `Y` three times; else those of
    /// the only layer that has red, green and blue. `name` is for messages.
    pub fn into_picture(self, what: &str, name: &str) -> Result<Picture> {
        let found = |what: &str| Some([self.single(&named(what, "R"))?, self.single(&named(what, "G"))?, self.single(&named(what, "B"))?]);
        let grey = || self.single(&named(what, "Y")).map(|y| [y; 3]);
        let only_layer = || {
            let mut layers = self.planes.iter().filter_map(|plane| plane.name.strip_suffix(".R").filter(|layer| found(layer).is_some()));
            layers.next().filter(|_| what.is_empty() && layers.next().is_none()).and_then(found)
        };
        let Some([r, g, b]) = found(what).or_else(grey).or_else(only_layer) else {
            let names: Vec<_> = self.planes.iter().take(20).map(|plane| plane.name.as_str()).collect();
            return Err(Error::new(format!("{name}: no channels {}; it has {}", named(what, "R, G and B"), names.join(", "))));
        };
        let mut pixels = Vec::new();
        reserve(&mut pixels, self.width * self.height)?;
        pixels.extend((0..self.width * self.height).map(|i| [r[i], g[i], b[i]]));
        Ok(Picture { width: self.width, height: self.height, header: self.header, pixels })
    }

    /// Reads an OpenEXR file: all parts, the first resolution of each, over the display window. `name` is for messages.
    pub fn read(bytes: &[u8], name: &str) -> Result<Self> {
        let failed = |e: exr::error::Error| Error::new(format!("{name}: not readable as OpenEXR: {e}"));

        // Check all sizes before memory is taken for any.
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(failed)?;
        let mut samples = 0usize;
        for part in &meta.headers {
            if part.deep {
                return Err(Error::new(format!("{name}: deep OpenEXR data are not read; flatten it first")));
            }
            let count =
                pixel_count(part.layer_size.width(), part.layer_size.height()).map_err(|e| Error::new(format!("{name}: {}", e.message)))?;
            samples = samples.saturating_add(count.saturating_mul(part.channels.list.len()));
        }
        let window = meta.headers.first().map(|part| part.shared_attributes.display_window);
        let window = window.ok_or_else(|| Error::new(format!("{name}: OpenEXR without a part")))?;
        let (width, height) = (window.size.width(), window.size.height());
        let count = pixel_count(width, height).map_err(|e| Error::new(format!("{name}: {}", e.message)))?;
        samples = samples.saturating_add(count.saturating_mul(meta.headers.iter().map(|part| part.channels.list.len()).sum()));
        if samples > 2 * MAX_SAMPLES {
            return Err(Error::new(format!("{name}: more than 2^31 numbers in all planes, the most that is read")));
        }
        if samples / 2 > FREE.saturating_add(bytes.len().saturating_mul(NUMBERS_PER_BYTE)) {
            return Err(Error::new(format!(
                "{name}: {} numbers do not fit into its {} bytes; the file is damaged",
                samples / 2,
                bytes.len()
            )));
        }
        reserve(&mut Vec::<f32>::new(), samples).map_err(|e| Error::new(format!("{name}: {}", e.message)))?;

        let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        let image = reader.from_buffered(Cursor::new(bytes)).map_err(failed)?;
        let several = image.layer_data.len() > 1;
        let header = header(&image.attributes, &image.layer_data[0].attributes, name)?;
        let mut planes = Vec::new();
        for layer in image.layer_data {
            let part = layer.attributes.layer_name.as_ref().map(text).filter(|_| several).unwrap_or_default();
            let corner = layer.attributes.layer_position - window.position;
            for channel in layer.channel_data.list {
                let own = text(&channel.name);
                let name = if own.starts_with(&format!("{part}.")) { own } else { named(&part, &own) };
                let samples = match channel.sample_data {
                    FlatSamples::U32(values) => Samples::U32(framed(values, layer.size, corner, (width, height))),
                    FlatSamples::F32(values) => Samples::F32(framed(values, layer.size, corner, (width, height))),
                    half => Samples::F32(framed(half.values_as_f32().collect(), layer.size, corner, (width, height))),
                };
                planes.push(Plane { name, samples });
            }
        }
        Ok(Self { width, height, header, planes })
    }

    /// The bytes of an OpenEXR file, losslessly compressed; the same whatever the number of threads.
    pub fn write(self) -> Result<Vec<u8>> {
        let failed = |e: exr::error::Error| Error::new(format!("cannot write OpenEXR: {e}"));
        let size = Vec2(self.width, self.height);
        let channel = |plane: Plane| {
            let samples = match plane.samples {
                Samples::F32(values) => FlatSamples::F32(values),
                Samples::U32(values) => FlatSamples::U32(values),
            };
            AnyChannel::new(Text::from_slice_unchecked(plane.name.as_bytes()), samples)
        };
        let channels = AnyChannels::sort(self.planes.into_iter().map(channel).collect());
        let encoding = Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let mut image = Image::from_layer(Layer::new(size, LayerAttributes::default(), encoding, channels));
        image.attributes.display_window = IntegerBounds::from_dimensions(size);
        // OpenEXR's aspect is width over height. The header holds it too, whatever it is.
        image.attributes.pixel_aspect = Some((1.0 / self.header.pixel_aspect()) as f32).filter(|a| ASPECTS.contains(a)).unwrap_or(1.0);
        image.attributes.chromaticities = self.header.primaries().map(|primaries| {
            let [red, green, blue, white] = primaries.map(|[x, y]| Vec2(x as f32, y as f32));
            Chromaticities { red, green, blue, white }
        });
        let lines = self.header.lines.join("\n");
        image
            .attributes
            .other
            .insert(Text::from_slice_unchecked(HEADER.as_bytes()), AttributeValue::Text(Text::from_slice_unchecked(lines.as_bytes())));
        let mut out = Cursor::new(Vec::new());
        image.write().to_buffered(&mut out).map_err(failed)?;
        Ok(out.into_inner())
    }

    fn single(&self, name: &str) -> Option<&Vec<f32>> {
        match &self.plane(name)?.samples {
            Samples::F32(values) => Some(values),
            Samples::U32(_) => None,
        }
    }
}

fn named(what: &str, channel: &str) -> String {
    if what.is_empty() { channel.to_string() } else { format!("{what}.{channel}") }
}

fn text(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

/// The trail: our own attribute, and what OpenEXR says in its own words where that says nothing.
fn header(attributes: &ImageAttributes, of_first: &LayerAttributes, name: &str) -> Result<Header> {
    let mut header = Header::default();
    if let Some(AttributeValue::Text(lines)) = of_first.other.get(&Text::from_slice_unchecked(HEADER.as_bytes())) {
        text(lines).lines().for_each(|line| header.push(line));
    }
    header.check(name)?;
    if header.values("PIXASPECT").next().is_none() && attributes.pixel_aspect != 1.0 && ASPECTS.contains(&attributes.pixel_aspect) {
        header.push(&format!("PIXASPECT={}", 1.0 / attributes.pixel_aspect));
    }
    if let Some(Chromaticities { red, green, blue, white }) = attributes.chromaticities.filter(|_| header.primaries().is_none()) {
        let list: Vec<_> = [red, green, blue, white].iter().map(|c| format!("{} {}", c.0, c.1)).collect();
        header.push(&format!("PRIMARIES= {}", list.join(" ")));
    }
    Ok(header)
}

/// The part of a plane inside a frame of `width` × `height` pixels, zero where there is none; `corner` is the plane's upper left
/// corner in the frame.
fn framed<T: Copy + Default>(values: Vec<T>, size: Vec2<usize>, corner: Vec2<i32>, (width, height): (usize, usize)) -> Vec<T> {
    if corner == Vec2(0, 0) && size == Vec2(width, height) {
        return values;
    }
    let mut frame = vec![T::default(); width * height];
    let (left, top) = (corner.0 as i64, corner.1 as i64);
    let columns = left.clamp(0, width as i64)..(left + size.0 as i64).clamp(0, width as i64);
    for y in top.clamp(0, height as i64)..(top + size.1 as i64).clamp(0, height as i64) {
        let from = (y - top) as usize * size.0;
        for x in columns.clone() {
            frame[y as usize * width + x as usize] = values[from + (x - left) as usize];
        }
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Picture {
        let mut header = Header::new("rtrace-rs -vf cam.vf scène.rad");
        header.push("EXPOSURE=2");
        header.push("PIXASPECT=.5");
        Picture { width: 3, height: 2, header, pixels: (0..6).map(|i| [i as f32 / 3.0, -1.0, f32::INFINITY]).collect() }
    }

    #[test]
    fn what_is_written_is_read_again_with_its_header() {
        let picture = picture();
        let bytes = picture.write_exr().unwrap();
        assert_eq!(Picture::read(&bytes, "a.exr").unwrap(), picture);
        assert_eq!(bytes, picture.write_exr().unwrap());
    }

    #[test]
    fn planes_keep_their_names_and_kinds() {
        let mut planes = Planes::of(&picture());
        planes.push_picture("variance", &[[0.25; 3]; 6]);
        planes.planes.push(Plane { name: "sums".into(), samples: Samples::U32(vec![u32::MAX; 6]) });
        let read = Planes::read(&planes.clone().write().unwrap(), "a.exr").unwrap();
        assert_eq!(read.plane("sums").unwrap().samples, Samples::U32(vec![u32::MAX; 6]));
        assert_eq!(read.clone().into_picture("variance", "a.exr").unwrap().pixels, [[0.25; 3]; 6]);
        assert_eq!(read.clone().into_picture("", "a.exr").unwrap(), picture());
        let error = read.into_picture("normal", "a.exr").unwrap_err().message;
        assert!(error.starts_with("a.exr: no channels normal.R, G and B; it has B, G, R, sums, variance.B"), "{error}");
    }

    #[test]
    fn a_layer_alone_or_grey_is_a_picture_too() {
        let planes = |list: &[&str]| Planes {
            width: 1,
            height: 1,
            header: Header::default(),
            planes: list.iter().map(|name| Plane::new(name, vec![7.0])).collect(),
        };
        let read = |list: &[&str]| Picture::read(&planes(list).write().unwrap(), "a.exr").map(|p| p.pixels);
        assert_eq!(read(&["Y"]).unwrap(), [[7.0; 3]]);
        assert_eq!(read(&["beauty.R", "beauty.G", "beauty.B", "depth"]).unwrap(), [[7.0; 3]]);
        assert!(read(&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"]).is_err());
    }

    #[test]
    fn xyz_is_written_as_radiance() {
        let mut picture = picture();
        picture.header.format = Format::Xyz;
        picture.pixels = vec![[358.0; 3]; 6];
        let read = Picture::read(&picture.write_exr().unwrap(), "a.exr").unwrap();
        assert!((read.pixels[0][1] - 1.0).abs() < 1e-6, "358 cd/m² at exposure 2 is 1 W/(sr·m²), not {:?}", read.pixels[0]);
    }

    #[test]
    fn a_crop_stands_at_its_place_in_the_frame() {
        assert_eq!(framed(vec![1, 2, 3, 4], Vec2(2, 2), Vec2(1, -1), (3, 2)), [0, 3, 4, 0, 0, 0]);
        assert_eq!(framed(vec![1], Vec2(1, 1), Vec2(i32::MAX, i32::MIN), (2, 1)), [0, 0]);
    }

    #[test]
    fn broken_files_are_errors() {
        let bytes = picture().write_exr().unwrap();
        for length in 0..bytes.len() {
            assert!(Picture::read(&bytes[..length], "a.exr").is_err(), "cut to {length}");
        }
        // Bytes set to 31 one after the other: sizes beyond all limits among them, and some just within.
        for at in 4..bytes.len() {
            let mut broken = bytes.clone();
            broken[at] = 31;
            let _ = Picture::read(&broken, "a.exr");
        }
    }
}
