//! The level of 128-bit vectors, whatever the instruction set.

use super::keys::Keys;
use super::vectors::Vectors;
use super::{casts, encode, fours, overlaps};
use crate::geometry::boxes::Four;
use crate::geometry::key::KeyBox;
use crate::geometry::line::{Crossing, Slabs, Walk};
use crate::geometry::record::{Frame, Record};
use crate::id::{Index, Pair};
use crate::simd::{Contact, EIGHT, Row, Simd, WINDOW, query_lanes, row_lanes};

/// The level of some vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Narrow<V>(pub(crate) V);

/// Bits below a count.
#[inline(always)]
const fn below(count: usize) -> u64 {
    if count >= WINDOW { u64::MAX } else { !(u64::MAX << count) }
}

/// Which of 16 rows have no byte below the query's, as a mask.
#[inline(always)]
fn inside<V: Vectors>(v: V, [a, b, c, d]: &[[u8; 16]; 4], query: V::Vector) -> V::Vector {
    v.reached([v.load(a), v.load(b), v.load(c), v.load(d)], query)
}

/// The places of the high bytes of four lanes, four times.
#[inline(always)]
fn high_bytes<V: Vectors>(v: V, lanes: [usize; 4]) -> V::Vector {
    v.splat(u32::from_le_bytes(lanes.map(|lane| 2 * lane as u8 + 1)))
}

impl<V: Vectors> Simd for Narrow<V> {
    type Keys = Keys<V>;

    type Axis = [V::Vector; 2];

    type Query = V::Vector;

    const ENCODES_FOUR: bool = true;

    const TESTS_SOME_PAIRS: bool = V::TESTS_SOME_PAIRS;

    #[inline(always)]
    fn call<R>(self, work: impl FnOnce() -> R) -> R {
        self.0.call(work)
    }

    #[inline(always)]
    fn keys(self, bounds: &KeyBox) -> Keys<V> {
        Keys::load(self.0, bounds)
    }

    #[inline(always)]
    fn bounds(self, keys: Keys<V>) -> KeyBox {
        keys.bounds(self.0)
    }

    #[inline(always)]
    fn encode(self, min: &[u8; 12], max: &[u8; 12]) -> Option<Keys<V>> {
        Keys::encode(self.0, min, max)
    }

    #[inline(always)]
    fn encode_four(
        self,
        boxes: Four<'_>,
        held: &[KeyBox; 4],
        old: &[KeyBox; 4],
        new: &mut [KeyBox; 4],
    ) -> Option<u32> {
        encode::encode_four(self.0, boxes, held, old, new)
    }

    #[inline(always)]
    fn above(self, a: Keys<V>, b: Keys<V>) -> u32 {
        let v = self.0;
        v.bits6([v.above32(a.first, b.first), v.above32(a.last, b.last)])
    }

    #[inline(always)]
    fn overlap(self, a: &KeyBox, b: &KeyBox) -> bool {
        self.keys(a).overlap(self.0, self.keys(b))
    }

    #[inline(always)]
    unsafe fn eight_overlap<I: Index>(self, boxes: &[KeyBox], pairs: &[Pair<I>; 8]) -> u32 {
        let ([first, last], _) = pairs.as_chunks() else { return 0 };
        // SAFETY: the caller vouches for the slots.
        unsafe {
            overlaps::four_overlap(self.0, boxes, first) | overlaps::four_overlap(self.0, boxes, last) << 4
        }
    }

    #[inline(always)]
    fn prefetch<T>(self, items: &[T], index: usize) {
        self.0.prefetch(items, index);
    }

    #[inline(always)]
    fn same(self, a: Keys<V>, b: Keys<V>) -> bool {
        let v = self.0;
        !v.any(v.or(v.xor(a.first, b.first), v.xor(a.last, b.last)))
    }

    #[inline(always)]
    fn lower(self, a: Keys<V>, b: Keys<V>) -> Keys<V> {
        let v = self.0;
        Keys { first: v.lower32(a.first, b.first), last: v.lower32(a.last, b.last) }
    }

    #[inline(always)]
    fn upper(self, a: Keys<V>, b: Keys<V>) -> Keys<V> {
        let v = self.0;
        Keys { first: v.upper32(a.first, b.first), last: v.upper32(a.last, b.last) }
    }

    #[inline(always)]
    fn narrow(self, keys: Keys<V>) -> bool {
        keys.is_narrow(self.0)
    }

    #[inline(always)]
    fn axis(self, axis: usize) -> [V::Vector; 2] {
        [high_bytes(self.0, row_lanes(axis)), high_bytes(self.0, query_lanes(axis))]
    }

