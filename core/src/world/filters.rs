//! Whom objects meet: see [`Filter`].

use super::World;
use crate::access::Access;
use crate::error::Error;
use crate::filter::{CLASSES, Filter};
use crate::id::{Id, Index};

impl<I: Index> World<'_, I> {
    /// Sets whom an object meets. Its pairs follow at the next step. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`], [`Error::NoFilters`] or [`Error::BadClass`].
    pub fn set_filter(&mut self, id: Id, filter: Filter) -> Result<(), Error> {
        let slot = self.slot_of(id)?;
        if self.parts.filters.of.is_empty() {
            return Err(Error::NoFilters);
        }
        if filter.class as usize >= CLASSES {
            return Err(Error::BadClass { class: filter.class });
        }
        if self.filter(id) != Some(filter) {
            self.parts.filters.of.put(slot, filter);
            self.ask_again(slot);
        }
        Ok(())
    }

    /// Whom an object meets; `None` for a stale id, and in a world without filters.
    #[must_use]
    pub fn filter(&self, id: Id) -> Option<Filter> {
        self.slot_of(id).ok().and_then(|slot| self.parts.filters.of.get(slot).copied())
    }

    /// Sets which classes meet: bit `b` of `meets[a]` says whether `a` meets `b`, and the same for `meets[b]`; both have to
    /// be set. All classes meet at first. All pairs are looked for anew at the next step. O(n).
    ///
    /// # Errors
    /// [`Error::NoFilters`].
    pub fn set_classes(&mut self, meets: &[u32; 32]) -> Result<(), Error> {
        if self.parts.filters.classes.is_empty() {
            return Err(Error::NoFilters);
        }
        self.parts.filters.classes.copy_in(meets);
        for slot in 0..self.parts.state.objects.slots as usize {
            if !self.parts.boxes.now.at(slot).is_empty() {
                self.ask_again(slot);
            }
        }
        Ok(())
    }

    /// Has the next step ask about all pairs of an object again, for a [`Rule`](crate::Rule) that has changed its mind. O(1).
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
        self.parts.moved.set(slot);
        self.parts.changed.set(slot);
        self.parts.state.objects.dirty = 1;
    }
}
