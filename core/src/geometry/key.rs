//! Boxes as order-preserving integer keys.
//!
//! Every decision compares keys, never floats: integers know no NaN, no -0.0 and no flush-to-zero mode, so the
//! same boxes give the same bytes on any host, and a CPU without FPU compares in one instruction. The mapping is
//! one to one, but for -0.0, which becomes 0.0 on the way in.

use crate::access::note_fault;
use bytemuck::{Pod, Zeroable};

/// The key of +infinity, the largest that a box can hold.
pub(crate) const POSITIVE_INFINITY: i32 = 0x7f80_0000;
/// The key of -infinity, the smallest.
pub(crate) const NEGATIVE_INFINITY: i32 = -POSITIVE_INFINITY;

/// The key of a float: `key(a) < key(b)` exactly if `a < b`. NaN maps beyond the infinities.
#[inline(always)]
pub(crate) const fn key(x: f32) -> i32 {
    mirrored(x.to_bits() as i32)
}

/// The float of a key.
#[inline(always)]
pub(crate) const fn value(key: i32) -> f32 {
    f32::from_bits(mirrored(key) as u32)
}

/// From sign and magnitude to two's complement, and back: -0.0 and 0.0 are both zero.
#[inline(always)]
const fn mirrored(bits: i32) -> i32 {
    if bits < 0 { i32::MIN.wrapping_sub(bits) } else { bits }
}

/// Lengths below this (2^-100) count as zero: so near to the denormals, hosts that flush them to zero would compute
/// another number.
pub(crate) const SHORTEST: f32 = f32::from_bits(27 << 23);

/// The length from one key to a higher one.
#[inline]
pub(crate) fn length(low: i32, high: i32) -> f32 {
    flushed(value(high) - value(low))
}

#[inline(always)]
fn flushed(length: f32) -> f32 {
    if length < SHORTEST { 0.0 } else { length }
}

/// Whether something holds of all three axes. Written out, since a loop of three costs more than its body where code
/// is made small.
#[inline(always)]
pub(crate) fn on_all_axes(holds: impl Fn(usize) -> bool) -> bool {
    holds(0) && holds(1) && holds(2)
}

/// A closed box in keys.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct KeyBox {
    pub(crate) min: [i32; 3],
    pub(crate) max: [i32; 3],
}

impl KeyBox {
    /// Overlaps nothing, not even itself: the box of a slot without an object.
    pub(crate) const EMPTY: Self = Self { min: [i32::MAX; 3], max: [i32::MIN; 3] };

    /// A box around nothing, whose sides are numbers: it only overlaps what is unbounded.
    pub(crate) const NOTHING: Self = Self { min: [POSITIVE_INFINITY; 3], max: [NEGATIVE_INFINITY; 3] };

    /// The box of one point.
    pub(crate) const fn at(corner: [i32; 3]) -> Self {
        Self { min: corner, max: corner }
    }

    /// The box at a slot, without a copy.
    #[inline(always)]
    pub(crate) fn of(boxes: &[Self], slot: usize) -> &Self {
        debug_assert!(slot < boxes.len(), "box {slot} of {}", boxes.len());
        match boxes.get(slot) {
            Some(bounds) => bounds,
            None => {
                note_fault();
                &Self::EMPTY
            }
        }
    }

    /// The box of a free slot: as empty, with a link to another slot where it does no harm.
    pub(crate) const fn free(next: u32) -> Self {
        let mut keys = Self::EMPTY;
        keys.min[1] = next as i32;
        keys
    }

    /// The link of a free slot.
    pub(crate) const fn next_free(&self) -> u32 {
        self.min[1] as u32
    }

