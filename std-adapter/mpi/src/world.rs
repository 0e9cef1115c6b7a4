//! The world of all ranks.

use crate::balance::Balance;
use crate::exchange::{Exchange, Letter, Progress};
use crate::fault::Fault;
use crate::links::Links;
use crate::local::{Local, Means};
use crate::message::{Batch, NOWHERE, Newcomer};
use crate::overlap::Overlap;
use crate::route::{Fate, Route};
use crate::settings::Settings;
use crate::split::Split;
use crate::stats::{Clock, Stage, Stats};
use crate::table::{KeyMap, KeyPair, Object};
use mpi::topology::SimpleCommunicator;
use trisap::{Aabb, Executor, Kernels};

/// One rank's part of a world that many ranks share.
///
/// All ranks make it, and all ranks step it, as often as each other. Objects have keys of 64 bits that the callers choose; no two
/// objects may have the same. A rank may be given any object; from the next step on it belongs to the rank whose cell holds its
/// minimum corner, and that rank gives it its boxes. [`arrivals`](Self::arrivals) and [`departures`](Self::departures) tell the
/// callers which of their own data has to travel too.
pub struct SplitWorld {
    pub(crate) exchange: Exchange,
    pub(crate) settings: Settings,
    pub(crate) local: Local,
    split: Split,
    balance: Balance,
    overlap: Overlap,
    links: Links,
    pub(crate) step: u64,
    /// Objects that have been given since the last step.
    pub(crate) given: Vec<Object>,
    pub(crate) given_keys: KeyMap<u64, usize>,
    /// Objects that have been removed since the last step.
    pub(crate) removed: Vec<Object>,
    found: Vec<KeyPair>,
    lost: Vec<KeyPair>,
    arrivals: Vec<u64>,
    departures: Vec<(u64, usize)>,
    stats: Stats,
}

/// Making and asking.
impl SplitWorld {
    /// An empty world of all ranks of a communicator. All of them have to call it.
    ///
    /// # Errors
    /// [`Fault::Version`], or [`Fault::World`] where the settings are not good.
    pub fn new(comm: &SimpleCommunicator, settings: &Settings) -> Result<Self, Fault> {
        let exchange = Exchange::new(comm, settings.timeout);
        let version = u64::from(settings.version);
        let ends = exchange.highest(&[version, u64::MAX - version]);
        let (lowest, highest) = ((u64::MAX - ends[1]) as u32, ends[0] as u32);
        if lowest != highest {
            return Err(Fault::Version { lowest, highest });
        }
        let split = Split::first_has_all(exchange.ranks());
        let links = Links::new(&split, exchange.rank());
        Ok(Self {
            local: Local::new(settings.config)?,
            balance: Balance::new(settings.balance),
            overlap: Overlap::new(settings.overlap),
            settings: *settings,
            exchange,
            split,
            links,
            step: 0,
            given: Vec::new(),
            given_keys: KeyMap::default(),
            removed: Vec::new(),
            found: Vec::new(),
            lost: Vec::new(),
            arrivals: Vec::new(),
            departures: Vec::new(),
            stats: Stats::default(),
        })
    }

    /// This rank.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.exchange.rank()
    }

    /// How many ranks there are.
    #[must_use]
    pub fn ranks(&self) -> usize {
        self.exchange.ranks()
    }

    /// Whether this rank owns an object.
    #[must_use]
    pub fn owns(&self, key: u64) -> bool {
        self.local.table.slot_of(key).is_some_and(|slot| self.local.table.is_owned(slot))
    }

    /// The box of an object that this rank owns or knows as a ghost, as it was given last.
    #[must_use]
    pub fn aabb(&self, key: u64) -> Option<Aabb> {
        self.local.table.slot_of(key).map(|slot| self.local.table.get(slot).now)
    }

    /// The keys and boxes of the objects that this rank owns.
    pub fn owned(&self) -> impl Iterator<Item = (u64, Aabb)> {
        let table = &self.local.table;
        table.owned_slots().map(|slot| (table.key(slot), table.now[slot as usize]))
    }

    /// The rank whose cell holds a point.
    #[must_use]
    pub fn rank_of(&self, point: [f32; 3]) -> usize {
        self.split.rank_of(point)
    }

    /// Objects that this rank owns since the last step and another rank owned before, or was given.
    #[must_use]
    pub fn arrivals(&self) -> &[u64] {
        &self.arrivals
    }

    /// Objects that this rank owned, and the ranks that own them since the last step.
    #[must_use]
    pub fn departures(&self) -> &[(u64, usize)] {
        &self.departures
    }

    /// The pairs of this rank that are there since the last step, the lower key first, in any order. Pairs that another rank had
    /// are not among them. All ranks together have exactly those of one world.
    #[must_use]
    pub fn found(&self) -> &[KeyPair] {
        &self.found
    }

    /// The pairs that this rank had in the step before and that are there no longer. Pairs that another rank has now are not
    /// among them.
    #[must_use]
    pub fn lost(&self) -> &[KeyPair] {
        &self.lost
    }

    /// Visits the pairs of this rank, the lower key first, in any order. O(pairs).
    pub fn visit_pairs(&mut self, visit: impl FnMut(KeyPair)) {
        let cell = self.split.cell(self.rank());
        self.local.visit_pairs(&cell, visit);
    }

    /// What the last step has done on this rank.
    #[must_use]
    pub fn stats(&self) -> &Stats {
        &self.stats
    }
}

