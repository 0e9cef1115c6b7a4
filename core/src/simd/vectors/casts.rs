//! Where a cast meets nodes and records.

use super::operations::{Half, Halves, ends, places};
use crate::geometry::key::KeyBox;
use crate::geometry::line::{Crossing, Walk};
use crate::geometry::record::Record;
use crate::simd::EIGHT;

/// As [`Simd::enter`](crate::simd::Simd::enter): a node in each half.
#[inline(always)]
pub(super) fn enter<W: Halves>(w: W, walk: &Walk, [a, b]: [&KeyBox; 2], until: f32) -> [f32; 2] {
    let ([a_low, a_high], [b_low, b_high]) = (ends(a), ends(b));
    // The low sides and one more; one, then the high sides.
    let (low, high) = (w.pick(a_low, b_low), w.pick(a_high, b_high));
    let high = w.shuffle(high, w.both(&places([1, 2, 3, 3])));
    let (low, high) = (w.floats(low), w.floats(high));
    let back = w.both(bytemuck::cast_ref(&walk.back));
    let (first, last) = (w.both(bytemuck::cast_ref(&walk.first)), w.both(bytemuck::cast_ref(&walk.last)));
    let (come, leave) = (w.both(bytemuck::cast_ref(&walk.come)), w.both(bytemuck::cast_ref(&walk.leave)));
    let come = w.multiply(w.subtract(w.select(back, high, low), first), come);
    let leave = w.multiply(w.subtract(w.select(back, low, high), last), leave);
    // NaN falls to the second operand.
    let (from, to) = (w.maximum(come, w.splat(0)), w.minimum(leave, w.splat(until.to_bits())));
    // The first lane also takes the second and the third one.
    let (second, third) = (w.both(&places([1; 4])), w.both(&places([2; 4])));
    let from = w.maximum(w.maximum(from, w.shuffle(from, second)), w.shuffle(from, third));
    let to = w.minimum(w.minimum(to, w.shuffle(to, second)), w.shuffle(to, third));
    let met = w.at_most(from, w.add(to, w.splat(Walk::LEAST.to_bits())));
    let from = w.select(met, from, w.splat(f32::NAN.to_bits()));
    let [a, b] = w.split(from);
    [f32::from_bits(w.half().first(a)), f32::from_bits(w.half().first(b))]
}

/// As [`Simd::met`](crate::simd::Simd::met).
#[inline(always)]
pub(super) fn met<W: Halves>(w: W, records: &[Record; EIGHT], crossing: &Crossing) -> ([f32; EIGHT], u32) {
    let order = w.both(&crossing.order);
    let [a, b, c, d] = eight(w, records);
    let (a, b) = (w.shuffle(a, order), w.shuffle(b, order));
    let (c, d) = (w.shuffle(c, order), w.shuffle(d, order));
    // Lanes of two records, then of four: two lanes in each vector.
    let (ab, cd) = (w.zip_first16(a, b), w.zip_first16(c, d));
    let (first, second) = (w.zip_first32(ab, cd), w.zip_last32(ab, cd));
    let third = w.zip_first32(w.zip_last16(a, b), w.zip_last16(c, d));
    let zero = w.splat(0);
    let (mut from, mut to) = (zero, w.splat(crossing.until.to_bits()));
    for (pair, lanes) in [first, second, third].into_iter().enumerate() {
        // A float that has the lane as its lower half; NaN for a lane of zero.
        let upper = w.or(w.equal16(lanes, zero), w.splat(0x4b00_4b00));
        for (k, x) in [(2 * pair, w.zip_first16(lanes, upper)), (2 * pair + 1, w.zip_last16(lanes, upper))] {
            let (scale, offset) =
                (w.splat(crossing.scale[k].to_bits()), w.splat(crossing.offset[k].to_bits()));
            let time = w.add(w.multiply(x, scale), offset);
            // NaN falls to the second operand.
            if k < 3 {
                from = w.maximum(time, from);
            } else {
                to = w.minimum(time, to);
            }
        }
    }
    let from = w.minimum(from, w.splat(Crossing::LATEST.to_bits()));
    let (met, mut times) = (w.at_most(from, to), [[0; 16]; 2]);
    let [first, last] = &mut times;
    w.put(first, last, w.select(met, from, w.splat(f32::NAN.to_bits())));
    (bytemuck::cast(times), w.bits8(met))
}

/// Eight records, of which each half has four consecutive ones.
#[inline(always)]
pub(super) fn eight<W: Halves>(w: W, records: &[Record; EIGHT]) -> [W::Vector; 4] {
    let [a, b, c, d, e, f, g, h]: &[[u8; 16]; EIGHT] = bytemuck::cast_ref(records);
    [w.pick(a, e), w.pick(b, f), w.pick(c, g), w.pick(d, h)]
}
