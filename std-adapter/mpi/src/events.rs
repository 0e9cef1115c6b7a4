//! Which candidates of sweeps are pairs that this rank has found or lost.
//!
//! A pair belongs to the rank whose cell holds its corner. Where the rank owns one of both objects, that is so: on each axis, the
//! corner is not below the owned object's minimum, which is in the cell, and both minima are below the cell's upper end, since
//! both boxes reach the cell. Only the corners of two ghosts have to be looked at.

use crate::split::{Cell, corner};
use crate::table::{KeyMap, KeyPair, Object, Table};

/// Objects that lived in the last step and have left, by the slot that they had.
pub(crate) type Gone = KeyMap<u32, Object>;

/// When the slots of a candidate had the objects that it is about.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum When {
    /// When the step began.
    Start,
    /// At the early sweep.
    EarlySweep,
    /// Now.
    Now,
}

/// What is known when a step's sweeps are done.
pub(crate) struct Deciding<'l> {
    pub(crate) table: &'l Table,
    /// Who has left before the early sweep and after it.
    pub(crate) gone: &'l [Gone; 2],
    /// The rank's cell now and in the last step.
    pub(crate) now: &'l Cell,
    pub(crate) before: &'l Cell,
}

impl Deciding<'_> {
    /// A candidate of two objects that the rank owns and owned in the last step: it is right, and belongs to this rank.
    #[inline]
    fn steady(&self, pair: [u32; 2]) -> Option<KeyPair> {
        self.table.steady_keys(pair).map(ordered)
    }

    /// A pair that the only sweep of a step has found, if it belongs to this rank and is new.
    #[inline]
    pub(crate) fn found(&self, pair: [u32; 2]) -> Option<KeyPair> {
        self.steady(pair).or_else(|| self.found_of_others(pair))
    }

    fn found_of_others(&self, pair: [u32; 2]) -> Option<KeyPair> {
        let table = self.table;
        let is_found = if pair.iter().all(|slot| table.is_known(*slot)) {
            // The sweep has compared the very boxes that count.
            pair.iter().any(|slot| table.is_owned(*slot)) || self.holds_now(pair)
        } else {
            self.is_new(pair, When::Now)
        };
        is_found.then(|| self.keys(pair, When::Now))
    }

    /// A pair that the only sweep of a step has lost, if it belonged to this rank and is not there now.
    #[inline]
    pub(crate) fn lost(&self, pair: [u32; 2]) -> Option<KeyPair> {
        self.steady(pair).or_else(|| self.lost_of_others(pair))
    }

    fn lost_of_others(&self, pair: [u32; 2]) -> Option<KeyPair> {
        let table = self.table;
        let is_lost = if pair.iter().all(|slot| table.is_known(*slot)) {
            pair.iter().any(|slot| table.is_steady(*slot)) || self.held_before(pair)
        } else {
            self.was_there(pair, When::Start)
        };
        is_lost.then(|| self.keys(pair, When::Start))
    }

    /// As [`found`](Self::found), of one of two sweeps.
    pub(crate) fn found_of_two(&self, pair: [u32; 2], when: When) -> Option<KeyPair> {
        let decided = || self.is_new(pair, when).then(|| self.keys(pair, when));
        self.steady(pair).or_else(decided)
    }

    /// As [`lost`](Self::lost), of one of two sweeps.
    pub(crate) fn lost_of_two(&self, pair: [u32; 2], when: When) -> Option<KeyPair> {
        let decided = || self.was_there(pair, when).then(|| self.keys(pair, when));
        self.steady(pair).or_else(decided)
    }

    /// Whether a pair overlaps now, did not before, and belongs to this rank.
    fn is_new(&self, pair: [u32; 2], when: When) -> bool {
        let [a, b] = pair.map(|slot| self.object(slot, when));
        a.now.overlaps(&b.now) && !a.before.overlaps(&b.before) && self.now.holds(corner(&a.now, &b.now))
    }

    /// Whether a pair overlapped before, does not now, and belonged to this rank.
    fn was_there(&self, pair: [u32; 2], when: When) -> bool {
        let [a, b] = pair.map(|slot| self.object(slot, when));
        a.before.overlaps(&b.before)
            && !a.now.overlaps(&b.now)
            && self.before.holds(corner(&a.before, &b.before))
    }

    /// The keys of a pair, the lower one first.
    #[inline]
    fn keys(&self, pair: [u32; 2], when: When) -> KeyPair {
        ordered(pair.map(|slot| self.key(slot, when)))
    }

    fn holds_now(&self, pair: [u32; 2]) -> bool {
        let [a, b] = pair.map(|slot| &self.table.now[slot as usize]);
        self.now.holds(corner(a, b))
    }

    fn held_before(&self, pair: [u32; 2]) -> bool {
        let [a, b] = pair.map(|slot| self.table.get(slot).before);
        self.before.holds(corner(&a, &b))
    }

    #[inline]
    fn key(&self, slot: u32, when: When) -> u64 {
        self.former(slot, when).map_or_else(|| self.table.key(slot), |object| object.key)
    }

    fn object(&self, slot: u32, when: When) -> Object {
        self.former(slot, when).copied().unwrap_or_else(|| self.table.get(slot))
    }

    /// The object that has left a slot since then.
    #[inline]
    fn former(&self, slot: u32, when: When) -> Option<&Object> {
        if when == When::Now || !self.table.was_vacated(slot) {
            return None;
        }
        let [first, last] = self.gone;
        let early = (when == When::Start).then(|| first.get(&slot)).flatten();
        early.or_else(|| last.get(&slot))
    }
}

/// Two keys, the lower one first.
#[inline]
pub(crate) fn ordered([a, b]: KeyPair) -> KeyPair {
    [a.min(b), a.max(b)]
}
