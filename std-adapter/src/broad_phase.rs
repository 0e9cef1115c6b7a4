//! A world that is keyed by the caller's own type, and grows by itself.

mod among;
mod view;

pub use among::AmongKeys;
pub use view::KeyedStep;

use crate::OwnedWorld;
use core::hash::Hash;
use std::collections::HashMap;
use trisap_core::{Aabb, Capacity, Config, Error, Field, Filter, Id, World};

/// Boxes by key, and which of them overlap: a [`World`] that counts its memory itself.
///
/// Keys are your own: an entity of an ECS, a number, a name. Each names one box. When objects or pairs no longer fit,
/// the world moves into more memory, twice as much for objects, and goes on with all its events. So no step is lost,
/// and no error says that something is full. Memory is never given back.
///
/// With the feature `rayon`, steps run on rayon's global pool if [`Config::with_workers`] allows more than one worker.
///
/// ```
/// use trisap::{Aabb, BroadPhase};
///
/// let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let mut broad_phase = BroadPhase::new();
/// broad_phase.insert("floor", Aabb::new([-9.0, -9.0, -1.0], [9.0, 9.0, 0.0]))?;
/// broad_phase.insert("ball", cube(0.0))?;
/// let step = broad_phase.step()?;
/// assert_eq!(step.found().collect::<Vec<_>>(), [["floor", "ball"]]);
///
/// broad_phase.remove(&"ball");
/// broad_phase.insert("crate", cube(20.0))?;
/// let step = broad_phase.step()?;
/// assert_eq!(step.lost().collect::<Vec<_>>(), [["floor", "ball"]]);
/// # Ok::<(), trisap::Error>(())
/// ```
pub struct BroadPhase<K> {
    owned: OwnedWorld<u32>,
    config: Config,
    ids: HashMap<K, Id>,
    names: Names<K>,
    #[cfg(feature = "rayon")]
    executor: crate::Rayon<'static>,
}

/// Which key an id has, or had.
#[derive(Clone, Debug)]
struct Names<K> {
    /// By slot.
    living: Vec<Option<(Id, K)>>,
    /// Keys of objects that were removed since the last step, and between that one and the step before.
    removed: HashMap<Id, K>,
    removed_before: HashMap<Id, K>,
}

/// A broad phase as it was: see [`BroadPhase::save`].
#[derive(Clone, Debug)]
pub struct Snapshot<K> {
    bytes: Vec<u8>,
    capacity: Capacity,
    names: Names<K>,
}

impl<K: Copy + Eq> Names<K> {
    fn key(&self, id: Id) -> Option<K> {
        match self.living.get(id.slot() as usize) {
            Some(Some((living, key))) if *living == id => Some(*key),
            _ => self.removed_before.get(&id).or_else(|| self.removed.get(&id)).copied(),
        }
    }
}

/// Room for so many objects at first.
const FIRST: u32 = 64;

impl<K: Copy + Eq + Hash> Default for BroadPhase<K> {
    fn default() -> Self {
        Self::new()
    }
}

impl<K: Copy + Eq + Hash> BroadPhase<K> {
    /// An empty broad phase with exact pairs and events. It grows from room for 64 objects.
    ///
    /// # Panics
    /// If a few kilobytes cannot be allocated.
    #[must_use]
    pub fn new() -> Self {
        let config = Config::new(Capacity::for_objects(FIRST)).with_events();
        Self::with_config(&config).expect("a small world")
    }

    /// An empty broad phase that begins with the capacity of a configuration.
    ///
    /// # Errors
    /// [`Error::CapacityTooLarge`], [`Error::NoMemory`] or [`Error::BadMargin`].
    pub fn with_config(config: &Config) -> Result<Self, Error> {
        Ok(Self {
            owned: OwnedWorld::new(config)?,
            config: *config,
            ids: HashMap::new(),
            names: Names { living: Vec::new(), removed: HashMap::new(), removed_before: HashMap::new() },
            #[cfg(feature = "rayon")]
            executor: crate::Rayon::global(),
        })
    }

    /// What the world is made for at the moment.
    #[must_use]
    pub fn config(&self) -> Config {
        self.config
    }

    /// How many boxes there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// Whether there is a box for a key.
    #[must_use]
    pub fn contains(&self, key: &K) -> bool {
        self.ids.contains_key(key)
    }

