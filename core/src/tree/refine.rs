//! Divides the leaves of calm worlds, for steps and queries that look at a few objects here and there: some in each step,
//! so that none takes long.
//!
//! The parts of a leaf keep its frame, and have [bounds](Record::include) in it, eight records that are tested at once in place
//! of three levels of nodes.
//!
//! While that goes on, a leaf that is still whole stands where the first one of its parts will stand: planes that nobody is
//! above yet are as good as planes that nobody reaches. The leaves have no fronts: only a full step gathers visitors.

use super::cells::divide;
use super::{Cell, Leaf, PARTS, Record, part_of};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::FINER;
use crate::memory::slab::Parts;
use crate::simd::{Phase, Simd};

/// Members of the leaves that are divided in one step: one in so many objects, and at least so many.
const SHARE_PER_STEP: u32 = 64;
const LEAST_PER_STEP: u32 = 1024;

/// Divides some leaves, if there are any left that are whole.
pub(crate) struct Refine<'p, 'm, I>(pub(crate) &'p mut Parts<'m, I>);

impl<I: Index> Phase for Refine<'_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let parts = self.0;
        if parts.state.refined == 0 {
            number_anew(parts);
        }
        let mut left = (parts.state.live / SHARE_PER_STEP).max(LEAST_PER_STEP);
        while left > 0 && parts.state.refined <= 1 << parts.state.depth {
            let whole = parts.state.refined as usize - 1;
            // An empty leaf takes its time too.
            left = left.saturating_sub(parts.tree.leaves.at(whole * PARTS).len + 1);
            divide_leaf(simd, parts, whole);
            parts.state.refined += 1;
        }
    }
}

/// Gives whole leaves the numbers of their first parts. O(slots).
fn number_anew<I: Index>(parts: &mut Parts<'_, I>) {
    let depth = parts.state.depth;
    let leaves = 1usize << depth;
    parts.state.refined = 1;
    for home in parts.home.span_mut(0, parts.state.slots as usize) {
        if *home < I::LARGE {
            *home = I::from_slot(home.slot() << FINER);
        }
    }
    let tree = &mut parts.tree;
    // From the back, so that each is read before its place is taken.
    for index in (0..leaves).rev() {
        let first = index * PARTS;
        let (cell, leaf) = (tree.cells.at(index), tree.leaves.at(index));
        let end = Leaf { start: leaf.start + leaf.room, ..Leaf::default() };
        tree.cells.span_mut(first, PARTS).fill(Cell::NOWHERE);
        tree.leaves.span_mut(first, PARTS).fill(end);
        tree.cells.put(first, cell);
        tree.leaves.put(first, leaf);
        tree.bounds.span_mut(first, PARTS).fill(Record::NOTHING);
        tree.bounds.put(first, Record::EVERYTHING);
    }
}

/// Divides one leaf. Moved objects may be gone or anywhere; they only have to stand where their homes and places say.
#[inline(always)]
fn divide_leaf<S: Simd, I: Index>(simd: S, parts: &mut Parts<'_, I>, whole: usize) {
    let node = (1usize << parts.state.depth) + whole;
    let first = whole * PARTS;
    let leaf = parts.tree.leaves.at(first);
    let boxes = if parts.boxes.fat.is_empty() { &*parts.boxes.now } else { &*parts.boxes.fat };
    let tree = &mut parts.tree;
    divide(tree.planes, node, FINER, tree.cells.span_mut(first, PARTS));
    let frame = tree.frames.at(whole);

    // The slots, and which part each goes to, stand in lists that are made anew when they are needed.
    parts.state.stale_lists = 1;
    let [_, slots, goals] = &mut parts.order;
    let count = leaf.len as usize;
    let (slots, goals) = (slots.span_mut(0, count), goals.span_mut(0, count));
    let mut lens = [0u32; PARTS];
    for (ahead, record) in tree.records.span(leaf.start as usize, count).iter().enumerate() {
        slots.put(ahead, I::from_slot(record.slot()));
        simd.prefetch(boxes, record.slot() as usize);
    }
    for (slot, goal) in slots.iter().zip(&mut *goals) {
        let bounds = KeyBox::of(boxes, slot.at());
        let part = part_of(tree.planes, node, &bounds.min);
        *goal = I::from_slot(part as u32);
        if let Some(len) = lens.get_mut(part) {
            *len += 1;
        }
    }
    let spare = leaf.room - leaf.len;
    let mut start = leaf.start;
    for (part, len) in lens.iter().enumerate() {
        let mut bag = tree.leaves.at(first + part);
        // What cannot be shared equally goes to the last one.
        let share =
            if part + 1 == PARTS { leaf.start + leaf.room - start - len } else { spare / PARTS as u32 };
        (bag.start, bag.len, bag.room) = (start, 0, len + share);
        (bag.front_start, bag.front_len) = (0, 0);
        start += bag.room;
        tree.leaves.put(first + part, bag);
    }
    let mut bounds = [Record::NOTHING; PARTS];
    for (slot, goal) in slots.iter().zip(&*goals) {
        let index = first + goal.at();
        let mut bag = tree.leaves.at(index);
        let keys = simd.keys(KeyBox::of(boxes, slot.at()));
        let record = simd.record(&frame, keys, slot.slot());
        if let Some(bounds) = bounds.get_mut(goal.at()) {
            bounds.include(&record);
        }
        tree.records.put((bag.start + bag.len) as usize, record);
        parts.home.put(slot.at(), I::from_slot(index as u32));
        parts.place.put(slot.at(), I::from_slot(bag.len));
        bag.len += 1;
        tree.leaves.put(index, bag);
    }
    tree.bounds.span_mut(first, PARTS).copy_in(&bounds);
}

/// Goes back to the leaves of the last full step, which have to be filled. Tells whether there was anything to do.
pub(crate) fn coarsen<I: Index>(parts: &mut Parts<'_, I>) -> bool {
    parts.state.calm = 0;
    if parts.state.refined == 0 {
        return false;
    }
    parts.state.refined = 0;
    ascend(parts.home, FINER);
    for index in 0..1usize << parts.state.depth {
        let leaf = parts.tree.leaves.at(index * PARTS);
        parts.tree.leaves.put(index, leaf);
    }
    true
}

/// Makes homes of the first leaves of some levels below: whoever is not at home there finds out when the leaves are counted.
pub(crate) fn descend<I: Index>(homes: &mut [I], levels: u32) {
    for home in homes {
        if *home < I::LARGE {
            *home = I::from_slot(home.slot() << levels);
        }
    }
}

/// Makes homes of the leaves of some levels above.
pub(crate) fn ascend<I: Index>(homes: &mut [I], levels: u32) {
    for home in homes {
        if *home < I::LARGE {
            *home = I::from_slot(home.slot() >> levels);
        }
    }
}
