//! Divides lists of pairs by a test of their boxes, or of sets of slots.

use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::limits::{PAIR_BLOCKS, PAIRS_PER_BLOCK, PAIRS_TOGETHER, PLACES_UNASKED};
use crate::memory::prefetch::{BOXES_NEAR, BOXES_OF_SOME_NEAR};
use crate::pairs::persistent::is_clear_of;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::simd::Simd;
use crate::simd::kernels::run;
use core::cell::Cell;

/// Brings the pairs that pass a test to the front and returns how many there are. Workers divide blocks; then pairs
/// on the wrong side of the border change places.
pub(crate) fn partition<I: Index>(
    context: StepContext<'_>,
    pairs: &mut [Pair<I>],
    test: impl Test<I>,
) -> usize {
    let to_front = |pairs: &mut [Pair<I>]| run!(context.kernels, |simd| to_front(simd, pairs, test));
    if context.is_small() {
        return to_front(pairs);
    }
    let count = pairs.len();
    let len = count.div_ceil(PAIR_BLOCKS).max(PAIRS_PER_BLOCK);
    let blocks = count.div_ceil(len);
    let mut fronts = [0; PAIR_BLOCKS];
    context.each((Chunks::new(&mut *pairs, len), Chunks::new(&mut fronts, 1)), |_, (pairs, front)| {
        front.fill(to_front(pairs));
    });
    let border = fronts.iter().sum();
    if blocks > 1 {
        let ends = || (0..blocks).map(|block| (block * len, block * len + fronts.at(block)));
        let late = ends().flat_map(|(start, end)| start.max(border)..end);
        let early = ends().flat_map(|(start, end)| end..(start + len).min(border));
        for (late, early) in late.zip(early) {
            pairs.swap_at(late, early);
        }
    }
    border
}

/// Brings the pairs of one block that pass a test to the front, in order, and returns how many there are.
#[inline(always)]
pub(crate) fn to_front<S: Simd, I: Index, T: Test<I>>(simd: S, pairs: &mut [Pair<I>], test: T) -> usize {
    if cfg!(any(not(feature = "large"), target_family = "wasm")) {
        // A small processor guesses no branches, and a module for the web is loaded over a network: this takes the least code.
        let (cells, mut front) = (Cell::from_mut(pairs).as_slice_of_cells(), 0);
        for pair in cells {
            let next = pair.get();
            if test.holds(simd, &next) {
                if let Some(first) = cells.get(front) {
                    pair.set(first.get());
                    first.set(next);
                }
                front += 1;
            }
        }
        return front;
    }
    let boxes = test.boxes();
    let near = if S::TESTS_SOME_PAIRS { BOXES_OF_SOME_NEAR } else { BOXES_NEAR };
    let far = boxes.len() > near;
    let (mut front, mut start) = (0, 0);
    while start < pairs.len() {
        let end = pairs.len().min(start + PAIRS_TOGETHER);
        if far {
            for pair in pairs.get(end..pairs.len().min(end + PAIRS_TOGETHER)).unwrap_or_default() {
                simd.prefetch(boxes, pair[0].at());
                simd.prefetch(boxes, pair[1].at());
            }
        }
        // Noted for all of them first, since which ones pass is hard to predict.
        let mut passing = test.hold(simd, pairs.span(start, end - start));
        // How many pass is so, too: where there are few, no branch asks for it.
        for _ in 0..PLACES_UNASKED {
            let (to, from) = if passing == 0 {
                (start, start)
            } else {
                (front, start + passing.trailing_zeros() as usize)
            };
            pairs.swap_at(to, from);
            front += usize::from(passing != 0);
            passing &= passing.wrapping_sub(1);
        }
        while passing != 0 {
            pairs.swap_at(front, start + passing.trailing_zeros() as usize);
            passing &= passing - 1;
            front += 1;
        }
        start = end;
    }
    front
}

/// A test of a pair.
pub(crate) trait Test<I>: Copy + Sync {
    /// The boxes that it looks at, if any.
    fn boxes(&self) -> &[KeyBox] {
        &[]
    }

    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool;

    /// Which of at most [`PAIRS_TOGETHER`] pairs pass: a bit each.
    #[inline(always)]
    fn hold<S: Simd>(&self, simd: S, pairs: &[Pair<I>]) -> usize {
        let mut bits = 0;
        for (bit, pair) in pairs.iter().enumerate() {
            bits |= usize::from(self.holds(simd, pair)) << bit;
        }
        bits
    }
}

