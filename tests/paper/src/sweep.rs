//! The improved sweep-and-prune of a leaf.

use crate::tree::{Leaf, Member};
use crate::{Aabb, Pair};

/// A box of the leaf that is swept.
#[derive(Clone, Copy, Debug)]
struct Swept {
    aabb: Aabb,
    id: u32,
    is_moved: bool,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Sweep {
    swept: Vec<Swept>,
    /// Pairs of places in the leaf that overlap on the axes so far.
    candidates: Vec<[u32; 2]>,
}

impl Sweep {
    /// Appends the overlaps of which at least one side has moved.
    pub(crate) fn leaf(
        &mut self,
        leaf: &Leaf,
        members: &[Member],
        boxes: &[Aabb],
        is_moved: &[bool],
        pairs: &mut Vec<Pair>,
    ) {
        let of = |member: &Member| {
            let at = member.id() as usize;
            Swept { aabb: boxes[at], id: member.id(), is_moved: is_moved[at] }
        };
        self.swept.clear();
        self.swept.extend(members.iter().map(of));
        if !self.swept.iter().any(|one| one.is_moved) {
            return;
        }

        // The first axis: the list is sorted, so that a box overlaps those behind it which start before it ends.
        let k = leaf.axis;
        self.candidates.clear();
        for (at, one) in self.swept.iter().enumerate() {
            let behind = self.swept.iter().enumerate().skip(at + 1);
            for (other_at, other) in behind.take_while(|(_, other)| other.aabb.min[k] <= one.aabb.max[k]) {
                if one.is_moved || other.is_moved {
                    self.candidates.push([at as u32, other_at as u32]);
                }
            }
        }
        // The other axes: pairs are filtered, not objects (E15).
        let swept = &self.swept;
        for axis in [(k + 1) % 3, (k + 2) % 3] {
            self.candidates.retain(|pair| {
                let [a, b] = pair.map(|at| &swept[at as usize].aabb);
                a.overlaps_on(b, axis)
            });
        }
        for pair in &self.candidates {
            let [a, b] = pair.map(|at| &swept[at as usize]);
            if belongs(leaf, &a.aabb, &b.aabb) {
                pairs.push([a.id.min(b.id), a.id.max(b.id)]);
            }
        }
    }
}

/// Whether an overlap is told by this leaf (E9): its lowest corner lies in the cell. That corner is made of minima, and both
/// boxes reach into the cell, so that it cannot lie above it.
fn belongs(leaf: &Leaf, a: &Aabb, b: &Aabb) -> bool {
    (0..3).all(|k| leaf.low[k].is_none_or(|low| a.min[k] > low || b.min[k] > low))
}
