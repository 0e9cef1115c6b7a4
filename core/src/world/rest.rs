//! Puts objects to rest, and wakes them. Steps then use this in [`persistent`](crate::pairs::persistent) and
//! [`intake`](crate::objects::intake).

use crate::access::bits;
use crate::error::Error;
use crate::id::{Id, Index, Pair};
use crate::memory::slab::Parts;
use crate::world::World;

/// Objects that the caller knows to rest. Steps find out about others by themselves.
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Cast, Config, Error, Filter, Id, InlineWorld, Region, Serial, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let sleeping = [world.insert(cube(0.0))?, world.insert(cube(0.5))?];
/// world.insert(cube(1.25))?;
/// world.set_resting(&sleeping)?;
/// let step = world.step()?;
/// assert_eq!(step.pairs().len(), 2);
/// assert!(step.awake_pairs().eq([[1, 2]])); // whose contacts may have changed
///
/// world.wake(&sleeping)?; // so does a box of its own
/// assert!(!world.is_resting(sleeping[0]));
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Puts objects to rest, all or none. The next step parks their pairs with each other, and steps ignore their
    /// boxes in the caller's array. An object wakes when it gets another box by [`set_aabb`](Self::set_aabb) or
    /// [`update_many`](Self::update_many). O(n).
    ///
    /// # Errors
    /// [`Error::StaleId`].
    #[doc(alias("sleep", "put_to_sleep", "deactivate"))]
    pub fn set_resting(&mut self, ids: &[Id]) -> Result<(), Error> {
        for id in ids {
            self.slot_of(*id)?;
        }
        let Parts { state, active, resting, .. } = &mut self.parts;
        for id in ids {
            let slot = id.slot() as usize;
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
        for id in ids {
            self.slot_of(*id)?;
        }
        for id in ids {
            bits::clear(self.parts.resting, id.slot() as usize);
        }
        Ok(())
    }

    /// The [`pairs`](Self::pairs) with at least one awake object: one that was not put to rest, or has been woken
    /// since. A narrow phase that keeps the contacts of resting objects needs only these. O(pairs).
    pub fn awake_pairs(&self) -> impl Iterator<Item = Pair<I>> {
        let rests = |slot: I| bits::test(self.parts.resting, slot.at());
        self.pairs().iter().copied().filter(move |[a, b]| !rests(*a) || !rests(*b))
    }

    /// Whether the object was put to rest and has not been woken since.
    #[doc(alias = "is_sleeping")]
    #[must_use]
    pub fn is_resting(&self, id: Id) -> bool {
        self.slot_of(id).is_ok_and(|slot| bits::test(self.parts.resting, slot))
    }
}
