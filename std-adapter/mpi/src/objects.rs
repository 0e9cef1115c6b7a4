//! Objects come, move and go.

use crate::fault::Fault;
use crate::message::NOWHERE;
use crate::table::Object;
use crate::world::SplitWorld;
use trisap::Aabb;

/// Objects. The next step sees these calls.
impl SplitWorld {
    /// Adds an object, on any rank. Its key must not be that of another living object of any rank: what the next step
    /// sees of that ends all ranks.
    ///
    /// # Errors
    /// [`Fault::BadBox`] or [`Fault::KeyTaken`].
    pub fn insert(&mut self, key: u64, aabb: Aabb) -> Result<(), Fault> {
        self.give(Object { key, now: aabb, before: NOWHERE })
    }

    /// Adds an object that may have been there in the last step.
    pub(crate) fn give(&mut self, object: Object) -> Result<(), Fault> {
        let key = object.key;
        if !object.now.is_valid() {
            return Err(Fault::BadBox { key });
        }
        if self.owns(key) || self.given_keys.contains_key(&key) {
            return Err(Fault::KeyTaken { key });
        }
        self.given_keys.insert(key, self.given.len());
        self.given.push(object);
        Ok(())
    }

    /// Gives an object that this rank owns another box.
    ///
    /// # Errors
    /// [`Fault::BadBox`] or [`Fault::NotOwned`].
    pub fn set(&mut self, key: u64, aabb: Aabb) -> Result<(), Fault> {
        if !aabb.is_valid() {
            return Err(Fault::BadBox { key });
        }
        match self.local.table.slot_of(key) {
            Some(slot) if self.local.table.is_owned(slot) => self.local.table.set(slot, aabb),
            _ => return Err(Fault::NotOwned { key }),
        }
        Ok(())
    }

    /// Asks for a box for each object that this rank owns. Faster than to [set](Self::set) them one by one.
    ///
    /// # Errors
    /// [`Fault::BadBox`] for the first bad one; that object and those after it keep their boxes.
    pub fn update(&mut self, mut next: impl FnMut(u64, &Aabb) -> Aabb) -> Result<(), Fault> {
        let table = &mut self.local.table;
        for slot in 0..table.slots() as u32 {
            if table.is_owned(slot) {
                let key = table.key(slot);
                let aabb = next(key, &table.now[slot as usize]);
                if !aabb.is_valid() {
                    return Err(Fault::BadBox { key });
                }
                table.set(slot, aabb);
            }
        }
        Ok(())
    }

    /// Removes an object that this rank owns. Its key may be used again at once.
    ///
    /// # Errors
    /// [`Fault::NotOwned`].
    pub fn remove(&mut self, key: u64) -> Result<(), Fault> {
        let table = &mut self.local.table;
        let slot = table.slot_of(key).filter(|&slot| table.is_owned(slot)).ok_or(Fault::NotOwned { key })?;
        table.set(slot, NOWHERE);
        self.removed.push(table.get(slot));
        self.local.remove(slot);
        Ok(())
    }
}
