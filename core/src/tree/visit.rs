//! Finds the leaves whose members can reach a region.

use super::{axis_of, key_of};
use crate::access::Access;

/// Nodes that can wait at once: one a level.
const STACK: usize = 32;

/// Calls `leaf` for each leaf at `depth`, from left to right, that has minima at or below `high` on all axes and
/// members that reach `low` on all axes; others only where the bounds are too loose to tell. O(depth) for each.
#[inline(always)]
pub(crate) fn visit(
    planes: &[i32],
    reach: &[[i32; 3]],
    depth: u32,
    low: &[i32; 3],
    high: &[i32; 3],
    mut leaf: impl FnMut(usize),
) {
    // A node without members reaches the lowest key; no box does.
    let low = low.map(|key| key.max(i32::MIN + 1));
    let first = 1u32 << depth;
    let mut stack = [0u32; STACK];
    let mut waiting = 1;
    stack[0] = 1;
    while waiting > 0 {
        waiting -= 1;
        let node = stack.at(waiting);
        let bound = reach.at(node as usize);
        if bound[0] < low[0] || bound[1] < low[1] || bound[2] < low[2] {
            continue;
        }
        if node >= first {
            leaf((node - first) as usize);
            continue;
        }
        let plane = planes.at(node as usize);
        if high[axis_of(plane)] >= key_of(plane) {
            stack.put(waiting, 2 * node + 1);
            waiting += 1;
        }
        stack.put(waiting, 2 * node);
        waiting += 1;
    }
}
