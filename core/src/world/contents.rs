//! Looks up what is in a world: objects, their boxes and margins.

use super::World;
use crate::access::Access;
use crate::config::Capacity;
use crate::error::Error;
use crate::geometry::aabb::Aabb;
use crate::geometry::key::is_coarse;
use crate::id::{Id, Index};
use core::fmt;

/// Looking around.
impl<I: Index> World<'_, I> {
    /// How much fits into the world.
    #[must_use]
    pub fn capacity(&self) -> Capacity {
        self.config().capacity
    }

    /// Living objects, also disabled ones.
    #[must_use]
    pub fn len(&self) -> u32 {
        self.parts.state.objects.live + self.parts.state.objects.disabled
    }

    /// Whether there is no object.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether `id` names a living object.
    #[must_use]
    pub fn contains(&self, id: Id) -> bool {
        self.slot_of(id).is_ok()
    }

    /// The object that lives in `slot`.
    #[must_use]
    pub fn id_at(&self, slot: u32) -> Option<Id> {
        let lives =
            slot < self.parts.state.objects.slots && !self.parts.boxes.now.at(slot as usize).is_free();
        if lives { Id::new(slot, self.parts.generations.at(slot as usize)) } else { None }
    }

    /// The box of an object, as it was given last, but with 0.0 for -0.0.
    #[must_use]
    pub fn aabb(&self, id: Id) -> Option<Aabb> {
        self.slot_of(id).ok().map(|slot| self.parts.bounds(slot).to_aabb())
    }

    /// Whether `f32` is too coarse for some box at its place: a side is shorter than four steps of its
    /// coordinate. A box without any side counts only if the world has not even steps enough to tell such
    /// boxes apart. The pairs are right for the boxes as given, but the boxes may have lost their shape
    /// before; [shift the origin](Self::shift_origin). O(slots that have been in use): ask now and then.
    #[must_use]
    pub fn is_coarse(&self) -> bool {
        let boxes = self.parts.boxes.given().span(0, self.parts.state.objects.slots as usize);
        is_coarse(boxes.iter(), self.parts.state.objects.live)
    }

    pub(crate) fn slot_of(&self, id: Id) -> Result<usize, Error> {
        if self.id_at(id.slot()) == Some(id) { Ok(id.slot() as usize) } else { Err(Error::StaleId { id }) }
    }

    /// Checks that all of these live.
    pub(super) fn check_ids(&self, ids: &[Id]) -> Result<(), Error> {
        ids.iter().try_for_each(|id| self.slot_of(*id).map(drop))
    }

    /// The living objects by ascending slot. O(slots that have been in use).
    pub fn ids(&self) -> impl Iterator<Item = Id> {
        (0..self.parts.state.objects.slots).filter_map(|slot| self.id_at(slot))
    }

    /// The living objects and their boxes, by ascending slot. O(slots that have been in use).
    pub fn iter(&self) -> impl Iterator<Item = (Id, Aabb)> {
        self.ids().filter_map(|id| Some((id, self.aabb(id)?)))
    }

    /// The objects that an object overlaps in the last result. O(pairs): to ask for many objects, go through
    /// [`pairs`](Self::pairs) once.
    pub fn pairs_of(&self, id: Id) -> impl Iterator<Item = Id> {
        self.pair_ids().filter_map(move |[a, b]| match id {
            _ if id == a => Some(b),
            _ if id == b => Some(a),
            _ => None,
        })
    }

    /// Removes all objects. Their ids become stale, and their pairs are lost at the next step. O(slots that
    /// have been in use).
    pub fn clear(&mut self) {
        for slot in 0..self.parts.state.objects.slots {
            if let Some(id) = self.id_at(slot) {
                // It lives.
                let _ = self.remove(id);
            }
        }
    }
}

impl<I: Index> fmt::Debug for World<'_, I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("World")
            .field("len", &self.len())
            .field("pairs", &self.pairs().len())
            .field("found", &self.found().len())
            .field("lost", &self.lost().len())
            .field("config", &self.config())
            .finish_non_exhaustive()
    }
}
