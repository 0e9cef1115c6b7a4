//! The world of one rank: the objects that it owns and the ghosts of others, and what has changed between their pairs.
//!
//! A step may sweep twice. The first sweep has the rank's own boxes as they are now and the ghosts as they were, and runs while
//! the ghosts' boxes travel; the second one has all boxes as they are now, and few movers. What either sweep finds or loses
//! is a candidate. Boxes decide: a pair is found if its boxes overlap now and did not in the last step, and lost if it is the
//! other way round. So an object that comes from another rank brings its box of the last step.

use crate::events::{Deciding, Gone, When, ordered};
use crate::message::NOWHERE;
use crate::split::{Cell, corner};
use crate::table::{KeyMap, KeyPair, Object, Table};
use trisap::{Boxes, Capacity, Config, Error, Executor, Kernels, OwnedWorld};

/// What a sweep of a rank's world runs on.
#[derive(Clone, Copy)]
pub(crate) struct Means<'e> {
    pub(crate) kernels: Kernels,
    pub(crate) executor: &'e dyn Executor,
}

/// Before the early sweep; after it is 1.
const EARLY: usize = 0;

/// The world of one rank.
pub(crate) struct Local {
    world: OwnedWorld<u32>,
    config: Config,
    pub(crate) table: Table,
    /// Who has left before the early sweep and after it.
    gone: [Gone; 2],
    /// What the early sweep has found and lost.
    found: Vec<[u32; 2]>,
    lost: Vec<[u32; 2]>,
    /// There has been an early sweep in this step.
    swept: bool,
    /// The table has more than the world could take: the world is made anew at the end of the step.
    outgrown: bool,
}

impl Local {
    /// An empty world with room for so much at first.
    pub(crate) fn new(config: Config) -> Result<Self, Error> {
        let config = config.with_events();
        Ok(Self {
            world: OwnedWorld::new(&config)?,
            config,
            table: Table::default(),
            gone: Default::default(),
            found: Vec::new(),
            lost: Vec::new(),
            swept: false,
            outgrown: false,
        })
    }

    /// Adds an object.
    pub(crate) fn insert(&mut self, object: &Object, owned: bool) {
        let slot = if self.outgrown { None } else { self.world.world().insert(object.now).ok() };
        // Any slot will do where the world is made anew.
        self.outgrown |= slot.is_none();
        let slot = slot.map_or(self.table.slots() as u32, |id| id.slot());
        self.table.put(slot, object, owned);
    }

    /// Removes an object. Its box of now stays known until the end of the step.
    pub(crate) fn remove(&mut self, slot: u32) {
        let object = self.table.take(slot);
        self.gone[usize::from(self.swept)].insert(slot, object);
        let mut world = self.world.world();
        // An outgrown world does not have all objects.
        if !self.outgrown
            && let Some(id) = world.id_at(slot)
        {
            self.outgrown = world.remove(id).is_err();
        }
    }

    /// Whether there can be a sweep before the ghosts come.
    pub(crate) fn can_sweep_early(&self) -> bool {
        !self.outgrown
    }

    /// Sweeps the rank's own boxes and the ghosts as they were. From now on changes come from other ranks.
    pub(crate) fn sweep_early(&mut self, means: Means<'_>) {
        self.swept = self.sweep(means).is_ok();
        self.outgrown = !self.swept;
        if self.swept {
            let world = self.world.world();
            self.found.clear();
            self.found.extend_from_slice(world.found());
            self.lost.clear();
            self.lost.extend_from_slice(world.lost());
        }
    }

    /// Sweeps all boxes as they are now.
    pub(crate) fn sweep_last(&mut self, means: Means<'_>) -> Result<(), Error> {
        if self.outgrown || self.sweep(means).is_err() {
            self.make_anew(means)?;
        }
        Ok(())
    }

    fn sweep(&mut self, means: Means<'_>) -> Result<(), Error> {
        let mut world = self.world.world();
        world.set_kernels(means.kernels).on(means.executor).step_over(Boxes::new(&self.table.now))?;
        Ok(())
    }

