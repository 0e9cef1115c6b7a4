//! A world that is keyed by the caller's own type, and grows by itself.

mod among;
mod bytes;
mod contacts;
mod error;
mod names;
mod room;
mod step;

pub use among::AmongKeys;
pub use error::KeyedError;
pub use room::Snapshot;
pub use step::{KeyedRule, KeyedStep, KeyedStepper};

use crate::OwnedWorld;
use contacts::Numbers;
use core::hash::Hash;
use names::Names;
use trisap_core::{Aabb, Capacity, Config, Error, Filter, Id, Object, World};

/// Boxes by key, and which of them overlap: a [`World`] that counts its memory itself.
///
/// Keys are your own: an entity of an ECS, a number, a name. Each names one box. When objects or pairs no longer fit,
/// the world moves into more memory, twice as much for objects, and goes on with all its events. So no step is lost,
/// and no error says that something is full. [`shrink_to_fit`](Self::shrink_to_fit) gives memory back. The world stays open, so a box
/// of a known key takes some ten nanoseconds, less if keys come in the order in which they were inserted.
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
#[doc(alias("bvh", "dynamic_tree", "space"))]
pub struct BroadPhase<K> {
    owned: OwnedWorld<u32>,
    config: Config,
    names: Names<K>,
    numbers: Option<Numbers>,
    /// The last step has found all pairs.
    complete: bool,
    #[cfg(feature = "rayon")]
    executor: crate::Rayon<'static>,
}

/// A copy goes on as the broad phase would have, byte for byte: the way to go back to a frame is to keep copies.
/// [`clone_from`](Clone::clone_from) uses the memory that there is.
///
/// # Panics
/// If there is no memory for a copy.
impl<K: Copy + Eq + Hash> Clone for BroadPhase<K> {
    fn clone(&self) -> Self {
        Self {
            owned: self.owned.clone(),
            config: self.config,
            names: self.names.clone(),
            numbers: self.numbers.clone(),
            complete: self.complete,
            #[cfg(feature = "rayon")]
            executor: crate::Rayon::global(),
        }
    }

