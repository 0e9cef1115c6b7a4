//! Tests four candidates at a time, with 128-bit vectors.

use super::vectors::{NO_BYTE, Vectors};
use crate::geometry::record::Record;
use crate::id::{Index, Pair};

/// The bytes of a record with the halves of its six lanes swapped, and no tag.
const HALVES: [u8; 16] = [6, 7, 8, 9, 10, 11, 0, 1, 2, 3, 4, 5, NO_BYTE, NO_BYTE, NO_BYTE, NO_BYTE];

/// For each mask of four words: the places of those that it keeps, in order.
pub(super) const KEPT: [[u8; 16]; 16] = {
    let mut table = [[0; 16]; 16];
    let mut mask = 0;
    while mask < 16 {
        let (mut word, mut kept) = (0, 0);
        while word < 4 {
            if mask >> word & 1 != 0 {
                let mut byte = 0;
                while byte < 4 {
                    table[mask][4 * kept + byte] = (4 * word + byte) as u8;
                    byte += 1;
                }
                kept += 1;
            }
            word += 1;
        }
        mask += 1;
    }
    table
};

/// What the lanes of another record must not exceed to touch this one: its maxima, then its complemented minima. The
/// tag's lanes exclude nothing.
#[inline(always)]
pub(super) fn limit<V: Vectors>(v: V, record: V::Vector) -> V::Vector {
    v.xor(v.shuffle(record, v.load(&HALVES)), v.splat(u32::MAX))
}

/// As [`Simd::four`](crate::simd::Simd::four).
#[inline(always)]
pub(super) fn four<V: Vectors, I: Index>(
    v: V,
    sorted: &[Record],
    base: u32,
    bits: u64,
    pairs: &mut [Pair<I>; 4],
) -> Option<usize> {
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
    let (record, partners) = unsafe {
        (
            pick(v, sorted, at),
            [pick(v, sorted, p), pick(v, sorted, q), pick(v, sorted, r), pick(v, sorted, s)],
        )
    };
    let tag = v.zip_last64(v.zip_last32(record, record), v.zip_last32(record, record));
    keep(v, partners, [limit(v, record); 4], tag, pairs)
}

/// As [`Simd::any_four`](crate::simd::Simd::any_four).
#[inline(always)]
pub(super) fn any_four<V: Vectors, I: Index>(
    v: V,
    sorted: &[Record],
    candidates: &[u32; 4],
    pairs: &mut [Pair<I>; 4],
) -> Option<usize> {
    let [mut firsts, mut seconds] = [[v.splat(0); 4]; 2];
    for (k, candidate) in candidates.iter().enumerate() {
        firsts[k] = v.load(bytemuck::cast_ref(sorted.get((candidate >> 16) as usize)?));
        seconds[k] = v.load(bytemuck::cast_ref(sorted.get((candidate & 0xffff) as usize)?));
    }
    let [a, b, c, d] = firsts;
    let limits = [limit(v, a), limit(v, b), limit(v, c), limit(v, d)];
    keep(v, seconds, limits, tags(v, firsts), pairs)
}

/// A record.
///
/// # Safety
/// The position must be in the slice.
#[inline(always)]
unsafe fn pick<V: Vectors>(v: V, records: &[Record], at: u32) -> V::Vector {
    // SAFETY: the caller vouches for the position.
    v.load(bytemuck::cast_ref(unsafe { records.get_unchecked(at as usize) }))
}

/// The tags of four records.
#[inline(always)]
fn tags<V: Vectors>(v: V, [a, b, c, d]: [V::Vector; 4]) -> V::Vector {
    v.zip_last64(v.zip_last32(a, b), v.zip_last32(c, d))
}

/// Writes the pairs of four records with those of the limits and tags, as far as they touch, and returns how many do.
/// `None` if only the keys can decide one of the four.
#[inline(always)]
fn keep<V: Vectors, I: Index>(
    v: V,
    records: [V::Vector; 4],
    [p, q, r, s]: [V::Vector; 4],
    others: V::Vector,
    pairs: &mut [Pair<I>; 4],
) -> Option<usize> {
    let [a, b, c, d] = records;
    let ties = v.or(v.or(v.equal16(a, p), v.equal16(b, q)), v.or(v.equal16(c, r), v.equal16(d, s)));
    // Those of the tags do not count.
    if v.any_of_three(ties) {
        return None;
    }
    let (first, second) = (v.excess16(a, p), v.excess16(b, q));
    let (third, fourth) = (v.excess16(c, r), v.excess16(d, s));
    // A word for each record, zero if it touches.
    let apart = v.join16(v.join16(first, second), v.join16(third, fourth));
    let tags = tags(v, records);
    let shared = v.and(v.and(tags, others), v.splat(Record::MARKS));
    let (kept, count) = v.counted4(v.equal32(v.or(apart, shared), v.splat(0)));
    let slots = v.splat(Record::SLOT);
    let (tags, others) = (v.and(tags, slots), v.and(others, slots));
    let (lower, upper) = (v.least32(tags, others), v.most32(tags, others));
    let places = v.load(&KEPT[kept as usize & 15]);
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(pairs);
    if size_of::<I>() == 2 {
        let packed = v.shuffle(v.or(lower, v.raised32(upper)), places);
        v.store(bytes.first_chunk_mut()?, packed);
    } else {
        let (lower, upper) = (v.shuffle(lower, places), v.shuffle(upper, places));
        v.store(bytes.first_chunk_mut()?, v.zip_first32(lower, upper));
        v.store(bytes.last_chunk_mut()?, v.zip_last32(lower, upper));
    }
    Some(count as usize)
}
