//! Keeps the leaves of one size: new planes for all, or for the part of the tree that has grown out of balance.

use super::build::{Build, LEAF_SAMPLE, is_divisible};
use super::cells::Sample;
use super::{Record, are_few};
use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::lists::links;
use crate::lists::radix::{self, Sharing};
use crate::memory::limits::{LEAF_TARGET, SUB_LEVELS, histogram_row};
use crate::memory::slab::Parts;
use crate::memory::state::{State, TreeState};
use crate::parallel::context::StepContext;

/// A world is out of balance when the sum of the squares of its leaves' counts is this many quarters of what new planes can
/// achieve: sweeps cost about that much. With few leaves it is less, as the sum cannot grow to that.
const OUT_OF_BALANCE: u64 = 16;
/// Planes are good if that sum is at most this many quarters of the least one that there is.
const GOOD: u64 = 5;
/// The fullest leaf is looked at if it has more than so many quarters of the mean.
const FULL: u64 = 6;
/// In place of what the planes of a leaf can achieve: more than they did, since they can divide it by now.
const DIVISIBLE: u32 = 1;
/// Sweeps are heavy that test so many times as many pairs in vain as when the planes were new, and so many in that many steps in
/// a row are a reason for new planes: a single one may be an odd frame.
const HEAVY: u64 = 4;
const HEAVY_STEPS: u8 = 3;
/// The most full steps from a try at better planes, or at more levels of them, to the next one.
const PATIENCE: u8 = 64;
/// One in this many objects may get new planes in one step, so that no step takes much longer than the others.
const SHARE_PER_STEP: usize = 8;
/// A leaf gets new planes when it has this many times the mean count.
const OVERFULL: usize = 2;

/// The mean count of the leaves at some depth, not less than that of new ones that are half full.
fn mean(live: u32, depth: u32) -> usize {
    (live as usize >> depth).max(LEAF_TARGET / 2)
}

/// The most members of a leaf that is not overfull.
pub(crate) fn overfull(state: &State) -> usize {
    OVERFULL * mean(state.objects.live, state.tree.depth)
}

/// The depth of the tree in full steps for a number of objects: at most [`LEAF_TARGET`] in a leaf at exact medians
/// (erratum E14). `deepest` is the greatest depth of planes.
pub(crate) fn depth_for(objects: usize, deepest: u32) -> u32 {
    let deepest = deepest.saturating_sub(SUB_LEVELS);
    (0..deepest).find(|&depth| objects <= LEAF_TARGET << depth).unwrap_or(deepest)
}

/// Whether there are no planes, or the number of objects has outgrown them, or new ones would be better.
pub(crate) fn needs_planes<I: Index>(parts: &Parts<'_, I>) -> bool {
    let TreeState { built, divisible, .. } = parts.state.tree;
    let live = parts.state.objects.live;
    let depth = |objects| depth_for(objects as usize, parts.sizes.depth);
    built == 0 || divisible != 0 || depth(live) > depth(built) || live < built / 4 || built < live / 4
}

/// Whether the leaves that have just been counted are so uneven that the whole tree needs new planes now.
pub(crate) fn is_out_of_balance<I: Index>(parts: &Parts<'_, I>) -> bool {
    let quarters = OUT_OF_BALANCE.min((1 << parts.state.tree.depth) + 3);
    4 * squares(parts) > quarters * parts.state.tree.baseline.max(even(parts.state))
}

/// The least sum of squares: of leaves that all have as many members.
fn even(state: &State) -> u64 {
    u64::from(state.objects.live).pow(2) >> state.tree.depth
}

/// Notes what the planes achieve, right after they were made and the leaves were counted.
pub(crate) fn set_baseline<I: Index>(parts: &mut Parts<'_, I>) {
    let baseline = squares(parts);
    let state = &mut *parts.state;
    state.tree.baseline = baseline;
    state.tree.poor = u8::from(4 * baseline > GOOD * even(state));
    if state.tree.poor == 0 {
        (state.tree.planes_in, state.tree.planes_after) = (0, 1);
    } else {
        put_off_planes(state);
    }
}

/// Waits for some full steps before new planes are tried again, and twice as many the next time.
fn put_off_planes(state: &mut State) {
    state.tree.planes_in = state.tree.planes_after.max(1);
    state.tree.planes_after = state.tree.planes_in.saturating_mul(2).min(PATIENCE);
}

