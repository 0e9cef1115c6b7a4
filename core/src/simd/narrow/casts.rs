//! Where a cast meets nodes and records, in 128-bit vectors.

use super::keys::Keys;
use super::vectors::Vectors;
use crate::geometry::key::KeyBox;
use crate::geometry::line::{Crossing, Walk};
use crate::geometry::record::Record;
use crate::simd::EIGHT;

/// As [`Simd::enter`](crate::simd::Simd::enter), for one node.
#[inline(always)]
pub(super) fn enter<V: Vectors>(v: V, walk: &Walk, node: &KeyBox, until: f32) -> f32 {
    let keys = Keys::load(v, node);
    let (low, high) = (v.floats(keys.first), v.floats(keys.maxima(v)));
    let back = v.load(bytemuck::cast_ref(&walk.back));
    let (first, last) = (v.load(bytemuck::cast_ref(&walk.first)), v.load(bytemuck::cast_ref(&walk.last)));
    let (come, leave) = (v.load(bytemuck::cast_ref(&walk.come)), v.load(bytemuck::cast_ref(&walk.leave)));
    let come = v.multiply(v.subtract(v.select(back, high, low), first), come);
    let leave = v.multiply(v.subtract(v.select(back, low, high), last), leave);
    // NaN falls to the second operand.
    let (from, to) = (v.maximum(come, v.splat(0)), v.minimum(leave, v.splat(until.to_bits())));
    // The first lane also takes the second and the third one.
    let (second, third) = (v.splat(0x0706_0504), v.splat(0x0b0a_0908));
    let from = v.maximum(v.maximum(from, v.shuffle(from, second)), v.shuffle(from, third));
    let to = v.minimum(v.minimum(to, v.shuffle(to, second)), v.shuffle(to, third));
    let (from, to) = (f32::from_bits(v.first(from)), f32::from_bits(v.first(to)));
    if from <= to + Walk::LEAST { from } else { f32::NAN }
}

/// When a cast enters eight records, and masks of those that it may touch.
#[inline(always)]
pub(super) fn met<V: Vectors>(
    v: V,
    records: &[Record; EIGHT],
    crossing: &Crossing,
) -> ([V::Vector; 2], [V::Vector; 2]) {
    let zero = v.splat(0);
    let (mut from, mut to) = ([zero; 2], [v.splat(crossing.until.to_bits()); 2]);
    for (k, lanes) in transposed(v, records, &crossing.order).into_iter().enumerate() {
        // A float that has the lane as its lower half; NaN for a lane of zero.
        let upper = v.or(v.equal16(lanes, zero), v.splat(0x4b00_4b00));
        let (scale, offset) = (v.splat(crossing.scale[k].to_bits()), v.splat(crossing.offset[k].to_bits()));
        let first = v.add(v.multiply(v.zip_first16(lanes, upper), scale), offset);
        let last = v.add(v.multiply(v.zip_last16(lanes, upper), scale), offset);
        // NaN falls to the second operand.
        if k < 3 {
            from = [v.maximum(first, from[0]), v.maximum(last, from[1])];
        } else {
            to = [v.minimum(first, to[0]), v.minimum(last, to[1])];
        }
    }
    let latest = v.splat(Crossing::LATEST.to_bits());
    let from = [v.minimum(from[0], latest), v.minimum(from[1], latest)];
    (from, [v.at_most(from[0], to[0]), v.at_most(from[1], to[1])])
}

/// Six lanes of eight records in an order: a vector for each lane.
#[inline(always)]
fn transposed<V: Vectors>(v: V, records: &[Record; EIGHT], order: &[u8; 16]) -> [V::Vector; 6] {
    let order = v.load(order);
    let mut ordered = [order; EIGHT];
    for (place, record) in ordered.iter_mut().zip(records) {
        *place = v.shuffle(v.load(bytemuck::cast_ref(record)), order);
    }
    let [a, b, c, d, e, f, g, h] = ordered;
    // Four lanes of two records, two lanes of four records, one lane of all.
    let (ab, cd) = (v.zip_first16(a, b), v.zip_first16(c, d));
    let (ef, gh) = (v.zip_first16(e, f), v.zip_first16(g, h));
    let (xy, xy_after) = (v.zip_first32(ab, cd), v.zip_first32(ef, gh));
    let (zx, zx_after) = (v.zip_last32(ab, cd), v.zip_last32(ef, gh));
    let yz = v.zip_first32(v.zip_last16(a, b), v.zip_last16(c, d));
    let yz_after = v.zip_first32(v.zip_last16(e, f), v.zip_last16(g, h));
    [
        v.zip_first64(xy, xy_after),
        v.zip_last64(xy, xy_after),
        v.zip_first64(zx, zx_after),
        v.zip_last64(zx, zx_after),
        v.zip_first64(yz, yz_after),
        v.zip_last64(yz, yz_after),
    ]
}
