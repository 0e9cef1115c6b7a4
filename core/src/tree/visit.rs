//! Finds the leaves whose members can reach a region.

use super::{axis_of, key_of};
use crate::access::Access;

/// Nodes that can wait at once: one a level.
const STACK: usize = 32;

/// The leaves at one depth, from left to right, that have minima at or below `high` on all axes and members that
/// reach `low` on all axes; others only where the bounds are too loose to tell. O(depth) for each leaf.
///
/// An iterator but for the trait: its loop has to be compiled into that of its caller to share its instruction set.
pub(crate) struct Visit<'v> {
    planes: &'v [i32],
    reach: &'v [[i32; 3]],
    first: u32,
    low: [i32; 3],
    high: [i32; 3],
    stack: [u32; STACK],
    waiting: usize,
}

impl<'v> Visit<'v> {
    #[inline(always)]
    pub(crate) fn new(
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
        Self { planes, reach, first: 1 << depth, low, high, stack, waiting: 1 }
    }

    #[inline(always)]
    pub(crate) fn next(&mut self) -> Option<usize> {
        while self.waiting > 0 {
            self.waiting -= 1;
            let node = self.stack.at(self.waiting);
            let bound = self.reach.at(node as usize);
            if bound[0] < self.low[0] || bound[1] < self.low[1] || bound[2] < self.low[2] {
                continue;
            }
            if node >= self.first {
                return Some((node - self.first) as usize);
            }
            let plane = self.planes.at(node as usize);
            if self.high[axis_of(plane)] >= key_of(plane) {
                self.stack.put(self.waiting, 2 * node + 1);
                self.waiting += 1;
            }
            self.stack.put(self.waiting, 2 * node);
            self.waiting += 1;
        }
        None
    }
}
