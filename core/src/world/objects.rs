//! Inserts objects, gives them other boxes, and removes them.

use super::World;
use crate::access::{Access, bits};
use crate::config::MARGINS;
use crate::error::Error;
use crate::filter::Filter;
use crate::geometry::aabb::Aabb;
use crate::geometry::boxes::Boxes;
use crate::geometry::key::KeyBox;
use crate::id::{Id, Index};
use crate::memory::slab::Parts;
use crate::object::Object;
use crate::objects::margins::margin_length;

/// Objects. None of these calls changes the result of the last step; the next step sees all of them at once.
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Config, Error, Id, InlineWorld, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let one = world.insert(cube(0.0))?;
/// let boxes = [cube(2.0), cube(4.0)];
/// let more: Vec<Id> = world.insert_many(&boxes)?.collect();
///
/// world.set_aabb(one, cube(1.5))?; // or `set_object`: a box and what else there is
/// world.update_many(&more, &vec![cube(2.25), cube(9.0)])?; // or whatever `Boxes` can look at
/// assert_eq!(world.step()?.pairs(), [[0, 1]]);
///
/// world.remove(one)?;
/// assert_eq!(world.remove(one), Err(Error::StaleId { id: one })); // nothing happens by an id that is old
/// world.remove_many(&more)?;
/// assert!(world.is_empty());
/// # Ok::<(), Error>(())
/// ```
impl<'m, I: Index> World<'m, I> {
    /// Adds an object: a box, or an [`Object`] with a box and what else it has. Slots are given out in
    /// ascending order until an object is removed. O(1).
    ///
    /// # Errors
    /// [`Error::ObjectsFull`], or what [`Object::check`] gives: [`Error::BadBox`] for a box alone.
    #[doc(alias("create_proxy", "add"))]
    pub fn insert(&mut self, object: impl Into<Object>) -> Result<Id, Error> {
        let object = object.into();
        let bounds = object.bounds(self.parts.config())?;
        let id = self.insert_box(bounds)?;
        self.describe(id, &object)
    }

    /// Adds an object in a slot that the caller names, so that a server and its clients agree on slots. Its
    /// generation is this world's. O(free slots), and O(slots below) where it is the highest so far.
    ///
    /// # Errors
    /// [`Error::SlotTaken`]; [`Error::ObjectsFull`] where there is no such slot; what [`Object::check`]
    /// gives.
    pub fn insert_at(&mut self, slot: u32, object: impl Into<Object>) -> Result<Id, Error> {
        let object = object.into();
        let bounds = object.bounds(self.parts.config())?;
        if let Some(id) = self.id_at(slot) {
            return Err(Error::SlotTaken { id });
        }
        self.check_room(slot)?;
        let first = self.parts.state.objects.slots;
        if slot < first {
            self.unchain(slot);
        }
        // The slots below are as if objects had come and gone there, the lowest one last.
        for below in first..slot {
            self.parts.state.objects.slots += 1;
            self.fill_slot(below, bounds)?;
        }
        (first..slot).rev().for_each(|below| self.remove_slot(below as usize));
        self.parts.state.objects.slots = self.parts.state.objects.slots.max(slot + 1);
        let id = self.fill_slot(slot, bounds)?;
        self.describe(id, &object)
    }

    /// Gives an object another box. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`] or [`Error::BadBox`]; the object keeps its box.
    #[doc(alias("move_proxy", "update"))]
    pub fn set_aabb(&mut self, id: Id, aabb: Aabb) -> Result<(), Error> {
        self.slot_of(id)?;
        let bounds = KeyBox::from_aabb(&aabb).ok_or(Error::BadBox { index: 0 })?;
        self.accept(&[id], [bounds].into_iter());
        Ok(())
    }

    /// Gives an object another box, and what else an [`Object`] has, all or none. What that leaves out stays.
    /// O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`], or what [`Object::check`] gives.
    pub fn set_object(&mut self, id: Id, object: impl Into<Object>) -> Result<(), Error> {
        let object = object.into();
        self.slot_of(id)?;
        let bounds = object.bounds(self.parts.config())?;
        self.describe(id, &object)?;
        self.accept(&[id], [bounds].into_iter());
        Ok(())
    }

