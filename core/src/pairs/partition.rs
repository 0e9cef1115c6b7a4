//! Divides lists of pairs by a test of their boxes, or of sets of slots.

use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::limits::{PAIR_BLOCKS, PAIRS_PER_BLOCK};
use crate::memory::prefetch::{BOXES_NEAR, BOXES_OF_FOURS_NEAR, PAIRS_AHEAD};
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
struct PartitionBlock<'b, I, T> {
    pairs: &'b mut [Pair<I>],
    test: T,
}

/// How many pairs ahead boxes are prefetched, for so many pairs, where there are more boxes than are `near`; all of them if none is
/// prefetched.
#[inline(always)]
fn ahead(boxes: &[KeyBox], near: usize, pairs: usize) -> usize {
    if cfg!(feature = "large") && boxes.len() > near { PAIRS_AHEAD } else { pairs }
}

/// The pairs from the first one on whose boxes are prefetched, where events are told.
#[inline(always)]
pub(crate) fn later<'p, S: Simd, I>(boxes: &[KeyBox], pairs: &'p [Pair<I>]) -> &'p [Pair<I>] {
    let near = if S::TESTS_FOUR_PAIRS { BOXES_OF_FOURS_NEAR } else { BOXES_NEAR };
    pairs.get(ahead(boxes, near, pairs.len())..).unwrap_or_default()
}

/// The same pairs by fours, as far as the level tests so many at once, and the others.
#[inline(always)]
pub(crate) fn by_fours<S: Simd, I>(pairs: &[Pair<I>]) -> (&[[Pair<I>; 4]], &[Pair<I>]) {
    if S::TESTS_FOUR_PAIRS { pairs.as_chunks() } else { (&[], pairs) }
}

impl<I: Index, T: Test<I>> Phase for PartitionBlock<'_, I, T> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> usize {
        let Self { pairs, test } = self;
        // Cells, so that pairs ahead can be read while others change places.
        let pairs = Cell::from_mut(pairs).as_slice_of_cells();
        let boxes = test.boxes();
        let ahead = ahead(boxes, BOXES_NEAR, pairs.len());
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

/// Brings the pairs of one block that pass a test to the front, in order, and returns how many there are. The others have another
/// order than those of [`PartitionBlock`]: fewer pairs change places.
pub(crate) struct ToFront<'b, I, T> {
    pub(crate) pairs: &'b mut [Pair<I>],
    pub(crate) test: T,
}

impl<I: Index, T: Test<I>> Phase for ToFront<'_, I, T> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> usize {
        let Self { pairs, test } = self;
        let ahead = pairs.len() - later::<S, I>(test.boxes(), pairs).len();
        let (mut front, mut start) = (0, 0);
        while start < pairs.len() {
            let some = pairs.span(start, (pairs.len() - start).min(u64::BITS as usize));
            let later = pairs.get(start + ahead..).unwrap_or_default();
            // Noted for all of them first, since which ones pass is hard to predict.
            let mut passing = holding(simd, some, later, &test);
            while passing != 0 {
                pairs.swap_at(front, start + passing.trailing_zeros() as usize);
                passing &= passing - 1;
                front += 1;
            }
            start += u64::BITS as usize;
        }
        front
    }
}

/// Which of at most 64 pairs pass a test, a bit each. Prefetches the boxes of as many `later` ones.
#[inline(always)]
fn holding<S: Simd, I: Index>(simd: S, pairs: &[Pair<I>], later: &[Pair<I>], test: &impl Test<I>) -> u64 {
    let mut bits = 0;
    let (fours, rest) = by_fours::<S, I>(pairs);
    for (index, four) in fours.iter().enumerate() {
        prefetch_four(simd, test.boxes(), later, 4 * index);
        bits |= u64::from(test.four_hold(simd, four)) << (4 * index);
    }
    for (index, pair) in (4 * fours.len()..).zip(rest) {
        prefetch_pair(simd, test.boxes(), later, index);
        bits |= u64::from(test.holds(simd, pair)) << index;
    }
    bits
}

/// Prefetches the boxes of four pairs from a position on, if there are so many.
#[inline(always)]
pub(crate) fn prefetch_four<S: Simd, I: Index>(simd: S, boxes: &[KeyBox], pairs: &[Pair<I>], from: usize) {
    if let Some(four) = pairs.get(from..).and_then(<[_]>::first_chunk::<4>) {
        for at in 0..4 {
            prefetch_pair(simd, boxes, four, at);
        }
    }
}

/// Prefetches the boxes of a pair, if there is one at this position.
#[inline(always)]
pub(crate) fn prefetch_pair<S: Simd, I: Index>(simd: S, boxes: &[KeyBox], pairs: &[Pair<I>], at: usize) {
    if let Some(pair) = pairs.get(at) {
        simd.prefetch(boxes, pair[0].at());
        simd.prefetch(boxes, pair[1].at());
    }
}

/// A test of a pair.
pub(crate) trait Test<I>: Copy + Sync {
    /// The boxes that it looks at, if any.
    fn boxes(&self) -> &[KeyBox] {
        &[]
    }

    fn holds<S: Simd>(&self, simd: S, pair: &Pair<I>) -> bool;

    /// Which of four pairs pass: a bit each.
    #[inline(always)]
    fn four_hold<S: Simd>(&self, simd: S, pairs: &[Pair<I>; 4]) -> u32 {
        let mut bits = 0;
        for (bit, pair) in pairs.iter().enumerate() {
            bits |= u32::from(self.holds(simd, pair)) << bit;
        }
        bits
    }
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

    #[inline(always)]
    fn four_hold<S: Simd>(&self, simd: S, pairs: &[Pair<I>; 4]) -> u32 {
        0b1111 ^ simd.overlaps(self.0, pairs)
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
    fn four_hold<S: Simd>(&self, simd: S, pairs: &[Pair<I>; 4]) -> u32 {
        0b1111 ^ (simd.overlaps(self.now, pairs) & simd.overlaps(self.before, pairs))
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
