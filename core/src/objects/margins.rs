//! Fat boxes: an object has moved when its box leaves the fat box around an earlier one (paper, section III.B;
//! erratum E2). In exact mode margins are left unused for a while if most objects keep leaving theirs, since they
//! then only make the swept boxes larger.

use crate::access::Access;
use crate::config::{Margin, Mode};
use crate::geometry::key::{KeyBox, length};
use crate::id::Index;
use crate::memory::slab::Parts;
use crate::simd::Simd;

/// The fat boxes of some consecutive slots; none if there are no margins, or they are left unused.
pub(crate) struct FatBoxes<'o> {
    pub(crate) boxes: &'o mut [KeyBox],
    pub(crate) margins: &'o [f32],
    pub(crate) fixed_margins: bool,
    pub(crate) motions: Motions,
}

/// What new boxes meant to objects with margins.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Motions {
    /// Whether a box changed inside its fat box, which stays.
    pub(crate) moved_inside_margin: bool,
    /// Boxes that were farther from the last one than the margin.
    pub(crate) outran: u32,
}

impl FatBoxes<'_> {
    /// Whether there are margins in use.
    #[inline(always)]
    pub(crate) fn exist(&self) -> bool {
        !self.boxes.is_empty()
    }

    /// The box of an object whose overlaps a result has; `now` is its box as given.
    #[inline(always)]
    pub(crate) fn reported(&self, mode: Mode, at: usize, now: &KeyBox) -> KeyBox {
        if mode == Mode::Fat && self.exist() { self.boxes.at(at) } else { *now }
    }

    /// Makes the fat box of an object around its box.
    pub(crate) fn anchor(&mut self, at: usize, bounds: &KeyBox) {
        self.boxes.put(at, bounds.grown(self.margins.at(at)));
    }

    /// Gives an object with a margin another box. Returns whether it stays in its fat box.
    #[inline(always)]
    pub(crate) fn follow<S: Simd>(&mut self, simd: S, at: usize, old: &KeyBox, keys: S::Keys) -> bool {
        let margin = if self.fixed_margins { None } else { Some(self.margins.at(at)) };
        if simd.suits(KeyBox::of(self.boxes, at), keys, margin) {
            self.motions.moved_inside_margin = true;
            return true;
        }
        self.stays(at, old, &simd.bounds(keys))
    }

    /// The same without vectors. Not inline, as it is as long as the rest of the intake.
    #[inline(never)]
    fn stays(&mut self, at: usize, old: &KeyBox, bounds: &KeyBox) -> bool {
        let fat = KeyBox::of(self.boxes, at);
        let margin = self.margins.at(at);
        if fat.contains(bounds) && (self.fixed_margins || !fat.dwarfs(bounds, margin)) {
            self.motions.moved_inside_margin = true;
            return true;
        }
        // The last box tells how fast the object is: its margin around that one would not have held this one either.
        let outran = !self.fixed_margins && !old.grown(margin).contains(bounds);
        self.motions.outran += u32::from(outran);
        self.boxes.put(at, bounds.grown(if outran { 0.0 } else { margin }));
        false
    }
}

/// Leaves margins unused from now on. Objects that had one count as moved. O(slots).
#[cold]
#[inline(never)]
pub(crate) fn leave_unused<I: Index>(parts: &mut Parts<'_, I>) {
    for slot in 0..parts.state.objects.slots as usize {
        let now = parts.boxes.now.at(slot);
        if !now.is_empty() && parts.boxes.fat.at(slot) != now {
            parts.objects().touch(slot);
        }
    }
    parts.boxes.tight = true;
}

/// Uses margins again. An object has one from its next box on. O(slots).
#[cold]
#[inline(never)]
pub(crate) fn use_again<I: Index>(parts: &mut Parts<'_, I>) {
    let slots = parts.state.objects.slots as usize;
    for (fat, now) in parts.boxes.fat.iter_mut().zip(parts.boxes.now.span(0, slots)) {
        *fat = if now.is_empty() { KeyBox::EMPTY } else { *now };
    }
    parts.boxes.tight = false;
}

/// The most that the size of a box counts, in multiples of its smallest side: a wide plane needs no wide margin.
const FLATTEST: f32 = 8.0;

/// The length of a margin for a box (erratum E2). An unbounded box counts as size zero.
pub(crate) fn margin_length(margin: &Margin, bounds: &KeyBox) -> f32 {
    let largest = bounds.largest_extent();
    let mut smallest = f32::MAX;
    for k in 0..3 {
        let side = length(bounds.min[k], bounds.max[k]);
        // The size of a flat box is that on its other axes.
        if side > 0.0 && side < smallest {
            smallest = side;
        }
    }
    let size = if largest > f32::MAX { 0.0 } else { largest.min(FLATTEST * smallest) };
    (margin.per_extent * size).max(margin.min).min(margin.max)
}
