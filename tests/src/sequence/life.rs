//! A world, its model and its twin, and what is done to them.

use super::format::{Header, Kind, Operation, operations};
use super::moving::{grow, moved};
use super::tally::Tally;
use super::{draw, filters};
use crate::checked::{Checked, Saved};
use crate::model::Model;
use crate::scenes::Rng;
use crate::worlds::Slab;
use std::fmt::Debug;
use trisap_core::{Aabb, Boxes, Config, Error, Id, Index, Kernels, Object, World};

/// Plays a sequence of operations.
///
/// # Panics
/// If the world, its model and its twin do not say the same.
#[must_use]
pub fn play(bytes: &[u8]) -> Tally {
    let (header, rest) = Header::split(bytes);
    let operations: Vec<Operation> = operations(rest).collect();
    if header.narrow() { live::<u16>(header, &operations) } else { live::<u32>(header, &operations) }
}

/// What is kept from one world to the one that is opened in its place.
pub(super) struct Past {
    /// The last id of each slot.
    pub(super) known: Vec<Option<Id>>,
    pub(super) saves: [Option<Saved>; 4],
    pub(super) tally: Tally,
    pub(super) kernels: Vec<Kernels>,
    /// The configuration of the world; the twin has other workers.
    pub(super) config: Config,
}

/// A world, its model and its twin.
pub(super) struct Life<'m, 'p, I: Index> {
    pub(super) header: Header,
    pub(super) checked: Checked<'m, I>,
    pub(super) twin: World<'m, I>,
    pub(super) past: &'p mut Past,
}

fn live<I: Index>(header: Header, operations: &[Operation]) -> Tally {
    let configs = [header.config(), header.config().with_workers(header.workers())];
    let mut slabs = configs.map(|config| Slab::new::<I>(&config));
    for (slab, config) in slabs.iter_mut().zip(&configs) {
        assert_eq!(slab.world::<I>(config).config(), *config);
    }
    let mut past = Past {
        known: vec![None; header.objects() as usize],
        saves: Default::default(),
        tally: Tally::default(),
        kernels: Kernels::all().collect(),
        config: configs[0],
    };
    let mut model = Model::default();
    if header.rule() {
        model.rule();
    }
    let ends_part = |op: &Operation| matches!(op.kind, Kind::Reopen | Kind::Copy | Kind::Grow);
    for (index, part) in operations.split_inclusive(ends_part).enumerate() {
        let [one, two] =
            slabs.each_mut().map(|slab| World::<I>::open(slab.bytes_mut()).expect("the world that is there"));
        let mut life = Life { header, checked: Checked::resume(one, model), twin: two, past: &mut past };
        if index == 0 {
            let rng = &mut Rng::new(header.start() as u64);
            let boxes: Vec<Aabb> = (0..header.start()).map(|_| draw::aabb(&header, rng)).collect();
            life.insert_many(&boxes);
        }
        for operation in part {
            life.apply(operation.clone());
        }
        model = life.checked.into_model();
        match part.last() {
            Some(Operation { kind: Kind::Copy, argument, .. }) if argument % 4 == 0 => slabs = slabs.clone(),
            Some(Operation { kind: Kind::Copy, .. }) => {
                for slab in &mut slabs {
                    *slab = moved::<I>(slab, |config| config, false).expect("it fits where it was");
                }
            }
            Some(Operation { kind: Kind::Grow, argument, .. }) => {
                grow::<I>(&header, *argument, &mut slabs, &mut past, &model);
            }
            _ => {}
        }
    }
    past.tally
}

