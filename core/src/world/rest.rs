//! Objects that the caller puts to rest and wakes. What a step makes of them is in [`persistent`](crate::pairs::persistent) and
//! [`ingest`](crate::objects::intake).

use crate::access::bits;
use crate::error::Error;
use crate::id::{Id, Index};
use crate::memory::slab::Parts;
use crate::world::World;

/// Objects that the caller knows to rest, beside those that are seen to.
impl<I: Index> World<'_, I> {
    /// Puts objects to rest, all or none: the next step parks their pairs with each other, and steps do not look at
    /// what the bounds array has for them. An object that gets another box by [`set_aabb`](Self::set_aabb) or
    /// [`update_many`](Self::update_many) wakes. O(n).
    ///
    /// # Errors
    /// [`Error::StaleId`].
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
                // More than can be, so that the next step looks at its pairs.
                state.pairs.active = u32::MAX;
            }
        }
        state.objects.resting |= u8::from(!ids.is_empty());
        Ok(())
    }

    /// Has steps look at the bounds array for objects again, all or none. O(n).
    ///
    /// # Errors
    /// [`Error::StaleId`].
    pub fn wake(&mut self, ids: &[Id]) -> Result<(), Error> {
        for id in ids {
            self.slot_of(*id)?;
        }
        for id in ids {
            bits::clear(self.parts.resting, id.slot() as usize);
        }
        Ok(())
    }

    /// Whether the object was put to rest and has not been woken since.
    #[must_use]
    pub fn is_resting(&self, id: Id) -> bool {
        self.slot_of(id).is_ok_and(|slot| bits::test(self.parts.resting, slot))
    }
}
