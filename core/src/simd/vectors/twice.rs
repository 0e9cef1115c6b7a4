//! Vectors of two registers.

use super::fours;
use super::operations::{Half, HalfOf, Halves, Vectors, ends, of_vectors, operations, places};
use crate::geometry::key::KeyBox;
use crate::simd::Row;

/// Vectors of two registers of an instruction set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Twice<V>(V);

/// Operations on each register.
macro_rules! on_both {
    ($($(#[$_:meta])* $name:ident($($operand:ident),+);)+) => {$(
        #[inline(always)]
        fn $name(self, $($operand: Self::Vector),+) -> Self::Vector {
            (self.0.$name($($operand.0),+), self.0.$name($($operand.1),+))
        }
    )+};
}

impl<V: Half> Vectors for Twice<V> {
    const NAME: &'static str = V::NAME;

    const GUARANTEED: Option<Self> = match V::GUARANTEED {
        Some(proof) => Some(Self(proof)),
        None => None,
    };

    #[inline(always)]
    fn detect() -> Option<Self> {
        V::detect().map(Self)
    }

    const MORE_CODE: bool = V::MORE_CODE;

    type Vector = (V::Vector, V::Vector);

    #[inline(always)]
    fn call<R>(self, work: impl FnOnce() -> R) -> R {
        self.0.call(work)
    }

    operations! { |this|
        words(words: [u32; 4]) = (this.0.words(words), this.0.words(words));
        splat(word: u32) = (this.0.splat(word), this.0.splat(word));
        any(a) -> bool = this.0.any(this.0.or(a.0, a.1));
        any_of_three(a) -> bool = this.0.any_of_three(this.0.or(a.0, a.1));
    }

    of_vectors!(on_both);

    on_both! { turned(a, ways); }
}

impl<V: Half> Halves for Twice<V> {
    type Half = V;

    operations! { |this|
        half() -> V = this.0;
        halved(sides) = (sides.0, this.0.shuffle(sides.1, this.0.load(&places([1, 2, 3, 0]))));
        six(mask) -> u32 = this.0.bits4(mask.0) | this.0.bits4(mask.1) << 2;
        steps16(a) -> HalfOf<Self> = this.0.steps16(a.0, a.1);
        bits8(mask) -> u32 = this.0.bits4(mask.0) | this.0.bits4(mask.1) << 4;
        zeros64(a) -> u32 = this.0.bits4(this.0.equal32(this.0.join16(a.0, a.1), this.0.splat(0)));
    }

    operations! {
        split(a) -> [HalfOf<Self>; 2] = a.into();
        joined(first: HalfOf<Self>, last: HalfOf<Self>) = (first, last);
    }

    /// The first four and the last four: two of them twice, so no lane is empty.
    #[inline(always)]
    fn sides(self, bounds: &KeyBox) -> Self::Vector {
        let [first, last] = ends(bounds);
        self.pick(first, last)
    }

    #[inline(always)]
    fn opposed(self, [a, b]: [&[u8; 32]; 2]) -> [Self::Vector; 2] {
        let from = |at, bytes: &[u8; 32]| self.0.load(bytes.split_at(at).1.first_chunk().unwrap_or(&[0; 16]));
        [(from(0, a), from(0, b)), (from(12, b), from(12, a))]
    }

    #[inline(always)]
    fn window<const N: usize>(self, rows: &[Row; N], count: usize, (query, _): Self::Vector) -> u64 {
        let v = self.0;
        let mut masks = [v.splat(0); 4];
        for (mask, rows) in masks.iter_mut().zip(rows.as_flattened().as_chunks::<64>().0) {
            let [a, b, c, d]: &[[u8; 16]; 4] = bytemuck::cast_ref(rows);
            *mask = v.reached([v.load(a), v.load(b), v.load(c), v.load(d)], query);
        }
        let below = if count >= N { u64::MAX } else { !(u64::MAX << count) };
        v.bits64(masks) & below
    }

    #[inline(always)]
    fn kept64(self, a: Self::Vector, mask: u32, [first, last]: &mut [[u8; 16]; 2]) {
        let v = self.0;
        let kept = v.load(&fours::KEPT[mask as usize & 15]);
        let (lower, upper) = (v.shuffle(v.even32(a.0, a.1), kept), v.shuffle(v.odd32(a.0, a.1), kept));
        v.store(first, v.zip_first32(lower, upper));
        v.store(last, v.zip_last32(lower, upper));
    }
}
