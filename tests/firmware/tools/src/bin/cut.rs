//! Cuts some objects and frames out of a recording: `cut FROM.aabbs TO.aabbs OBJECTS FIRST_FRAME FRAMES`.
//!
//! Takes the objects that are nearest to the middle of the world's floor (the lowest y) in the first frame, the nearest
//! first.

use anyhow::{Context, Result};
use std::env;
use std::fs::File;
use trisap::Boxes;
use trisap::recording::{Header, PaddedBox, Recording, Writer};

fn main() -> Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [from, to, objects, first, frames] = &arguments[..] else {
        anyhow::bail!("usage: cut FROM.aabbs TO.aabbs OBJECTS FIRST_FRAME FRAMES");
    };
    let (objects, first, frames): (usize, usize, u32) = (objects.parse()?, first.parse()?, frames.parse()?);

    let recording = Recording::open(from)?;
    let header = recording.header();
    let start = recording.frame(first).context("the recording has no such frame")?;
    let floor = [0, 1, 2]
        .map(|k| if k == 1 { 2.0 * header.world.min[1] } else { header.world.min[k] + header.world.max[k] });
    // Twice the distance, squared.
    let distance =
        |bounds: &PaddedBox| (0..3).map(|k| (bounds[k] + bounds[4 + k] - floor[k]).powi(2)).sum::<f32>();
    let mut nearest: Vec<usize> = (0..start.len()).collect();
    nearest.sort_by(|&a, &b| distance(&start[a]).total_cmp(&distance(&start[b])).then(a.cmp(&b)));
    nearest.truncate(objects);

    let cut = Header { count: u32::try_from(nearest.len())?, frames, ..header.clone() };
    let mut writer = Writer::new(File::create(to)?, cut)?;
    for frame in recording.frames().skip(first).take(frames as usize) {
        let boxes: Vec<PaddedBox> = nearest.iter().map(|&index| frame[index]).collect();
        writer.write_frame(Boxes::padded(&boxes))?;
    }
    writer.finish()?;
    Ok(())
}
