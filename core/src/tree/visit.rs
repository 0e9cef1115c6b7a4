//! Finds the leaves whose members may touch a region.

use crate::access::Access;
use crate::arch::Simd;
use crate::key::KeyBox;

/// Nodes that can wait at once: one a level.
const STACK: usize = 32;

/// The leaves at one depth whose boxes overlap a region. O(depth) for each leaf.
///
/// An iterator but for the trait: its loop has to be compiled into that of its caller to share its instruction set.
pub(crate) struct Visit<'v> {
    nodes: &'v [KeyBox],
    first: u32,
    region: KeyBox,
    stack: [u32; STACK],
    waiting: usize,
}

impl<'v> Visit<'v> {
    /// Starts at any leaf, which comes first; best the one whose cell holds the region's low corner, as then little is left to
    /// visit. No way down from the root has to be found: the tests on the way up do not wait for each other.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(
        simd: S,
        nodes: &'v [KeyBox],
        depth: u32,
        leaf: usize,
        region: KeyBox,
    ) -> Self {
        let first = 1 << depth;
        let leaf = first | leaf as u32;
        let mut stack = [0; STACK];
        let mut waiting = 0;
        // All that stands beside the way, the deepest last.
        for level in (0..depth).rev() {
            let beside = leaf >> level ^ 1;
            // Written always, and kept or not, so that nothing depends on a guess of the branch predictor.
            stack.put(waiting, beside);
            waiting += usize::from(simd.overlap(KeyBox::of(nodes, beside as usize), &region));
        }
        stack.put(waiting, leaf);
        Self { nodes, first, region, stack, waiting: waiting + 1 }
    }

    #[inline(always)]
    pub(crate) fn next<S: Simd>(&mut self, simd: S) -> Option<usize> {
        // In variables, so that they stay in registers.
        let Self { nodes, first, region, stack, waiting } = self;
        let mut count = *waiting;
        while count > 0 {
            count -= 1;
            let node = stack.at(count);
            if node >= *first {
                *waiting = count;
                return Some((node - *first) as usize);
            }
            for child in [2 * node + 1, 2 * node] {
                stack.put(count, child);
                count += usize::from(simd.overlap(KeyBox::of(nodes, child as usize), region));
            }
        }
        *waiting = 0;
        None
    }
}
