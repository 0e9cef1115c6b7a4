//! Boxes in 16 bits: the record of a box in the frame of its leaf.

use super::key::value;
use bytemuck::{Pod, Zeroable};

/// The grid of a leaf's records: 65,536 steps an axis over the part of the cell where minima are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Frame {
    /// Twice the corner, as a box has two corners.
    pub(crate) origin: [f32; 8],
    /// Steps a unit of length, twice as well.
    pub(crate) scale: [f32; 8],
}

/// The last step of a frame's grid.
pub(crate) const GRID_MAX: f32 = 65_535.0;

impl Frame {
    /// Of no leaf.
    pub(crate) const NONE: Self = Self { origin: [0.0; 8], scale: [0.0; 8] };

    /// A frame of an origin and of steps a unit of length.
    pub(crate) const fn new(origin: [f32; 3], scale: [f32; 3]) -> Self {
        const fn twice([x, y, z]: [f32; 3]) -> [f32; 8] {
            [x, y, z, x, y, z, 0.0, 0.0]
        }
        Self { origin: twice(origin), scale: twice(scale) }
    }

    /// What [`new`](Self::new) makes it of.
    pub(crate) const fn parts(&self) -> [[f32; 3]; 2] {
        let ([a, b, c, ..], [d, e, f, ..]) = (self.origin, self.scale);
        [[a, b, c], [d, e, f]]
    }

    /// The axis on which it is longest. Any axis is correct to sweep along (errata E16 and E17); along the longest side a box meets
    /// the fewest others.
    pub(crate) const fn longest_axis(&self) -> usize {
        let [x, y, z, ..] = self.scale;
        let (longest, steps) = if y < x { (1, y) } else { (0, x) };
        if z < steps { 2 } else { longest }
    }

    /// Whether it maps coordinates to steps in their order, as sweeps need it: wherever its grid lies then, no pair is lost.
    pub(crate) fn is_sound(&self) -> bool {
        let whole = |numbers: &[f32; 8]| numbers[..3] == numbers[3..6] && numbers[6..] == [0.0; 2];
        let finite = |x: &f32| x.abs() <= f32::MAX;
        whole(&self.origin)
            && whole(&self.scale)
            && self.origin.iter().all(finite)
            && self.scale.iter().all(|x| *x >= 0.0 && finite(x))
    }

    /// The grid over the minima between two corners.
    ///
    /// Any monotone map is conservative: it can make apart boxes touch, which the exact test finds, but never the
    /// other way. Maxima beyond the cell land on the last step, above every minimum, so that no tie comes of it.
    pub(crate) fn over(low: [i32; 3], high: [i32; 3]) -> Self {
        let origin = low.map(value);
        let scale = |k: usize| {
            let (low, high) = (origin[k], value(high[k]));
            // A flat cell still needs a step above zero for the maxima; the floor also keeps denormals out, so
            // that a flush-to-zero mode of the host changes nothing.
            let floor = (low.abs().max(high.abs()) * 1e-6).max(1e-24);
            GRID_MAX / (high - low).max(floor).min(f32::MAX)
        };
        Self::new(origin, [scale(0), scale(1), scale(2)])
    }
}

/// A box in its leaf's frame: 16 bytes, as four fit into a cache line.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Record {
    /// The minimum, then the complemented maximum: with both falling as boxes shrink, one kind of compare
    /// decides all six lanes.
    pub(crate) lanes: [u16; 6],
    /// The slot, and above it marks.
    pub(crate) tag: u32,
}

impl Record {
    /// The bits of a tag that hold the slot.
    pub(crate) const SLOT: u32 = (1 << 27) - 1;
    /// A mark of a member: the box reaches beyond the cell.
    pub(crate) const STRADDLES: u32 = 1 << 28;
    /// The lowest of three marks of a ghost: the minimum lies below the cell's low side on this axis (erratum E9).
    pub(crate) const BELOW: u32 = 1 << 29;
    /// These three: two records that share one are not reported here.
    pub(crate) const MARKS: u32 = 7 * Self::BELOW;

    /// Bounds that everything touches.
    pub(crate) const EVERYTHING: Self = Self { lanes: [0; 6], tag: 0 };
    /// Bounds of nothing.
    pub(crate) const NOTHING: Self = Self { lanes: [u16::MAX; 6], tag: 0 };

    #[inline(always)]
    pub(crate) fn slot(&self) -> u32 {
        self.tag & Self::SLOT
    }

    /// Grows bounds so that they hold another record of the same frame. What touches that, or crosses it, does so with the
    /// bounds: the lower a lane, the more it lets pass.
    #[inline(always)]
    pub(crate) fn include(&mut self, other: &Self) {
        for k in 0..6 {
            self.lanes[k] = self.lanes[k].min(other.lanes[k]);
        }
    }
}
