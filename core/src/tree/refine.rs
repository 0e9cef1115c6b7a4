//! Divides the leaves of calm worlds, for steps and queries that look at a few objects here and there: some in each step,
//! so that none takes long.
//!
//! While that goes on, a leaf that is still whole stands where the first one of its parts will stand: planes that nobody is
//! above yet are as good as planes that nobody reaches. The leaves have no fronts: only a full step gathers visitors.

use super::assign::{extend, raise};
use super::cells::{divide, frame};
use super::{Cell, Frame, Leaf, below};
use crate::access::Access;
use crate::arch::{Phase, Simd};
use crate::id::Index;
use crate::key::KeyBox;
use crate::layout::FINER;
use crate::storage::Parts;

/// Leaves that a leaf is divided into.
const PARTS: usize = 1 << FINER;
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
        while left > 0 && parts.state.refined <= 1 << parts.state.swept_depth {
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
    parts.state.swept_depth = depth;
    parts.state.depth = depth + FINER;
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
        let (cell, frame, leaf) = (tree.cells.at(index), tree.frames.at(index), tree.leaves.at(index));
        let end = Leaf { start: leaf.start + leaf.room, ..Leaf::default() };
        tree.cells.span_mut(first, PARTS).fill(Cell::NOWHERE);
        tree.frames.span_mut(first, PARTS).fill(Frame::default());
        tree.leaves.span_mut(first, PARTS).fill(end);
        tree.cells.put(first, cell);
        tree.frames.put(first, frame);
        tree.leaves.put(first, leaf);
        let reach = tree.reach.at(leaves + index);
        for level in 1..=FINER {
            let first = (leaves + index) << level;
            tree.reach.span_mut(first, 1 << level).fill([i32::MIN; 3]);
            tree.reach.put(first, reach);
        }
    }
}

/// Divides one leaf. Moved objects may be gone or anywhere; they only have to stand where their homes and places say.
#[inline(always)]
fn divide_leaf<S: Simd, I: Index>(simd: S, parts: &mut Parts<'_, I>, whole: usize) {
    let extent = parts.state.extent();
    let node = (1usize << parts.state.swept_depth) + whole;
    let first = whole * PARTS;
    let leaf = parts.tree.leaves.at(first);
    let boxes = if parts.boxes.fat.is_empty() { &*parts.boxes.now } else { &*parts.boxes.fat };
    let tree = &mut parts.tree;
    divide(tree.planes, node, FINER, tree.cells.span_mut(first, PARTS));
    let cells = tree.cells.span(first, PARTS);
    frame(cells, &extent, tree.frames.span_mut(first, PARTS), tree.leaves.span_mut(first, PARTS));

    // The slots, and which part each goes to, stand in lists that are made anew when they are needed.
    parts.state.stale_lists = 1;
    let [_, slots, goals] = &mut parts.order;
    let count = leaf.len as usize;
    let (slots, goals) = (slots.span_mut(0, count), goals.span_mut(0, count));
    let mut lens = [0u32; PARTS];
    let mut reaches = [[i32::MIN; 3]; PARTS];
    for (ahead, record) in tree.records.span(leaf.start as usize, count).iter().enumerate() {
        slots.put(ahead, I::from_slot(record.slot()));
        simd.prefetch(KeyBox::of(boxes, record.slot() as usize));
    }
    for (slot, goal) in slots.iter().zip(&mut *goals) {
        let bounds = KeyBox::of(boxes, slot.at());
        let part = part_of(tree.planes, node, &bounds.min);
        *goal = I::from_slot(part as u32);
        if let Some(len) = lens.get_mut(part) {
            *len += 1;
        }
        let mut reach = reaches.at(part);
        extend(&mut reach, &bounds.max);
        reaches.put(part, reach);
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
    for (slot, goal) in slots.iter().zip(&*goals) {
        let index = first + goal.at();
        let mut bag = tree.leaves.at(index);
        let keys = simd.keys(KeyBox::of(boxes, slot.at()));
        let record = simd.record(&tree.frames.at(index), keys, slot.slot());
        tree.records.put((bag.start + bag.len) as usize, record);
        parts.home.put(slot.at(), I::from_slot(index as u32));
        parts.place.put(slot.at(), I::from_slot(bag.len));
        bag.len += 1;
        tree.leaves.put(index, bag);
    }
    for level in (1..=FINER).rev() {
        for index in 0..1usize << level {
            tree.reach.put((node << level) + index, reaches.at(index));
        }
        for index in 0..1usize << (level - 1) {
            let mut reach = reaches.at(2 * index);
            extend(&mut reach, &reaches.at(2 * index + 1));
            reaches.put(index, reach);
        }
    }
    // The node itself, and those above, may reach farther than need be; but no less far than an object that has moved and
    // is here until it is brought to its leaf.
    raise(tree.reach, node, &reaches.at(0));
}

/// Which part of a node holds a minimum corner.
#[inline(always)]
fn part_of(planes: &[i32], node: usize, min: &[i32; 3]) -> usize {
    below(planes, node, FINER, min) - node * PARTS
}

/// Goes back to the leaves of the last full step, which have to be filled. Tells whether there was anything to do.
pub(crate) fn coarsen<I: Index>(parts: &mut Parts<'_, I>) -> bool {
    parts.state.calm = 0;
    if parts.state.refined == 0 {
        return false;
    }
    parts.state.refined = 0;
    let levels = parts.state.depth - parts.state.swept_depth;
    parts.state.depth = parts.state.swept_depth;
    ascend(parts.home, levels);
    for index in 0..1usize << parts.state.depth {
        let leaf = parts.tree.leaves.at(index << levels);
        parts.tree.leaves.put(index, leaf);
    }
    true
}

/// Makes homes of the leaves of some levels above.
pub(crate) fn ascend<I: Index>(homes: &mut [I], levels: u32) {
    for home in homes {
        if *home < I::LARGE {
            *home = I::from_slot(home.slot() >> levels);
        }
    }
}
