//! The bounds of minimum corners, and whether `f32` is too coarse for boxes.

use super::key::{KeyBox, key, value};
use bytemuck::{Pod, Zeroable};

/// The bounds of the finite minimum corners in a world, without large objects where these are known.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Extent {
    pub(crate) low: [i32; 3],
    pub(crate) high: [i32; 3],
}

impl Extent {
    pub(crate) const NONE: Self = Self { low: [i32::MAX; 3], high: [i32::MIN; 3] };

    /// Takes in one minimum corner, unbounded or not.
    pub(crate) fn include(&mut self, min: &[i32; 3]) {
        let mut include = |k: usize| {
            self.low[k] = self.low[k].min(min[k]);
            self.high[k] = self.high[k].max(min[k]);
        };
        include(0);
        include(1);
        include(2);
    }

    /// Cuts off infinite coordinates, which would make frames too coarse: once for many corners.
    pub(crate) fn make_finite(&mut self) {
        self.low = self.low.map(|low| low.max(key(f32::MIN)));
        self.high = self.high.map(|high| high.min(key(f32::MAX)));
    }

    pub(crate) fn union(&mut self, other: &Self) {
        for k in 0..3 {
            self.low[k] = self.low[k].min(other.low[k]);
            self.high[k] = self.high[k].max(other.high[k]);
        }
    }
}

/// Whether `f32` is too coarse for some of `live` boxes, empty ones aside. A point may be meant, or may be a
/// box that has lost its sides far from the origin; `f32` cannot tell neighbours apart there either. So points
/// count only if on no axis the world has four steps for each box of a row, were the boxes to fill a cube.
pub(crate) fn is_coarse<'b>(boxes: impl Iterator<Item = &'b KeyBox>, live: u32) -> bool {
    let (mut extent, mut points) = (Extent::NONE, false);
    for bounds in boxes.filter(|bounds| !bounds.is_empty()) {
        if bounds.is_coarse() {
            return true;
        }
        points |= bounds.min == bounds.max && bounds.min.iter().any(|key| value(*key).abs() > 1e-20);
        extent.include(&bounds.min);
    }
    extent.make_finite();
    let steps = |k: usize| extent.high[k].abs_diff(extent.low[k]);
    let row = u64::from(steps(0).max(steps(1)).max(steps(2)) / 4);
    points && row < 1 << 16 && row.pow(3) + 1 < u64::from(live)
}
