//! Gives objects values for the caller's use: an entity, an index, a pointer.

use super::{Step, World};
use crate::access::bits;
use crate::error::Error;
use crate::id::{Id, Index};

/// Values of objects.
///
/// ```
/// use trisap_core::{Aabb, Capacity, Config, InlineWorld, Region, layout};
///
/// const CONFIG: Config = Config::new(Capacity::for_objects(16)).with_events().with_values();
/// const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;
///
/// let mut memory = InlineWorld::<BYTES>::EMPTY;
/// let mut world = memory.init::<u16>(&CONFIG)?;
/// let door = world.insert(Aabb::new([0.0; 3], [1.0; 3]))?;
/// let hand = world.insert(Aabb::new([1.0; 3], [2.0; 3]))?;
/// world.set_value(door, 4711)?;
/// world.set_value(hand, 12)?;
/// assert!(world.step()?.found_values().eq([[4711, 12]]));
///
/// world.visit_overlaps(&Region::Point([0.5; 3]), &mut |id| {
///     assert_eq!(world.value(id), Some(4711));
///     core::ops::ControlFlow::Continue(())
/// })?;
/// world.remove(door)?;
/// world.insert(Aabb::new([8.0; 3], [9.0; 3]))?; // has the slot of the door from now on, and the value 0
/// assert!(world.step()?.lost_values().eq([[4711, 12]]));
/// # Ok::<(), trisap_core::Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Gives an object a value; a new object has 0. Snapshots and [moves](Self::move_into) keep it. O(1).
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
        self.slot_of(id).ok().and_then(|slot| self.parts.values.of.get(slot).copied())
    }

    /// [`pairs`](Self::pairs) by value, without those of objects that were removed since the step. None in a world
    /// without values.
    pub fn pair_values(&self) -> impl Iterator<Item = [u64; 2]> {
        self.values_of(self.pair_ids())
    }

    /// [`found`](Self::found) by value, without those of objects that were removed since the step.
    pub fn found_values(&self) -> impl Iterator<Item = [u64; 2]> {
        self.values_of(self.found_ids())
    }

    /// [`lost`](Self::lost) by the values of the objects that were the pair, also if they are gone and others have
    /// their slots. Ask before you insert an object, as for [`lost_ids`](Self::lost_ids).
    pub fn lost_values(&self) -> impl Iterator<Item = [u64; 2]> {
        self.lost().iter().filter_map(|pair| {
            let [a, b] = pair.map(|slot| self.former_value(slot.at()));
            Some([a?, b?])
        })
    }

    fn values_of(&self, pairs: impl Iterator<Item = [Id; 2]>) -> impl Iterator<Item = [u64; 2]> {
        pairs.filter_map(|[a, b]| Some([self.value(a)?, self.value(b)?]))
    }

    /// The value of the object that had a slot in the complete step before the last one.
    fn former_value(&self, slot: usize) -> Option<u64> {
        let values = &self.parts.values;
        let is_reused = bits::test(self.parts.former.reused.words, slot);
        if is_reused { values.former.get(slot).copied() } else { values.of.get(slot).copied() }
    }
}

impl<'w, I: Index> Step<'w, I> {
    /// See [`World::pair_values`]; here none is missing.
    pub fn pair_values(&self) -> impl Iterator<Item = [u64; 2]> + use<'w, I> {
        self.world.pair_values()
    }

    /// See [`World::found_values`]; here none is missing.
    pub fn found_values(&self) -> impl Iterator<Item = [u64; 2]> + use<'w, I> {
        self.world.found_values()
    }

    /// See [`World::lost_values`].
    pub fn lost_values(&self) -> impl Iterator<Item = [u64; 2]> + use<'w, I> {
        self.world.lost_values()
    }
}
