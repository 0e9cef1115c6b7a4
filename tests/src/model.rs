//! A world as simple as can be: what every call must do, without any structure to make it fast.

use crate::{SlotPair, oracle};
use std::collections::HashMap;
use trisap_core::{Aabb, Filter, Id};

/// One pair of a complete step, with the generations of its slots: a slot that was given away in between makes
/// it another pair.
type Held = (SlotPair, [u32; 2]);

/// The naive model of a world.
#[derive(Clone, Debug, Default)]
pub struct Model {
    boxes: Vec<Option<Aabb>>,
    /// Those of disabled objects.
    hidden: Vec<Option<Aabb>>,
    generations: Vec<u32>,
    filters: Vec<Filter>,
    /// Which classes meet; all do where nothing has been said.
    classes: Option<[u32; 32]>,
    /// What the rule thinks of the object in each slot; without a rule nothing.
    opinions: Option<Vec<u32>>,
    resting: Vec<bool>,
    /// Of all objects that have got one, also of those that are no more.
    values: HashMap<Id, u64>,
    last: Vec<Held>,
    /// Whether the last step was not complete.
    incomplete: bool,
    /// The generations of all slots in the last complete step, and in the one before.
    known: Vec<u32>,
    former: Vec<u32>,
}

/// What came and went between two complete steps, ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Events {
    /// Pairs that the earlier step did not have.
    pub found: Vec<SlotPair>,
    /// Pairs that the later step does not have.
    pub lost: Vec<SlotPair>,
}

impl Model {
    /// A model that follows events alone: objects in the first `count` slots, which never change.
    #[must_use]
    pub fn of_events(count: usize) -> Self {
        Self {
            boxes: vec![None; count],
            hidden: vec![None; count],
            generations: vec![1; count],
            ..Self::default()
        }
    }

    /// Takes a new object under the id that the world gave it.
    ///
    /// # Panics
    /// If the id cannot be right: a slot in use, or a generation that is not the slot's next one.
    pub fn insert(&mut self, id: Id, aabb: Aabb) {
        let slot = id.slot() as usize;
        if slot >= self.boxes.len() {
            self.boxes.resize(slot + 1, None);
            self.hidden.resize(slot + 1, None);
            // The slots between are as if somebody had come and gone.
            self.generations.resize(slot, 1);
            self.generations.push(0);
            self.filters.resize(slot + 1, Filter::ALL);
            self.resting.resize(slot + 1, false);
        }
        assert!(self.aabb(slot as u32).is_none(), "{id} was given out, but its slot is in use");
        self.generations[slot] += 1;
        assert_eq!(id.generation(), self.generations[slot], "{id} has not the next generation of its slot");
        self.boxes[slot] = Some(aabb);
        self.filters[slot] = Filter::ALL;
        self.resting[slot] = false;
        if let Some(opinions) = &mut self.opinions {
            opinions.resize(self.boxes.len(), 0);
            opinions[slot] = 0;
        }
    }

    /// Moves an object, which wakes it.
    pub fn set(&mut self, id: Id, aabb: Aabb) {
        assert!(self.contains(id), "the test moves {id}, which is not alive");
        self.shift(id, aabb);
        self.resting[id.slot() as usize] = false;
    }

    /// Gives an object the box that it has from another origin.
    pub fn shift(&mut self, id: Id, aabb: Aabb) {
        let boxes = if self.is_enabled(id.slot()) { &mut self.boxes } else { &mut self.hidden };
        boxes[id.slot() as usize] = Some(aabb);
    }

    /// Disables an object, which rests from then on, or enables it, which wakes it.
    pub fn set_enabled(&mut self, id: Id, enabled: bool) {
        let slot = id.slot() as usize;
        if self.is_enabled(id.slot()) != enabled {
            std::mem::swap(&mut self.boxes[slot], &mut self.hidden[slot]);
            self.resting[slot] = !enabled;
        }
    }

    /// Whether the object in a slot is enabled.
    #[must_use]
    pub fn is_enabled(&self, slot: u32) -> bool {
        self.boxes[slot as usize].is_some()
    }

