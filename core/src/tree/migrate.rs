//! Moves the records of all objects that have left their leaf at once: finds their new leaves, takes them out of the old ones, gives
//! them places in the new ones, and writes their records there.
//!
//! Workers share what looks at boxes. What changes leaves is done alone: it is short, and to share the leaves between two workers
//! gained nothing.

use super::relocate::{Relocate, withdraw};
use super::{Cell, Frame, Leaf, Record, leaf_of};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::LEAVERS_PER_BLOCK;
use crate::memory::prefetch::LEAVERS_AHEAD;
use crate::memory::slab::Parts;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::parallel::shared::Shared;
use crate::simd::{Phase, Simd};

/// Brings the first objects in the second of the sorted lists, as many as said, to their leaves or to the large objects; an object
/// may stand there twice. Returns whether there was room, as [`Relocate`]. Leaves are not divided.
pub(crate) fn migrate<I: Index>(parts: &mut Parts<'_, I>, count: usize, context: StepContext<'_>) -> bool {
    find_targets(parts, count, context);
    take_out(parts, count);
    let left = give_places(parts, count);
    write_records(parts, count, context);
    // Large and removed objects, and those whose new leaf is full.
    for index in 0..left {
        let slot = parts.order[0].at(index);
        parts.order[1].put(index, slot);
    }
    left == 0 || context.kernels.run(Relocate(parts, left))
}

/// Works on blocks of objects and of their new leaves.
fn each_block<I: Index>(
    slots: &[I],
    targets: &mut [I],
    context: StepContext<'_>,
    work: impl Fn(&[I], &mut [I]) + Sync,
) {
    let blocks = Chunks::new(targets.span_mut(0, slots.len()), LEAVERS_PER_BLOCK);
    context.each(blocks, |block, targets| {
        work(slots.span(block * LEAVERS_PER_BLOCK, targets.len()), targets);
    });
}

/// Writes the new leaf of each object to the third of the sorted lists; [`Index::LARGE`] if it is to be moved by itself.
fn find_targets<I: Index>(parts: &mut Parts<'_, I>, count: usize, context: StepContext<'_>) {
    let [_, slots, targets] = &mut parts.order;
    let slots = slots.span(0, count);
    let (boxes, home, place) = (parts.boxes.swept(), &*parts.home, &*parts.place);
    let (planes, depth, cells) = (&*parts.tree.planes, parts.state.tree.depth, &*parts.tree.cells);
    each_block(slots, targets, context, |slots, targets| {
        context.kernels.run(FindTargets { slots, targets, boxes, home, place, planes, depth, cells });
    });
}

struct FindTargets<'t, I> {
    slots: &'t [I],
    targets: &'t mut [I],
    /// By slot, as the next.
    boxes: &'t [KeyBox],
    home: &'t [I],
    place: &'t [I],
    planes: &'t [i32],
    depth: u32,
    cells: &'t [Cell],
}

impl<I: Index> Phase for FindTargets<'_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { slots, targets, boxes, home, place, planes, depth, cells } = self;
        for (index, (slot, target)) in slots.iter().zip(targets).enumerate() {
            if let Some(later) = slots.get(index + LEAVERS_AHEAD) {
                simd.prefetch(boxes, later.at());
                simd.prefetch(home, later.at());
                simd.prefetch(place, later.at());
            }
            let bounds = boxes.at(slot.at());
            let leaf = leaf_of(planes, depth, &bounds.min);
            let is_large = cells.at(leaf).classify(simd, simd.keys(&bounds)).is_large();
            let alone = home.at(slot.at()) == I::LARGE || bounds.is_empty() || is_large;
            *target = if alone { I::LARGE } else { I::from_slot(leaf as u32) };
        }
    }
}

/// Takes the objects out of their leaves.
fn take_out<I: Index>(parts: &mut Parts<'_, I>, count: usize) {
    for index in 0..count {
        if parts.order[2].at(index) != I::LARGE {
            // The second time nothing happens: it has no leaf any more.
            withdraw(parts, parts.order[1].at(index).at());
        }
    }
}

/// Gives the objects places in their new leaves. Those that are to be moved by themselves come to the first of the sorted lists;
/// returns how many there are.
fn give_places<I: Index>(parts: &mut Parts<'_, I>, count: usize) -> usize {
    let Parts { order: [alone, slots, targets], home, place, tree, .. } = parts;
    let mut left = 0;
    for (slot, target) in slots.span(0, count).iter().zip(targets.span_mut(0, count)) {
        if *target != I::LARGE && home.at(slot.at()) != I::NONE {
            // It stands here for the second time.
            continue;
        }
        match tree.leaves.get_mut(target.at()) {
            Some(leaf) if leaf.len < leaf.room => {
                home.put(slot.at(), *target);
                place.put(slot.at(), I::from_slot(leaf.len));
                leaf.len += 1;
            }
            _ => {
                *target = I::LARGE;
                alone.put(left, *slot);
                left += 1;
            }
        }
    }
    left
}

/// Writes the records of the objects that have places.
fn write_records<I: Index>(parts: &mut Parts<'_, I>, count: usize, context: StepContext<'_>) {
    let [_, slots, targets] = &mut parts.order;
    let slots = slots.span(0, count);
    let (boxes, place) = (parts.boxes.swept(), &*parts.place);
    let (cells, frames, leaves) = (&*parts.tree.cells, &*parts.tree.frames, &*parts.tree.leaves);
    let records = Shared::new(parts.tree.records);
    each_block(slots, targets, context, |slots, targets| {
        context.kernels.run(WriteRecords { slots, targets, boxes, place, cells, frames, leaves, records });
    });
}

struct WriteRecords<'t, 's, I> {
    slots: &'t [I],
    targets: &'t [I],
    /// By slot, as the next.
    boxes: &'t [KeyBox],
    place: &'t [I],
    cells: &'t [Cell],
    frames: &'t [Frame],
    leaves: &'t [Leaf],
    records: Shared<'s, Record>,
}

impl<I: Index> Phase for WriteRecords<'_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { slots, targets, boxes, place, cells, frames, leaves, records } = self;
        for (slot, target) in slots.iter().zip(targets) {
            let (slot, leaf) = (slot.at(), target.at());
            if let (Some(cell), Some(frame), Some(leaf)) =
                (cells.get(leaf), frames.get(leaf), leaves.get(leaf))
            {
                let keys = simd.keys(KeyBox::of(boxes, slot));
                let record = simd.record(frame, keys, slot as u32 | cell.classify(simd, keys).marks());
                records.store(leaf.start as usize + place.at(slot).at(), &record);
            }
        }
    }
}
