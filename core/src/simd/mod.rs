//! The operations of a step for each instruction set, and all `unsafe` for it.
//!
//! What a step does with boxes is a function that is generic over [`Simd`] and inlined, so it has the
//! instruction set of its caller: [`run!`](kernels::run), for the level of a [`Kernels`](crate::Kernels). A
//! level is some operations on bytes, records and boxes: one small file. All levels give the same bytes.

// A program for an emulator is built with `--cfg agreement` to call the tests of single operations.
#[cfg(any(test, agreement))]
#[path = "../../tests/kernels/agreement.rs"]
mod agreement;
pub(crate) mod kernels;
pub(crate) mod levels;
pub(crate) mod scalar;
#[cfg(any(
    all(target_arch = "x86", feature = "sse41"),
    all(target_arch = "x86_64", any(feature = "sse41", feature = "avx2")),
    all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"),
    all(target_arch = "wasm32", target_feature = "simd128")
))]
mod vectors;

use crate::access::Access;
use crate::geometry::boxes::Boxes;
use crate::geometry::key::{KeyBox, KeyFour};
use crate::geometry::line::{Crossing, Walk};
use crate::geometry::record::{Frame, Record};
use crate::id::{Index, Pair, pair};

/// How two records of one leaf lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Contact {
    /// They touch on all axes, as far as the grid can tell. If not, they are apart for certain.
    pub(crate) touches: bool,
    /// Two coordinates share a step of the grid, so only the keys can decide.
    pub(crate) tied: bool,
}

/// Four bytes of a record: see [`Simd::row`].
pub(crate) type Row = [u8; 4];

/// Rows that are compared at a time: one bit each in a mask.
pub(crate) const WINDOW: usize = 64;

/// Records that are tested against a cast at a time.
pub(crate) const EIGHT: usize = 8;

/// The result of a test of candidates.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tested {
    /// Pairs.
    pub(crate) found: usize,
    /// Candidates that only the keys can decide.
    pub(crate) tied: usize,
}

/// As [`Simd::overlaps`], one pair after another.
#[inline(always)]
fn each_overlap<S: Simd, I: Index>(simd: S, boxes: &[KeyBox], pairs: &[Pair<I>]) -> usize {
    let mut bits = 0;
    for (bit, pair) in pairs.iter().enumerate() {
        let overlap = simd.overlap(KeyBox::of(boxes, pair[0].at()), KeyBox::of(boxes, pair[1].at()));
        bits |= usize::from(overlap) << bit;
    }
    bits
}

/// The operations of one instruction set. A value of the type is the proof that the CPU has it.
pub(crate) trait Simd: Copy + Send + Sync {
    /// The six keys of a box, three minima and three maxima.
    type Keys: Copy;

    /// The places of a row's bytes in a record.
    type Axis: Copy;

    /// What rows are compared with.
    type Query: Copy;

    /// Whether it encodes four boxes at a time: see [`encode_four`](Self::encode_four).
    const ENCODES_FOUR: bool = false;

    /// Whether loops are compiled in more forms where that takes less time: some pairs or candidates tested at
    /// once, half a window, boxes that leave their fat boxes in an exact world, what all boxes have in common.
    const MORE_CODE: bool = false;

    /// Calls a closure that is compiled for this level: see [`call!`].
    #[inline(never)]
    fn call<R>(self, work: impl FnOnce() -> R) -> R {
        work()
    }

    /// The keys of a box.
    fn keys(self, bounds: &KeyBox) -> Self::Keys;

    /// The keys of the first four boxes: bit `k` where box `k` is not `old[k]`. `None`, and nothing is
    /// written, where one is bad, an old one empty, or one not inside what it is to be `held` by.
    #[inline(always)]
    fn encode_four(
        self,
        _: Boxes<'_>,
        _held: Option<&KeyFour>,
        _old: &KeyFour,
        _new: &mut KeyFour,
    ) -> Option<u32> {
        None
    }

    /// Which of some boxes are inside the outer ones, a bit each. One box in scalar code, four with vectors.
    #[inline(always)]
    fn inside<const N: usize>(self, outer: &[KeyBox; N], inner: &[KeyBox; N]) -> u32 {
        let boxes = outer.iter().zip(inner).enumerate();
        boxes.fold(0, |bits, (bit, (outer, inner))| bits | u32::from(outer.contains(inner)) << bit)
    }

