//! What a step of a broad phase has found.

use super::Names;
use trisap_core::{Id, Stats, World};

/// The result of a step by key, and the world as it is after it.
pub struct KeyedStep<'b, K> {
    pub(super) world: World<'b>,
    pub(super) names: &'b Names<K>,
}

impl<K: Copy + Eq> KeyedStep<'_, K> {
    /// The overlapping pairs, each once.
    pub fn pairs(&self) -> impl Iterator<Item = [K; 2]> {
        self.world.pair_ids().filter_map(|pair| self.keys(pair))
    }

    /// Those of which at least one has not been put to rest: what a narrow phase has to look at that keeps the contacts of those
    /// that rest.
    pub fn awake_pairs(&self) -> impl Iterator<Item = [K; 2]> {
        let id = |slot| self.world.id_at(slot);
        self.world.awake_pairs().filter_map(move |[a, b]| self.keys([id(a)?, id(b)?]))
    }

    /// With events: the pairs that this step has and the last one had not.
    pub fn found(&self) -> impl Iterator<Item = [K; 2]> {
        self.world.found_ids().filter_map(|pair| self.keys(pair))
    }

    /// With events: the pairs that the last step had and this one has not, also of keys that have been removed. A key that was
    /// removed and inserted again is another object: its pairs are lost, and found again.
    pub fn lost(&self) -> impl Iterator<Item = [K; 2]> {
        self.world.lost_ids().filter_map(|pair| self.keys(pair))
    }

    /// What the step did.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.world.stats()
    }

    /// The world after the step, for what is not here.
    #[must_use]
    pub fn world(&self) -> &World<'_> {
        &self.world
    }

    fn keys(&self, [a, b]: [Id; 2]) -> Option<[K; 2]> {
        Some([self.names.key(a)?, self.names.key(b)?])
    }
}

impl<K: Copy + Eq> core::fmt::Debug for KeyedStep<'_, K> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("KeyedStep").field("stats", &self.stats()).finish_non_exhaustive()
    }
}