/// A bit for each of at least one pair.
const fn all<I>(pairs: &[Pair<I>]) -> usize {
    usize::MAX >> (PAIRS_TOGETHER - pairs.len())
}

/// Passes if the boxes overlap.
#[derive(Clone, Copy)]
pub(crate) struct Overlap<'b>(pub(crate) &'b [KeyBox]);

impl<I: Index> Test<I> for Overlap<'_> {
    #[inline(always)]
    fn boxes(&self) -> &[KeyBox] {
        self.0
    }

    #[inline(always)]
    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool {
        simd.overlap(KeyBox::of(self.0, pair[0].at()), KeyBox::of(self.0, pair[1].at()))
    }

    #[inline(always)]
    fn hold<S: Simd>(&self, simd: S, pairs: &[Pair<I>]) -> usize {
        simd.overlaps(self.0, pairs)
    }
}

/// Passes if the boxes do not overlap.
#[derive(Clone, Copy)]
pub(crate) struct Apart<'b>(pub(crate) &'b [KeyBox]);

impl<I: Index> Test<I> for Apart<'_> {
    #[inline(always)]
    fn boxes(&self) -> &[KeyBox] {
        self.0
    }

    #[inline(always)]
    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool {
        !Overlap(self.0).holds(simd, pair)
    }

    #[inline(always)]
    fn hold<S: Simd>(&self, simd: S, pairs: &[Pair<I>]) -> usize {
        all(pairs) & !simd.overlaps(self.0, pairs)
    }
}

/// Passes if the boxes do not overlap now, or did not before: then other objects had the slots.
#[derive(Clone, Copy)]
pub(crate) struct Ended<'b> {
    pub(crate) now: &'b [KeyBox],
    pub(crate) before: &'b [KeyBox],
}

impl<I: Index> Test<I> for Ended<'_> {
    #[inline(always)]
    fn boxes(&self) -> &[KeyBox] {
        self.now
    }

    #[inline(always)]
    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool {
        !(Overlap(self.now).holds(simd, pair) && Overlap(self.before).holds(simd, pair))
    }

    #[inline(always)]
    fn hold<S: Simd>(&self, simd: S, pairs: &[Pair<I>]) -> usize {
        all(pairs) & !(simd.overlaps(self.now, pairs) & simd.overlaps(self.before, pairs))
    }
}

/// As [`Ended`]; passes also if the filters no longer let the pair through: an object is in the set `asked`, and the
/// pair does not stay.
#[derive(Clone, Copy)]
pub(crate) struct Dropped<'b, I> {
    pub(crate) now: &'b [KeyBox],
    pub(crate) before: &'b [KeyBox],
    pub(crate) asked: &'b [u32],
    pub(crate) staying: &'b [Pair<I>],
}

impl<I: Index> Test<I> for Dropped<'_, I> {
    #[inline(always)]
    fn boxes(&self) -> &[KeyBox] {
        self.now
    }

    #[inline(always)]
    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool {
        let Self { now, before, asked, staying } = *self;
        let dropped = || Touch(asked).holds(simd, pair) && !Among(staying).holds(simd, pair);
        Ended { now, before }.holds(simd, pair) || dropped()
    }
}

/// Passes if neither object is in a set.
#[derive(Clone, Copy)]
pub(crate) struct ClearOf<'b>(pub(crate) &'b [u32]);

impl<I: Index> Test<I> for ClearOf<'_> {
    #[inline(always)]
    fn holds<S: Simd>(&self, _: S, pair: &Pair<I>) -> bool {
        is_clear_of(self.0, pair)
    }
}

/// Passes if an object is in a set.
#[derive(Clone, Copy)]
pub(crate) struct Touch<'b>(pub(crate) &'b [u32]);

impl<I: Index> Test<I> for Touch<'_> {
    #[inline(always)]
    fn holds<S: Simd>(&self, _: S, pair: &Pair<I>) -> bool {
        !is_clear_of(self.0, pair)
    }
}

/// Passes if the pair is in an ascending list.
#[derive(Clone, Copy)]
pub(crate) struct Among<'b, I>(pub(crate) &'b [Pair<I>]);

impl<I: Index> Test<I> for Among<'_, I> {
    #[inline(always)]
    fn holds<S: Simd>(&self, _: S, pair: &Pair<I>) -> bool {
        self.0.binary_search(pair).is_ok()
    }
}
