//! Checks what a slab has and a snapshot does not: lists, and what follows from the rest.

use super::tree::leaves;
use super::{Invalid, check};
use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::lists::links;
use crate::memory::limits::LEAF_TARGET;
use crate::memory::slab::Parts;
use crate::memory::stats::Path;
use crate::simd::kernels::Kernels;
use crate::simd::{Phase, Simd, limit, scalar::Scalar};
use crate::step::recount::{self, Sum};
use crate::tree::cells::cut;
use crate::tree::visit::Visit;
use crate::tree::{Cell, Record, first_of_eight, home_of};

/// Checks all of it.
pub(super) fn slab<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    unused(parts)?;
    last_boxes(parts)?;
    lists(parts)?;
    if !parts.sizes.is_small() && parts.state.tree.filled != 0 {
        tree(parts)?;
        cells(parts)?;
    }
    kept_pairs(parts)
}

/// Slots that were never in use are as new.
fn unused<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let slots = parts.state.objects.slots as usize;
    for set in [
        &*parts.moved.words,
        parts.changed.words,
        parts.outdated.words,
        parts.filters.changed.words,
        parts.resting,
        parts.active,
        parts.former.reused.words,
    ] {
        let words = set.get(bits::words(slots)..).unwrap_or_default();
        check(words.iter().all(|word| *word == 0), "a set has slots that there are not", slots)?;
    }
    for boxes in [&*parts.boxes.now, parts.boxes.fat, parts.boxes.before] {
        let unused = boxes.get(slots..).unwrap_or_default();
        check(
            unused.iter().all(|bounds| *bounds == KeyBox::EMPTY),
            "a slot without an object has a box",
            slots,
        )?;
    }
    let generations = parts.generations.get(slots..).unwrap_or_default();
    check(generations.iter().all(|count| *count == 0), "a slot is not as new", slots)
}

/// The box of the last complete step is that of the slot, if it has not changed since.
fn last_boxes<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let reported = parts.boxes.reported(parts.state.setup.mode());
    for (slot, before) in parts.boxes.before.iter().enumerate().take(parts.state.objects.slots as usize) {
        let known = !bits::test(parts.changed.words, slot) && !bits::test(parts.outdated.words, slot);
        check(!known || *before == reported.at(slot), "a box of the last step is not kept", slot)?;
    }
    Ok(())
}

/// Slots that are looked for at a time. Their bits are on the stack, which is small on a microcontroller.
const SLOTS_AT_A_TIME: usize = if cfg!(feature = "large") { 1 << 15 } else { 1 << 8 };

/// Each list has every living object once, and the list that was swept is in order.
fn lists<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    if parts.state.lists.stale != 0 {
        return Ok(());
    }
    let (listed, slots) = (parts.state.lists.listed as usize, parts.state.objects.slots as usize);
    for slot in 0..slots {
        let lives = !parts.boxes.now.at(slot).is_empty();
        check(!lives || bits::test(parts.listed, slot), "a living object is not marked as listed", slot)?;
    }
    check(
        bits::count(parts.listed) as usize == listed,
        "the marks of the lists are not counted right",
        listed,
    )?;
    for order in &parts.order {
        let order = order.span(0, listed);
        for first in (0..slots).step_by(SLOTS_AT_A_TIME) {
            let mut met = [0; SLOTS_AT_A_TIME / 32];
            for slot in order {
                let marked = slot.at() < slots && bits::test(parts.listed, slot.at());
                check(marked, "a list holds a slot that is not marked", slot.at())?;
                if let Some(bit) = slot.at().checked_sub(first).filter(|bit| *bit < SLOTS_AT_A_TIME) {
                    check(bits::set(&mut met, bit), "a list holds a slot twice", slot.at())?;
                }
            }
        }
    }
    let swept = parts.state.stats().path == Path::Lists
        && parts.state.pairs.without_surplus == 0
        && parts.moved.count() == 0;
    if swept && listed == parts.state.objects.live as usize {
        let axis = parts.state.lists.axis as usize;
        let order = parts.order.get(axis).map_or(&[][..], |order| order.span(0, listed));
        for (at, two) in order.windows(2).enumerate() {
            let boxes = parts.boxes.swept();
            let ascends = links::precedes(boxes, axis, two.at(0), two.at(1));
            check(ascends, "the swept list is not in order", at)?;
        }
    }
    Ok(())
}

/// Records are those of their boxes, leaf by leaf without gaps. No other object has a place in the tree.
fn tree<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let sub_levels = parts.state.tree.sub_levels();
    let swept = parts.boxes.swept();
    check(parts.tree.nodes.at(0) == KeyBox::NOTHING, "there is a node zero", 0)?;
    let (mut end, mut placed) = (0, parts.state.tree.large as usize);
    for index in 0..leaves(parts.state) {
        let leaf = parts.tree.leaves.at(index);
        check(leaf.start == end, "a leaf does not start where the last one ends", index)?;
        end += leaf.room;
        placed += leaf.len as usize;
        for record in parts.tree.records.span(leaf.start as usize, leaf.len as usize) {
            let slot = record.slot() as usize;
            if bits::test(parts.moved.words, slot) {
                continue;
            }
            let bounds = swept.at(slot);
            let home = home_of(parts.tree.planes, parts.state, &bounds.min);
            check(home == index, "an object is not where the planes say", slot)?;
            let mut expected = Scalar.record(&parts.tree.frames.at(index >> sub_levels), bounds, slot as u32);
            // Nobody reads the marks in divided leaves: a full step makes them anew.
            expected.tag |= match sub_levels {
                0 => parts.tree.cells.at(index).classify(Scalar, bounds).marks(),
                _ => record.tag & Record::STRADDLES,
            };
            check(*record == expected, "a record is not that of its box", slot)?;
        }
    }
    let large =
        parts.tree.straddlers.span(parts.state.tree.large_start as usize, parts.state.tree.large as usize);
    for straddler in large {
        let slot = straddler.slot as usize;
        let current = bits::test(parts.moved.words, slot) || straddler.bounds == swept.at(slot);
        check(current, "a large object's box is not its own", slot)?;
    }
    let homes = parts.home.iter().filter(|home| **home != I::NONE).count();
    check(homes == placed, "an object has a place in the tree and is not there", homes)
}

