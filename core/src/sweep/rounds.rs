//! Takes the bits of masks in rounds, so that no branch depends on how many bits a mask has. First one, two or three
//! bits of each mask go to a list of candidates, so that a multiple of four is left. Then four bits of each mask are
//! tested at once, until no mask has any.

use super::Sink;
use crate::access::Access;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair, pair};
use crate::memory::limits::MASKS_PER_ROUND;
use crate::memory::scratch::{CANDIDATES_PER_ROUND, Lists};
use crate::simd::{Simd, Tested, call};
use crate::tree::Record;
use core::ops::Range;

/// Candidates and pairs so far.
pub(super) struct Found<'s, I> {
    pub(super) sorted: &'s [Record],
    pub(super) boxes: &'s [KeyBox],
    pub(super) candidates: &'s mut [u32],
    /// Candidates that wait to be tested.
    pub(super) collected: usize,
    pub(super) pairs: &'s mut [Pair<I>],
    /// Pairs that wait to be passed on.
    pub(super) found: usize,
    /// As in [`LeafScratch`](crate::memory::scratch::LeafScratch).
    pub(super) tested: &'s mut u64,
    pub(super) tied: &'s mut u64,
}

/// Takes all bits of the masks.
#[inline(always)]
pub(super) fn drain<S: Simd, I: Index>(
    simd: S,
    lists: &mut Lists,
    mask_count: usize,
    found: &mut Found<'_, I>,
    sink: &mut dyn Sink<I>,
) {
    let mut left = 0;
    for start in (0..mask_count).step_by(MASKS_PER_ROUND) {
        found.make_room(simd, sink);
        left = found.odd_ones(lists, start..mask_count.min(start + MASKS_PER_ROUND), left);
    }
    while left > 0 {
        let mut again = 0;
        for start in (0..left).step_by(MASKS_PER_ROUND) {
            found.make_room(simd, sink);
            again = found.fours(simd, lists, start..left.min(start + MASKS_PER_ROUND), again);
        }
        left = again;
    }
}

/// Tests the last candidates and passes the last pairs on.
#[inline(always)]
pub(super) fn drain_last<S: Simd, I: Index>(simd: S, found: &mut Found<'_, I>, sink: &mut dyn Sink<I>) {
    found.test(simd, sink);
    found.hand_on(sink);
}

