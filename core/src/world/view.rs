//! Shows the tree, for debug views.

use crate::access::Access;
use crate::geometry::aabb::Aabb;
use crate::geometry::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY, value};
use crate::id::{Id, Index};
use crate::tree::{UNSPLIT, axis_of, key_of};
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
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, layout};
/// const CONFIG: Config = Config::new(Capacity::for_objects(1000));
/// # let mut memory = Box::new(InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY);
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// for i in 0..1000u16 {
///     world.insert(Aabb::from_center([f32::from(i), 0.0, 0.0], [0.25; 3]))?;
/// }
/// world.step()?;
/// assert_eq!(world.leaves().map(|leaf| leaf.objects).sum::<u32>(), 1000);
/// assert_eq!(world.planes().count() + 1, world.leaves().count());
/// assert!(world.planes().all(|plane| plane.axis == 0)); // all objects stand in a row along x
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// The leaves, from left to right. O(leaves).
    pub fn leaves(&self) -> impl Iterator<Item = LeafView> + '_ {
        let tree = &self.parts.tree;
        (0..self.leaf_count()).map(|leaf| {
            let cell = tree.cells.at(leaf);
            let cell = KeyBox { min: cell.low(), max: cell.high() };
            LeafView { cell: shown(cell), objects: tree.leaves.at(leaf).len }
        })
    }

    /// The planes that divide a node, from the root down. O(leaves log leaves).
    pub fn planes(&self) -> impl Iterator<Item = PlaneView> + '_ {
        let planes = &*self.parts.tree.planes;
        let state = &*self.parts.state;
        let divides = move |node: usize| {
            // Planes below a leaf that is not divided yet divide nothing.
            let levels = (usize::BITS - 1 - node.leading_zeros()).checked_sub(state.tree.depth);
            let whole = |levels| !state.tree.is_subdivided((node >> levels) - (1 << state.tree.depth));
            key_of(planes.at(node)) != UNSPLIT && !levels.is_some_and(whole)
        };
        (1..self.leaf_count()).filter(move |&node| divides(node)).map(|node| {
            let depth = usize::BITS - 1 - node.leading_zeros();
            let mut cell = KeyBox { min: [i32::MIN; 3], max: [i32::MAX; 3] };
            for level in (0..depth).rev() {
                let plane = planes.at(node >> (level + 1));
                let (axis, key) = (axis_of(plane), key_of(plane));
                if node >> level & 1 == 1 {
                    cell.min[axis] = cell.min[axis].max(key);
                } else {
                    cell.max[axis] = cell.max[axis].min(key);
                }
            }
            let plane = planes.at(node);
            PlaneView { axis: axis_of(plane), position: value(key_of(plane)), cell: shown(cell), depth }
        })
    }

    /// The large objects, which are in no leaf. O(large objects).
    pub fn large(&self) -> impl Iterator<Item = Id> + '_ {
        self.large_in_tree().filter_map(|slot| self.id_of(slot))
    }

    fn leaf_count(&self) -> usize {
        if self.has_tree() { self.parts.state.leaves() as usize } else { 0 }
    }
}

/// Sides beyond all floats are infinite.
fn shown(cell: KeyBox) -> Aabb {
    let shown = |key: i32| key.clamp(NEGATIVE_INFINITY, POSITIVE_INFINITY);
    KeyBox { min: cell.min.map(shown), max: cell.max.map(shown) }.to_aabb()
}
