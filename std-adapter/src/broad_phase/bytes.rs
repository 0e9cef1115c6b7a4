//! Snapshots of broad phases as bytes.

use super::Snapshot;
use super::names::{Events, Named, Names};
use core::hash::Hash;
use std::collections::HashMap;
use trisap_core::{Aabb, Capacity, Error, Id};

/// What the bytes begin with. Words of 64 bits follow: a sum over them, their number, what is known of keys; then the
/// snapshot of the world.
const MAGIC: u64 = 0x7472_6973_6170_4b02;

impl<K: Copy + Eq + Hash> Snapshot<K> {
    /// The snapshot as bytes: for a file, or for another machine of the same byte order. `number` gives each key a number
    /// of its own, as `Entity::to_bits` does. O(bytes).
    ///
    /// ```
    /// use trisap::{Aabb, BroadPhase, Snapshot};
    ///
    /// let mut broad_phase = BroadPhase::new();
    /// broad_phase.insert(7u32, Aabb::new([0.0; 3], [1.0; 3]))?;
    /// let bytes = broad_phase.save().to_bytes(u64::from);
    ///
    /// let mut late = BroadPhase::new();
    /// late.restore(&Snapshot::from_bytes(&bytes, |number| u32::try_from(number).ok())?)?;
    /// assert!(late.contains(&7));
    /// # Ok::<(), trisap::Error>(())
    /// ```
    #[must_use]
    pub fn to_bytes(&self, number: impl Fn(K) -> u64) -> Vec<u8> {
        let Capacity { objects, leaf_refs, pairs, .. } = self.capacity;
        let mut words =
            vec![MAGIC, 0, 0, objects.into(), leaf_refs.into(), pairs.into(), self.complete.into()];
        self.names.write(&mut words, &number);
        let contacts = self.contacts.as_deref();
        words.push(contacts.map_or(0, |contacts| 1 + contacts.len() as u64));
        words.extend(contacts.unwrap_or_default().iter().map(|word| u64::from(*word)));
        words[2] = words.len() as u64;
        words[1] = sum(&words[2..]);
        let words = words.iter().flat_map(|word| word.to_ne_bytes());
        words.chain(self.bytes.iter().copied()).collect()
    }

    /// The snapshot in bytes; `key` gives the key of a number. O(bytes).
    ///
    /// # Errors
    /// [`Error::BadSnapshot`] if they are no snapshot of this version, if they have changed since, or if there is no key
    /// of a number. What they say of the world is checked when it is [restored](super::BroadPhase::restore).
    pub fn from_bytes(bytes: &[u8], key: impl Fn(u64) -> Option<K>) -> Result<Self, Error> {
        Self::parse(bytes, &key).ok_or(Error::BadSnapshot)
    }

    fn parse(bytes: &[u8], key: &impl Fn(u64) -> Option<K>) -> Option<Self> {
        let word = |at: usize| bytes.get(8 * at..)?.first_chunk().map(|word| u64::from_ne_bytes(*word));
        let len = usize::try_from(word(2)?).ok()?;
        let (_, world) = bytes.split_at_checked(len.checked_mul(8)?)?;
        let words: Vec<u64> = (0..len).map_while(word).collect();
        if words.len() < 7 || words[0] != MAGIC || words[1] != sum(&words[2..]) {
            return None;
        }
        let count = |at: usize| u32::try_from(words[at]).ok();
        let capacity = Capacity::for_objects(count(3)?).with_leaf_refs(count(4)?).with_pairs(count(5)?);
        let complete = words[6] != 0;
        let mut rest = &words[7..];
        // As many as there can be, whatever the bytes say: the world keeps the box of each slot.
        let slots = capacity.objects.min(u32::try_from(world.len() / size_of::<Aabb>()).unwrap_or(u32::MAX));
        let names = Names::read(&mut rest, key, slots)?;
        let contacts = match take(&mut rest)? {
            0 => None,
            len => Some((1..len).map(|_| u32::try_from(take(&mut rest)?).ok()).collect::<Option<Vec<_>>>()?),
        };
        rest.is_empty().then(|| Self { bytes: world.to_vec(), capacity, names, complete, contacts })
    }
}

/// Changes with any word.
pub(super) fn sum(words: &[u64]) -> u64 {
    words.iter().fold(1, |sum, word| (sum ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29))
}

fn take(rest: &mut &[u64]) -> Option<u64> {
    let (first, behind) = rest.split_first()?;
    *rest = behind;
    Some(*first)
}

/// A list with its length in front.
fn list<T>(rest: &mut &[u64], mut item: impl FnMut(&mut &[u64]) -> Option<T>) -> Option<Vec<T>> {
    (0..take(rest)?).map(|_| item(rest)).collect()
}

impl<K: Copy + Eq + Hash> Names<K> {
    fn write(&self, words: &mut Vec<u64>, number: &impl Fn(K) -> u64) {
        words.extend([self.next, self.stepped]);
        let mut removed =
            [&self.removed, &self.removed_before].map(|names| names.values().copied().collect::<Vec<_>>());
        removed.iter_mut().for_each(|names| names.sort_unstable_by_key(|named| named.serial));
        let [removed, before] = removed;
        for names in [self.living().collect(), removed, before] {
            words.push(names.len() as u64);
            words
                .extend(names.iter().flat_map(|named| [named.id.to_bits(), named.serial, number(named.key)]));
        }
        words.push(self.before.is_some().into());
        if let Some(before) = &self.before {
            words.push(before.len() as u64);
            words.extend(before.iter().flat_map(|([a, b], [x, y])| [*a, *b, number(*x), number(*y)]));
        }
        words.push(self.events.is_some().into());
        if let Some(Events { found, lost }) = &self.events {
            for pairs in [found, lost] {
                words.push(pairs.len() as u64);
                words.extend(pairs.iter().flatten().map(|key| number(*key)));
            }
        }
    }

    fn read(rest: &mut &[u64], key: &impl Fn(u64) -> Option<K>, slots: u32) -> Option<Self> {
        let mut names = Self::new();
        (names.next, names.stepped) = (take(rest)?, take(rest)?);
        let named = |rest: &mut &[u64]| {
            let id = Id::from_bits(take(rest)?).filter(|id| id.slot() < slots)?;
            Some(Named { id, serial: take(rest)?, key: key(take(rest)?)? })
        };
        list(rest, named)?.into_iter().for_each(|named| names.put(named));
        for removed in [&mut names.removed, &mut names.removed_before] {
            *removed =
                list(rest, named)?.into_iter().map(|named| (named.id, named)).collect::<HashMap<_, _>>();
        }
        let pair = |rest: &mut &[u64]| Some([key(take(rest)?)?, key(take(rest)?)?]);
        if take(rest)? != 0 {
            let before = list(rest, |rest| Some(([take(rest)?, take(rest)?], pair(rest)?)))?;
            names.before = Some(before.into_iter().collect());
        }
        if take(rest)? != 0 {
            names.events = Some(Events { found: list(rest, pair)?, lost: list(rest, pair)? });
        }
        Some(names)
    }
}