    /// Removes an object. Its id becomes stale, and its pairs are lost at the next step. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`].
    #[doc(alias("destroy_proxy", "delete"))]
    pub fn remove(&mut self, id: Id) -> Result<(), Error> {
        let slot = self.slot_of(id)?;
        self.remove_slot(slot);
        Ok(())
    }

    /// Adds objects, all or none. Gives their ids in the order of the boxes: `let ids: Vec<Id> =
    /// world.insert_many(boxes)?.collect()`. Objects whose ids you do not take are added when the iterator is
    /// dropped; if it is forgotten (`mem::forget`), only the taken ones are there. The world is whole. O(n).
    ///
    /// # Errors
    /// [`Error::BadBox`] or [`Error::ObjectsFull`].
    pub fn insert_many<'w, 'b>(
        &'w mut self,
        boxes: impl Into<Boxes<'b>>,
    ) -> Result<Inserted<'w, 'm, 'b, I>, Error> {
        let boxes = boxes.into();
        let needed = u64::from(self.len()) + boxes.len() as u64;
        if needed > self.parts.sizes.objects as u64 {
            return Err(Error::ObjectsFull { needed, room: self.parts.sizes.objects as u32 });
        }
        check_all(&boxes)?;
        Ok(Inserted { world: self, boxes, next: 0 })
    }

    /// Gives objects other boxes, all or none. O(n).
    ///
    /// # Errors
    /// [`Error::LengthMismatch`]: not as many boxes as ids; [`Error::StaleId`] or [`Error::BadBox`].
    pub fn update_many<'b>(&mut self, ids: &[Id], boxes: impl Into<Boxes<'b>>) -> Result<(), Error> {
        let boxes = boxes.into();
        if ids.len() != boxes.len() {
            return Err(Error::LengthMismatch { needed: ids.len(), given: boxes.len() });
        }
        self.check_ids(ids)?;
        check_all(&boxes)?;
        let bounds = |index| boxes.get(index).as_ref().and_then(KeyBox::from_aabb);
        self.accept(ids, (0..boxes.len()).filter_map(bounds));
        Ok(())
    }

    /// Removes objects, all or none. O(n).
    ///
    /// # Errors
    /// [`Error::StaleId`], also where an id comes twice.
    pub fn remove_many(&mut self, ids: &[Id]) -> Result<(), Error> {
        self.check_ids(ids)?;
        // All ids name living objects. So only an id that comes twice meets the mark of its first time.
        const MARK: u32 = 1 << 31;
        let toggle = |world: &mut Self, id: &Id| {
            let generation = world.parts.generations.at(id.slot() as usize);
            world.parts.generations.put(id.slot() as usize, generation ^ MARK);
        };
        for (index, id) in ids.iter().enumerate() {
            if let Err(error) = self.slot_of(*id) {
                ids.iter().take(index).for_each(|id| toggle(self, id));
                return Err(error);
            }
            toggle(self, id);
        }
        for id in ids {
            toggle(self, id);
            self.remove_slot(id.slot() as usize);
        }
        Ok(())
    }

    fn insert_box(&mut self, bounds: KeyBox) -> Result<Id, Error> {
        let parts = &mut self.parts;
        let free = parts.state.objects.free;
        let slot = if free > 0 { free - 1 } else { parts.state.objects.slots };
        if free > 0 {
            parts.state.objects.free = parts.boxes.now.at(slot as usize).next_free();
        } else {
            self.check_room(slot)?;
            self.parts.state.objects.slots += 1;
        }
        self.fill_slot(slot, bounds)
    }

    /// Gives a new object what it has beside its box.
    fn describe(&mut self, id: Id, object: &Object) -> Result<Id, Error> {
        object.filter.map_or(Ok(()), |filter| self.set_filter(id, filter))?;
        object.value.map_or(Ok(()), |value| self.set_value(id, value))?;
        object.margin.map_or(Ok(()), |length| self.set_margin(id, length))?;
        Ok(id)
    }

    fn check_room(&self, slot: u32) -> Result<(), Error> {
        let room = self.parts.sizes.objects as u32;
        if slot < room { Ok(()) } else { Err(Error::ObjectsFull { needed: u64::from(slot) + 1, room }) }
    }

    /// Takes a slot out of the chain of free ones.
    fn unchain(&mut self, slot: u32) {
        let Parts { state, boxes, .. } = &mut self.parts;
        let next = boxes.now.at(slot as usize).next_free();
        let mut at = state.objects.free;
        if at == slot + 1 {
            state.objects.free = next;
            return;
        }
        // As many as there can be.
        for _ in 0..state.objects.slots {
            let before = (at as usize).wrapping_sub(1);
            at = boxes.now.at(before).next_free();
            if at == slot + 1 {
                return boxes.now.put(before, KeyBox::free(next));
            }
        }
    }

    /// A new object in a slot that is free, and in no chain.
    fn fill_slot(&mut self, slot: u32, bounds: KeyBox) -> Result<Id, Error> {
        let (parts, at) = (&mut self.parts, slot as usize);
        parts.state.objects.live += 1;
        // After four billion objects in one slot an old id could match again. Zero is left out, so ids are
        // never zero.
        let former_generation = parts.generations.at(at);
        let generation = former_generation.wrapping_add(1).max(1);
        parts.generations.put(at, generation);
        if MARGINS
            && let (Some(margin), Some(length)) = (parts.config().margin, parts.boxes.margins.get_mut(at))
        {
            *length = margin_length(&margin, &bounds);
        }
        parts.objects().insert(at, bounds);
        if let Some(filter) = parts.filters.of.get_mut(at) {
            *filter = Filter::ALL;
        }
        let Parts { former, values, .. } = parts;
        if parts.state.objects.has_inserted == 0 {
            former.reused.clear();
        }
        let former_value = values.of.get_mut(at).map(core::mem::take);
        if former_generation != 0 && !bits::test(former.reused.words, at) {
            // With events, so that lost pairs can be named.
            former.reused.set(at);
            former.generations.get_mut(at).into_iter().for_each(|to| *to = former_generation);
            values.former.get_mut(at).into_iter().zip(former_value).for_each(|(to, value)| *to = value);
        }
        parts.state.objects.has_inserted = 1;
        parts.state.lists.stale = 1;
        // The generation is not zero.
        Id::new(slot, generation).ok_or(Error::NotAWorld)
    }

    /// Gives living objects other boxes.
    fn accept(&mut self, ids: &[Id], boxes: impl Iterator<Item = KeyBox>) {
        let parts = &mut self.parts;
        ids.iter().for_each(|id| bits::clear(parts.resting, id.slot() as usize));
        let mut objects = parts.objects();
        for (id, bounds) in ids.iter().zip(boxes) {
            objects.accept(id.slot() as usize, bounds);
        }
        let outran = objects.fat.rule.outran;
        parts.state.objects.outran = parts.state.objects.outran.saturating_add(outran);
    }

    fn remove_slot(&mut self, slot: usize) {
        let parts = &mut self.parts;
        let next = parts.state.objects.free;
        bits::clear(parts.resting, slot);
        if parts.boxes.now.at(slot).is_empty() {
            parts.state.objects.disabled -= 1;
        } else {
            parts.state.objects.live -= 1;
        }
        parts.objects().remove(slot, next);
        parts.state.objects.free = slot as u32 + 1;
    }
}

