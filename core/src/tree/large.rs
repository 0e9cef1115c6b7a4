//! The large objects: one list, in groups of eight under a complete tree of their own, so that a road, a
//! cable or a ground is looked at only by what is near it.
//!
//! Boxes that are long on the same axes stand together, as a box around two that cross holds everything
//! between. Each half of the list is divided at a median, along the axis on which its boxes are thinnest
//! beside their spread. Behind the straddlers stand the boxes of nodes, then the list. Movers make the boxes
//! larger, and after enough changes the list is ordered anew.

use super::Straddler;
use super::enclose::expand_ancestors;
use super::limits::LARGE_PER_OBJECT;
use super::visit::{Probe, Shape, Visit};
use crate::access::Access;
use crate::geometry::key::{KeyBox, length};
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::memory::state::{TreeState, large_nodes};
use crate::simd::Simd;
use crate::sort::select;

/// Objects in a group.
const GROUP: usize = 8;
/// An object that takes another's place counts as so many changes of boxes.
const STRANGER: u32 = 16;
/// The list is ordered anew after so many changes for each of its objects.
const CHANGES: u32 = 4;
/// More levels than there can be.
const DEEPEST: u8 = 28;
/// A side counts as long if it is at least one in so many of the longest one.
const LONG: f32 = 8.0;

/// The depth of the tree: there is room for some more objects.
fn depth_for(large: u32) -> u8 {
    ((large + large / 8) / GROUP as u32 + 1).next_power_of_two().trailing_zeros() as u8
}

/// Whether so many large objects and the boxes of their nodes fit behind so many straddlers, and are few enough:
/// each is taken for as long as the world on half of the axes that planes are on. A single leaf has none.
pub(crate) fn fit<I: Index>(parts: &Parts<'_, I>, straddlers: u32, large: u32) -> bool {
    let (live, room) = (u64::from(parts.state.objects.live), parts.tree.straddlers.len() as u64);
    let (leaves, each) = (parts.state.tree.count.max(1), u64::from(large));
    let are_few = each << (leaves.ilog2() / 2) <= LARGE_PER_OBJECT * live;
    leaves == 1 || are_few && u64::from(straddlers) + large_nodes(depth_for(large)) as u64 + each <= room
}

/// Whether the list has room in its groups and in the array for so many objects.
pub(crate) fn has_room(tree: &TreeState, large: usize, room: usize) -> bool {
    tree.large_depth < DEEPEST && large <= GROUP << tree.large_depth && tree.large_list() + large <= room
}

/// The large objects and the boxes of their nodes, a complete tree.
#[derive(Clone, Copy)]
pub(crate) struct Large<'g> {
    pub(crate) list: &'g [Straddler],
    boxes: &'g [KeyBox],
    /// The first group.
    first: u32,
}

impl<'g> Shape<'g> for Large<'g> {
    fn boxes(&self) -> &'g [KeyBox] {
        self.boxes
    }

    fn below(&self, node: u32) -> Result<u32, usize> {
        if node < self.first { Ok(2 * node) } else { Err((node - self.first) as usize) }
    }
}

impl<'g> Large<'g> {
    pub(crate) fn new(tree: &TreeState, straddlers: &'g [Straddler]) -> Self {
        let list = straddlers.span(tree.large_list(), tree.large as usize);
        let nodes = straddlers.span(tree.large_start as usize, large_nodes(tree.large_depth));
        let boxes = bytemuck::try_cast_slice(nodes).unwrap_or_default();
        Self { list, boxes, first: 1 << tree.large_depth }
    }

    /// The walk to the groups that a probe meets.
    pub(crate) fn visit<P: Probe>(&self, probe: P) -> Visit<Self, P> {
        Visit::from_root(*self, probe)
    }

    pub(crate) fn group(&self, group: usize) -> &'g [Straddler] {
        let from = (group * GROUP).min(self.list.len());
        self.list.span(from, GROUP.min(self.list.len() - from))
    }

    /// The objects of the groups that a probe meets.
    #[inline(always)]
    pub(crate) fn each<S: Simd, P: Probe>(&self, simd: S, probe: P, mut each: impl FnMut(&Straddler)) {
        let mut visit = self.visit(probe);
        while let Some(group) = visit.next(simd) {
            self.group(group).iter().for_each(&mut each);
        }
    }
}

/// The list, and the boxes of its nodes.
pub(super) fn split<'g>(
    tree: &TreeState,
    straddlers: &'g mut [Straddler],
) -> (&'g mut [Straddler], &'g mut [KeyBox]) {
    let nodes = large_nodes(tree.large_depth);
    let both = straddlers.span_mut(tree.large_start as usize, nodes + tree.large as usize);
    let (nodes, list) = both.split_at_mut_checked(nodes).unwrap_or_default();
    (list, bytemuck::try_cast_slice_mut(nodes).unwrap_or_default())
}

/// The axes that a box is long on, a bit each.
fn long_axes(bounds: &KeyBox) -> u32 {
    let side = |k: usize| length(bounds.min[k], bounds.max[k]);
    let long = side(0).max(side(1)).max(side(2)) / LONG;
    (0..3).map(|k| u32::from(side(k) >= long) << k).sum()
}

/// Whether a box is much longer on one axis than on another.
pub(super) fn is_thin(bounds: &KeyBox) -> bool {
    long_axes(bounds) != 7
}

