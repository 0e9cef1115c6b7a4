//! A number for each pair of keys, from the step that finds it to the step that loses it.

use super::BroadPhase;
use core::hash::Hash;
use trisap_contacts::Contacts;
use trisap_core::{Error, Field, World};

/// Contacts, and the numbers of the lost and found pairs of the last step, in their order.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    pub(super) contacts: Contacts<Vec<u32>>,
    ended: Vec<u32>,
    began: Vec<u32>,
}

impl Numbers {
    /// The numbers of some pairs of a world.
    fn of(world: &World<'_>, pairs: &[[u32; 2]]) -> Result<Self, Error> {
        let mut numbers = Self::with(Contacts::new_in(vec![0; Contacts::words(0, 0)], 0, 0)?);
        numbers.update(world, &[], pairs)?;
        numbers.began.clear();
        Ok(numbers)
    }

    /// As they were when these contacts were saved.
    pub(super) fn with(contacts: Contacts<Vec<u32>>) -> Self {
        Self { contacts, ended: Vec::new(), began: Vec::new() }
    }

    /// A step was complete. If the one before was not, contacts may have been asked for when nobody knew the pairs that stay.
    pub(super) fn step(&mut self, world: &World<'_>, was_complete: bool) -> Result<(), Error> {
        if was_complete || !self.contacts.is_empty() {
            return self.update(world, world.lost(), world.found());
        }
        self.update(world, &[], world.pairs())?;
        let number = |[a, b]: &[u32; 2]| self.contacts.get(*a, *b);
        self.began = world.found().iter().filter_map(number).collect();
        Ok(())
    }

    /// Brings the numbers into the order that the pairs get when their results are sorted.
    pub(super) fn sort(&mut self, world: &World<'_>) {
        for (pairs, numbers) in [(world.lost(), &mut self.ended), (world.found(), &mut self.began)] {
            let mut numbered: Vec<_> = pairs.iter().zip(numbers.drain(..)).collect();
            numbered.sort_unstable();
            numbers.extend(numbered.iter().map(|(_, number)| *number));
        }
    }

    fn update(&mut self, world: &World<'_>, lost: &[[u32; 2]], found: &[[u32; 2]]) -> Result<(), Error> {
        let Self { contacts, ended, began } = self;
        loop {
            ended.clear();
            began.clear();
            let said =
                contacts.update(lost, found, |_, number| ended.push(number), |_, number| began.push(number));
            let [objects, room] = contacts.room();
            let (objects, room) = match said {
                Err(Error::NoRoom { field: Field::Objects, .. }) => (world.config().capacity.objects, room),
                // A quarter more, so that they do not move in each step.
                Err(Error::NoRoom { needed, .. }) => (objects, needed.saturating_add(needed / 4)),
                said => return said,
            };
            *contacts = contacts.move_into(memory(objects, room)?, objects, room)?;
        }
    }
}

fn memory(objects: u32, room: u32) -> Result<Vec<u32>, Error> {
    let (words, mut memory) = (Contacts::words(objects, room), Vec::new());
    let bytes = words.saturating_mul(size_of::<u32>());
    memory.try_reserve_exact(words).map_err(|_| Error::NoMemory { bytes })?;
    memory.resize(words, 0);
    Ok(memory)
}