/// Looks at the leaves that have just been filled: how many are in use, how full is the fullest one; and, where the planes could
/// not part its members when they were made, whether new ones could do so by now.
pub(crate) fn review<I: Index>(parts: &mut Parts<'_, I>) {
    let Parts { state, tree, boxes, .. } = parts;
    let (mut in_use, mut fullest, mut most) = (0, 0, 0);
    for (index, leaf) in tree.leaves.span(0, 1 << state.tree.depth).iter().enumerate() {
        in_use += u32::from(leaf.len > 0);
        if leaf.len > most {
            (fullest, most) = (index, leaf.len);
        }
    }
    (state.tree.leaves_in_use, state.tree.fullest_leaf) = (in_use, most);
    state.tree.divisible = 0;
    let quarters = if state.tree.poor != 0 { GOOD } else { FULL };
    let is_full = (4 * u64::from(most)) << state.tree.depth > quarters * u64::from(state.objects.live);
    if state.tree.planes_in > 0 {
        state.tree.planes_in -= 1;
    } else if !is_full {
        state.tree.planes_after = state.tree.planes_after.saturating_sub(1).max(1);
    } else {
        let mut leaf = tree.leaves.at(fullest);
        if is_leaf_divisible::<I>(boxes.swept(), tree.records.span(leaf.start as usize, most as usize)) {
            if state.tree.poor != 0 {
                state.tree.divisible = 1;
            } else {
                leaf.baseline = DIVISIBLE;
                tree.leaves.put(fullest, leaf);
                put_off_planes(state);
            }
        }
    }
}

fn is_leaf_divisible<I: Index>(boxes: &[KeyBox], members: &[Record]) -> bool {
    let mut sample = [I::default(); LEAF_SAMPLE];
    let mut count = 0;
    // An odd step, as every second object may be of another kind.
    let step = (members.len() / LEAF_SAMPLE) | 1;
    for (slot, record) in sample.iter_mut().zip(members.iter().step_by(step)) {
        *slot = I::from_slot(record.slot());
        count += 1;
    }
    is_divisible(boxes, sample.span(0, count))
}

/// Notes how many pairs a full step has tested in vain. Where that stays far more than it was with new planes, clusters have come
/// into the same leaves from far apart, say, and their counts do not tell.
pub(crate) fn weigh(state: &mut State, in_vain: u64, planes_are_new: bool) {
    if planes_are_new {
        (state.tree.baseline_work, state.tree.heavy) = (in_vain, 0);
        return;
    }
    let is_heavy = in_vain
        > HEAVY.saturating_mul(state.tree.baseline_work).saturating_add(u64::from(state.objects.live));
    state.tree.heavy = if is_heavy { state.tree.heavy.saturating_add(1) } else { 0 };
    if state.tree.heavy >= HEAVY_STEPS && state.tree.planes_in == 0 {
        state.tree.divisible = 1;
        put_off_planes(state);
    }
}

/// Uses all levels of the planes again, where copies that were too many for that have become fewer. The leaves must be counted
/// anew.
pub(crate) fn deepen<I: Index>(parts: &mut Parts<'_, I>) {
    let TreeState { built, depth, large, large_start, deeper_in, deeper_after, .. } = parts.state.tree;
    let live = parts.state.objects.live;
    let whole = depth_for(live.min(built) as usize, parts.sizes.depth);
    if depth >= whole {
        (parts.state.tree.deeper_in, parts.state.tree.deeper_after) = (0, 1);
        return;
    }
    if deeper_in > 0 {
        parts.state.tree.deeper_in -= 1;
        return;
    }
    // Each level has about as many more copies as there are, at most.
    let (straddlers, large) = (u64::from(large_start) << (whole - depth), u64::from(large));
    let fits = straddlers + large <= parts.tree.straddlers.len() as u64;
    if fits && are_few(large, whole, live) {
        parts.state.tree.deeper_in = deeper_after.max(1);
        parts.state.tree.deeper_after = parts.state.tree.deeper_in.saturating_mul(2).min(PATIENCE);
        parts.state.tree.depth = whole;
        for leaf in &mut *parts.tree.leaves {
            leaf.baseline = 0;
        }
        super::renumber(parts.home, |leaf| leaf << (whole - depth));
    }
}

fn squares<I: Index>(parts: &Parts<'_, I>) -> u64 {
    parts.tree.leaves.span(0, 1 << parts.state.tree.depth).iter().map(|leaf| u64::from(leaf.len).pow(2)).sum()
}

/// Makes all planes anew from sorted lists of all living objects.
pub(crate) fn build_planes<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) {
    let live = parts.state.objects.live as usize;
    let depth = depth_for(live, parts.sizes.depth);
    links::list_all(parts);
    parts.state.tree.depth = depth;
    // Zero would say that there are no planes.
    parts.state.tree.built = parts.state.objects.live.max(1);
    parts.state.tree.divisible = 0;
    let boxes = parts.boxes.swept();
    let slots = parts.order[0].span(0, live);
    let extent = super::assign::scan_bounds(boxes.iter()).extent.trimmed(&Sample::of_list(slots, boxes));
    parts.state.tree.set_extent(&extent);
    for leaf in &mut *parts.tree.leaves {
        leaf.baseline = 0;
    }
    make_planes(parts, live, 1, depth + SUB_LEVELS, 0, context);
    // Homes are numbers of leaves that are no more.
    parts.home.fill(I::NONE);
    parts.state.tree.filled = 0;
}

