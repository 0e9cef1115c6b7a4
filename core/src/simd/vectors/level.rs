//! The level of some vectors, whatever the instruction set.

use super::operations::{Half, HalfOf, Halves, NO_BYTE, Vectors, ends, places};
use super::{casts, encode, fours, overlaps};
use crate::geometry::boxes::Boxes;
use crate::geometry::key::{KeyBox, KeyFour};
use crate::geometry::line::{Crossing, Walk};
use crate::geometry::record::{Frame, Record};
use crate::id::{Index, Pair};
use crate::simd::{Contact, EIGHT, Row, Simd, WINDOW, each_overlap, query_lanes, row_lanes};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Level<W>(W);

impl<W: Halves> Level<W> {
    pub(crate) const NAME: &'static str = W::NAME;

    /// The level, where the target guarantees it.
    pub(crate) const GUARANTEED: Option<Self> = match W::GUARANTEED {
        Some(vectors) => Some(Self(vectors)),
        None => None,
    };

    /// The level, where this CPU has it.
    pub(crate) fn detect() -> Option<Self> {
        W::detect().map(Self)
    }
}

/// The places of the high bytes of four lanes, four times.
#[inline(always)]
fn high_bytes<W: Halves>(w: W, lanes: [usize; 4]) -> HalfOf<W> {
    w.half().splat(u32::from_le_bytes(lanes.map(|lane| 2 * lane as u8 + 1)))
}

/// The places of the six lanes of a record, of which the maxima stand in the last half.
const SIX_LANES: [u8; 16] = [0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 12, 13, NO_BYTE, NO_BYTE, NO_BYTE, NO_BYTE];

impl<W: Halves> Simd for Level<W> {
    type Keys = W::Vector;

    type Axis = [HalfOf<W>; 2];

    type Query = W::Vector;

    const ENCODES_FOUR: bool = true;

    const TESTS_SOME_PAIRS: bool = W::TESTS_SOME_PAIRS;

    #[inline(always)]
    fn call<R>(self, work: impl FnOnce() -> R) -> R {
        self.0.call(work)
    }

    #[inline(always)]
    fn keys(self, bounds: &KeyBox) -> W::Vector {
        let [first, last] = ends(bounds);
        self.0.pick(first, last)
    }

    #[inline(always)]
    fn encode_four(self, boxes: Boxes<'_>, held: &KeyFour, old: &KeyFour, new: &mut KeyFour) -> Option<u32> {
        encode::encode_four(self.0, boxes, held, old, new)
    }

    #[inline(always)]
    fn inside<const N: usize>(self, outer: &[KeyBox; N], inner: &[KeyBox; N]) -> u32 {
        let (Some(outer), Some(inner)) = (outer.first_chunk(), inner.first_chunk()) else { return 0 };
        encode::inside(self.0, outer, inner)
    }

    #[inline(always)]
    fn predicted<const N: usize>(
        self,
        now: &[KeyBox; N],
        old: &[KeyBox; N],
        margins: &[f32; N],
        predicts: bool,
        made: &mut [KeyBox; N],
    ) {
        let (Some(now), Some(old)) = (now.first_chunk(), old.first_chunk()) else { return };
        let (Some(margins), Some(made)) = (margins.first_chunk(), made.first_chunk_mut()) else { return };
        encode::predicted(self.0, now, old, margins, predicts, made);
    }

    #[inline(always)]
    fn above(self, a: W::Vector, b: W::Vector) -> u32 {
        self.0.bits8(self.0.above32(a, b))
    }

    #[inline(always)]
    fn overlap(self, a: &KeyBox, b: &KeyBox) -> bool {
        overlaps::overlap(self.0, a, b)
    }

    #[inline(always)]
    fn overlaps<I: Index>(self, boxes: &[KeyBox], pairs: &[Pair<I>]) -> usize {
        let (eights, rest) = pairs.as_chunks();
        // Boxes are read with what is behind them, which the last one has not. Asked once for all pairs,
        // since a branch for each eight takes half as long again as the tests.
        let mut most = 0;
        if W::TESTS_SOME_PAIRS {
            for slot in eights.as_flattened().as_flattened() {
                most = most.max(slot.slot());
            }
        }
        if !W::TESTS_SOME_PAIRS || most as usize + 1 >= boxes.len() {
            return each_overlap(self, boxes, pairs);
        }
        let mut bits = 0;
        for (index, eight) in eights.iter().enumerate() {
            // SAFETY: behind the box of each slot there is another one.
            bits |= (unsafe { overlaps::eight_overlap(self.0, boxes, eight) } as usize) << (8 * index);
        }
        if rest.is_empty() { bits } else { bits | each_overlap(self, boxes, rest) << (8 * eights.len()) }
    }

