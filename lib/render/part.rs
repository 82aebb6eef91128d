//! A part of a picture's samples as numbers that lose nothing, and the whole made of parts.

use super::{GROUPS, Pixel, Rendering};
use crate::color::to_pixel;
use crate::error::{Error, Result};
use crate::picture::exr::{Plane, Planes, Samples};
use crate::picture::{Header, reserve};
use std::ops::Range;

/// The header line that says which samples a part holds.
const RANGE: &str = "SAMPLES=";

/// The sums of a pixel.
const SUMS: usize = 3 * GROUPS;

/// The option that asks for a part, and the one that asks for the whole.
const PART_OPTION: &str = "--samples";
const WHOLE_OPTION: &str = "--spp";

/// The picture of a part and, exactly, all sums of its pixels: each the sum of numbers of double precision, whose upper and lower
/// halves are planes of whole numbers, `sum0.GROUP.C.high` and `.low`; should one number not do, `sum1…` has what it leaves out, and so on.
pub fn part(width: usize, height: usize, mut header: Header, samples: &Range<u32>, rendering: &Rendering) -> Planes {
    let pixels = &rendering.pixels;
    header.push(&format!("{RANGE} {}..{}", samples.start, samples.end));
    let mut planes = Planes { width, height, header, planes: Vec::new() };
    let means: Vec<[f32; 3]> = pixels.iter().map(|p| to_pixel(p.mean())).collect();
    planes.push_picture("", &means);
    let mut push = |name: &str, of: &dyn Fn(&Pixel) -> u32| {
        planes.planes.push(Plane { name: name.into(), samples: Samples::U32(pixels.iter().map(of).collect()) });
    };
    push("samples", &|p| p.samples());
    push("surface", &|p| p.surface as u32);
    push("exact", &|p| p.exact as u32);
    // How many numbers each sum takes, and where the first of them is among all that are written.
    let mut depths = [0; SUMS];
    for pixel in pixels {
        let mut own = [0; SUMS];
        pixel.parts().for_each(|(sum, _)| own[sum] += 1);
        depths.iter_mut().zip(own).for_each(|(depth, own)| *depth = own.max(*depth));
    }
    let firsts: [usize; SUMS] = std::array::from_fn(|sum| depths[..sum].iter().sum());
    let mut numbers = vec![vec![[0; 2]; pixels.len()]; depths.iter().sum()];
    for (i, pixel) in pixels.iter().enumerate() {
        let mut next = firsts;
        for (sum, value) in pixel.parts() {
            let bits = value.to_bits();
            numbers[next[sum]][i] = [(bits >> 32) as u32, bits as u32];
            next[sum] += 1;
        }
    }
    let of_sums = (0..SUMS).flat_map(|sum| (0..depths[sum]).map(move |level| names(level, sum)));
    for (names, numbers) in of_sums.zip(&numbers) {
        for (half, name) in names.into_iter().enumerate() {
            planes.planes.push(Plane { name, samples: Samples::U32(numbers.iter().map(|bits| bits[half]).collect()) });
        }
    }
    planes
}

/// The names of the planes of a number that is part of a sum.
fn names(level: usize, sum: usize) -> [String; 2] {
    ["high", "low"].map(|half| format!("sum{level}.{:02}.{}.{half}", sum / 3, ["R", "G", "B"][sum % 3]))
}