    /// All keys, in no order.
    pub fn keys(&self) -> impl Iterator<Item = K> {
        self.ids.keys().copied()
    }

    /// The id of a key in the [world](Self::world).
    #[must_use]
    pub fn id(&self, key: &K) -> Option<Id> {
        self.ids.get(key).copied()
    }

    /// The key of an id that the world knows, or knew in the step before.
    #[must_use]
    pub fn key(&self, id: Id) -> Option<K> {
        self.names.key(id)
    }

    /// The world, to look at: results, batches, and visitors of queries. [`key`](Self::key) gives the key of an id. Any
    /// number of threads may look at once.
    #[must_use]
    pub fn as_world(&self) -> &World<'_> {
        self.owned.as_world()
    }

    /// The world, to change what is not here: margins, classes, values. Do not remove or insert objects there: keys
    /// would be wrong.
    #[must_use]
    pub fn world(&mut self) -> World<'_> {
        self.owned.world()
    }

    /// The box of a key, as it was given last.
    #[must_use]
    pub fn aabb(&self, key: &K) -> Option<Aabb> {
        self.as_world().aabb(self.id(key)?)
    }

    /// Adds a box, or gives the key another one if it has one.
    ///
    /// # Errors
    /// [`Error::BadBox`], or [`Error::NoMemory`].
    pub fn insert(&mut self, key: K, aabb: Aabb) -> Result<(), Error> {
        if self.update(&key, aabb)? {
            return Ok(());
        }
        let id = match self.owned.world().insert(aabb) {
            Err(Error::ObjectsFull { .. }) => {
                let Capacity { objects, pairs, .. } = self.config.capacity;
                let more = Capacity::for_objects(objects.saturating_mul(2).max(FIRST));
                self.grow(more.with_pairs(more.pairs.max(pairs)))?;
                self.owned.world().insert(aabb)
            }
            said => said,
        }?;
        let slot = id.slot() as usize;
        if slot >= self.names.living.len() {
            self.names.living.resize(slot + 1, None);
        }
        self.names.living[slot] = Some((id, key));
        self.ids.insert(key, id);
        Ok(())
    }

    /// Gives a key another box. False if it has none.
    ///
    /// # Errors
    /// [`Error::BadBox`].
    pub fn update(&mut self, key: &K, aabb: Aabb) -> Result<bool, Error> {
        match self.id(key) {
            Some(id) => self.owned.world().set_aabb(id, aabb).map(|()| true),
            None => Ok(false),
        }
    }

    /// Removes a box. False if the key has none. Its pairs are lost at the next step.
    pub fn remove(&mut self, key: &K) -> bool {
        let Some(id) = self.ids.remove(key) else { return false };
        let removed = self.owned.world().remove(id).is_ok();
        self.names.living[id.slot() as usize] = None;
        self.names.removed.insert(id, *key);
        removed
    }

    /// Sets whom a key meets. False if it has no box.
    ///
    /// # Errors
    /// [`Error::NoFilters`] or [`Error::BadClass`].
    pub fn set_filter(&mut self, key: &K, filter: Filter) -> Result<bool, Error> {
        match self.id(key) {
            Some(id) => self.owned.world().set_filter(id, filter).map(|()| true),
            None => Ok(false),
        }
    }

    /// Whether a key meets what has a filter, by groups and classes: for queries [among](Self::among) some. False where it has no box.
    #[must_use]
    pub fn meets(&self, key: &K, filter: &Filter) -> bool {
        self.id(key).is_some_and(|id| self.as_world().meets(id, filter))
    }

    /// Puts a key to rest, until it gets another box or is woken: steps set aside its pairs with others that rest. False where it
    /// has no box.
    ///
    /// ```
    /// use trisap::{Aabb, BroadPhase};
    ///
    /// let mut broad_phase = BroadPhase::new();
    /// for (key, x) in [('a', 0.0), ('b', 0.5), ('c', 1.25)] {
    ///     broad_phase.insert(key, Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]))?;
    /// }
    /// assert!(broad_phase.set_resting(&'a') && broad_phase.set_resting(&'b'));
    /// let step = broad_phase.step()?;
    /// assert_eq!(step.pairs().count(), 2);
    /// assert_eq!(step.awake_pairs().collect::<Vec<_>>(), [['b', 'c']]); // whose contacts may have changed
    ///
    /// broad_phase.wake(&'a'); // so does a box of its own
    /// assert!(!broad_phase.is_resting(&'a'));
    /// # Ok::<(), trisap::Error>(())
    /// ```
    pub fn set_resting(&mut self, key: &K) -> bool {
        self.id(key).is_some_and(|id| self.owned.world().set_resting(&[id]).is_ok())
    }

    /// Wakes a key. False where it has no box.
    pub fn wake(&mut self, key: &K) -> bool {
        self.id(key).is_some_and(|id| self.owned.world().wake(&[id]).is_ok())
    }

    /// Whether a key was put to rest and has not been woken since.
    #[must_use]
    pub fn is_resting(&self, key: &K) -> bool {
        self.id(key).is_some_and(|id| self.as_world().is_resting(id))
    }

    /// Finds all overlapping pairs of the boxes as they are now, with as much memory as they take.
    ///
    /// # Errors
    /// [`Error::NoMemory`], [`Error::CapacityTooLarge`] of more than four billion pairs, or [`Error::InvariantBroken`].
    pub fn step(&mut self) -> Result<KeyedStep<'_, K>, Error> {
        while let Err(error) = self.try_step() {
            let Error::PairsFull { needed, .. } = error else { return Err(error) };
            // A quarter more, so that a growing scene does not move in each step.
            let too_many = Error::CapacityTooLarge { field: Field::Pairs, most: u64::from(u32::MAX) };
            let pairs = u32::try_from(needed + needed / 4).map_err(|_| too_many)?;
            self.grow(self.config.capacity.with_pairs(pairs))?;
        }
        self.names.removed_before = core::mem::take(&mut self.names.removed);
        Ok(KeyedStep { world: self.owned.world(), names: &self.names })
    }

    #[cfg(feature = "rayon")]
    fn try_step(&mut self) -> Result<(), Error> {
        let mut world = self.owned.world();
        if self.config.workers > 1 {
            world.on(&self.executor).step().map(|_| ())
        } else {
            world.step().map(|_| ())
        }
    }

    #[cfg(not(feature = "rayon"))]
    fn try_step(&mut self) -> Result<(), Error> {
        self.owned.world().step().map(|_| ())
    }

    fn grow(&mut self, capacity: Capacity) -> Result<(), Error> {
        let mut config = self.config.with_capacity(capacity);
        config.lean &= capacity.objects <= 256;
        self.owned.move_to(&config)?;
        self.config = config;
        Ok(())
    }

    /// Everything, to go back to later: boxes, keys, and what the next events are compared with.
    #[must_use]
    pub fn save(&self) -> Snapshot<K> {
        let world = self.as_world();
        let mut bytes = vec![0; world.snapshot_size()];
        // As long as the world has said.
        let written = world.save(&mut bytes);
        debug_assert_eq!(written, Ok(bytes.len()));
        Snapshot { bytes, capacity: self.config.capacity, names: self.names.clone() }
    }

    /// Goes back to a snapshot of this broad phase, or of another one of the same kind. It may have grown since: its room stays.
    ///
    /// # Errors
    /// [`Error::OtherConfig`], or [`Error::NoMemory`]; nothing has changed then.
    pub fn restore(&mut self, snapshot: &Snapshot<K>) -> Result<(), Error> {
        match self.owned.world().load(&snapshot.bytes) {
            Err(Error::NoRoom { .. }) => {
                let Capacity { objects, leaf_refs, pairs, .. } = self.config.capacity;
                let capacity = Capacity::for_objects(objects.max(snapshot.capacity.objects))
                    .with_leaf_refs(leaf_refs.max(snapshot.capacity.leaf_refs))
                    .with_pairs(pairs.max(snapshot.capacity.pairs));
                let mut config = self.config.with_capacity(capacity);
                config.lean = false;
                let mut owned = OwnedWorld::new(&config)?;
                owned.world().load(&snapshot.bytes)?;
                (self.owned, self.config) = (owned, config);
            }
            said => said?,
        }
        self.names = snapshot.names.clone();
        self.ids = self.names.living.iter().flatten().map(|(id, key)| (*key, *id)).collect();
        Ok(())
    }
}

impl<K> core::fmt::Debug for BroadPhase<K> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { config, ids, .. } = self;
        f.debug_struct("BroadPhase").field("len", &ids.len()).field("config", config).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
