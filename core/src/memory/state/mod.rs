//! The numbers of a world that are not arrays, one struct for each layer that owns some.

mod owners;
mod setup;

pub(crate) use owners::{ListState, ObjectState, PairState, StepState, TreeState};
pub(crate) use setup::Setup;

use super::stats::Stats;
use crate::config::Config;
use bytemuck::{Pod, Zeroable};

/// See the module. Plain bytes without gaps, as it is in the slab: parts with numbers of 64 bits come first.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct State {
    pub(crate) setup: Setup,
    pub(crate) tree: TreeState,
    pub(crate) pairs: PairState,
    pub(crate) step: StepState,
    pub(crate) objects: ObjectState,
    pub(crate) lists: ListState,
    /// The indices out of range that the last step knew of: see [`access`](crate::access).
    pub(crate) faults: u32,
}

impl State {
    pub(crate) fn new(config: &Config, index_bytes: usize) -> Self {
        let pairs = PairState { complete: 1, ..PairState::zeroed() };
        Self { setup: Setup::new(config, index_bytes), pairs, ..Self::zeroed() }
    }

    /// The leaves now; without a tree, those of the last step.
    pub(crate) const fn leaves(&self) -> u32 {
        if self.tree.filled != 0 { 1 << (self.tree.depth + self.tree.sub_levels()) } else { self.step.leaves }
    }

    /// The state as a snapshot has it: without lists, and without what belongs to the memory or to the build. The
    /// number of workers decides about scratch memory alone, features about the slab alone, hooks about the time of
    /// later steps alone.
    pub(crate) fn portable(&self) -> Self {
        Self {
            setup: self.setup.portable(),
            pairs: PairState { unproven: 0, swapped: 0, ..self.pairs },
            lists: ListState { listed: 0, stale: 1, ..self.lists },
            faults: 0,
            ..*self
        }
    }

    /// Whether this is such a state.
    pub(crate) const fn is_portable(&self) -> bool {
        let ListState { listed, stale, .. } = self.lists;
        self.setup.is_portable()
            && self.pairs.unproven == 0
            && self.faults == 0
            && listed == 0
            && stale == 1
            && self.pairs.swapped == 0
    }

    /// Takes over what a snapshot does not have.
    pub(crate) fn adopt(&mut self, other: &Self) {
        self.setup.adopt(&other.setup);
        self.faults = other.faults;
        self.pairs.swapped = other.pairs.swapped;
    }

    /// The state of a world into which another one has moved: the objects and the last result of that one, without
    /// tree, lists and parked pairs. The caller counts the pairs of the step before.
    pub(crate) fn with_objects_of(&self, other: &Self) -> Self {
        let TreeState { leaves_in_use, fullest_leaf, .. } = other.tree;
        Self {
            setup: self.setup,
            tree: TreeState { leaves_in_use, fullest_leaf, ..TreeState::zeroed() },
            pairs: PairState { swapped: self.pairs.swapped, ..other.pairs.reported_alone() },
            step: StepState { calm: 0, kept: 0, margins_in: 0, ..other.step },
            objects: other.objects,
            lists: ListState { stale: 1, ..ListState::zeroed() },
            faults: self.faults,
        }
    }

    pub(crate) fn stats(&self) -> Stats {
        let Self { tree, pairs, step, objects, .. } = self;
        let has_tree = step.leaves > 1;
        Stats {
            objects: objects.live,
            moved: step.moved,
            path: step.path().unwrap_or_default(),
            reason: step.reason().unwrap_or_default(),
            fine_leaves: tree.subdivided != 0 && has_tree,
            shared: step.is_shared(),
            outran: step.outran,
            leaves: step.leaves,
            leaves_in_use: if has_tree { tree.leaves_in_use } else { u32::from(objects.live > 0) },
            fullest_leaf: if has_tree { tree.fullest_leaf } else { objects.live },
            copies: step.copies,
            candidates: step.candidates,
            tied: step.tied,
            pairs: pairs.reported,
            found: pairs.found,
            lost: pairs.lost,
            surplus: pairs.swept - pairs.reported,
            large: if has_tree { tree.large } else { 0 },
            rebalanced: step.rebalanced,
            coarse_resolution: step.is_coarse(),
        }
    }
}
