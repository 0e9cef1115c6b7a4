//! The 128-bit vectors of AArch64. Every CPU that runs an operating system has them.

use super::operations::{Half, Vectors, operations, proven};
use core::arch::aarch64::*;
// The same bits as other numbers.
use core::arch::aarch64::{
    vreinterpretq_f32_u8 as floats, vreinterpretq_s32_u8 as signed, vreinterpretq_u16_u8 as shorts,
    vreinterpretq_u32_u8 as words, vreinterpretq_u64_u8 as longs,
};

/// Proof of NEON. This file is compiled only where it may be used everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Neon(());

/// A bit for each byte of eight, in each half.
const BIT: [u8; 16] = [1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128];

impl Vectors for Neon {
    const NAME: &'static str = "neon";

    const GUARANTEED: Option<Self> = Some(Self(()));

    type Vector = uint8x16_t;

    #[inline(always)]
    fn words(self, words: [u32; 4]) -> uint8x16_t {
        self.load(&bytemuck::cast(words))
    }

    proven! {
        splat(word: u32) = vreinterpretq_u8_u32(vdupq_n_u32(word));
        // The greatest of four words: zero only if all are.
        any(a) -> bool = vmaxvq_u32(words(a)) != 0;
        and(a, b) = vandq_u8(a, b);
        or(a, b) = vorrq_u8(a, b);
        xor(a, b) = veorq_u8(a, b);
        select(mask, a, b) = vbslq_u8(mask, a, b);
        shuffle(a, places) = vqtbl1q_u8(a, places);
        equal16(a, b) = vreinterpretq_u8_u16(vceqq_u16(shorts(a), shorts(b)));
        equal32(a, b) = vreinterpretq_u8_u32(vceqq_u32(words(a), words(b)));
        excess16(a, b) = vreinterpretq_u8_u16(vqsubq_u16(shorts(a), shorts(b)));
        join8(a, b) = vpmaxq_u8(a, b);
        join16(a, b) = vreinterpretq_u8_u16(vpmaxq_u16(shorts(a), shorts(b)));
        zip_first16(a, b) = vreinterpretq_u8_u16(vzip1q_u16(shorts(a), shorts(b)));
        zip_last16(a, b) = vreinterpretq_u8_u16(vzip2q_u16(shorts(a), shorts(b)));
        zip_first32(a, b) = vreinterpretq_u8_u32(vzip1q_u32(words(a), words(b)));
        zip_last32(a, b) = vreinterpretq_u8_u32(vzip2q_u32(words(a), words(b)));
        zip_first64(a, b) = vreinterpretq_u8_u64(vzip1q_u64(longs(a), longs(b)));
        zip_last64(a, b) = vreinterpretq_u8_u64(vzip2q_u64(longs(a), longs(b)));
        fourth_on(a, b) = vextq_u8::<12>(a, b);
        above32(a, b) = vreinterpretq_u8_u32(vcgtq_s32(signed(a), signed(b)));
        upper32(a, b) = vreinterpretq_u8_s32(vmaxq_s32(signed(a), signed(b)));
        minus32(a, b) = vreinterpretq_u8_u32(vsubq_u32(words(a), words(b)));
        magnitude32(a) = vreinterpretq_u8_s32(vabsq_s32(signed(a)));
        add(a, b) = vreinterpretq_u8_f32(vaddq_f32(floats(a), floats(b)));
        subtract(a, b) = vreinterpretq_u8_f32(vsubq_f32(floats(a), floats(b)));
        multiply(a, b) = vreinterpretq_u8_f32(vmulq_f32(floats(a), floats(b)));
        // NEON's own maximum gives NaN if one operand is NaN.
        maximum(a, b) = vbslq_u8(vreinterpretq_u8_u32(vcgtq_f32(floats(a), floats(b))), a, b);
        minimum(a, b) = vbslq_u8(vreinterpretq_u8_u32(vcltq_f32(floats(a), floats(b))), a, b);
        at_most(a, b) = vreinterpretq_u8_u32(vcleq_f32(floats(a), floats(b)));
    }
}

impl Half for Neon {
    #[inline(always)]
    fn load(self, bytes: &[u8; 16]) -> uint8x16_t {
        // SAFETY: the 16 bytes are read.
        unsafe { vld1q_u8(bytes.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, bytes: &mut [u8; 16], a: uint8x16_t) {
        // SAFETY: the 16 bytes are written.
        unsafe { vst1q_u8(bytes.as_mut_ptr(), a) }
    }

    proven! {
        first(a) -> u32 = vgetq_lane_u32::<0>(words(a));
        even32(a, b) = vreinterpretq_u8_u32(vuzp1q_u32(words(a), words(b)));
        odd32(a, b) = vreinterpretq_u8_u32(vuzp2q_u32(words(a), words(b)));
        // Both saturate, and NaN gives zero.
        steps16(a, b) = vreinterpretq_u8_u16(vqmovn_high_u32(vqmovn_u32(vcvtq_u32_f32(floats(a))), vcvtq_u32_f32(floats(b))));
    }

    #[inline(always)]
    fn reached(self, [a, b, c, d]: [uint8x16_t; 4], query: uint8x16_t) -> uint8x16_t {
        // SAFETY: `self` proves NEON.
        unsafe {
            // The least of each four bytes of masks.
            let first = vpminq_u8(vcgeq_u8(a, query), vcgeq_u8(b, query));
            let last = vpminq_u8(vcgeq_u8(c, query), vcgeq_u8(d, query));
            vpminq_u8(first, last)
        }
    }

    #[inline(always)]
    fn bits4(self, mask: uint8x16_t) -> u32 {
        // SAFETY: `self` proves NEON.
        unsafe { vaddvq_u32(words(self.and(mask, self.words([1, 2, 4, 8])))) }
    }

    // The lower of a mask and a bit is the bit where the mask is set. With `and` the compiler would know that
    // no two bits are in one place, and make three operations of each sum.
    #[inline(always)]
    fn bits64(self, [a, b, c, d]: [uint8x16_t; 4]) -> u64 {
        // SAFETY: `self` proves NEON.
        unsafe {
            let bit = self.load(&BIT);
            let first = vpaddq_u8(vminq_u8(a, bit), vminq_u8(b, bit));
            let last = vpaddq_u8(vminq_u8(c, bit), vminq_u8(d, bit));
            let sums = vpaddq_u8(first, last);
            vgetq_lane_u64::<0>(longs(vpaddq_u8(sums, sums)))
        }
    }
}
