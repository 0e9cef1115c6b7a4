//! Records: boxes in 16 bits a side, on the grid of their leaf (paper, section IV).

use super::aabb::{Aabb, narrowed, widened};
use super::key::{KeyBox, value};
use bytemuck::{Pod, Zeroable};

/// The grid of a leaf: 65,536 steps an axis over the part of its cell where minima are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Frame {
    /// The low corner, twice, as a box has two corners.
    pub(crate) origin: [f32; 8],
    /// Steps a unit of length, twice too.
    pub(crate) scale: [f32; 8],
}

/// The last step of a frame's grid.
pub(crate) const GRID_MAX: f32 = 65_535.0;

impl Frame {
    /// Of no leaf.
    pub(crate) const NONE: Self = Self { origin: [0.0; 8], scale: [0.0; 8] };

    /// The longest axis. Any axis is right to sweep along (errata E16 and E17); along the longest one a box
    /// meets the fewest others.
    pub(crate) const fn longest_axis(&self) -> usize {
        let [x, y, z, ..] = self.scale;
        let (longest, steps) = if y < x { (1, y) } else { (0, x) };
        if z < steps { 2 } else { longest }
    }

    /// The grid over the minima in a box.
    ///
    /// Any monotone map is conservative. It can make boxes touch that are apart, which the exact test finds,
    /// but it never makes boxes apart that touch. Maxima beyond the cell get the last step, above every
    /// minimum, so they tie with nothing.
    pub(crate) fn over(bounds: &KeyBox) -> Self {
        let origin = bounds.min.map(value);
        let scale = |k: usize| {
            let (low, high) = (origin[k], value(bounds.max[k]));
            // A flat cell still needs a step above zero for the maxima. The floor also keeps denormals out,
            // so a flush-to-zero mode of the host changes nothing.
            let floor = (low.abs().max(high.abs()) * 1e-6).max(1e-24);
            GRID_MAX / (high - low).max(floor).min(f32::MAX)
        };
        let twice = |[x, y, z]: [f32; 3]| [x, y, z, x, y, z, 0.0, 0.0];
        Self { origin: twice(origin), scale: twice([scale(0), scale(1), scale(2)]) }
    }

    /// The part of a box that holds whatever has its record within `bounds`. Steps are rounded, so one more
    /// on each side; the first and the last one also hold what is beyond the grid.
    pub(crate) fn part(&self, of: &Aabb, bounds: &Record) -> Aabb {
        let mut part = *of;
        for k in 0..3 {
            // Taken out first: a closure that is a call would check the index.
            let (origin, scale) = (widened(self.origin[k]), widened(self.scale[k]));
            let at = |steps: f64| origin + steps / scale;
            let (low, high) = (bounds.lanes[k], !bounds.lanes[3 + k]);
            if low > 0 {
                part.min[k] = part.min[k].max(narrowed(at(f64::from(low) - 1.0)));
            }
            if high < u16::MAX {
                part.max[k] = part.max[k].min(-narrowed(-at(f64::from(high) + 2.0)));
            }
        }
        part
    }
}

/// A box in the frame of its leaf: 16 bytes, four in a cache line.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Record {
    /// The minimum, then the complemented maximum. Both fall as boxes grow, so one kind of compare decides
    /// all six lanes.
    pub(crate) lanes: [u16; 6],
    /// The slot, and marks above it. Of bounds: what the filters of the members [offer](crate::filter::offer).
    pub(crate) tag: u32,
}

impl Record {
    /// The bits of a tag that hold the slot.
    pub(crate) const SLOT: u32 = (1 << 27) - 1;
    /// The mark of what a member that left has left behind, while others move in.
    pub(crate) const HOLE: u32 = 1 << 27;
    /// A mark of a member: the box reaches beyond the cell.
    pub(crate) const STRADDLES: u32 = 1 << 28;
    /// The lowest of three marks of a ghost, one an axis: the minimum is below the cell (erratum E9).
    pub(crate) const BELOW: u32 = 1 << 29;
    /// These three. Two records that share one are reported in another leaf.
    pub(crate) const MARKS: u32 = 7 * Self::BELOW;

    /// Bounds that everything touches.
    pub(crate) const EVERYTHING: Self = Self { lanes: [0; 6], tag: u32::MAX };
    /// Bounds of nothing.
    pub(crate) const NOTHING: Self = Self { lanes: [u16::MAX; 6], tag: 0 };

    pub(crate) fn slot(&self) -> u32 {
        self.tag & Self::SLOT
    }

    /// Grows bounds to hold another record of the same frame. Whatever touches or crosses that record also
    /// touches or crosses the bounds, since a lower lane excludes less.
    pub(crate) fn include(&mut self, other: &Self) {
        for k in 0..6 {
            self.lanes[k] = self.lanes[k].min(other.lanes[k]);
        }
    }
}