    /// Makes the world anew with more room: first as it was in the last step, so that the pairs of then can be lost, and then
    /// as it is now. All slots change.
    fn make_anew(&mut self, means: Means<'_>) -> Result<(), Error> {
        let gone: Vec<_> =
            self.gone.iter_mut().flat_map(|gone| gone.drain().map(|(_, object)| object)).collect();
        let living: Vec<_> =
            self.table.living_slots().map(|slot| (self.table.get(slot), self.table.is_owned(slot))).collect();
        self.swept = false;
        self.outgrown = false;
        let needed = (gone.len() + living.len()) as u32;
        let mut capacity = self.config.capacity;
        if capacity.objects < needed {
            let objects = needed.saturating_add(needed / 4).saturating_add(16);
            let usual = Capacity::for_objects(objects);
            capacity = usual.with_pairs(capacity.pairs.max(usual.pairs));
        }
        loop {
            self.config.capacity = capacity;
            match self.fill(&gone, &living, means) {
                Err(Error::PairsFull { needed, room }) => {
                    let needed = u32::try_from(needed).map_err(|_| Error::PairsFull { needed, room })?;
                    capacity.pairs = needed.saturating_add(needed / 4);
                }
                result => return result,
            }
        }
    }

    /// Fills a new world with the objects of the last step, and takes it to this step.
    fn fill(&mut self, gone: &[Object], living: &[(Object, bool)], means: Means<'_>) -> Result<(), Error> {
        // Two large worlds at a time might not fit.
        self.world = OwnedWorld::new(&self.config.with_capacity(Capacity::for_objects(0)))?;
        self.world = OwnedWorld::new(&self.config)?;
        self.gone = Default::default();
        self.table = Table::default();
        let mut world = self.world.world();
        for object in gone.iter().filter(|object| object.before != NOWHERE) {
            let slot = world.insert(object.before)?.slot();
            self.gone[EARLY].insert(slot, *object);
            self.table.vacate(slot);
        }
        for (object, owned) in living.iter().filter(|(object, _)| object.before != NOWHERE) {
            let slot = world.insert(object.before)?.slot();
            self.table.put(slot, object, *owned);
        }
        world.set_kernels(means.kernels).on(means.executor).step()?;
        for slot in self.gone[EARLY].keys() {
            if let Some(id) = world.id_at(*slot) {
                world.remove(id)?;
            }
        }
        for (object, owned) in living.iter().filter(|(object, _)| object.before == NOWHERE) {
            let slot = world.insert(object.now)?.slot();
            self.table.put(slot, object, *owned);
        }
        self.sweep(means)
    }

    /// Writes the pairs that this rank has found and lost in this step, and goes on to the next one. A pair belongs to the rank
    /// whose cell holds its corner: now for what is found, in the last step for what is lost.
    pub(crate) fn conclude(
        &mut self,
        now: &Cell,
        before: &Cell,
        found: &mut Vec<KeyPair>,
        lost: &mut Vec<KeyPair>,
    ) {
        let world = self.world.world();
        let deciding = Deciding { table: &self.table, gone: &self.gone, now, before };
        found.clear();
        lost.clear();
        if self.swept {
            let found_of = |pair: &[u32; 2], when| deciding.found_of_two(*pair, when);
            let lost_of = |pair: &[u32; 2], when| deciding.lost_of_two(*pair, when);
            found.extend(self.found.iter().filter_map(|pair| found_of(pair, When::EarlySweep)));
            found.extend(world.found().iter().filter_map(|pair| found_of(pair, When::Now)));
            lost.extend(self.lost.iter().filter_map(|pair| lost_of(pair, When::Start)));
            lost.extend(world.lost().iter().filter_map(|pair| lost_of(pair, When::EarlySweep)));
        } else {
            found.extend(world.found().iter().filter_map(|pair| deciding.found(*pair)));
            lost.extend(world.lost().iter().filter_map(|pair| deciding.lost(*pair)));
        }
        self.table.conclude();
        self.gone.iter_mut().for_each(KeyMap::clear);
        self.swept = false;
    }

