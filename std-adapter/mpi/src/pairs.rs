//! Pairs of other ranks.

use crate::table::KeyPair;
use crate::world::SplitWorld;

impl SplitWorld {
    /// Waits until all ranks have called it, for as long as a step would wait.
    pub fn meet(&self) {
        self.exchange.sum(&[0]);
    }

    /// Brings pairs of all ranks to one rank, in any order; the others get none. All ranks have to call it.
    #[must_use]
    pub fn gather(&self, pairs: &[KeyPair], to: usize) -> Vec<KeyPair> {
        let mut all = if self.rank() == to { pairs.to_vec() } else { Vec::new() };
        let letter =
            (self.rank() != to && !pairs.is_empty()).then(|| (to, bytemuck::cast_slice(pairs).to_vec()));
        let letters: Vec<_> = letter.into_iter().collect();
        for (_, bytes) in self.exchange.scatter(&letters) {
            all.extend(bytes.chunks_exact(size_of::<KeyPair>()).map(bytemuck::pod_read_unaligned::<KeyPair>));
        }
        all
    }

    /// Sends each pair that the last step has told this rank to the rank that owns the lower key, and returns those that have come
    /// and those that are here already, in any order. All ranks have to call it after the same step.
    ///
    /// Meant for [`found`](Self::found) and for the pairs of [`visit_pairs`](Self::visit_pairs). A pair whose lower object this
    /// rank no longer knows, as may be after it was lost, stays here.
    #[must_use]
    pub fn send_to_owners(&self, pairs: &[KeyPair]) -> Vec<KeyPair> {
        let mut batches = vec![Vec::new(); self.ranks()];
        for pair in pairs {
            let owner = self.aabb(pair[0]).map_or(self.rank(), |aabb| self.rank_of(aabb.min));
            batches[owner].push(*pair);
        }
        let mut all = std::mem::take(&mut batches[self.rank()]);
        let full = batches.into_iter().enumerate().filter(|(_, batch)| !batch.is_empty());
        let letters: Vec<_> = full.map(|(to, batch)| (to, bytemuck::cast_slice(&batch).to_vec())).collect();
        for (_, bytes) in self.exchange.scatter(&letters) {
            all.extend(bytes.chunks_exact(size_of::<KeyPair>()).map(bytemuck::pod_read_unaligned::<KeyPair>));
        }
        all
    }
}
