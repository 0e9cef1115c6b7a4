//! What happens to one object: it comes, gets another box, or goes (paper, III.B.1 and V; errata E1 to E6).

pub(crate) mod intake;
pub(crate) mod margins;

use crate::access::{Access, bits};
use crate::config::{EVENTS, MARGINS, TREE};
use crate::geometry::key::{KeyBox, POSITIVE_INFINITY};
use crate::id::Index;
use crate::memory::layout::reports_margins;
use crate::memory::slab::Parts;
use crate::memory::slot_set::SlotSet;
use crate::objects::margins::{FatBoxes, FatRule};

/// The arrays of some consecutive slots. Positions count from the first of them.
pub(crate) struct Objects<'o> {
    pub(crate) now: &'o mut [KeyBox],
    /// See [`BoxParts::cut`](crate::memory::slab::BoxParts::cut). Steps need it not.
    pub(crate) cut: &'o mut [u16],
    /// In a fat world: the boxes as given. `now` then has what they are reported as.
    pub(crate) given: &'o mut [KeyBox],
    pub(crate) fat: FatBoxes<'o>,
    pub(crate) moved: SlotSet<'o>,
    pub(crate) changed: SlotSet<'o>,
    /// See [`BoxParts::before`](crate::memory::slab::BoxParts::before).
    pub(crate) before: &'o mut [KeyBox],
    /// Who is put to rest by the caller; empty where nobody is.
    pub(crate) resting: &'o [u32],
}

impl<I: Index> Parts<'_, I> {
    /// In a step: whether a box has changed inside its fat box since the last complete one.
    pub(crate) fn any_stays(&self) -> bool {
        TREE && self.changed.count() > self.moved.count()
    }

    /// The box of an object as it was given last.
    pub(crate) fn bounds(&self, slot: usize) -> KeyBox {
        let now = self.boxes.now.at(slot);
        if now.is_empty() { now.enabled(self.boxes.cut.at(slot)) } else { self.boxes.given().at(slot) }
    }

    /// Where a process may have ended between two writes: makes boxes whole, and what is around them anew.
    #[cold]
    #[inline(never)]
    pub(crate) fn mend_boxes(&mut self) {
        for slot in 0..self.state.objects.slots as usize {
            let mut bounds = self.boxes.given().at(slot);
            // The box of a free slot or a disabled object is beyond. These are not written in a step.
            if bounds.min[0] <= POSITIVE_INFINITY {
                bounds.include(&KeyBox { min: bounds.max, max: bounds.min });
                self.objects().anchor(slot, bounds);
            }
        }
    }

    /// The arrays of all slots, to change some.
    pub(crate) fn objects(&mut self) -> Objects<'_> {
        self.state.objects.dirty = 1;
        let has_tree = !self.sizes.is_small();
        let (predicted, renews) = (self.config().predicted, has_tree && self.state.step.renews != 0);
        let boxes = if self.boxes.tight { &mut [] } else { &mut *self.boxes.fat };
        let (margins, reports_margins) = (&*self.boxes.margins, reports_margins(&self.sizes.config));
        let rule = FatRule { reports_margins, predicted, renews, regrows: false, outran: 0 };
        Objects {
            now: self.boxes.now,
            cut: self.boxes.cut,
            given: self.boxes.given,
            fat: FatBoxes { boxes, margins, rule },
            moved: self.moved.reborrow(),
            changed: self.changed.reborrow(),
            before: self.boxes.before,
            resting: if self.state.objects.resting != 0 { self.resting } else { &[] },
        }
    }
}

impl Objects<'_> {
    /// Keeps the box that the last complete step reported, for the events of the next one. To be called
    /// before anything of the slot is replaced; only the first call after that step counts.
    fn keep(&mut self, at: usize) {
        if EVENTS
            && TREE
            && let Some(before) = self.before.get_mut(at)
            && !bits::test(self.changed.words, at)
        {
            let now = self.now.at(at);
            *before = if now.is_empty() { KeyBox::EMPTY } else { now };
        }
    }

    /// Notes that the next step has to look at a slot.
    pub(crate) fn touch(&mut self, at: usize) {
        self.keep(at);
        self.moved.set(at);
        self.changed.set(at);
    }

    /// A new object. It counts as moved once (erratum E6), and as overlapping nothing before. If another
    /// object had the slot in the last step, its pairs are lost in any case.
    pub(crate) fn insert(&mut self, at: usize, bounds: KeyBox) {
        self.anchor(at, bounds);
        if EVENTS
            && TREE
            && let Some(before) = self.before.get_mut(at)
        {
            *before = KeyBox::EMPTY;
        }
    }

    /// A new box, given by itself.
    pub(crate) fn accept(&mut self, at: usize, bounds: KeyBox) {
        let Some(now) = self.now.get_mut(at).filter(|now| !now.is_empty()) else {
            return self.hide(at, bounds);
        };
        // Far too wide. No predicted box is at first. What is reported follows from boxes alone.
        let around = if MARGINS && !self.given.is_empty() { Some(&*now) } else { self.fat.boxes.get(at) };
        let margin = self.fat.margin(at);
        if let Some(around) = around
            && around.largest_extent() > 16.0 * (bounds.largest_extent() + margin)
        {
            return self.anchor(at, bounds);
        }
        let before =
            self.before.get_mut(at).filter(|_| EVENTS && TREE && !bits::test(self.changed.words, at));
        if let Some(stays) = self.fat.replace(self.given, at, now, &bounds, before) {
            self.note(at / 32, 1 << (at % 32), u32::from(stays) << (at % 32));
        }
    }

    /// Whether boxes with margins are reported.
    pub(crate) fn is_fat(&self) -> bool {
        MARGINS && !self.given.is_empty()
    }

    /// Puts the box of an object there whose motion nobody knows.
    fn place(&mut self, at: usize, mut bounds: KeyBox) {
        if self.is_fat() {
            self.given.put(at, bounds);
            let margin = self.fat.margin(at);
            bounds = bounds.grown(margin);
        }
        self.now.put(at, bounds);
        self.fat.anchor(at, &bounds);
    }

    /// Notes that some objects of a word of the bit sets have other boxes, of which some stay in their fat
    /// boxes.
    pub(crate) fn note(&mut self, word: usize, changed: u32, contained: u32) {
        self.moved.add(word, changed & !contained);
        self.changed.add(word, changed);
    }

    /// Makes what is around the box anew, as after a move.
    pub(crate) fn anchor(&mut self, at: usize, bounds: KeyBox) {
        self.touch(at);
        self.place(at, bounds);
    }

    /// The object goes; `next` is the next free slot.
    pub(crate) fn remove(&mut self, at: usize, next: u32) {
        self.touch(at);
        self.empty(at, KeyBox::free(next));
    }

    /// The object is disabled, or is and gets another box: steps see an empty one.
    pub(crate) fn hide(&mut self, at: usize, bounds: KeyBox) {
        let (hidden, low) = bounds.disabled();
        self.empty(at, hidden);
        self.cut.put(at, low);
    }

    fn empty(&mut self, at: usize, empty: KeyBox) {
        self.now.put(at, empty);
        if self.is_fat() {
            self.given.put(at, KeyBox::EMPTY);
        }
        if self.fat.exist() {
            self.fat.boxes.put(at, KeyBox::EMPTY);
        }
    }
}
