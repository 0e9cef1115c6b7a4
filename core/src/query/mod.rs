//! Answers questions between two steps, on the tree of the last one: what is in a region, what a moving box
//! meets, what is nearest.
//!
//! Answers are about the boxes as they are now, without margins. Objects that have changed since the last
//! step or [refresh](World::refresh) are looked at one by one, and so are all objects before the first one
//! with a tree. All numbers are computed in `f64` from the boxes' `f32`, in operations that keep the order of
//! their operands. So whatever the tree rules out, the exact test would too.

// In the order of use, in which the documentation lists the methods.
mod region;
mod cast;
mod nearest;
mod among;

pub use among::Among;
pub use cast::{Cast, Hit};
pub use region::{Planes, Region, Side, Volume};

use crate::access::{Access, bits};
use crate::geometry::aabb::narrowed;
use crate::geometry::key::{KeyBox, key};
use crate::id::{Id, Index};
use crate::memory::slab::Parts;
use crate::simd::{Simd, call, limit};
use crate::tree::large::Large;
use crate::tree::visit::{Probe, Visit};
use crate::tree::{Frame, Record, leaf_of, sub_leaves_of};
use crate::world::World;
use core::ops::ControlFlow;

impl<I: Index> World<'_, I> {
    /// Whether the tree holds every object that has not changed since the last step.
    pub(crate) fn has_tree(&self) -> bool {
        cfg!(feature = "large") && self.parts.state.tree.filled != 0
    }

    /// The leaf of a full step that holds a minimum corner, if there is a tree.
    pub(crate) fn leaf_in_tree(&self, min: &[i32; 3]) -> Option<usize> {
        let planes = (&*self.parts.tree.splits, self.parts.state.tree.height);
        self.has_tree().then(|| leaf_of(planes, min))
    }

    /// The large objects in the tree that have not changed.
    pub(crate) fn large_in_tree(&self) -> impl Iterator<Item = usize> + '_ {
        let tree = &self.parts.state.tree;
        let large = Large::new(tree, self.parts.tree.straddlers).list;
        let count = if self.has_tree() { large.len() } else { 0 };
        let slots = large.iter().take(count).map(|straddler| straddler.slot as usize);
        slots.filter(|&slot| is_current(&self.parts, slot))
    }

    /// The id of a living object.
    pub(crate) fn id_of(&self, slot: usize) -> Option<Id> {
        Id::new(slot as u32, self.parts.generations.at(slot))
    }
}

/// Whether the record of an object in the tree is up to date.
fn is_current<I: Index>(parts: &Parts<'_, I>, slot: usize) -> bool {
    parts.state.objects.dirty == 0 || !bits::test(parts.moved.words, slot)
}

/// A query: what it looks for, and what it has found. It meets the nodes that may hold answers. Each of its own
/// functions returns whether to look on.
trait Search: Probe {
    /// Looks at the members of a leaf of a full step.
    fn leaf<S: Simd>(&mut self, simd: S, whole: usize) -> ControlFlow<()>;

    /// Looks at the box of an object as it is now.
    fn object<S: Simd>(&mut self, simd: S, slot: usize) -> ControlFlow<()>;
}

/// Looks through a whole world: at the objects that the tree does not know, at large objects, as they are
/// often among the answers, and at leaves, from one on if there is a tree.
#[inline(always)]
fn walk<S: Simd, I: Index>(
    simd: S,
    world: &World<'_, I>,
    home: Option<usize>,
    search: impl Search,
) -> ControlFlow<()> {
    let (parts, mut from) = (&world.parts, 0);
    let mut leaves = Visit::new(parts.tree.nodes(), search);
    while let Some(slot) = match home {
        None => (from < parts.state.objects.slots as usize).then_some(from),
        Some(_) if parts.state.objects.dirty == 0 => None,
        Some(_) => parts.moved.first_from(from),
    } {
        from = slot + 1;
        if !KeyBox::of(parts.boxes.now, slot).is_empty() {
            let search = &mut leaves.probe;
            call!(simd, search.object(simd, slot))?;
        }
    }
    let Some(home) = home else { return ControlFlow::Continue(()) };
    if parts.state.tree.large > 0 {
        let large = Large::new(&parts.state.tree, parts.tree.straddlers);
        let mut groups = large.visit(leaves.probe);
        while let Some(group) = groups.next(simd) {
            for two in large.group(group).chunks(2) {
                let bounds =
                    [0, 1].map(|at| two.get(at).map_or(&KeyBox::NOTHING, |straddler| &straddler.bounds));
                let when = groups.probe.meet(simd, bounds);
                for (straddler, when) in two.iter().zip(when) {
                    let slot = straddler.slot as usize;
                    if groups.probe.is_met(when) && is_current(parts, slot) {
                        groups.probe.object(simd, slot)?;
                    }
                }
            }
        }
        leaves.probe = groups.probe;
    }
    leaves.start(simd, home);
    while let Some(whole) = leaves.next(simd) {
        leaves.probe.leaf(simd, whole)?;
    }
    ControlFlow::Continue(())
}

/// A region in the frame of a whole leaf, and which of its sub-leaves the region touches; bit zero if the
/// leaf is not divided.
#[inline(always)]
fn parts_near<S: Simd, I: Index>(
    simd: S,
    parts: &Parts<'_, I>,
    whole: usize,
    region: &KeyBox,
) -> (Record, u32) {
    let frame = parts.tree.frames.get(whole).unwrap_or(&Frame::NONE);
    let region = simd.record(frame, simd.keys(region), 0);
    let bounds = sub_leaves_of(parts.tree.bounds, parts.state.tree.sub_levels(), whole);
    (region, bounds.map_or(1, |bounds| simd.touching(bounds, limit(&region))))
}

/// The key of the greatest `f32` that is not above a number.
fn key_below(x: f64) -> i32 {
    key(narrowed(x))
}

/// The key of the least `f32` that is not below a number.
fn key_above(x: f64) -> i32 {
    key(-narrowed(-x))
}