    /// As [`KeyBox::predicted`], for one box in scalar code, for four with vectors.
    #[inline(always)]
    fn predicted<const N: usize>(
        self,
        now: &[KeyBox; N],
        old: &[KeyBox; N],
        margins: &[f32; N],
        predicts: bool,
        made: &mut [KeyBox; N],
    ) {
        for (made, ((now, old), margin)) in made.iter_mut().zip(now.iter().zip(old).zip(margins)) {
            *made = KeyBox::predicted(now, old, *margin, predicts);
        }
    }

    /// The keys of `a` that are above the keys of `b`: bit `k` for minimum `k`, bit `3 + k` for maximum `k`.
    fn above(self, a: Self::Keys, b: Self::Keys) -> u32;

    /// As [`KeyBox::overlaps`].
    #[inline(always)]
    fn overlap(self, a: &KeyBox, b: &KeyBox) -> bool {
        a.overlaps(b)
    }

    /// Which of some pairs of slots have overlapping boxes: a bit each of at most [`PAIRS_TOGETHER`].
    #[inline(always)]
    fn overlaps<I: Index>(self, boxes: &[KeyBox], pairs: &[Pair<I>]) -> usize {
        each_overlap(self, boxes, pairs)
    }

    /// Prepares the rows of a sweep along an axis.
    fn axis(self, axis: usize) -> Self::Axis;

    /// The row of a record: on each of the two other axes the high bytes of the complemented minimum and of
    /// the maximum.
    fn row(self, axis: Self::Axis, record: &Record) -> Row;

    /// Prepares a comparison of rows with a record: on each of the two other axes the high bytes of its
    /// complemented maximum and of its minimum. They are at most the same bytes of a row that it touches
    /// there.
    fn query(self, axis: Self::Axis, record: &Record) -> Self::Query;

    /// Which of the first `count` rows, at most all, have no byte below the query's: bit `i` for row `i`.
    /// There are 32 or [`WINDOW`] rows.
    fn window<const N: usize>(self, rows: &[Row; N], count: usize, query: Self::Query) -> u64;

    /// Tests the record at `base >> 16` against four others, at `base & 0xffff` plus the lowest four
    /// bits of a mask. Writes the pairs that touch and share no mark to the start of `to`, in
    /// order, and returns how many there are. What is behind them means nothing. `None` if only the keys can
    /// decide one of the four, or if a position is not in the slice. The mask must have four bits at least.
    #[inline(always)]
    fn four<I: Index>(self, sorted: &[Record], base: u32, bits: u64, to: &mut [Pair<I>; 4]) -> Option<usize> {
        let a = sorted.get((base >> 16) as usize)?;
        let (mut found, mut rest) = (0, bits);
        for _ in 0..4 {
            let b = sorted.get((base & 0xffff).wrapping_add(rest.trailing_zeros()) as usize)?;
            rest &= rest.wrapping_sub(1);
            let contact = self.contact(a, b);
            if contact.tied {
                return None;
            }
            to.put(found, pair::<I>(a.slot(), b.slot()));
            found += usize::from(contact.touches & (a.tag & b.tag & Record::MARKS == 0));
        }
        Some(found)
    }

    /// Tests candidates, which are pairs of positions: `high << 16 | low`. Writes the pairs that certainly
    /// touch and share no mark to the start of `pairs`, in order, and the candidates that only the keys can
    /// decide to the start of `candidates`. What is behind them means nothing. `pairs` has a place for each
    /// candidate.
    #[inline(always)]
    fn test_candidates<I: Index>(
        self,
        sorted: &[Record],
        candidates: &mut [u32],
        pairs: &mut [Pair<I>],
    ) -> Tested {
        let Tested { mut found, mut tied } = Tested::default();
        let (mut from, mut one_by_one) = (0, 0);
        while from < candidates.len() {
            if Self::MORE_CODE && from >= one_by_one {
                one_by_one = from + 4;
                // No closures: they would not share the instruction set of their function.
                if let Some(four) = candidates.get(from..).and_then(|rest| rest.first_chunk())
                    && let Some(room) = pairs.get_mut(found..).and_then(|room| room.first_chunk_mut())
                    && let Some(kept) = self.any_four(sorted, four, room)
                {
                    (found, from) = (found + kept, one_by_one);
                    continue;
                }
            }
            let candidate = candidates.at(from);
            let a = sorted.at((candidate >> 16) as usize);
            let b = sorted.at((candidate & 0xffff) as usize);
            let contact = self.contact(&a, &b);
            // Two records that share a mark are reported in another leaf (erratum E9).
            let ours = contact.touches & (a.tag & b.tag & Record::MARKS == 0);
            // Always written, kept or not: there is no branch to predict.
            pairs.put(found, pair::<I>(a.slot(), b.slot()));
            found += usize::from(ours & !contact.tied);
            candidates.put(tied, candidate);
            tied += usize::from(ours & contact.tied);
            from += 1;
        }
        Tested { found, tied }
    }

