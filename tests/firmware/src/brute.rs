//! Brute force with the same care as the world: integer keys, computed once a step, bad boxes refused, and nothing else
//! in the inner loop than the compares.

use trisap_core::{Aabb, Boxes, Pair};

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

    /// Whether no minimum is above its maximum, and none is NaN, which is beyond the infinities.
    #[inline(always)]
    fn is_box(&self) -> bool {
        let infinite = key(f32::INFINITY);
        let is_side = |low: i32, high: i32| !infinite <= low && low <= high && high <= infinite;
        let ([a, b, c], [d, e, f]) = (self.min, self.max);
        is_side(a, d) && is_side(b, e) && is_side(c, f)
    }

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
        let Some(Aabb { min: [a, b, c], max: [d, e, f] }) = boxes.get(index) else { continue };
        let new = Keys { min: [key(a), key(b), key(c)], max: [key(d), key(e), key(f)] };
        // One that is refused leaves the last one there.
        if new.is_box() {
            *keys = new;
        }
    }
    test_all(&keys[..keys.len().min(boxes.len())], pairs)
}

/// In a function of its own, so that the inner loop keeps to the registers.
#[inline(never)]
fn test_all(keys: &[Keys], pairs: &mut [Pair<u16>]) -> usize {
    let all = keys.len();
    let mut count = 0;
    let mut keys = keys;
    while let Some((&first, others)) = keys.split_first() {
        let mut rest = others;
        while let Some((other, others)) = rest.split_first() {
            rest = others;
            if first.overlaps(other) {
                if let Some(pair) = pairs.get_mut(count) {
                    *pair = [all - keys.len(), all - 1 - rest.len()].map(|slot| slot as u16);
                }
                count += 1;
            }
        }
        keys = others;
    }
    count
}

/// Events: tells what is new in `pairs` since `last`, both in order, by one walk along both. Writes what fits, and
/// returns how many pairs were found and lost.
#[inline(never)]
pub fn compare(
    last: &[Pair<u16>],
    pairs: &[Pair<u16>],
    found: &mut [Pair<u16>],
    lost: &mut [Pair<u16>],
) -> [usize; 2] {
    let number = |[a, b]: Pair<u16>| u32::from(a) << 16 | u32::from(b);
    let (mut founds, mut losts, mut last) = (0, 0, last);
    for &pair in pairs {
        loop {
            match last.split_first() {
                Some((&before, rest)) if number(before) <= number(pair) => {
                    last = rest;
                    if before == pair {
                        break;
                    }
                    put(lost, &mut losts, before);
                }
                _ => {
                    put(found, &mut founds, pair);
                    break;
                }
            }
        }
    }
    last.iter().for_each(|before| put(lost, &mut losts, *before));
    [founds, losts]
}

#[inline(always)]
fn put(pairs: &mut [Pair<u16>], count: &mut usize, pair: Pair<u16>) {
    if let Some(place) = pairs.get_mut(*count) {
        *place = pair;
    }
    *count += 1;
}