/// The ids of new objects: see [`World::insert_many`]. When it is dropped, it adds the rest.
pub struct Inserted<'w, 'm, 'b, I: Index = u32> {
    world: &'w mut World<'m, I>,
    boxes: Boxes<'b>,
    next: usize,
}

impl<I: Index> Iterator for Inserted<'_, '_, '_, I> {
    type Item = Id;

    fn next(&mut self) -> Option<Id> {
        let bounds = self.boxes.get(self.next).as_ref().and_then(KeyBox::from_aabb)?;
        self.next += 1;
        // There is room, as `insert_many` has checked.
        self.world.insert_box(bounds).ok()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.boxes.len() - self.next;
        (left, Some(left))
    }
}

impl<I: Index> ExactSizeIterator for Inserted<'_, '_, '_, I> {}

impl<I: Index> Drop for Inserted<'_, '_, '_, I> {
    fn drop(&mut self) {
        self.for_each(drop);
    }
}

fn check_all(boxes: &Boxes<'_>) -> Result<(), Error> {
    let bad = (0..boxes.len()).find(|&index| boxes.get(index).as_ref().and_then(KeyBox::from_aabb).is_none());
    match bad {
        Some(index) => Err(Error::BadBox { index: index as u32 }),
        None => Ok(()),
    }
}