    /// As [`four`](Self::four) for any four candidates. Also `None` if a position is not in the slice.
    #[inline(always)]
    fn any_four<I: Index>(self, _: &[Record], _: &[u32; 4], _to: &mut [Pair<I>; 4]) -> Option<usize> {
        None
    }

    #[inline(always)]
    fn contact(self, a: &Record, b: &Record) -> Contact {
        let (mut touches, mut tied) = (true, false);
        for k in 0..6 {
            // b's maximum against a's minimum, then the complements: b's minimum against a's maximum.
            let limit = !b.lanes[(k + 3) % 6];
            touches &= a.lanes[k] <= limit;
            tied |= a.lanes[k] == limit;
        }
        Contact { touches, tied }
    }

    /// Which of some records touch the one whose [`limit`] this is: bit `i` for record `i`.
    #[inline(always)]
    fn touching(self, records: &[Record; EIGHT], limit: Record) -> u32 {
        let mut mask = 0;
        for (index, record) in records.iter().enumerate() {
            let mut inside = true;
            for k in 0..6 {
                inside &= record.lanes[k] <= limit.lanes[k];
            }
            mask |= u32::from(inside) << index;
        }
        mask
    }

    /// When a cast enters the boxes of two nodes, between zero and `until`; NaN if it does not. The sides
    /// must be numbers.
    #[inline(always)]
    fn enter(self, walk: &Walk, nodes: [&KeyBox; 2], until: f32) -> [f32; 2] {
        walk.enter(nodes, until)
    }

    /// When a cast enters each of some records, and which it may touch: bit `i` for record `i`. Others have
    /// NaN.
    #[inline(always)]
    fn met(self, records: &[Record; EIGHT], crossing: &Crossing) -> ([f32; EIGHT], u32) {
        let (mut times, mut mask) = ([f32::NAN; EIGHT], 0);
        for (index, record) in records.iter().enumerate() {
            times[index] = crossing.met(record);
            mask |= u32::from(!times[index].is_nan()) << index;
        }
        (times, mask)
    }

    /// A box on the grid of a leaf.
    fn record(self, frame: &Frame, keys: Self::Keys, tag: u32) -> Record;
}

/// The bits of minima in a mask, and of maxima.
pub(crate) const MINIMA: u32 = 0b111;
pub(crate) const MAXIMA: u32 = 0b111 << 3;

/// The lanes that a row comes from, complemented.
#[inline(always)]
const fn row_lanes(axis: usize) -> [usize; 4] {
    match axis {
        0 => [1, 4, 2, 5],
        1 => [2, 5, 0, 3],
        _ => [0, 3, 1, 4],
    }
}

/// The lanes that a query comes from.
#[inline(always)]
const fn query_lanes(axis: usize) -> [usize; 4] {
    let [a, b, c, d] = row_lanes(axis);
    [b, a, d, c]
}

/// What the lanes of another record must not exceed to touch this one: the maxima, then the complemented
/// minima. The tag's lanes exclude nothing.
#[inline(always)]
pub(crate) fn limit(record: &Record) -> Record {
    let [x0, y0, z0, x1, y1, z1] = record.lanes.map(|lane| !lane);
    Record { lanes: [x1, y1, z1, x0, y0, z0], tag: u32::MAX }
}

/// Calls a function of a level as a call, not inline: `call!(simd, drain(simd, masks))`. What it needs takes
/// no registers from its caller's loops.
macro_rules! call {
    ($simd:ident, $call:expr) => {
        $crate::simd::Simd::call(
            $simd,
            #[inline(always)]
            move || $call,
        )
    };
}
pub(crate) use call;
