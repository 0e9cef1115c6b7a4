//! Moves the records of moved objects to their leaves, one by one (paper, section III.B.2).

use super::enclose::expand_ancestors;
use super::{Cell, Frame, Leaf, Straddler, home_within, large, leaf_of, most};
use crate::access::Access;
use crate::filter::offer;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::MOVERS_PER_BLOCK;
use crate::memory::slab::Parts;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::simd::Simd;
use crate::simd::kernels::run;

/// Leaves behind a full one that are asked for room.
const NEIGHBOURS: usize = 16;

/// Brings the objects in the first of the [thirds], as many as said, to their leaves or to the large objects.
/// Returns whether there was room. If a leaf or the list of large objects is full, or a third, nothing is
/// lost, but all leaves must be filled anew.
pub(crate) fn relocate_all<I: Index>(
    parts: &mut Parts<'_, I>,
    count: usize,
    context: StepContext<'_>,
) -> bool {
    let (boxes, all, tree, state) = (parts.boxes.swept(), &*parts.home, &parts.tree, &*parts.state);
    let [movers, leaves, _] = thirds(parts.spare);
    // Workers share the walks down the tree. The records move one by one.
    context.each(Chunks::new(leaves.span_mut(0, count), MOVERS_PER_BLOCK), |block, leaves| {
        for (slot, leaf) in movers.iter().skip(block * MOVERS_PER_BLOCK).zip(leaves) {
            let (min, home) = (&KeyBox::of(boxes, slot.at()).min, all.at(slot.at()));
            let holds = |cell: &Cell| (0..3).all(|k| (cell.low()[k]..cell.high()[k]).contains(&min[k]));
            let whole = home.at() >> state.tree.sub_levels();
            let stays = home < I::LARGE && tree.cells.get(whole).is_some_and(holds);
            let whole = if stays { whole } else { leaf_of((tree.splits, state.tree.height), min) };
            *leaf = I::from_slot(home_within(tree, state, whole, min) as u32);
        }
    });
    run!(context.kernels, |simd| {
        let fits = (0..count).all(|index| relocate(simd, parts, index));
        parts.state.tree.filled *= u8::from(fits);
        fits
    })
}

/// The scratch memory of a step as three lists: movers, the leaves of these, and movers in order.
pub(crate) fn thirds<I>(spare: &mut [I]) -> [&mut [I]; 3] {
    let mut thirds = spare.chunks_exact_mut((spare.len() / 3).max(1));
    [(); 3].map(|()| thirds.next().unwrap_or_default())
}

#[inline(always)]
fn relocate<S: Simd, I: Index>(simd: S, parts: &mut Parts<'_, I>, index: usize) -> bool {
    let [movers, leaves, _] = thirds(parts.spare);
    let (slot, leaf) = (movers.at(index).at(), leaves.at(index));
    let bounds = parts.boxes.swept().at(slot);
    let home = parts.home.at(slot);
    if bounds.is_empty() {
        withdraw(parts, slot);
        return true;
    }
    let (stays, leaf, keys) = (leaf == home, leaf.at(), simd.keys(&bounds));
    let sub_levels = parts.state.tree.sub_levels();
    let whole = leaf >> sub_levels;
    let classified = parts.tree.cells.at(whole).classify(simd, keys);
    if classified.is_large() {
        let mut place = parts.place.at(slot).at();
        if home != I::LARGE {
            withdraw(parts, slot);
            place = parts.state.tree.large as usize;
        }
        return large::put(parts, place, Straddler { bounds, slot: slot as u32, long: 0 });
    }
    if !stays {
        withdraw(parts, slot);
        let Leaf { len, room, .. } = parts.tree.leaves.at(leaf);
        if len == room && !borrow(parts, leaf) {
            return false;
        }
        parts.home.put(slot, I::from_slot(leaf as u32));
        parts.place.put(slot, I::from_slot(len));
        if let Some(leaf) = parts.tree.leaves.get_mut(leaf) {
            leaf.len = len + 1;
        }
    }
    let at = parts.tree.leaves.at(leaf).start as usize + parts.place.at(slot).at();
    let frame = parts.tree.frames.get(whole).unwrap_or(&Frame::NONE);
    let record = simd.record(frame, keys, slot as u32 | classified.marks());
    parts.tree.records.put(at, record);
    if sub_levels > 0
        && let Some(bounds) = parts.tree.bounds.get_mut(leaf)
    {
        bounds.include(&record);
        bounds.tag |= offer(parts.filters.of, slot);
    }
    // While leaves are not filled, the boxes of nodes are made later.
    let top = if parts.state.tree.filled == 0 { 0 } else { parts.tree.tops.at(whole) as usize };
    expand_ancestors(parts.tree.boxes, |node| parts.tree.parents.at(node / 2) as usize, top, &bounds);
    true
}

