//! A world that is compared with the model after everything that is done to it.

use crate::doing::On as _;
use crate::model::{Events, Model};
use crate::worlds::Setup;
use crate::{SlotPair, oracle, sorted};
use trisap_core::{Aabb, Boxes, Config, Error, Filter, Id, Index, Mode, Pair, Rejected, Stats, Step, World};

/// What a complete step said, copied out of the world in the order in which it said it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// The overlapping pairs.
    pub pairs: Vec<SlotPair>,
    /// The pairs that came.
    pub found: Vec<SlotPair>,
    /// The pairs that went.
    pub lost: Vec<SlotPair>,
    /// In a world with values: those of the overlapping pairs, then of those that came, then of those that went.
    pub values: Vec<[u64; 2]>,
    /// The boxes that the step refused.
    pub rejected: Option<Rejected>,
    /// Pairs beyond the exact ones.
    pub surplus: u64,
    /// The statistics.
    pub stats: Stats,
    /// Whether `f32` is too coarse for some box.
    pub coarse: bool,
}

impl Outcome {
    /// Copies a step.
    #[must_use]
    pub fn of<I: Index>(step: &Step<'_, I>) -> Self {
        Self {
            pairs: slots(step.pairs()),
            found: slots(step.found()),
            lost: slots(step.lost()),
            values: step.pair_values().chain(step.found_values()).chain(step.lost_values()).collect(),
            rejected: step.rejected(),
            surplus: step.surplus(),
            stats: step.stats(),
            coarse: step.is_coarse(),
        }
    }
}

/// Pairs of any index width as slots.
#[must_use]
pub fn slots<I: Index>(pairs: &[Pair<I>]) -> Vec<SlotPair> {
    pairs.iter().map(|pair| pair.map(Index::slot)).collect()
}

/// A snapshot of a world, and the model as it was then.
pub type Saved = (Vec<u8>, Model);

/// A world and its model.
pub struct Checked<'m, I: Index = u32> {
    world: World<'m, I>,
    model: Model,
    config: Config,
    /// Whether calls between steps are followed by a check, too.
    each_call: bool,
}

impl<'m, I: Index> Checked<'m, I> {
    /// Follows an empty world.
    pub fn new(world: World<'m, I>) -> Self {
        assert!(world.is_empty(), "a world with a past needs its model: see resume");
        Self::resume(world, Model::default())
    }

    /// Follows a world that the model has followed up to here.
    pub fn resume(world: World<'m, I>, model: Model) -> Self {
        let config = world.config();
        let checked = Self { world, model, config, each_call: true };
        checked.check();
        checked
    }

    /// Does what other setups do, too: all calls are checked on the reference, and on the others only steps. Calls between steps
    /// use no kernels and no job system, and the check behind a step sees what they have done.
    #[must_use]
    pub fn like_the_reference(mut self, setup: Setup) -> Self {
        self.each_call = setup.is_reference();
        self
    }

    /// Gives the model back, to follow the world again when it has been reopened.
    pub fn into_model(self) -> Model {
        self.model
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The world, for calls that change nothing.
    pub fn world(&self) -> &World<'m, I> {
        &self.world
    }

