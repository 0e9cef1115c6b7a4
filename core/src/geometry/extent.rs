//! Bounds of minimum corners.

use super::key::key;

/// The bounds of the finite minimum corners in a world, large objects left out where these are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Extent {
    pub(crate) low: [i32; 3],
    pub(crate) high: [i32; 3],
}

impl Extent {
    pub(crate) const NONE: Self = Self { low: [i32::MAX; 3], high: [i32::MIN; 3] };

    /// The least and the most that coordinates of a frame can be.
    pub(crate) const FINITE: Self = Self { low: [key(f32::MIN); 3], high: [key(f32::MAX); 3] };

    /// Takes in one minimum corner, unbounded or not.
    #[inline(always)]
    pub(crate) fn include(&mut self, min: &[i32; 3]) {
        let mut include = |k: usize| {
            self.low[k] = self.low[k].min(min[k]);
            self.high[k] = self.high[k].max(min[k]);
        };
        include(0);
        include(1);
        include(2);
    }

    /// Without unbounded coordinates, which would only blur the frames: once for many corners.
    pub(crate) fn make_finite(&mut self) {
        for k in 0..3 {
            self.low[k] = self.low[k].max(Self::FINITE.low[k]);
            self.high[k] = self.high[k].min(Self::FINITE.high[k]);
        }
    }

    pub(crate) fn union(&mut self, other: &Self) {
        for k in 0..3 {
            self.low[k] = self.low[k].min(other.low[k]);
            self.high[k] = self.high[k].max(other.high[k]);
        }
    }
}
