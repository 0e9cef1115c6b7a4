//! A number for each pair, from the step that finds it to the step that loses it: [`Contacts`].
//!
//! They stand beside a world of [`trisap_core`], and know of it only which pairs a step has found and lost.
//! `trisap` has them as `BroadPhase::keep_contacts`.
#![no_std]

use trisap_core::{Error, Field, Index, Pair};

/// Small numbers for pairs: what is kept for each pair (a manifold, a sound, damage) is an array.
///
/// A pair has a number from the step that finds it to the step that loses it; then the number is given again,
/// the last freed number first. So numbers are below the most pairs that there were at once, and the
/// same calls give the same numbers. Contacts stand beside a [`World`](trisap_core::World) with events and are
/// [told](Self::update) of the lost and found pairs of each step.
///
/// The memory, of [`words`](Self::words), is the caller's: a slice, an array, a vector. All state is in it
/// and holds no addresses, so a copy of it is a copy of the contacts: kept beside a copy or a snapshot of the
/// world it gives each pair the same number after going back. A number takes 24 bytes, a slot 4.
///
/// ```
/// use trisap_contacts::Contacts;
/// use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, layout};
///
/// const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_events();
/// let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// let mut world = memory.init::<u16>(&CONFIG)?;
/// let mut contacts = Contacts::new_in([0; Contacts::words(8, 16)], 8, 16)?;
/// let mut steps = [0; 16]; // how long each has lasted, by contact
///
/// for x in [0.0, 0.5, 0.9] {
///     world.insert(Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]))?;
/// }
/// for _ in 0..3 {
///     let step = world.step()?;
///     contacts.update(step.lost(), step.found(), |_, _| {}, |_pair, contact| steps[contact as usize] = 0)?;
///     for (contact, _partner) in contacts.of(0) {
///         steps[contact as usize] += 1;
///     }
/// }
/// assert_eq!(contacts.get(1, 0).map(|contact| steps[contact as usize]), Some(3));
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contacts<M> {
    memory: M,
}

/// No contact, no slot.
const NONE: u32 = u32::MAX;
/// The first word: a mark that names the version.
const MARK: u32 = 0x7472_6331;
/// What the words in front are.
const OBJECTS: usize = 1;
const ROOM: usize = 2;
/// How many pairs there are.
const LIVE: usize = 3;
/// Numbers from here on were never given.
const USED: usize = 4;
/// The number that became free last; [`NEXT`] of it leads on.
const FREE: usize = 5;
/// Behind them, by slot: the first contact of an object. Then, by contact and side: the slots of the pair,
/// and what is next to it in the lists of its two objects.
const HEAD: usize = 6;
const SLOT: usize = 0;
const NEXT: usize = 2;
const BEFORE: usize = 4;
const EACH: usize = 6;

impl Contacts<()> {
    /// Words of memory for a world of so many objects, with so many pairs at most.
    #[must_use]
    pub const fn words(objects: u32, contacts: u32) -> usize {
        HEAD.saturating_add(objects as usize).saturating_add(EACH.saturating_mul(contacts as usize))
    }
}

/// What there is.
impl<M: AsRef<[u32]>> Contacts<M> {
    /// Contacts that are in the memory already, such as a copy. O(words): all of it is checked.
    ///
    /// # Errors
    /// [`Error::BadSnapshot`] if these words are not the memory of contacts.
    pub fn open(memory: M) -> Result<Self, Error> {
        let contacts = Self { memory };
        if contacts.is_whole() { Ok(contacts) } else { Err(Error::BadSnapshot) }
    }

    /// Contacts that a program keeps as an address alone: the mark in front is checked, not the rest.
    #[doc(hidden)]
    pub fn reopen(memory: M) -> Result<Self, Error> {
        let is_marked = memory.as_ref().first() == Some(&MARK);
        if is_marked { Ok(Self { memory }) } else { Err(Error::BadSnapshot) }
    }