    /// The world, for calls that must fail.
    pub fn world_mut(&mut self) -> &mut World<'m, I> {
        &mut self.world
    }

    /// The model, after a call that it has to follow.
    pub fn model_mut(&mut self) -> &mut Model {
        &mut self.model
    }

    /// The world and the model.
    pub fn parts_mut(&mut self) -> (&mut World<'m, I>, &Model) {
        (&mut self.world, &self.model)
    }

    /// Every invariant, and every object against the model.
    ///
    /// # Panics
    /// If the world is not what the model says.
    pub fn check(&self) {
        if let Err(invalid) = self.world.validate() {
            panic!("the world is not valid: {invalid}");
        }
        assert_eq!(self.world.len() as usize, self.model.len());
        assert_eq!(self.world.is_empty(), self.model.is_empty());
        assert!(self.world.ids().eq(self.model.ids()), "the ids in order");
        assert!(self.world.iter().all(|(id, aabb)| self.model.aabb(id.slot()) == Some(aabb)));
        if let Some(living) = self.model.living_pairs() {
            let mut pairs: Vec<[Id; 2]> = self.world.pair_ids().collect();
            pairs.sort_unstable_by_key(|pair| pair.map(Id::slot));
            assert_eq!(pairs, living, "the pairs whose objects live");
            let values = living.iter().map(|pair| pair.map(|id| self.model.value(id)));
            let mut told: Vec<[u64; 2]> = self.world.pair_values().collect();
            let mut values: Vec<[u64; 2]> = values.filter(|_| self.config.values).collect();
            told.sort_unstable();
            values.sort_unstable();
            assert_eq!(told, values, "their values");
        }
        for slot in 0..self.model.boxes().len() as u32 {
            let id = self.model.id_at(slot);
            assert_eq!(self.world.id_at(slot), id, "the id at slot {slot}");
            if let Some(id) = id {
                // Equal as numbers: a negative zero may come back as a positive one.
                assert_eq!(self.world.aabb(id), self.model.aabb(slot), "the box of {id}");
                assert_eq!(self.world.is_enabled(id), self.model.is_enabled(slot), "whether {id} is enabled");
                assert!(self.world.contains(id));
                assert_eq!(self.world.is_resting(id), self.model.is_resting(slot), "whether {id} rests");
                let filter = self.config.filters.then(|| self.model.filter(slot));
                assert_eq!(self.world.filter(id), filter, "the filter of {id}");
                let value = self.config.values.then(|| self.model.value(id));
                assert_eq!(self.world.value(id), value, "the value of {id}");
            }
        }
    }

    fn check_call(&self) {
        if self.each_call {
            self.check();
        }
    }

    /// Inserts one object.
    pub fn insert(&mut self, aabb: Aabb) -> Id {
        let id = self.world.insert(aabb).expect("room and a good box");
        self.model.insert(id, aabb);
        self.check_call();
        id
    }

    /// Inserts several objects in one call.
    pub fn insert_many(&mut self, boxes: &[Aabb]) -> Vec<Id> {
        let ids = self.world.insert_many(Boxes::new(boxes)).expect("room and good boxes");
        assert_eq!(ids.len(), boxes.len());
        let ids: Vec<Id> = ids.collect();
        assert_eq!(ids.len(), boxes.len(), "an id for each box");
        for (id, aabb) in ids.iter().zip(boxes) {
            self.model.insert(*id, *aabb);
        }
        self.check_call();
        ids
    }

    /// Moves one object.
    pub fn set(&mut self, id: Id, aabb: Aabb) {
        self.world.set_aabb(id, aabb).expect("a living object and a good box");
        self.model.set(id, aabb);
        self.check_call();
    }

    /// Moves several objects in one call.
    pub fn update_many(&mut self, ids: &[Id], boxes: &[Aabb]) {
        self.world.update_many(ids, Boxes::new(boxes)).expect("living objects and good boxes");
        for (id, aabb) in ids.iter().zip(boxes) {
            self.model.set(*id, *aabb);
        }
        self.check_call();
    }

    /// Gives an object a margin of its own.
    pub fn set_margin(&mut self, id: Id, length: f32) {
        let expected = if self.config.margin.is_some() { Ok(()) } else { Err(Error::NoMargins) };
        assert_eq!(self.world.set_margin(id, length), expected);
        self.check_call();
    }

    /// Sets whom an object meets.
    pub fn set_filter(&mut self, id: Id, filter: Filter) {
        self.world.set_filter(id, filter).expect("a living object and a good class");
        self.model.set_filter(id, filter);
        self.check_call();
    }

    /// Sets which classes meet.
    pub fn set_classes(&mut self, meets: &[u32; 32]) {
        self.world.set_classes(meets).expect("a world with filters");
        self.model.set_classes(meets);
        self.check_call();
    }

    /// From now on, steps have a rule.
    pub fn rule(&mut self) {
        self.model.rule();
    }

    /// The rule changes its mind about an object.
    pub fn refilter(&mut self, id: Id, opinion: u32) {
        self.world.refilter(id).expect("a living object in a world with filters");
        self.model.set_opinion(id, opinion);
        self.check_call();
    }

    /// Puts objects to rest.
    pub fn set_resting(&mut self, ids: &[Id]) {
        self.world.set_resting(ids).expect("living objects");
        ids.iter().for_each(|id| self.model.set_resting(*id, true));
        self.check_call();
    }

    /// Wakes objects.
    pub fn wake(&mut self, ids: &[Id]) {
        self.world.wake(ids).expect("living objects");
        ids.iter().for_each(|id| self.model.set_resting(*id, false));
        self.check_call();
    }

    /// Disables objects, or enables them.
    pub fn set_enabled(&mut self, ids: &[Id], enabled: bool) {
        self.world.set_enabled_many(ids, enabled).expect("living objects");
        ids.iter().for_each(|id| self.model.set_enabled(*id, enabled));
        self.check_call();
    }

    /// A snapshot of the world, and the model as it is now.
    pub fn save(&self) -> Saved {
        let size = self.world.snapshot_size();
        let mut bytes = vec![0; size + 3];
        assert_eq!(self.world.save(&mut bytes), Ok(size));
        assert_eq!(bytes[size..], [0; 3], "nothing is written behind a snapshot");
        bytes.truncate(size);
        (bytes, self.model.clone())
    }

    /// Goes back to a snapshot.
    pub fn load(&mut self, (bytes, model): &Saved) {
        self.world.load(bytes).expect("a good snapshot");
        self.model = model.clone();
        self.check_call();
    }

    /// Removes one object.
    pub fn remove(&mut self, id: Id) {
        self.world.remove(id).expect("a living object");
        self.model.remove(id);
        self.check_call();
    }

    /// Removes several objects in one call.
    pub fn remove_many(&mut self, ids: &[Id]) {
        self.world.remove_many(ids).expect("living objects");
        for id in ids {
            self.model.remove(*id);
        }
        self.check_call();
    }

    /// Makes a call that must fail, and sees that it changed nothing.
    ///
    /// # Panics
    /// If the call succeeds, or changes anything.
    pub fn refuse<T>(&mut self, call: impl FnOnce(&mut World<'m, I>) -> Result<T, Error>) -> Error {
        let error = call(&mut self.world).err().expect("a refusal");
        self.check();
        error
    }

    /// A step that must be complete.
    pub fn step(&mut self, setup: Setup) -> Outcome {
        self.try_step(setup).unwrap_or_else(|error| panic!("{setup:?}: {error}"))
    }

    /// A step over a bounds array that must be complete.
    pub fn step_over(&mut self, boxes: &[Aabb], setup: Setup) -> Outcome {
        self.try_step_over(boxes, setup).unwrap_or_else(|error| panic!("{setup:?}: {error}"))
    }

    /// A step. An error must be a full pair buffer, and the right one.
    pub fn try_step(&mut self, setup: Setup) -> Result<Outcome, Error> {
        let result = self.advance(None, setup);
        self.settle(result, None)
    }

    fn advance(&mut self, bounds: Option<Boxes<'_>>, setup: Setup) -> Result<Outcome, Error> {
        let Self { world, model, .. } = self;
        // At the end of the step.
        let aabb = |slot: u32| {
            let known = model.boxes().get(slot as usize).copied().flatten();
            let given = bounds.and_then(|bounds| bounds.get(slot as usize)).filter(Aabb::is_valid);
            known.map(|known| given.filter(|_| !model.is_resting(slot)).unwrap_or(known))
        };
        let has_margins = world.config().margin.is_some() || world.config().predicted;
        let rule = |a, b| {
            let (Some(one), Some(other)) = (aabb(a), aabb(b)) else {
                panic!("the rule is asked about {a} and {b}, of which one is no more")
            };
            assert!(
                has_margins || one.overlaps(&other),
                "the rule is asked about {a} and {b}, which do not overlap"
            );
            assert!(
                model.filters_meet([a, b]),
                "the rule is asked about {a} and {b}, which filters keep apart"
            );
            model.agree(a, b)
        };
        let mut stepper = world.under(&setup);
        if model.has_rule() {
            stepper = stepper.with_rule(&rule);
        }
        let step = match bounds {
            Some(bounds) => stepper.step_over(bounds),
            None => stepper.step(),
        };
        step.map(|step| Outcome::of(&step))
    }

    /// A step over a bounds array, which may have bad boxes in it, be shorter than the slots or longer.
    pub fn try_step_over(&mut self, boxes: &[Aabb], setup: Setup) -> Result<Outcome, Error> {
        let result = self.advance(Some(Boxes::new(boxes)), setup);
        let mut rejected: Option<Rejected> = None;
        for (aabb, slot) in boxes.iter().zip(0..) {
            let Some(id) = self.model.id_at(slot) else { continue };
            if self.model.is_resting(slot) || !self.model.is_enabled(slot) {
                continue;
            }
            if aabb.is_valid() {
                self.model.set(id, *aabb);
            } else {
                rejected.get_or_insert(Rejected { first: id, count: 0 }).count += 1;
            }
        }
        self.settle(result, rejected)
    }

    /// Compares what a step said with the model, which has the boxes of that step.
    ///
    /// # Errors
    /// That of the step.
    pub fn settle(
        &mut self,
        result: Result<Outcome, Error>,
        rejected: Option<Rejected>,
    ) -> Result<Outcome, Error> {
        let exact = self.model.pairs();
        match &result {
            Ok(outcome) => {
                assert_eq!(outcome.rejected, rejected, "the refused boxes");
                self.check_pairs(outcome, &exact);
                self.check_stats(outcome);
                self.check_ids(outcome);
                assert_eq!(slots(self.world.pairs()), outcome.pairs, "World::pairs after the step");
                assert_eq!(slots(self.world.found()), outcome.found, "World::found after the step");
                assert_eq!(slots(self.world.lost()), outcome.lost, "World::lost after the step");
            }
            Err(error) => {
                self.check_overflow(*error, &exact);
                self.model.fail();
            }
        }
        self.check();
        result
    }

    fn check_pairs(&mut self, outcome: &Outcome, exact: &[SlotPair]) {
        let pairs = sorted(&outcome.pairs);
        assert!(pairs.iter().all(|[a, b]| a < b), "a pair has its lower slot first");
        assert!(pairs.windows(2).all(|two| two[0] != two[1]), "no pair is told twice");
        match self.config.mode {
            Mode::Exact => assert_same(&pairs, exact, self.model.boxes()),
            Mode::Fat => {
                let missing = first_absent(exact, &pairs);
                assert_eq!(missing, None, "every overlap is among the fat pairs");
                let barred = pairs.iter().find(|pair| !self.model.meet(**pair));
                assert_eq!(barred, None, "no pair that a filter holds back");
            }
        }
        assert_eq!(outcome.surplus, (pairs.len() - exact.len()) as u64, "the surplus");
        let events = self.model.complete(&pairs);
        let told = Events { found: sorted(&outcome.found), lost: sorted(&outcome.lost) };
        if self.config.events {
            assert_eq!(told, events, "found and lost are the difference to the last complete step");
        } else {
            assert_eq!(told, Events::default(), "no events were asked for");
        }
    }

    /// The pairs by id and by value: those that live, and of the lost ones those that the model knew in the step before.
    fn check_ids(&self, outcome: &Outcome) {
        let named = |pairs: &[SlotPair], at: &dyn Fn(u32) -> Option<Id>| -> Vec<[Id; 2]> {
            pairs.iter().map(|pair| pair.map(|slot| at(slot).expect("a known object"))).collect()
        };
        let living = |slot| self.model.id_at(slot);
        let former = |slot| self.model.former_id(slot);
        let [pairs, found] = [&outcome.pairs, &outcome.found].map(|pairs| named(pairs, &living));
        let lost = named(&outcome.lost, &former);
        assert!(self.world.pair_ids().eq(pairs.iter().copied()), "pairs by id");
        assert!(self.world.found_ids().eq(found.iter().copied()), "found by id");
        assert!(self.world.lost_ids().eq(lost.iter().copied()), "lost by id");
        let all = pairs.iter().chain(&found).chain(&lost);
        let values = all.filter(|_| self.config.values).map(|pair| pair.map(|id| self.model.value(id)));
        assert!(values.eq(outcome.values.iter().copied()), "pairs by value");
    }

    fn check_stats(&self, outcome: &Outcome) {
        let stats = &outcome.stats;
        assert_eq!(stats.objects as usize, self.model.boxes().iter().flatten().count());
        assert_eq!(stats.pairs, outcome.pairs.len() as u64);
        assert_eq!(stats.found, outcome.found.len() as u64);
        assert_eq!(stats.lost, outcome.lost.len() as u64);
        // Removed objects count as moved, once for each slot.
        assert!(stats.moved as usize <= self.model.boxes().len(), "{} moved", stats.moved);
    }

    fn check_overflow(&self, error: Error, exact: &[SlotPair]) {
        let Error::PairsFull { needed, .. } = error else {
            panic!("a step fails for lack of room only: {error:?}")
        };
        let capacity = self.config.capacity.pairs;
        assert!(needed > u64::from(capacity), "{needed} pairs fit into {capacity}");
        let prefix = sorted(&slots(self.world.pairs()));
        if self.config.margin.is_none() && !self.config.predicted {
            assert_eq!(needed, exact.len() as u64, "the pairs that are needed");
            assert_eq!(prefix.len(), capacity as usize, "the buffer is filled");
        } else {
            // The overlaps of fat boxes go through the buffer too.
            assert!(needed >= exact.len() as u64, "{needed} are not enough for {} pairs", exact.len());
            assert!(prefix.len() <= capacity as usize, "no more pairs than fit");
        }
        assert!(prefix.windows(2).all(|two| two[0] != two[1]), "no pair is told twice");
        if self.config.mode == Mode::Exact {
            let wrong = first_absent(&prefix, exact);
            assert_eq!(wrong, None, "every pair of the prefix is an overlap");
        }
        assert!(self.world.found().is_empty() && self.world.lost().is_empty(), "no events without all pairs");
    }
}

