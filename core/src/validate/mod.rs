//! Checks all invariants of a world: in tests, to debug an embedding, and in the bytes of a snapshot before it is
//! loaded. After a world that passes, the next step finds what brute force finds.

pub(crate) mod content;
mod numbers;
mod objects;
pub(crate) mod pairs;
mod slab;
pub(crate) mod tree;

pub(crate) use numbers::numbers;

use crate::id::Index;
use crate::world::World;
use content::{Content, InSlab};
use core::fmt;

/// The first broken invariant that [`World::validate`] met: a fault of this library, or something wrote to the slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Invalid {
    what: &'static str,
    at: usize,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (at {})", self.what, self.at)
    }
}

impl core::error::Error for Invalid {}

#[inline(always)]
fn check(holds: bool, what: &'static str, at: usize) -> Result<(), Invalid> {
    if holds { Ok(()) } else { Err(Invalid { what, at }) }
}

/// Tests of an embedding.
impl<I: Index> World<'_, I> {
    /// Checks all invariants of the world: slots, boxes, lists, tree and pairs. Steps never call it. O(n log n +
    /// pairs), and about as long as a step that finds all pairs.
    ///
    /// # Errors
    /// The first broken one.
    pub fn validate(&self) -> Result<(), Invalid> {
        let parts = &self.parts;
        numbers(parts.state, &parts.sizes)?;
        content(&mut InSlab(parts))?;
        slab::slab(parts)
    }
}

/// Checks what a slab and a snapshot both have, after the numbers.
pub(crate) fn content<I: Index>(content: &mut impl Content<I>) -> Result<(), Invalid> {
    objects::objects(content)?;
    if !content.sizes().is_small() {
        tree::tree(content)?;
    }
    pairs::pairs(content)
}

/// The same without the tree.
pub(crate) fn content_without_tree<I: Index>(content: &impl Content<I>) -> Result<(), Invalid> {
    objects::objects(content)?;
    pairs::pairs(content)
}