    /// The number of a pair of slots, in any order. O(partners of that object of the two which has fewer).
    #[must_use]
    pub fn get(&self, a: u32, b: u32) -> Option<u32> {
        let (slots, pair) = ([a, b], [a.min(b), a.max(b)]);
        let mut at = slots.map(|slot| self.first(slot));
        loop {
            for (contact, slot) in at.iter_mut().zip(slots) {
                if *contact == NONE {
                    return None;
                }
                if self.slots(*contact) == pair {
                    return Some(*contact);
                }
                *contact = self.next(*contact, slot);
            }
        }
    }

    /// The slots of a number's pair, the lower one first.
    #[must_use]
    pub fn pair(&self, contact: u32) -> Option<[u32; 2]> {
        let pair = (contact < self.word(USED)).then(|| self.slots(contact))?;
        (pair[0] != NONE).then_some(pair)
    }

    /// The contacts of an object and its partners' slots, those inserted last first. O(answers).
    pub fn of(&self, slot: u32) -> impl Iterator<Item = (u32, u32)> {
        let is_one = |contact: &u32| *contact != NONE;
        let next = move |contact: &u32| Some(self.next(*contact, slot)).filter(is_one);
        core::iter::successors(Some(self.first(slot)).filter(is_one), next)
            .map(move |contact| (contact, self.slots(contact)[1 - self.side(contact, slot)]))
    }

    /// How many pairs have a number.
    #[must_use]
    pub fn len(&self) -> usize {
        self.word(LIVE) as usize
    }

    /// Whether none has.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All numbers in use are below this.
    #[must_use]
    pub fn end(&self) -> u32 {
        self.word(USED)
    }

    /// How many objects and pairs there is room for.
    #[must_use]
    pub fn room(&self) -> [u32; 2] {
        [self.word(OBJECTS), self.word(ROOM)]
    }

    /// The memory, to save or copy.
    #[must_use]
    pub fn memory(&self) -> &M {
        &self.memory
    }

    /// The same contacts, with the same numbers, in other memory: to have more room. O(words).
    ///
    /// # Errors
    /// [`Error::SlabTooSmall`]; [`Error::NoRoom`] if there are more slots or numbers in use.
    pub fn move_into<N: AsRef<[u32]> + AsMut<[u32]>>(
        &self,
        memory: N,
        objects: u32,
        contacts: u32,
    ) -> Result<Contacts<N>, Error> {
        let [own, used] = [self.word(OBJECTS), self.word(USED)];
        for (field, needed, room) in [(Field::Objects, own, objects), (Field::Contacts, used, contacts)] {
            if needed > room {
                return Err(Error::NoRoom { field, needed, room });
            }
        }
        let mut to = Contacts::new_in(memory, objects, contacts)?;
        let (from, own, used) = (self.memory.as_ref(), own as usize, EACH * used as usize);
        let into = to.memory.as_mut();
        // Where words stand, where they go, and how many they are.
        let spans =
            [(LIVE, LIVE, HEAD - LIVE), (HEAD, HEAD, own), (HEAD + own, HEAD + objects as usize, used)];
        for (start, to, count) in spans {
            for (to, from) in into.iter_mut().skip(to).zip(from.iter().skip(start).take(count)) {
                *to = *from;
            }
        }
        Ok(to)
    }

    fn word(&self, at: usize) -> u32 {
        self.memory.as_ref().get(at).copied().unwrap_or_default()
    }

    /// Where a word of a contact is.
    fn at(&self, contact: u32, word: usize) -> usize {
        HEAD + self.word(OBJECTS) as usize + EACH * contact as usize + word
    }

    fn first(&self, slot: u32) -> u32 {
        if slot < self.word(OBJECTS) { self.word(HEAD + slot as usize) } else { NONE }
    }

    fn slots(&self, contact: u32) -> [u32; 2] {
        [0, 1].map(|side| self.word(self.at(contact, SLOT + side)))
    }