/// The first pair of an ascending list that another one does not have.
fn first_absent<'p>(pairs: &'p [SlotPair], others: &[SlotPair]) -> Option<&'p SlotPair> {
    let mut rest = others.iter().peekable();
    pairs.iter().find(|pair| {
        while rest.next_if(|other| other < pair).is_some() {}
        rest.peek() != Some(pair)
    })
}

/// Compares two ascending lists of pairs, and shows the boxes of the first difference.
///
/// # Panics
/// If they differ.
pub fn assert_same(pairs: &[SlotPair], expected: &[SlotPair], boxes: &[Option<Aabb>]) {
    if pairs == expected {
        return;
    }
    let show = |pair: Option<&SlotPair>| pair.map(|pair| (*pair, pair.map(|slot| boxes[slot as usize])));
    let missing = show(expected.iter().find(|pair| pairs.binary_search(pair).is_err()));
    let wrong = show(pairs.iter().find(|pair| expected.binary_search(pair).is_err()));
    panic!(
        "{} pairs for {}; first missing: {missing:?}; first wrong: {wrong:?}",
        pairs.len(),
        expected.len()
    );
}

/// All pairs of a scene, ascending, in the way that suits its size.
#[must_use]
pub fn expected(boxes: &[Aabb]) -> Vec<SlotPair> {
    oracle::overlaps(&oracle::all_live(boxes))
}

#[cfg(test)]
mod tests {
    use super::first_absent;

    #[test]
    fn what_another_list_lacks_is_found_wherever_it_stands() {
        let all = [[0, 1], [0, 2], [1, 2], [2, 9]];
        assert_eq!(first_absent(&all, &all), None);
        assert_eq!(first_absent(&[], &all), None);
        for (at, pair) in all.iter().enumerate() {
            let less: Vec<_> = all.iter().copied().filter(|other| other != pair).collect();
            assert_eq!(first_absent(&all, &less), Some(pair), "{at}");
            assert_eq!(first_absent(&less, &all), None);
            assert_eq!(first_absent(&all[at..], &all[..at]), Some(pair));
        }
    }
}
