//! Finds the leaves whose members may touch a region.

use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::simd::Simd;

/// Nodes that can wait at once: one a level.
const STACK: usize = 32;

/// The leaves at one depth whose boxes overlap a region. O(depth) for each leaf.
///
/// An iterator but for the trait: its loop has to be compiled into that of its caller to share its instruction set.
pub(crate) struct Visit<'v> {
    nodes: &'v [KeyBox],
    first: u32,
    region: KeyBox,
    /// Where it started, and on which levels above what stands beside the way is to be visited: a bit each.
    leaf: u32,
    beside: u32,
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
        let mut beside = 0;
        for level in 0..depth {
            let node = KeyBox::of(nodes, (leaf >> level ^ 1) as usize);
            beside |= u32::from(simd.overlap(node, &region)) << level;
        }
        let mut stack = [0; STACK];
        stack[0] = leaf;
        Self { nodes, first, region, leaf, beside, stack, waiting: 1 }
    }

    #[inline(always)]
    pub(crate) fn next<S: Simd>(&mut self, simd: S) -> Option<usize> {
        // In variables, so that they stay in registers.
        let Self { nodes, first, region, leaf, beside, stack, waiting } = self;
        let mut count = *waiting;
        loop {
            let node = if count > 0 {
                count -= 1;
                stack.at(count)
            } else if *beside != 0 {
                // The deepest first.
                let level = beside.trailing_zeros();
                *beside &= *beside - 1;
                *leaf >> level ^ 1
            } else {
                *waiting = 0;
                return None;
            };
            if node >= *first {
                *waiting = count;
                return Some((node - *first) as usize);
            }
            for child in [2 * node + 1, 2 * node] {
                stack.put(count, child);
                count += usize::from(simd.overlap(KeyBox::of(nodes, child as usize), region));
            }
        }
    }
}
