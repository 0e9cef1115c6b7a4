//! Finds the leaves whose members can reach a region.

use super::{axis_of, key_of};
use crate::access::Access;
use crate::arch::{MAXIMA, MINIMA, Simd};
use crate::key::KeyBox;

/// Nodes that can wait at once: one a level.
const STACK: usize = 32;

/// The leaves at one depth, from left to right, that have minima at or below `high` on all axes and members that
/// reach `low` on all axes; others only where the bounds are too loose to tell. O(depth) for each leaf.
///
/// An iterator but for the trait: its loop has to be compiled into that of its caller to share its instruction set.
pub(crate) struct Visit<'v, S: Simd> {
    planes: &'v [i32],
    /// How far the two children of each node reach.
    reach: &'v [KeyBox],
    first: u32,
    /// The region's low sides, for both children at once.
    low: S::Keys,
    high: [i32; 3],
    stack: [u32; STACK],
    waiting: usize,
}

impl<'v, S: Simd> Visit<'v, S> {
    #[inline(always)]
    pub(crate) fn new(
        simd: S,
        planes: &'v [i32],
        reach: &'v [[i32; 3]],
        depth: u32,
        low: [i32; 3],
        high: [i32; 3],
    ) -> Self {
        // A node without members reaches the lowest key; no box does.
        let low = low.map(|key| key.max(i32::MIN + 1));
        let mut stack = [0; STACK];
        stack[0] = 1;
        let reach = bytemuck::try_cast_slice(reach).unwrap_or_default();
        Self { planes, reach, first: 1 << depth, low: simd.keys(&KeyBox::at(low)), high, stack, waiting: 1 }
    }

    /// The same for a region whose low corner is in the cell of a leaf: no way down from the root has to be found. That leaf comes
    /// first, then others in any order.
    #[inline(always)]
    pub(crate) fn starting_at(mut self, simd: S, leaf: usize) -> Self {
        let Self { planes, reach, first, low, high, stack, .. } = &mut self;
        let leaf = *first | leaf as u32;
        let mut waiting = 0;
        // All that stands beside the way, the deepest last.
        for level in (0..first.trailing_zeros()).rev() {
            let node = leaf >> level;
            let parent = node as usize / 2;
            let plane = planes.at(parent);
            let unreached = simd.above(*low, simd.keys(KeyBox::of(reach, parent)));
            let is_right = node & 1 != 0;
            let side = if is_right { MINIMA } else { MAXIMA };
            stack.put(waiting, node ^ 1);
            let below = is_right | (high[axis_of(plane)] >= key_of(plane));
            waiting += usize::from((unreached & side == 0) & below);
        }
        stack.put(waiting, leaf);
        self.waiting = waiting + 1;
        self
    }

    #[inline(always)]
    pub(crate) fn next(&mut self, simd: S) -> Option<usize> {
        // In variables, so that they stay in registers.
        let Self { planes, reach, first, low, high, stack, waiting } = self;
        let mut count = *waiting;
        while count > 0 {
            count -= 1;
            let node = stack.at(count);
            if node >= *first {
                *waiting = count;
                return Some((node - *first) as usize);
            }
            let plane = planes.at(node as usize);
            let unreached = simd.above(*low, simd.keys(KeyBox::of(reach, node as usize)));
            let right = (unreached & MAXIMA == 0) & (high[axis_of(plane)] >= key_of(plane));
            // Written always, and kept or not, so that nothing depends on a guess of the branch predictor.
            stack.put(count, 2 * node + 1);
            count += usize::from(right);
            stack.put(count, 2 * node);
            count += usize::from(unreached & MINIMA == 0);
        }
        *waiting = 0;
        None
    }
}
