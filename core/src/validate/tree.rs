//! Checks the tree: each object that has not moved is once where the planes say; the boxes of nodes hold it.

use crate::access::{Access, bits};
use crate::filter::offer;
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::simd::{EIGHT, Simd as _, scalar::Scalar};
use crate::snapshot::check::{Invalid, check};
use crate::tree::cells::cell_of;
use crate::tree::large::Large;
use crate::tree::{Record, SUB_LEAVES, axis_of, home_of, plane};

/// Checks the planes and, if leaves are filled, all of them. O(slots + leaves log leaves).
pub(super) fn tree<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let state = &parts.state.tree;
    shape(parts)?;
    if state.filled == 0 {
        return Ok(());
    }
    nodes(parts)?;
    cells(parts)?;
    let (mut end, mut placed) = (0, state.large as usize);
    for index in 0..(state.count as usize) << state.sub_levels() {
        let leaf = parts.tree.leaves.at(index);
        check(leaf.start == end && leaf.len <= leaf.room, "leaves do not stand one behind another", index)?;
        end += leaf.room;
        placed += leaf.len as usize;
        // Records are read in groups of eight, also behind the last leaf.
        check(end as usize + EIGHT <= parts.sizes.records(), "more records than there are", index)?;
        for (place, record) in leaf.members(parts.tree.records).iter().enumerate() {
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

/// Each leaf and each node but the root is once below another, and each plane has an axis.
fn shape<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let (nodes, count) = (parts.tree.nodes(), parts.state.tree.count as usize);
    for node in 1..2 * count {
        let split = nodes.splits.at(node);
        let known = match split.as_leaf() {
            // Walks have one length, and end in a leaf that is below itself.
            Some(leaf) => {
                let reached =
                    nodes.depth(node) <= parts.state.tree.height.into() || parts.state.tree.filled == 0;
                leaf < count
                    && nodes.tops.at(leaf) as usize == node
                    && split.below as usize == node
                    && reached
            }
            None => {
                let pair = split.below as usize / 2;
                let axis = plane(axis_of(split.plane), split.plane) == split.plane;
                axis && split.below % 2 == 0 && pair < count && nodes.above(2 * pair) == node
            }
        };
        check(known, "a node is not where the one above says, or a plane has no axis", node)?;
        let top = (0..nodes.depth(node)).fold(node, |node, _| nodes.above(node));
        check(top == 1, "a node is not below the root", node)?;
    }
    let divided = (0..count).filter(|whole| parts.state.tree.is_subdivided(*whole));
    for at in divided.flat_map(|whole| whole * SUB_LEAVES + 1..(whole + 1) * SUB_LEAVES) {
        let known = parts.tree.planes.at(at);
        check(plane(axis_of(known), known) == known, "a plane has no axis", at)?;
    }
    Ok(())
}

/// The box of each node is valid and holds the boxes below it, since nothing looks below a box that is not
/// met.
fn nodes<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let nodes = parts.tree.nodes();
    check(nodes.boxes.at(0) == KeyBox::NOTHING, "there is a node zero", 0)?;
    for node in 1..2 * parts.state.tree.count as usize {
        let around = nodes.boxes.at(node);
        check(around == KeyBox::NOTHING || around.is_valid(), "the box of a node is none", node)?;
        let holds = node == 1 || nodes.boxes.at(nodes.above(node)).contains(&around);
        check(holds, "the box of a node does not hold the one below", node)?;
    }
    Ok(())
}

/// A record is its box's in the frame of its leaf, and what is around it holds it.
fn member<I: Index>(parts: &Parts<'_, I>, leaf: usize, record: &Record) -> Result<(), Invalid> {
    let (state, tree) = (&parts.state.tree, &parts.tree);
    let (slot, sub_levels) = (record.slot() as usize, state.sub_levels());
    let whole = leaf >> sub_levels;
    let bounds = parts.boxes.swept().at(slot);
    check(!bounds.is_empty(), "a record has no object", slot)?;
    let home = home_of(tree, parts.state, &bounds.min);
    check(home == leaf, "an object is not where the planes say", slot)?;
    let mut expected = Scalar.record(&tree.frames.at(whole), bounds, slot as u32);
    // Nobody reads the marks in divided leaves: a full step makes them anew.
    expected.tag |= match sub_levels {
        0 => tree.cells.at(leaf).classify(Scalar, bounds).marks(),
        _ => record.tag & Record::STRADDLES,
    };
    check(*record == expected, "a record is not that of its box", slot)?;
    let around = tree.nodes().around(whole);
    check(around.contains(&bounds), "the box of a node does not hold a member", slot)?;
    let mut both = tree.bounds.at(leaf);
    both.include(record);
    both.tag |= offer(parts.filters.of, slot);
    let same = both == tree.bounds.at(leaf);
    check(sub_levels == 0 || same, "the bounds of a leaf do not hold a member", leaf)
}

/// Large objects stand in their list, with their boxes.
fn large<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let state = &parts.state.tree;
    let large = Large::new(state, parts.tree.straddlers);
    for (place, straddler) in large.list.iter().enumerate() {
        let slot = straddler.slot as usize;
        let is_there = slot < parts.state.objects.slots as usize
            && parts.home.at(slot) == I::LARGE
            && parts.place.at(slot).at() == place;
        check(is_there, "a large object is not at its place, or not the only one", slot)?;
        let current = straddler.bounds == parts.boxes.swept().at(slot) && !straddler.bounds.is_empty();
        check(current || bits::test(parts.moved.words, slot), "a large object's box is not its own", slot)?;
        let mut met = false;
        large.each(Scalar, straddler.bounds, |other| met |= core::ptr::eq(other, straddler));
        check(met, "the boxes of nodes do not hold a large object", slot)?;
    }
    Ok(())
}

/// The cells are as the planes say.
fn cells<I: Index>(parts: &Parts<'_, I>) -> Result<(), Invalid> {
    let (state, tree) = (&parts.state.tree, &parts.tree);
    for leaf in 0..state.count as usize {
        let (known, cell) = (tree.cells.at(leaf), cell_of(tree.nodes(), tree.tops.at(leaf) as usize));
        let same = (cell.low(), cell.high()) == (known.low(), known.high());
        check(same, "a cell is not that of its planes", leaf)?;
    }
    Ok(())
}