    #[inline(always)]
    fn axis(self, axis: usize) -> [HalfOf<W>; 2] {
        [high_bytes(self.0, row_lanes(axis)), high_bytes(self.0, query_lanes(axis))]
    }

    #[inline(always)]
    fn row(self, [row, _]: [HalfOf<W>; 2], record: &Record) -> Row {
        let h = self.0.half();
        (!h.first(h.shuffle(h.load(bytemuck::cast_ref(record)), row))).to_le_bytes()
    }

    #[inline(always)]
    fn query(self, [_, query]: [HalfOf<W>; 2], record: &Record) -> W::Vector {
        let h = self.0.half();
        let query = h.shuffle(h.load(bytemuck::cast_ref(record)), query);
        self.0.joined(query, query)
    }

    #[inline(always)]
    fn window(self, rows: &[Row; WINDOW], count: usize, query: W::Vector) -> u64 {
        self.0.window(rows, count, query)
    }

    #[inline(always)]
    fn four<I: Index>(self, sorted: &[Record], base: u32, bits: u64, to: &mut [Pair<I>; 4]) -> Option<usize> {
        fours::four(self.0, sorted, base, bits, to)
    }

    #[inline(always)]
    fn any_four<I: Index>(
        self,
        sorted: &[Record],
        candidates: &[u32; 4],
        pairs: &mut [Pair<I>; 4],
    ) -> Option<usize> {
        fours::any_four(self.0, sorted, candidates, pairs)
    }

    #[inline(always)]
    fn contact(self, a: &Record, b: &Record) -> Contact {
        let h = self.0.half();
        let a = h.load(bytemuck::cast_ref(a));
        let limit = fours::limit(h, h.load(bytemuck::cast_ref(b)), h.load(&fours::HALVES));
        Contact { touches: !h.any_of_three(h.excess16(a, limit)), tied: h.any_of_three(h.equal16(a, limit)) }
    }

    #[inline(always)]
    fn touching(self, records: &[Record; EIGHT], limit: Record) -> u32 {
        let w = self.0;
        let limit = w.both(bytemuck::cast_ref(&limit));
        let [a, b, c, d] = casts::eight(w, records);
        let (a, b) = (w.excess16(a, limit), w.excess16(b, limit));
        let (c, d) = (w.excess16(c, limit), w.excess16(d, limit));
        // A word for each record, zero if it touches.
        let apart = w.join16(w.join16(a, b), w.join16(c, d));
        w.bits8(w.equal32(apart, w.splat(0)))
    }

    #[inline(always)]
    fn enter(self, walk: &Walk, nodes: [&KeyBox; 2], until: f32) -> [f32; 2] {
        casts::enter(self.0, walk, nodes, until)
    }

    #[inline(always)]
    fn met(self, records: &[Record; EIGHT], crossing: &Crossing) -> ([f32; EIGHT], u32) {
        casts::met(self.0, records, crossing)
    }

    #[inline(always)]
    fn record(self, frame: &Frame, keys: W::Vector, tag: u32) -> Record {
        let (w, h) = (self.0, self.0.half());
        // The first three numbers of their rows.
        let sides = w.shuffle(keys, w.pick(&places([0, 1, 2, 3]), &places([1, 2, 3, 0])));
        let [[origin, _], [scale, _]]: [&[[u8; 16]; 2]; 2] =
            [&frame.origin, &frame.scale].map(bytemuck::cast_ref);
        let at = w.multiply(w.subtract(w.floats(sides), w.both(origin)), w.both(scale));
        let [minima, maxima] = w.split(at);
        let lanes = h.shuffle(h.steps16(minima, maxima), h.load(&SIX_LANES));
        // Maxima are complemented. The tag's place is zero.
        let mut bytes = [0; 16];
        h.store(&mut bytes, h.xor(lanes, h.words([0, 0xffff_0000, u32::MAX, tag])));
        bytemuck::cast(bytes)
    }
}