    /// Whether these are the keys of a box.
    #[inline(always)]
    pub(crate) fn is_valid(&self) -> bool {
        // The infinities are constants that a small processor's compare can hold, if it asks for more or less than them.
        let wrong = |k: usize| {
            self.min[k] > self.max[k] || self.min[k] < NEGATIVE_INFINITY || self.max[k] > POSITIVE_INFINITY
        };
        !(wrong(0) || wrong(1) || wrong(2))
    }

    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.min[0] > self.max[0]
    }

    #[inline(always)]
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        on_all_axes(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }

    /// Containment on all three axes (errata E3 and E4).
    #[inline(always)]
    pub(crate) fn contains(&self, inner: &Self) -> bool {
        on_all_axes(|k| self.min[k] <= inner.min[k] && inner.max[k] <= self.max[k])
    }

    /// Grows it to hold another box as well.
    #[inline(always)]
    pub(crate) fn include(&mut self, other: &Self) {
        for k in 0..3 {
            self.min[k] = self.min[k].min(other.min[k]);
            self.max[k] = self.max[k].max(other.max[k]);
        }
    }

    /// The box grown by a length on all sides (erratum E1): two single-rounded operations an axis that saturate
    /// at the largest float. Where rounding would shrink it, the tight side stays.
    pub(crate) fn grown(&self, length: f32) -> Self {
        let mut fat = *self;
        if length < SHORTEST {
            return fat;
        }
        for k in 0..3 {
            let low = value(self.min[k]) - length;
            let high = value(self.max[k]) + length;
            fat.min[k] = key(low.max(f32::MIN)).min(self.min[k]);
            fat.max[k] = key(high.min(f32::MAX)).max(self.max[k]);
        }
        fat
    }

    /// Whether this fat box is much larger than one that is anchored at the box inside would be: on some side it is
    /// farther away than four margins and half of the box. It is never farther than two margins from a box of the size
    /// that it was anchored at, and rounding at most doubles a margin.
    pub(crate) fn dwarfs(&self, inner: &Self, margin: f32) -> bool {
        let fat = bytemuck::cast::<KeyBox, [i32; 6]>(*self).map(value);
        let inner = bytemuck::cast::<KeyBox, [i32; 6]>(*inner).map(value);
        let mut dwarfs = false;
        for k in 0..6 {
            let near = 4.0 * margin + 0.5 * flushed(inner[k % 3 + 3] - inner[k % 3]);
            // Not so of NaN, which is between infinities.
            dwarfs |= flushed((inner[k] - fat[k]).abs()) > near;
        }
        dwarfs
    }

    /// The largest extent as a length, infinite where the box is unbounded.
    pub(crate) fn largest_extent(&self) -> f32 {
        let extent = |k: usize| length(self.min[k], self.max[k]);
        // The box [inf, inf] has no extent that arithmetic could tell; `max` passes over its NaN.
        extent(0).max(extent(1)).max(extent(2)).max(0.0)
    }

    /// Whether a side is below four steps of its coordinate: only such a box can be coarse.
    #[inline(always)]
    pub(crate) fn is_narrow(&self) -> bool {
        !on_all_axes(|k| self.max[k].wrapping_sub(self.min[k]) as u32 >= 4)
    }

    /// Whether the box has no side, and is not at the origin.
    pub(crate) fn is_distant_point(&self) -> bool {
        self.min == self.max && !on_all_axes(|k| value(self.min[k]).abs() <= 1e-20)
    }

    /// Whether `f32` can hardly tell the box's sides apart at its distance from the origin: a side, or, where a side
    /// has vanished, the largest one, is below four steps of the coordinate.
    pub(crate) fn is_coarse(&self) -> bool {
        let largest = self.largest_extent();
        (0..3).any(|k| {
            let (low, high) = (self.min[k], self.max[k]);
            let bounded = high < POSITIVE_INFINITY && low > NEGATIVE_INFINITY;
            let near_zero = low < 0 && high >= 0;
            let distance = value(low).abs();
            let vanished = distance > 1e-20 && largest > 0.0 && largest < distance * (4.0 * f32::EPSILON);
            bounded && !near_zero && if low == high { vanished } else { high.wrapping_sub(low) < 4 }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::aabb::Aabb;

    #[test]
    fn keys_keep_the_order_of_floats() {
        let ordered = [
            f32::NEG_INFINITY,
            f32::MIN,
            -1.0,
            -f32::MIN_POSITIVE,
            -f32::from_bits(1),
            0.0,
            f32::from_bits(1),
            f32::MIN_POSITIVE,
            1.0,
            f32::MAX,
            f32::INFINITY,
        ];
        for pair in ordered.windows(2) {
            assert!(key(pair[0]) < key(pair[1]), "{pair:?}");
        }
        for x in ordered {
            assert_eq!(value(key(x)).to_bits(), x.to_bits());
        }
        assert_eq!(key(-0.0), key(0.0));
        assert_eq!(key(f32::INFINITY), POSITIVE_INFINITY);
        assert_eq!(key(f32::NEG_INFINITY), NEGATIVE_INFINITY);
    }

    #[test]
    fn keys_are_the_order_of_all_floats() {
        // From one infinity to the other, a block at a time: each float is below the next, and stands at its key. Where other
        // processors are emulated, some blocks are enough: the machine code differs, not the rule.
        let blocks = (NEGATIVE_INFINITY..POSITIVE_INFINITY).step_by(1 << 16);
        for block in blocks.step_by(if cfg!(target_arch = "x86_64") { 1 } else { 61 }) {
            let stands = |k: i32| value(k) < value(k.wrapping_add(1)) && key(value(k)) == k;
            let right = (block..block + (1 << 16)).fold(true, |right, k| right & stands(k));
            assert!(right, "between {:?} and the next 65,536 floats", value(block));
        }
        // Beyond them is what is no number.
        for bits in (0x7f80_0001..=0x7fff_ffff_u32).step_by(if cfg!(target_arch = "x86_64") { 1 } else { 61 })
        {
            assert!(key(f32::from_bits(bits)) > POSITIVE_INFINITY);
            assert!(key(f32::from_bits(bits | 1 << 31)) < NEGATIVE_INFINITY);
        }
    }

    #[test]
    fn nan_of_either_sign_is_refused() {
        for nan in [f32::NAN, -f32::NAN] {
            for k in 0..3 {
                let mut aabb = Aabb::new([0.0; 3], [1.0; 3]);
                aabb.min[k] = nan;
                assert_eq!(KeyBox::from_aabb(&aabb), None);
                let mut aabb = Aabb::new([0.0; 3], [1.0; 3]);
                aabb.max[k] = nan;
                assert_eq!(KeyBox::from_aabb(&aabb), None);
            }
        }
    }

    #[test]
    fn growth_saturates_and_never_shrinks() {
        let wide = KeyBox::from_aabb(&Aabb::new([f32::MIN; 3], [f32::MAX; 3])).unwrap();
        assert_eq!(wide.grown(1e38), wide);
        let far = KeyBox::from_aabb(&Aabb::new([1e9; 3], [1e9; 3])).unwrap();
        assert_eq!(far.grown(0.01), far, "a margin below one ulp changes nothing");
        let unbounded = KeyBox::from_aabb(&Aabb::new([f32::NEG_INFINITY; 3], [0.0; 3])).unwrap();
        assert!(unbounded.grown(1.0).contains(&unbounded));
    }
}
