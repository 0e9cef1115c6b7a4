//! Shows the tree, for debug views.

use crate::access::Access;
use crate::geometry::aabb::Aabb;
use crate::geometry::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY, value};
use crate::id::{Id, Index};
use crate::memory::limits::SUB_LEVELS;
use crate::memory::slab::TreeParts;
use crate::tree::cells::{cell_of, divide};
use crate::tree::{Cell, SUB_LEAVES, UNSPLIT, axis_of, key_of};
use crate::world::World;

/// A leaf of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LeafView {
    /// The part of space whose minimum corners are at home in the leaf; infinite at the rim.
    pub cell: Aabb,
    /// The objects that were in it at the last step.
    pub objects: u32,
}

/// A plane of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlaneView {
    /// The axis that it divides: 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Its place on that axis.
    pub position: f32,
    /// The part of space that it divides; infinite at the rim.
    pub cell: Aabb,
    /// How many planes are above it.
    pub depth: u32,
}

/// The tree of the last step; nothing if there is none.
impl<I: Index> World<'_, I> {
    /// The leaves. [`Stats::leaves`](crate::Stats::leaves) also counts empty ones that are nowhere. O(leaves).
    #[doc(alias("debug_draw", "debug_render"))]
    pub fn leaves(&self) -> impl Iterator<Item = LeafView> + '_ {
        let (state, tree) = (&self.parts.state.tree, &self.parts.tree);
        let count = if self.has_tree() { state.count as usize } else { 0 };
        let all = (0..count).flat_map(move |whole| {
            let levels = if state.is_subdivided(whole) { SUB_LEVELS } else { 0 };
            let (cells, first) = (parts_of(tree, whole, levels), whole << state.sub_levels());
            (0..1 << levels).map(move |part| (cells.at(part), tree.leaves.at(first + part).len))
        });
        // What was not worth a division has no upper part.
        let somewhere = all.filter(|(cell, _)| cell.low()[0] < i32::MAX);
        somewhere.map(|(cell, objects)| LeafView { cell: shown(cell), objects })
    }

    /// The planes, each once. O(leaves · depth).
    pub fn planes(&self) -> impl Iterator<Item = PlaneView> + '_ {
        let (state, tree) = (&self.parts.state.tree, &self.parts.tree);
        let nodes = tree.nodes();
        let count = if self.has_tree() { state.count as usize } else { 0 };
        let inner = (1..2 * count)
            .map(|node| (node, tree.splits.at(node)))
            .filter(|(_, split)| split.as_leaf().is_none());
        let inner = inner.map(move |(node, split)| (split.plane, cell_of(nodes, node), nodes.depth(node)));
        let divided = (0..count).filter(|whole| state.is_subdivided(*whole));
        let below = divided.flat_map(move |whole| {
            (1..SUB_LEAVES).map(move |node| {
                let level = node.ilog2();
                let depth = nodes.depth(nodes.tops.at(whole) as usize) + level;
                let cell = parts_of(tree, whole, level).at(node - (1 << level));
                (tree.planes.at(whole * SUB_LEAVES + node), cell, depth)
            })
        });
        inner.chain(below).filter(|(plane, _, _)| key_of(*plane) != UNSPLIT).map(|(plane, cell, depth)| {
            PlaneView { axis: axis_of(plane), position: value(key_of(plane)), cell: shown(cell), depth }
        })
    }

    /// The large objects, which are in no leaf. O(large objects).
    pub fn large(&self) -> impl Iterator<Item = Id> + '_ {
        self.large_in_tree().filter_map(|slot| self.id_of(slot))
    }
}

/// The cells of a leaf of a full step, by planes of so many levels below it.
fn parts_of(tree: &TreeParts<'_>, whole: usize, levels: u32) -> [Cell; SUB_LEAVES] {
    let mut cells = [tree.cells.at(whole); SUB_LEAVES];
    divide(tree.planes.span(whole * SUB_LEAVES, SUB_LEAVES), levels, &mut cells);
    cells
}

/// Sides beyond all floats are infinite.
fn shown(cell: Cell) -> Aabb {
    let shown = |key: i32| key.clamp(NEGATIVE_INFINITY, POSITIVE_INFINITY);
    KeyBox { min: cell.low().map(shown), max: cell.high().map(shown) }.to_aabb()
}
