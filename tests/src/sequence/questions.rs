//! Queries, and views of the tree.

use super::draw;
use super::format::Operation;
use super::life::Life;
use crate::checked::slots;
use crate::doing::On as _;
use crate::queries::{Questions, ask_cast, ask_nearest, ask_region};
use crate::worlds::Setup;
use std::ops::ControlFlow::Continue;
use trisap_core::{Cast, Error, Filter, Hit, Id, Index, Kernels, Region};

fn is_good(region: &Region) -> bool {
    if let Region::Aabb(aabb) = region { aabb.is_valid() } else { true }
}

fn expected(good: bool) -> Result<(), Error> {
    if good { Ok(()) } else { Err(Error::BadQuery { index: 0 }) }
}

/// Two in three objects. Only about these it is to be asked.
fn two_in_three<'a>(op: &Operation, found: &'a [Option<Id>]) -> impl Fn(Id) -> bool + Copy + Sync + use<'a> {
    let by = op.argument as u32;
    move |id| {
        assert!(found.contains(&Some(id)), "a condition is asked about {id}");
        !(id.slot() + by).is_multiple_of(3)
    }
}

fn ids_of(hits: &[Option<Hit>]) -> Vec<Option<Id>> {
    hits.iter().map(|hit| hit.map(|hit| hit.id)).collect()
}

impl<I: Index> Life<'_, '_, I> {
    fn say_ids(&mut self, ids: &[Option<Id>]) {
        self.past.tally.answers += ids.len() as u64;
        ids.iter().for_each(|id| self.past.tally.say(id.map_or(0, Id::to_bits)));
    }

    fn say_hits(&mut self, hits: &[Option<Hit>]) {
        for hit in hits {
            self.past.tally.answers += 1;
            self.past.tally.say(hit.map_or(0, |hit| hit.id.to_bits()));
            self.past.tally.say(hit.map_or(0, |hit| hit.distance.to_bits()));
        }
    }

    pub(super) fn overlaps(&mut self, op: &mut Operation) {
        let region = draw::region(&self.header, &mut op.rng);
        let mut ids = vec![None; self.objects() as usize];
        let said = self.checked.world_mut().set_kernels(Kernels::SCALAR).overlaps(&region, &mut ids);
        self.past.tally.say_status(&said);
        assert_eq!(said.map(|_| ()), expected(is_good(&region)));
        let Ok(count) = said else { return };
        self.say_ids(&ids[..count]);
        let mut visited = Vec::new();
        let mut visit = |id: Id| {
            visited.push(Some(id));
            Continue(())
        };
        self.checked.world().visit_overlaps(&region, &mut visit).expect("a good region");
        self.say_ids(&visited);
        let found = ids[..count].to_vec();
        let some = two_in_three(op, &found);
        let expected: Vec<Option<Id>> = found.iter().filter(|id| id.is_some_and(some)).copied().collect();
        let count = self.checked.world().among(some).overlaps(&region, &mut ids).expect("a good region");
        assert_eq!(ids[..count], expected, "among some");
        self.say_ids(&expected);
        let setup = self.setup(op);
        let (world, model) = self.checked.parts_mut();
        ask_region(world, model, &region, Setup::REFERENCE);
        ask_region(&mut self.twin, model, &region, setup);
    }

    pub(super) fn cast(&mut self, op: &mut Operation) {
        let cast = draw::cast(&self.header, &mut op.rng);
        let mut hits = vec![None; self.objects() as usize];
        let said = self.checked.world_mut().set_kernels(Kernels::SCALAR).hits(&cast, &mut hits);
        self.past.tally.say_status(&said);
        assert_eq!(said.map(|_| ()), expected(cast.distance >= 0.0));
        let Ok(count) = said else { return };
        self.say_hits(&hits[..count]);
        // All of them, or only those that are nearer than the last.
        let all = op.argument.is_multiple_of(2);
        let mut visited = Vec::new();
        let mut visit = |hit: Hit| {
            visited.push(Some(hit));
            if all { f64::from(cast.distance) } else { hit.distance }
        };
        self.checked.world().visit_hits(&cast, &mut visit).expect("a good cast");
        self.say_hits(&visited);
        let found = ids_of(&hits[..count]);
        let some = two_in_three(op, &found);
        let expected: Vec<Option<Hit>> =
            hits[..count].iter().filter(|hit| hit.is_some_and(|hit| some(hit.id))).copied().collect();
        let count = self.checked.world().among(some).hits(&cast, &mut hits).expect("a good cast");
        assert_eq!(hits[..count], expected, "among some");
        let first = self.checked.world().among(some).first_hit(&cast);
        assert_eq!(first, Ok(expected.first().copied().flatten()), "among some");
        self.say_hits(&expected);
        let setup = self.setup(op);
        let (world, model) = self.checked.parts_mut();
        ask_cast(world, model, &cast, Setup::REFERENCE);
        ask_cast(&mut self.twin, model, &cast, setup);
    }

