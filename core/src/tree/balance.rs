//! Keeps leaves of one size: makes new planes for the whole tree, or for the part that has grown out of balance.

use super::build::{Build, is_divisible};
use super::cells::Sample;
use super::limits::{
    FULL, GOOD, HEAVY, HEAVY_STEPS, LEAF_SAMPLE, OUT_OF_BALANCE, OVERFULL, PATIENCE, REBALANCED_SHARE,
};
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

/// A baseline for a leaf that new planes can divide by now.
const DIVISIBLE: u32 = 1;

/// The mean count of the leaves at a depth; at least that of new leaves that are half full.
fn mean(live: u32, depth: u32) -> usize {
    (live as usize >> depth).max(LEAF_TARGET / 2)
}

/// The most members of a leaf that is not overfull.
pub(crate) fn overfull(state: &State) -> usize {
    OVERFULL * mean(state.objects.live, state.tree.depth)
}

/// The depth of the leaves of full steps for a number of objects, so that none has more than [`LEAF_TARGET`] at exact
/// medians (erratum E14). `deepest` is the greatest depth of planes.
pub(crate) fn depth_for(objects: usize, deepest: u32) -> u32 {
    let deepest = deepest.saturating_sub(SUB_LEVELS);
    (0..deepest).find(|&depth| objects <= LEAF_TARGET << depth).unwrap_or(deepest)
}

/// Whether new planes are due: there are none, or they are for far more or fewer objects, or others would be better.
pub(crate) fn needs_planes<I: Index>(parts: &Parts<'_, I>) -> bool {
    let TreeState { built, divisible, .. } = parts.state.tree;
    let live = parts.state.objects.live;
    let depth = |objects| depth_for(objects as usize, parts.sizes.depth);
    built == 0 || divisible != 0 || depth(live) > depth(built) || live < built / 4 || built < live / 4
}

/// Whether the leaves that were just counted are so uneven that the whole tree needs new planes now.
pub(crate) fn is_out_of_balance<I: Index>(parts: &Parts<'_, I>) -> bool {
    let quarters = OUT_OF_BALANCE.min((1 << parts.state.tree.depth) + 3);
    4 * squares(parts) > quarters * parts.state.tree.baseline.max(even(parts.state))
}

/// The sum of squares of leaves that all have as many members: the least that there is.
fn even(state: &State) -> u64 {
    u64::from(state.objects.live).pow(2) >> state.tree.depth
}

/// Notes how even the leaves are, right after their planes were made and they were counted.
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

/// Tries new planes again after some full steps, and after twice as many the next time.
fn put_off_planes(state: &mut State) {
    state.tree.planes_in = state.tree.planes_after.max(1);
    state.tree.planes_after = state.tree.planes_in.saturating_mul(2).min(PATIENCE);
}

/// Looks at the leaves that were just filled: how many are in use, and how full the fullest one is. If that is too
/// full, a sample of its members tells whether new planes would part them by now.
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
    // An odd step, since every second object may be of another kind.
    let step = (members.len() / LEAF_SAMPLE) | 1;
    for (slot, record) in sample.iter_mut().zip(members.iter().step_by(step)) {
        *slot = I::from_slot(record.slot());
        count += 1;
    }
    is_divisible(boxes, sample.span(0, count))
}

/// Notes how many pairs a full step tested in vain. If they stay far more than with new planes, new ones are due:
/// clusters may have come into one leaf, which counts do not tell.
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

/// Uses all levels of the planes again, if there were too many ghosts for that and by now there are fewer. The leaves
/// must be counted anew.
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
    // Each level at most about doubles the ghosts.
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

/// Makes all planes anew, from sorted lists of all living objects.
pub(crate) fn build_planes<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) {
    let live = parts.state.objects.live as usize;
    let depth = depth_for(live, parts.sizes.depth);
    links::list_all(parts);
    parts.state.tree.depth = depth;
    // Zero would mean that there are no planes.
    parts.state.tree.built = parts.state.objects.live.max(1);
    parts.state.tree.divisible = 0;
    let boxes = parts.boxes.swept().span(0, parts.state.objects.slots as usize);
    let slots = parts.order[0].span(0, live);
    let extent = super::assign::scan_bounds(boxes.iter()).extent.trimmed(&Sample::of_list(slots, boxes));
    parts.state.tree.set_extent(&extent);
    for leaf in &mut *parts.tree.leaves {
        leaf.baseline = 0;
    }
    make_planes(parts, live, 1, depth + SUB_LEVELS, 0, context);
    // Homes are numbers of old leaves.
    parts.home.fill(I::NONE);
    parts.state.tree.filled = 0;
}

/// Sorts the first `count` slots of the lists and makes the planes of the nodes below `root`. The sort uses the room
/// of as many records, from `first` on.
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

/// Makes new planes for the sub-trees around overfull leaves, as many as a step allows. Leaves must not be divided;
/// they have to be filled anew. Returns how many objects are in them.
pub(crate) fn rebalance<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u32 {
    if parts.state.tree.filled == 0 {
        return 0;
    }
    let depth = parts.state.tree.depth;
    let leaves = 1usize << depth;
    let live = parts.state.objects.live as usize;
    let mean = mean(parts.state.objects.live, depth);
    let mut budget = (live / REBALANCED_SHARE).max(16 * LEAF_TARGET);
    let mut done = 0;
    let mut index = 0;
    while index < leaves {
        let leaf = parts.tree.leaves.at(index);
        // A leaf that new planes could not divide is tried again when it has grown by half.
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
        // The next leaf behind that sub-tree.
        index = ((node + 1) << levels) - leaves;
    }
    done as u32
}

/// The smallest sub-tree around a leaf in which the mean is not far above that of the world: its root, its levels and
/// its objects.
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

/// Makes the planes below a node anew, from the records of its leaves, which are lost.
fn rebuild<I: Index>(parts: &mut Parts<'_, I>, node: usize, levels: u32, context: StepContext<'_>) {
    let first = (node << levels) - (1usize << parts.state.tree.depth);
    let range = first..first + (1 << levels);
    let mut count = 0;
    for index in range.clone() {
        let mut leaf = parts.tree.leaves.at(index);
        for record in parts.tree.records.span(leaf.start as usize, leaf.len as usize) {
            // The object may be gone.
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
