//! Brute force with the same care as the world: integer keys, computed once a step, and nothing else in the inner
//! loop than the compares.

use trisap_core::{Boxes, Pair};

/// A box in keys.
#[derive(Clone, Copy)]
pub struct Keys {
    min: [i32; 3],
    max: [i32; 3],
}

/// Like the float's order, but for -0.0, which comes before 0.0: no recording has it.
fn key(value: f32) -> i32 {
    let bits = value.to_bits() as i32;
    bits ^ (((bits >> 31) as u32) >> 1) as i32
}

impl Keys {
    /// No box yet.
    pub const NONE: Self = Self { min: [0; 3], max: [0; 3] };

    #[inline(always)]
    fn overlaps(&self, other: &Self) -> bool {
        self.min[0] <= other.max[0]
            && other.min[0] <= self.max[0]
            && self.min[1] <= other.max[1]
            && other.min[1] <= self.max[1]
            && self.min[2] <= other.max[2]
            && other.min[2] <= self.max[2]
    }
}

/// Tests every two boxes. Writes the overlapping pairs that fit and returns how many there are. `keys` has room for all
/// boxes.
pub fn force(boxes: Boxes<'_>, keys: &mut [Keys], pairs: &mut [Pair<u16>]) -> usize {
    for (index, keys) in keys.iter_mut().enumerate() {
        let Some(aabb) = boxes.get(index) else { continue };
        *keys = Keys { min: aabb.min.map(key), max: aabb.max.map(key) };
    }
    let mut count = 0;
    let mut rest = &keys[..keys.len().min(boxes.len())];
    let mut a = 0;
    while let Some((first, others)) = rest.split_first() {
        for (b, other) in (a + 1..).zip(others) {
            if first.overlaps(other) {
                if let Some(pair) = pairs.get_mut(count) {
                    *pair = [a, b];
                }
                count += 1;
            }
        }
        rest = others;
        a += 1;
    }
    count
}
