//! Checks the tree: each object that has not moved is once where the planes say, and the boxes of nodes hold it.

use super::content::{Content, LeafCounts, Place, Set};
use super::{Invalid, check};
use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::SUB_LEVELS;
use crate::memory::state::State;
use crate::simd::{EIGHT, Simd as _, scalar::Scalar};
use crate::tree::balance::depth_for;
use crate::tree::cells::divide;
use crate::tree::{Cell, axis_of, plane};

/// The number of nodes with planes, plus one for node zero, which there is not.
pub(crate) fn planes(state: &State, deepest: u32) -> usize {
    if state.tree.built == 0 { 0 } else { 1 << (depth_for(state.tree.built as usize, deepest) + SUB_LEVELS) }
}

/// The number of leaves. They have baselines even if they are not filled.
pub(crate) fn leaves(state: &State) -> usize {
    if state.tree.built == 0 { 0 } else { 1 << (state.tree.depth + state.tree.sub_levels()) }
}

/// Checks the planes and, if leaves are filled, all of them. O(slots + leaves log leaves).
pub(crate) fn tree<I: Index>(content: &mut impl Content<I>) -> Result<(), Invalid> {
    for node in 1..planes(content.state(), content.sizes().depth) {
        // Any key is right for a plane, but not any axis.
        let known = content.plane(node);
        check(plane(axis_of(known), known) == known, "a plane has no axis", node)?;
    }
    let slots = content.state().objects.slots as usize;
    for index in 0..leaves(content.state()) {
        let LeafCounts { len, room, baseline } = content.leaf(index);
        // So that it can be multiplied.
        check(baseline as usize <= slots, "a leaf was never so full", index)?;
        let empty = len == 0 && room == 0;
        check(content.state().tree.filled != 0 || empty, "a leaf that is not filled has room", index)?;
    }
    if content.state().tree.filled == 0 {
        return Ok(());
    }
    nodes(content)?;
    let mut filled = Filled { content, position: 0, packed: 0, current: 0 };
    let depth = filled.content.state().tree.depth;
    for whole in 0..1usize << depth {
        filled.whole(whole, depth)?;
    }
    filled.large()?;
    let known = filled.current;
    let state = filled.content.state();
    let words = 0..bits::words(slots);
    let moved: usize = words.map(|index| moved_and_living(filled.content, index)).sum();
    check(known + moved == state.objects.live as usize, "the tree does not hold every object once", known)
}

/// How many slots of a word hold an object that has moved.
fn moved_and_living<I: Index>(content: &impl Content<I>, index: usize) -> usize {
    let moved = bits::of_word(content.word(Set::Moved, index).unwrap_or(0));
    moved.filter(|bit| !content.now(index * 32 + bit).is_empty()).count()
}

/// The box of each node is valid and holds those below it, since nothing looks below a box that is not met.
fn nodes<I: Index>(content: &impl Content<I>) -> Result<(), Invalid> {
    let leaves = 1usize << content.state().tree.depth;
    for node in 1..2 * leaves {
        let around = content.node(node);
        check(around == KeyBox::NOTHING || around.is_valid(), "the box of a node is none", node)?;
        let holds = node == 1 || content.node(node / 2).contains(&around);
        check(holds, "the box of a node does not hold the one below", node)?;
    }
    Ok(())
}

/// A walk through the filled leaves.
struct Filled<'c, C> {
    content: &'c mut C,
    /// Records so far, with the free room of leaves and without.
    position: u64,
    packed: usize,
    /// Living objects so far that have not moved.
    current: usize,
}

