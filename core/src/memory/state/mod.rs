//! The numbers of a world that are not arrays, one struct for each layer that owns some.

mod owners;
mod setup;

pub(crate) use owners::{ListState, ObjectState, PairState, StepState, TreeState, large_nodes, slot};
pub(crate) use setup::Setup;

use super::layout::{has_fat, sweeps_margins};
use super::scratch::Work;
use super::stats::{Route, Stats};
use crate::config::{Config, MOVERS_ONLY, TREE};
use crate::memory::limits::TRIAL;
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
    /// Whether a step has begun and not ended: it is set first and cleared last.
    pub(crate) stepping: u64,
}

impl State {
    pub(crate) fn new(config: &Config, index_bytes: usize) -> Self {
        let pairs = PairState { complete: 1, ..PairState::zeroed() };
        // Margins are used from the first step on, predicted boxes once some have tried them.
        let uses = sweeps_margins(config) || config.fixed_margins || config.forced.of(MOVERS_ONLY).is_some();
        let margins_in = if has_fat(config) && !uses { TRIAL } else { 0 };
        let step = StepState { margins_in, ..StepState::zeroed() };
        Self { setup: Setup::new(config, index_bytes), pairs, step, ..Self::zeroed() }
    }

    /// The leaves now; without a tree, as the last step had them.
    pub(crate) const fn leaves(&self) -> u32 {
        if TREE && self.tree.filled != 0 { self.tree.leaves() } else { self.step.leaves }
    }

    /// The state as a snapshot has it: the objects and the last result, without the tree, lists, fat boxes
    /// and surplus, and without what belongs to the memory, the build or a test. The next step finds all
    /// pairs anew.
    pub(crate) fn portable(&self) -> Self {
        let TreeState { leaves_in_use, fullest_leaf, .. } = self.tree;
        let step = StepState { calm: 0, was_calm: 0, kept: 0, margins_in: 0, ..self.step };
        Self {
            setup: self.setup.portable(),
            tree: TreeState { leaves_in_use, fullest_leaf, ..TreeState::zeroed() },
            pairs: self.pairs.portable(),
            // Each object gets a new fat box with its next box.
            step: StepState { renews: 1, age: 0, spent: 0, ..step },
            objects: self.objects,
            lists: ListState { stale: 1, ..ListState::zeroed() },
            stepping: 0,
        }
    }

    /// Whether this is such a state.
    pub(crate) fn is_portable(&self) -> bool {
        bytemuck::bytes_of(self) == bytemuck::bytes_of(&self.portable())
    }

    pub(crate) fn stats(&self) -> Stats {
        let Self { tree, pairs, step, objects, .. } = self;
        let has_tree = step.leaves > 1;
        let Route { path, reason } = step.route().unwrap_or(Route::UNCHANGED);
        let Work { copies, candidates, tied, spared } = step.work;
        Stats {
            objects: objects.live,
            moved: step.moved,
            path,
            reason,
            fine_leaves: tree.subdivided != 0 && has_tree,
            shared: step.shared != 0,
            outran: step.outran,
            leaves: step.leaves,
            leaves_in_use: if has_tree { tree.leaves_in_use } else { u32::from(objects.live > 0) },
            fullest_leaf: if has_tree { tree.fullest_leaf } else { objects.live },
            copies,
            candidates,
            spared,
            tied,
            pairs: pairs.reported,
            found: pairs.found,
            lost: pairs.lost,
            surplus: pairs.swept - pairs.reported,
            large: if has_tree { tree.large } else { 0 },
            rebalanced: step.rebalanced,
        }
    }
}
