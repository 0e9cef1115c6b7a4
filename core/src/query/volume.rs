//! Parts of space of the caller's own. The tree asks about the boxes of its nodes first, and about nothing in a node that is
//! wholly inside or outside.

use super::{Among, is_current};
use crate::access::{Access, note_fault};
use crate::error::Error;
use crate::geometry::aabb::{Aabb, widened};
use crate::geometry::key::KeyBox;
use crate::id::{Id, Index};
use crate::memory::limits::LEVELS;
use crate::simd::EIGHT;
use crate::tree::SUB_LEAVES;
use crate::world::World;
use arrayvec::ArrayVec;
use core::ops::ControlFlow;

/// How a box lies to a part of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Outside. Then each box inside it is outside, too.
    Outside,
    /// Neither for certain: it counts as touching.
    Across,
    /// Inside. Then each box inside it is inside, too.
    Inside,
}

/// A part of space to look for objects: of the caller's own, or [`Planes`].
pub trait Volume {
    /// How a box lies to it: that of an object, or one around many. [`Side::Across`] is right for any box that is not outside, and
    /// for any box around many; more certain answers save time.
    fn side(&self, aabb: &Aabb) -> Side;
}

/// What is on the inner side of some planes or touches it: a frustum of six, an oriented box, any convex part of space. A plane is a
/// normal that points outward, and its distance along that: `x` is inside where `normal * x <= distance`, in `f64`. A box is outside
/// if it is wholly beyond one plane, so that near edges and corners some boxes that are not quite inside count, as is usual in
/// culling. Where there is NaN in a plane, or infinities meet, a box counts as touching.
#[derive(Clone, Copy, Debug)]
pub struct Planes<'p>(pub &'p [[f64; 4]]);

impl Volume for Planes<'_> {
    fn side(&self, aabb: &Aabb) -> Side {
        let (low, high) = (aabb.min.map(widened), aabb.max.map(widened));
        let mut side = Side::Inside;
        for plane in self.0 {
            // Of the innermost corner and of the outermost. Rounded products and sums rise with their parts, so what is said of a box
            // holds for each box inside it.
            let (mut inner, mut outer) = (0.0, 0.0);
            for k in 0..3 {
                let normal = plane[k];
                let (a, b) = if normal == 0.0 { (0.0, 0.0) } else { (normal * low[k], normal * high[k]) };
                inner += a.min(b);
                outer += a.max(b);
            }
            if inner > plane[3] {
                return Side::Outside;
            }
            let is_inside = outer <= plane[3];
            side = if is_inside { side } else { Side::Across };
        }
        side
    }
}

/// What is in a part of space of the caller's own.
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, Planes, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let [a, b] = [world.insert(cube(0.0))?, world.insert(cube(5.0))?];
/// // Between two planes: x >= 3 and x + y <= 8.
/// let wedge = Planes(&[[-1.0, 0.0, 0.0, -3.0], [1.0, 1.0, 0.0, 8.0]]);
/// let mut found = [None; 2];
/// assert_eq!(world.within(&wedge, &mut found)?, 1);
/// assert_eq!(found[0], Some(b));
/// # assert!(world.contains(a));
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Visits the objects whose boxes are inside a part of space or across its border, each once, until the visitor breaks. The same
    /// calls give the same order. O(nodes and objects at the border + answers + movers since the last step).
    pub fn visit_within(&self, volume: &dyn Volume, visit: &mut dyn FnMut(Id) -> ControlFlow<()>) {
        let _ = self.walk_within(volume, visit);
    }

    /// Writes the objects whose boxes are inside a part of space or across its border to `out`, by ascending slot. Returns how many
    /// there are.
    ///
    /// # Errors
    /// [`Error::OutputFull`], which says how many there are; `out` then holds some of them.
    pub fn within(&self, volume: &dyn Volume, out: &mut [Option<Id>]) -> Result<usize, Error> {
        super::region::collected(out, &|_| true, |visit| {
            self.visit_within(volume, visit);
            Ok(())
        })
    }

    fn walk_within(
        &self,
        volume: &dyn Volume,
        visit: &mut dyn FnMut(Id) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (parts, tree) = (&self.parts, &self.parts.tree);
        let mut meet = |slot: usize, around: Side, bounds: &KeyBox| {
            let is_met = around == Side::Inside || volume.side(&bounds.to_aabb()) != Side::Outside;
            self.id_of(slot).filter(|_| is_met).map_or(ControlFlow::Continue(()), &mut *visit)
        };
        let mut waiting = ArrayVec::<(u32, Side), { LEVELS + 1 }>::new();
        if self.has_tree() {
            waiting.push((1, Side::Across));
        }
        while let Some((node, mut side)) = waiting.pop() {
            let bounds = KeyBox::of(tree.boxes, node as usize);
            if side == Side::Across && !bounds.is_empty() {
                side = volume.side(&bounds.to_aabb());
            }
            if side == Side::Outside || bounds.is_empty() {
                continue;
            }
            let split = tree.splits.at(node as usize);
            let Some(whole) = split.as_leaf() else {
                let children = [split.below + 1, split.below];
                if children.into_iter().any(|child| waiting.try_push((child, side)).is_err()) {
                    note_fault(tree.boxes.as_ptr().addr());
                }
                continue;
            };
            let sub_levels = parts.state.tree.sub_levels();
            for leaf in tree.leaves.span(whole << sub_levels, if sub_levels == 0 { 1 } else { SUB_LEAVES }) {
                // Eight boxes are read before the first is asked about, as they lie apart in memory.
                for eight in tree.records.span(leaf.start as usize, leaf.len as usize).chunks(EIGHT) {
                    let mut boxes = [KeyBox::EMPTY; EIGHT];
                    for (record, bounds) in eight.iter().zip(&mut boxes).filter(|_| side == Side::Across) {
                        *bounds = parts.boxes.now.at(record.slot() as usize);
                    }
                    for (record, bounds) in eight.iter().zip(&boxes) {
                        let slot = record.slot() as usize;
                        if is_current(parts, slot) {
                            meet(slot, side, bounds)?;
                        }
                    }
                }
            }
        }
        for slot in self.large_in_tree().chain(self.apart_from_tree()) {
            meet(slot, Side::Across, KeyBox::of(parts.boxes.now, slot))?;
        }
        ControlFlow::Continue(())
    }
}

impl<C: Fn(Id) -> bool, I: Index> Among<'_, '_, C, I> {
    /// See [`World::within`].
    ///
    /// # Errors
    /// Those of [`World::within`].
    pub fn within(&self, volume: &dyn Volume, out: &mut [Option<Id>]) -> Result<usize, Error> {
        super::region::collected(out, &self.condition, |visit| {
            self.world.visit_within(volume, visit);
            Ok(())
        })
    }
}
