//! The line that a cast moves along, and where it meets a box.

use super::Cast;
use crate::access::Access;
use crate::arch::Simd;
use crate::key::{KeyBox, value};
use crate::tree::{Frame, Record, axis_of, key_of};

/// A cast, prepared: a box is met where the point `t * direction` is inside the box's difference from the start. A fourth
/// axis, which nothing moves along, fills the vectors.
pub(crate) struct Line {
    low: [f64; 4],
    high: [f64; 4],
    direction: [f64; 4],
    pub(super) distance: f64,
    pub(crate) slabs: Slabs,
}

/// What it takes to find where a line passes the sides of a box.
pub(crate) struct Slabs {
    /// All ones where the line runs backwards, so that the high side of a box comes first.
    pub(crate) back: [i32; 4],
    /// What is taken from the side that is met first, and from the one that is met last.
    pub(crate) first: [f64; 4],
    pub(crate) last: [f64; 4],
    /// One over the direction; infinite where it is zero.
    pub(crate) inverse: [f64; 4],
}

/// The grid's steps, in one more than which the highest ends.
const GRID_END: f64 = 65_536.0;
/// Bounds how long a cast takes for a step of the grid on an axis that it hardly moves along, as `f32` must hold the product
/// with a number of steps.
const STEEPEST: f64 = (1u128 << 80) as f64;
/// From where on, in steps of the grid, a cast is too far away for these bounds.
const FARTHEST: f64 = (1u64 << 60) as f64;

/// What it takes to find which records of a leaf a cast may touch: when it passes the sides of their boxes is a linear function
/// of their lanes. Times are in steps of the leaf's grid on the axis where they are the most.
///
/// It lets through whatever [`Line::span`] does: sides are moved outwards by more than all roundings together, and a lane of
/// zero, where a side may be anywhere outside the grid, excludes nothing.
pub(crate) struct Crossing {
    /// The bytes of a record's lanes in the order: sides that are met first, sides that are met last.
    pub(crate) order: [u8; 16],
    /// For each lane in that order, when the cast is there: `scale * (BASE + lane) + offset`.
    pub(crate) scale: [f32; 6],
    pub(crate) offset: [f32; 6],
    /// How long the cast is in the leaf.
    pub(crate) length: f32,
}

impl Crossing {
    /// Added to each lane: the least number whose floats are whole numbers, which so have the lane as their low bits.
    pub(crate) const BASE: f64 = (1u32 << 23) as f64;

    /// As [`Simd::crossed`], for one record.
    #[inline(always)]
    pub(crate) fn passes(&self, record: &Record) -> bool {
        let (mut from, mut to) = (0.0, self.length);
        for k in 0..6 {
            let lane = record.lanes.at(self.order[2 * k] as usize / 2);
            let time = self.scale[k] * (Self::BASE as f32 + f32::from(lane)) + self.offset[k];
            // A side that is anywhere, and NaN, exclude nothing.
            if lane != 0 && k < 3 && time > from {
                from = time;
            }
            if lane != 0 && k >= 3 && time < to {
                to = time;
            }
        }
        from <= to
    }
}

/// A cast on its way through the tree, in `f32`: its time is its distance on the axis where it moves most.
///
/// It comes to nodes no later, and leaves them no earlier, than [`Line::span`] says, as the factors take in more than all
/// roundings.
pub(crate) struct Walk {
    /// As in [`Slabs`].
    pub(crate) back: [i32; 4],
    pub(crate) first: [f32; 4],
    pub(crate) last: [f32; 4],
    /// What distances from the sides are multiplied with.
    pub(crate) come: [f32; 4],
    pub(crate) leave: [f32; 4],
    /// Time in one unit of distance.
    speed: f64,
}

impl Walk {
    /// More than what a few roundings in `f32` can come to.
    const SLACK: f64 = 1.0 / (1u32 << 20) as f64;
    /// Added to the time of leaving, for numbers so small that their factors do nothing.
    pub(crate) const LEAST: f32 = f32::from_bits(27 << 23);

    pub(super) fn new(line: &Line) -> Self {
        let Slabs { back, first, last, inverse } = line.slabs;
        let most = line.direction.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
        let speed = if most > 0.0 { most } else { 1.0 };
        let factor = inverse.map(|inverse| inverse * speed);
        let greatest = f64::from(f32::MAX);
        let mut last = last.map(|side| side as f32);
        // Nothing is left on the axis that does not count.
        last[3] = f32::MIN;
        Self {
            back,
            first: first.map(|side| side as f32),
            last,
            come: factor.map(|factor| (factor * (1.0 - Self::SLACK)).clamp(-greatest, greatest) as f32),
            // Infinite where it is too large: what is not left yet is never left.
            leave: factor.map(|factor| (factor * (1.0 + Self::SLACK)) as f32),
            speed,
        }
    }

    /// A time that is not before a distance.
    pub(super) fn time(&self, distance: f64) -> f32 {
        (distance * self.speed * (1.0 + Self::SLACK)) as f32 + Self::LEAST
    }

    /// A distance that is not beyond a time.
    pub(super) fn distance(&self, time: f32) -> f64 {
        f64::from(time) / self.speed * (1.0 - Self::SLACK)
    }

