//! Divides leaves into eight sub-leaves in calm worlds, for steps and queries that look at a few objects here
//! and there. Each step divides some, so that none takes long.
//!
//! Sub-leaves share the frame of their leaf, and have [bounds](Record::include) in it: eight records that are
//! tested at once, in place of three levels of nodes.
//!
//! Meanwhile a leaf that is not divided yet is at the number of its first sub-leaf, and the other seven are
//! empty. Divided leaves have no straddlers: only a full step gathers ghosts.

use super::cells::{divide, evenly};
use super::limits::{DIVIDED_AT_LEAST, DIVIDED_SHARE, SUB_SAMPLE};
use super::{Cell, Leaf, Record, SUB_LEAVES, UNSPLIT, plane, renumber, sub_leaf_of};
use crate::access::Access;
use crate::filter::offer;
use crate::geometry::key::{KeyBox, length};
use crate::id::Index;
use crate::memory::limits::SUB_LEVELS;
use crate::memory::slab::{Parts, TreeParts};
use crate::simd::Simd;
use crate::sort::heapsort;

/// Divides some leaves that are not divided yet.
#[inline(always)]
pub(crate) fn subdivide<S: Simd, I: Index>(simd: S, parts: &mut Parts<'_, I>) {
    if parts.state.tree.subdivided == 0 {
        number_anew(parts);
    }
    let mut left = (parts.state.objects.live / DIVIDED_SHARE).max(DIVIDED_AT_LEAST);
    while left > 0 && parts.state.tree.subdivided <= parts.state.tree.count {
        let whole = parts.state.tree.subdivided as usize - 1;
        // An empty leaf takes time too.
        left = left.saturating_sub(parts.tree.leaves.at(whole * SUB_LEAVES).len + 1);
        divide_leaf(simd, parts, whole);
        parts.state.tree.subdivided += 1;
    }
}

/// Gives each leaf the number of its first sub-leaf. O(slots).
fn number_anew<I: Index>(parts: &mut Parts<'_, I>) {
    let leaves = parts.state.tree.count as usize;
    parts.state.tree.subdivided = 1;
    let slots = parts.state.objects.slots as usize;
    renumber(parts.home.span_mut(0, slots), |leaf| leaf << SUB_LEVELS);
    let tree = &mut parts.tree;
    // From the back, so that each is read before it is overwritten.
    for index in (0..leaves).rev() {
        let first = index * SUB_LEAVES;
        let (cell, leaf) = (tree.cells.at(index), tree.leaves.at(index));
        let end = Leaf { start: leaf.start + leaf.room, ..Leaf::default() };
        tree.cells.span_mut(first, SUB_LEAVES).fill(Cell::NOWHERE);
        tree.leaves.span_mut(first, SUB_LEAVES).fill(end);
        tree.cells.put(first, cell);
        tree.leaves.put(first, leaf);
        tree.bounds.span_mut(first, SUB_LEAVES).fill(Record::NOTHING);
        tree.bounds.put(first, Record::EVERYTHING);
    }
}

/// Makes the planes of the sub-leaves of a leaf: medians on the longest axis of a sample of its members.
// Not inline: its sample would stand on the stack of the whole step.
#[inline(never)]
fn make_planes(tree: &mut TreeParts<'_>, boxes: &[KeyBox], leaf: &Leaf, whole: usize) {
    let members = leaf.members(tree.records);
    let (mut sample, mut count) = ([[0; 3]; SUB_SAMPLE], 0);
    let of = |at| KeyBox::of(boxes, members.at(at).slot() as usize);
    let some = evenly(members.len(), SUB_SAMPLE).map(of);
    // Without the objects that have gone since.
    for (min, bounds) in sample.iter_mut().zip(some.filter(|bounds| !bounds.is_empty())) {
        *min = bounds.min;
        count += 1;
    }
    for node in 1..SUB_LEAVES {
        let level = node.ilog2();
        let [start, middle, end] =
            [0, 1, 2].map(|half| (count * (2 * (node - (1 << level)) + half)) >> (level + 1));
        let part = sample.span_mut(start, end - start);
        let mut extent = KeyBox::EMPTY;
        part.iter().for_each(|min| extent.include(&KeyBox::point(*min)));
        let side = |k: usize| length(extent.min[k % 3], extent.max[k % 3]);
        let axis = (1..3).fold(0, |best, k| if side(k) > 1.25 * side(best) { k } else { best });
        heapsort(part, |a, b| a[axis % 3] < b[axis % 3]);
        let (low, here) = (sample.get(start), sample.get(middle));
        let divides = low.zip(here).filter(|(low, here)| middle < end && low[axis % 3] < here[axis % 3]);
        tree.planes
            .put(whole * SUB_LEAVES + node, divides.map_or(UNSPLIT, |(_, here)| plane(axis, here[axis % 3])));
    }
}

