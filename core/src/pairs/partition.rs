//! Divides lists of pairs by what their boxes, or marks, tell.

use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::pairs::persistent::is_clear_of;
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::simd::{Phase, Simd};
use core::cell::Cell;

/// Blocks that pairs are divided in. Fixed, so that the order does not depend on the number of workers.
const BLOCKS: usize = 32;
/// The fewest pairs in a block.
const PAIRS_PER_BLOCK: usize = 8192;

/// Brings the pairs that the test holds of to the front and returns how many there are: block by block, and then those on
/// the wrong side of the border change places.
pub(crate) fn partition<I: Index>(
    context: StepContext<'_>,
    pairs: &mut [Pair<I>],
    test: impl Test<I>,
) -> usize {
    if context.is_small() {
        return context.kernels.run(PartitionBlock { pairs, test });
    }
    let count = pairs.len();
    let len = count.div_ceil(BLOCKS).max(PAIRS_PER_BLOCK);
    let blocks = count.div_ceil(len);
    let mut fronts = [0; BLOCKS];
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

/// Brings the pairs of a block that the test holds of to its front and returns how many there are.
pub(crate) struct PartitionBlock<'b, I, T> {
    pub(crate) pairs: &'b mut [Pair<I>],
    pub(crate) test: T,
}

/// How many pairs ahead boxes are prefetched: a pair's boxes are anywhere in memory. 0.91 to 0.97 of a step of 8,000.
const AHEAD: usize = 12;
/// Up to this many boxes are in the cache anyway, and are not prefetched.
const NEAR: usize = 4 << 10;

/// How many pairs ahead the boxes of so many pairs are prefetched; as many as there are, where none is.
#[inline(always)]
pub(crate) fn ahead(boxes: &[KeyBox], pairs: usize) -> usize {
    if cfg!(feature = "large") && boxes.len() > NEAR { AHEAD } else { pairs }
}

impl<I: Index, T: Test<I>> Phase for PartitionBlock<'_, I, T> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> usize {
        let Self { pairs, test } = self;
        // So that those further on can be read while others change.
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

/// Exchanges a pair with the one at `front` and returns how far the front moves up: one where the test holds of the pair.
/// Exchanged always, so that nothing waits for a guess of the branch predictor: the pairs from `front` on are those that the
/// test does not hold of, in any order.
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

/// Something that is true or false of a pair.
pub(crate) trait Test<I>: Copy + Sync {
    /// The boxes that it takes to tell, if any.
    fn boxes(&self) -> &[KeyBox] {
        &[]
    }

    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool;
}

/// The boxes overlap.
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

/// The boxes do not overlap.
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

/// The objects that overlapped are not the same any more, or do not overlap any more.
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

/// As [`Ended`], or no pair any more for the filters.
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

/// Neither object is marked.
#[derive(Clone, Copy)]
pub(crate) struct ClearOf<'b>(pub(crate) &'b [u32]);

impl<I: Index> Test<I> for ClearOf<'_> {
    #[inline(always)]
    fn holds<S: Simd>(&self, _: S, pair: &Pair<I>) -> bool {
        is_clear_of(self.0, pair)
    }
}

/// One of the objects is marked.
#[derive(Clone, Copy)]
pub(crate) struct Touch<'b>(pub(crate) &'b [u32]);

impl<I: Index> Test<I> for Touch<'_> {
    #[inline(always)]
    fn holds<S: Simd>(&self, _: S, pair: &Pair<I>) -> bool {
        !is_clear_of(self.0, pair)
    }
}

/// The pair is in an ascending list.
#[derive(Clone, Copy)]
pub(crate) struct Among<'b, I>(pub(crate) &'b [Pair<I>]);

impl<I: Index> Test<I> for Among<'_, I> {
    #[inline(always)]
    fn holds<S: Simd>(&self, _: S, pair: &Pair<I>) -> bool {
        self.0.binary_search(pair).is_ok()
    }
}
