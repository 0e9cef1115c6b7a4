//! Checks the tree: each object that has not moved is once where the planes say, and the boxes of nodes hold it.

use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::SUB_LEVELS;
use crate::memory::slab::Parts;
use crate::simd::{EIGHT, Simd as _, scalar::Scalar};
use crate::snapshot::check::{Invalid, check};
use crate::tree::balance::depth_for;
use crate::tree::cells::cut;
use crate::tree::{Cell, Record, axis_of, home_of, plane};

/// Checks the planes and, if leaves are filled, all of them. O(slots + leaves log leaves).
pub(super) fn tree<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let state = &parts.state.tree;
    if state.built > 0 {
        for node in 1..1 << (depth_for(state.built as usize, parts.sizes.depth) + SUB_LEVELS) {
            // Any key is right for a plane, but not any axis.
            let known = parts.tree.planes.at(node);
            check(plane(axis_of(known), known) == known, "a plane has no axis", node)?;
        }
    }
    if state.filled == 0 {
        return Ok(());
    }
    nodes(parts)?;
    cells(parts)?;
    let (mut end, mut placed) = (0, state.large as usize);
    for index in 0..1 << (state.depth + state.sub_levels()) {
        let leaf = parts.tree.leaves.at(index);
        check(leaf.start == end && leaf.len <= leaf.room, "leaves do not stand one behind another", index)?;
        end += leaf.room;
        placed += leaf.len as usize;
        // Records are read in groups of eight, also behind the last leaf.
        check(end as usize + EIGHT <= parts.sizes.records, "more records than there are", index)?;
        for (place, record) in
            parts.tree.records.span(leaf.start as usize, leaf.len as usize).iter().enumerate()
        {
            let slot = record.slot() as usize;
            let is_there = slot < parts.state.objects.slots as usize
                && parts.home.at(slot) == I::from_slot(index as u32)
                && parts.place.at(slot).at() == place;
            check(is_there, "a record is not at its object's place, or not the only one", slot)?;
            // Objects that have moved or are gone are still where they were.
            if !bits::test(parts.moved.words, slot) {
                member(parts, index, record)?;
            }
        }
    }
    large(parts)?;
    // Each record and each large object has the place that its slot names, so none of them is there twice.
    let homes = parts.home.iter().filter(|home| **home != I::NONE).count();
    check(homes == placed, "an object has a place in the tree and is not there", homes)?;
    for slot in 0..parts.state.objects.slots as usize {
        let is_known = bits::test(parts.moved.words, slot) || parts.home.at(slot) != I::NONE;
        check(is_known || parts.boxes.now.at(slot).is_empty(), "an object has no place in the tree", slot)?;
    }
    Ok(())
}

/// The box of each node is valid and holds those below it, since nothing looks below a box that is not met.
fn nodes<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let nodes = &parts.tree.nodes;
    check(nodes.at(0) == KeyBox::NOTHING, "there is a node zero", 0)?;
    for node in 1..2usize << parts.state.tree.depth {
        let around = nodes.at(node);
        check(around == KeyBox::NOTHING || around.is_valid(), "the box of a node is none", node)?;
        let holds = node == 1 || nodes.at(node / 2).contains(&around);
        check(holds, "the box of a node does not hold the one below", node)?;
    }
    Ok(())
}

/// A record is that of its box in the frame of its leaf, and what is around it holds it.
fn member<I: Index>(parts: &Parts<'_, I>, leaf: usize, record: &Record) -> Result<(), Invalid> {
    let (state, tree) = (&parts.state.tree, &parts.tree);
    let (slot, sub_levels) = (record.slot() as usize, state.sub_levels());
    let whole = leaf >> sub_levels;
    let bounds = parts.boxes.swept().at(slot);
    check(!bounds.is_empty(), "a record has no object", slot)?;
    let home = home_of(tree.planes, parts.state, &bounds.min);
    check(home == leaf, "an object is not where the planes say", slot)?;
    let mut expected = Scalar.record(&tree.frames.at(whole), bounds, slot as u32);
    // Nobody reads the marks in divided leaves: a full step makes them anew.
    expected.tag |= match sub_levels {
        0 => tree.cells.at(leaf).classify(Scalar, bounds).marks(),
        _ => record.tag & Record::STRADDLES,
    };
    check(*record == expected, "a record is not that of its box", slot)?;
    let around = tree.nodes.at((1 << state.depth) + whole);
    check(around.contains(&bounds), "the box of a node does not hold a member", slot)?;
    let mut both = tree.bounds.at(leaf);
    both.include(record);
    let same = both.lanes == tree.bounds.at(leaf).lanes;
    check(sub_levels == 0 || same, "the bounds of a leaf do not hold a member", leaf)
}

/// Large objects stand in their list, with their boxes.
fn large<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let state = &parts.state.tree;
    let large = parts.tree.straddlers.span(state.large_start as usize, state.large as usize);
    for (place, straddler) in large.iter().enumerate() {
        let slot = straddler.slot as usize;
        let is_there = slot < parts.state.objects.slots as usize
            && parts.home.at(slot) == I::LARGE
            && parts.place.at(slot).at() == place;
        check(is_there, "a large object is not at its place, or not the only one", slot)?;
        let current = straddler.bounds == parts.boxes.swept().at(slot) && !straddler.bounds.is_empty();
        check(current || bits::test(parts.moved.words, slot), "a large object's box is not its own", slot)?;
    }
    Ok(())
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