    /// Which of the two objects a slot is.
    fn side(&self, contact: u32, slot: u32) -> usize {
        usize::from(self.slots(contact)[1] == slot)
    }

    fn next(&self, contact: u32, slot: u32) -> u32 {
        self.word(self.at(contact, NEXT + self.side(contact, slot)))
    }

    /// Whether each number in use is once in the lists of its two objects, each free one in the free list.
    fn is_whole(&self) -> bool {
        let words = self.memory.as_ref();
        let [mark, objects, room, live, used, mut free] =
            words.first_chunk::<HEAD>().copied().unwrap_or_default();
        let len = Contacts::words(objects, room);
        if mark != MARK || len == usize::MAX || words.len() < len || live > used || used > room {
            return false;
        }
        let is_free = |contact: u32| self.slots(contact)[0] == NONE;
        for _ in live..used {
            if free >= used || !is_free(free) {
                return false;
            }
            free = self.word(self.at(free, NEXT));
        }
        let mut linked = 0;
        for slot in 0..objects {
            // No list leads back to where it was: each contact knows one that is before it.
            let (mut before, mut at) = (NONE, self.first(slot));
            while at != NONE {
                let is_next = |at: u32| self.word(self.at(at, BEFORE + self.side(at, slot))) == before;
                if at >= used || !self.slots(at).contains(&slot) || !is_next(at) {
                    return false;
                }
                linked += 1;
                (before, at) = (at, self.next(at, slot));
            }
        }
        let in_use = || (0..used).filter(|contact| !is_free(*contact)).map(|contact| self.slots(contact));
        free == NONE
            && in_use().count() == live as usize
            && in_use().all(|[a, b]| a < b && b < objects)
            && linked == 2 * u64::from(live)
    }
}

/// Changes.
impl<M: AsRef<[u32]> + AsMut<[u32]>> Contacts<M> {
    /// No contacts yet, with room for a world of so many objects, and so many pairs. O(objects).
    ///
    /// # Errors
    /// [`Error::SlabTooSmall`], in bytes.
    pub fn new_in(mut memory: M, objects: u32, contacts: u32) -> Result<Self, Error> {
        let (words, given) = (Contacts::words(objects, contacts), memory.as_ref().len());
        if given < words {
            let [needed, given] = [words, given].map(|words| words.saturating_mul(size_of::<u32>()));
            return Err(Error::SlabTooSmall { needed, given });
        }
        if let Some(head) = memory.as_mut().first_chunk_mut::<HEAD>() {
            *head = [MARK, objects, contacts, 0, 0, NONE];
        }
        let mut empty = Self { memory };
        empty.clear();
        Ok(empty)
    }

    /// Takes back the numbers of the lost pairs, then gives the found pairs numbers, and tells each. A pair
    /// without a number is not told as lost, and a pair with a number keeps it. A world with pairs begins
    /// with all as found. O(events), each times the partners of the object that has fewer.
    ///
    /// # Errors
    /// [`Error::NoRoom`] where the slots or the pairs do not fit; [`Error::BadPair`]. Nothing is told or
    /// changed then: with [more room](Self::move_into) the same events fit. A pair may be lost once: where one
    /// that was told twice leaves too little room, the error comes after some were told.
    pub fn update<I: Index>(
        &mut self,
        lost: &[Pair<I>],
        found: &[Pair<I>],
        mut ended: impl FnMut(Pair<I>, u32),
        mut began: impl FnMut(Pair<I>, u32),
    ) -> Result<(), Error> {
        let [objects, room] = self.room();
        for [a, b] in found.iter().map(|pair| pair.map(Index::slot)) {
            if a == b {
                return Err(Error::BadPair);
            }
            if a.max(b) >= objects {
                let needed = a.max(b).saturating_add(1);
                return Err(Error::NoRoom { field: Field::Objects, needed, room: objects });
            }
        }
        let number = |contacts: &Self, pair: Pair<I>| contacts.get(pair[0].slot(), pair[1].slot());
        if self.len() + found.len() > room as usize {
            // A found pair with a number keeps it, unless it is lost as well.
            let is_new = |pair: &&Pair<I>| number(self, **pair).is_none() || lost.contains(pair);
            let gone = lost.iter().filter(|pair| number(self, **pair).is_some()).count();
            let needed = self.len().saturating_sub(gone) + found.iter().filter(is_new).count();
            if needed > room as usize {
                let needed = u32::try_from(needed).unwrap_or(u32::MAX);
                return Err(Error::NoRoom { field: Field::Contacts, needed, room });
            }
        }
        for pair in lost {
            if let Some(contact) = number(self, *pair) {
                self.free(contact);
                ended(*pair, contact);
            }
        }
        for pair in found {
            let contact = match number(self, *pair) {
                Some(contact) => contact,
                None if self.len() < room as usize => self.insert(pair.map(Index::slot)),
                // A pair was lost twice.
                None => return Err(Error::BadPair),
            };
            began(*pair, contact);
        }
        Ok(())
    }

