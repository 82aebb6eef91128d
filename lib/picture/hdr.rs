//! RADIANCE pictures, byte for byte: header, resolution line, and pixels of three mantissas and one common exponent.
//!
//! Ward 1991, "Real Pixels" (Graphics Gems II). RADIANCE cuts off when it encodes and adds half a step when it decodes; so
//! does this. Any of the eight orientations, any of the three encodings of a line, and any width are read.

use super::{FREE, Format, Header, Picture, pixel_count, reserve};
use crate::error::{Error, Result};

/// The longest header that is read, in bytes.
const MAX_HEADER: usize = 1 << 16;

/// The most pixels that a byte of a file stands for beyond the first [`FREE`] ones: runs of runs could stand for any number, but nobody
/// writes them, and the present encoding reaches 16.
const PIXELS_PER_BYTE: usize = 64;

/// Widths whose lines are run-length encoded when written.
const RUN_LENGTH_WIDTHS: std::ops::RangeInclusive<usize> = 17..=32767;

/// The shortest run that is worth its two bytes, the longest run, the longest stretch of single bytes.
const MIN_RUN: usize = 4;
const MAX_RUN: usize = 127;
const MAX_SINGLE: usize = 128;

/// A pixel as stored: mantissas of red, green and blue (or X, Y and Z), and the exponent + 128.
pub type Rgbe = [u8; 4];

/// The values of a stored pixel: (mantissa + ½) · 2^(exponent − 136), exactly; 0 if the exponent is 0.
pub fn decode(stored: Rgbe) -> [f32; 3] {
    let [r, g, b, _] = values(stored);
    [r, g, b].map(|v| v as f32)
}

/// The same, as numbers that are normal whatever is stored, and anything: quick.
#[inline]
pub fn values(stored: Rgbe) -> [f64; 4] {
    let exponent = u64::from(stored[3]);
    let scale = f64::from_bits((exponent + 1023 - 136) << 52);
    let scale = if exponent == 0 { 0.0 } else { scale };
    stored.map(|m| (f64::from(m) + 0.5) * scale)
}

/// The stored pixel nearest below these values: 256 · value / 2^k cut off, where 2^k is the power of two just above the
/// largest. Negative values become 0. `None` if a value is not a number or not below 2^127.
pub fn encode(color: [f32; 3]) -> Option<Rgbe> {
    if color.iter().any(|v| v.is_nan()) {
        return None;
    }
    let largest = color[0].max(color[1]).max(color[2]);
    if largest <= 1e-32 {
        return Some([0; 4]);
    }
    if largest >= power_of_two(127) {
        return None;
    }
    // The largest is at least 1e-32, so its exponent can be read from its bits: 2^(exponent − 127) ≤ largest.
    let exponent = (largest.to_bits() >> 23) as i32 - 126;
    let scale = power_of_two(8 - exponent);
    let [r, g, b] = color.map(|v| (v * scale) as u8);
    Some([r, g, b, (exponent + 128) as u8])
}

/// The distance between the values that can be stored beside these; 0 for those that never were.
pub fn step(color: [f32; 3]) -> f32 {
    match encode(color) {
        Some(stored @ [.., e]) if e > 0 && decode(stored) == color => power_of_two(i32::from(e) - 136),
        _ => 0.0,
    }
}

/// 2^n for −126 ≤ n ≤ 127.
fn power_of_two(n: i32) -> f32 {
    f32::from_bits(((n + 127) as u32) << 23)
}

/// Reads a RADIANCE picture.
pub fn read(bytes: &[u8], name: &str) -> Result<Picture> {
    let (header, rest) = read_header(bytes, name)?;
    let mut input = Bytes { rest, name };
    let resolution = Resolution::read(&mut input)?;
    let in_file = |e: Error| Error::new(format!("{name}: {}", e.message));
    let count = pixel_count(resolution.length, resolution.lines).map_err(in_file)?;

    if count > FREE.saturating_add(input.rest.len().saturating_mul(PIXELS_PER_BYTE)) {
        let bytes = input.rest.len();
        return Err(Error::new(format!("{name}: {count} pixels do not fit into its {bytes} bytes; the file is damaged, or cut off")));
    }

    // Decode in the order of the file; what is missing is found out before its memory is touched.
    let mut pixels = Vec::new();
    reserve(&mut pixels, count).map_err(in_file)?;
    let mut line = vec![[0; 4]; resolution.length];
    for y in 0..resolution.lines {
        read_line(&mut input, &mut line)
            .map_err(|what| Error::new(format!("{name}: {what} in line {} of {} of the picture", y + 1, resolution.lines)))?;
        pixels.extend(line.iter().map(|&pixel| decode(pixel)));
    }

    let (width, height) = resolution.size();
    if !resolution.is_standard() {
        let mut turned = Vec::new();
        reserve(&mut turned, count).map_err(in_file)?;
        turned.extend((0..count).map(|i| pixels[resolution.index(i % width, i / width)]));
        pixels = turned;
    }
    Ok(Picture { width, height, header, pixels })
}

