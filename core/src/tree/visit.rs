//! Walks the tree by the boxes of its nodes, to the leaves that a box, a cast or a point looks for.

use crate::access::{Access, note_fault};
use crate::geometry::key::KeyBox;
use crate::memory::leaf::Nodes;
use crate::memory::limits::LEVELS;
use crate::simd::Simd;
use arrayvec::ArrayVec;

/// What looks for leaves.
pub(crate) trait Probe {
    /// When a node is met, or that it is not. Nodes that are met first are visited first. The default is for a
    /// node that counts as met without a look at it.
    type When: Copy + PartialOrd + Default;

    /// When two nodes are met.
    fn meet<S: Simd>(&self, simd: S, nodes: [&KeyBox; 2]) -> [Self::When; 2];

    /// Whether a node is still to be visited. What was found may change that.
    fn is_met(&self, when: Self::When) -> bool {
        when <= Self::When::default()
    }
}

/// A box meets all nodes that it overlaps, in the order of their numbers.
impl Probe for KeyBox {
    /// Whether they are apart.
    type When = bool;

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, [a, b]: [&KeyBox; 2]) -> [bool; 2] {
        [!simd.overlap(a, self), !simd.overlap(b, self)]
    }
}

#[derive(Clone, Copy)]
struct Waiting<W> {
    node: u32,
    when: W,
}

/// Nodes to walk by, from the root, which has number one.
pub(crate) trait Shape<'v>: Copy {
    fn boxes(&self) -> &'v [KeyBox];

    /// The left child of a node, whose right one has the next number; or the leaf that the node is.
    fn below(&self, node: u32) -> Result<u32, usize>;
}

impl<'v> Shape<'v> for Nodes<'v> {
    fn boxes(&self) -> &'v [KeyBox] {
        self.boxes
    }

    fn below(&self, node: u32) -> Result<u32, usize> {
        let split = self.splits.at(node as usize);
        split.as_leaf().map_or(Ok(split.below), Err)
    }
}

/// The walk to the leaves that a probe meets. O(depth) for each leaf.
///
/// Not an `Iterator`: its loop has to be inlined into its caller's, to have its instruction set.
pub(crate) struct Visit<N, P: Probe> {
    nodes: N,
    pub(crate) probe: P,
    /// Nodes that wait: at most one a level, and the leaf at the start.
    stack: ArrayVec<Waiting<P::When>, LEVELS>,
}

impl<'v, P: Probe> Visit<Nodes<'v>, P> {
    /// To be started where it stands, as it takes long to move.
    #[inline(always)]
    pub(crate) fn new(nodes: Nodes<'v>, probe: P) -> Self {
        Self { nodes, probe, stack: ArrayVec::new() }
    }

    /// Starts at a leaf, which comes first; best at the one whose cell holds the probe's low corner, since
    /// little is left to visit then. From there the nodes beside the way up to the root are tested, which do
    /// not depend on each other; a way down from the root would wait for each test.
    #[inline(always)]
    pub(crate) fn start<S: Simd>(&mut self, simd: S, leaf: usize) {
        let (nodes, top) = (self.nodes, self.nodes.tops.at(leaf));
        let mut beside = ArrayVec::<u32, LEVELS>::new();
        let mut node = top;
        while node > 1 && beside.try_push(node ^ 1).is_ok() {
            node = nodes.parents.at(node as usize / 2);
        }
        // The deepest one is pushed last, so it comes first.
        for pair in beside.rchunks(2) {
            let (lower, upper) = (pair.at(0), pair.last().copied().unwrap_or_default());
            let [upper, lower] = self.meet(simd, [upper, lower]);
            self.push(upper);
            if pair.len() > 1 {
                self.push(lower);
            }
        }
        self.push(Waiting { node: top, when: P::When::default() });
    }
}

impl<'v, N: Shape<'v>, P: Probe> Visit<N, P> {
    pub(crate) fn from_root(nodes: N, probe: P) -> Self {
        let mut visit = Self { nodes, probe, stack: ArrayVec::new() };
        visit.push(Waiting { node: 1, when: P::When::default() });
        visit
    }

    /// Lets a node wait if it is met.
    fn push(&mut self, node: Waiting<P::When>) {
        if self.probe.is_met(node.when) && self.stack.try_push(node).is_err() {
            note_fault(self.nodes.boxes().as_ptr().addr());
        }
    }

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, pair: [u32; 2]) -> [Waiting<P::When>; 2] {
        let [a, b] = pair;
        let boxes = self.nodes.boxes();
        let nodes = [KeyBox::of(boxes, a as usize), KeyBox::of(boxes, b as usize)];
        let [when, other] = self.probe.meet(simd, nodes);
        [Waiting { node: a, when }, Waiting { node: b, when: other }]
    }

    #[inline(always)]
    pub(crate) fn next<S: Simd>(&mut self, simd: S) -> Option<usize> {
        while let Some(mut here) = self.stack.pop() {
            // Down to the leaf that is met first.
            while self.probe.is_met(here.when) {
                let below = match self.nodes.below(here.node) {
                    Ok(below) => below,
                    Err(leaf) => return Some(leaf),
                };
                let [left, right] = self.meet(simd, [below, below + 1]);
                // NaN comes last.
                let swap = right.when < left.when || left.when.partial_cmp(&left.when).is_none();
                let (near, later) = if swap { (right, left) } else { (left, right) };
                self.push(later);
                here = near;
            }
        }
        None
    }
}
