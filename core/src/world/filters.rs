//! Sets whom objects meet: see [`Filter`].

use super::World;
use crate::access::Access;
use crate::error::Error;
use crate::filter::{CLASSES, FILTERS, Filter, meet};
use crate::id::{Id, Index};

/// Whom objects meet. A rule of the caller's own comes with a step: [`with_rule`](World::with_rule).
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Cast, Config, Error, Filter, Id, InlineWorld, Region, Serial, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_filters();
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// const STATIC: u32 = 1;
/// let floor = world.insert(cube(0.0))?;
/// let wall = world.insert(cube(0.5))?;
/// let ball = world.insert(cube(0.75))?;
/// world.set_filter(floor, Filter::class(STATIC))?;
/// world.set_filter(wall, Filter::class(STATIC))?;
/// assert_eq!(world.step()?.pairs().len(), 3);
///
/// let mut meets = [u32::MAX; 32];
/// meets[STATIC as usize] &= !(1 << STATIC); // what is static does not meet what is
/// world.set_classes(&meets)?;
/// assert_eq!(world.step()?.pairs().len(), 2);
///
/// world.set_filter(ball, Filter::groups(1, 0))?; // meets nobody
/// assert!(world.step()?.pairs().is_empty());
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Sets whom an object meets. Its pairs follow at the next step. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`], [`Error::NoFilters`] or [`Error::BadClass`].
    #[doc(alias("set_collision_groups", "collision_layers"))]
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

    /// Whether an object meets whatever has a filter, by groups and classes; for queries, see [`among`](Self::among).
    /// In a world without filters objects have [`Filter::ALL`]. False for a stale id. O(1).
    #[must_use]
    pub fn meets(&self, id: Id, filter: &Filter) -> bool {
        let classes = &*self.parts.filters.classes;
        let row = |class: usize| if FILTERS && !classes.is_empty() { classes.at(class) } else { u32::MAX };
        let of = |slot: usize| self.parts.filters.of.get(slot).copied().unwrap_or_default();
        self.slot_of(id).is_ok_and(|slot| meet(&of(slot), filter, row))
    }

    /// Sets which classes meet. Two classes `a` and `b` meet if bit `b` of `meets[a]` and bit `a` of `meets[b]` are
    /// set. At first all classes meet. The next step looks for all pairs anew. O(n).
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

    /// Makes the next step ask about all pairs of an object again, after a [`Rule`](crate::Rule) has changed its
    /// answer. O(1).
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
        self.parts.state.objects.dirty = 1;
    }
}
