//! Checks all invariants of a world, in tests and to debug an embedding. After a world that passes, the next
//! step finds what brute force finds.

mod pairs;
mod slab;
mod tree;

use crate::id::Index;
use crate::snapshot::check::Invalid;
use crate::world::World;

/// Tests of an embedding, with the feature `validate`.
impl<I: Index> World<'_, I> {
    /// Checks all invariants of the world: slots, boxes, lists, tree and pairs. Steps never call it. O(n log
    /// n + pairs), and about as long as a step that finds all pairs.
    ///
    /// # Errors
    /// The first broken one.
    pub fn validate(&self) -> Result<(), Invalid> {
        let parts = &self.parts;
        // None of the deep ones is inline: their stack frames do not stand below each other.
        slab::numbers(parts.state, &parts.sizes)?;
        slab::slots(parts)?;
        slab::last_boxes(parts)?;
        slab::lists(parts)?;
        if !parts.sizes.is_small() {
            tree::tree(parts)?;
        }
        pairs::pairs(self)
    }
}

/// A sum over numbers in any order that tells, without a list, whether some are missing or there twice.
fn sum(numbers: impl Iterator<Item = u64>) -> u64 {
    // SplitMix64: each bit of a number changes each bit of the result for half of all numbers.
    let mixed = |number: u64| {
        let bits = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ bits >> 31
    };
    numbers.map(mixed).fold(0, u64::wrapping_add)
}