/// Brings the list into order. O(n log n).
fn order<I: Index>(parts: &mut Parts<'_, I>) {
    let tree = &mut parts.state.tree;
    tree.large_changed = 0;
    let (list, _) = split(tree, parts.tree.straddlers);
    for straddler in &mut *list {
        straddler.long = long_axes(&straddler.bounds);
    }
    for level in 0..tree.large_depth {
        let size = GROUP << (tree.large_depth - level);
        for part in list.chunks_mut(size.max(1)).filter(|part| part.len() > size / 2) {
            let axis = thinnest(part);
            let place =
                |straddler: &Straddler| (straddler.long, straddler.bounds.min.at(axis), straddler.slot);
            select(part, size / 2, &|a: &Straddler, b: &Straddler| place(a) < place(b));
        }
    }
    for (place, straddler) in list.iter().enumerate() {
        parts.place.put(straddler.slot as usize, I::from_slot(place as u32));
    }
}

/// The axis on which the boxes are thinnest beside the spread of their minima.
fn thinnest(list: &[Straddler]) -> usize {
    let (mut best, mut least) = (0, f32::INFINITY);
    for axis in 0..3 {
        let minima = list.iter().map(|straddler| straddler.bounds.min[axis]);
        let spread = length(minima.clone().min().unwrap_or(0), minima.max().unwrap_or(0));
        let side = |straddler: &Straddler| {
            length(straddler.bounds.min[axis], straddler.bounds.max[axis]).min(spread)
        };
        // NaN where all minima are the same.
        let share = list.iter().map(side).sum::<f32>() / spread;
        if share < least {
            (best, least) = (axis, share);
        }
    }
    best
}

/// Makes the boxes of the nodes for the list as it stands.
fn enclose<I: Index>(parts: &mut Parts<'_, I>) {
    let groups = 1usize << parts.state.tree.large_depth;
    let (list, nodes) = split(&parts.state.tree, parts.tree.straddlers);
    if nodes.is_empty() {
        return;
    }
    nodes.fill(KeyBox::NOTHING);
    for (node, group) in nodes.span_mut(groups, groups).iter_mut().zip(list.chunks(GROUP)) {
        group.iter().for_each(|straddler| node.include(&straddler.bounds));
    }
    for node in (2..2 * groups).rev() {
        let bounds = nodes.at(node);
        if let Some(parent) = nodes.get_mut(node / 2) {
            parent.include(&bounds);
        }
    }
}

/// Puts an object at a place of the list, or behind its end. Returns whether there was room.
pub(super) fn put<I: Index>(parts: &mut Parts<'_, I>, place: usize, straddler: Straddler) -> bool {
    let tree = &mut parts.state.tree;
    let (count, is_behind) = ((place as u32 + 1).max(tree.large), place as u32 >= tree.large);
    if !has_room(tree, count as usize, parts.tree.straddlers.len()) {
        return false;
    }
    tree.large = count;
    let (list, nodes) = split(tree, parts.tree.straddlers);
    let is_known = !is_behind && list.at(place).slot == straddler.slot;
    let cost = if is_known { u32::from(list.at(place).bounds != straddler.bounds) } else { STRANGER };
    tree.large_changed = tree.large_changed.saturating_add(cost);
    list.put(place, straddler);
    let group = if nodes.is_empty() { 0 } else { (1 << tree.large_depth) + place / GROUP };
    expand_ancestors(nodes, |node| node / 2, group, &straddler.bounds);
    parts.home.put(straddler.slot as usize, I::LARGE);
    parts.place.put(straddler.slot as usize, I::from_slot(place as u32));
    true
}

/// Takes the object at a place out of the list. The last one takes its place.
pub(super) fn take<I: Index>(parts: &mut Parts<'_, I>, place: usize) {
    let tree = &mut parts.state.tree;
    tree.large = tree.large.saturating_sub(1);
    let last = parts.tree.straddlers.at(tree.large_list() + tree.large as usize);
    if place < tree.large as usize {
        put(parts, place, last);
    }
}

/// Gives so many large objects, from a place in the array on, their place behind so many straddlers.
pub(super) fn seat<I: Index>(parts: &mut Parts<'_, I>, from: usize, straddlers: u32, large: u32) {
    let tree = &mut parts.state.tree;
    (tree.large_start, tree.large, tree.large_depth) = (straddlers, large, depth_for(large));
    let (to, count) = (tree.large_list(), large as usize);
    for index in 0..count {
        // From the end that is not written to yet.
        let index = if to > from { count - 1 - index } else { index };
        parts.tree.straddlers.put(to + index, parts.tree.straddlers.at(from + index));
    }
}

/// Gives the objects of the list their new boxes.
pub(super) fn renew<I: Index>(parts: &mut Parts<'_, I>) {
    let tree = &mut parts.state.tree;
    for straddler in split(tree, parts.tree.straddlers).0 {
        let bounds = parts.boxes.swept().at(straddler.slot as usize);
        tree.large_changed = tree.large_changed.saturating_add(u32::from(bounds != straddler.bounds));
        straddler.bounds = bounds;
    }
}

/// Whether the list is to be ordered anew, after some changes.
pub(crate) const fn is_due(tree: &TreeState) -> bool {
    tree.large as usize > GROUP && tree.large_changed / CHANGES > tree.large
}

/// Brings the list into order, `anew` or if that is due, and makes the boxes of the nodes. O(n log n), or O(n)
/// if it is not due.
pub(crate) fn arrange<I: Index>(parts: &mut Parts<'_, I>, anew: bool) {
    if anew || is_due(&parts.state.tree) {
        order(parts);
    }
    enclose(parts);
}
