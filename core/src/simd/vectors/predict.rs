//! Predicted boxes.

use super::operations::{Half, Halves, Vectors, places};
use crate::geometry::key::{AHEAD, AROUND, KeyBox, SHORTEST};

/// Lengths, but those that are too short to be one are zero, and NaN.
#[inline(always)]
fn flushed<W: Halves>(w: W, lengths: W::Vector) -> W::Vector {
    w.and(lengths, w.at_most(w.splat(SHORTEST.to_bits()), lengths))
}

/// See [`KeyBox::predicted`]. The minima are in the first half, the maxima in the last one.
#[inline(always)]
pub(super) fn predict<W: Halves>(w: W, old: &KeyBox, bounds: &KeyBox, margin: f32) -> KeyBox {
    let (sides, old) = (w.halved(w.sides(bounds)), w.halved(w.sides(old)));
    let (now, old) = (w.floats(sides), w.floats(old));
    let (zero, magnitude) = (w.splat(0), w.splat(i32::MAX as u32));
    // The greatest number, and the one below.
    let (most, less) = (w.splat(f32::MAX.to_bits()), w.splat(f32::MAX.to_bits() - 1));
    // Only what is above zero and finite; so not NaN.
    let side = w.and(w.subtract(now, w.swap(now)), magnitude);
    let counts = w.and(w.at_most(w.splat(SHORTEST.to_bits()), side), w.at_most(side, less));
    let side = w.select(counts, side, most);
    let (second, third) = (w.both(&places([1, 2, 0, 3])), w.both(&places([2, 0, 1, 3])));
    let smallest = w.minimum(side, w.minimum(w.shuffle(side, second), w.shuffle(side, third)));
    let size = w.and(smallest, w.at_most(smallest, less));
    let around = w.maximum(w.multiply(size, w.splat(AROUND.to_bits())), w.splat(margin.to_bits()));
    let around = flushed(w, around);
    let step = w.subtract(now, old);
    let far = w.and(step, magnitude);
    let counts = w.and(w.at_most(w.splat(SHORTEST.to_bits()), far), w.at_most(far, size));
    let reach = w.and(w.multiply(step, w.splat(AHEAD.to_bits())), counts);
    let down = w.subtract(w.minimum(reach, zero), around);
    let up = w.add(w.maximum(reach, zero), around);
    let by = w.first_and_last(down, up);
    let to = w.add(now, by);
    let to = w.first_and_last(w.maximum(to, w.splat(f32::MIN.to_bits())), w.minimum(to, most));
    // Infinite sides stay, and so does one that rounding would move inwards.
    let to = w.keys(to);
    let to = w.first_and_last(w.lower32(to, sides), w.upper32(to, sides));
    let [first, last] = w.split(w.select(w.equal32(by, zero), sides, to));
    let (h, mut bytes) = (w.half(), [0; 24]);
    // There are as many.
    if let Some(bytes) = bytes.first_chunk_mut() {
        h.store(bytes, first);
    }
    if let Some(bytes) = bytes.last_chunk_mut() {
        h.store(bytes, h.fourth_on(h.shuffle(first, h.load(&places([2; 4]))), last));
    }
    bytemuck::cast(bytes)
}