/// Sorts the first `count` slots of the lists and makes the planes of the nodes below `root` from them. The sort
/// takes its room from the records from `first` on, as many as there are slots.
fn make_planes<I: Index>(
    parts: &mut Parts<'_, I>,
    count: usize,
    root: usize,
    levels: u32,
    first: usize,
    context: StepContext<'_>,
) {
    let boxes: &[KeyBox] = parts.boxes.swept();
    let room = bytemuck::try_cast_slice_mut::<Record, u32>(parts.tree.records.span_mut(first, count))
        .unwrap_or_default();
    let [x, y, z] = &mut parts.order;
    let mut lists = [x.span_mut(0, count), y.span_mut(0, count), z.span_mut(0, count)];
    let (histograms, _) =
        bytemuck::try_cast_slice_mut::<Record, u32>(parts.output.scratch).unwrap_or_default().as_chunks_mut();
    let sharing = Sharing { executor: context.executor, workers: context.workers };
    for (axis, list) in lists.iter_mut().enumerate() {
        radix::sort(list, boxes, axis, room, histograms, sharing);
    }
    let (starts, sides) =
        parts.tree.histogram.split_at_mut_checked(histogram_row(parts.sizes.depth)).unwrap_or_default();
    let sides = sides.span_mut(0, bits::words(parts.sizes.objects));
    sides.fill(0);
    Build { boxes, lists, planes: parts.tree.planes, sides, spare: parts.place, starts }
        .share(root, levels, room, context);
    parts.state.lists.stale = 1;
}

/// Gives new planes to the parts of the tree with overfull leaves, as many as a step allows. The leaves must be those of the
/// last full step; they have to be filled anew. Returns how many objects are concerned.
pub(crate) fn rebalance<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u32 {
    if parts.state.tree.filled == 0 {
        return 0;
    }
    let depth = parts.state.tree.depth;
    let leaves = 1usize << depth;
    let live = parts.state.objects.live as usize;
    let mean = mean(parts.state.objects.live, depth);
    let mut budget = (live / SHARE_PER_STEP).max(16 * LEAF_TARGET);
    let mut done = 0;
    let mut index = 0;
    while index < leaves {
        let leaf = parts.tree.leaves.at(index);
        // A leaf that new planes could not divide is not tried again until it has grown by half.
        let overfull =
            leaf.len as usize > overfull(parts.state) && leaf.len > leaf.baseline + leaf.baseline / 2;
        if !overfull && leaf.baseline != DIVISIBLE {
            index += 1;
            continue;
        }
        let (node, levels, count) = smallest_even(parts, index, mean);
        if count <= budget && levels > 0 {
            budget -= count;
            done += count;
            rebuild(parts, node, levels, context);
        }
        // The next leaf behind that part of the tree.
        index = ((node + 1) << levels) - leaves;
    }
    done as u32
}

/// The smallest part of the tree around a leaf in which the mean is not too far above that of the world: its root,
/// its levels and its objects.
fn smallest_even<I: Index>(parts: &Parts<'_, I>, leaf: usize, mean: usize) -> (usize, u32, usize) {
    let depth = parts.state.tree.depth;
    let leaves = 1usize << depth;
    let mut node = leaves + leaf;
    let mut levels = 0;
    loop {
        let first = (node << levels) - leaves;
        let count: usize =
            parts.tree.leaves.span(first, 1 << levels).iter().map(|leaf| leaf.len as usize).sum();
        if levels == depth || count <= (mean + mean / 2) << levels {
            return (node, levels, count);
        }
        node /= 2;
        levels += 1;
    }
}

/// Makes the planes below a node anew from the records of its leaves, which are lost.
fn rebuild<I: Index>(parts: &mut Parts<'_, I>, node: usize, levels: u32, context: StepContext<'_>) {
    let first = (node << levels) - (1usize << parts.state.tree.depth);
    let range = first..first + (1 << levels);
    let mut count = 0;
    for index in range.clone() {
        let mut leaf = parts.tree.leaves.at(index);
        for record in parts.tree.records.span(leaf.start as usize, leaf.len as usize) {
            // It may be gone by now.
            if parts.boxes.now.at(record.slot() as usize).is_empty() {
                continue;
            }
            for list in &mut parts.order {
                list.put(count, I::from_slot(record.slot()));
            }
            count += 1;
        }
        leaf.baseline = 0;
        parts.tree.leaves.put(index, leaf);
    }
    let start = parts.tree.leaves.at(range.start).start as usize;
    let sub_levels = (depth_for(parts.state.tree.built as usize, parts.sizes.depth) + SUB_LEVELS)
        .saturating_sub(parts.state.tree.depth);
    make_planes(parts, count, node, levels + sub_levels, start, context);
}
