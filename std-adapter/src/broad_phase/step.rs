//! Steps by key, and what they have found.

use super::BroadPhase;
use super::names::{Events, Names};
use crate::OwnedWorld;
use core::hash::Hash;
use core::ops::Deref;
use trisap_core::{Error, Executor, Field, Serial, Stats, World};

/// A rule of the caller: whether two keys, the one that was inserted first first, make a pair. See [`trisap_core::Rule`].
pub type KeyedRule<'r, K> = dyn Fn(K, K) -> bool + Sync + 'r;

/// The result of a step by key: [`pairs`](BroadPhase::pairs), [`found`](BroadPhase::found), [`lost`](BroadPhase::lost). It is a view
/// of the broad phase, so boxes, keys and queries can be asked while its pairs are walked over.
pub struct KeyedStep<'b, K> {
    broad_phase: &'b BroadPhase<K>,
}

impl<'b, K: Copy + Eq + Hash> KeyedStep<'b, K> {
    /// The world after the step, to look at it by ids and slots.
    #[must_use]
    pub fn world(&self) -> &'b World<'b> {
        self.broad_phase.as_world()
    }
}

impl<K> Deref for KeyedStep<'_, K> {
    type Target = BroadPhase<K>;

    fn deref(&self) -> &BroadPhase<K> {
        self.broad_phase
    }
}

impl<K: Copy + Eq + Hash> core::fmt::Debug for KeyedStep<'_, K> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("KeyedStep").field("stats", &self.stats()).finish_non_exhaustive()
    }
}

/// A step on workers or with a rule: made by [`BroadPhase::on`] and [`BroadPhase::with_rule`].
#[must_use = "does nothing until `step`"]
pub struct KeyedStepper<'b, K> {
    broad_phase: &'b mut BroadPhase<K>,
    executor: Option<&'b dyn Executor>,
    rule: Option<&'b KeyedRule<'b, K>>,
}

impl<'b, K: Copy + Eq + Hash + Sync> KeyedStepper<'b, K> {
    /// The same on the workers of a job system.
    pub fn on(self, executor: &'b dyn Executor) -> Self {
        Self { executor: Some(executor), ..self }
    }

    /// The same with a rule.
    pub fn with_rule(self, rule: &'b KeyedRule<'b, K>) -> Self {
        Self { rule: Some(rule), ..self }
    }

    /// See [`BroadPhase::step`].
    ///
    /// # Errors
    /// Those of [`BroadPhase::step`], or [`Error::NoFilters`] for a rule in a world without filters.
    pub fn step(self) -> Result<KeyedStep<'b, K>, Error> {
        let Self { broad_phase, executor, rule } = self;
        broad_phase.run(|owned, names, own| {
            let executor = executor.unwrap_or(own);
            let Some(rule) = rule else { return owned.step(executor, None) };
            let by_slot = |a, b| names.any_pair([a, b]).is_some_and(|[a, b]| rule(a, b));
            owned.step(executor, Some(&by_slot))
        })
    }
}

