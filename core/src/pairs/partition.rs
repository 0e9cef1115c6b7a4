//! Divides lists of pairs by a test of their boxes, or of sets of slots.

use crate::access::Access;
use crate::filter::FILTERS;
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
    test: Test<'_, I>,
) -> usize {
    let to_front = |pairs: &mut [Pair<I>]| run!(context.kernels, |simd| to_front(simd, pairs, &test));
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
pub(crate) fn to_front<S: Simd, I: Index>(simd: S, pairs: &mut [Pair<I>], test: &Test<'_, I>) -> usize {
    if cfg!(any(not(feature = "large"), target_family = "wasm")) {
        // A small processor guesses no branches, and a module for the web is loaded over a network: this takes the least code.
        let (cells, mut front) = (Cell::from_mut(pairs).as_slice_of_cells(), 0);
        for pair in cells {
            let next = pair.get();
            if test.hold(simd, &[next]) != 0 {
                if let Some(first) = cells.get(front) {
                    pair.set(first.get());
                    first.set(next);
                }
                front += 1;
            }
        }
        return front;
    }
    let [boxes, _] = test.boxes();
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
#[derive(Clone, Copy)]
pub(crate) enum Test<'b, I> {
    /// The boxes overlap.
    Overlap(&'b [KeyBox]),
    /// They do not.
    Apart(&'b [KeyBox]),
    /// The boxes do not overlap now, or did not before: then other objects had the slots.
    Ended { now: &'b [KeyBox], before: &'b [KeyBox] },
    /// The same, or the filters no longer let the pair through: an object is in the set `asked`, and the pair does not stay.
    Dropped { now: &'b [KeyBox], before: &'b [KeyBox], asked: &'b [u32], staying: &'b [Pair<I>] },
    /// Neither object is in a set.
    ClearOf(&'b [u32]),
    /// An object is in a set.
    Touch(&'b [u32]),
    /// The pair is in an ascending list.
    Among(&'b [Pair<I>]),
}

impl<'b, I: Index> Test<'b, I> {
    /// The boxes that it looks at, if any, now and before.
    const fn boxes(&self) -> [&'b [KeyBox]; 2] {
        match *self {
            Self::Overlap(now) | Self::Apart(now) => [now, &[]],
            Self::Ended { now, before } | Self::Dropped { now, before, .. } => [now, before],
            Self::ClearOf(_) | Self::Touch(_) | Self::Among(_) => [&[]; 2],
        }
    }

    /// Which of at most [`PAIRS_TOGETHER`] pairs pass, of at least one: a bit each.
    #[inline(always)]
    fn hold<S: Simd>(&self, simd: S, pairs: &[Pair<I>]) -> usize {
        let all = usize::MAX >> (PAIRS_TOGETHER - pairs.len());
        let [now, before] = self.boxes();
        let mut overlap = if now.is_empty() { all } else { simd.overlaps(now, pairs) };
        if !before.is_empty() {
            overlap &= simd.overlaps(before, pairs);
        }
        match *self {
            Self::Overlap(_) => overlap,
            // The tests below are of filters.
            _ if !FILTERS => all & !overlap,
            Self::Apart(_) | Self::Ended { .. } => all & !overlap,
            Self::Dropped { asked, staying, .. } => {
                let stays = |pair: &Pair<I>| is_clear_of(asked, pair) || staying.binary_search(pair).is_ok();
                all & !(overlap & each(pairs, stays))
            }
            Self::ClearOf(set) => each(pairs, |pair| is_clear_of(set, pair)),
            Self::Touch(set) => each(pairs, |pair| !is_clear_of(set, pair)),
            Self::Among(list) => each(pairs, |pair| list.binary_search(pair).is_ok()),
        }
    }
}

/// A bit for each pair that passes a test.
#[inline(always)]
fn each<I>(pairs: &[Pair<I>], holds: impl Fn(&Pair<I>) -> bool) -> usize {
    pairs.iter().enumerate().fold(0, |bits, (bit, pair)| bits | usize::from(holds(pair)) << bit)
}