/// A step.
impl SplitWorld {
    /// Finds all pairs of the boxes of all ranks as they are now. All ranks have to call it.
    ///
    /// A rank that dies, that does not answer within [the time](Settings::timeout), or that sends what makes no sense ends all
    /// ranks with a message.
    ///
    /// # Errors
    /// None that a rank gets alone: where its world cannot be made larger, all ranks end too.
    pub fn step(&mut self, kernels: Kernels, executor: &dyn Executor) -> Result<(), Fault> {
        let means = Means { kernels, executor };
        let mut clock = Clock::start();
        self.step += 1;
        self.stats = Stats::default();
        let collectives = self.exchange.collectives();
        let new_split = self.next_split();
        let old_split = self.split.clone();
        if let Some(split) = new_split {
            self.links = Links::new(&split, self.rank());
            self.split = split;
            self.stats.planes_moved = true;
        }
        clock.end(Stage::Balance, &mut self.stats);

        let own = self.local.table.owned() as u64;
        let total = own + self.given.len() as u64;
        let now = self.split.clone();
        let mut route = Route::new(self.rank(), &old_split, &now);
        let fates = self.route(&mut route);
        let early = self.sweeps_early();
        let (linked, far) = self.letters(&mut route.batches);
        clock.end(Stage::Route, &mut self.stats);

        let (local, stats) = (&mut self.local, &mut self.stats);
        let progress = Progress { executor, exchange: &self.exchange };
        let work = || {
            if early {
                local.sweep_early(Means { executor: &progress, ..means });
                stats.overlapped = true;
            }
            clock.end(Stage::EarlySweep, stats);
        };
        let (letters, census) = self.exchange.step(self.step, &linked, &far, [total, own], work);
        clock.end(Stage::Exchange, &mut self.stats);

        self.apply(fates, &letters);
        self.links.conclude();
        clock.end(Stage::Apply, &mut self.stats);
        if let Err(error) = self.local.sweep_last(means) {
            self.exchange.end_all(&error.to_string());
        }
        clock.end(Stage::LastSweep, &mut self.stats);
        self.local.conclude(&route.cell_now, &route.cell_before, &mut self.found, &mut self.lost);
        self.balance.note(&census, self.ranks());
        self.stats.total = census.objects;
        self.stats.most = census.most;
        self.stats.far = census.far;
        self.stats.objects = self.local.table.owned() as u64;
        self.stats.ghosts = (self.local.table.len() - self.local.table.owned()) as u64;
        self.stats.arrived = self.arrivals.len() as u64;
        self.stats.departed = self.departures.len() as u64;
        self.stats.collectives = self.exchange.collectives() - collectives;
        clock.end(Stage::Events, &mut self.stats);
        self.overlap.note(&self.stats);
        Ok(())
    }

    fn next_split(&mut self) -> Option<Split> {
        let (table, given) = (&self.local.table, &self.given);
        let points = || {
            let owned = table.owned_slots().map(|slot| table.now[slot as usize].min);
            owned.chain(given.iter().map(|object| object.now.min)).collect()
        };
        self.balance.split(self.step, &self.split, &self.exchange, points)
    }