/// Gives a full leaf half of the free room of the next leaf that has some, so that a crowd that gathers needs
/// no fill of all leaves. Records between move along, and places stay. Returns whether there was room. A
/// leaf that is to be divided gets none. O(members of [`NEIGHBOURS`] leaves).
fn borrow<I: Index>(parts: &mut Parts<'_, I>, full: usize) -> bool {
    let (tree, behind) = (&mut parts.tree, full + 1..parts.state.tree.leaves() as usize);
    let is_over = u64::from(tree.leaves.at(full).len) >= most(parts.state);
    let free = |leaf: &usize| tree.leaves.at(*leaf).room > tree.leaves.at(*leaf).len;
    let Some(giver) = behind.take(NEIGHBOURS).find(free).filter(|_| !is_over) else { return false };
    let Leaf { room, len, .. } = tree.leaves.at(giver);
    let given = (room - len).div_ceil(2);
    for index in (full + 1..=giver).rev() {
        let Some(leaf) = tree.leaves.get_mut(index) else { continue };
        for record in (leaf.start..leaf.start + leaf.len).rev() {
            tree.records.put((record + given) as usize, tree.records.at(record as usize));
        }
        leaf.start += given;
    }
    tree.leaves.put(giver, Leaf { room: room - given, ..tree.leaves.at(giver) });
    tree.leaves.put(full, Leaf { room: tree.leaves.at(full).room + given, ..tree.leaves.at(full) });
    true
}

/// Takes an object out of its leaf or out of the large objects. The last one there takes its place.
fn withdraw<I: Index>(parts: &mut Parts<'_, I>, slot: usize) {
    let home = parts.home.at(slot);
    parts.home.put(slot, I::NONE);
    let place = parts.place.at(slot).at();
    if home == I::LARGE {
        large::take(parts, place);
    } else if let Some(leaf) = parts.tree.leaves.get_mut(home.at()) {
        leaf.len -= 1;
        let last = parts.tree.records.at((leaf.start + leaf.len) as usize);
        parts.tree.records.put(leaf.start as usize + place, last);
        parts.place.put(last.slot() as usize, I::from_slot(place as u32));
    }
}

/// Orders the list of movers by leaf, or by whole leaf if they are few; large objects come last, and removed
/// ones are dropped. Their slots are then in the third of the [thirds], their homes in the second. Returns how
/// many there are. O(movers + leaves).
pub(crate) fn order_movers<I: Index>(parts: &mut Parts<'_, I>, count: usize) -> usize {
    let leaves = parts.state.tree.leaves() as usize;
    // With few movers, a count for each sub-leaf would take longer than it saves.
    let coarser = if count < leaves / 4 { parts.state.tree.sub_levels() } else { 0 };
    let leaves = leaves >> coarser;
    let starts = parts.tree.histogram.span_mut(0, leaves + 2);
    starts.fill(0);
    let [movers, homes, list] = thirds(parts.spare);
    let (movers, all) = (movers.span(0, count), &*parts.home);
    // Removed objects come last.
    let place_of = |home: I| if home == I::NONE { leaves + 1 } else { (home.at() >> coarser).min(leaves) };
    for slot in movers {
        let place = place_of(all.at(slot.at()));
        starts.put(place, starts.at(place) + 1);
    }
    let mut start = 0;
    for next in &mut *starts {
        start += core::mem::replace(next, start);
    }
    for slot in movers {
        let home = all.at(slot.at());
        let place = place_of(home);
        let at = starts.at(place);
        list.put(at as usize, *slot);
        homes.put(at as usize, home);
        starts.put(place, at + 1);
    }
    // Each entry is now where the next leaf starts.
    starts.at(leaves) as usize
}
