//! Disables objects, and enables them again.

use super::World;
use crate::access::{Access, bits};
use crate::error::Error;
use crate::id::{Id, Index};
use crate::lists::links;

/// Objects that are out of it for a while: parked, pooled, far away.
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, Region, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_events();
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let [crate_, shelf] = [world.insert(cube(0.0))?, world.insert(cube(0.5))?];
/// world.step()?;
///
/// world.set_enabled(crate_, false)?;
/// assert_eq!(world.step()?.lost(), [[0, 1]]);
/// assert_eq!((world.len(), world.aabb(crate_)), (2, Some(cube(0.0)))); // it is still there
///
/// world.set_aabb(crate_, cube(1.25))?; // moved while nobody looks
/// world.set_enabled(crate_, true)?;
/// assert_eq!(world.step()?.found(), [[0, 1]]);
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Disables an object, or enables it again. A disabled object is in no pair and in no answer, and costs a step
    /// nothing. It keeps its id, box, margin, filter and value, and can be given others; steps ignore its box in the
    /// caller's array. Its pairs are lost at the next step, and found at the next one after it is enabled. It counts as
    /// [resting](Self::set_resting), and is awake when it is enabled. O(1).
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
        for id in ids {
            self.slot_of(*id)?;
        }
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
        let bounds = parts.boxes.now.at(slot);
        let mut objects = parts.objects();
        objects.touch(slot);
        objects.hide(slot, bounds);
        // So that steps pass over its box in the caller's array.
        bits::set(parts.resting, slot);
        let objects = &mut parts.state.objects;
        (objects.live, objects.disabled) = (objects.live - 1, objects.disabled + 1);
        (objects.resting, objects.dirty) = (1, 1);
    }

    /// As where an object comes, but the one that had the slot before is the same.
    fn enable(&mut self, slot: usize) {
        let parts = &mut self.parts;
        let bounds = parts.bounds(slot);
        let mut objects = parts.objects();
        objects.anchor(slot, bounds);
        objects.now.put(slot, bounds);
        bits::clear(parts.resting, slot);
        let objects = &mut parts.state.objects;
        (objects.live, objects.disabled) = (objects.live + 1, objects.disabled - 1);
        objects.dirty = 1;
        links::append(parts, slot as u32);
    }
}
