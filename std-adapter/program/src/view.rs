//! `trisap view`: a page that shows a scene in motion, with the boxes lit that are in a pair.
//!
//! The page holds all frames: for each box its corners, as shares of the scene in 16 bits, and whether it is lit. So it needs no
//! server, and the pairs are those that a step has found.

use crate::Outcome;
use crate::args::{EngineArgs, ViewArgs};
use crate::drive::{Frame, Visitor, drive};
use crate::setup::Engine;
use crate::source::Source;
use anyhow::{Context, Result, ensure};
use std::process::Command;
use trisap::{Aabb, Capacity, Config};

const PAGE: &str = include_str!("view.html");

/// Bytes of all boxes of all frames that a browser still takes with ease.
const MOST_BYTES: usize = 1 << 26;

pub(crate) fn view(args: &ViewArgs) -> Result<Outcome> {
    let mut source = Source::of(&args.scene, Some(args.frames))?;
    let (objects, frames) = (source.objects() as usize, source.frames() as usize);
    let most = MOST_BYTES / 13 / objects.max(1);
    ensure!(
        frames <= most,
        "{frames} frames of {objects} boxes are too many for a page; take --frames {most} or fewer boxes"
    );
    let engine = Engine::new(&EngineArgs::default())?;
    let mut film = Film::default();
    let config = Config::new(Capacity::for_objects(source.objects()));
    drive(&mut source, config, &engine, &mut film)?;
    let data = film.data();
    let page = PAGE
        .replace("{title}", &source.name().replace('&', "&amp;").replace('<', "&lt;"))
        .replace("{boxes}", &objects.to_string())
        .replace("{pairs}", &format!("{:?}", film.pairs))
        .replace("{sides}", &format!("{:?}", film.sides()))
        .replace("{up}", &film.up().to_string())
        .replace("{data}", &base64(&data));
    std::fs::write(&args.out, page).with_context(|| args.out.display().to_string())?;
    println!("wrote {}: {} frames of {objects} boxes", args.out.display(), film.frames.len());
    if args.open {
        let opener = if cfg!(windows) {
            "explorer"
        } else if cfg!(target_os = "macos") {
            "open"
        } else {
            "xdg-open"
        };
        Command::new(opener).arg(&args.out).spawn().with_context(|| format!("cannot start {opener}"))?;
    }
    Ok(Outcome::Good)
}

/// All frames: the boxes, and which of them are in a pair.
#[derive(Default)]
struct Film {
    frames: Vec<Vec<(Aabb, bool)>>,
    pairs: Vec<usize>,
}

impl Visitor for Film {
    fn start(&mut self) {
        *self = Self::default();
    }

    fn visit(&mut self, frame: &Frame<'_>) -> Result<bool> {
        let pairs = frame.pairs.all.sorted();
        let boxes = (0..frame.boxes.len()).map(|at| frame.boxes.get(at).unwrap_or_default());
        let mut boxes: Vec<_> = boxes.map(|aabb| (aabb, false)).collect();
        for slot in pairs.iter().flatten() {
            boxes[*slot as usize].1 = true;
        }
        self.frames.push(boxes);
        self.pairs.push(pairs.len());
        Ok(true)
    }
}

impl Film {
    /// Where the scene is: its middle nine tenths on each axis, with half as much again around, so that a ground without end or
    /// a box that has left does not make all others dots.
    fn extent(&self) -> [[f32; 2]; 3] {
        [0, 1, 2].map(|k| {
            let boxes = self.frames.iter().flatten();
            let ends = boxes.flat_map(|(aabb, _)| [aabb.min[k], aabb.max[k]]);
            let mut ends: Vec<f32> = ends.filter(|end| end.is_finite()).collect();
            ends.sort_unstable_by(f32::total_cmp);
            let at = |share: usize| ends.get(ends.len() * share / 20).copied().unwrap_or(0.0);
            let (low, high) = (at(1), at(19));
            let around = 0.25 * (high - low).max(f32::MIN_POSITIVE);
            let first = ends.first().copied().unwrap_or(0.0);
            let last = ends.last().copied().unwrap_or(1.0);
            [first.max(low - around), last.min(high + around)]
        })
    }

    fn sides(&self) -> [f32; 3] {
        self.extent().map(|[low, high]| (high - low).max(f32::MIN_POSITIVE))
    }

    /// The axis that is most likely upwards: the thinnest one, the last of equal ones.
    fn up(&self) -> usize {
        let sides = self.sides();
        [2, 1, 0].into_iter().min_by(|a, b| sides[*a].total_cmp(&sides[*b])).unwrap_or(2)
    }

    /// For each frame and box six numbers of 16 bits, and a byte: lit or not.
    fn data(&self) -> Vec<u8> {
        let extent = self.extent();
        let mut data = Vec::new();
        for (aabb, lit) in self.frames.iter().flatten() {
            for corner in [aabb.min, aabb.max] {
                for k in 0..3 {
                    let [low, high] = extent[k];
                    let share = (corner[k] - low) / (high - low).max(f32::MIN_POSITIVE);
                    data.extend(((share.clamp(0.0, 1.0) * 65535.0) as u16).to_le_bytes());
                }
            }
            data.push(u8::from(*lit));
        }
        data
    }
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len() / 3 * 4 + 4);
    for three in bytes.chunks(3) {
        let bits =
            three.iter().chain([0; 2].iter()).take(3).fold(0, |bits, byte| bits << 8 | u32::from(*byte));
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k) & 63) as usize];
            text.push(if k <= three.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_become_letters() {
        let texts = ["", "f", "fo", "foo", "foob", "fooba", "foobar"].map(|text| base64(text.as_bytes()));
        assert_eq!(texts, ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"]);
    }
}
