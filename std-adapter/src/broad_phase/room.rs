//! More room and less, and snapshots.

use super::contacts::Numbers;
use super::names::Names;
use super::{BroadPhase, FIRST};
use crate::OwnedWorld;
use core::hash::Hash;
use trisap_contacts::Contacts;
use trisap_core::{Capacity, Config, Error, Id, World};

/// A broad phase as it was: see [`BroadPhase::save`].
#[derive(Clone, Debug)]
pub struct Snapshot<K> {
    pub(super) bytes: Vec<u8>,
    pub(super) capacity: Capacity,
    pub(super) names: Names<K>,
    pub(super) complete: bool,
    /// The memory of contacts, if there are any.
    pub(super) contacts: Option<Vec<u32>>,
}

/// Room, and snapshots.
impl<K: Copy + Eq + Hash> BroadPhase<K> {
    /// Makes room for so many more boxes than there are, so that the world does not move while they come. O(bytes) if it has to.
    ///
    /// # Errors
    /// [`Error::NoMemory`] or [`Error::CapacityTooLarge`].
    pub fn reserve(&mut self, additional: usize) -> Result<(), Error> {
        let objects = u32::try_from(self.len().saturating_add(additional)).unwrap_or(u32::MAX);
        if objects > self.config.capacity.objects {
            let (more, now) = (Capacity::for_objects(objects), self.config.capacity);
            let leaf_refs = more.leaf_refs.max(now.leaf_refs);
            self.grow(more.with_pairs(more.pairs.max(now.pairs)).with_leaf_refs(leaf_refs))?;
        }
        self.names.reserve(additional);
        Ok(())
    }

    /// Gives memory back after a crowd has gone: afterwards there is room for what is there, and a quarter more pairs. Boxes, rest,
    /// filters, values and margins stay, the next step tells right events; until then there is no result. Does nothing if little
    /// would be gained, if the last step has failed, or with [contacts](Self::keep_contacts). O(bytes), and the next step takes as long as the first one.
    ///
    /// # Errors
    /// [`Error::NoMemory`]; nothing has changed then.
    pub fn shrink_to_fit(&mut self) -> Result<(), Error> {
        let old = self.owned.as_world();
        let pairs = self.pairs().count() as u32;
        let fitting = Capacity::for_objects((self.len() as u32).max(FIRST));
        let capacity = fitting.with_pairs(fitting.pairs.max(pairs + pairs / 4));
        let now = self.config.capacity;
        if self.numbers.is_some()
            || !self.complete
            || capacity.objects > now.objects / 2 && capacity.pairs > now.pairs / 2
        {
            return Ok(());
        }
        let config = self.config.with_capacity(capacity);
        let mut owned = OwnedWorld::new(&config)?;
        let ids = owned.change(|world| {
            self.names.living().map(|named| copy(old, named.id, world)).collect::<Result<Vec<_>, _>>()
        })?;
        if let Some(classes) = old.classes() {
            owned.change(|world| world.set_classes(&classes))?;
        }
        self.names.rename(&ids, old);
        (self.owned, self.config) = (owned, config);
        Ok(())
    }

    pub(super) fn grow(&mut self, capacity: Capacity) -> Result<(), Error> {
        let mut config = self.config.with_capacity(capacity);
        config.lean &= capacity.objects <= 256;
        self.owned.move_to(&config)?;
        self.config = config;
        Ok(())
    }

    /// Boxes, keys, and what the next events are compared with: for files and for those who join late. To go back within
    /// a program, a copy is faster: see [`clone_from`](Clone::clone_from).
    #[must_use]
    pub fn save(&self) -> Snapshot<K> {
        let world = self.as_world();
        let mut bytes = vec![0; world.snapshot_size()];
        // As long as the world has said.
        let written = world.save(&mut bytes);
        debug_assert_eq!(written, Ok(bytes.len()));
        let (capacity, names, complete) = (self.config.capacity, self.names.clone(), self.complete);
        let contacts = self.numbers.as_ref().map(|numbers| numbers.contacts.memory().clone());
        Snapshot { bytes, capacity, names, complete, contacts }
    }

    /// Becomes the broad phase of a snapshot, which is of the same kind: the next step has the pairs and events that it would
    /// have had, in any order. It may have grown since: its room stays.
    ///
    /// # Errors
    /// [`Error::OtherConfig`], [`Error::NoMemory`], or [`Error::BadSnapshot`] of forged bytes; nothing has changed then.
    #[doc(alias = "load")]
    pub fn restore(&mut self, snapshot: &Snapshot<K>) -> Result<(), Error> {
        let numbers = snapshot.contacts.as_ref().map(|memory| Contacts::open(memory.clone())).transpose()?;
        match self.owned.change(|world| world.load(&snapshot.bytes)) {
            Err(Error::NoRoom { .. }) => {
                let Capacity { objects, leaf_refs, pairs, .. } = self.config.capacity;
                let capacity = Capacity::for_objects(objects.max(snapshot.capacity.objects))
                    .with_leaf_refs(leaf_refs.max(snapshot.capacity.leaf_refs))
                    .with_pairs(pairs.max(snapshot.capacity.pairs));
                let mut config = self.config.with_capacity(capacity);
                config.lean = false;
                let mut owned = OwnedWorld::new(&config)?;
                owned.change(|world| world.load(&snapshot.bytes))?;
                (self.owned, self.config) = (owned, config);
            }
            said => said?,
        }
        self.names = snapshot.names.clone();
        // Bytes of a snapshot may name what is not there.
        let world = self.owned.as_world();
        self.names.retain(|id| world.contains(id));
        self.complete = snapshot.complete;
        self.numbers = numbers.map(Numbers::with);
        Ok(())
    }
}

/// Inserts an object of one world into another one of the same kind, with all that belongs to it.
fn copy(from: &World<'_>, id: Id, to: &mut World<'_>) -> Result<Id, Error> {
    let copy = to.insert(from.aabb(id).ok_or(Error::StaleId { id })?)?;
    let Config { margin, filters, values, .. } = from.config();
    if margin.is_some()
        && let Some(length) = from.margin(id)
    {
        to.set_margin(copy, length)?;
    }
    if filters && let Some(filter) = from.filter(id) {
        to.set_filter(copy, filter)?;
    }
    if values && let Some(value) = from.value(id) {
        to.set_value(copy, value)?;
    }
    to.set_enabled(copy, from.is_enabled(id))?;
    if from.is_resting(id) {
        to.set_resting(&[copy])?
    } else {
        to.wake(&[copy])?
    }
    Ok(copy)
}
