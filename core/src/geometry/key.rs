//! Boxes as order-preserving integer keys.
//!
//! Every decision compares keys, never floats: integers know no NaN, no -0.0 and no flush-to-zero mode. So
//! the same boxes give the same bytes on any host, and a CPU without FPU compares in one instruction. The
//! mapping is one to one, except that -0.0 becomes 0.0.

use crate::access::note_fault;
use crate::config::TREE;
use bytemuck::{Pod, Zeroable};

/// The key of +infinity, the largest that a box can hold.
pub(crate) const POSITIVE_INFINITY: i32 = 0x7f80_0000;
/// The key of -infinity, the smallest.
pub(crate) const NEGATIVE_INFINITY: i32 = -POSITIVE_INFINITY;

/// The minimum of a disabled box: so many bits less, and beyond infinity.
const CUT: i32 = 10;
const BEYOND: i32 = POSITIVE_INFINITY + 1 + (POSITIVE_INFINITY >> CUT);

/// The key of a float: `key(a) < key(b)` exactly if `a < b`. NaN maps beyond the infinities.
pub(crate) const fn key(x: f32) -> i32 {
    mirrored(x.to_bits() as i32)
}

/// The float of a key.
pub(crate) const fn value(key: i32) -> f32 {
    f32::from_bits(mirrored(key) as u32)
}

/// From sign and magnitude to two's complement, and back: -0.0 and 0.0 are both zero.
const fn mirrored(bits: i32) -> i32 {
    if bits < 0 { i32::MIN.wrapping_sub(bits) } else { bits }
}

/// Lengths below this (2^-100) count as zero. Hosts that flush denormals would compute them differently.
pub(crate) const SHORTEST: f32 = f32::from_bits(27 << 23);

/// Steps of its last motion that a predicted box holds.
pub(crate) const AHEAD: f32 = 7.0;
/// What a predicted box has around it, as a share of the smallest side.
pub(crate) const AROUND: f32 = 0.05;

/// The length from one key to a higher one.
#[inline]
pub(crate) fn length(low: i32, high: i32) -> f32 {
    flushed(value(high) - value(low))
}

fn flushed(length: f32) -> f32 {
    if length < SHORTEST { 0.0 } else { length }
}

/// Whether something holds on all three axes. Written out, since a loop of three costs more than its body
/// where code is compiled for size.
#[inline(always)]
pub(crate) fn on_all_axes(holds: impl Fn(usize) -> bool) -> bool {
    holds(0) && holds(1) && holds(2)
}

/// Four boxes, as vectors take them.
pub(crate) type KeyFour = [KeyBox; 4];

/// A closed box in keys.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct KeyBox {
    pub(crate) min: [i32; 3],
    pub(crate) max: [i32; 3],
}

impl KeyBox {
    /// The box of a slot without an object. It overlaps nothing, not even itself. Also the extent of no corners.
    pub(crate) const EMPTY: Self = Self { min: [i32::MAX; 3], max: [i32::MIN; 3] };

    /// A box around nothing, to be grown by [`include`](Self::include). Its sides are numbers; it overlaps
    /// only unbounded boxes.
    pub(crate) const NOTHING: Self = Self { min: [POSITIVE_INFINITY; 3], max: [NEGATIVE_INFINITY; 3] };

    /// The box that holds all others.
    pub(crate) const ALL: Self = Self { min: [NEGATIVE_INFINITY; 3], max: [POSITIVE_INFINITY; 3] };

    /// The box of a point.
    pub(crate) const fn point(at: [i32; 3]) -> Self {
        Self { min: at, max: at }
    }

    /// The box of a slot, by reference.
    #[inline(always)]
    pub(crate) fn of(boxes: &[Self], slot: usize) -> &Self {
        debug_assert!(slot < boxes.len(), "box {slot} of {}", boxes.len());
        match boxes.get(slot) {
            Some(bounds) => bounds,
            None => {
                note_fault(boxes.as_ptr().addr());
                &Self::EMPTY
            }
        }
    }

