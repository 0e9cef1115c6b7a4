//! Keeps leaves of one size: a leaf that is too full is divided where it stands, and two that are nearly empty are
//! joined. So planes follow where objects come and go, and all others stay (paper, section III.B.2). The first planes
//! are made the same way, from one leaf that holds all objects.

use super::build::{Build, is_divisible};
use super::cells::Sample;
use super::limits::{GHOSTS_SHARE, HEAVY, HEAVY_STEPS, LEAF_SAMPLE, PATIENCE, SAMPLED_FROM, SAMPLED_SHARE};
use super::shape::{graft, join};
use super::{Cell, Leaf, Record, are_few, assign, large, most, planned};
use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::lists::radix::{self, Sharing};
use crate::memory::limits::{LEVELS, depth_for};
use crate::memory::slab::Parts;
use crate::memory::state::{State, TreeState};
use crate::parallel::context::StepContext;

/// Why the whole tree is to be made anew.
pub(crate) enum Due {
    /// Sweeps test far more pairs in vain than with new planes.
    Heavy = 1,
    /// There are too many leaves, or levels.
    Outgrown = 2,
}

/// Whether new planes for the whole tree are due.
pub(crate) fn needs_planes(state: &State) -> bool {
    state.tree.count == 0 || state.tree.due != 0
}

/// No leaf is to be divided.
const STAYS: u32 = u32::MAX;

/// Divides and joins leaves by their counts. Returns how many objects were in leaves that were divided; if there are
/// any, all must be counted anew.
pub(crate) fn balance<I: Index>(parts: &mut Parts<'_, I>, context: StepContext<'_>) -> u32 {
    let (count, most) = (parts.state.tree.count as usize, most(parts.state));
    let mut members = 0;
    for leaf in parts.tree.leaves.span_mut(0, count) {
        let is_full = u64::from(leaf.len) > most && leaf.len > leaf.stuck + leaf.stuck / 2;
        leaf.start = if is_full { members } else { STAYS };
        members += if is_full { leaf.len } else { 0 };
    }
    if members == 0 {
        return 0;
    }
    list_members(parts, count);
    if count == 1 {
        let boxes = parts.boxes.swept().span(0, parts.state.objects.slots as usize);
        let sample = Sample::of_list(parts.order[0].span(0, members as usize), boxes);
        let extent = assign::scan_bounds(boxes.iter()).extent.trimmed(&sample);
        parts.state.tree.set_extent(&extent);
    }
    let few = planned(parts.state) * 6 / 5;
    for leaf in (1..count).rev() {
        join(&mut parts.tree, &mut parts.state.tree, leaf, few);
    }
    for leaf in 0..parts.state.tree.count as usize {
        if parts.tree.leaves.at(leaf).start != STAYS {
            divide(parts, leaf, most, context);
        }
    }
    members
}

/// Writes the slots of the leaves that are to be divided to the first of the sorted lists. Each leaf then starts where
/// its members end. O(slots).
fn list_members<I: Index>(parts: &mut Parts<'_, I>, count: usize) {
    let Parts { tree, order, home, state, .. } = parts;
    state.lists.stale = 1;
    let leaves = tree.leaves.span_mut(0, count);
    for (slot, home) in home.span(0, state.objects.slots as usize).iter().enumerate() {
        if let Some(leaf) = leaves.get_mut(home.at())
            && leaf.start != STAYS
        {
            order[0].put(leaf.start as usize, I::from_slot(slot as u32));
            leaf.start += 1;
        }
    }
}

/// Divides a leaf whose members are listed, into leaves of at most so many at medians: exact ones, or of a sample of many.
fn divide<I: Index>(parts: &mut Parts<'_, I>, index: usize, most: u64, context: StepContext<'_>) {
    let leaf = parts.tree.leaves.at(index);
    let (len, mut levels) = (leaf.len as usize, 0);
    while u64::from(leaf.len >> levels) > most {
        levels += 1;
    }
    let top = parts.tree.tops.at(index) as usize;
    if (parts.tree.nodes().depth(top) + levels) as usize >= LEVELS {
        outgrow(&mut parts.state.tree);
        return;
    }
    let boxes: &[KeyBox] = parts.boxes.swept();
    // All records and cells are written anew afterwards.
    let room =
        bytemuck::try_cast_slice_mut::<Record, u32>(parts.tree.records.span_mut(0, len)).unwrap_or_default();
    let planes = bytemuck::try_cast_slice_mut::<Cell, i32>(parts.tree.cells).unwrap_or_default();
    let [x, y, z] = &mut parts.order;
    let (start, step) = (leaf.start as usize - len, if len < SAMPLED_FROM { 1 } else { SAMPLED_SHARE });
    for at in 0..len / step {
        x.put(start + at, x.at(start + at * step));
    }
    let mut lists = [x, y, z].map(|list| list.span_mut(start, len / step));
    let [x, others @ ..] = &mut lists;
    others.iter_mut().for_each(|list| list.copy_in(x));
    let (histograms, _) =
        bytemuck::try_cast_slice_mut::<Record, u32>(parts.output.scratch).unwrap_or_default().as_chunks_mut();
    let sharing = Sharing { executor: context.executor, workers: context.workers };
    for (axis, list) in lists.iter_mut().enumerate() {
        radix::sort(list, boxes, axis, room, histograms, sharing);
    }
    let (starts, sides) = parts.tree.histogram.split_at_mut_checked((1 << levels) + 1).unwrap_or_default();
    let sides = sides.span_mut(0, bits::words(parts.sizes.objects));
    sides.fill(0);
    Build { boxes, lists, planes, sides, spare: parts.place, starts }.share(1, levels, room, context);
    let before = parts.state.tree.count;
    if !graft(&mut parts.tree, &mut parts.state.tree, index, levels) {
        outgrow(&mut parts.state.tree);
    }
    let stuck = if parts.state.tree.count == before { leaf.len } else { 0 };
    parts.tree.leaves.put(index, Leaf { stuck, ..leaf });
}

