//! The method of J. Cao and M. Wang, "A Fast and Generalized Broad-Phase Collision Detection Method Based on KD-Tree
//! Spatial Subdivision and Sweep-and-Prune", as it is printed: what trisap is measured against.
//!
//! - **Lists.** All objects stand in three doubly linked lists, one an axis, sorted by quicksort at first and repaired by
//!   insertion sort in every step.
//! - **Tree.** A KD-tree is split from the sorted lists, level by level, at the median object, until a leaf has no more
//!   than [`Settings::leaf`] boxes. The axes take turns, the most dispersed first. Boxes that straddle a plane are copied
//!   to the other side. Every step goes through the tree once from the top: the planes follow the medians, copies come
//!   and go.
//! - **Temporal inference.** An object whose box is still inside its expanded box is static. Only dynamic objects are
//!   tested, against each other and against static ones.
//! - **Sweep.** Each leaf is swept along one axis, in the order that its list has already. The pairs that overlap there are
//!   tested on the second axis, those that are left on the third.
//!
//! No vector instructions, no threads, no layout for the cache, and no other way for small or crowded scenes: the paper
//! has none. (It sweeps leaves in parallel. Here everybody has one thread.)
//!
//! The printed text loses pairs and repeats some, and parts of it contradict each other. It is corrected there and nowhere
//! else. The code names each correction by its number:
//!
//! | | printed | here |
//! |---|---|---|
//! | E1 | the expanded box is the centre ± a share of the half extent, so smaller than the box | the box and a margin on each side: that share of the extent |
//! | E2 | the share is the mean size of all, by a hundred: it depends on the unit of length | a hundredth |
//! | E3, E4 | an object is static if two comparisons hold, one of them turned round, on one axis | if the expanded box contains the box, on all axes |
//! | E5 | the expanded box is made anew from the last box, so whoever creeps is static for ever | it stays until the box leaves it; lists, planes and sweeps use expanded boxes, and the box itself decides in the end |
//! | E6 | pairs of two static objects are not tested, and so drop out | they are kept from the last step |
//! | E7 | static boxes that straddle a plane are not copied, and miss dynamic ones beyond | they are copied as well |
//! | E8 | the side of an object is decided when it moves; planes move too | it is decided in every step |
//! | E9 | the pairs of all leaves are put together: straddling pairs repeat | a pair is told by the one leaf where the higher of its minima lies on all axes |
//! | E10 | lists in the order of "positions", at times of centres | of the minima, and of the index where these are equal |
//! | E11 | a leaf is split until it is small enough: equal boxes never are | it is split where both sides get smaller and copies are few |
//! | E12 | one node in three lists, and values are swapped between nodes | links for each axis, which are changed |
//! | E13 | the order is repaired in linear time | by insertion as long as that takes few moves, or else the list is sorted anew |
//! | E15 | the loop over time is inside the parallel loop over leaves, and objects are filtered | phases, and pairs are filtered |
//! | E16 | a leaf is swept along the axis of its grandparent's dispersion; some have none | then along that of the nearest ancestor |
//! | E17 | the split axes take turns, or are chosen by dispersion | in turns, ordered by the dispersion of the whole scene; an axis that separates nothing is passed over |

#![forbid(unsafe_code)]

mod aabb;
mod inference;
mod lists;
mod sweep;
mod tree;

pub use aabb::Aabb;

use inference::Inference;
use lists::Lists;
use sweep::Sweep;
use tree::Tree;

/// Two objects by index, the lower one first.
pub type Pair = [u32; 2];

/// What the paper leaves open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The boxes up to which a leaf is not split; the paper's T.
    pub leaf: usize,
    /// The margin of an expanded box on each side, as a share of the extent of the box on that axis (E1, E2).
    pub margin: f32,
}

impl Default for Settings {
    fn default() -> Self {
        // The paper has no number for T. From 32 to 256 the times are much the same.
        Self { leaf: 64, margin: 0.01 }
    }
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Dynamic objects.
    pub moved: usize,
    /// Places by which nodes went back in the lists.
    pub moves: u64,
    /// Lists that were sorted anew (E13).
    pub sorted: u32,
    /// Leaves of the tree.
    pub leaves: usize,
    /// Boxes in all leaves: the objects and their copies.
    pub entries: usize,
}

/// A fixed number of objects, and what is known of them from the last step.
#[derive(Clone, Debug)]
pub struct World {
    inference: Inference,
    lists: Lists,
    tree: Tree,
    sweep: Sweep,
    /// The pairs of expanded boxes that overlap.
    expanded_pairs: Vec<Pair>,
    pairs: Vec<Pair>,
    counts: Counts,
}

impl World {
    /// A world of so many objects, which have no boxes before the first [`step`](Self::step).
    #[must_use]
    pub fn new(objects: usize, settings: Settings) -> Self {
        Self {
            inference: Inference::new(objects, settings.margin),
            lists: Lists::default(),
            tree: Tree::new(objects, settings.leaf),
            sweep: Sweep::default(),
            expanded_pairs: Vec::new(),
            pairs: Vec::new(),
            counts: Counts::default(),
        }
    }

    /// Takes the boxes of all objects and finds the pairs that overlap, each once, in any order.
    ///
    /// # Panics
    /// If there is another number of boxes than of objects, or a box that is not [valid](Aabb::is_valid).
    pub fn step(&mut self, boxes: &[Aabb]) -> &[Pair] {
        let moved = self.inference.update(boxes);
        self.counts =
            Counts { moved, leaves: self.counts.leaves, entries: self.counts.entries, ..Counts::default() };
        let Inference { expanded, is_moved, .. } = &self.inference;
        // E15: one phase after the other. Where nobody has moved, none of them changes anything.
        if moved > 0 {
            (self.counts.moves, self.counts.sorted) = self.lists.update(expanded);
            self.tree.update(&self.lists, expanded);
            (self.counts.leaves, self.counts.entries) =
                (self.tree.leaves.len(), self.tree.leaf_members.len());
            // E6: neither of these boxes has changed.
            self.expanded_pairs.retain(|pair| pair.iter().all(|&id| !is_moved[id as usize]));
            for leaf in &self.tree.leaves {
                let members = &self.tree.leaf_members[leaf.members.clone()];
                self.sweep.leaf(leaf, members, expanded, is_moved, &mut self.expanded_pairs);
            }
        }
        // E5: expanded boxes may overlap where the boxes do not.
        let overlaps = |&&[a, b]: &&Pair| boxes[a as usize].overlaps(&boxes[b as usize]);
        self.pairs.clear();
        self.pairs.extend(self.expanded_pairs.iter().filter(overlaps));
        &self.pairs
    }

    /// The pairs of the last step.
    #[must_use]
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// What the last step did.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }
}
