//! The objects that a rank knows, by the slot that each has in the rank's world.

use crate::message::NOWHERE;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use trisap::Aabb;

/// Two objects by key, the lower one first.
pub type KeyPair = [u64; 2];

/// The object lives.
const LIVES: u8 = 1;
/// The rank owns it: its box comes from here.
const OWNED: u8 = 2;
/// Its box or its owner has changed since the last step.
const CHANGED: u8 = 4;
/// The rank owns it since this step.
const NEW: u8 = 8;
/// It lives in this slot since this step.
const ENTERED: u8 = 16;
/// Another object has left this slot in this step.
const VACATED: u8 = 32;

/// What stands for the key of an object that is not steady. A steady object of this very key only takes the longer way.
const UNSTEADY: u64 = u64::MAX;

/// Spreads keys that follow each other: the usual hash of the standard library takes longer than all else that is done with
/// a ghost.
#[derive(Debug, Default)]
pub(crate) struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }
    fn write_u32(&mut self, number: u32) {
        self.write_u64(u64::from(number));
    }
    fn write_u64(&mut self, number: u64) {
        let product = (self.0 ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = product ^ product >> 32;
    }
}

pub(crate) type KeyMap<K, V> = HashMap<K, V, BuildHasherDefault<KeyHasher>>;

/// An object with its box now and in the last step, each [`NOWHERE`] where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Object {
    pub(crate) key: u64,
    pub(crate) now: Aabb,
    pub(crate) before: Aabb,
}

/// Objects by slot. Arrays of each part, since a step reads all boxes and nothing else.
#[derive(Debug, Default)]
pub(crate) struct Table {
    keys: Vec<u64>,
    /// The keys of steady objects again: of most pairs, nothing else is read.
    steady: Vec<u64>,
    /// The boxes as they are now.
    pub(crate) now: Vec<Aabb>,
    before: Vec<Aabb>,
    flags: Vec<u8>,
    slots: KeyMap<u64, u32>,
    /// Slots whose box or owner has changed since the last step, each once.
    changed: Vec<u32>,
    owned: usize,
}

impl Table {
    /// Objects that live.
    pub(crate) fn len(&self) -> usize {
        self.slots.len()
    }

    /// Objects that the rank owns.
    pub(crate) fn owned(&self) -> usize {
        self.owned
    }

    /// One more than the highest slot so far.
    pub(crate) fn slots(&self) -> usize {
        self.keys.len()
    }

    /// The slot of a living object.
    pub(crate) fn slot_of(&self, key: u64) -> Option<u32> {
        self.slots.get(&key).copied()
    }

    pub(crate) fn lives(&self, slot: u32) -> bool {
        self.flags[slot as usize] & LIVES != 0
    }

    pub(crate) fn is_owned(&self, slot: u32) -> bool {
        self.flags[slot as usize] & OWNED != 0
    }

    /// Whether the rank owns an object and did so in the last step. What a sweep says of two such objects needs no second look:
    /// nothing has come or left.
    #[inline]
    pub(crate) fn is_steady(&self, slot: u32) -> bool {
        self.flags[slot as usize] & (OWNED | NEW) == OWNED
    }

    /// The keys of two steady objects.
    #[inline]
    pub(crate) fn steady_keys(&self, pair: [u32; 2]) -> Option<[u64; 2]> {
        let keys = pair.map(|slot| self.steady[slot as usize]);
        keys.iter().all(|key| *key != UNSTEADY).then_some(keys)
    }

    /// Whether the object lives and did so in the last step, in this slot.
    #[inline]
    pub(crate) fn is_known(&self, slot: u32) -> bool {
        self.flags[slot as usize] & (LIVES | ENTERED) == LIVES
    }

    /// Whether an object has left this slot in this step.
    #[inline]
    pub(crate) fn was_vacated(&self, slot: u32) -> bool {
        self.flags[slot as usize] & VACATED != 0
    }

    #[inline]
    pub(crate) fn key(&self, slot: u32) -> u64 {
        self.keys[slot as usize]
    }

    pub(crate) fn get(&self, slot: u32) -> Object {
        let at = slot as usize;
        Object { key: self.keys[at], now: self.now[at], before: self.before[at] }
    }

    /// The slots of the objects that the rank owns, ascending.
    pub(crate) fn owned_slots(&self) -> impl Iterator<Item = u32> {
        (0..self.flags.len() as u32).filter(|&slot| self.is_owned(slot))
    }

    /// The slots of all living objects, ascending.
    pub(crate) fn living_slots(&self) -> impl Iterator<Item = u32> {
        (0..self.flags.len() as u32).filter(|&slot| self.lives(slot))
    }

    /// The slots whose boxes have changed since the last step.
    pub(crate) fn changed(&self) -> &[u32] {
        &self.changed
    }

    /// Puts an object into a slot where none lives.
    pub(crate) fn put(&mut self, slot: u32, object: &Object, owned: bool) {
        self.make_room(slot);
        let at = slot as usize;
        self.keys[at] = object.key;
        self.now[at] = object.now;
        self.before[at] = object.before;
        // Where a slot's former object had changed, the slot stands in the list already.
        self.flags[at] = self.flags[at] & (CHANGED | VACATED) | LIVES | ENTERED;
        self.slots.insert(object.key, slot);
        self.set_owned(slot, owned);
        self.mark(slot);
    }

    /// Has a slot empty.
    pub(crate) fn take(&mut self, slot: u32) -> Object {
        let object = self.get(slot);
        self.set_owned(slot, false);
        self.flags[slot as usize] &= !LIVES;
        self.slots.remove(&object.key);
        self.vacate(slot);
        object
    }

    /// Notes that an object has left a slot in this step.
    pub(crate) fn vacate(&mut self, slot: u32) {
        self.make_room(slot);
        self.flags[slot as usize] |= VACATED;
        self.mark(slot);
    }

    fn make_room(&mut self, slot: u32) {
        let at = slot as usize;
        if at >= self.keys.len() {
            self.keys.resize(at + 1, 0);
            self.steady.resize(at + 1, UNSTEADY);
            self.now.resize(at + 1, NOWHERE);
            self.before.resize(at + 1, NOWHERE);
            self.flags.resize(at + 1, 0);
        }
    }

    /// Says whether the rank owns an object.
    pub(crate) fn set_owned(&mut self, slot: u32, owned: bool) {
        self.steady[slot as usize] = UNSTEADY;
        self.owned = self.owned - usize::from(self.is_owned(slot)) + usize::from(owned);
        if owned {
            self.flags[slot as usize] |= OWNED | NEW;
            self.mark(slot);
        } else {
            self.flags[slot as usize] &= !OWNED;
        }
    }

    /// Gives an object another box.
    #[inline]
    pub(crate) fn set(&mut self, slot: u32, now: Aabb) {
        if self.now[slot as usize] != now {
            self.now[slot as usize] = now;
            self.mark(slot);
        }
    }

    /// Has the boxes of now be those of the last step.
    pub(crate) fn conclude(&mut self) {
        for slot in self.changed.drain(..) {
            let at = slot as usize;
            if self.flags[at] & (OWNED | NEW) == OWNED | NEW {
                self.steady[at] = self.keys[at];
            }
            self.flags[at] &= !(CHANGED | NEW | ENTERED | VACATED);
            self.before[at] = self.now[at];
        }
    }

    #[inline]
    fn mark(&mut self, slot: u32) {
        let flags = &mut self.flags[slot as usize];
        if *flags & CHANGED == 0 {
            *flags |= CHANGED;
            self.changed.push(slot);
        }
    }
}
