//! Brute force, random numbers, and the comparison of the two.

use trisap_paper::{Aabb, Pair, Settings, World};

/// All against all.
pub(crate) fn brute_force(boxes: &[Aabb]) -> Vec<Pair> {
    let touch = |a: &Aabb, b: &Aabb| (0..3).all(|k| a.min[k] <= b.max[k] && b.min[k] <= a.max[k]);
    let of = |a: usize| ((a + 1)..boxes.len()).filter(move |&b| touch(&boxes[a], &boxes[b]));
    (0..boxes.len()).flat_map(|a| of(a).map(move |b| [a as u32, b as u32])).collect()
}

/// Leaves of two sizes, without a margin, with a small and with a large one.
pub(crate) fn settings() -> impl Iterator<Item = Settings> {
    [1, 10, 64].into_iter().flat_map(|leaf| [0.0, 0.01, 0.5].map(|margin| Settings { leaf, margin }))
}

/// Steps one world for each of the settings through the frames, and compares each step with brute force.
pub(crate) fn check(name: &str, frames: &[Vec<Aabb>]) {
    let expected: Vec<Vec<Pair>> = frames.iter().map(|boxes| brute_force(boxes)).collect();
    for settings in settings() {
        let mut world = World::new(frames[0].len(), settings);
        for (frame, (boxes, expected)) in frames.iter().zip(&expected).enumerate() {
            let mut pairs = world.step(boxes).to_vec();
            pairs.sort_unstable();
            // Not `assert_eq`, which would print thousands of pairs.
            assert!(
                pairs == *expected,
                "{name}, {settings:?}, frame {frame}: {} pairs, {} overlap",
                pairs.len(),
                expected.len()
            );
        }
    }
}

/// Random numbers: a xorshift.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// At least 0 and below 1.
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}
