//! The level of some vectors, whatever the instruction set.

use super::encode::{OUTWARDS, OWNERS, above, numbers, outside, put_three, second, smallest, three, zeros};
use super::fours::{HALVES, keep, limit, pick};
use super::operations::{Half, HalfOf, Halves, NO_BYTE, Vectors, ends, operations, places};
use super::overlaps::eight_overlap;
use crate::geometry::boxes::Boxes;
use crate::geometry::key::{AHEAD, AROUND, KeyBox, KeyFour, POSITIVE_INFINITY, SHORTEST};
use crate::geometry::line::{Crossing, Walk};
use crate::geometry::record::{Frame, Record};
use crate::id::{Index, Pair};
use crate::simd::{Contact, EIGHT, Row, Simd, each_overlap, query_lanes, row_lanes};

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

/// Eight records, of which each half has four consecutive ones.
#[inline(always)]
fn eight<W: Halves>(w: W, records: &[Record; EIGHT]) -> [W::Vector; 4] {
    let [a, b, c, d, e, f, g, h]: &[[u8; 16]; EIGHT] = bytemuck::cast_ref(records);
    [w.pick(a, e), w.pick(b, f), w.pick(c, g), w.pick(d, h)]
}

/// The places of the six lanes of a record, of which the maxima stand in the last half.
const SIX_LANES: [u8; 16] = [0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 12, 13, NO_BYTE, NO_BYTE, NO_BYTE, NO_BYTE];

impl<W: Halves> Simd for Level<W> {
    type Keys = W::Vector;

    type Axis = [HalfOf<W>; 2];

    type Query = W::Vector;

    const ENCODES_FOUR: bool = true;

    const MORE_CODE: bool = W::MORE_CODE;

    #[inline(always)]
    fn call<R>(self, work: impl FnOnce() -> R) -> R {
        self.0.call(work)
    }

    operations! { |this|
        keys(bounds: &KeyBox) -> W::Vector = this.0.sides(bounds);
        above(a: W::Vector, b: W::Vector) -> u32 = this.0.six(this.0.above32(a, b));
        axis(axis: usize) -> [HalfOf<W>; 2] =
            [high_bytes(this.0, row_lanes(axis)), high_bytes(this.0, query_lanes(axis))];
    }

    #[inline(always)]
    fn window<const N: usize>(self, rows: &[Row; N], count: usize, query: W::Vector) -> u64 {
        self.0.window(rows, count, query)
    }

    #[inline(always)]
    fn encode_four(
        self,
        boxes: Boxes<'_>,
        held: Option<&KeyFour>,
        old: &KeyFour,
        new: &mut KeyFour,
    ) -> Option<u32> {
        let w = self.0;
        let [a, b, c] = numbers(w, boxes)?;
        let (infinity, magnitude) = (w.splat(POSITIVE_INFINITY as u32), w.splat(i32::MAX as u32));
        let largest = w.upper32(w.upper32(w.and(a, magnitude), w.and(b, magnitude)), w.and(c, magnitude));
        let (a, b, c) = (w.keys(a), w.keys(b), w.keys(c));
        let [old_a, old_b, old_c] = three(w, bytemuck::cast_ref(old));
        // The minima and the maxima of the first box, then of the second one. Nothing behind them counts.
        let first = above(w, a, w.fourth_on(a, b));
        let [minima, maxima] = second(w, b, c);
        let second = above(w, minima, maxima);
        let upside_down = w.and(w.or(first, second), w.words([u32::MAX, u32::MAX, u32::MAX, 0]));
        // No key of an object is above +infinity, but the first one of an empty box is.
        let empty = above(w, w.upper32(old_a, old_b), infinity);
        // Bounds hold no NaN either.
        let beyond = match held {
            Some(held) => {
                let [a, b, c] = outside(w, [a, b, c], held);
                w.or(w.or(a, b), c)
            }
            None => above(w, largest, infinity),
        };
        if w.any(w.or(w.or(upside_down, empty), beyond)) {
            return None;
        }
        put_three(w, [a, b, c], new);
        Some(!zeros(w, [w.xor(a, old_a), w.xor(b, old_b), w.xor(c, old_c)]) & 0b1111)
    }