    /// As [`Simd::enter`].
    #[inline(always)]
    pub(crate) fn enter(
        &self,
        low: [f32; 4],
        plane: i32,
        reaches: &KeyBox,
        until: f32,
    ) -> ([f32; 2], [f32; 4]) {
        let mut above = low;
        let (axis, key) = (axis_of(plane), value(key_of(plane)));
        above[axis] = if key > above[axis] { key } else { above[axis] };
        let child = |low: &[f32; 4], reach: &[i32; 3]| {
            let (mut from, mut to) = (0.0, until);
            for k in 0..3 {
                let (low, high) = (low[k], value(reach[k]));
                let (entry, exit) = if self.back[k] != 0 { (high, low) } else { (low, high) };
                let come = (entry - self.first[k]) * self.come[k];
                let leave = (exit - self.last[k]) * self.leave[k];
                from = if come > from { come } else { from };
                to = if leave < to { leave } else { to };
            }
            if from <= to + Self::LEAST && reach[0] != i32::MIN { from } else { f32::NAN }
        };
        ([child(&low, &reaches.min), child(&above, &reaches.max)], above)
    }
}

impl Slabs {
    /// As [`Simd::span`].
    #[inline(always)]
    pub(crate) fn span(&self, min: [i32; 4], max: [i32; 4], far: f64) -> (f64, f64) {
        let (mut from, mut to) = (0.0, far);
        for k in 0..3 {
            let (low, high) = (f64::from(value(min[k])), f64::from(value(max[k])));
            let (low, high) = if self.back[k] != 0 { (high, low) } else { (low, high) };
            let (first, last) =
                ((low - self.first[k]) * self.inverse[k], (high - self.last[k]) * self.inverse[k]);
            // A side that the line runs along gives NaN, which these pass over.
            from = if first > from { first } else { from };
            to = if last < to { last } else { to };
        }
        (from, to)
    }
}

impl Line {
    pub(super) fn new(cast: &Cast) -> Self {
        let four = |[x, y, z]: [f32; 3]| [x, y, z, 0.0].map(f64::from);
        let (low, high, direction) = (four(cast.start.min), four(cast.start.max), four(cast.direction));
        let inverse = direction.map(|d| if d == 0.0 { f64::INFINITY } else { 1.0 / d });
        let (mut first, mut last) = (high, low);
        for k in 0..3 {
            if direction[k] < 0.0 {
                (first[k], last[k]) = (low[k], high[k]);
            }
        }
        let back = direction.map(|d| -i32::from(d < 0.0));
        let slabs = Slabs { back, first, last, inverse };
        // Finite: beyond it is where a line along which nothing moves would meet the boxes beside it.
        let distance = f64::from(cast.distance).min(f64::MAX);
        Self { low, high, direction, distance, slabs }
    }

    /// Between which distances up to `far` the cast touches a box; where it does not, the first one is above the second. Each
    /// number rises with the box's sides, so a larger box is met no later and left no earlier.
    #[inline(always)]
    pub(super) fn span<S: Simd>(&self, simd: S, min: &[i32; 3], max: &[i32; 3], far: f64) -> (f64, f64) {
        let four = |[x, y, z]: [i32; 3]| [x, y, z, 0];
        simd.span(&self.slabs, four(*min), four(*max), far)
    }

    /// What it takes to find the members of a leaf that the cast may touch from one distance to another.
    #[inline(always)]
    pub(super) fn crossing(&self, frame: &Frame, from: f64, to: f64) -> Crossing {
        let [x, y, z, ..] = frame.scale;
        let scale = [x, y, z].map(f64::from);
        // Steps of the grid in one unit of distance, on the axis where they are the most.
        let speed = (0..3).fold(f64::MIN_POSITIVE, |most, k| most.max((self.direction[k] * scale[k]).abs()));
        let mut crossing = Crossing { order: [0; 16], scale: [0.0; 6], offset: [0.0; 6], length: 0.0 };
        let mut near = true;
        for k in 0..3 {
            let (low, high) = (self.low[k], self.high[k]);
            let (way, origin) = (self.direction[k] * from, f64::from(frame.origin[k]));
            // Where the start of the cast is on the grid at the first distance.
            let (first, last) = ((low + way - origin) * scale[k], (high + way - origin) * scale[k]);
            near &= first.abs().max(last.abs()) < FARTHEST;
            let back = self.slabs.back[k] != 0;
            let steep = (speed * self.slabs.inverse[k] / scale[k]).clamp(-STEEPEST, STEEPEST);
            // More than what the grid's steps and the roundings in `f32` here and in `f64` there can come to.
            let spread = low.abs() + high.abs() + origin.abs();
            let slack = 8.0
                + (GRID_END + first.abs() + last.abs()) * f64::from(4.0 * f32::EPSILON)
                + spread * scale[k] * (8.0 * f64::EPSILON);
            let (low, high) = ((0, steep, -last - slack), (3, -steep, first - slack - GRID_END));
            let (entry, exit) = if back { (high, low) } else { (low, high) };
            // Not by index: the compiler loses sight of the lanes.
            for (lane, (of, factor, shift)) in [(k, entry), (k + 3, exit)] {
                let byte = 2 * (k + of) as u8;
                crossing.order.put(2 * lane, byte);
                crossing.order.put(2 * lane + 1, byte + 1);
                crossing.scale.put(lane, factor as f32);
                crossing.offset.put(lane, ((shift - Crossing::BASE) * factor) as f32);
            }
        }
        if !near {
            // Not a number: excludes nothing.
            crossing.offset = [f32::NAN; 6];
        }
        crossing.length = ((to - from) * speed * (1.0 + 1e-6) + 1.0) as f32;
        crossing
    }
}
