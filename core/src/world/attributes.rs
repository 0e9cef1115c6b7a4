//! Sets what objects have beside boxes: whether they are enabled or rest, whom they meet, a margin, a value.

use super::World;
use crate::access::{Access, bits};
use crate::config::Margin;
use crate::error::Error;
use crate::filter::{CLASSES, Filter, meet};
use crate::id::{Id, Index};
use crate::memory::slab::Parts;

/// Attributes of objects. A rule of the caller's own about pairs: [`with_rule`](World::with_rule).
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Config, Error, Filter, InlineWorld, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_events().with_filters().with_values();
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// const STATIC: u32 = 1;
/// let [floor, wall, ball] = [world.insert(cube(0.0))?, world.insert(cube(0.5))?, world.insert(cube(0.75))?];
/// [floor, wall].iter().try_for_each(|id| world.set_filter(*id, Filter::class(STATIC)))?;
/// assert_eq!(world.step()?.pairs().len(), 3);
///
/// let mut meets = [u32::MAX; 32];
/// meets[STATIC as usize] &= !(1 << STATIC); // what is static does not meet what is
/// world.set_classes(&meets)?;
/// assert_eq!(world.step()?.pairs().len(), 2);
///
/// world.set_resting(&[wall, ball])?;
/// assert!(world.step()?.awake_pairs().eq([[0, 2]])); // whose contacts may have changed
/// world.wake(&[ball])?; // so does a box of its own
/// assert!(world.is_resting(wall) && !world.is_resting(ball));
///
/// world.set_value(ball, 4711)?;
/// world.set_value(wall, 12)?;
/// world.set_enabled(floor, false)?; // out of it for a while: parked, pooled, far away
/// assert_eq!(world.step()?.lost(), [[0, 2]]);
/// assert_eq!((world.len(), world.aabb(floor)), (3, Some(cube(0.0)))); // it is still there
/// assert!(world.pair_values().eq([[12, 4711]]));
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Disables an object, or enables it again. A disabled object is in no pair and in no answer, and costs a
    /// step nothing. It keeps its id, box, margin, filter and value, and can be given others; steps ignore
    /// its box in the caller's array. Its pairs are lost at the next step, and found at the next one after it
    /// is enabled. It [rests](Self::set_resting) until it is woken or moved, and is awake when enabled. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`].
    pub fn set_enabled(&mut self, id: Id, enabled: bool) -> Result<(), Error> {
        self.set_enabled_many(&[id], enabled)
    }

    /// [Disables](Self::set_enabled) objects or enables them again, all or none. O(n).
    ///
    /// # Errors
    /// [`Error::StaleId`].
    pub fn set_enabled_many(&mut self, ids: &[Id], enabled: bool) -> Result<(), Error> {
        self.check_ids(ids)?;
        for slot in ids.iter().map(|id| id.slot() as usize) {
            match (enabled, self.parts.boxes.now.at(slot).is_empty()) {
                (true, true) => self.enable(slot),
                (false, false) => self.disable(slot),
                _ => {}
            }
        }
        Ok(())
    }

    /// Whether an object is enabled. False for a stale id. O(1).
    #[must_use]
    pub fn is_enabled(&self, id: Id) -> bool {
        self.slot_of(id).is_ok_and(|slot| !self.parts.boxes.now.at(slot).is_empty())
    }

    fn disable(&mut self, slot: usize) {
        let parts = &mut self.parts;
        let bounds = parts.bounds(slot);
        let mut objects = parts.objects();
        objects.touch(slot);
        objects.hide(slot, bounds);
        // So that steps pass over its box in the caller's array.
        bits::set(parts.resting, slot);
        let objects = &mut parts.state.objects;
        (objects.live, objects.disabled, objects.resting) = (objects.live - 1, objects.disabled + 1, 1);
    }

    /// As where an object comes, but the slot had the same object before.
    fn enable(&mut self, slot: usize) {
        let parts = &mut self.parts;
        let bounds = parts.bounds(slot);
        parts.objects().anchor(slot, bounds);
        bits::clear(parts.resting, slot);
        let objects = &mut parts.state.objects;
        (objects.live, objects.disabled) = (objects.live + 1, objects.disabled - 1);
        parts.state.lists.stale = 1;
    }

    /// Puts objects to rest, all or none: objects that the caller knows to rest, as steps find out about
    /// others by themselves. The next step parks their pairs with each other, and steps ignore their boxes in
    /// the caller's array. An object wakes when it gets another box by [`set_aabb`](Self::set_aabb) or
    /// [`update_many`](Self::update_many). O(n).
    ///
    /// # Errors
    /// [`Error::StaleId`].
    #[doc(alias("sleep", "put_to_sleep", "deactivate"))]
    pub fn set_resting(&mut self, ids: &[Id]) -> Result<(), Error> {
        self.check_ids(ids)?;
        let Parts { state, active, resting, .. } = &mut self.parts;
        for slot in ids.iter().map(|id| id.slot() as usize) {
            bits::set(resting, slot);
            if !active.is_empty() && bits::test(active, slot) {
                bits::clear(active, slot);
                // No more can be active, so the next step looks at its pairs.
                state.pairs.active = u32::MAX;
            }
        }
        state.objects.resting |= u8::from(!ids.is_empty());
        Ok(())
    }

    /// Wakes objects, all or none: steps take their boxes from the caller's array again. O(n).
    ///
    /// # Errors
    /// [`Error::StaleId`].
    #[doc(alias("wake_up", "activate"))]
    pub fn wake(&mut self, ids: &[Id]) -> Result<(), Error> {
        self.check_ids(ids)?;
        ids.iter().for_each(|id| bits::clear(self.parts.resting, id.slot() as usize));
        Ok(())
    }

    /// Whether the object was put to rest and has not been woken since.
    #[doc(alias = "is_sleeping")]
    #[must_use]
    pub fn is_resting(&self, id: Id) -> bool {
        self.slot_of(id).is_ok_and(|slot| bits::test(self.parts.resting, slot))
    }

    /// Sets whom an object meets. Its pairs follow at the next step. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`], [`Error::NoFilters`] or [`Error::BadClass`].
    #[doc(alias("set_collision_groups", "collision_layers"))]
    pub fn set_filter(&mut self, id: Id, filter: Filter) -> Result<(), Error> {
        let slot = self.slot_of(id)?;
        let own = self.parts.filters.of.get_mut(slot).ok_or(Error::NoFilters)?;
        if filter.class as usize >= CLASSES {
            return Err(Error::BadClass { class: filter.class });
        }
        if core::mem::replace(own, filter) != filter {
            self.ask_again(slot);
        }
        Ok(())
    }

    /// Whom an object meets; `None` for a stale id, and in a world without filters.
    #[must_use]
    pub fn filter(&self, id: Id) -> Option<Filter> {
        self.attribute(id, self.parts.filters.of)
    }

    /// Whether an object meets a filter, by groups and classes; for queries, see [`among`](Self::among).
    /// In a world without filters objects have [`Filter::ALL`]. False for a stale id or a bad class. O(1).
    #[must_use]
    pub fn meets(&self, id: Id, filter: &Filter) -> bool {
        let row = |class: usize| self.parts.filters.classes.get(class).copied().unwrap_or(u32::MAX);
        let is_one = self.contains(id) && (filter.class as usize) < CLASSES;
        is_one && meet(&self.filter(id).unwrap_or_default(), filter, row)
    }

    /// Sets which classes meet. Two classes `a` and `b` meet if bit `b` of `meets[a]` and bit `a` of
    /// `meets[b]` are set. At first all classes meet. The next step looks for all pairs anew. O(n).
    ///
    /// # Errors
    /// [`Error::NoFilters`].
    #[doc(alias("object_layers", "collision_matrix"))]
    pub fn set_classes(&mut self, meets: &[u32; 32]) -> Result<(), Error> {
        if self.parts.filters.classes.is_empty() {
            return Err(Error::NoFilters);
        }
        self.parts.filters.classes.copy_in(meets);
        for slot in 0..self.parts.state.objects.slots as usize {
            if !self.parts.boxes.now.at(slot).is_free() {
                self.ask_again(slot);
            }
        }
        Ok(())
    }

    /// Which classes meet, as [`set_classes`](Self::set_classes) takes it; `None` in a world without filters.
    #[must_use]
    pub fn classes(&self) -> Option<[u32; 32]> {
        (*self.parts.filters.classes).try_into().ok()
    }

    /// Makes the next step ask about all pairs of an object again, after a [`Rule`](crate::Rule) has changed
    /// its answer. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`] or [`Error::NoFilters`].
    pub fn refilter(&mut self, id: Id) -> Result<(), Error> {
        let slot = self.slot_of(id)?;
        if self.parts.filters.of.is_empty() {
            return Err(Error::NoFilters);
        }
        self.ask_again(slot);
        Ok(())
    }

    fn ask_again(&mut self, slot: usize) {
        self.parts.filters.changed.set(slot);
        self.parts.objects().touch(slot);
    }

    /// Sets how far an object may move before it counts as moved, in place of the world's margin. It counts
    /// as moved once. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`], [`Error::NoMargins`]; [`Error::BadMargin`] for a negative or not finite `length`.
    pub fn set_margin(&mut self, id: Id, length: f32) -> Result<(), Error> {
        let slot = self.slot_of(id)?;
        Margin::length(length).check()?;
        *self.parts.boxes.margins.get_mut(slot).ok_or(Error::NoMargins)? = length;
        if !self.parts.boxes.now.at(slot).is_empty() {
            let bounds = self.parts.bounds(slot);
            self.parts.objects().anchor(slot, bounds);
        }
        Ok(())
    }

    /// How far an object may move before it counts as moved. `None` for a stale id, or without margins.
    #[must_use]
    pub fn margin(&self, id: Id) -> Option<f32> {
        self.attribute(id, self.parts.boxes.margins)
    }

    /// Gives an object a value for the caller's use, such as an entity, an index or a pointer; a new object
    /// has 0. Snapshots and [moves](Self::move_into) keep it. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`] or [`Error::NoValues`].
    #[doc(alias("user_data", "set_user_data"))]
    pub fn set_value(&mut self, id: Id, value: u64) -> Result<(), Error> {
        let slot = self.slot_of(id)?;
        *self.parts.values.of.get_mut(slot).ok_or(Error::NoValues)? = value;
        Ok(())
    }

    /// The value of an object. `None` for a stale id, and in a world without values. O(1).
    #[doc(alias = "user_data")]
    #[must_use]
    pub fn value(&self, id: Id) -> Option<u64> {
        self.attribute(id, self.parts.values.of)
    }

    fn attribute<T: Copy>(&self, id: Id, of: &[T]) -> Option<T> {
        of.get(self.slot_of(id).ok()?).copied()
    }
}