    /// Tells other ranks what they have to know. What becomes of the objects here is for later: the early sweep has them.
    fn route(&mut self, route: &mut Route<'_>) -> Fates {
        let mut fates = Fates::default();
        self.arrivals.clear();
        self.departures.clear();
        for object in self.removed.drain(..) {
            // Where it was is what counts.
            route.tell(&object);
        }
        let table = &self.local.table;
        let mut tell = |slot: u32| {
            let object = table.get(slot);
            match route.tell(&object) {
                Fate::Stays => {}
                fate => fates.moved.push((slot, object.key, fate)),
            }
        };
        if self.stats.planes_moved {
            table.owned_slots().for_each(&mut tell);
        } else {
            // A slot may have got another object since it was noted.
            table.changed().iter().copied().filter(|&slot| table.is_owned(slot)).for_each(&mut tell);
        }
        for (_, key, fate) in &fates.moved {
            if let Fate::Ghost(owner) | Fate::Leaves(owner) = fate {
                self.departures.push((*key, *owner));
            }
        }
        self.given_keys.clear();
        for object in self.given.drain(..) {
            match route.tell_of_new(&object) {
                Fate::Stays => {
                    self.arrivals.push(object.key);
                    fates.given.push((object, true));
                }
                Fate::Ghost(_) => fates.given.push((object, false)),
                Fate::Leaves(_) => {}
            }
        }
        fates
    }

    fn sweeps_early(&self) -> bool {
        let objects = self.local.table.len();
        let can = self.ranks() > 1 && self.local.can_sweep_early();
        can && self.overlap.sweeps_early(objects, self.stats.planes_moved)
    }

    /// The messages of this step: one for each linked rank, and those to other ranks.
    fn letters(&mut self, batches: &mut [Batch]) -> (Vec<Letter>, Vec<Letter>) {
        let (mut linked, mut far) = (Vec::new(), Vec::new());
        for (rank, batch) in batches.iter_mut().enumerate() {
            let is_linked = self.links.contains(rank);
            if is_linked || batch.needed() > 0 {
                let batch = std::mem::take(batch);
                self.links.told(rank, batch.needed() > 0);
                let bytes = batch.encode(self.settings.version, self.step);
                self.stats.bytes += bytes.len() as u64;
                self.stats.told += batch.objects();
                self.stats.bytes_needed += batch.needed();
                self.stats.messages += 1;
                if is_linked { &mut linked } else { &mut far }.push((rank, bytes));
            }
        }
        (linked, far)
    }

    /// Does what this rank and others have decided.
    fn apply(&mut self, fates: Fates, letters: &[Letter]) {
        let mut batches = Vec::with_capacity(letters.len());
        for (from, bytes) in letters {
            match Batch::decode(bytes, self.settings.version, self.step) {
                Ok(batch) => {
                    self.links.told(*from, batch.needed() > 0);
                    batches.push(batch);
                }
                Err(why) => self.exchange.end_all(&format!("{why} (from rank {from})")),
            }
        }
        // Who leaves does so first, since a key may be used again.
        for (slot, _, fate) in fates.moved {
            match fate {
                Fate::Stays => {}
                Fate::Ghost(_) => self.local.table.set_owned(slot, false),
                Fate::Leaves(_) => self.local.remove(slot),
            }
        }
        for change in batches.iter().flat_map(|batch| &batch.left) {
            let slot = self.ghost(change.key);
            self.local.table.set(slot, change.now);
            self.local.remove(slot);
        }
        for change in batches.iter().flat_map(|batch| &batch.moved) {
            let slot = self.ghost(change.key);
            self.local.table.set(slot, change.now);
        }
        for (object, owned) in fates.given {
            self.enter(&object, owned);
        }
        for batch in &batches {
            for newcomer in &batch.entered {
                self.enter(&Object { key: newcomer.key, now: newcomer.now, before: newcomer.before }, false);
            }
            for newcomer in &batch.owned {
                self.arrivals.push(newcomer.key);
                match self.local.table.slot_of(newcomer.key) {
                    Some(slot) if !self.local.table.is_owned(slot) && newcomer.before != NOWHERE => {
                        self.local.table.set(slot, newcomer.now);
                        self.local.table.set_owned(slot, true);
                    }
                    _ => {
                        let Newcomer { key, now, before } = *newcomer;
                        self.enter(&Object { key, now, before }, true);
                    }
                }
            }
        }
    }

    /// The slot of an object of another rank.
    fn ghost(&self, key: u64) -> u32 {
        match self.local.table.slot_of(key) {
            Some(slot) if !self.local.table.is_owned(slot) => slot,
            _ => self.exchange.end_all(&format!("another rank tells of {key}, which is no ghost here")),
        }
    }

    fn enter(&mut self, object: &Object, owned: bool) {
        if self.local.table.slot_of(object.key).is_some() {
            self.exchange.end_all(&format!("two objects have the key {}", object.key));
        }
        self.local.insert(object, owned);
    }
}

/// What becomes of objects on this rank after the early sweep.
#[derive(Default)]
struct Fates {
    /// Objects that it owned, with their slots.
    moved: Vec<(u32, u64, Fate)>,
    /// Objects that it was given and that reach its cell, and whether it owns them.
    given: Vec<(Object, bool)>,
}
