//! Answers questions between two steps, on the tree of the last one: what is in a region, what a moving box meets,
//! what is nearest.
//!
//! Answers are about the boxes as they are now, without margins. Objects that have changed since the last step or
//! [refresh](World::refresh) are looked at one by one, and so are all objects before the first one with a tree. All numbers are computed in `f64`
//! from the boxes' `f32`, in operations that keep the order of their operands. So whatever the tree rules out, the
//! exact test would too.

// In the order of use, in which the documentation lists the methods.
mod region;

mod volume;

mod cast;

mod nearest;

mod among;

mod batch;

pub use among::Among;
pub use cast::{Cast, Hit};
pub use region::Region;
pub use volume::{Planes, Side, Volume};

use crate::access::{Access, bits};
use crate::geometry::aabb::narrowed;
use crate::geometry::key::{KeyBox, key};
use crate::id::{Id, Index};
use crate::memory::prefetch::RECORDS_AHEAD;
use crate::memory::slab::Parts;
use crate::simd::{EIGHT, Simd, limit};
use crate::tree::large::Large;
use crate::tree::{ChunksOfEight, Frame, Record, SUB_LEAVES, first_of_eight, sub_leaves_of};
use crate::world::World;

impl<I: Index> World<'_, I> {
    /// Whether the tree holds every object that has not changed since the last step.
    pub(crate) fn has_tree(&self) -> bool {
        self.parts.state.tree.filled != 0
    }

    /// Whether there may be objects that the tree does not know. Asked first, since it takes less than an empty iterator.
    fn has_apart(&self) -> bool {
        !self.has_tree() || self.parts.state.objects.dirty != 0
    }

    /// The large objects in the tree; `None` if there are none.
    fn large_objects(&self) -> Option<Large<'_>> {
        let tree = &self.parts.state.tree;
        (self.has_tree() && tree.large > 0).then(|| Large::new(tree, self.parts.tree.straddlers))
    }

    /// The slots that the tree does not know: all, or those that have changed since the last step.
    fn apart_from_tree(&self) -> impl Iterator<Item = usize> + '_ {
        let (has_tree, dirty) = (self.has_tree(), self.parts.state.objects.dirty != 0);
        let all = 0..if has_tree { 0 } else { self.parts.state.objects.slots as usize };
        let moved = (has_tree && dirty).then(|| self.parts.moved.slots());
        all.chain(moved.into_iter().flatten()).filter(|&slot| !self.parts.boxes.now.at(slot).is_empty())
    }

    /// The large objects, those that have changed aside.
    pub(crate) fn large_in_tree(&self) -> impl Iterator<Item = usize> + '_ {
        let large = self.large_objects().map_or(&[][..], |large| large.list);
        large.iter().map(|straddler| straddler.slot as usize).filter(|&slot| is_current(&self.parts, slot))
    }

    /// The id of a living object.
    pub(crate) fn id_of(&self, slot: usize) -> Option<Id> {
        Id::new(slot as u32, self.parts.generations.at(slot))
    }
}

/// Whether the record of an object in the tree is up to date.
#[inline(always)]
fn is_current<I: Index>(parts: &Parts<'_, I>, slot: usize) -> bool {
    parts.state.objects.dirty == 0 || !bits::test(parts.moved.words, slot)
}

/// Looks for members of a leaf whose records touch that of a region.
///
/// Not an `Iterator`: its loop has to be inlined into that of its caller, to have its instruction set.
struct MembersNear<'q, S> {
    simd: S,
    /// The slots that have changed since the last step, if any.
    moved: &'q [u32],
    chunks_of_eight: ChunksOfEight<'q>,
    /// The region in the leaf's frame.
    region: Record,
    limit: Record,
    eight: &'q [Record; EIGHT],
    mask: u32,
}

impl<'q, S: Simd> MembersNear<'q, S> {
    #[inline(always)]
    fn new<I: Index>(simd: S, parts: &'q Parts<'_, I>, leaf: usize, region: Record) -> Self {
        const NONE: &[Record; EIGHT] = &[Record { lanes: [0; 6], tag: 0 }; EIGHT];
        let bucket = parts.tree.leaves.at(leaf);
        let chunks_of_eight = bucket.chunks_of_eight(parts.tree.records);
        let moved = if parts.state.objects.dirty != 0 { &*parts.moved.words } else { &[] };
        Self { simd, moved, chunks_of_eight, region, limit: limit(&region), eight: NONE, mask: 0 }
    }

    /// The slot of the next one, and whether its swept box certainly overlaps the region.
    #[inline(always)]
    fn next(&mut self) -> Option<(usize, bool)> {
        loop {
            while self.mask == 0 {
                let (eight, left) = self.chunks_of_eight.next()?;
                self.mask = self.simd.touching(eight, self.limit);
                if self.mask != 0 {
                    self.mask &= first_of_eight(left);
                }
                self.eight = eight;
            }
            let record = self.eight.at(self.mask.trailing_zeros() as usize);
            self.mask &= self.mask - 1;
            let contact = self.simd.contact(&self.region, &record);
            let slot = record.slot() as usize;
            if contact.touches && (self.moved.is_empty() || !bits::test(self.moved, slot)) {
                return Some((slot, !contact.tied));
            }
        }
    }
}

/// A region in the frame of a whole leaf, and which of its sub-leaves the region touches; bit zero if the leaf is not
/// divided.
#[inline(always)]
fn parts_near<S: Simd, I: Index>(
    simd: S,
    parts: &Parts<'_, I>,
    whole: usize,
    region: &KeyBox,
) -> (Record, u32) {
    let frame = parts.tree.frames.get(whole).unwrap_or(&Frame::NONE);
    let region = simd.record(frame, simd.keys(region), 0);
    let bounds = sub_leaves_of(parts.tree.bounds, parts.state.tree.sub_levels(), whole);
    (region, bounds.map_or(1, |bounds| simd.touching(bounds, limit(&region))))
}

/// Prefetches what tells which sub-leaves of a whole leaf to look at.
#[inline(always)]
fn prefetch_parts<S: Simd, I: Index>(simd: S, parts: &Parts<'_, I>, whole: usize) {
    simd.prefetch(parts.tree.frames, whole);
    let first = whole << parts.state.tree.sub_levels();
    simd.prefetch_from::<SUB_LEAVES, _>(parts.tree.bounds, first);
    simd.prefetch_from::<SUB_LEAVES, _>(parts.tree.leaves, first);
}

/// Prefetches the first members of a leaf; the processor sees for itself that the others follow.
#[inline(always)]
fn prefetch_members<S: Simd, I: Index>(simd: S, parts: &Parts<'_, I>, leaf: usize) {
    simd.prefetch_from::<RECORDS_AHEAD, _>(parts.tree.records, parts.tree.leaves.at(leaf).start as usize);
}

/// The key of the greatest `f32` that is not above a number.
#[inline(always)]
fn key_below(x: f64) -> i32 {
    key(narrowed(x))
}

/// The key of the least `f32` that is not below a number.
#[inline(always)]
fn key_above(x: f64) -> i32 {
    key(-narrowed(-x))
}