impl<'m, I: Index> Life<'m, '_, I> {
    fn apply(&mut self, mut op: Operation) {
        self.past.tally.kinds[op.kind as usize] += 1;
        // Before questions, and while objects come and move, so that leaves fill up between two steps.
        let asks =
            matches!(op.kind, Kind::Overlaps | Kind::Cast | Kind::Nearest | Kind::Batches | Kind::View);
        let changes = matches!(op.kind, Kind::Insert | Kind::InsertMany | Kind::Set | Kind::Remove);
        if (asks || changes) && op.argument % 3 == 1 {
            self.refresh(&op);
        }
        match op.kind {
            Kind::Insert => {
                let aabb = match op.argument {
                    0..208 => draw::aabb(&self.header, &mut op.rng),
                    208..224 => draw::from_f64(&self.header, &mut op.rng),
                    224..240 => draw::from_fixed(&self.header, &mut op.rng),
                    _ => draw::bad_box(&mut op.rng),
                };
                // In some cases at a slot, which there may not be.
                let slot = op.argument % 4 == 3;
                let slot = slot.then(|| op.rng.below(self.objects() as usize + 1) as u32);
                let object = self.described(Object::new(aabb), &mut op);
                self.insert(object, slot);
            }
            Kind::InsertMany => {
                let mut boxes: Vec<Aabb> =
                    (0..self.share(&op)).map(|_| draw::aabb(&self.header, &mut op.rng)).collect();
                if op.argument >= 240 {
                    boxes.push(draw::bad_box(&mut op.rng));
                }
                self.insert_many(&boxes);
            }
            Kind::Set => self.set(&mut op),
            Kind::UpdateMany => self.update_many(&mut op),
            Kind::Remove => self.remove(&mut op),
            Kind::RemoveMany => self.remove_many(&mut op),
            Kind::SetMargin => self.set_margin(&mut op),
            Kind::SetFilter => self.set_filter(&mut op),
            Kind::SetFilterMany => self.set_filter_many(&mut op),
            Kind::SetValue => self.set_value(&mut op),
            Kind::SetValueMany => self.set_value_many(&mut op),
            Kind::SetClasses => self.set_classes(&mut op),
            Kind::Refilter => self.refilter(&mut op),
            Kind::SetResting | Kind::Wake => self.set_resting(&mut op),
            Kind::SetEnabled => self.set_enabled(&mut op),
            Kind::Shift => self.shift(&mut op),
            Kind::Step => self.step(&op),
            Kind::StepOver => self.step_over(&mut op),
            Kind::Overlaps => self.overlaps(&mut op),
            Kind::Cast => self.cast(&mut op),
            Kind::Nearest => self.nearest(&mut op),
            Kind::Batches => self.batches(&mut op),
            Kind::View => self.view(),
            Kind::Save => self.save(&op),
            Kind::Load => self.load(&op),
            Kind::LoadDamaged => self.load_damaged(&mut op),
            Kind::LoadForged => self.load_forged(&mut op),
            Kind::Clear => self.clear(),
            Kind::Reopen | Kind::Copy | Kind::Grow => {}
        }
        // After a step it has been checked.
        if !matches!(op.kind, Kind::Step | Kind::StepOver) {
            self.checked.check();
        }
    }

    /// How many objects there is room for.
    pub(super) fn objects(&self) -> u32 {
        self.past.config.capacity.objects
    }

    /// The same call of the world and of its twin.
    pub(super) fn both<T: PartialEq + Debug>(
        &mut self,
        call: impl Fn(&mut World<'m, I>) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let said = call(self.checked.world_mut());
        assert_eq!(said, call(&mut self.twin), "the twin says something else");
        self.past.tally.say_status(&said);
        said
    }

    /// How many are taken, or tried.
    fn share(&self, op: &Operation) -> usize {
        let objects = self.objects() as usize;
        [1, 2, objects / 9 + 1, objects / 3 + 1, objects][op.argument % 5]
    }

    fn slot(&self, op: &mut Operation) -> u32 {
        op.rng.below(self.objects() as usize) as u32
    }

    /// An id: of three slots the first with an object, or the last id of the third.
    pub(super) fn any(&self, op: &mut Operation) -> Option<Id> {
        let mut id = None;
        for _ in 0..3 {
            let slot = self.slot(op);
            let there = self.checked.world().id_at(slot);
            if there.is_some() {
                return there;
            }
            id = self.past.known[slot as usize];
        }
        id
    }

    /// Several ids. One batch in sixteen has an id twice or a stale one.
    pub(super) fn some(&self, op: &mut Operation) -> Vec<Id> {
        let mut taken = vec![false; self.objects() as usize];
        let mut ids = Vec::new();
        for _ in 0..self.share(op) {
            let slot = self.slot(op);
            if let Some(id) = self.checked.world().id_at(slot)
                && !std::mem::replace(&mut taken[slot as usize], true)
            {
                ids.push(id);
            }
        }
        if op.argument >= 240 {
            let slot = self.slot(op) as usize;
            let stale = self.past.known[slot].filter(|id| !self.checked.world().contains(*id));
            ids.extend(stale.or(ids.first().copied()));
        }
        ids
    }

    pub(super) fn stale(&self, id: Id) -> Result<(), Error> {
        if self.checked.model().contains(id) { Ok(()) } else { Err(Error::StaleId { id }) }
    }

    fn all_alive(&self, ids: &[Id]) -> Result<(), Error> {
        ids.iter().try_for_each(|id| self.stale(*id))
    }

    pub(super) fn model(&mut self) -> &mut Model {
        self.checked.model_mut()
    }

    /// One in four that may come anywhere has more than a box.
    fn described(&self, mut object: Object, op: &mut Operation) -> Object {
        let has = if op.argument % 4 == 2 { op.argument >> 2 } else { 0 };
        object.filter = (has & 1 != 0).then(|| draw::filter(&mut op.rng));
        object.value = (has & 2 != 0).then(|| op.rng.bits());
        object.margin = (has & 4 != 0).then(|| [0.0, 0.125, 0.5, -1.0][op.argument >> 5 & 3]);
        object
    }

    fn insert(&mut self, object: Object, slot: Option<u32>) {
        let (live, room) = (self.checked.model().len() as u64, self.objects());
        let needed = slot.map_or(live, u64::from) + 1;
        let expected = if let Err(error) = self.takes(&object) {
            Some(error)
        } else if let Some(id) = slot.and_then(|slot| self.checked.model().id_at(slot)) {
            Some(Error::SlotTaken { id })
        } else {
            (needed > u64::from(room)).then_some(Error::ObjectsFull { needed, room })
        };
        let said = self.both(|world| match slot {
            Some(slot) => world.insert_at(slot, object),
            None => world.insert(object),
        });
        assert_eq!(said.err(), expected);
        if let Ok(id) = said {
            assert!(slot.is_none_or(|slot| slot == id.slot()), "another slot");
            self.born(id, &object);
        }
    }

    fn takes(&self, object: &Object) -> Result<(), Error> {
        if let Some(filter) = object.filter {
            self.has_filters().and(filters::good(filter))?;
        }
        object.value.map_or(Ok(()), |_| self.has_values())?;
        object.margin.map_or(Ok(()), |length| self.takes_margin(length))?;
        if object.aabb.is_valid() { Ok(()) } else { Err(Error::BadBox { index: 0 }) }
    }

    fn born(&mut self, id: Id, object: &Object) {
        self.past.tally.say(id.to_bits());
        self.past.known[id.slot() as usize] = Some(id);
        self.model().insert(id, object.aabb);
        object.filter.into_iter().for_each(|filter| self.model().set_filter(id, filter));
        object.value.into_iter().for_each(|value| self.model().set_value(id, value));
        if let Some(length) = object.margin {
            assert_eq!(self.checked.world().margin(id), Some(length), "the margin of {id}");
        }
        self.name(id);
    }

    fn insert_many(&mut self, boxes: &[Aabb]) {
        let needed = (self.checked.model().len() + boxes.len()) as u64;
        let bad = boxes.iter().position(|aabb| !aabb.is_valid());
        let expected = if needed > u64::from(self.objects()) {
            Err(Error::ObjectsFull { needed, room: self.objects() })
        } else {
            bad.map_or(Ok(()), |index| Err(Error::BadBox { index: index as u32 }))
        };
        let said = self.both(|world| world.insert_many(Boxes::new(boxes)).map(Iterator::collect::<Vec<_>>));
        assert_eq!(said.as_ref().map(|_| ()).map_err(|error| *error), expected);
        let ids = said.unwrap_or_default();
        assert!(ids.is_empty() || ids.len() == boxes.len(), "an id for each box");
        for (id, aabb) in ids.iter().zip(boxes) {
            self.born(*id, &Object::new(*aabb));
        }
    }

    pub(super) fn moved(&self, id: Id, op: &mut Operation) -> Aabb {
        let aabb = self.checked.world().aabb(id).unwrap_or_default();
        draw::moved(aabb, &self.header, op.argument, &mut op.rng)
    }

    fn set(&mut self, op: &mut Operation) {
        let Some(id) = self.any(op) else { return };
        let next = if op.argument < 240 { self.moved(id, op) } else { draw::bad_box(&mut op.rng) };
        let good = if next.is_valid() { Ok(()) } else { Err(Error::BadBox { index: 0 }) };
        let expected = self.stale(id).and(good);
        assert_eq!(self.both(|world| world.set_aabb(id, next)), expected);
        if expected.is_ok() {
            self.model().set(id, next);
        }
    }

    fn update_many(&mut self, op: &mut Operation) {
        let ids = self.some(op);
        let mut boxes: Vec<Aabb> = ids.iter().map(|id| self.moved(*id, op)).collect();
        if op.argument >= 250
            && let Some(last) = boxes.last_mut()
        {
            *last = draw::bad_box(&mut op.rng);
        }
        let bad = boxes.iter().position(|aabb| !aabb.is_valid());
        let good = bad.map_or(Ok(()), |index| Err(Error::BadBox { index: index as u32 }));
        let expected = self.all_alive(&ids).and(good);
        assert_eq!(self.both(|world| world.update_many(&ids, Boxes::new(&boxes))), expected);
        if expected.is_ok() {
            ids.iter().zip(&boxes).for_each(|(id, aabb)| self.model().set(*id, *aabb));
        }
    }

    fn remove(&mut self, op: &mut Operation) {
        let Some(id) = self.any(op) else { return };
        let expected = self.stale(id);
        assert_eq!(self.both(|world| world.remove(id)), expected);
        if expected.is_ok() {
            self.model().remove(id);
        }
    }

    fn remove_many(&mut self, op: &mut Operation) {
        let ids = self.some(op);
        let twice = ids.iter().enumerate().find(|(at, id)| ids[..*at].contains(id));
        let once = twice.map_or(Ok(()), |(_, id)| Err(Error::StaleId { id: *id }));
        let expected = self.all_alive(&ids).and(once);
        assert_eq!(self.both(|world| world.remove_many(&ids)), expected);
        if expected.is_ok() {
            ids.iter().for_each(|id| self.model().remove(*id));
        }
    }

    fn clear(&mut self) {
        let said = self.both(|world| {
            world.clear();
            Ok(())
        });
        assert_eq!(said, Ok(()));
        for id in self.checked.model().ids() {
            self.model().remove(id);
        }
    }

    fn takes_margin(&self, length: f32) -> Result<(), Error> {
        match self.past.config.margin {
            _ if length < 0.0 => Err(Error::BadMargin),
            None => Err(Error::NoMargins),
            Some(_) => Ok(()),
        }
    }

    fn set_margin(&mut self, op: &mut Operation) {
        let Some(id) = self.any(op) else { return };
        let length = [0.0, 0.125, 0.5, -1.0][op.argument % 4];
        let expected = self.stale(id).and(self.takes_margin(length));
        assert_eq!(self.both(|world| world.set_margin(id, length)), expected);
        if expected.is_ok() {
            assert_eq!(self.checked.world().margin(id), Some(length), "the margin of {id}");
        }
    }

    fn set_resting(&mut self, op: &mut Operation) {
        let ids = self.some(op);
        let rests = op.kind == Kind::SetResting;
        let expected = self.all_alive(&ids);
        let said = self.both(|world| if rests { world.set_resting(&ids) } else { world.wake(&ids) });
        assert_eq!(said, expected);
        if expected.is_ok() {
            ids.iter().for_each(|id| self.model().set_resting(*id, rests));
        }
    }

    fn set_enabled(&mut self, op: &mut Operation) {
        let ids = self.some(op);
        let enabled = op.argument & 2 != 0;
        let expected = self.all_alive(&ids);
        let one = ids.first().filter(|_| ids.len() == 1);
        let said = self.both(|world| match one {
            Some(id) => world.set_enabled(*id, enabled),
            None => world.set_enabled_many(&ids, enabled),
        });
        assert_eq!(said, expected);
        if expected.is_ok() {
            ids.iter().for_each(|id| self.model().set_enabled(*id, enabled));
        }
    }

    /// Boxes are exactly the differences, or the least floats around them.
    fn shift(&mut self, op: &mut Operation) {
        let step = [0.25, 0.1, 1e6, 0.25][op.argument % 4];
        let mut by = [(); 3].map(|()| (op.rng.below(65) as i32 - 32) as f64 * step);
        if op.argument >= 250 {
            by[op.rng.below(3)] = f64::NAN;
        }
        let said = self.both(|world| world.shift_origin(by));
        let Ok(rounded) = said else {
            assert!(by.iter().any(|x| x.is_nan()) && said == Err(Error::BadShift));
            return;
        };
        self.past.tally.say(u64::from(rounded));
        for id in self.checked.model().ids() {
            let Some(old) = self.checked.model().aabb(id.slot()) else { continue };
            let new = self.checked.world().aabb(id).expect("alive");
            for k in 0..3 {
                let (low, high) = (f64::from(old.min[k]) - by[k], f64::from(old.max[k]) - by[k]);
                assert!(
                    f64::from(new.min[k]) <= low && f64::from(new.max[k]) >= high,
                    "{old:?} by {by:?}: {new:?}"
                );
                let tight_below = f64::from(new.min[k].next_up()) >= low || new.min[k] == f32::NEG_INFINITY;
                let tight_above = f64::from(new.max[k].next_down()) <= high || new.max[k] == f32::INFINITY;
                assert!(tight_below && tight_above, "{old:?} by {by:?}: {new:?}");
            }
            self.model().shift(id, new);
        }
    }
}