    /// The box of the object in a slot, enabled or not.
    #[must_use]
    pub fn aabb(&self, slot: u32) -> Option<Aabb> {
        self.boxes.get(slot as usize)?.or(self.hidden[slot as usize])
    }

    /// Sets whom an object meets.
    pub fn set_filter(&mut self, id: Id, filter: Filter) {
        self.filters[id.slot() as usize] = filter;
    }

    /// Whom an object meets.
    #[must_use]
    pub fn filter(&self, slot: u32) -> Filter {
        self.filters[slot as usize]
    }

    /// Gives an object a value.
    pub fn set_value(&mut self, id: Id, value: u64) {
        assert!(self.contains(id), "the test gives a value to {id}, which is not alive");
        self.values.insert(id, value);
    }

    /// The value of an object, or the last one that it had.
    #[must_use]
    pub fn value(&self, id: Id) -> u64 {
        self.values.get(&id).copied().unwrap_or(0)
    }

    /// Sets which classes meet.
    pub fn set_classes(&mut self, meets: &[u32; 32]) {
        self.classes = Some(*meets);
    }

    /// From now on there is a rule.
    pub fn rule(&mut self) {
        self.opinions = Some(vec![0; self.boxes.len()]);
    }

    /// Whether there is a rule.
    #[must_use]
    pub fn has_rule(&self) -> bool {
        self.opinions.is_some()
    }

    /// What the rule thinks of an object from now on.
    pub fn set_opinion(&mut self, id: Id, opinion: u32) {
        if let Some(opinions) = &mut self.opinions {
            opinions[id.slot() as usize] = opinion;
        }
    }

    /// The rule: no two objects whose opinions add up to one, four, seven and so on.
    #[must_use]
    pub fn agree(&self, a: u32, b: u32) -> bool {
        assert!(a < b, "the rule is asked about the lower slot first");
        let of = |slot: u32| self.opinions.as_ref().map_or(0, |opinions| opinions[slot as usize]);
        (of(a) + of(b)) % 3 != 1
    }

    /// Whether two objects make a pair where their boxes overlap.
    #[must_use]
    pub fn meet(&self, [a, b]: SlotPair) -> bool {
        self.filters_meet([a, b]) && self.agree(a, b)
    }

    /// Whether the filters let two objects make a pair.
    #[must_use]
    pub fn filters_meet(&self, [a, b]: SlotPair) -> bool {
        let (one, other) = (self.filter(a), self.filter(b));
        let likes = |one: Filter, other: Filter| {
            let classes = self.classes.map_or(u32::MAX, |classes| classes[one.class as usize]);
            other.group & one.mask > 0 && classes & (1 << other.class) > 0
        };
        likes(one, other) && likes(other, one)
    }

    /// Puts an object to rest or wakes it.
    pub fn set_resting(&mut self, id: Id, rests: bool) {
        assert!(self.contains(id), "the test puts {id} to rest, which is not alive");
        self.resting[id.slot() as usize] = rests;
    }

    /// Whether the object in a slot rests.
    #[must_use]
    pub fn is_resting(&self, slot: u32) -> bool {
        self.resting[slot as usize]
    }

    /// Removes an object.
    pub fn remove(&mut self, id: Id) {
        assert!(self.contains(id), "the test removes {id}, which is not alive");
        self.boxes[id.slot() as usize] = None;
        self.hidden[id.slot() as usize] = None;
        self.resting[id.slot() as usize] = false;
    }

    /// Whether the id names a living object.
    #[must_use]
    pub fn contains(&self, id: Id) -> bool {
        self.id_at(id.slot()) == Some(id)
    }

    /// The object of a slot.
    #[must_use]
    pub fn id_at(&self, slot: u32) -> Option<Id> {
        self.aabb(slot)?;
        Id::from_bits((u64::from(self.generations[slot as usize]) << 32) | u64::from(slot))
    }

    /// The object that had a slot in the complete step before the last one.
    #[must_use]
    pub fn former_id(&self, slot: u32) -> Option<Id> {
        let generation = *self.former.get(slot as usize)?;
        Id::from_bits((u64::from(generation) << 32) | u64::from(slot))
    }

