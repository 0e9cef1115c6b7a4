//! What happens to one object when it comes, gets another box, or goes (paper, section III.B; errata E1 to E6).

pub(crate) mod intake;

use crate::access::Access;
use crate::config::{Margin, Mode};
use crate::geometry::key::{KeyBox, length};
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::memory::slot_set::SlotSet;
use crate::memory::state::ObjectState;

/// The arrays of some consecutive slots; positions count from the first of them.
pub(crate) struct Objects<'o> {
    pub(crate) now: &'o mut [KeyBox],
    pub(crate) fat: FatBoxes<'o>,
    pub(crate) moved: SlotSet<'o>,
    pub(crate) changed: SlotSet<'o>,
    pub(crate) mode: Mode,
}

/// The fat boxes of some consecutive slots; none in a world without margins.
pub(crate) struct FatBoxes<'o> {
    pub(crate) boxes: &'o mut [KeyBox],
    pub(crate) margins: &'o [f32],
    pub(crate) fixed_margins: bool,
    pub(crate) motions: Motions,
}

/// What new boxes meant to objects with margins.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Motions {
    /// Whether a box changed inside its fat box, which then stays.
    pub(crate) moved_inside_margin: bool,
    /// Boxes that were farther from the last one than the margin.
    pub(crate) outran: u32,
}

impl FatBoxes<'_> {
    /// Whether the world has margins.
    #[inline(always)]
    pub(crate) fn exist(&self) -> bool {
        !self.boxes.is_empty()
    }

    /// Follows an object with a margin from one box to another one. Returns whether it stays in its fat box. Not inline: it is
    /// as long as the rest of an intake.
    #[inline(never)]
    pub(crate) fn follow(&mut self, at: usize, old: &KeyBox, bounds: &KeyBox) -> bool {
        let fat = KeyBox::of(self.boxes, at);
        if fat.contains(bounds) && (self.fixed_margins || !fat.dwarfs(bounds, self.margins.at(at))) {
            self.motions.moved_inside_margin = true;
            return true;
        }
        let margin = self.margins.at(at);
        // The last box says how fast the object is: a margin around it would not have held this one either.
        let outran = !self.fixed_margins && !old.grown(margin).contains(bounds);
        self.motions.outran += u32::from(outran);
        self.boxes.put(at, bounds.grown(if outran { 0.0 } else { margin }));
        false
    }
}

impl<I: Index> Parts<'_, I> {
    /// What all slots' arrays say about one object.
    pub(crate) fn objects(&mut self) -> Objects<'_> {
        let fat = FatBoxes {
            boxes: self.boxes.fat,
            margins: self.boxes.margins,
            fixed_margins: self.state.setup.has_fixed_margins(),
            motions: Motions::default(),
        };
        Objects {
            now: self.boxes.now,
            fat,
            moved: self.moved.reborrow(),
            changed: self.changed.reborrow(),
            mode: self.state.setup.mode(),
        }
    }
}

impl ObjectState {
    /// Notes what boxes that came have meant to their objects.
    pub(crate) fn note(&mut self, motions: Motions) {
        self.moved_inside_margin |= u8::from(motions.moved_inside_margin);
        self.outran = self.outran.saturating_add(motions.outran);
    }
}

impl Objects<'_> {
    /// A new object. It counts as moved once (erratum E6), and as overlapping nothing before.
    pub(crate) fn enter(&mut self, at: usize, bounds: KeyBox) {
        self.now.put(at, bounds);
        if self.fat.exist() {
            self.fat.boxes.put(at, bounds.grown(self.fat.margins.at(at)));
        }
        self.moved.set(at);
        self.changed.set(at);
    }

    /// A new box.
    pub(crate) fn accept(&mut self, at: usize, bounds: KeyBox) {
        let old = self.now.at(at);
        if bounds != old {
            self.now.put(at, bounds);
            let contained = self.fat.exist() && self.fat.follow(at, &old, &bounds);
            self.note(at / 32, 1 << (at % 32), u32::from(contained) << (at % 32));
        }
    }

    /// Notes that some objects of a word of the bit sets have other boxes now, and that fat boxes have held some of them.
    #[inline(always)]
    pub(crate) fn note(&mut self, word: usize, changed: u32, contained: u32) {
        let moved = changed & !contained;
        let reported = if self.mode == Mode::Exact { changed } else { moved };
        self.moved.add(word, moved);
        self.changed.add(word, reported);
    }

    /// Anchors the fat box at the current box anew, as after a move.
    pub(crate) fn anchor(&mut self, at: usize, bounds: KeyBox, margin: f32) {
        self.fat.boxes.put(at, bounds.grown(margin));
        self.moved.set(at);
        self.changed.set(at);
    }

    /// The object goes; `next` is the free slot behind it.
    pub(crate) fn leave(&mut self, at: usize, next: u32) {
        self.changed.set(at);
        self.now.put(at, KeyBox::free(next));
        if self.fat.exist() {
            self.fat.boxes.put(at, KeyBox::EMPTY);
        }
        self.moved.set(at);
    }
}

/// How many times the smallest side of a box its margin takes it to be large at most: a wide plane needs no wide margin.
const FLATTEST: f32 = 8.0;

/// The length that a margin means for a box (erratum E2). What is unbounded has no size that it could be a share of.
pub(crate) fn margin_length(margin: &Margin, bounds: &KeyBox) -> f32 {
    let largest = bounds.largest_extent();
    let mut smallest = f32::MAX;
    for k in 0..3 {
        let side = length(bounds.min[k], bounds.max[k]);
        // A flat box has a size on its other axes.
        if side > 0.0 && side < smallest {
            smallest = side;
        }
    }
    let size = if largest > f32::MAX { 0.0 } else { largest.min(FLATTEST * smallest) };
    (margin.per_extent * size).max(margin.min).min(margin.max)
}