/// Steps, and what the last one has found.
impl<K: Copy + Eq + Hash> BroadPhase<K> {
    /// Finds all overlapping pairs of the boxes as they are now, with as much memory as they take.
    ///
    /// # Errors
    /// [`Error::NoMemory`], [`Error::CapacityTooLarge`] of more than four billion pairs, or [`Error::InvariantBroken`].
    #[doc(alias("update", "refit", "rebuild"))]
    pub fn step(&mut self) -> Result<KeyedStep<'_, K>, Error> {
        self.run(|owned, _, executor| owned.step(executor, None))
    }

    /// Brings the tree up to date for queries, without a look for pairs: a broad phase that is only asked needs no step. Without
    /// this, queries look one by one at all boxes that have changed since the last step. See [`World::refresh`].
    ///
    /// ```
    /// use trisap::{Aabb, BroadPhase, Cast};
    ///
    /// let mut broad_phase = BroadPhase::new();
    /// for k in 0..1000u16 {
    ///     broad_phase.insert(k, Aabb::from_center([f32::from(k); 3], [1.0; 3]))?;
    /// }
    /// broad_phase.refresh()?;
    /// let ray = Cast::ray([500.0, 500.0, 0.0], [0.0, 0.0, 1.0], f32::INFINITY);
    /// assert_eq!(broad_phase.first_hit(&ray)?.map(|hit| hit.0), Some(499));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvariantBroken`].
    pub fn refresh(&mut self) -> Result<(), Error> {
        self.owned.change(|world| world.refresh())
    }

    /// Puts the pairs of the last step into an order that depends on them alone, whatever the room, the workers and the past
    /// of the broad phase are: by the [slots](trisap_core::Id::slot) of their objects. See [`World::sort_results`].
    pub fn sort_results(&mut self) {
        if let Some(numbers) = &mut self.numbers {
            numbers.sort(self.owned.as_world());
        }
        self.owned.change(|world| world.sort_results());
    }

    /// Steps on the workers of a job system of your own: `broad_phase.on(&executor).step()`. At most
    /// [`Config::workers`](crate::Config::workers) work at once.
    pub fn on<'b>(&'b mut self, executor: &'b dyn Executor) -> KeyedStepper<'b, K> {
        KeyedStepper { broad_phase: self, executor: Some(executor), rule: None }
    }

    /// Steps with a rule that decides the pairs that the filters let through: `broad_phase.with_rule(&rule).step()`. If there is a
    /// rule in one step, it should be the same in all; see [`refilter`](Self::refilter).
    ///
    /// ```
    /// use trisap::{Aabb, BroadPhase, Config};
    ///
    /// let mut broad_phase = BroadPhase::with_config(&Config::default().with_filters())?;
    /// broad_phase.extend([1, 2, 11].map(|key| (key, Aabb::new([0.0; 3], [1.0; 3]))));
    /// let other_team = |a: i32, b: i32| a / 10 != b / 10;
    /// let step = broad_phase.with_rule(&other_team).step()?;
    /// assert_eq!(step.pairs().count(), 2); // 1 and 11, 2 and 11
    /// # Ok::<(), trisap::Error>(())
    /// ```
    pub fn with_rule<'b>(&'b mut self, rule: &'b KeyedRule<'b, K>) -> KeyedStepper<'b, K> {
        KeyedStepper { broad_phase: self, executor: None, rule: Some(rule) }
    }

    /// Steps until there is room for all pairs.
    fn run(
        &mut self,
        step: impl Fn(&mut OwnedWorld, &Names<K>, &dyn Executor) -> Result<(), Error>,
    ) -> Result<KeyedStep<'_, K>, Error> {
        let was_complete = core::mem::take(&mut self.complete);
        loop {
            #[cfg(feature = "rayon")]
            let executor: &dyn Executor = if self.config.workers > 1 { &self.executor } else { &Serial };
            #[cfg(not(feature = "rayon"))]
            let executor: &dyn Executor = &Serial;
            match step(&mut self.owned, &self.names, executor) {
                Err(Error::PairsFull { needed, .. }) => {
                    // A quarter more, so that a growing scene does not move in each step.
                    let too_many = Error::CapacityTooLarge { field: Field::Pairs, most: u64::from(u32::MAX) };
                    let pairs = u32::try_from(needed + needed / 4).map_err(|_| too_many)?;
                    self.grow(self.config.capacity.with_pairs(pairs))?;
                }
                said => break said?,
            }
        }
        self.complete = true;
        self.names.step(self.owned.as_world());
        // Without memory for them there are none: they would have missed this step.
        if let Some(mut numbers) = self.numbers.take() {
            numbers.step(self.owned.as_world(), was_complete)?;
            self.numbers = Some(numbers);
        }
        Ok(KeyedStep { broad_phase: self })
    }

    /// The overlapping pairs of the last step, each once, without those of keys that were removed since. Of the two keys the one
    /// that was inserted first comes first, here and in all pairs: so a pair is lost in the order in which it was found.
    pub fn pairs(&self) -> impl Iterator<Item = [K; 2]> {
        self.as_world().pairs().iter().filter_map(|pair| self.names.pair(*pair))
    }

    /// The keys that a key was in pairs with at the last step. O(all pairs).
    pub fn pairs_of(&self, key: &K) -> impl Iterator<Item = K> {
        let slot = self.id(key).map(trisap_core::Id::slot);
        let partner =
            move |[a, b]: [u32; 2]| if Some(a) == slot { Some(b) } else { (Some(b) == slot).then_some(a) };
        let is_old = slot.is_some_and(|slot| self.names.in_slot(slot).is_some());
        let pairs = if is_old { self.as_world().pairs() } else { &[] };
        pairs.iter().filter_map(move |pair| self.names.in_slot(partner(*pair)?).map(|named| named.key))
    }

    /// Those of which at least one has not been put to rest: what a narrow phase has to look at that keeps the contacts of those
    /// that rest.
    pub fn awake_pairs(&self) -> impl Iterator<Item = [K; 2]> {
        self.as_world().awake_pairs().filter_map(|pair| self.names.pair(pair))
    }

    /// The pairs that the last step had and the one before had not.
    ///
    /// # Panics
    /// If there are no [events](crate::Config::with_events): an empty answer would be wrong.
    #[doc(alias("started", "begin_contact"))]
    pub fn found(&self) -> impl Iterator<Item = [K; 2]> {
        let (pairs, told) = self.events(|events| &events.found, World::found);
        pairs.iter().filter_map(|pair| self.names.pair(*pair)).chain(told.iter().copied())
    }

    /// The pairs that the step before had and the last one has not, also of keys that have been removed. A key that was removed and
    /// inserted again is another object: its pairs are lost, and found again. So take the lost pairs out of a set of contacts before
    /// the found ones are put in.
    ///
    /// # Panics
    /// If there are no [events](crate::Config::with_events): an empty answer would be wrong.
    #[doc(alias("stopped", "ended", "end_contact"))]
    pub fn lost(&self) -> impl Iterator<Item = [K; 2]> {
        let (pairs, told) = self.events(|events| &events.lost, World::lost);
        let from_world = (!pairs.is_empty()).then(|| self.as_world().lost_ids()).into_iter().flatten();
        from_world.filter_map(|pair| self.names.former_pair(pair)).chain(told.iter().copied())
    }

    /// Events of the world, or those that are told in its place.
    fn events<'b>(
        &'b self,
        told: impl FnOnce(&'b Events<K>) -> &'b Vec<[K; 2]>,
        of_world: impl FnOnce(&'b World<'b>) -> &'b [[u32; 2]],
    ) -> (&'b [[u32; 2]], &'b [[K; 2]]) {
        assert!(
            self.config.events,
            "found and lost pairs need a broad phase made with `Config::with_events`"
        );
        match &self.names.events {
            Some(events) => (&[], told(events)),
            None => (of_world(self.as_world()), &[]),
        }
    }

    /// What the last step did.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.as_world().stats()
    }
}
