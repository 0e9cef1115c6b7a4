//! What is in a region, what a moving box meets, what is nearest: questions between two steps, on the tree of the last one.
//!
//! Answers are those of the boxes as they are now, margins aside: what has come, moved or gone since the last step is asked
//! one by one, and so is everything before the first step with a tree. All numbers are computed in `f64` from the boxes'
//! `f32`, in operations that keep the order of their operands, so that what the tree rules out the exact test would too.

mod batch;
mod cast;
mod nearest;
mod region;

pub use cast::{Cast, Hit};
pub use region::Region;

use crate::access::{Access, bits};
use crate::arch::{Simd, limit};
use crate::id::{Id, Index};
use crate::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY, key};
use crate::storage::Parts;
use crate::tree::Record;
use crate::world::World;

impl<I: Index> World<'_, I> {
    /// Whether the tree holds every object that has not been touched since the last step.
    pub(crate) fn has_tree(&self) -> bool {
        self.parts.state.filled != 0
    }

    /// The slots that the tree does not answer for: all, or those that were touched since the last step.
    fn apart_from_tree(&self) -> impl Iterator<Item = usize> + '_ {
        let (has_tree, touched) = (self.has_tree(), self.parts.state.touched != 0);
        let all = 0..if has_tree { 0 } else { self.parts.state.slots as usize };
        let moved = if has_tree && touched { &*self.parts.moved } else { &[] };
        all.chain(bits::ones(moved)).filter(|&slot| !self.parts.boxes.now.at(slot).is_empty())
    }

    /// The large objects that the tree answers for.
    pub(crate) fn large_in_tree(&self) -> impl Iterator<Item = usize> + '_ {
        let state = &*self.parts.state;
        let count = if self.has_tree() { state.large as usize } else { 0 };
        let large = self.parts.tree.fronts.span(state.large_start as usize, count);
        large.iter().map(|front| front.slot as usize).filter(|&slot| is_current(&self.parts, slot))
    }

    /// The id of a living object.
    pub(crate) fn id_of(&self, slot: usize) -> Option<Id> {
        Id::new(slot as u32, self.parts.generations.at(slot))
    }
}

/// How far the members of a node reach at most, or `None` where there are none.
#[inline(always)]
fn reach_of<I: Index>(parts: &Parts<'_, I>, node: u32) -> Option<[i32; 3]> {
    let reach = parts.tree.reach.at(node as usize);
    // Cells at the rim end beyond all floats.
    (reach[0] != i32::MIN).then_some(reach.map(|key| key.min(POSITIVE_INFINITY)))
}

/// Whether the tree's record of an object is that of its box.
#[inline(always)]
fn is_current<I: Index>(parts: &Parts<'_, I>, slot: usize) -> bool {
    parts.state.touched == 0 || !bits::test(parts.moved, slot)
}

/// Calls `visit` with the current members of a leaf that may touch a region; it must find out which ones do.
#[inline(always)]
fn members_near<S: Simd, I: Index>(
    simd: S,
    parts: &Parts<'_, I>,
    leaf: usize,
    region: &KeyBox,
    mut visit: impl FnMut(usize),
) {
    let bag = parts.tree.leaves.at(leaf);
    let members = parts.tree.records.span(bag.start as usize, bag.len as usize);
    let limit = limit(&simd.record(&parts.tree.frames.at(leaf), simd.keys(region), 0));
    let (quads, rest) = members.as_chunks::<4>();
    let mut visit = |record: &Record| {
        let slot = record.slot() as usize;
        if is_current(parts, slot) {
            visit(slot);
        }
    };
    for quad in quads {
        let mut mask = simd.touching(quad, limit);
        while mask != 0 {
            visit(&quad.at(mask.trailing_zeros() as usize));
            mask &= mask - 1;
        }
    }
    rest.iter().for_each(visit);
}

/// The key of the greatest `f32` that is not above a number, but finite numbers stay finite.
fn key_below(x: f64) -> i32 {
    let nearest = x as f32;
    let below = if f64::from(nearest) > x { nearest.next_down() } else { nearest };
    // NaN comes from infinities alone: nothing is known.
    if below.is_nan() { NEGATIVE_INFINITY } else { key(below) }
}

/// The key of the least `f32` that is not below a number.
fn key_above(x: f64) -> i32 {
    let nearest = x as f32;
    let above = if f64::from(nearest) < x { nearest.next_up() } else { nearest };
    if above.is_nan() { POSITIVE_INFINITY } else { key(above) }
}
