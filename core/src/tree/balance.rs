//! Keeps leaves of one size: a leaf that is too full is divided where it stands, and two that are nearly
//! empty are joined. So planes follow where objects come and go, and all others stay (paper, section
//! III.B.2). The first planes are made the same way, from one leaf that holds all objects.

use super::build::{as_slots, divide};
use super::cells::Sample;
use super::limits::{CROWDED_SHARE, GHOSTS_SHARE, HEAVY, HEAVY_STEPS, PATIENCE};
use super::shape::join;
use super::{most, planned};
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::{block_len, depth_for, histogram_row, slot_blocks};
use crate::memory::slab::Parts;
use crate::memory::state::{State, TreeState};
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::parallel::shared::SharedSlots;

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

/// Divides and joins leaves by their counts. `extent` is that of all minima. Returns how many objects were in
/// leaves that were divided; if there are any, all must be counted anew. So where all leaves are filled in
/// each step, full ones wait until they have many members together, or one has far too many.
pub(crate) fn balance<I: Index>(
    parts: &mut Parts<'_, I>,
    extent: &KeyBox,
    waits: bool,
    context: StepContext<'_>,
) -> u32 {
    let (count, most) = (parts.state.tree.count as usize, most(parts.state));
    let (mut members, mut fullest) = (0, 0);
    for (leaf, stuck) in parts.tree.leaves.span_mut(0, count).iter_mut().zip(&*parts.tree.stuck) {
        let is_full = u64::from(leaf.len) > most && leaf.len > stuck + stuck / 2;
        leaf.start = if is_full { members } else { STAYS };
        members += if is_full { leaf.len } else { 0 };
        fullest = fullest.max(if is_full { leaf.len } else { 0 });
    }
    let share = if waits && u64::from(fullest) <= 2 * most { CROWDED_SHARE } else { u32::MAX };
    if members <= parts.state.objects.live / share {
        return 0;
    }
    list_members(parts, count, context);
    if count == 1 {
        let boxes = parts.boxes.swept().span(0, parts.state.objects.slots as usize);
        let list = as_slots::<I>(parts.tree.records).span(0, members as usize);
        let minimum = |at| Some(KeyBox::of(boxes, list.at(at).at()).min);
        parts.state.tree.extent = extent.trimmed(&Sample::of(list.len(), minimum));
    }
    let few = planned(parts.state) * 6 / 5;
    for leaf in (1..count).rev() {
        join(&mut parts.tree, &mut parts.state.tree, leaf, few);
    }
    let mut fits = true;
    for leaf in 0..parts.state.tree.count as usize {
        if parts.tree.leaves.at(leaf).start != STAYS {
            fits &= divide(parts, leaf, most);
        }
    }
    if !fits && parts.state.tree.wait == 0 {
        // Not in each step: new planes may be no better.
        parts.state.tree.due = Due::Outgrown as u8;
        put_off(&mut parts.state.tree);
    }
    members
}

/// Writes the slots of the leaves that are to be divided where their records were, which are all written anew
/// afterwards; the histogram tells where those of each block begin. Each leaf then starts where its members
/// end. O(slots).
fn list_members<I: Index>(parts: &mut Parts<'_, I>, count: usize, context: StepContext<'_>) {
    let Parts { tree, home, state, .. } = parts;
    let (slots, row) = (state.objects.slots as usize, histogram_row(count));
    let (leaves, len) = (tree.leaves.span_mut(0, count), block_len(slots, slot_blocks(context.workers)));
    let (list, starts) = (SharedSlots::new(as_slots::<I>(tree.records)), &*leaves);
    let histogram = tree.histogram.span_mut(0, slot_blocks(context.workers) * row);
    let blocks = (Chunks::new(home.span_mut(0, slots), len), Chunks::new(histogram, row));
    context.each(blocks, |block, (homes, histogram)| {
        for (slot, home) in (block * len..).zip(homes) {
            if let (Some(leaf), Some(next)) = (starts.get(home.at()), histogram.get_mut(home.at()))
                && leaf.start != STAYS
            {
                list.store((leaf.start + *next) as usize, I::from_slot(slot as u32));
                *next += 1;
            }
        }
    });
    for leaf in leaves.iter_mut().filter(|leaf| leaf.start != STAYS) {
        leaf.start += leaf.len;
    }
}

/// Looks at the leaves that were just filled: how many are in use, and how full the fullest one is. Leaves that
/// no plane could divide are tried again now and then.
pub(crate) fn review<I: Index>(parts: &mut Parts<'_, I>) {
    let (most, leaves) = (most(parts.state), parts.state.tree.count as usize);
    let state = &mut parts.state.tree;
    (state.leaves_in_use, state.fullest_leaf, state.uneven) = (0, 0, 0);
    let mut freed = false;
    for (leaf, stuck) in parts.tree.leaves.span(0, leaves).iter().zip(&mut *parts.tree.stuck) {
        state.leaves_in_use += u32::from(leaf.len > 0);
        state.fullest_leaf = state.fullest_leaf.max(leaf.len);
        if u64::from(leaf.len) > most {
            if *stuck > 0 && state.wait == 0 {
                (*stuck, freed) = (0, true);
            }
            state.uneven |= u8::from(leaf.len > *stuck + *stuck / 2);
        }
    }
    if freed {
        put_off(state);
    } else if state.wait > 0 {
        state.wait -= 1;
    } else {
        state.waits = state.waits.saturating_sub(1);
    }
}

/// Waits for some full steps until the next try, and twice as long the next time.
fn put_off(state: &mut TreeState) {
    state.wait = state.waits.max(1);
    state.waits = state.wait.saturating_mul(2).min(PATIENCE);
}

/// Notes how many pairs a full step tested in vain, and how many ghosts it had. If there stay far more than
/// with new planes, these are due: clusters have come into a leaf, or it is long, which counts do not tell.
pub(crate) fn weigh(state: &mut State, in_vain: u64, copies: u64) {
    let (tree, live) = (&mut state.tree, u64::from(state.objects.live));
    if tree.unweighed != 0 {
        (tree.baseline_work, tree.baseline_copies) = (in_vain, copies);
        (tree.heavy, tree.unweighed) = (0, tree.unweighed - 1);
        return;
    }
    let is_heavy = in_vain > HEAVY.saturating_mul(tree.baseline_work).saturating_add(live)
        || copies > tree.baseline_copies + tree.baseline_copies / 2 + live / GHOSTS_SHARE;
    tree.heavy = if is_heavy { tree.heavy.saturating_add(1) } else { 0 };
    if tree.heavy >= HEAVY_STEPS {
        tree.due = Due::Heavy as u8;
    }
}

/// Plans leaves for as many objects as there are, or were while there are not clearly fewer.
pub(crate) fn plan(state: &mut State) {
    let (live, target) = (state.objects.live as usize, state.setup.forced.leaf_target());
    state.tree.depth = state.tree.depth.min(depth_for(live + live / 8, target)).max(depth_for(live, target));
}

/// Now and then plans leaves of half the size again, where there were too many ghosts for that. Returns whether
/// all must be counted anew.
pub(crate) fn refine(state: &mut TreeState) -> bool {
    let tries = state.coarser > 0 && state.wait == 0;
    if tries {
        state.coarser -= 1;
        put_off(state);
    }
    tries
}