/// The cells are those of the planes. Each is cut by itself, so that no memory is needed.
fn cells<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let sub_levels = parts.state.tree.sub_levels();
    let depth = parts.state.tree.depth + sub_levels;
    for index in 0..1usize << depth {
        let mut planes = [0; 2];
        let mut cell = Cell::ALL;
        let divided = sub_levels == 0 || parts.state.tree.is_subdivided(index >> sub_levels);
        if !divided && index & ((1 << sub_levels) - 1) != 0 {
            continue;
        }
        for level in 0..if divided { depth } else { depth - sub_levels } {
            let node = ((1 << depth) + index) >> (depth - level);
            let right = ((1 << depth) + index) >> (depth - level - 1) & 1;
            planes.put(1, parts.tree.planes.at(node));
            let mut halves = [cell, cell];
            cut(&planes, 1, &parts.state.tree.extent(), &mut halves);
            let half = halves.at(right);
            let (mut low, mut high) = (cell.low(), cell.high());
            for k in 0..3 {
                low[k] = low[k].max(half.low()[k]);
                high[k] = high[k].min(half.high()[k]);
            }
            cell = Cell::new(low, high, high);
        }
        let known = parts.tree.cells.at(index);
        check(
            (cell.low(), cell.high()) == (known.low(), known.high()),
            "a cell is not that of its planes",
            index,
        )?;
    }
    Ok(())
}

/// The pairs that the next step would keep are all that there are. Not checked if the step itself looks, or if a rule
/// may have refused pairs.
fn kept_pairs<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let state = &*parts.state;
    let known = state.pairs.complete != 0 && state.pairs.without_surplus == 0 && state.pairs.unproven == 0;
    let filled = !parts.sizes.is_small() && state.tree.filled != 0;
    let few = state.objects.live as usize <= LEAF_TARGET && parts.moved.count() == 0;
    if !known || !parts.filters.of.is_empty() || !filled && !few {
        return Ok(());
    }
    let all = if filled { Kernels::detect().run(InTree(parts)) } else { one_by_one(parts) };
    check(all == recount::kept(parts), "pairs are missing, or there twice", 0)
}

/// Whether an object lives and has not moved.
fn stays<I: Index>(parts: &Parts<'_, I>, slot: usize) -> bool {
    !KeyBox::of(parts.boxes.now, slot).is_empty() && !bits::test(parts.moved.words, slot)
}

/// The sum over all overlaps of objects that have not moved.
fn one_by_one<I: Index>(parts: &Parts<'_, I>) -> Sum {
    let (boxes, mut all) = (parts.boxes.swept(), Sum::default());
    let slots = 0..parts.state.objects.slots as usize;
    for a in slots.clone().filter(|slot| stays(parts, *slot)) {
        for b in a + 1..slots.end {
            if stays(parts, b) && KeyBox::of(boxes, a).overlaps(KeyBox::of(boxes, b)) {
                all.add([a as u32, b as u32]);
            }
        }
    }
    all
}

/// As [`one_by_one`], in a tree.
struct InTree<'p, 'm, I>(&'p Parts<'m, I>);

impl<I: Index> Phase for InTree<'_, '_, I> {
    type Output = Sum;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Sum {
        let Self(parts) = self;
        let (state, tree, boxes) = (&*parts.state, &parts.tree, parts.boxes.swept());
        let (mut all, sub_levels) = (Sum::default(), state.tree.sub_levels());
        for slot in (0..state.objects.slots as usize).filter(|slot| stays(parts, *slot)) {
            let bounds = KeyBox::of(boxes, slot);
            // No vectors: a closure does not have the instruction set of its function.
            let mut meet = |other: usize| {
                if other > slot && stays(parts, other) && KeyBox::of(boxes, other).overlaps(bounds) {
                    all.add([slot as u32, other as u32]);
                }
            };
            let mut visit = Visit::new(simd, tree.nodes, state.tree.depth, 0, *bounds);
            while let Some(whole) = visit.next(simd) {
                let record = simd.record(&tree.frames.at(whole), simd.keys(bounds), 0);
                for part in whole << sub_levels..(whole + 1) << sub_levels {
                    for (eight, left) in tree.leaves.at(part).chunks_of_eight(tree.records) {
                        let mut mask = simd.touching(eight, limit(&record)) & first_of_eight(left);
                        while mask != 0 {
                            meet(eight.at(mask.trailing_zeros() as usize).slot() as usize);
                            mask &= mask - 1;
                        }
                    }
                }
            }
            for straddler in tree.straddlers.span(state.tree.large_start as usize, state.tree.large as usize)
            {
                meet(straddler.slot as usize);
            }
        }
        all
    }
}
