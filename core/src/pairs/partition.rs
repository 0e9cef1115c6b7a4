//! Divides lists of pairs by a test of their boxes, or of sets of slots.

use crate::access::{Access, bits};
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::limits::{PAIR_BLOCKS, PAIRS_PER_BLOCK, PAIRS_TOGETHER};
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::simd::kernels::run;
use crate::simd::{Simd, call};

#[derive(Clone, Copy)]
pub(crate) enum Test<'b, I> {
    /// The boxes overlap.
    Overlap(&'b [KeyBox]),
    /// The boxes do not overlap now; or did not before, if there are boxes of before: of new objects.
    Ended { now: &'b [KeyBox], before: &'b [KeyBox] },
    /// Neither object is in a set.
    ClearOf(&'b [u32]),
    /// Whatever the caller looks for.
    Holds(&'b (dyn Fn(&Pair<I>) -> bool + Sync)),
}

/// Whether neither object of a pair is in a set.
pub(crate) fn is_clear_of<I: Index>(set: &[u32], pair: &Pair<I>) -> bool {
    !(bits::test(set, pair[0].at()) | bits::test(set, pair[1].at()))
}

/// Brings the pairs that pass a test to the front and returns how many there are. Workers divide blocks; then
/// pairs on the wrong side of the border change places.
pub(crate) fn partition<I: Index>(
    context: StepContext<'_>,
    pairs: &mut [Pair<I>],
    test: Test<'_, I>,
) -> usize {
    let count = pairs.len();
    let len = count.div_ceil(PAIR_BLOCKS).max(PAIRS_PER_BLOCK);
    let mut fronts = [0; PAIR_BLOCKS];
    context.each((Chunks::new(&mut *pairs, len), Chunks::new(&mut fronts, 1)), |_, (pairs, front)| {
        front.fill(run!(context.kernels, |simd| to_front(simd, pairs, test)));
    });
    let border: usize = fronts.iter().sum();
    let starts = || (0..).map(|block| block * len).take_while(|start| *start < count).zip(&fronts);
    let mut all_late = starts().map(|(start, front)| border.max(start)..start + front);
    let (front, back) = pairs.split_at_mut_checked(border).unwrap_or_default();
    let mut late = 0..0;
    for (start, passing) in starts() {
        let mut early = start + passing..border.min(start + len);
        while !early.is_empty() {
            while late.is_empty() {
                late = all_late.next().unwrap_or(border..usize::MAX);
            }
            // Runs of one length change places.
            let run = late.len().min(early.len());
            let others = back.span_mut(late.start - border, run);
            front.span_mut(early.start, run).iter_mut().zip(others).for_each(|(a, b)| core::mem::swap(a, b));
            (early.start, late.start) = (early.start + run, late.start + run);
        }
    }
    border
}

/// Brings the pairs of one block that pass a test to the front and returns how many there are. The first pair
/// that does not pass changes places with the last one that passes, and so on.
#[inline(always)]
fn to_front<S: Simd, I: Index>(simd: S, pairs: &mut [Pair<I>], test: Test<'_, I>) -> usize {
    // Pairs are tested together, since which ones pass is hard to predict: the next ones from either end.
    // These have bits where pairs wait to change places.
    let (mut start, mut end) = (0, pairs.len());
    let (mut failing, mut first, mut passing) = (0, 0, 0usize);
    loop {
        let len = PAIRS_TOGETHER.min(end - start);
        if failing == 0 && len > 0 {
            let next = pairs.span(start, len);
            failing = ones(len) & !call!(simd, test.hold(simd, next));
            (first, start) = (start, start + len);
        } else if passing == 0 && len > 0 {
            end -= len;
            let next = pairs.span(end, len);
            passing = call!(simd, test.hold(simd, next));
        } else if failing != 0 && passing != 0 {
            exchange_bits(pairs, (first, &mut failing), (end, &mut passing));
        } else {
            break;
        }
    }
    // One group is left to be divided: the last one from the front, or from the end.
    if failing != 0 {
        (end, passing) = (first, ones(start - first) & !failing);
    }
    let front = passing.count_ones() as usize;
    failing = ones(front) & !passing;
    passing &= !ones(front);
    while failing != 0 {
        exchange_bits(pairs, (end, &mut failing), (end, &mut passing));
    }
    end + front
}

/// The same, pair by pair, for the few of a world without a tree: a loop for each test, in registers.
#[inline(always)]
pub(super) fn one_by_one<I: Index>(pairs: &mut [Pair<I>], holds: impl Fn(&Pair<I>) -> bool) -> usize {
    let (mut count, mut rest) = (0, pairs.iter_mut());
    while let Some(pair) = rest.next() {
        if !holds(pair) {
            let Some(last) = rest.rfind(|pair| holds(pair)) else { break };
            core::mem::swap(pair, last);
        }
        count += 1;
    }
    count
}

/// Exchanges the pair of a word's lowest bit with the pair of another word's highest bit; clears both bits.
fn exchange_bits<I: Index>(pairs: &mut [Pair<I>], low: (usize, &mut usize), high: (usize, &mut usize)) {
    let highest = PAIRS_TOGETHER - 1 - high.1.leading_zeros() as usize;
    pairs.swap_at(low.0 + low.1.trailing_zeros() as usize, high.0 + highest);
    *low.1 &= low.1.wrapping_sub(1);
    *high.1 &= !(1 << highest);
}

const fn ones(count: usize) -> usize {
    if count == 0 { 0 } else { usize::MAX >> (PAIRS_TOGETHER - count) }
}

impl<I: Index> Test<'_, I> {
    /// Which of at most [`PAIRS_TOGETHER`] pairs pass: a bit each.
    #[inline(always)]
    fn hold<S: Simd>(self, simd: S, pairs: &[Pair<I>]) -> usize {
        match self {
            Self::Overlap(now) => simd.overlaps(now, pairs),
            Self::Ended { now, before } => {
                let mut overlap = simd.overlaps(now, pairs);
                if !before.is_empty() {
                    overlap &= simd.overlaps(before, pairs);
                }
                ones(pairs.len()) & !overlap
            }
            Self::ClearOf(set) => each(pairs, |pair| is_clear_of(set, pair)),
            Self::Holds(test) => each(pairs, test),
        }
    }
}

/// A bit for each pair that passes a test.
#[inline(always)]
fn each<I>(pairs: &[Pair<I>], holds: impl Fn(&Pair<I>) -> bool) -> usize {
    pairs.iter().enumerate().fold(0, |bits, (bit, pair)| bits | usize::from(holds(pair)) << bit)
}
