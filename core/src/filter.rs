//! Whom an object meets: asked before a pair is written, so that a pair that nobody wants costs no room.

use crate::access::Access;
use crate::error::Error;
use crate::id::{Id, Index, Pair};
use crate::storage::FilterParts;
use crate::sweep::Sink;
use crate::world::World;
use bytemuck::{Pod, Zeroable};

/// Whether there can be filters. A lean program does without their code.
pub(crate) const FILTERS: bool = cfg!(feature = "large");

/// Classes that the class matrix knows.
pub(crate) const CLASSES: usize = 32;

/// Whom an object meets. Two objects make a pair if each one's group is in the other one's mask, and their classes meet (see
/// [`World::set_classes`]).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Pod, Zeroable)]
pub struct Filter {
    /// The groups that the object is in, one bit each.
    pub group: u32,
    /// The groups that it meets.
    pub mask: u32,
    /// Its class, below 32: for instance static, kinematic, dynamic, sensor.
    pub class: u32,
}

impl Filter {
    /// In all groups, meets all groups, class 0: what a new object has.
    pub const ALL: Self = Self { group: u32::MAX, mask: u32::MAX, class: 0 };

    /// Of a class, in all groups, meets all groups.
    #[must_use]
    pub const fn class(class: u32) -> Self {
        Self { class, ..Self::ALL }
    }

    /// Class 0, with a group and a mask.
    #[must_use]
    pub const fn groups(group: u32, mask: u32) -> Self {
        Self { group, mask, class: 0 }
    }
}

impl Default for Filter {
    fn default() -> Self {
        Self::ALL
    }
}

/// A caller's own rule: whether the objects in two slots, the lower one first, make a pair.
///
/// It is asked from any worker, at any time during the step, only of boxes that overlap (with their
/// margins), and has to answer the same as long
/// as neither object was [refiltered](World::refilter): pairs of resting objects are not asked about again.
pub type Rule<'r> = dyn Fn(u32, u32) -> bool + Sync + 'r;

impl<I: Index> World<'_, I> {
    /// Sets whom an object meets. Its pairs follow at the next step. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`], [`Error::NoFilters`] or [`Error::BadClass`].
    pub fn set_filter(&mut self, id: Id, filter: Filter) -> Result<(), Error> {
        let slot = self.slot_of(id)?;
        if self.parts.filters.of.is_empty() {
            return Err(Error::NoFilters);
        }
        if filter.class as usize >= CLASSES {
            return Err(Error::BadClass { class: filter.class });
        }
        if self.filter(id) != Some(filter) {
            self.parts.filters.of.put(slot, filter);
            self.ask_again(slot);
        }
        Ok(())
    }

    /// Whom an object meets; `None` for a stale id, and in a world without filters.
    #[must_use]
    pub fn filter(&self, id: Id) -> Option<Filter> {
        self.slot_of(id).ok().and_then(|slot| self.parts.filters.of.get(slot).copied())
    }

    /// Sets which classes meet: bit `b` of `meets[a]` says whether `a` meets `b`, and the same for `meets[b]`; both have to
    /// be set. All classes meet at first. All pairs are looked for anew at the next step. O(n).
    ///
    /// # Errors
    /// [`Error::NoFilters`].
    pub fn set_classes(&mut self, meets: &[u32; 32]) -> Result<(), Error> {
        if self.parts.filters.classes.is_empty() {
            return Err(Error::NoFilters);
        }
        self.parts.filters.classes.copy_in(meets);
        for slot in 0..self.parts.state.slots as usize {
            if !self.parts.boxes.now.at(slot).is_empty() {
                self.ask_again(slot);
            }
        }
        Ok(())
    }

    /// Has the next step ask about all pairs of an object again, for a [`Rule`] that has changed its mind. O(1).
    ///
    /// # Errors
    /// [`Error::StaleId`] or [`Error::NoFilters`].
    pub fn refilter(&mut self, id: Id) -> Result<(), Error> {
        let slot = self.slot_of(id)?;
        if self.parts.filters.of.is_empty() {
            return Err(Error::NoFilters);
        }
        self.ask_again(slot);
        Ok(())
    }

    fn ask_again(&mut self, slot: usize) {
        self.parts.filters.changed.set(slot);
        self.parts.moved.set(slot);
        self.parts.changed.set(slot);
        self.parts.state.touched = 1;
    }
}

/// Decides about pairs of overlapping boxes.
#[derive(Clone, Copy)]
pub(crate) struct Gate<'g> {
    filters: &'g [Filter],
    classes: &'g [u32],
    rule: Option<&'g Rule<'g>>,
}

impl<'g> Gate<'g> {
    /// The gate of a world, if it has one.
    pub(crate) fn new(parts: &'g FilterParts<'_>, rule: Option<&'g Rule<'g>>) -> Option<Self> {
        (FILTERS && !parts.of.is_empty()).then_some(Self { filters: parts.of, classes: parts.classes, rule })
    }

    /// Whether two objects make a pair.
    #[inline]
    pub(crate) fn lets_through<I: Index>(&self, pair: &Pair<I>) -> bool {
        if !FILTERS {
            return true;
        }
        let (Some(a), Some(b)) = (self.filters.get(pair[0].at()), self.filters.get(pair[1].at())) else {
            return true;
        };
        meet(a, b, |class| self.classes.at(class))
            && self.rule.is_none_or(|rule| rule(pair[0].slot(), pair[1].slot()))
    }
}

/// Whether two objects make a pair by their filters and the rows of the class matrix.
#[inline(always)]
pub(crate) fn meet(a: &Filter, b: &Filter, row: impl Fn(usize) -> u32) -> bool {
    let class = |a: &Filter, b: &Filter| row(a.class as usize % CLASSES) >> (b.class % 32) & 1;
    let groups = a.group & b.mask != 0 && b.group & a.mask != 0;
    groups && class(a, b) & class(b, a) != 0
}

/// Passes on the pairs that a gate lets through.
pub(crate) struct Gated<'s, 'g, I> {
    pub(crate) gate: &'s Gate<'g>,
    pub(crate) sink: &'s mut dyn Sink<I>,
}

impl<I: Index> Sink<I> for Gated<'_, '_, I> {
    fn take(&mut self, pairs: &mut [Pair<I>]) {
        let mut kept = 0;
        for index in 0..pairs.len() {
            let pair = pairs.at(index);
            pairs.put(kept, pair);
            kept += usize::from(self.gate.lets_through(&pair));
        }
        self.sink.take(pairs.span_mut(0, kept));
    }
}