/// Divides one leaf. Its moved objects may be gone or anywhere else by now. They only have to be where their
/// homes and places say.
#[inline(always)]
fn divide_leaf<S: Simd, I: Index>(simd: S, parts: &mut Parts<'_, I>, whole: usize) {
    let first = whole * SUB_LEAVES;
    let leaf = parts.tree.leaves.at(first);
    let boxes = parts.boxes.swept();
    let tree = &mut parts.tree;
    make_planes(tree, boxes, &leaf, whole);
    divide(tree.planes.span(first, SUB_LEAVES), SUB_LEVELS, tree.cells.span_mut(first, SUB_LEAVES));
    let frame = tree.frames.at(whole);

    let count = leaf.len as usize;
    let slots = parts.spare.span_mut(0, count);
    let mut lens = [0u32; SUB_LEAVES];
    for (record, to) in leaf.members(tree.records).iter().zip(&mut *slots) {
        *to = I::from_slot(record.slot());
        let bounds = KeyBox::of(boxes, record.slot() as usize);
        let sub = sub_leaf_of(tree.planes, whole, &bounds.min);
        parts.home.put(to.at(), I::from_slot((first + sub) as u32));
        if let Some(len) = lens.get_mut(sub) {
            *len += 1;
        }
    }
    let spare = leaf.room - leaf.len;
    let mut start = leaf.start;
    for (sub, len) in lens.iter().enumerate() {
        let mut sub_leaf = tree.leaves.at(first + sub);
        // The last one gets what does not divide equally.
        let is_last = sub + 1 == SUB_LEAVES;
        let room = if is_last { leaf.start + leaf.room - start } else { len + spare / SUB_LEAVES as u32 };
        (sub_leaf.start, sub_leaf.len, sub_leaf.room) = (start, 0, room);
        (sub_leaf.straddler_start, sub_leaf.straddler_len) = (0, 0);
        start += sub_leaf.room;
        tree.leaves.put(first + sub, sub_leaf);
    }
    let mut bounds = [Record::NOTHING; SUB_LEAVES];
    for slot in &*slots {
        let index = parts.home.at(slot.at()).at();
        let mut sub_leaf = tree.leaves.at(index);
        let keys = simd.keys(KeyBox::of(boxes, slot.at()));
        let record = simd.record(&frame, keys, slot.slot());
        if let Some(bounds) = bounds.get_mut(index - first) {
            bounds.include(&record);
            bounds.tag |= offer(parts.filters.of, slot.at());
        }
        tree.records.put((sub_leaf.start + sub_leaf.len) as usize, record);
        parts.place.put(slot.at(), I::from_slot(sub_leaf.len));
        sub_leaf.len += 1;
        tree.leaves.put(index, sub_leaf);
    }
    tree.bounds.span_mut(first, SUB_LEAVES).copy_in(&bounds);
}

/// Goes back to whole leaves, which have to be filled. Returns whether leaves were divided.
pub(crate) fn merge<I: Index>(parts: &mut Parts<'_, I>) -> bool {
    let step = &mut parts.state.step;
    step.was_calm = if step.calm > 0 { step.calm } else { step.was_calm };
    step.calm = 0;
    if parts.state.tree.subdivided == 0 {
        return false;
    }
    parts.state.tree.subdivided = 0;
    renumber(parts.home, |leaf| leaf >> SUB_LEVELS);
    for index in 0..parts.state.tree.count as usize {
        let leaf = parts.tree.leaves.at(index * SUB_LEAVES);
        parts.tree.leaves.put(index, leaf);
    }
    true
}