/// Looks at the leaves that were just filled: how many are in use, and how full the fullest one is. A sample of a leaf
/// that no plane could divide tells whether one would by now.
pub(crate) fn review<I: Index>(parts: &mut Parts<'_, I>) {
    let most = most(parts.state);
    let Parts { state, tree, boxes, .. } = parts;
    let state = &mut state.tree;
    (state.leaves_in_use, state.fullest_leaf, state.uneven) = (0, 0, 0);
    let mut freed = false;
    for leaf in tree.leaves.span_mut(0, state.count as usize) {
        state.leaves_in_use += u32::from(leaf.len > 0);
        state.fullest_leaf = state.fullest_leaf.max(leaf.len);
        if u64::from(leaf.len) <= most {
            continue;
        }
        let members = tree.records.span(leaf.start as usize, leaf.len as usize);
        if leaf.stuck > 0 && state.wait == 0 && is_leaf_divisible::<I>(boxes.swept(), members) {
            (leaf.stuck, freed) = (0, true);
        }
        state.uneven |= u8::from(leaf.len > leaf.stuck + leaf.stuck / 2);
    }
    if freed {
        put_off(state);
    } else if state.wait > 0 {
        state.wait -= 1;
    } else {
        state.waits = state.waits.saturating_sub(1);
    }
}

/// There is no room for more leaves, or levels. Not in each step: new planes may be no better.
fn outgrow(state: &mut TreeState) {
    if state.wait == 0 {
        state.due = Due::Outgrown as u8;
        put_off(state);
    }
}

/// Waits for some full steps until the next try, and twice as long the next time.
fn put_off(state: &mut TreeState) {
    state.wait = state.waits.max(1);
    state.waits = state.wait.saturating_mul(2).min(PATIENCE);
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

/// Notes how many pairs a full step tested in vain, and how many ghosts it had. If there stay far more than with new
/// planes, new ones are due: clusters may have come into one leaf, or leaves have become long, which counts do not tell.
pub(crate) fn weigh(state: &mut State, in_vain: u64, copies: u64) {
    let (tree, live) = (&mut state.tree, u64::from(state.objects.live));
    if tree.unweighed != 0 {
        (tree.baseline_work, tree.baseline_copies) = (in_vain, copies);
        (tree.heavy, tree.unweighed) = (0, 0);
        return;
    }
    let is_heavy = in_vain > HEAVY.saturating_mul(tree.baseline_work).saturating_add(live)
        || copies > tree.baseline_copies + tree.baseline_copies / 2 + live / GHOSTS_SHARE;
    tree.heavy = if is_heavy { tree.heavy.saturating_add(1) } else { 0 };
    if tree.heavy >= HEAVY_STEPS {
        tree.due = Due::Heavy as u8;
    }
}

/// Plans leaves for as many objects as there are, or for as many as there were while they are not clearly fewer.
pub(crate) fn plan(state: &mut State) {
    let live = state.objects.live as usize;
    state.tree.depth = state.tree.depth.min(depth_for(live + live / 8)).max(depth_for(live));
}

/// Plans leaves of the usual size again, if there were too many ghosts for that and by now there are fewer. Returns
/// whether all must be counted anew.
pub(crate) fn refine<I: Index>(parts: &mut Parts<'_, I>) -> bool {
    let (state, room) = (&mut *parts.state, parts.tree.straddlers.len());
    let (coarser, number) = (state.tree.coarser, u64::from(state.tree.large));
    if coarser == 0 || state.tree.wait > 0 {
        return false;
    }
    // Twice as many leaves have at most about twice as many ghosts.
    let fits = large::fits(u64::from(state.tree.large_start) << coarser.min(31), number, room);
    let leaves = u64::from(state.tree.count) << coarser.min(31);
    if !fits || !are_few(number, leaves as u32, state.objects.live) {
        return false;
    }
    state.tree.coarser = 0;
    put_off(&mut state.tree);
    true
}
