//! Makes planes: divides a leaf in place, then its parts (paper, III.A; errata E10, E11, E13, E14, E17).
//!
//! A plane is at the median minimum of a sample, on the axis that parts the sample best. The paper keeps
//! three sorted lists of all objects for exact medians. Those of samples make leaves that are nearly as even,
//! and need no sort. O(n log n) in all.

use super::cells::evenly;
use super::large::is_thin;
use super::limits::{AXIS_SAMPLE, CROSSING, LOPSIDED, SAMPLED_FROM, SAMPLED_SHARE};
use super::shape::set_leaf;
use super::{AXIS, Leaf, Record, Split, UNSPLIT, axis_of, key_of, plane};
use crate::access::{Access, note_fault};
use crate::geometry::key::{KeyBox, length};
use crate::id::Index;
use crate::memory::limits::LEVELS;
use crate::memory::slab::Parts;
use crate::sort::select;
use arrayvec::ArrayVec;

/// Divides a leaf until its parts have at most so many members. They are where all records were, before where
/// the leaf starts; behind all members is scratch memory. The part with the lowest minima keeps the number of
/// the leaf. Returns whether there was room for all parts.
pub(super) fn divide<I: Index>(parts: &mut Parts<'_, I>, index: usize, most: u64) -> bool {
    let Parts { tree, state, boxes, sizes, .. } = parts;
    let (boxes, state) = (boxes.swept(), &mut state.tree);
    let leaf = tree.leaves.at(index);
    let (len, top) = (leaf.len as usize, tree.tops.at(index) as usize);
    // One more than exact medians would take.
    let levels = u64::from(leaf.len).div_ceil(most.max(1)).next_power_of_two().trailing_zeros() + 1;
    if (tree.nodes().depth(top) + levels) as usize >= LEVELS {
        return false;
    }
    // Two lists, a sample, and behind them a key of each of that.
    let keys = tree.records.len() - AXIS_SAMPLE.min(sizes.objects).div_ceil(4);
    let (lists, keys) = tree.records.split_at_mut_checked(keys).unwrap_or_default();
    let keys = bytemuck::try_cast_slice_mut(keys).unwrap_or_default();
    let (list, rest) = as_slots::<I>(lists).split_at_mut_checked(sizes.objects).unwrap_or_default();
    let (spare, sample) = rest.split_at_mut_checked(sizes.objects).unwrap_or_default();
    let list = list.span_mut(leaf.start as usize - len, len);
    let share = if len < SAMPLED_FROM { 1 } else { SAMPLED_SHARE };
    for at in 0..len / share {
        list.put(at, list.at(at * share));
    }
    let (mut number, mut free, mut fits) = (index, state.count as usize, true);
    let mut waiting = ArrayVec::<[usize; 4], LEVELS>::new();
    let mut here = Some([top, levels as usize, 0, len / share]);
    while let Some([node, levels, start, len]) = here {
        let part = list.span_mut(start, len);
        let is_full = levels > 0 && (len * share) as u64 > most;
        let mut plane = UNSPLIT;
        if is_full {
            let mut count = 0;
            for (to, at) in sample.iter_mut().zip(evenly(len, AXIS_SAMPLE)) {
                (*to, count) = (part.at(at), count + 1);
            }
            plane = best_plane(boxes, sample.span(0, count), keys.span_mut(0, count));
        }
        let pair = state.count as usize;
        if plane != UNSPLIT && pair < tree.parents.len() {
            state.count += 1;
            tree.splits.put(node, Split { plane, below: 2 * pair as u32 });
            tree.parents.put(pair, node as u32);
            let below = divide_list(boxes, part, spare, plane);
            if waiting.try_push([2 * pair + 1, levels - 1, start + below, len - below]).is_err() {
                note_fault(boxes.as_ptr().addr());
            }
            here = Some([2 * pair, levels - 1, start, below]);
            continue;
        }
        fits &= plane == UNSPLIT;
        let stuck = if is_full { (len * share) as u32 } else { 0 };
        tree.leaves.put(number, if number == index { leaf } else { Leaf::default() });
        tree.stuck.put(number, stuck);
        set_leaf(tree.splits, tree.tops, node, number);
        number = free;
        free += 1;
        here = waiting.pop();
    }
    fits
}

/// The memory of records as a list of slots.
pub(super) fn as_slots<I: Index>(records: &mut [Record]) -> &mut [I] {
    bytemuck::try_cast_slice_mut(records).unwrap_or_default()
}

/// Brings the objects below a plane to the front of a list; returns how many. Both parts keep their order.
fn divide_list<I: Index>(boxes: &[KeyBox], list: &mut [I], spare: &mut [I], plane: i32) -> usize {
    let (mut below, mut above) = (0, 0);
    for at in 0..list.len() {
        let slot = list.at(at);
        let is_above = KeyBox::of(boxes, slot.at()).min[axis_of(plane)] >= key_of(plane);
        // Both are written, since a branch here would be guessed wrong half of the time.
        list.put(below, slot);
        spare.put(above, slot);
        below += usize::from(!is_above);
        above += usize::from(is_above);
    }
    list.span_mut(below, above).copy_in(spare.span(0, above));
    below
}

/// The plane that parts a sample of objects best, or [`UNSPLIT`]. There is room for a key of each.
fn best_plane<I: Index>(boxes: &[KeyBox], sample: &[I], keys: &mut [i32]) -> i32 {
    let count = sample.len();
    let mut best = (usize::MAX, UNSPLIT);
    // If many minima equal the median, or too many boxes cross the planes there, quarters may be better.
    for position in [count / 2, count / 4, count - count / 4] {
        for axis in 0..3 {
            let (mut first, mut last) = (i32::MAX, i32::MIN);
            for (key, slot) in keys.iter_mut().zip(sample) {
                *key = KeyBox::of(boxes, slot.at()).min[axis];
                (first, last) = (first.min(*key), last.max(*key));
            }
            // At the position, or the next one that has objects on both sides.
            select(keys, position, &|a, b| a < b);
            if let Some(key) = keys.iter().skip(position).filter(|key| **key & !AXIS > first).min() {
                let found = crossing(boxes, sample, plane(axis, *key), length(first, last) / 2.0);
                best = if found.0 < best.0 { found } else { best };
            }
        }
        if best.0 < count {
            break;
        }
    }
    best.1
}

/// How many boxes of a sample cross a plane; more if it is lopsided, and the greatest number if too many do.
/// Four thin ones that go `far` beyond it count as one: they become large objects, which cost little. And the
/// plane, which goes to the middle of a gap below it: there, boxes that grow a little do not cross it.
fn crossing<I: Index>(boxes: &[KeyBox], sample: &[I], plane: i32, far: f32) -> (usize, i32) {
    let (axis, key) = (axis_of(plane), key_of(plane));
    let (mut below, mut quarters, mut end) = (0, 0, i32::MIN);
    for slot in sample {
        let bounds = KeyBox::of(boxes, slot.at());
        let [low, high] = [bounds.min[axis], bounds.max[axis]];
        (below, end) = if low < key { (below + 1, end.max(high)) } else { (below, end) };
        if low < key && high >= key {
            quarters += if length(key, high) > far && is_thin(bounds) { 1 } else { 4 };
        }
    }
    let (all, half_gap) = (sample.len(), key - key.midpoint(end.min(key)));
    let cost = match quarters / 4 {
        crossing if crossing * CROSSING > below => usize::MAX,
        // Lopsided: any other plane is better.
        crossing if below.min(all - below) < all / LOPSIDED => all + crossing,
        crossing => crossing,
    };
    (cost, plane - (half_gap & !AXIS))
}