    #[inline(always)]
    fn inside<const N: usize>(self, outer: &[KeyBox; N], inner: &[KeyBox; N]) -> u32 {
        let (Some(outer), Some(inner)) = (outer.first_chunk(), inner.first_chunk::<4>()) else { return 0 };
        let w = self.0;
        zeros(w, outside(w, three(w, bytemuck::cast_ref(inner)), outer)) & 0b1111
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
        let (Some(now), Some(old)) = (now.first_chunk::<4>(), old.first_chunk::<4>()) else { return };
        let (Some(margins), Some(made)) = (margins.first_chunk::<4>(), made.first_chunk_mut()) else {
            return;
        };
        let w = self.0;
        let (now, old) = (three(w, bytemuck::cast_ref(now)), three(w, bytemuck::cast_ref(old)));
        let (shortest, most) = (w.splat(SHORTEST.to_bits()), w.splat(f32::MAX.to_bits()));
        let [a, b, c] = now;
        let floats = [w.floats(a), w.floats(b), w.floats(c)];
        // No motion is at most zero and at least the shortest one.
        let size = if predicts { smallest(w, floats) } else { w.splat(0) };
        let margins = w.shuffle(
            w.both(bytemuck::cast_ref(margins)),
            w.pick(&places([0, 1, 0, 1]), &places([2, 3, 2, 3])),
        );
        let around = w.maximum(w.multiply(size, w.splat(AROUND.to_bits())), margins);
        let around = w.and(w.at_most(shortest, around), around);
        let mut to = now;
        for k in 0..3 {
            let (owners, outwards) = (w.both(&places(OWNERS[k])), w.words(OUTWARDS[k]));
            let (size, around) = (w.shuffle(size, owners), w.shuffle(around, owners));
            let now = w.xor(floats[k], w.and(outwards, w.splat(1 << 31)));
            let step = w.subtract(now, w.floats(w.turned(old[k], outwards)));
            let goes_on = w.and(w.at_most(shortest, step), w.at_most(step, size));
            let ahead = w.and(goes_on, w.multiply(step, w.splat(AHEAD.to_bits())));
            let moved = w.minimum(w.add(now, w.add(ahead, around)), most);
            let side = w.upper32(w.keys(moved), w.turned(to[k], outwards));
            to[k] = w.turned(side, outwards);
        }
        put_three(w, to, made);
    }

    #[inline(always)]
    fn overlap(self, a: &KeyBox, b: &KeyBox) -> bool {
        let (w, [a_min, a_max], [b_min, b_max]) = (self.0, ends(a), ends(b));
        // The minima of both; one number, then the maxima of the other one, which they must not exceed.
        let (minima, maxima) = (w.pick(a_min, b_min), w.pick(b_max, a_max));
        let maxima = w.shuffle(maxima, w.both(&places([1, 2, 3, 0])));
        !w.any_of_three(w.above32(minima, maxima))
    }

