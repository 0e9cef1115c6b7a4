//! Checks all invariants of a world, in tests and to debug an embedding. After a world that passes, the next step
//! finds what brute force finds.

mod numbers;
mod pairs;
mod slab;
mod tree;

use crate::id::Index;
use crate::snapshot::check::{self, Invalid};
use crate::snapshot::stored::Stored;
use crate::world::World;

/// Tests of an embedding, with the feature `validate`.
impl<I: Index> World<'_, I> {
    /// Checks all invariants of the world: slots, boxes, lists, tree and pairs. Steps never call it. O(n log n +
    /// pairs), and about as long as a step that finds all pairs.
    ///
    /// # Errors
    /// The first broken one.
    pub fn validate(&self) -> Result<(), Invalid> {
        let parts = &self.parts;
        numbers::numbers(parts.state, &parts.sizes)?;
        check::all(&Stored::of(parts))?;
        slab::slab(parts)?;
        if !parts.sizes.is_small() {
            tree::tree(parts)?;
        }
        pairs::pairs(parts)
    }
}