/// The whole of parts (their names, for messages, and what they hold) in any order: width, height, header and pixels of one rendering of
/// all the samples. Errors unless the parts are of the same picture and have all samples from 0 on once.
pub fn join(parts: impl Iterator<Item = Result<(String, Planes)>>) -> Result<(usize, usize, Header, Rendering)> {
    let mut ranges: Vec<(Range<u32>, String)> = Vec::new();
    let mut whole: Option<(usize, usize, Header, Vec<Pixel>)> = None;
    for named in parts {
        let (name, planes) = named?;
        let (range, header) = understood(&planes, &name)?;
        let (width, height, first, pixels) = match &mut whole {
            Some(whole) => whole,
            None => whole.insert((planes.width, planes.height, header.clone(), blank(planes.width * planes.height)?)),
        };
        if (*width, *height) != (planes.width, planes.height) || *first != header {
            return Err(Error::new(format!(
                "{name}: not of the same picture as {}; parts differ in nothing but {PART_OPTION}, -o and -n",
                ranges[0].1
            )));
        }
        append(&planes, &range, pixels, &name)?;
        ranges.push((range, name));
    }
    let Some((width, height, mut header, pixels)) = whole else { return Err(Error::new("name the parts that are to be joined")) };
    ranges.sort_by_key(|(range, _)| range.start);
    let mut end = 0;
    for (range, name) in &ranges {
        if range.start > end {
            return Err(Error::new(format!("the samples {end}..{} are in no part; make one with {PART_OPTION}", range.start)));
        }
        if range.start < end {
            return Err(Error::new(format!("{name}: the samples {}..{} are in another part too; leave one out", range.start, end)));
        }
        end = range.end;
    }
    if let Some(command) = header.lines.first_mut() {
        *command = command.replace(PART_OPTION, &format!("{WHOLE_OPTION} {end}"));
    }
    Ok((width, height, header, Rendering::of(pixels)))
}

/// So many pixels without samples.
fn blank(count: usize) -> Result<Vec<Pixel>> {
    let mut pixels = Vec::new();
    reserve(&mut pixels, count)?;
    pixels.resize(count, Pixel::default());
    Ok(pixels)
}

/// Which samples a part holds, and its header without that.
fn understood(planes: &Planes, name: &str) -> Result<(Range<u32>, Header)> {
    let mut header = planes.header.clone();
    let range = header.lines.iter().find_map(|line| range(line.strip_prefix(RANGE)?.trim()));
    let range = range.ok_or_else(|| Error::new(format!("{name}: not a part of a picture, as {PART_OPTION} A..B with -o makes it")))?;
    header.lines.retain(|line| !line.starts_with(RANGE));
    if let Some(command) = header.lines.first_mut()
        && let Some((before, after)) = command.split_once(PART_OPTION)
    {
        // Behind the option stands what it was given.
        let rest = after.char_indices().skip(1).find(|(_, c)| *c == ' ').map_or("", |(at, _)| &after[at..]);
        *command = format!("{before}{PART_OPTION}{rest}");
    }
    Ok((range, header))
}

/// The range that `A..B` names; `None` if it is none, or empty.
pub fn range(text: &str) -> Option<Range<u32>> {
    let (start, end) = text.split_once("..")?;
    let range = start.parse().ok()?..end.parse().ok()?;
    (range.start < range.end).then_some(range)
}

/// Adds a part to the pixels.
fn append(planes: &Planes, range: &Range<u32>, pixels: &mut [Pixel], name: &str) -> Result<()> {
    let plane = |plane: &str| match planes.plane(plane).map(|plane| &plane.samples) {
        Some(Samples::U32(values)) => Some(values),
        _ => None,
    };
    let needed = |wanted: &str| plane(wanted).ok_or_else(|| Error::new(format!("{name}: no plane {wanted}; it is no whole part")));
    let (samples, surface, exact) = (needed("samples")?, needed("surface")?, needed("exact")?);
    let mut parts: Vec<Pixel> = Vec::with_capacity(pixels.len());
    for i in 0..pixels.len() {
        if samples[i] != range.end - range.start && exact[i] == 0 {
            return Err(Error::new(format!(
                "{name}: a pixel has {} samples of {}; it is no whole part",
                samples[i],
                range.end - range.start
            )));
        }
        parts.push(Pixel::taken(range, surface[i] != 0, exact[i] != 0));
    }
    for sum in 0..SUMS {
        for level in 0.. {
            let names = names(level, sum);
            if planes.plane(&names[0]).or(planes.plane(&names[1])).is_none() {
                break;
            }
            let (high, low) = (needed(&names[0])?, needed(&names[1])?);
            for (i, part) in parts.iter_mut().enumerate() {
                let value = f64::from_bits((high[i] as u64) << 32 | low[i] as u64);
                if !value.is_finite() {
                    return Err(Error::new(format!("{name}: a sum of a pixel is {value}; it is no whole part")));
                }
                part.add_to(sum, value);
            }
        }
    }
    pixels.iter_mut().zip(&parts).for_each(|(pixel, part)| pixel.append(part));
    Ok(())
}
