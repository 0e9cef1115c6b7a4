//! Divides leaves into eight sub-leaves in calm worlds, for steps and queries that look at a few objects here
//! and there. Each step divides some, so that none takes long.
//!
//! Sub-leaves share the frame of their leaf, and have [bounds](Record::include) in it: eight records that are
//! tested at once, in place of three levels of nodes.
//!
//! Meanwhile a leaf that is not divided yet is at the number of its first sub-leaf, and the other seven are
//! empty. Nobody reads the straddlers meanwhile: only a full step gathers ghosts.

use super::cells::evenly;
use super::limits::{DIVIDED_AT_LEAST, DIVIDED_SHARE, SUB_SAMPLE};
use super::{Leaf, Record, SUB_LEAVES, UNSPLIT, plane, renumber, sub_leaf_of};
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
        let leaf = tree.leaves.at(index);
        let end = Leaf { start: leaf.start + leaf.room, ..Leaf::default() };
        tree.leaves.span_mut(first, SUB_LEAVES).fill(end);
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
    let frame = tree.frames.at(whole);

    let members = tree.records.span_mut(leaf.start as usize, leaf.len as usize);
    let mut ends = [0; SUB_LEAVES];
    for slot in members.iter().map(|record| record.slot() as usize) {
        let sub = sub_leaf_of(tree.planes, whole, &KeyBox::of(boxes, slot).min);
        parts.home.put(slot, I::from_slot((first + sub) as u32));
        let members = ends.at(sub) + 1;
        ends.put(sub, members);
    }
    let lens = ends;
    let (mut next, mut start) = ([0; SUB_LEAVES], 0);
    for (next, end) in next.iter_mut().zip(&mut ends) {
        *next = start;
        start += *end;
        *end = start;
    }
    // Each record changes places with the next one of its sub-leaf.
    for (sub, end) in ends.iter().enumerate() {
        while next.at(sub) < *end {
            let at = next.at(sub);
            let home = parts.home.at(members.at(at).slot() as usize).at() % SUB_LEAVES;
            // It ends, whatever the memory holds.
            let home = if next.at(home) < ends.at(home) { home } else { sub };
            let place = next.at(home);
            members.swap_at(at, place);
            next.put(home, place + 1);
        }
    }
    // The last one first, as records move up: each gets an equal share of the free room, the last one the rest.
    let share = (leaf.room - leaf.len) as usize / SUB_LEAVES;
    let mut end = (leaf.start + leaf.room) as usize;
    for sub in (0..SUB_LEAVES).rev() {
        let (len, mut bounds) = (lens.at(sub), Record::NOTHING);
        let from = leaf.start as usize + ends.at(sub) - len;
        let start = from + sub * share;
        for place in (0..len).rev() {
            let slot = tree.records.at(from + place).slot();
            let keys = simd.keys(KeyBox::of(boxes, slot as usize));
            let record = simd.record(&frame, keys, slot);
            bounds.include(&record);
            bounds.tag |= offer(parts.filters.of, slot as usize);
            tree.records.put(start + place, record);
            parts.place.put(slot as usize, I::from_slot(place as u32));
        }
        let [start, len, room] = [start, len, end - start].map(|count| count as u32);
        tree.leaves.put(first + sub, Leaf { start, len, room });
        tree.bounds.put(first + sub, bounds);
        end = start as usize;
    }
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
