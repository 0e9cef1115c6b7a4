//! The paper's method as a contender.

use super::clip::Clip;
use super::measure::{Measured, Runner, Started, compare};
use anyhow::Result;
use std::time::Instant;
use trisap::{Aabb, Config, Mode};
use trisap_paper::{Settings, World};

struct AsPrinted {
    /// The clip's boxes, as the method takes them.
    frames: Vec<Vec<trisap_paper::Aabb>>,
    world: World,
    at_end: bool,
    milliseconds: Vec<f64>,
}

/// Plays the clip once and compares what can be compared.
pub(super) fn start<'c>(clip: &Clip) -> Started<'c> {
    let of = |aabb: &Aabb| trisap_paper::Aabb::new(aabb.min, aabb.max);
    let frames: Vec<Vec<_>> = clip.frames.iter().map(|boxes| boxes.iter().map(of).collect()).collect();
    let mut world = World::new(frames[0].len(), Settings::default());
    let mut measured = Measured { name: "the paper's method".into(), ..Measured::default() };
    for (frame, boxes) in frames.iter().enumerate() {
        let pairs = world.step(boxes);
        if let Some(expected) = clip.pairs(frame) {
            let mut reported = pairs.to_vec();
            reported.sort_unstable();
            measured.verdict.add(compare(expected, &reported, Mode::Exact, 0));
        }
    }
    (Box::new(AsPrinted { frames, world, at_end: true, milliseconds: Vec::new() }), measured)
}

impl Runner for AsPrinted {
    fn pass(&mut self) -> Result<Option<Config>> {
        let count = self.frames.len();
        for k in 1..count {
            let frame = if self.at_end { count - 1 - k } else { k };
            let start = Instant::now();
            self.world.step(&self.frames[frame]);
            self.milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
        }
        self.at_end = !self.at_end;
        // There is always room: its lists of pairs grow.
        Ok(None)
    }

    fn milliseconds(&self) -> &[f64] {
        &self.milliseconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trisap::scene::{Kind, Objects, Setup};

    #[test]
    fn the_method_is_measured_and_compared() -> Result<()> {
        let setup = Setup { kind: Kind::Gravity, objects: Objects::Assorted, count: 400, seed: 3 };
        let (mut runner, measured) = start(&Clip::synthetic(setup, 30, 5));
        assert!(measured.verdict.is_good() && measured.verdict.frames == 5 && measured.verdict.pairs > 0);
        assert!(runner.pass()?.is_none() && runner.pass()?.is_none());
        assert_eq!(runner.milliseconds().len(), 8);
        Ok(())
    }
}
