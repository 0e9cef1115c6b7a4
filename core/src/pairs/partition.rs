//! Divides lists of pairs by a test of their boxes, or of sets of slots.

use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::limits::{PAIR_BLOCKS, PAIRS_PER_BLOCK};
use crate::memory::prefetch::{BOXES_NEAR, PAIRS_AHEAD};
use crate::pairs::persistent::is_clear_of;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::simd::{Phase, Simd};
use core::cell::Cell;

/// Brings the pairs that pass a test to the front and returns how many there are. Workers divide blocks; then pairs
/// on the wrong side of the border change places.
pub(crate) fn partition<I: Index>(
    context: StepContext<'_>,
    pairs: &mut [Pair<I>],
    test: impl Test<I>,
) -> usize {
    if context.is_small() {
        return context.kernels.run(PartitionBlock { pairs, test });
    }
    let count = pairs.len();
    let len = count.div_ceil(PAIR_BLOCKS).max(PAIRS_PER_BLOCK);
    let blocks = count.div_ceil(len);
    let mut fronts = [0; PAIR_BLOCKS];
    context.each((Chunks::new(&mut *pairs, len), Chunks::new(&mut fronts, 1)), |_, (pairs, front)| {
        front.fill(context.kernels.run(PartitionBlock { pairs, test }));
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

/// Divides one block in the same way.
pub(crate) struct PartitionBlock<'b, I, T> {
    pub(crate) pairs: &'b mut [Pair<I>],
    pub(crate) test: T,
}

/// How many pairs ahead boxes are prefetched, for so many pairs; all of them if none is prefetched.
#[inline(always)]
pub(crate) fn ahead(boxes: &[KeyBox], pairs: usize) -> usize {
    if cfg!(feature = "large") && boxes.len() > BOXES_NEAR { PAIRS_AHEAD } else { pairs }
}

impl<I: Index, T: Test<I>> Phase for PartitionBlock<'_, I, T> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> usize {
        let Self { pairs, test } = self;
        // Cells, so that pairs ahead can be read while others change places.
        let pairs = Cell::from_mut(pairs).as_slice_of_cells();
        let boxes = test.boxes();
        let ahead = ahead(boxes, pairs.len());
        let mut front = 0;
        let later = pairs.get(ahead..).unwrap_or_default();
        for (pair, later) in pairs.iter().zip(later) {
            let later = later.get();
            simd.prefetch(boxes, later[0].at());
            simd.prefetch(boxes, later[1].at());
            front += exchange(simd, pairs, front, pair, &test);
        }
        for pair in pairs.get(later.len()..).unwrap_or_default() {
            front += exchange(simd, pairs, front, pair, &test);
        }
        front
    }
}

/// Exchanges a pair with the one at `front` and returns how far the front moves up: one if the pair passes the test.
/// The exchange is made in any case, so there is no branch to predict: the pairs from `front` on are those that fail,
/// in any order.
#[inline(always)]
fn exchange<S: Simd, I: Index>(
    simd: S,
    pairs: &[Cell<Pair<I>>],
    front: usize,
    pair: &Cell<Pair<I>>,
    test: &impl Test<I>,
) -> usize {
    let Some(first) = pairs.get(front) else { return 0 };
    let next = pair.get();
    pair.set(first.get());
    first.set(next);
    usize::from(test.holds(simd, &next))
}

/// A test of a pair.
pub(crate) trait Test<I>: Copy + Sync {
    /// The boxes that it looks at, if any.
    fn boxes(&self) -> &[KeyBox] {
        &[]
    }

    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool;
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