impl<C> Filled<'_, C> {
    /// Checks one whole leaf and its sub-leaves.
    fn whole<I: Index>(&mut self, whole: usize, depth: u32) -> Result<(), Invalid>
    where
        C: Content<I>,
    {
        let sub_levels = self.content.state().tree.sub_levels();
        let cell = cell_of(self.content, depth, whole);
        let frame = self.content.frame(whole);
        check(frame.is_sound(), "a frame does not keep the order of numbers", whole)?;
        let divided = self.content.state().tree.is_subdivided(whole);
        let node = (1 << depth) + whole;
        let around = self.content.node(node);
        for part in 0..1usize << sub_levels {
            let index = whole << sub_levels | part;
            let LeafCounts { len, room, .. } = self.content.leaf(index);
            check(len <= room, "a leaf has more records than room", index)?;
            let stays_empty = sub_levels > 0 && !divided && part > 0;
            check(!stays_empty || room == 0, "a part of a whole leaf has room", index)?;
            let cell = if divided { cell_of(self.content, depth + sub_levels, index) } else { cell };
            let end = self.position + u64::from(room);
            // Records are read in groups of eight, also behind the last leaf.
            let last = self.content.sizes().records.saturating_sub(EIGHT) as u64;
            check(end <= last, "leaves have more records than there are", index)?;
            let members = self.members(index, len as usize)?;
            self.position = end;
            if members == Members::NONE {
                continue;
            }
            let inside = cell.holds(&members.around.min) && cell.holds(&members.highest);
            check(inside, "an object is not where the planes say", index)?;
            check(around.contains(&members.around), "the box of a node does not hold a member", node)?;
            // Lanes fall as boxes grow, so those of the box around all members are the least.
            let record = Scalar.record(&frame, members.around, 0);
            let bounds = self.content.bounds(index);
            let mut both = bounds;
            both.include(&record);
            check(sub_levels == 0 || both == bounds, "the bounds of a leaf do not hold a member", index)?;
        }
        Ok(())
    }

    /// Checks the members of a leaf. Objects that have moved or are gone are still where they were.
    #[inline(always)]
    fn members<I: Index>(&mut self, leaf: usize, len: usize) -> Result<Members, Invalid>
    where
        C: Content<I>,
    {
        let slots = self.content.state().objects.slots as usize;
        let mut members = Members::NONE;
        // More members than slots would be more than a snapshot has.
        check(self.packed + len <= slots, "the leaves have more members than there are slots", leaf)?;
        for place in 0..len {
            let slot = self.content.member(self.position as usize + place, self.packed + place);
            check(slot < slots, "a record is of no slot", leaf)?;
            let is_there = self.content.is_at(slot, Place::Leaf(leaf, place));
            check(is_there, "a record is not at its object's place, or not the only one", slot)?;
            if self.content.is_in(Set::Moved, slot) {
                continue;
            }
            let bounds = self.content.swept(slot);
            check(!bounds.is_empty(), "a record has no object", slot)?;
            members.around.include(&bounds);
            for k in 0..3 {
                members.highest[k] = members.highest[k].max(bounds.min[k]);
            }
            self.current += 1;
        }
        self.packed += len;
        Ok(members)
    }

    /// Checks the large objects.
    fn large<I: Index>(&mut self) -> Result<(), Invalid>
    where
        C: Content<I>,
    {
        let (slots, count) =
            (self.content.state().objects.slots as usize, self.content.state().tree.large as usize);
        for place in 0..count {
            let slot = self.content.large(place);
            check(slot < slots, "a large object is of no slot", place)?;
            let is_there = self.content.is_at(slot, Place::Large(place));
            check(is_there, "a large object is not at its place, or not the only one", slot)?;
            if !self.content.is_in(Set::Moved, slot) {
                check(!self.content.now(slot).is_empty(), "a large object is none", slot)?;
                self.current += 1;
            }
        }
        Ok(())
    }
}

/// The members of a leaf that have not moved.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Members {
    around: KeyBox,
    /// The greatest of their minima.
    highest: [i32; 3],
}

impl Members {
    const NONE: Self = Self { around: KeyBox::NOTHING, highest: [i32::MIN; 3] };
}

/// The cell of a leaf at a depth, cut along its path alone, so that no memory is needed.
fn cell_of<I: Index>(content: &impl Content<I>, depth: u32, leaf: usize) -> Cell {
    let node = (1 << depth) + leaf;
    let mut cell = Cell::ALL;
    for level in (0..depth).rev() {
        let mut halves = [cell; 2];
        divide(&[0, content.plane(node >> (level + 1))], 1, 1, &mut halves);
        cell = halves.at(node >> level & 1);
    }
    cell
}
