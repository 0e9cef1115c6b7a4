//! What the steps are measured on: the recording, and what is as bad as input can be.

use crate::recording;
use trisap_core::Aabb;

/// Makes the boxes of a frame.
pub struct Scene {
    /// Its name.
    pub name: &'static str,
    /// Pairs that the world has room for, times the number of objects; `None` for all that there can be.
    pub pairs_per_object: Option<usize>,
    /// Fills in the boxes of frame `index`.
    pub frame: fn(index: usize, boxes: &mut [Aabb]),
}

/// All of them.
pub const SCENES: [Scene; 6] = [
    Scene { name: "recorded", pairs_per_object: Some(4), frame: recorded },
    Scene { name: "resting", pairs_per_object: Some(4), frame: |_, boxes| recorded(0, boxes) },
    Scene { name: "teleporting", pairs_per_object: Some(4), frame: teleporting },
    Scene { name: "reversing", pairs_per_object: Some(4), frame: reversing },
    Scene { name: "overlapping", pairs_per_object: None, frame: overlapping },
    Scene { name: "overlapping, no room", pairs_per_object: Some(4), frame: overlapping },
];

fn recorded(index: usize, boxes: &mut [Aabb]) {
    let frame = recording::frame(index, boxes.len());
    for (at, aabb) in boxes.iter_mut().enumerate() {
        *aabb = frame.and_then(|frame| frame.get(at)).unwrap_or_default();
    }
}

/// Unit cubes, each somewhere else in each frame, at the recording's density.
fn teleporting(index: usize, boxes: &mut [Aabb]) {
    let side = match boxes.len() {
        0..=16 => 5.4,
        17..=32 => 6.8,
        33..=64 => 8.6,
        65..=128 => 10.8,
        _ => 13.7,
    };
    let mut random = Random(index as u32 + 1);
    for aabb in boxes {
        let min = [(); 3].map(|()| random.below(side - 1.0));
        *aabb = Aabb::new(min, min.map(|low| low + 1.0));
    }
}

/// A diagonal of unit cubes whose order turns around in each frame.
fn reversing(index: usize, boxes: &mut [Aabb]) {
    let sign = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    for (at, aabb) in boxes.iter_mut().enumerate() {
        let low = sign * at as f32;
        *aabb = Aabb::new([low; 3], [low + 1.0; 3]);
    }
}

/// All overlap all others, and all move.
fn overlapping(index: usize, boxes: &mut [Aabb]) {
    let mut random = Random(index as u32 + 1);
    for aabb in boxes {
        let [a, b, c, d, e, f] = [(); 6].map(|()| random.below(1.0));
        *aabb = Aabb::new([a, b, c], [1.0 + d, 1.0 + e, 1.0 + f]);
    }
}

/// Xorshift.
struct Random(u32);

impl Random {
    fn below(&mut self, limit: f32) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 >> 8) as f32 * (limit / (1 << 24) as f32)
    }
}
