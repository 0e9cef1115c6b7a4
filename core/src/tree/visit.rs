//! Finds the leaves whose members can reach a region.

use super::Corner;
use crate::access::Access;
use crate::arch::{MAXIMA, MINIMA, Simd};
use crate::key::KeyBox;

/// Nodes that can wait at once: one a level.
const STACK: usize = 32;

/// The leaves at one depth that have minima at or below `high` on all axes and members that reach `low` on all axes; others only
/// where the bounds are too loose to tell. O(depth) for each leaf.
///
/// An iterator but for the trait: its loop has to be compiled into that of its caller to share its instruction set.
pub(crate) struct Visit<'v, S: Simd> {
    planes: &'v [i32],
    /// How far the two children of each node reach.
    reach: &'v [KeyBox],
    first: u32,
    /// The region's low sides, for both children at once.
    low: S::Keys,
    high: Corner,
    stack: [u32; STACK],
    waiting: usize,
}

impl<'v, S: Simd> Visit<'v, S> {
    /// Starts at any leaf, which comes first; best the one whose cell holds the region's low corner, as then little is left to
    /// visit. No way down from the root has to be found: the tests on the way up do not wait for each other.
    #[inline(always)]
    pub(crate) fn new(
        simd: S,
        planes: &'v [i32],
        reach: &'v [[i32; 3]],
        depth: u32,
        leaf: usize,
        low: [i32; 3],
        high: [i32; 3],
    ) -> Self {
        // A node without members reaches the lowest key; no box does.
        let low = simd.keys(&KeyBox::at(low.map(|key| key.max(i32::MIN + 1))));
        let reach: &[KeyBox] = bytemuck::try_cast_slice(reach).unwrap_or_default();
        let high = Corner::new(high);
        let first = 1 << depth;
        let leaf = first | leaf as u32;
        let mut stack = [0; STACK];
        let mut waiting = 0;
        // All that stands beside the way, the deepest last.
        for level in (0..depth).rev() {
            let node = leaf >> level;
            let parent = node as usize / 2;
            let unreached = simd.above(low, simd.keys(KeyBox::of(reach, parent)));
            let is_right = node & 1 != 0;
            let side = if is_right { MINIMA } else { MAXIMA };
            stack.put(waiting, node ^ 1);
            let below = is_right | high.reaches(planes.at(parent));
            waiting += usize::from((unreached & side == 0) & below);
        }
        stack.put(waiting, leaf);
        Self { planes, reach, first, low, high, stack, waiting: waiting + 1 }
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
            let unreached = simd.above(*low, simd.keys(KeyBox::of(reach, node as usize)));
            let right = (unreached & MAXIMA == 0) & high.reaches(planes.at(node as usize));
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
