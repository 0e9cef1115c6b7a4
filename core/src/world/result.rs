//! What a step has found.

use super::World;
use crate::access::Access;
use crate::error::Rejected;
use crate::id::{Index, Pair};
use crate::memory::stats::Stats;

/// The result of a step, and a view of the world as it is after it.
pub struct Step<'w, I: Index = u32> {
    pub(super) world: &'w World<'w, I>,
    pub(super) rejected: Option<Rejected>,
}

impl<'w, I: Index> Step<'w, I> {
    /// See [`World::pairs`].
    #[must_use]
    pub fn pairs(&self) -> &'w [Pair<I>] {
        self.world.pairs()
    }

    /// See [`World::found`].
    #[must_use]
    pub fn found(&self) -> &'w [Pair<I>] {
        self.world.found()
    }

    /// See [`World::lost`].
    #[must_use]
    pub fn lost(&self) -> &'w [Pair<I>] {
        self.world.lost()
    }

    /// The world after the step: for ids, boxes and queries while its pairs are looked at.
    #[must_use]
    pub fn world(&self) -> &'w World<'w, I> {
        self.world
    }

    /// What the step did.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.world.stats()
    }

    /// The objects whose boxes in the bounds array were refused: NaN, or a minimum above its maximum. They have kept
    /// their last good boxes, and all others are as if nothing had been.
    #[must_use]
    pub fn rejected(&self) -> Option<Rejected> {
        self.rejected
    }

    /// How many of the pairs are there only for the margins: their boxes as given do not overlap. Always zero in
    /// [`Mode::Exact`](crate::Mode::Exact). Counted when it is asked for: O(pairs).
    #[must_use]
    pub fn surplus(&self) -> u64 {
        let now = &self.world.parts.boxes.now;
        let apart = |pair: &&Pair<I>| !now.at(pair[0].at()).overlaps(&now.at(pair[1].at()));
        self.pairs().iter().filter(apart).count() as u64
    }
}