    /// Visits the pairs of this rank.
    pub(crate) fn visit_pairs(&mut self, cell: &Cell, mut visit: impl FnMut(KeyPair)) {
        for [a, b] in self.world.world().pairs() {
            // See `Deciding` for why one owned object is enough.
            let one_owned = self.table.is_owned(*a) || self.table.is_owned(*b);
            let (a, b) = (*a as usize, *b as usize);
            if one_owned || cell.holds(corner(&self.table.now[a], &self.table.now[b])) {
                visit(ordered([self.table.key(a as u32), self.table.key(b as u32)]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trisap::{Aabb, Serial};

    fn means() -> Means<'static> {
        Means { kernels: trisap::Kernels::detect(), executor: &Serial }
    }

    fn cube(x: f32) -> Aabb {
        Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])
    }

    fn object(key: u64, now: f32, before: Option<f32>) -> Object {
        Object { key, now: cube(now), before: before.map_or(NOWHERE, cube) }
    }

    fn events(local: &mut Local) -> (Vec<KeyPair>, Vec<KeyPair>) {
        let (mut found, mut lost) = Default::default();
        local.conclude(&Cell::ALL, &Cell::ALL, &mut found, &mut lost);
        (found, lost)
    }

    fn local(objects: u32, pairs: u32) -> Local {
        Local::new(Config::new(Capacity::for_objects(objects).with_leaf_refs(0).with_pairs(pairs)))
            .expect("small")
    }

    #[test]
    fn who_comes_with_a_pair_has_not_found_it() {
        let mut local = local(8, 8);
        local.insert(&object(7, 0.0, Some(0.0)), true);
        local.insert(&object(3, 0.5, Some(0.6)), false);
        local.insert(&object(5, 0.7, Some(9.0)), false);
        local.sweep_last(means()).expect("room");
        let (mut found, lost) = events(&mut local);
        found.sort_unstable();
        assert_eq!((found, lost), (vec![[3, 5], [5, 7]], vec![]));
    }

    #[test]
    fn who_leaves_with_a_pair_has_not_lost_it() {
        let mut local = local(8, 8);
        for (key, x) in [(1, 0.0), (2, 0.5), (3, 0.7)] {
            local.insert(&object(key, x, None), true);
        }
        local.sweep_last(means()).expect("room");
        events(&mut local);
        // All leave, the first one for nowhere, and others come into their slots between and after two sweeps.
        let slot = local.table.slot_of(1).expect("lives");
        local.table.set(slot, NOWHERE);
        local.remove(slot);
        local.insert(&object(4, 0.6, None), true);
        local.sweep_early(means());
        for key in [2, 3] {
            let slot = local.table.slot_of(key).expect("lives");
            local.remove(slot);
        }
        local.insert(&object(5, 0.6, None), true);
        local.sweep_last(means()).expect("room");
        let (mut found, mut lost) = events(&mut local);
        found.sort_unstable();
        lost.sort_unstable();
        // Pairs of 4 with 2 and 3 are found where both overlap now: their corner's rank decides.
        assert_eq!(found, [[2, 4], [3, 4], [4, 5]]);
        assert_eq!(lost, [[1, 2], [1, 3]]);
    }

    #[test]
    fn a_world_that_is_made_anew_says_the_same() {
        let mut small = local(1, 1);
        let mut large = local(100, 1000);
        for time in 0..12 {
            for key in 0..(3 * time).min(20) {
                let x = ((key * 7 + time * 3) % 11) as f32 * 0.4;
                for local in [&mut small, &mut large] {
                    match local.table.slot_of(key) {
                        Some(slot) if (key + time) % 5 == 0 => {
                            local.table.set(slot, NOWHERE);
                            local.remove(slot);
                        }
                        Some(slot) => local.table.set(slot, cube(x)),
                        None => local.insert(&object(key, x, None), true),
                    }
                }
            }
            let [mut a, mut b] = [&mut small, &mut large].map(|local| {
                local.sweep_last(means()).expect("memory");
                events(local)
            });
            for list in [&mut a.0, &mut a.1, &mut b.0, &mut b.1] {
                list.sort_unstable();
            }
            assert_eq!(a, b, "step {time}");
        }
    }
}
