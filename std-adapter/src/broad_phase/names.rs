//! Which key an object has, or had, and in which order keys came.

use core::hash::Hash;
use std::collections::{BTreeMap, HashMap};
use trisap_core::{Id, Pair, World};

/// An object by name.
#[derive(Clone, Copy, Debug)]
pub(super) struct Named<K> {
    pub(super) id: Id,
    pub(super) key: K,
    /// How many objects came before it: the keys of a pair are in this order.
    pub(super) serial: u64,
}

/// The found and lost pairs of a step in a world that was made anew since the step before.
#[derive(Clone, Debug)]
pub(super) struct Events<K> {
    pub(super) found: Vec<[K; 2]>,
    pub(super) lost: Vec<[K; 2]>,
}

/// All names.
#[derive(Clone, Debug)]
pub(super) struct Names<K> {
    ids: HashMap<K, Id>,
    /// By slot.
    living: Vec<Option<Named<K>>>,
    /// Objects of the last step that were removed since, and those of the step before.
    pub(super) removed: HashMap<Id, Named<K>>,
    pub(super) removed_before: HashMap<Id, Named<K>>,
    /// The serial of the next object, and at the last step: what is younger is in no pair.
    pub(super) next: u64,
    pub(super) stepped: u64,
    /// Behind the slot of the last key that was looked up: the next one is often here.
    guess: usize,
    /// The pairs of the last step by serials, if the world was made anew since.
    pub(super) before: Option<BTreeMap<[u64; 2], [K; 2]>>,
    /// What the last step tells in place of the world.
    pub(super) events: Option<Events<K>>,
}

impl<K: Copy + Eq + Hash> Names<K> {
    pub(super) fn new() -> Self {
        Self {
            ids: HashMap::new(),
            living: Vec::new(),
            removed: HashMap::new(),
            removed_before: HashMap::new(),
            next: 0,
            stepped: 0,
            guess: 0,
            before: None,
            events: None,
        }
    }

    /// Becomes a copy, in the memory that there is.
    pub(super) fn copy_from(&mut self, from: &Self) {
        self.ids.clone_from(&from.ids);
        self.living.clone_from(&from.living);
        self.removed.clone_from(&from.removed);
        self.removed_before.clone_from(&from.removed_before);
        (self.next, self.stepped, self.guess) = (from.next, from.stepped, from.guess);
        self.before.clone_from(&from.before);
        self.events.clone_from(&from.events);
    }

    /// Keeps the names of living objects alone that are there.
    pub(super) fn retain(&mut self, is_there: impl Fn(Id) -> bool) {
        self.living.iter_mut().for_each(|name| *name = name.filter(|named| is_there(named.id)));
        self.ids.retain(|_, id| is_there(*id));
    }

    pub(super) fn len(&self) -> usize {
        self.ids.len()
    }

    pub(super) fn id(&self, key: &K) -> Option<Id> {
        self.ids.get(key).copied()
    }

    /// The same, fast for keys that come in the order in which they were inserted.
    #[inline]
    pub(super) fn look_up(&mut self, key: &K) -> Option<Id> {
        if let Some(Some(named)) = self.living.get(self.guess)
            && named.key == *key
        {
            self.guess += 1;
            return Some(named.id);
        }
        let id = self.id(key)?;
        self.guess = id.slot() as usize + 1;
        Some(id)
    }

    pub(super) fn living(&self) -> impl Iterator<Item = Named<K>> {
        self.living.iter().flatten().copied()
    }

    /// An object that lives, or lived at one of the last two steps.
    pub(super) fn named(&self, id: Id) -> Option<Named<K>> {
        match self.living.get(id.slot() as usize) {
            Some(Some(named)) if named.id == id => Some(*named),
            _ => self.removed_before.get(&id).or_else(|| self.removed.get(&id)).copied(),
        }
    }

    /// The object of the last step that is still in a slot.
    pub(super) fn in_slot(&self, slot: u32) -> Option<Named<K>> {
        self.living.get(slot as usize).copied().flatten().filter(|named| named.serial < self.stepped)
    }

    pub(super) fn insert(&mut self, key: K, id: Id) {
        let serial = self.next;
        self.next += 1;
        self.put(Named { id, key, serial });
    }