/// Writes a RADIANCE picture, top row first.
pub fn write(picture: &Picture) -> Result<Vec<u8>> {
    let mut out = b"#?RADIANCE\n".to_vec();
    for line in &picture.header.lines {
        out.extend(line.as_bytes());
        out.push(b'\n');
    }
    let format = match picture.header.format {
        Format::Rgb => "32-bit_rle_rgbe",
        Format::Xyz => "32-bit_rle_xyze",
    };
    out.extend(format!("FORMAT={format}\n\n-Y {:8} +X {:8}\n", picture.height, picture.width).as_bytes());
    let mut line = vec![[0; 4]; picture.width];
    for (y, row) in picture.pixels.chunks_exact(picture.width).enumerate() {
        for (x, (&color, pixel)) in row.iter().zip(&mut line).enumerate() {
            *pixel = encode(color).ok_or_else(|| {
                let ([r, g, b], place) = (color, super::place(y * picture.width + x, picture.width));
                Error::new(format!("the pixel in {place} is {r} {g} {b}, which a RADIANCE picture cannot hold"))
            })?;
        }
        write_line(&mut out, &line);
    }
    Ok(out)
}

/// What was read of a picture's pixels, or what is wrong with them; the caller says where.
type Part<T> = std::result::Result<T, &'static str>;

/// The part of the input that is not yet read.
struct Bytes<'a> {
    rest: &'a [u8],
    name: &'a str,
}

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Part<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or("the file ends")?;
        self.rest = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Part<u8> {
        Ok(self.take(1)?[0])
    }
}

/// Reads the lines up to the empty one.
fn read_header<'a>(bytes: &'a [u8], name: &str) -> Result<(Header, &'a [u8])> {
    if !bytes.first().is_some_and(|c| (b' '..=b'~').contains(c)) {
        let what = if bytes.is_empty() { "the file is empty" } else { "neither a RADIANCE picture nor OpenEXR" };
        return Err(Error::new(format!("{name}: {what}")));
    }
    let mut header = Header::default();
    let mut rest = bytes;
    loop {
        let end = rest.iter().position(|&c| c == b'\n');
        let Some(end) = end.filter(|end| bytes.len() - rest.len() + end < MAX_HEADER) else {
            let what = if bytes.len() < MAX_HEADER { "the file ends in its header" } else { "no end of the header within 64 KiB" };
            return Err(Error::new(format!("{name}: {what}; is it a RADIANCE picture?")));
        };
        let line = rest[..end].strip_suffix(b"\r").unwrap_or(&rest[..end]);
        let first = rest.len() == bytes.len();
        rest = &rest[end + 1..];
        if line.is_empty() {
            header.check(name)?;
            return Ok((header, rest));
        }
        let line = String::from_utf8_lossy(line);
        if let Some(format) = line.strip_prefix("FORMAT=") {
            header.format = match format.trim() {
                "32-bit_rle_rgbe" => Format::Rgb,
                "32-bit_rle_xyze" => Format::Xyz,
                "Radiance_spectra" => {
                    return Err(Error::new(format!("{name}: a spectral picture; make it RGB first, for example with rcomb -c RGB")));
                }
                other => {
                    return Err(Error::new(format!(
                        "{name}: FORMAT={other} is not a format of pictures (32-bit_rle_rgbe or 32-bit_rle_xyze)"
                    )));
                }
            };
        } else if !(first && line.starts_with("#?")) {
            header.push(&line);
        }
    }
}

/// The order of the pixels in a file: which axis runs slowly, and from which end each begins.
#[derive(Clone, Copy, Debug)]
struct Resolution {
    /// Lines are columns of the picture.
    columns: bool,
    /// X runs from right to left.
    leftward: bool,
    /// Y runs from bottom to top.
    upward: bool,
    lines: usize,
    /// Pixels in a line.
    length: usize,
}

impl Resolution {
    fn read(input: &mut Bytes) -> Result<Self> {
        let end = input.rest.iter().take(32).position(|&c| c == b'\n');
        let end = end.ok_or_else(|| Error::new(format!("{}: no resolution line like -Y 480 +X 640 after the header", input.name)))?;
        let text = String::from_utf8_lossy(&input.rest[..end]);
        input.rest = &input.rest[end + 1..];
        let words: Vec<_> = text.split_whitespace().collect();
        let axis = |sign_axis: &str, length: &str| match (sign_axis.as_bytes(), length.parse::<usize>()) {
            (&[sign @ (b'+' | b'-'), axis @ (b'X' | b'Y')], Ok(length)) if length > 0 => Some((sign == b'-', axis, length)),
            _ => None,
        };
        let axes = match words[..] {
            [a, m, b, n] => axis(a, m).zip(axis(b, n)),
            _ => None,
        };
        match axes {
            Some(((up, b'Y', lines), (left, b'X', length))) => Ok(Self { columns: false, leftward: left, upward: !up, lines, length }),
            Some(((left, b'X', lines), (up, b'Y', length))) => Ok(Self { columns: true, leftward: left, upward: !up, lines, length }),
            _ => Err(Error::new(format!("{}: {text:?} is not a resolution line like -Y 480 +X 640", input.name))),
        }
    }