    /// The box of a free slot: empty, with a link to the next free slot in a side that no such test reads.
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
        // Compared so that the constants are the infinities, which fit into the compare instruction of a small
        // processor, and maxima first, on all axes. Written out, as closures take it some two instructions more.
        let ([a, b, c], [d, e, f]) = (self.min, self.max);
        let (low, high) = (NEGATIVE_INFINITY, POSITIVE_INFINITY);
        let wrong = d > high || a > d || e > high || b > e || f > high || c > f;
        !(wrong || a < low || b < low || c < low)
    }

    /// Whether all keys are the same. With `==` it would be a call.
    #[inline(always)]
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        on_all_axes(|k| self.min[k] == other.min[k] && self.max[k] == other.max[k])
    }

    /// Whether it is the box of a free slot.
    pub(crate) const fn is_free(&self) -> bool {
        self.min[0] == i32::MAX
    }

    /// The box of an object that becomes disabled: empty, with a minimum beyond infinity. There is no room
    /// for the low bits of that minimum, which come beside.
    pub(crate) const fn disabled(mut self) -> (Self, u16) {
        let low = self.min[0] as u16 & ((1 << CUT) - 1);
        self.min[0] = (self.min[0] >> CUT) + BEYOND;
        (self, low)
    }

    /// The box that was [disabled](Self::disabled), from both.
    pub(crate) const fn enabled(mut self, low: u16) -> Self {
        self.min[0] = self.min[0].wrapping_sub(BEYOND) << CUT | low as i32;
        self
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

    /// Grows the box to hold another one too.
    pub(crate) fn include(&mut self, other: &Self) {
        for k in 0..3 {
            self.min[k] = self.min[k].min(other.min[k]);
            self.max[k] = self.max[k].max(other.max[k]);
        }
    }

    /// Cuts off infinite coordinates, which would make frames too coarse: once for many corners.
    pub(crate) fn make_finite(&mut self) {
        self.min = self.min.map(|low| low.max(key(f32::MIN)));
        self.max = self.max.map(|high| high.min(key(f32::MAX)));
    }

    /// The box grown by a length on all sides (erratum E1). Sides saturate at the largest float. Where
    /// rounding would shrink the box, the old side stays.
    pub(crate) fn grown(&self, length: f32) -> Self {
        Self::predicted(self, self, length, false)
    }

    /// A box that holds a box and, if it goes on as it came from an old one, the next [`AHEAD`], with a
    /// little around it, at least a margin: a share of its smallest side. A motion beyond that predicts
    /// nothing. Or the box grown by its margin, unless it `predicts`.
    #[inline(always)]
    pub(crate) fn predicted(now: &Self, old: &Self, margin: f32, predicts: bool) -> Self {
        let smallest = if predicts { now.smallest_extent() } else { 0.0 };
        let most = if smallest < f32::MAX { smallest } else { 0.0 };
        let around = flushed(margin.max(most * AROUND));
        // Outwards is up: minima come with the other sign.
        let side = |side: i32, old: i32| {
            let (now, step) = (value(side), value(side) - value(old));
            // Only worlds with a tree predict.
            let step = if TREE && step >= SHORTEST && step <= most { step * AHEAD } else { 0.0 };
            let to = now + (step + around);
            // Infinite sides stay, and so does one that rounding would move inwards.
            key(if to < f32::MAX { to } else { f32::MAX }).max(side)
        };
        let low = |k: usize| side(now.min[k].wrapping_neg(), old.min[k].wrapping_neg()).wrapping_neg();
        let high = |k: usize| side(now.max[k], old.max[k]);
        Self { min: [low(0), low(1), low(2)], max: [high(0), high(1), high(2)] }
    }

    /// Where the box has come from, if it went as another one has gone.
    #[inline]
    pub(crate) fn came_from(&self, from: &Self, to: &Self) -> Self {
        let side = |now: i32, from: i32, to: i32| key(value(now) - (value(to) - value(from)));
        let low = |k: usize| side(self.min[k], from.min[k], to.min[k]);
        let high = |k: usize| side(self.max[k], from.max[k], to.max[k]);
        Self { min: [low(0), low(1), low(2)], max: [high(0), high(1), high(2)] }
    }

    /// The smallest side that is not flat, as a flat box has the size of its other sides. The largest float
    /// if there is none.
    #[inline(always)]
    pub(crate) fn smallest_extent(&self) -> f32 {
        let lesser = |least: f32, k: usize| {
            let side = length(self.min[k], self.max[k]);
            // False for NaN.
            if side > 0.0 && side < least { side } else { least }
        };
        // Written out: a loop that is compiled for size has a check of its index.
        lesser(lesser(lesser(f32::MAX, 0), 1), 2)
    }

    /// The largest side; infinite if the box is unbounded.
    pub(crate) fn largest_extent(&self) -> f32 {
        let side = |k: usize| value(self.max[k]) - value(self.min[k]);
        // The length of [inf, inf] is NaN, which is above nothing. Written out for the same reason.
        let larger = |largest: f32, side: f32| if side > largest { side } else { largest };
        flushed(larger(larger(larger(0.0, side(0)), side(1)), side(2)))
    }

    /// Whether `f32` can hardly tell the box's sides apart so far from the origin: a side is shorter than
    /// four steps of the coordinate. Where a side has vanished, the largest one decides.
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

/// Whether `f32` is too coarse for some of `live` boxes, empty ones aside. A point may be meant, or may be a
/// box that has lost its sides far from the origin; `f32` cannot tell neighbours apart there either. So points
/// count only if on no axis the world has four steps for each box of a row, were the boxes to fill a cube.
pub(crate) fn is_coarse<'b>(boxes: impl Iterator<Item = &'b KeyBox>, live: u32) -> bool {
    let (mut extent, mut points) = (KeyBox::EMPTY, false);
    for bounds in boxes.filter(|bounds| !bounds.is_empty()) {
        if bounds.is_coarse() {
            return true;
        }
        points |= bounds.min == bounds.max && bounds.min.iter().any(|key| value(*key).abs() > 1e-20);
        extent.include(&KeyBox::point(bounds.min));
    }
    extent.make_finite();
    let steps = |k: usize| extent.max[k].abs_diff(extent.min[k]);
    let row = u64::from(steps(0).max(steps(1)).max(steps(2)) / 4);
    points && row < 1 << 16 && row.pow(3) + 1 < u64::from(live)
}