    pub(super) fn put(&mut self, named: Named<K>) {
        let slot = named.id.slot() as usize;
        if slot >= self.living.len() {
            self.living.resize(slot + 1, None);
        }
        self.living[slot] = Some(named);
        self.ids.insert(named.key, named.id);
        self.guess = slot + 1;
    }

    pub(super) fn remove(&mut self, key: &K) -> Option<Id> {
        let id = self.ids.remove(key)?;
        let named = self.living[id.slot() as usize].take();
        self.remember(named);
        Some(id)
    }

    pub(super) fn clear(&mut self) {
        self.ids.clear();
        for named in core::mem::take(&mut self.living) {
            self.remember(named);
        }
    }

    /// Only objects of the last step can be in a lost pair, so the rest is forgotten: what is never stepped does not grow.
    fn remember(&mut self, named: Option<Named<K>>) {
        self.removed.extend(named.filter(|named| named.serial < self.stepped).map(|named| (named.id, named)));
    }

    pub(super) fn reserve(&mut self, additional: usize) {
        self.ids.reserve(additional);
    }

    /// A complete step was done.
    pub(super) fn step(&mut self, world: &World<'_>) {
        self.removed_before = core::mem::take(&mut self.removed);
        self.stepped = self.next;
        self.events = self.before.take().map(|mut before| {
            let now = self.pairs_of_last_step(world);
            let found = now.iter().filter(|(pair, _)| before.remove(*pair).is_none());
            let found = found.map(|(_, keys)| *keys).collect();
            Events { found, lost: before.into_values().collect() }
        });
    }

    /// The pairs of the last step, those of objects that were removed since included, by serials in order.
    fn pairs_of_last_step(&self, world: &World<'_>) -> BTreeMap<[u64; 2], [K; 2]> {
        let gone: HashMap<u32, Named<K>> =
            self.removed.values().map(|named| (named.id.slot(), *named)).collect();
        let of = |slot: u32| gone.get(&slot).copied().or_else(|| self.in_slot(slot));
        let pairs = world.pairs().iter().filter_map(|[a, b]| Some(in_order([of(*a)?, of(*b)?])));
        pairs.map(|pair| (pair.map(|named| named.serial), pair.map(|named| named.key))).collect()
    }

    /// The objects get these ids, in the order of [`living`](Self::living), in a world that has no result yet. With events, the
    /// next step tells them relative to the pairs of the old world.
    pub(super) fn rename(&mut self, ids: &[Id], old: &World<'_>) {
        if old.config().events && self.before.is_none() {
            self.before = Some(self.pairs_of_last_step(old));
        }
        let living = core::mem::take(&mut self.living);
        (self.ids, self.removed, self.removed_before) = Default::default();
        for (named, id) in living.into_iter().flatten().zip(ids) {
            self.put(Named { id: *id, ..named });
        }
        self.events = None;
    }

    /// The keys of a pair of slots of the last step, the one that was inserted first first.
    pub(super) fn pair(&self, pair: Pair<u32>) -> Option<[K; 2]> {
        let [a, b] = pair.map(|slot| self.in_slot(slot));
        Some(in_order([a?, b?]).map(|named| named.key))
    }

    /// The same of any living objects.
    pub(super) fn any_pair(&self, pair: Pair<u32>) -> Option<[K; 2]> {
        let [a, b] = pair.map(|slot| self.living.get(slot as usize).copied().flatten());
        Some(in_order([a?, b?]).map(|named| named.key))
    }

    /// The same by id, also of objects that are gone.
    pub(super) fn former_pair(&self, pair: [Id; 2]) -> Option<[K; 2]> {
        let [a, b] = pair.map(|id| self.named(id));
        Some(in_order([a?, b?]).map(|named| named.key))
    }

    /// How many removed keys are remembered.
    #[cfg(test)]
    pub(super) fn remembered(&self) -> usize {
        self.removed.len() + self.removed_before.len()
    }
}

fn in_order<K>([a, b]: [Named<K>; 2]) -> [Named<K>; 2] {
    if a.serial < b.serial { [a, b] } else { [b, a] }
}