    #[inline(always)]
    fn row(self, [row, _]: [V::Vector; 2], record: &Record) -> Row {
        let v = self.0;
        (!v.first(v.shuffle(v.load(bytemuck::cast_ref(record)), row))).to_le_bytes()
    }

    #[inline(always)]
    fn query(self, [_, query]: [V::Vector; 2], record: &Record) -> V::Vector {
        let v = self.0;
        v.shuffle(v.load(bytemuck::cast_ref(record)), query)
    }

    #[inline(always)]
    fn window(self, rows: &[Row; WINDOW], count: usize, query: V::Vector) -> u64 {
        let v = self.0;
        let [a, b, c, d]: &[[[u8; 16]; 4]; 4] = bytemuck::cast_ref(rows);
        let (a, b) = (inside(v, a, query), inside(v, b, query));
        v.bits64([a, b, inside(v, c, query), inside(v, d, query)]) & below(count)
    }

    #[inline(always)]
    fn four<I: Index>(
        self,
        sorted: &[Record],
        base: u32,
        bits: u64,
        pairs: &mut [Pair<I>; 4],
    ) -> Option<usize> {
        fours::four(self.0, sorted, base, bits, pairs)
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
        let v = self.0;
        let a = v.load(bytemuck::cast_ref(a));
        let limit = fours::limit(v, v.load(bytemuck::cast_ref(b)));
        Contact { touches: !v.any(v.excess16(a, limit)), tied: v.any_of_three(v.equal16(a, limit)) }
    }

    #[inline(always)]
    fn touching(self, records: &[Record; EIGHT], limit: Record) -> u32 {
        let v = self.0;
        let limit = v.load(bytemuck::cast_ref(&limit));
        let mut excess = [limit; EIGHT];
        for (excess, record) in excess.iter_mut().zip(records) {
            *excess = v.excess16(v.load(bytemuck::cast_ref(record)), limit);
        }
        let [a, b, c, d, e, f, g, h] = excess;
        let first = v.join16(v.join16(a, b), v.join16(c, d));
        let last = v.join16(v.join16(e, f), v.join16(g, h));
        // 16 bits for each record, zero if it touches.
        let apart = v.join16(first, last);
        v.bits16(v.equal8(v.join8(apart, apart), v.splat(0))) & 0xff
    }

    #[inline(always)]
    fn span(self, slabs: &Slabs, min: [i32; 4], max: [i32; 4], far: f64) -> (f64, f64) {
        // Vectors of two numbers would gain nothing on three axes.
        slabs.span(min, max, far)
    }

    #[inline(always)]
    fn enter(self, walk: &Walk, [a, b]: [&KeyBox; 2], until: f32) -> [f32; 2] {
        [casts::enter(self.0, walk, a, until), casts::enter(self.0, walk, b, until)]
    }

    #[inline(always)]
    fn crossed(self, records: &[Record; EIGHT], crossing: &Crossing) -> u32 {
        let (_, [first, last]) = casts::met(self.0, records, crossing);
        self.0.bits4(first) | self.0.bits4(last) << 4
    }

    #[inline(always)]
    fn met(self, records: &[Record; EIGHT], crossing: &Crossing) -> [f32; EIGHT] {
        let v = self.0;
        let (times, met) = casts::met(v, records, crossing);
        let never = v.splat(f32::NAN.to_bits());
        let mut bytes = [[0; 16]; 2];
        v.store(&mut bytes[0], v.select(met[0], times[0], never));
        v.store(&mut bytes[1], v.select(met[1], times[1], never));
        bytemuck::cast(bytes)
    }

    #[inline(always)]
    fn pop_min(self, numbers: &mut [u32; EIGHT]) -> u32 {
        let v = self.0;
        let [first, last]: &mut [[u8; 16]; 2] = bytemuck::cast_mut(numbers);
        let (a, b) = (v.load(first), v.load(last));
        let least = v.least32(a, b);
        let least = v.least32(least, v.zip_last64(least, least));
        // The two that are left, each twice.
        let least = v.zip_first32(least, least);
        let least = v.least32(v.zip_first64(least, least), v.zip_last64(least, least));
        v.store(first, v.or(a, v.equal32(a, least)));
        v.store(last, v.or(b, v.equal32(b, least)));
        v.first(least)
    }

    #[inline(always)]
    fn record(self, frame: &Frame, keys: Keys<V>, tag: u32) -> Record {
        keys.record(self.0, frame, tag)
    }
}
