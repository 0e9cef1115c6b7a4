//! Computes cells and frames from planes, and finds where most objects are.

use super::limits::{FAR, OUTLIERS, SPARSE, SPREAD_SAMPLE};
use super::{Cell, Frame, Nodes, UNSPLIT, axis_of, key_of};
use crate::access::Access;
use crate::geometry::key::{KeyBox, key, length, value};
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;

impl KeyBox {
    /// The part where most minima are, as a sample shows. The extent itself if that is not far smaller.
    pub(crate) fn trimmed(&self, sample: &Sample) -> Self {
        let (low, high) = sample.bounds();
        let mut trimmed = *self;
        for k in 0..3 {
            if low[k] > high[k] {
                continue;
            }
            let most = length(low[k], high[k]);
            if length(self.min[k], self.max[k]) > SPARSE * most {
                // A sample does not see all: it is made as long again on either side.
                trimmed.min[k] = self.min[k].max(key((value(low[k]) - most).max(f32::MIN)));
                trimmed.max[k] = self.max[k].min(key((value(high[k]) + most).min(f32::MAX)));
            }
        }
        trimmed
    }

    /// The part of a cell where minima can be.
    pub(crate) fn clip(&self, cell: &Cell) -> Self {
        let mut part = Self { min: cell.low(), max: cell.high() };
        for k in 0..3 {
            part.min[k] = part.min[k].max(self.min[k]).min(self.max[k]);
            part.max[k] = part.max[k].min(self.max[k]).max(part.min[k]);
        }
        part
    }
}

/// At most so many of `count` numbers, one from each of as many equal parts. Where in its part, multiples of the
/// golden ratio tell: a fixed step would see one column of a grid whose rows are as long.
pub(super) fn evenly(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let step = count.div_ceil(most).max(1);
    let within = move |part: usize| (u64::from((part as u32).wrapping_mul(0x9e37_79b9)) * step as u64) >> 32;
    (0..count)
        .step_by(step)
        .enumerate()
        .map(move |(part, first)| (first + within(part) as usize).min(count - 1))
}

/// A sample of minima: the few least and greatest numbers on each axis.
pub(crate) struct Sample {
    low: [[i32; 3]; OUTLIERS + 1],
    high: [[i32; 3]; OUTLIERS + 1],
    count: usize,
}

impl Sample {
    const NONE: Self =
        Self { low: [[i32::MAX; 3]; OUTLIERS + 1], high: [[i32::MIN; 3]; OUTLIERS + 1], count: 0 };

    /// A sample of `count` minima.
    #[inline(always)]
    pub(crate) fn of(count: usize, minimum: impl Fn(usize) -> Option<[i32; 3]>) -> Self {
        let mut sample = Self::NONE;
        evenly(count, SPREAD_SAMPLE).filter_map(minimum).for_each(|min| sample.include(min));
        sample
    }

    #[inline(always)]
    fn include(&mut self, min: [i32; 3]) {
        self.count += 1;
        let (mut low, mut high) = (min, min);
        for row in &mut self.low {
            for k in 0..3 {
                (row[k], low[k]) = (row[k].min(low[k]), row[k].max(low[k]));
            }
        }
        for row in &mut self.high {
            for k in 0..3 {
                (row[k], high[k]) = (row[k].max(high[k]), row[k].min(high[k]));
            }
        }
    }

    /// The least and the greatest numbers, outliers aside. The least is above the greatest if there are none.
    pub(crate) fn bounds(&self) -> ([i32; 3], [i32; 3]) {
        // In a small sample nothing is an outlier.
        let left_out = (self.count * OUTLIERS / (SPREAD_SAMPLE * 3 / 4)).min(OUTLIERS);
        (self.low[left_out], self.high[left_out])
    }
}

/// The cell of a node. O(depth).
pub(crate) fn cell_of(nodes: Nodes<'_>, mut node: usize) -> Cell {
    let (mut low, mut high) = (Cell::ALL.low(), Cell::ALL.high());
    for _ in 0..nodes.depth(node) {
        let above = nodes.above(node);
        let plane = nodes.splits.at(above).plane;
        let axis = axis_of(plane);
        if node % 2 == 1 {
            low[axis] = low[axis].max(key_of(plane));
        } else {
            high[axis] = high[axis].min(key_of(plane));
        }
        node = above;
    }
    Cell::new(low, high, high)
}

/// Cuts space by the planes into one cell a leaf. O(leaves · depth).
pub(crate) fn cut(nodes: Nodes<'_>, extent: &KeyBox, cells: &mut [Cell], context: StepContext<'_>) {
    context.each(Chunks::new(cells, 1), |leaf, to| {
        let cell = cell_of(nodes, nodes.tops.at(leaf) as usize);
        let (part, mut far) = (extent.clip(&cell), cell.high());
        for k in 0..3 {
            let reach = FAR * length(part.min[k], part.max[k]);
            // Beside a flat cell no box is large.
            far[k] = match far[k] {
                Cell::RIM => Cell::RIM,
                _ if reach <= 0.0 => Cell::RIM,
                high => key((value(high) + reach).min(f32::MAX)) + 1,
            };
        }
        to.fill(Cell::new(cell.low(), cell.high(), far));
    });
}

/// Cuts the first cell by planes of some levels, numbered as in a heap.
pub(crate) fn divide(planes: &[i32], levels: u32, cells: &mut [Cell]) {
    for level in 0..levels {
        // From the back, so that a parent is read before a child overwrites it.
        for index in (0..1usize << level).rev() {
            let parent = cells.at(index);
            let plane = planes.at((1 << level) + index);
            let (mut low, mut high) = (parent.low(), parent.high());
            let axis = axis_of(plane);
            if key_of(plane) == UNSPLIT {
                low = [i32::MAX; 3];
            } else {
                high[axis] = high[axis].min(key_of(plane));
                low[axis] = low[axis].max(key_of(plane));
            }
            cells.put(2 * index, Cell::new(parent.low(), high, parent.far()));
            cells.put(2 * index + 1, Cell::new(low, parent.high(), parent.far()));
        }
    }
}

/// Makes the frame of each leaf, from the bounds of minima. O(leaves).
pub(crate) fn frame(cells: &[Cell], extent: &KeyBox, frames: &mut [Frame]) {
    for (cell, frame) in cells.iter().zip(frames) {
        *frame = Frame::over(&extent.clip(cell));
    }
}