    fn clone_from(&mut self, source: &Self) {
        self.owned.clone_from(&source.owned);
        (self.config, self.complete) = (source.config, source.complete);
        self.names.copy_from(&source.names);
        self.numbers.clone_from(&source.numbers);
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

    /// An empty broad phase that begins with the capacity of a configuration. It tells found and lost pairs only
    /// [with events](Config::with_events), unlike that of [`new`](Self::new).
    ///
    /// # Errors
    /// [`Error::CapacityTooLarge`], [`Error::NoMemory`] or [`Error::BadMargin`].
    pub fn with_config(config: &Config) -> Result<Self, Error> {
        Ok(Self {
            owned: OwnedWorld::new(config)?,
            config: *config,
            names: Names::new(),
            numbers: None,
            complete: true,
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
        self.names.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether there is a box for a key.
    #[must_use]
    pub fn contains(&self, key: &K) -> bool {
        self.id(key).is_some()
    }

    /// All keys, in the order of their slots: the same calls give the same order.
    pub fn keys(&self) -> impl Iterator<Item = K> {
        self.names.living().map(|named| named.key)
    }

    /// All keys and their boxes, in the same order.
    pub fn iter(&self) -> impl Iterator<Item = (K, Aabb)> {
        let world = self.as_world();
        self.names.living().filter_map(|named| Some((named.key, world.aabb(named.id)?)))
    }

    /// The id of a key in the [world](Self::as_world).
    #[must_use]
    pub fn id(&self, key: &K) -> Option<Id> {
        self.names.id(key)
    }

    /// The key of an id that lives, or was in one of the last two steps.
    #[must_use]
    pub fn key(&self, id: Id) -> Option<K> {
        self.names.named(id).map(|named| named.key)
    }

    /// The world, to look at it by ids and slots. [`key`](Self::key) gives the key of an id. Any number of threads may look at once.
    #[must_use]
    pub fn as_world(&self) -> &World<'_> {
        self.owned.as_world()
    }

    /// The world, to change what is not here: values, the origin. Do not remove or insert objects there: keys would be wrong.
    #[must_use]
    pub fn world(&mut self) -> World<'_> {
        self.owned.world()
    }

    /// The box of a key, as it was given last.
    #[must_use]
    pub fn aabb(&self, key: &K) -> Option<Aabb> {
        self.as_world().aabb(self.id(key)?)
    }

    /// Adds a box, or an [`Object`]: a box and what else it has. A key that has a box gets these instead, all or none.
    /// Boxes that come in an iterator come by [`extend`](Self::extend).
    ///
    /// # Errors
    /// Those of [`Object::check`], [`Error::BadBox`] for a box alone; or [`Error::NoMemory`].
    #[doc(alias("create_proxy", "add"))]
    pub fn insert(&mut self, key: K, object: impl Into<Object>) -> Result<(), KeyedError<K>> {
        let named = |error| KeyedError { key, error };
        let object = object.into();
        if let Some(id) = self.names.look_up(&key) {
            return self.owned.change(|world| world.set_object(id, object)).map_err(named);
        }
        let id = match self.owned.change(|world| world.insert(object)) {
            Err(Error::ObjectsFull { .. }) => {
                self.reserve(self.len().max(FIRST as usize)).map_err(named)?;
                self.owned.change(|world| world.insert(object))
            }
            said => said,
        };
        self.names.insert(key, id.map_err(named)?);
        Ok(())
    }

    /// Gives a key another box. False if it has none.
    ///
    /// # Errors
    /// [`Error::BadBox`].
    #[doc(alias("set_aabb", "move_proxy"))]
    pub fn update(&mut self, key: &K, aabb: Aabb) -> Result<bool, KeyedError<K>> {
        self.at(key, |world, id| world.set_aabb(id, aabb))
    }

    /// Gives keys other boxes, and tells how many of them have one. The fastest way for many.
    ///
    /// # Errors
    /// [`Error::BadBox`] of the first box that is refused. Its key keeps its box, all others have got theirs.
    pub fn update_many(
        &mut self,
        boxes: impl IntoIterator<Item = (K, Aabb)>,
    ) -> Result<usize, KeyedError<K>> {
        self.at_each(boxes, |world, id, aabb| world.set_aabb(id, aabb))
    }

    /// Removes a box. False if the key has none. Its pairs are lost at the next step.
    #[doc(alias("destroy_proxy", "delete"))]
    pub fn remove(&mut self, key: &K) -> bool {
        self.names.remove(key).is_some_and(|id| self.owned.change(|world| world.remove(id)).is_ok())
    }

    /// Removes all boxes. Their pairs are lost at the next step.
    pub fn clear(&mut self) {
        self.owned.change(|world| world.clear());
        self.names.clear();
    }

    /// Sets whom a key meets. False if it has no box.
    ///
    /// # Errors
    /// [`Error::NoFilters`] or [`Error::BadClass`].
    #[doc(alias("set_collision_groups", "collision_layers"))]
    pub fn set_filter(&mut self, key: &K, filter: Filter) -> Result<bool, KeyedError<K>> {
        self.at(key, |world, id| world.set_filter(id, filter))
    }

    /// Sets whom keys meet, and tells how many of them have a box.
    ///
    /// # Errors
    /// Those of [`set_filter`](Self::set_filter), of the first filter that is refused; all others are set.
    pub fn set_filter_many(
        &mut self,
        filters: impl IntoIterator<Item = (K, Filter)>,
    ) -> Result<usize, KeyedError<K>> {
        self.at_each(filters, |world, id, filter| world.set_filter(id, filter))
    }

    /// Sets which classes meet: see [`World::set_classes`].
    ///
    /// # Errors
    /// [`Error::NoFilters`].
    pub fn set_classes(&mut self, meets: &[u32; 32]) -> Result<(), Error> {
        self.owned.change(|world| world.set_classes(meets))
    }

    /// Asks about the pairs of a key again, after a [rule](Self::with_rule) has changed its answer. False if it has no box.
    ///
    /// # Errors
    /// [`Error::NoFilters`].
    pub fn refilter(&mut self, key: &K) -> Result<bool, KeyedError<K>> {
        self.at(key, |world, id| world.refilter(id))
    }

    /// Whether a key meets what has a filter, by groups and classes: for queries [among](Self::among) some. False where it has no box.
    #[must_use]
    pub fn meets(&self, key: &K, filter: &Filter) -> bool {
        self.id(key).is_some_and(|id| self.as_world().meets(id, filter))
    }

    /// How far a key may move before it counts as moved. `None` where it has no box, and without margins.
    #[must_use]
    pub fn margin(&self, key: &K) -> Option<f32> {
        self.as_world().margin(self.id(key)?)
    }

    /// Sets that, in place of the world's margin. False if the key has no box.
    ///
    /// # Errors
    /// [`Error::NoMargins`] or [`Error::BadMargin`].
    pub fn set_margin(&mut self, key: &K, length: f32) -> Result<bool, KeyedError<K>> {
        self.at(key, |world, id| world.set_margin(id, length))
    }

    /// Puts a key to rest, until it gets another box or is woken: steps set aside its pairs with others that rest. False where it
    /// has no box. O(1).
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
    #[doc(alias("sleep", "put_to_sleep"))]
    pub fn set_resting(&mut self, key: &K) -> bool {
        self.at(key, |world, id| world.set_resting(&[id])).is_ok_and(|is_there| is_there)
    }

    /// Wakes a key. False where it has no box. O(1).
    #[doc(alias = "wake_up")]
    pub fn wake(&mut self, key: &K) -> bool {
        self.at(key, |world, id| world.wake(&[id])).is_ok_and(|is_there| is_there)
    }

    /// Disables a key, or enables it again; see [`World::set_enabled`](crate::World::set_enabled). False where it has no box. O(1).
    pub fn set_enabled(&mut self, key: &K, enabled: bool) -> bool {
        self.at(key, |world, id| world.set_enabled(id, enabled)).is_ok_and(|is_there| is_there)
    }

    /// Whether a key has a box and is enabled. O(1).
    #[must_use]
    pub fn is_enabled(&self, key: &K) -> bool {
        self.id(key).is_some_and(|id| self.as_world().is_enabled(id))
    }

    /// Whether a key was put to rest and has not been woken since. O(1).
    #[doc(alias = "is_sleeping")]
    #[must_use]
    pub fn is_resting(&self, key: &K) -> bool {
        self.id(key).is_some_and(|id| self.as_world().is_resting(id))
    }

    /// How often steps were shared with other threads so far.
    #[cfg(feature = "rayon")]
    #[must_use]
    pub fn sharing(&self) -> crate::Sharing {
        self.executor.sharing()
    }

    /// Does something with the object of a key, if there is one.
    fn at(
        &mut self,
        key: &K,
        change: impl FnOnce(&mut World<'_>, Id) -> Result<(), Error>,
    ) -> Result<bool, KeyedError<K>> {
        let Some(id) = self.names.look_up(key) else { return Ok(false) };
        let changed = self.owned.change(|world| change(world, id));
        changed.map(|()| true).map_err(|error| KeyedError { key: *key, error })
    }

    /// Gives keys other boxes until one has none, or its box is refused.
    fn update_until_new(&mut self, boxes: &mut impl Iterator<Item = (K, Aabb)>) -> Option<(K, Aabb)> {
        let Self { owned, names, .. } = self;
        owned.change(|world| {
            boxes.find(|(key, aabb)| names.look_up(key).is_none_or(|id| world.set_aabb(id, *aabb).is_err()))
        })
    }

    /// Does something with the object of each key; how many there are, or the first refusal.
    fn at_each<T>(
        &mut self,
        of_keys: impl IntoIterator<Item = (K, T)>,
        change: impl Fn(&mut World<'_>, Id, T) -> Result<(), Error>,
    ) -> Result<usize, KeyedError<K>> {
        let Self { owned, names, .. } = self;
        let mut refused = None;
        let changed = owned.change(|world| {
            let mut changed = 0;
            for (key, with) in of_keys {
                let Some(id) = names.look_up(&key) else { continue };
                match change(world, id, with) {
                    Ok(()) => changed += 1,
                    Err(error) => drop(refused.get_or_insert(KeyedError { key, error })),
                }
            }
            changed
        });
        refused.map_or(Ok(changed), Err)
    }
}

/// Inserts boxes, or moves those of known keys.
///
/// # Panics
/// If a box is refused, or memory cannot be had, with the key. What came before it is there.
impl<K: Copy + Eq + Hash + core::fmt::Debug> Extend<(K, Aabb)> for BroadPhase<K> {
    fn extend<T: IntoIterator<Item = (K, Aabb)>>(&mut self, boxes: T) {
        let mut boxes = boxes.into_iter();
        if self.is_empty() {
            // Later on they may be known.
            let count = boxes.size_hint().0;
            self.reserve(count).unwrap_or_else(|error| panic!("no room for {count} boxes: {error}"));
        }
        // Known keys in one go, as long as none is new.
        while let Some((key, aabb)) = self.update_until_new(&mut boxes) {
            self.insert(key, aabb).unwrap_or_else(|refused| panic!("{refused}"));
        }
    }
}

/// A broad phase as by [`BroadPhase::new`], with these boxes.
///
/// # Panics
/// As by [`BroadPhase::extend`].
impl<K: Copy + Eq + Hash + core::fmt::Debug> FromIterator<(K, Aabb)> for BroadPhase<K> {
    fn from_iter<T: IntoIterator<Item = (K, Aabb)>>(boxes: T) -> Self {
        let mut broad_phase = Self::new();
        broad_phase.extend(boxes);
        broad_phase
    }
}

impl<K> core::fmt::Debug for BroadPhase<K> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("BroadPhase").field("config", &self.config).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