    /// Takes back all numbers of an object, and tells each with the partner's slot: before the object is
    /// removed, for whoever cannot wait for the lost pairs of the next step. O(answers).
    pub fn remove_all(&mut self, slot: u32, mut ended: impl FnMut(u32, u32)) {
        while let Some((contact, other)) = { self.of(slot).next() } {
            self.free(contact);
            ended(contact, other);
        }
    }

    /// Takes back all numbers. O(objects).
    pub fn clear(&mut self) {
        for (at, value) in [(LIVE, 0), (USED, 0), (FREE, NONE)] {
            self.set(at, value);
        }
        let objects = self.word(OBJECTS) as usize;
        for first in self.memory.as_mut().iter_mut().skip(HEAD).take(objects) {
            *first = NONE;
        }
    }

    /// Gives a pair a number that is free.
    fn insert(&mut self, [a, b]: [u32; 2]) -> u32 {
        let free = self.word(FREE);
        let contact = if free == NONE { self.word(USED) } else { free };
        if free == NONE {
            self.set(USED, contact + 1);
        } else {
            self.set(FREE, self.word(self.at(free, NEXT)));
        }
        self.set(LIVE, self.word(LIVE) + 1);
        for (side, slot) in [a.min(b), a.max(b)].into_iter().enumerate() {
            let next = self.first(slot);
            for (word, value) in [(SLOT, slot), (NEXT, next), (BEFORE, NONE)] {
                self.set(self.at(contact, word + side), value);
            }
            self.lead(next, slot, BEFORE, contact);
            self.set(HEAD + slot as usize, contact);
        }
        contact
    }

    fn set(&mut self, at: usize, value: u32) {
        if let Some(word) = self.memory.as_mut().get_mut(at) {
            *word = value;
        }
    }

    /// Lets a contact of a slot, if it is one, lead to another.
    fn lead(&mut self, from: u32, slot: u32, word: usize, to: u32) {
        if from != NONE {
            self.set(self.at(from, word + self.side(from, slot)), to);
        }
    }

    fn free(&mut self, contact: u32) {
        for (side, slot) in self.slots(contact).into_iter().enumerate() {
            let [next, before] = [NEXT, BEFORE].map(|word| self.word(self.at(contact, word + side)));
            self.lead(next, slot, BEFORE, before);
            if before == NONE {
                self.set(HEAD + slot as usize, next);
            } else {
                self.lead(before, slot, NEXT, next);
            }
        }
        for (word, value) in [(SLOT, NONE), (SLOT + 1, NONE), (NEXT, self.word(FREE))] {
            self.set(self.at(contact, word), value);
        }
        self.set(FREE, contact);
        self.set(LIVE, self.word(LIVE) - 1);
    }
}