impl<I: Index> Found<'_, I> {
    /// Makes room for the candidates and the pairs of `MASKS_PER_ROUND` masks.
    #[inline(always)]
    fn make_room<S: Simd>(&mut self, simd: S, sink: &mut dyn Sink<I>) {
        if self.collected + CANDIDATES_PER_ROUND > self.candidates.len() {
            self.test(simd, sink);
        }
        if self.found + CANDIDATES_PER_ROUND > self.pairs.len() {
            self.hand_on(sink);
        }
    }

    /// Passes the pairs on.
    #[inline(always)]
    fn hand_on(&mut self, sink: &mut dyn Sink<I>) {
        sink.take(self.pairs.span_mut(0, self.found));
        self.found = 0;
    }

    /// Moves bits of masks to the candidates, so that a multiple of four is left. Masks with bits left are put to
    /// `to` and on; returns where they end.
    #[inline(always)]
    fn odd_ones(&mut self, lists: &mut Lists, which: Range<usize>, mut to: usize) -> usize {
        let room = self
            .candidates
            .get_mut(self.collected..)
            .and_then(<[_]>::first_chunk_mut::<CANDIDATES_PER_ROUND>);
        let Some(room) = room else { return to };
        let mut count = 0;
        for index in which {
            let (bits, base) = lists.mask(index);
            let (one, two, _) = without(bits);
            let odd = bits.count_ones() as usize % 4;
            // Always written, used or not.
            let at = count % (4 * MASKS_PER_ROUND);
            for (offset, bits) in [bits, one, two].into_iter().enumerate() {
                room.put(at + offset, candidate(base, bits));
            }
            count += odd;
            let even = if odd & 2 == 0 { bits } else { two };
            let rest = if odd & 1 == 0 { even } else { even & even.wrapping_sub(1) };
            lists.put_mask(to, rest, base);
            to += usize::from(rest != 0);
        }
        self.collected += count;
        to
    }

    /// Tests four bits of each mask. Masks with bits left are put to `to` and on; returns where they end.
    #[inline(always)]
    fn fours<S: Simd>(&mut self, simd: S, lists: &mut Lists, which: Range<usize>, mut to: usize) -> usize {
        let sorted = self.sorted;
        let pairs = self.pairs.get_mut(self.found..).and_then(<[_]>::first_chunk_mut::<CANDIDATES_PER_ROUND>);
        let candidates = self
            .candidates
            .get_mut(self.collected..)
            .and_then(<[_]>::first_chunk_mut::<CANDIDATES_PER_ROUND>);
        let (Some(pairs), Some(candidates)) = (pairs, candidates) else { return to };
        let (mut found, mut untested) = (0, 0);
        let count = which.len();
        for index in which {
            let (bits, base) = lists.mask(index);
            let (one, two, three) = without(bits);
            let rest = three & three.wrapping_sub(1);
            lists.put_mask(to, rest, base);
            to += usize::from(rest != 0);
            // No closure: it would not have the instruction set of its function.
            if let Some(room) =
                pairs.get_mut(found % (4 * MASKS_PER_ROUND)..).and_then(<[_]>::first_chunk_mut::<4>)
                && let Some(four) = simd.four(sorted, base, bits, room)
            {
                found += four;
                continue;
            }
            // Rare, except where boxes share sides.
            for bits in [bits, one, two, three] {
                candidates.put(untested, candidate(base, bits));
                untested += 1;
            }
        }
        self.found += found;
        self.collected += untested;
        *self.tested += (4 * count - untested) as u64;
        to
    }

    /// Tests the candidates on all lanes.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, sink: &mut dyn Sink<I>) {
        if self.found + self.collected > self.pairs.len() {
            self.hand_on(sink);
        }
        let (sorted, boxes) = (self.sorted, self.boxes);
        let candidates = self.candidates.span_mut(0, self.collected);
        let pairs = self.pairs.span_mut(self.found, self.collected);
        let Tested { found, tied } = call!(simd, test_candidates(simd, sorted, candidates, pairs, boxes));
        *self.tested += self.collected as u64;
        *self.tied += tied as u64;
        self.found += found;
        self.collected = 0;
    }
}

/// A mask without its lowest bit, its two lowest, and its three lowest.
#[inline(always)]
const fn without(bits: u64) -> (u64, u64, u64) {
    let one = bits & bits.wrapping_sub(1);
    let two = one & one.wrapping_sub(1);
    (one, two, two & two.wrapping_sub(1))
}

/// The candidate of the lowest bit of a mask.
#[inline(always)]
const fn candidate(base: u32, bits: u64) -> u32 {
    base.wrapping_add(bits.trailing_zeros())
}

/// Tests candidates: see [`Simd::test_candidates`]. Pairs go to the front of `pairs`, which has a place for each
/// candidate.
#[inline(always)]
fn test_candidates<S: Simd, I: Index>(
    simd: S,
    sorted: &[Record],
    candidates: &mut [u32],
    pairs: &mut [Pair<I>],
    boxes: &[KeyBox],
) -> Tested {
    let Tested { mut found, tied } = simd.test_candidates(sorted, candidates, pairs);
    // Where boxes share a step of the grid, the keys decide.
    for &candidate in candidates.span(0, tied) {
        let a = sorted.at((candidate >> 16) as usize).slot();
        let b = sorted.at((candidate & 0xffff) as usize).slot();
        pairs.put(found, pair::<I>(a, b));
        found += usize::from(simd.overlap(KeyBox::of(boxes, a as usize), KeyBox::of(boxes, b as usize)));
    }
    Tested { found, tied }
}
