//! The line that a cast moves along, and where it meets a box.

use super::{Cast, key_above, key_below};
use crate::arch::Simd;
use crate::key::{KeyBox, value};

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

    /// A box around everything that the cast passes between two distances.
    #[inline(always)]
    pub(super) fn hull(&self, from: f64, to: f64) -> KeyBox {
        let mut hull = KeyBox::EMPTY;
        for k in 0..3 {
            let (a, b) = (self.direction[k] * from, self.direction[k] * to);
            let (a, b) = if a < b { (a, b) } else { (b, a) };
            // More than what the roundings of the distances and of these sums can come to; nothing moves where there is
            // no direction, however far.
            let slack = (a.abs() + b.abs() + self.low[k].abs() + self.high[k].abs()) * (8.0 * f64::EPSILON);
            let still = self.direction[k] == 0.0;
            let (a, b) = if still { (0.0, 0.0) } else { (a - slack, b + slack) };
            hull.min[k] = key_below(self.low[k] + a);
            hull.max[k] = key_above(self.high[k] + b);
        }
        hull
    }
}