    pub(super) fn nearest(&mut self, op: &mut Operation) {
        let point = draw::point(&self.header, &mut op.rng);
        let room = [1, 2, 7, self.objects() as usize][op.argument % 4];
        let mut hits = vec![None; room];
        let count = self
            .checked
            .world_mut()
            .set_kernels(Kernels::SCALAR)
            .nearest(point, &mut hits)
            .expect("a good point");
        self.say_hits(&hits[..count]);
        let mut all = vec![None; self.objects() as usize];
        self.checked.world().nearest(point, &mut all).expect("a good point");
        let living = ids_of(&all);
        let some = two_in_three(op, &living);
        let expected = all.iter().filter(|hit| hit.is_some_and(|hit| some(hit.id))).take(room);
        let count = self.checked.world().among(some).nearest(point, &mut hits).expect("a good point");
        assert!(hits[..count].iter().eq(expected), "among some");
        self.say_hits(&hits[..count]);
        // All that is as near as the farthest of them, or only what is nearer than the last.
        let distance = hits[..count].last().copied().flatten().map_or(1.0, |hit| hit.distance);
        let all = op.argument.is_multiple_of(2);
        let mut visited = Vec::new();
        let mut visit = |hit: Hit| {
            visited.push(Some(hit));
            if all { f64::INFINITY } else { hit.distance }
        };
        self.checked.world().visit_nearest(point, distance, &mut visit).expect("a good point");
        self.say_hits(&visited);
        let setup = self.setup(op);
        let (world, model) = self.checked.parts_mut();
        ask_nearest(world, model, point, room, Setup::REFERENCE);
        ask_nearest(&mut self.twin, model, point, room, setup);
    }

    pub(super) fn batches(&mut self, op: &mut Operation) {
        let casts: Vec<Cast> = (0..op.argument % 5).map(|_| draw::cast(&self.header, &mut op.rng)).collect();
        let regions: Vec<Region> =
            (0..op.argument % 5).map(|_| draw::region(&self.header, &mut op.rng)).collect();
        let setup = Setup::REFERENCE;
        let mut hits = vec![None; casts.len()];
        let said =
            self.checked.world_mut().with(setup).among(|_| true).first_hits(&casts, &setup.jobs, &mut hits);
        self.past.tally.say_status(&said);
        let bad_cast = casts.iter().position(|cast| cast.distance < 0.0);
        assert_eq!(said.err(), bad_cast.map(|index| Error::BadQuery { index: index as u32 }));
        let (mut ids, mut ends) = (vec![None; 3 * regions.len()], vec![0; regions.len()]);
        let told = self.checked.world_mut().with(setup).among(|_| true).overlaps_many(
            &regions,
            &setup.jobs,
            &mut ids,
            &mut ends,
        );
        self.past.tally.say_status(&told);
        let bad_region = regions.iter().position(|region| !is_good(region));
        if let Some(index) = bad_region {
            assert_eq!(told, Err(Error::BadQuery { index: index as u32 }));
        }
        if bad_cast.is_none() && bad_region.is_none() {
            self.say_hits(&hits);
            ends.iter().for_each(|end| self.past.tally.say(*end as u64));
            let living: Vec<Option<Id>> = self.checked.world().ids().map(Some).collect();
            let among = self.checked.world().among(two_in_three(op, &living));
            among.first_hits(&casts, &setup.jobs, &mut hits).expect("good casts");
            let full = among.overlaps_many(&regions, &setup.jobs, &mut ids, &mut ends);
            assert!(matches!(full, Ok(_) | Err(Error::OutputFull { .. })));
            self.say_hits(&hits);
            ends.iter().for_each(|end| self.past.tally.say(*end as u64));
            let questions = Questions { regions, casts, ..Questions::default() };
            let other = self.setup(op);
            let (world, model) = self.checked.parts_mut();
            questions.ask(world, model, setup);
            questions.ask_batches(world, setup);
            questions.ask_batches(&mut self.twin, other);
        }
    }

    /// The twin has the same tree.
    pub(super) fn view(&mut self) {
        let (world, twin) = (self.checked.world(), &self.twin);
        let (leaves, planes): (Vec<_>, Vec<_>) = (world.leaves().collect(), world.planes().collect());
        let large: Vec<_> = world.large().collect();
        assert!(leaves.iter().copied().eq(twin.leaves()) && planes.iter().copied().eq(twin.planes()));
        assert!(large.iter().copied().eq(twin.large()));
        assert_eq!(world.config(), self.past.config);
        assert_eq!(world.snapshot_size(), twin.snapshot_size());
        assert_eq!(world.capacity(), world.config().capacity);
        let partners = |id: Id| world.pairs_of(id).count();
        let live = world.pair_ids().count();
        assert_eq!(world.ids().map(partners).sum::<usize>(), 2 * live, "each pair is of two objects");
        assert!(world.ids().all(|id| world.margin(id) == twin.margin(id)), "the twin's margins");
        let len = world.len();
        for number in [leaves.len(), planes.len(), large.len(), len as usize] {
            self.past.tally.say(number as u64);
        }
        self.say_contents();
    }

    /// All that is known of the objects, and the last result.
    fn say_contents(&mut self) {
        let (world, tally) = (self.checked.world(), &mut self.past.tally);
        for (id, aabb) in world.iter() {
            tally.say(id.to_bits());
            tally.say(u64::from(world.is_resting(id)) + 2 * u64::from(world.is_enabled(id)));
            aabb.min.iter().chain(&aabb.max).for_each(|x| tally.say(u64::from(x.to_bits())));
            if let Some(Filter { group, mask, class }) = world.filter(id) {
                [group, mask, class].iter().for_each(|part| tally.say(u64::from(*part)));
            }
            if let Some(value) = world.value(id) {
                tally.say(value);
            }
        }
        tally.say_pairs(&slots(world.pairs()));
        tally.say_pairs(&slots(world.found()));
        tally.say_pairs(&slots(world.lost()));
    }
}
