//! Tests four candidates at a time.

use super::operations::{Half, Halves, NO_BYTE, Vectors, kept, places};
use crate::geometry::record::Record;
use crate::id::{Index, Pair};

/// The bytes of a record with the halves of its six lanes swapped, and its tag.
pub(super) const HALVES: [u8; 16] = [6, 7, 8, 9, 10, 11, 0, 1, 2, 3, 4, 5, 12, 13, 14, 15];

/// The places of the lower halves of words, raised above zeros.
const RAISED: [u8; 16] =
    [NO_BYTE, NO_BYTE, 0, 1, NO_BYTE, NO_BYTE, 4, 5, NO_BYTE, NO_BYTE, 8, 9, NO_BYTE, NO_BYTE, 12, 13];

/// The places of the bytes that a mask of four keeps.
pub(super) const KEPT: [[u8; 16]; 16] = kept();

/// What the lanes of other records must not exceed to touch these: the maxima, then the complemented minima;
/// and the tags as they are.
#[inline(always)]
pub(super) fn limit<V: Vectors>(v: V, records: V::Vector, halves: V::Vector) -> V::Vector {
    v.xor(v.shuffle(records, halves), v.words([u32::MAX, u32::MAX, u32::MAX, 0]))
}

/// Two records.
///
/// # Safety
/// The positions must be in the slice.
#[inline(always)]
pub(super) unsafe fn pick<W: Halves>(w: W, records: &[Record], a: u32, b: u32) -> W::Vector {
    // SAFETY: the caller vouches for the positions.
    let (a, b) = unsafe { (records.get_unchecked(a as usize), records.get_unchecked(b as usize)) };
    w.pick(bytemuck::cast_ref(a), bytemuck::cast_ref(b))
}

/// By how much two records exceed the limits of two others, and the marks that they share: zero in the eight
/// bytes of a pair that is reported here.
#[inline(always)]
fn excess<W: Halves>(w: W, records: W::Vector, limit: W::Vector) -> W::Vector {
    let shared = w.and(w.and(records, limit), w.splat(Record::MARKS));
    w.select(w.words([u32::MAX, u32::MAX, u32::MAX, 0]), w.excess16(records, limit), shared)
}

/// Writes the pairs of four records, of which the first and the third come together, with those of the
/// limits, as far as they touch, and returns how many do. `None` if only the keys can decide one of the four.
#[inline(always)]
pub(super) fn keep<W: Halves, I: Index>(
    w: W,
    [a, b]: [W::Vector; 2],
    [first, second]: [W::Vector; 2],
    pairs: &mut [Pair<I>; 4],
) -> Option<usize> {
    // Ties of the tags do not count.
    if w.any_of_three(w.or(w.equal16(a, first), w.equal16(b, second))) {
        return None;
    }
    let kept = w.zeros64(w.join16(excess(w, a, first), excess(w, b, second)));
    // The tags of both records.
    let tags = w.zip_last64(w.zip_last32(a, first), w.zip_last32(b, second));
    let slots = w.and(tags, w.splat(Record::SLOT));
    let crossed = w.shuffle(slots, w.both(&places([1, 0, 3, 2])));
    let upper = w.upper32(slots, crossed);
    let lower = w.xor(w.xor(slots, crossed), upper);
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(pairs);
    if size_of::<I>() == 2 {
        let (h, [a, b]) = (w.half(), w.split(w.or(lower, w.shuffle(upper, w.both(&RAISED)))));
        let places = h.load(&KEPT[kept as usize & 15]);
        h.store(bytes.first_chunk_mut()?, h.shuffle(h.even32(a, b), places));
    } else {
        let second = w.words([0, u32::MAX, 0, u32::MAX]);
        w.kept64(w.select(second, upper, lower), kept, bytes.as_chunks_mut().0.first_chunk_mut()?);
    }
    Some(kept.count_ones() as usize)
}
