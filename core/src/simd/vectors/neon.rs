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

    proven! {
        words(words: [u32; 4]) = vreinterpretq_u8_u32(vld1q_u32(words.as_ptr()));
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
    proven! {
        load(bytes: &[u8; 16]) = vld1q_u8(bytes.as_ptr());
        store(bytes: &mut [u8; 16], a) -> () = vst1q_u8(bytes.as_mut_ptr(), a);
        first(a) -> u32 = vgetq_lane_u32::<0>(words(a));
        even32(a, b) = vreinterpretq_u8_u32(vuzp1q_u32(words(a), words(b)));
        odd32(a, b) = vreinterpretq_u8_u32(vuzp2q_u32(words(a), words(b)));
        // Both saturate, and NaN gives zero.
        steps16(a, b) = vreinterpretq_u8_u16(vqmovn_high_u32(vqmovn_u32(vcvtq_u32_f32(floats(a))), vcvtq_u32_f32(floats(b))));
        reached(rows: [uint8x16_t; 4], query) = {
            // The least of each four bytes of masks.
            let first = vpminq_u8(vcgeq_u8(rows[0], query), vcgeq_u8(rows[1], query));
            let last = vpminq_u8(vcgeq_u8(rows[2], query), vcgeq_u8(rows[3], query));
            vpminq_u8(first, last)
        };
        bits4(mask) -> u32 = vaddvq_u32(vandq_u32(words(mask), vld1q_u32([1, 2, 4, 8].as_ptr())));
        // The lower of a mask and a bit is the bit where the mask is set. With `and` the compiler would know
        // that no two bits are in one place, and make three operations of each sum.
        bits64(masks: [uint8x16_t; 4]) -> u64 = {
            let bit = vld1q_u8(BIT.as_ptr());
            let first = vpaddq_u8(vminq_u8(masks[0], bit), vminq_u8(masks[1], bit));
            let last = vpaddq_u8(vminq_u8(masks[2], bit), vminq_u8(masks[3], bit));
            let sums = vpaddq_u8(first, last);
            vgetq_lane_u64::<0>(longs(vpaddq_u8(sums, sums)))
        };
    }
}
