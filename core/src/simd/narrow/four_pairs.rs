//! Tests and divides four pairs at a time, with 128-bit vectors.

use super::fours::KEPT;
use super::vectors::Vectors;
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::simd::{Simd, each_overlap};

/// For each mask of four words: the places of those that it has not, the first one last.
const BACK: [[u8; 16]; 16] = {
    let mut table = [[0; 16]; 16];
    let mut mask = 0;
    while mask < 16 {
        let (mut word, mut place) = (0, 16);
        while word < 4 {
            if mask >> word & 1 == 0 {
                place -= 4;
                let mut byte = 0;
                while byte < 4 {
                    table[mask][place + byte] = (4 * word + byte) as u8;
                    byte += 1;
                }
            }
            word += 1;
        }
        mask += 1;
    }
    table
};

/// As [`Simd::overlaps`].
#[inline(always)]
pub(super) fn overlaps<V: Vectors, S: Simd, I: Index>(
    v: V,
    simd: S,
    boxes: &[KeyBox],
    pairs: &[Pair<I>; 4],
) -> u32 {
    // Boxes are read with the word behind them, which the last one has not.
    let Some(most) = boxes.len().checked_sub(2).filter(|most| !any_above(v, pairs, *most)) else {
        return each_overlap(simd, boxes, pairs);
    };
    debug_assert!(pairs.iter().flatten().all(|slot| slot.at() <= most));
    let [p, q, r, s] = pairs;
    // SAFETY: behind the box of each slot there is another one.
    let (first, last) = unsafe {
        (v.join16(apart(v, boxes, p), apart(v, boxes, q)), v.join16(apart(v, boxes, r), apart(v, boxes, s)))
    };
    // Four bytes of each pair, of which the last one means nothing.
    let all = v.and(v.join8(first, last), v.splat(0x00ff_ffff));
    v.bits4(v.equal32(all, v.splat(0)))
}

/// Whether a slot is above a number.
#[inline(always)]
fn any_above<V: Vectors, I: Index>(v: V, pairs: &[Pair<I>; 4], most: usize) -> bool {
    let (first, last) = halves(v, pairs);
    if size_of::<I>() == 2 {
        let most = u16::try_from(most).unwrap_or(u16::MAX);
        v.any(v.excess16(first, v.splat(u32::from(most) * 0x1_0001)))
    } else {
        let most = v.splat(u32::try_from(most).unwrap_or(u32::MAX));
        v.any(v.xor(v.most32(v.most32(first, last), most), most))
    }
}

/// The first 16 bytes of four pairs, and the last ones: the same if there are no others.
#[inline(always)]
fn halves<V: Vectors, I: Index>(v: V, pairs: &[Pair<I>; 4]) -> (V::Vector, V::Vector) {
    let bytes: &[u8] = bytemuck::cast_slice(pairs);
    let (first, last) = (bytes.first_chunk().unwrap_or(&[0; 16]), bytes.last_chunk().unwrap_or(&[0; 16]));
    (v.load(first), v.load(last))
}

/// The axes on which the boxes of a pair are apart. The last lane means nothing.
///
/// # Safety
/// Behind the box of each slot there must be another one.
#[inline(always)]
unsafe fn apart<V: Vectors, I: Index>(v: V, boxes: &[KeyBox], pair: &Pair<I>) -> V::Vector {
    // SAFETY: the caller vouches for the slots.
    let ([a_min, a_max], [b_min, b_max]) =
        unsafe { (sides(v, boxes, pair[0].at()), sides(v, boxes, pair[1].at())) };
    v.or(v.above32(a_min, b_max), v.above32(b_min, a_max))
}

/// The minima and the maxima of a box, with a word more each.
///
/// # Safety
/// Behind the box there must be another one.
#[inline(always)]
unsafe fn sides<V: Vectors>(v: V, boxes: &[KeyBox], at: usize) -> [V::Vector; 2] {
    // SAFETY: a box is 24 bytes, three minima and three maxima; 28 bytes from its start on are read, all of them in the slice.
    unsafe {
        let bytes: *const u8 = boxes.as_ptr().add(at).cast();
        [v.load(&*bytes.cast()), v.load(&*bytes.add(12).cast())]
    }
}

/// As [`Simd::part`].
#[inline(always)]
pub(super) fn part<V: Vectors, I: Index>(v: V, pairs: &[Pair<I>; 4], stay: u32, gap: &mut [Pair<I>]) {
    let mask = (stay & 15) as usize;
    if let Some(to) = gap.first_chunk_mut() {
        order(v, pairs, &KEPT[mask], to);
    }
    if let Some(to) = gap.last_chunk_mut() {
        order(v, pairs, &BACK[mask], to);
    }
}

/// Writes four pairs in the order of these places, which are places of words.
#[inline(always)]
fn order<V: Vectors, I: Index>(v: V, pairs: &[Pair<I>; 4], places: &[u8; 16], to: &mut [Pair<I>; 4]) {
    let (first, last) = halves(v, pairs);
    let (bytes, places): (&mut [u8], _) = (bytemuck::cast_slice_mut(to), v.load(places));
    if size_of::<I>() == 2 {
        if let Some(bytes) = bytes.first_chunk_mut() {
            v.store(bytes, v.shuffle(first, places));
        }
    } else {
        // The first slots of the pairs, and the second ones.
        let (a, b) = (v.zip_first32(first, last), v.zip_last32(first, last));
        let (a, b) = (v.zip_first32(a, b), v.zip_last32(a, b));
        let (a, b) = (v.shuffle(a, places), v.shuffle(b, places));
        if let Some(bytes) = bytes.first_chunk_mut() {
            v.store(bytes, v.zip_first32(a, b));
        }
        if let Some(bytes) = bytes.last_chunk_mut() {
            v.store(bytes, v.zip_last32(a, b));
        }
    }
}
