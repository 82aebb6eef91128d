//! A stream of rays on standard input, and the records that answer it.

use super::{Console, Outcome, Output};
use crate::picture::SOFTWARE;
use crate::rays::{Asked, Form, Reader, Space, Teller, is_still};
use crate::render::Budget;
use rayon::prelude::*;
use std::io::{self, BufReader};
use std::path::Path;

/// How many rays are answered together where nothing else says so.
const BATCH: usize = 8192;
/// How many bytes of rays are read at a time.
const CHUNK: usize = 1 << 16;

/// What a stream of answers looks like.
pub struct Stream<'a> {
    /// `-x`: how many rays make a line of a picture, or are answered before anything else is read.
    pub x: usize,
    /// `-y`: how many lines.
    pub y: usize,
    /// Whether it has a header.
    pub header: bool,
    /// Where it goes; nothing is standard output.
    pub output: Option<&'a Path>,
}

/// Answers the rays on standard input.
pub fn answer(mut teller: Teller, stream: &Stream, console: &Console) -> Outcome<()> {
    let mut output = Output::create(stream.output)?;
    output.write(head(&teller, stream, console).as_bytes())?;
    // As for rtrace: with a picture's height, answers need not be out before the next ray is read, unless they come one by one.
    let flushed = stream.x > 0 && (stream.y == 0 || stream.x == 1);
    if flushed {
        output.flush()?;
    }
    let mut left = match (stream.x.max(1) as u64).checked_mul(stream.y as u64) {
        Some(0) => None,
        wanted => Some(wanted.unwrap_or(u64::MAX)),
    };
    let mut reader = Reader::new(BufReader::with_capacity(CHUNK, io::stdin().lock()), teller.format.input);
    let mut number = 0;
    let mut last = [0.0; 6];
    // Time is for each batch, which is all rays where nothing divides them.
    let time = if let Budget::Time(time) = teller.budget { Some(time) } else { None };
    let all = if time.is_some() { usize::MAX } else { BATCH };
    let mut trouble = None;
    let mut batch: Vec<[f64; 6]> = Vec::new();
    while left != Some(0) && trouble.is_none() {
        let most = (if flushed { stream.x } else { all }).min(left.unwrap_or(u64::MAX).try_into().unwrap_or(usize::MAX));
        batch.clear();
        trouble = reader.read(&mut batch, most).err();
        let at_once = batch.last().is_some_and(is_still);
        if batch.is_empty() {
            break;
        }
        if let Some(time) = time {
            teller.budget = Budget::Time(time.mul_f64(rayon::current_num_threads().min(batch.len()) as f64 / batch.len() as f64));
        }
        let rays = &batch[..batch.len() - at_once as usize];
        let share = rays.len().div_ceil(16 * rayon::current_num_threads()).max(1);
        let records = rays.par_chunks(share).enumerate().with_max_len(1).map(|(part, rays)| {
            let mut writer = teller.writer(rays.len());
            let rays: Vec<Asked> = rays.iter().map(|&ray| Asked::new(ray)).collect();
            teller.tell(&rays, number + (part * share) as u64, &mut writer);
            writer.bytes
        });
        records.collect::<Vec<_>>().iter().try_for_each(|records| output.write(records))?;
        last = *rays.last().unwrap_or(&last);
        if at_once {
            let mut writer = teller.writer(1);
            teller.empty(&Asked::new(last), &mut writer);
            output.write(&writer.bytes)?;
        }
        number += batch.len() as u64;
        left = left.map(|left| left - batch.len() as u64);
        console.progress(|| format!("{number} rays"));
        if flushed || at_once {
            output.flush()?;
        }
    }
    if let Some(error) = trouble {
        output.flush()?;
        return Err(error.into());
    }
    if let Some(left) = left.filter(|&left| left > 0) {
        console.warn(&format!("the input ended {left} rays before -x and -y are reached"));
    }
    output.finish()
}

/// The header of a stream of answers, and the resolution line of a picture.
fn head(teller: &Teller, stream: &Stream, console: &Console) -> String {
    let mut head = String::new();
    let (output, space) = (teller.format.output, teller.space);
    if stream.header {
        head += &format!("#?RADIANCE\n{}\n{SOFTWARE}\n", console.trail());
        if let Some(count) = teller.fields.count(space) {
            head += &format!("NCOMP={count}\n");
        }
        if space == Space::Xyz {
            head += "PRIMARIES= 1.0000 0.0000 0.0000 1.0000 0.0000 0.0000 0.3333 0.3333\n";
        }
        if let Form::Single | Form::Double = output {
            head += &format!("BigEndian={}\n", cfg!(target_endian = "big") as u8);
        }
        head += &format!("FORMAT={}\n\n", output.name(space));
    }
    if stream.x > 0 && stream.y > 0 {
        head += &format!("-Y {:8} +X {:8}\n", stream.y, stream.x);
    }
    head
}