    /// Width and height.
    fn size(&self) -> (usize, usize) {
        if self.columns { (self.lines, self.length) } else { (self.length, self.lines) }
    }

    fn is_standard(&self) -> bool {
        !self.columns && !self.leftward && !self.upward
    }

    /// Where in the file the pixel in column `x` from the left and row `y` from the top stands.
    fn index(&self, x: usize, y: usize) -> usize {
        let (width, height) = self.size();
        let x = if self.leftward { width - 1 - x } else { x };
        let y = if self.upward { height - 1 - y } else { y };
        if self.columns { x * height + y } else { y * width + x }
    }
}

/// Reads one line in whichever encoding it is.
fn read_line(input: &mut Bytes, line: &mut [Rgbe]) -> Part<()> {
    match *input.rest {
        [2, 2, high @ 0..128, low, ..] => {
            if usize::from(high) << 8 | usize::from(low) != line.len() {
                return Err("a line of another length than the picture's width");
            }
            input.take(4)?;
            for channel in 0..4 {
                read_runs(input, line, channel)?;
            }
            Ok(())
        }
        _ => read_plain(input, line),
    }
}

/// Reads one channel of a line: counts above 128 repeat the next byte, others announce single bytes.
fn read_runs(input: &mut Bytes, line: &mut [Rgbe], channel: usize) -> Part<()> {
    let mut x = 0;
    while x < line.len() {
        let code = usize::from(input.byte()?);
        let count = if code > 128 { code - 128 } else { code };
        let pixels = line.get_mut(x..x + count).ok_or("a run beyond the end of the line")?;
        if code > 128 {
            let value = input.byte()?;
            pixels.iter_mut().for_each(|pixel| pixel[channel] = value);
        } else {
            let values = input.take(count)?;
            pixels.iter_mut().zip(values).for_each(|(pixel, &value)| pixel[channel] = value);
        }
        x += count;
    }
    Ok(())
}

/// Reads a line of whole pixels, where (1, 1, 1, n) repeats the pixel before it n times; consecutive repeats count n · 256, n · 65536….
fn read_plain(input: &mut Bytes, line: &mut [Rgbe]) -> Part<()> {
    let (mut x, mut shift) = (0, 0);
    while x < line.len() {
        let &[r, g, b, e] = input.take(4)? else { return Err("the file ends") };
        if x > 0 && [r, g, b] == [1, 1, 1] {
            if shift > 24 {
                return Err("more than four repeat counts on end");
            }
            let end = line.len().min(x + (usize::from(e) << shift));
            let before = line[x - 1];
            line[x..end].fill(before);
            x = end;
            shift += 8;
        } else {
            line[x] = [r, g, b, e];
            x += 1;
            shift = 0;
        }
    }
    Ok(())
}

/// Writes one line as RADIANCE writes it.
fn write_line(out: &mut Vec<u8>, line: &[Rgbe]) {
    if !RUN_LENGTH_WIDTHS.contains(&line.len()) {
        out.extend(line.as_flattened());
        return;
    }
    out.extend([2, 2, (line.len() >> 8) as u8, line.len() as u8]);
    for channel in 0..4 {
        let mut start = 0;
        while start < line.len() {
            // Find the next run that is worth it, and write what stands before it: singly, or as one short run if it is one.
            let (run, length) = next_run(line, channel, start);
            let before = &line[start..run];
            let alike = before.iter().all(|pixel| pixel[channel] == before[0][channel]);
            if (2..MIN_RUN).contains(&before.len()) && alike {
                out.extend([128 + before.len() as u8, before[0][channel]]);
            } else {
                for part in before.chunks(MAX_SINGLE) {
                    out.push(part.len() as u8);
                    out.extend(part.iter().map(|pixel| pixel[channel]));
                }
            }
            if length > 0 {
                out.extend([128 + length as u8, line[run][channel]]);
            }
            start = run + length;
        }
    }
}

/// Where the next run of at least [`MIN_RUN`] begins and its length, at most [`MAX_RUN`]; the end and 0 if there is none.
fn next_run(line: &[Rgbe], channel: usize, start: usize) -> (usize, usize) {
    let mut begin = start;
    while begin < line.len() {
        let value = line[begin][channel];
        let length = line[begin..].iter().take(MAX_RUN).take_while(|pixel| pixel[channel] == value).count();
        if length >= MIN_RUN {
            return (begin, length);
        }
        begin += length;
    }
    (line.len(), 0)
}