/// Contacts: with them each pair has a small number, from the step that finds it to the step that loses it. What is kept for a pair
/// (a manifold, a sound, damage) stands in a `Vec` at that place. See [`Contacts`].
///
/// ```
/// use trisap::{Aabb, BroadPhase};
///
/// let mut broad_phase = BroadPhase::new();
/// broad_phase.keep_contacts()?;
/// let mut steps = Vec::new(); // by contact
/// for frame in 0..6u8 {
///     broad_phase.insert("floor", Aabb::new([-9.0, -9.0, -1.0], [9.0, 9.0, 0.0]))?;
///     broad_phase.insert("ball", Aabb::from_center([0.0, 0.0, 3.0 - f32::from(frame)], [0.5; 3]))?;
///     let step = broad_phase.step()?;
///     for ([a, b], contact) in step.lost_contacts() {
///         println!("{a} and {b} have touched for {} steps", steps[contact]);
///     }
///     for (_, contact) in step.found_contacts() {
///         steps.resize(steps.len().max(contact + 1), 0);
///         steps[contact] = 0;
///     }
///     for (_partner, contact) in step.contacts_of(&"ball") {
///         steps[contact] += 1;
///     }
/// }
/// assert_eq!(steps, [2]);
/// assert_eq!(broad_phase.contact(&"ball", &"floor"), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
impl<K: Copy + Eq + Hash> BroadPhase<K> {
    /// Gives each pair a number, those of the last step first. Copies and snapshots have them too: after going back each pair has the
    /// number that it had. After a step that had no memory for them there are none. Needs [events](crate::Config::with_events). With contacts, [`shrink_to_fit`](Self::shrink_to_fit) does nothing.
    ///
    /// # Errors
    /// [`Error::NoMemory`].
    ///
    /// # Panics
    /// If there are no events: numbers would never end.
    pub fn keep_contacts(&mut self) -> Result<(), Error> {
        assert!(self.config.events, "contacts need a broad phase made with `Config::with_events`");
        if self.numbers.is_none() {
            let world = self.as_world();
            self.numbers = Some(Numbers::of(world, if self.complete { world.pairs() } else { &[] })?);
        }
        Ok(())
    }

    /// The number of a pair at the last step. `None` if there was no such pair, and without [contacts](Self::keep_contacts). O(partners
    /// of that key of the two which has fewer).
    #[must_use]
    pub fn contact(&self, a: &K, b: &K) -> Option<usize> {
        let [a, b] = [self.slot_of_last_step(a)?, self.slot_of_last_step(b)?];
        Some(self.numbers.as_ref()?.contacts.get(a, b)? as usize)
    }

    /// The partners of a key at the last step, and the numbers of their pairs; nothing without [contacts](Self::keep_contacts).
    /// O(answers).
    pub fn contacts_of(&self, key: &K) -> impl Iterator<Item = (K, usize)> {
        let numbers = self.numbers.as_ref().zip(self.slot_of_last_step(key));
        let of = numbers.map(|(numbers, slot)| numbers.contacts.of(slot)).into_iter().flatten();
        of.filter_map(|(contact, other)| Some((self.names.in_slot(other)?.key, contact as usize)))
    }

    /// The keys of a pair of the last step. `None` if no pair has this number, or one of its keys was removed since.
    #[must_use]
    pub fn contact_keys(&self, contact: usize) -> Option<[K; 2]> {
        self.names.pair(self.numbers.as_ref()?.contacts.pair(u32::try_from(contact).ok()?)?)
    }

    /// The [found](Self::found) pairs and the numbers that they have got; nothing without [contacts](Self::keep_contacts).
    pub fn found_contacts(&self) -> impl Iterator<Item = ([K; 2], usize)> {
        let began = self.numbers.iter().flat_map(|numbers| &numbers.began);
        let told = self.as_world().found().iter().zip(began).filter(|_| self.names.events.is_none());
        let told = told.filter_map(|(pair, contact)| Some((self.names.pair(*pair)?, *contact as usize)));
        // Of the first step after a shrink, in which all pairs are new to the world, the events that are told.
        let others = self.names.events.iter().flat_map(|events| &events.found);
        told.chain(others.filter_map(|[a, b]| Some(([*a, *b], self.contact(a, b)?))))
    }

    /// The [lost](Self::lost) pairs and the numbers that they had. The same number may be among the found ones: take these first.
    pub fn lost_contacts(&self) -> impl Iterator<Item = ([K; 2], usize)> {
        let ended = self.numbers.iter().flat_map(|numbers| &numbers.ended);
        let told = self.as_world().lost_ids().zip(ended);
        told.filter_map(|(pair, contact)| Some((self.names.former_pair(pair)?, *contact as usize)))
    }

    fn slot_of_last_step(&self, key: &K) -> Option<u32> {
        let slot = self.id(key)?.slot();
        self.names.in_slot(slot).map(|named| named.id.slot())
    }
}
