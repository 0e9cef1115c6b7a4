//! Gives the result of the last step.

use super::World;
use crate::access::Access;
use crate::error::Rejected;
use crate::id::{Index, Pair};
use crate::memory::stats::Stats;
use crate::pairs::order;

/// Results of the last step by slot, which stay until the next one.
///
/// ```
/// # use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_events();
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// let mut masses = [2.0, 3.0, 5.0]; // the caller's own arrays, by slot
/// let boxes = [0.0, 0.5, 9.0].map(|x| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]));
/// for aabb in boxes {
///     world.insert(aabb)?;
/// }
/// world.step()?;
/// for [a, b] in world.pairs().iter().map(|pair| pair.map(usize::from)) {
///     masses[a] += masses[b];
/// }
/// assert_eq!(masses, [5.0, 3.0, 5.0]);
/// assert_eq!((world.found().len(), world.lost().len(), world.stats().pairs), (1, 0, 1));
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// The overlapping pairs of the last step, each once, the lower slot first. Their order means nothing, but the
    /// same calls give the same order. After [`Error::PairsFull`](crate::Error::PairsFull) these are the pairs that
    /// fit.
    #[doc(alias("contacts", "collisions", "overlaps"))]
    #[must_use]
    pub fn pairs(&self) -> &[Pair<I>] {
        let result = self.parts.state.pairs.result();
        self.parts.output.pairs.span(result.start, result.len())
    }

    /// With events: the pairs of the last step that the complete step before it did not have. Other objects in the
    /// same slots are another pair.
    #[doc(alias("started", "begin_contact"))]
    #[must_use]
    pub fn found(&self) -> &[Pair<I>] {
        let found = self.parts.state.pairs.found as usize;
        self.parts.output.pairs.span(self.parts.state.pairs.result().end - found, found)
    }

    /// With events: the pairs of the complete step before the last one that the last one does not have. The slot of a
    /// removed object may have a new object by now, and the same two slots may be found again: take the lost pairs first.
    #[doc(alias("stopped", "ended", "end_contact"))]
    #[must_use]
    pub fn lost(&self) -> &[Pair<I>] {
        self.parts.output.previous.span(0, self.parts.state.pairs.lost as usize)
    }

    /// Puts the result of the last step into an order of its own: [`pairs`](Self::pairs) are those that the complete
    /// step before had, in ascending order, and behind them the [found](Self::found) ones in ascending order; the
    /// [lost](Self::lost) ones ascend, too. Without events all pairs ascend. So worlds with the same objects in the same
    /// slots give the same bytes, whatever their room, their workers and their past are: as a solver needs that takes
    /// contacts in order and has to agree with another machine. After [`Error::PairsFull`](crate::Error::PairsFull)
    /// nothing is done.
    ///
    /// O(pairs), for each byte of a pair, in place: about as long as a step takes to find that many. The next step with
    /// few movers looks at all pairs once more, as those at rest are no longer set aside.
    ///
    /// ```
    /// # use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, layout};
    /// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
    /// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
    /// # let mut world = memory.init::<u16>(&CONFIG)?;
    /// for x in [2.0, 1.0, 0.0] {
    ///     world.insert(Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]))?;
    /// }
    /// world.step()?;
    /// world.sort_results();
    /// assert_eq!(world.pairs(), [[0, 1], [1, 2]]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn sort_results(&mut self) {
        order::sort_results(&mut self.parts);
    }

    /// What the last step did.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.parts.state.stats()
    }
}

/// The result of a step, and a view of the world as it is after it.
pub struct Step<'w, I: Index = u32> {
    pub(super) world: &'w World<'w, I>,
    pub(super) rejected: Option<Rejected>,
}

impl<'w, I: Index> Step<'w, I> {
    /// See [`World::pairs`].
    #[must_use]
    pub fn pairs(&self) -> &'w [Pair<I>] {
        self.world.pairs()
    }

    /// See [`World::found`].
    #[must_use]
    pub fn found(&self) -> &'w [Pair<I>] {
        self.world.found()
    }

    /// See [`World::lost`].
    #[must_use]
    pub fn lost(&self) -> &'w [Pair<I>] {
        self.world.lost()
    }

    /// See [`World::awake_pairs`].
    pub fn awake_pairs(&self) -> impl Iterator<Item = Pair<I>> + use<'w, I> {
        self.world.awake_pairs()
    }

    /// The world after the step: for ids, boxes and queries while its pairs are looked at.
    #[must_use]
    pub fn world(&self) -> &'w World<'w, I> {
        self.world
    }

    /// What the step did.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.world.stats()
    }

    /// The objects whose boxes in the caller's array were refused: NaN, or a minimum above its maximum. They keep
    /// their last good boxes; all other objects are not affected.
    #[must_use]
    pub fn rejected(&self) -> Option<Rejected> {
        self.rejected
    }

    /// How many pairs there are only because of margins: their boxes as given do not overlap. Always zero in
    /// [`Mode::Exact`](crate::Mode::Exact). Each call counts: O(pairs).
    #[must_use]
    pub fn surplus(&self) -> u64 {
        let now = &self.world.parts.boxes.now;
        let apart = |pair: &&Pair<I>| !now.at(pair[0].at()).overlaps(&now.at(pair[1].at()));
        self.pairs().iter().filter(apart).count() as u64
    }
}