    /// The living objects by ascending slot.
    #[must_use]
    pub fn ids(&self) -> Vec<Id> {
        (0..self.boxes.len() as u32).filter_map(|slot| self.id_at(slot)).collect()
    }

    /// How many objects are alive.
    #[must_use]
    pub fn len(&self) -> usize {
        self.boxes.iter().chain(&self.hidden).flatten().count()
    }

    /// Whether no object is alive.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The boxes by slot; dead and disabled slots are empty.
    #[must_use]
    pub fn boxes(&self) -> &[Option<Aabb>] {
        &self.boxes
    }

    /// The pairs that an exact step must return, ascending.
    #[must_use]
    pub fn pairs(&self) -> Vec<SlotPair> {
        let mut pairs = oracle::overlaps(&self.boxes);
        // Where nobody has said anything of anybody all meet.
        if self.classes.is_some()
            || self.has_rule()
            || self.filters.iter().any(|filter| *filter != Filter::ALL)
        {
            pairs.retain(|pair| self.meet(*pair));
        }
        pairs
    }

    /// How many pairs the last complete step had.
    #[must_use]
    pub fn last_pairs(&self) -> usize {
        self.last.len()
    }

    /// The pairs of the last step whose objects live, ascending; `None` if it was not complete.
    #[must_use]
    pub fn living_pairs(&self) -> Option<Vec<[Id; 2]>> {
        let id = |slot: u32, generation| self.id_at(slot).filter(|id| id.generation() == generation);
        let ids = |([a, b], [first, second]): &Held| Some([id(*a, *first)?, id(*b, *second)?]);
        (!self.incomplete).then(|| self.last.iter().filter_map(ids).collect())
    }

    /// A step was not complete.
    pub fn fail(&mut self) {
        self.incomplete = true;
    }

    /// Takes the pairs of a complete step (ascending) and tells what has changed since the last one.
    pub fn complete(&mut self, pairs: &[SlotPair]) -> Events {
        let generation = |slot: u32| self.generations[slot as usize];
        let held: Vec<Held> = pairs.iter().map(|&[a, b]| ([a, b], [generation(a), generation(b)])).collect();
        let events =
            Events { found: only_in_first(&held, &self.last), lost: only_in_first(&self.last, &held) };
        self.last = held;
        self.incomplete = false;
        self.former = std::mem::replace(&mut self.known, self.generations.clone());
        events
    }
}

/// The pairs of one ascending list that another does not have.
fn only_in_first(first: &[Held], second: &[Held]) -> Vec<SlotPair> {
    let mut rest = second.iter().peekable();
    let mut only = Vec::new();
    for held in first {
        while rest.next_if(|other| *other < held).is_some() {}
        if rest.peek() != Some(&held) {
            only.push(held.0);
        }
    }
    only
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(slot: u32, generation: u32) -> Id {
        Id::from_bits((u64::from(generation) << 32) | u64::from(slot)).unwrap()
    }

    #[test]
    fn reuse_of_an_id_loses_and_finds_the_pair() {
        let unit = Aabb::new([0.0; 3], [1.0; 3]);
        let mut model = Model::default();
        model.insert(id(0, 1), unit);
        model.insert(id(1, 1), unit);
        let pairs = model.pairs();
        assert_eq!(model.complete(&pairs), Events { found: vec![[0, 1]], lost: vec![] });
        assert_eq!(model.complete(&pairs), Events::default());
        model.remove(id(1, 1));
        model.insert(id(1, 2), unit);
        let pairs = model.pairs();
        assert_eq!(model.complete(&pairs), Events { found: vec![[0, 1]], lost: vec![[0, 1]] });
        model.remove(id(0, 1));
        let pairs = model.pairs();
        assert_eq!(model.complete(&pairs), Events { found: vec![], lost: vec![[0, 1]] });
    }

    #[test]
    #[should_panic(expected = "next generation")]
    fn a_generation_that_comes_back_is_noticed() {
        let mut model = Model::default();
        model.insert(id(0, 1), Aabb::default());
        model.remove(id(0, 1));
        model.insert(id(0, 1), Aabb::default());
    }
}