    #[inline(always)]
    fn overlaps<I: Index>(self, boxes: &[KeyBox], pairs: &[Pair<I>]) -> usize {
        let (eights, rest) = pairs.as_chunks();
        // Boxes are read with what is behind them, which the last one has not. Asked once for all pairs,
        // since a branch for each eight takes half as long again as the tests.
        let mut most = 0;
        if W::MORE_CODE {
            for slot in eights.as_flattened().as_flattened() {
                most = most.max(slot.slot());
            }
        }
        if !W::MORE_CODE || most as usize + 1 >= boxes.len() {
            return each_overlap(self, boxes, pairs);
        }
        let mut bits = 0;
        for (index, eight) in eights.iter().enumerate() {
            // SAFETY: behind the box of each slot there is another one.
            bits |= (unsafe { eight_overlap(self.0, boxes, eight) } as usize) << (8 * index);
        }
        if rest.is_empty() { bits } else { bits | each_overlap(self, boxes, rest) << (8 * eights.len()) }
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
    fn four<I: Index>(self, sorted: &[Record], base: u32, bits: u64, to: &mut [Pair<I>; 4]) -> Option<usize> {
        let w = self.0;
        let second = bits & bits.wrapping_sub(1);
        let third = second & second.wrapping_sub(1);
        let fourth = third & third.wrapping_sub(1);
        let first = base & 0xffff;
        let (p, q) = (first + bits.trailing_zeros(), first + second.trailing_zeros());
        let (r, s) = (first + third.trailing_zeros(), first + fourth.trailing_zeros());
        let at = base >> 16;
        if at.max(s) as usize >= sorted.len() {
            return None;
        }
        // SAFETY: the positions of the bits ascend, and the last one is in the slice, as is `at`.
        unsafe {
            let limit = limit(w, pick(w, sorted, at, at), w.both(&HALVES));
            keep(w, [pick(w, sorted, p, r), pick(w, sorted, q, s)], [limit, limit], to)
        }
    }

    #[inline(always)]
    fn any_four<I: Index>(
        self,
        sorted: &[Record],
        candidates: &[u32; 4],
        pairs: &mut [Pair<I>; 4],
    ) -> Option<usize> {
        let (w, h) = (self.0, self.0.half());
        let last = u32::from(u16::try_from(sorted.len().checked_sub(1)?).unwrap_or(u16::MAX));
        // All halves of the candidates are compared with the last position before they are taken for positions.
        if h.any(h.excess16(h.load(bytemuck::cast_ref(candidates)), h.splat(last << 16 | last))) {
            return None;
        }
        let [p, q, r, s] = *candidates;
        // SAFETY: the positions are in the slice.
        unsafe {
            let (a, b) = (pick(w, sorted, p >> 16, r >> 16), pick(w, sorted, q >> 16, s >> 16));
            let (c, d) = (pick(w, sorted, p & 0xffff, r & 0xffff), pick(w, sorted, q & 0xffff, s & 0xffff));
            let halves = w.both(&HALVES);
            keep(w, [a, b], [limit(w, c, halves), limit(w, d, halves)], pairs)
        }
    }

    #[inline(always)]
    fn contact(self, a: &Record, b: &Record) -> Contact {
        let h = self.0.half();
        let a = h.load(bytemuck::cast_ref(a));
        let limit = limit(h, h.load(bytemuck::cast_ref(b)), h.load(&HALVES));
        Contact { touches: !h.any_of_three(h.excess16(a, limit)), tied: h.any_of_three(h.equal16(a, limit)) }
    }

    #[inline(always)]
    fn touching(self, records: &[Record; EIGHT], limit: Record) -> u32 {
        let w = self.0;
        let limit = w.both(bytemuck::cast_ref(&limit));
        let [a, b, c, d] = eight(w, records);
        let (a, b) = (w.excess16(a, limit), w.excess16(b, limit));
        let (c, d) = (w.excess16(c, limit), w.excess16(d, limit));
        // A word for each record, zero if it touches.
        let apart = w.join16(w.join16(a, b), w.join16(c, d));
        w.bits8(w.equal32(apart, w.splat(0)))
    }

    #[inline(always)]
    fn enter(self, walk: &Walk, [a, b]: [&KeyBox; 2], until: f32) -> [f32; 2] {
        // A node in each half.
        let (w, [a_low, a_high], [b_low, b_high]) = (self.0, ends(a), ends(b));
        // The low sides and one more; one, then the high sides.
        let (low, high) = (w.pick(a_low, b_low), w.pick(a_high, b_high));
        let high = w.shuffle(high, w.both(&places([1, 2, 3, 3])));
        let (low, high) = (w.floats(low), w.floats(high));
        let back = w.both(bytemuck::cast_ref(&walk.back));
        let (first, last) = (w.both(bytemuck::cast_ref(&walk.first)), w.both(bytemuck::cast_ref(&walk.last)));
        let (come, leave) = (w.both(bytemuck::cast_ref(&walk.come)), w.both(bytemuck::cast_ref(&walk.leave)));
        let come = w.multiply(w.subtract(w.select(back, high, low), first), come);
        let leave = w.multiply(w.subtract(w.select(back, low, high), last), leave);
        // NaN falls to the second operand.
        let (from, to) = (w.maximum(come, w.splat(0)), w.minimum(leave, w.splat(until.to_bits())));
        // The first lane also takes the second and the third one.
        let (second, third) = (w.both(&places([1; 4])), w.both(&places([2; 4])));
        let from = w.maximum(w.maximum(from, w.shuffle(from, second)), w.shuffle(from, third));
        let to = w.minimum(w.minimum(to, w.shuffle(to, second)), w.shuffle(to, third));
        let met = w.at_most(from, w.add(to, w.splat(Walk::LEAST.to_bits())));
        let from = w.select(met, from, w.splat(f32::NAN.to_bits()));
        let [a, b] = w.split(from);
        [f32::from_bits(w.half().first(a)), f32::from_bits(w.half().first(b))]
    }

    #[inline(always)]
    fn met(self, records: &[Record; EIGHT], crossing: &Crossing) -> ([f32; EIGHT], u32) {
        let w = self.0;
        let order = w.both(&crossing.order);
        let [a, b, c, d] = eight(w, records);
        let (a, b) = (w.shuffle(a, order), w.shuffle(b, order));
        let (c, d) = (w.shuffle(c, order), w.shuffle(d, order));
        // Lanes of two records, then of four: two lanes in each vector.
        let (ab, cd) = (w.zip_first16(a, b), w.zip_first16(c, d));
        let (first, second) = (w.zip_first32(ab, cd), w.zip_last32(ab, cd));
        let third = w.zip_first32(w.zip_last16(a, b), w.zip_last16(c, d));
        let zero = w.splat(0);
        let (mut from, mut to) = (zero, w.splat(crossing.until.to_bits()));
        for (pair, lanes) in [first, second, third].into_iter().enumerate() {
            // A float that has the lane as its lower half; NaN for a lane of zero.
            let upper = w.or(w.equal16(lanes, zero), w.splat(0x4b00_4b00));
            for (k, x) in
                [(2 * pair, w.zip_first16(lanes, upper)), (2 * pair + 1, w.zip_last16(lanes, upper))]
            {
                let (scale, offset) =
                    (w.splat(crossing.scale[k].to_bits()), w.splat(crossing.offset[k].to_bits()));
                let time = w.add(w.multiply(x, scale), offset);
                // NaN falls to the second operand.
                if k < 3 {
                    from = w.maximum(time, from);
                } else {
                    to = w.minimum(time, to);
                }
            }
        }
        let from = w.minimum(from, w.splat(Crossing::LATEST.to_bits()));
        let (met, mut times) = (w.at_most(from, to), [[0; 16]; 2]);
        let [first, last] = &mut times;
        w.put(first, last, w.select(met, from, w.splat(f32::NAN.to_bits())));
        (bytemuck::cast(times), w.bits8(met))
    }

    #[inline(always)]
    fn record(self, frame: &Frame, keys: W::Vector, tag: u32) -> Record {
        let (w, h) = (self.0, self.0.half());
        // The first three numbers of their rows.
        let [[origin, _], [scale, _]]: [&[[u8; 16]; 2]; 2] =
            [&frame.origin, &frame.scale].map(bytemuck::cast_ref);
        let at = w.multiply(w.subtract(w.floats(w.halved(keys)), w.both(origin)), w.both(scale));
        let lanes = h.shuffle(w.steps16(at), h.load(&SIX_LANES));
        // Maxima are complemented. The tag's place is zero.
        let mut bytes = [0; 16];
        h.store(&mut bytes, h.xor(lanes, h.words([0, 0xffff_0000, u32::MAX, tag])));
        bytemuck::cast(bytes)
    }
}
