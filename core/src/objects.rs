//! What happens to one object when it comes, gets another box, or goes (paper, section III.B; errata E1 to E6).

use crate::access::{Access, bits};
use crate::config::{Margin, Mode};
use crate::key::KeyBox;

/// The arrays of some consecutive slots; positions count from the first of them.
pub(crate) struct Objects<'o> {
    pub(crate) now: &'o mut [KeyBox],
    pub(crate) fat: &'o mut [KeyBox],
    pub(crate) margins: &'o [f32],
    pub(crate) before: &'o mut [KeyBox],
    pub(crate) moved: &'o mut [u32],
    pub(crate) changed: &'o mut [u32],
    pub(crate) mode: Mode,
}

impl Objects<'_> {
    fn has_margins(&self) -> bool {
        !self.fat.is_empty()
    }

    /// A new object. It counts as moved once (erratum E6), and as overlapping nothing before.
    pub(crate) fn enter(&mut self, at: usize, bounds: KeyBox) {
        self.now.put(at, bounds);
        if self.has_margins() {
            self.fat.put(at, bounds.grown(self.margins.at(at)));
        }
        bits::set(self.moved, at);
        bits::set(self.changed, at);
        // An object that had the slot since the last step is forgotten: its pairs are lost either way.
        if let Some(before) = self.before.get_mut(at) {
            *before = KeyBox::EMPTY;
        }
    }

    /// A new box. Returns whether the object crept: its box changed inside the fat box, which then stays.
    #[inline(always)]
    pub(crate) fn accept(&mut self, at: usize, bounds: KeyBox) -> bool {
        bounds != self.now.at(at) && self.change(at, bounds)
    }

    /// A box that differs from the old one.
    #[inline(always)]
    pub(crate) fn change(&mut self, at: usize, bounds: KeyBox) -> bool {
        let old = self.now.at(at);
        self.now.put(at, bounds);
        if !self.has_margins() {
            self.report(at, old);
            bits::set(self.moved, at);
            return false;
        }
        if self.mode == Mode::Exact {
            self.report(at, old);
        }
        let anchor = self.fat.at(at);
        if anchor.contains(&bounds) {
            return true;
        }
        self.anchor(at, bounds);
        false
    }

    /// Anchors the fat box at the current box anew, as after a move.
    pub(crate) fn anchor(&mut self, at: usize, bounds: KeyBox) {
        if self.mode == Mode::Fat {
            self.report(at, self.fat.at(at));
        }
        self.fat.put(at, bounds.grown(self.margins.at(at)));
        bits::set(self.moved, at);
    }

    /// The object goes; `next` is the free slot behind it.
    pub(crate) fn leave(&mut self, at: usize, next: u32) {
        let reported =
            if self.has_margins() && self.mode == Mode::Fat { self.fat.at(at) } else { self.now.at(at) };
        self.report(at, reported);
        self.now.put(at, KeyBox::free(next));
        if self.has_margins() {
            self.fat.put(at, KeyBox::EMPTY);
        }
        bits::set(self.moved, at);
    }

    /// Keeps the box that the last complete step has reported, the first time that it changes.
    #[inline(always)]
    fn report(&mut self, at: usize, old: KeyBox) {
        if bits::set(self.changed, at)
            && let Some(before) = self.before.get_mut(at)
        {
            *before = old;
        }
    }
}

/// The length that a margin means for a box (erratum E2).
pub(crate) fn margin_length(margin: &Margin, bounds: &KeyBox) -> f32 {
    (margin.per_extent * bounds.largest_extent()).max(margin.min).min(margin.max)
}
