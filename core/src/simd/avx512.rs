//! 512-bit integers of x86-64, parts F, BW, DQ and VL: Skylake-X, Zen 4 and later. Operations that they do not make
//! shorter are those of [`Avx2`], and [`Kernels`](crate::Kernels) gives AVX2 whole phases.

use super::detect::Avx2;
use super::{Contact, EIGHT, HALF, Phase, Row, Simd, Tested, WINDOW};
use crate::geometry::aabb::Four;
use crate::geometry::key::KeyBox;
use crate::geometry::line::{Crossing, Slabs, Walk};
use crate::geometry::record::{Frame, Record};
use crate::id::{Index, Pair};
use core::arch::x86_64::*;

cpufeatures::new!(detected, "avx512f", "avx512bw", "avx512dq", "avx512vl");
cpufeatures::new!(second_generation, "avx512vbmi2");

/// Proof that the CPU has these parts of AVX-512 and what [`Avx2`] proves, and that the operating system saves the
/// wide registers and the masks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512(Avx2);

impl Avx512 {
    /// Asks the CPU.
    pub(crate) fn detect() -> Option<Self> {
        if detected::get() { Avx2::detect().map(Self) } else { None }
    }

    /// Whether the CPU is of the second generation or later: Ice Lake, Zen 4. The first one, up to Cascade Lake,
    /// lowers its clock for the wide registers, and a step with them takes longer.
    pub(crate) fn pays() -> bool {
        second_generation::get()
    }

    /// The same CPU without the wide registers.
    pub(crate) const fn narrow(self) -> Avx2 {
        self.0
    }
}

/// One bit for each of 16 rows. A plain function: a closure would not have the instruction set of its function.
#[inline(always)]
fn quarter(_: Avx512, rows: &[u8; 64], query: __m512i) -> __mmask16 {
    // SAFETY: the token proves AVX-512 BW; the load reads the 64 bytes.
    unsafe {
        // How much the query's bytes exceed a row's: zero where none does.
        let excess = _mm512_subs_epu8(query, _mm512_loadu_si512(rows.as_ptr().cast()));
        _mm512_testn_epi32_mask(excess, excess)
    }
}

impl Simd for Avx512 {
    type Keys = <Avx2 as Simd>::Keys;

    type Axis = <Avx2 as Simd>::Axis;

    type Query = __m512i;

    const ENCODES_FOUR: bool = true;
    const TESTS_SOME_PAIRS: bool = true;

    #[inline(always)]
    fn call<P: Phase>(self, phase: P) -> P::Output {
        #[inline(never)]
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi1,bmi2,popcnt")]
        fn compiled<P: Phase>(simd: Avx512, phase: P) -> P::Output {
            phase.run(simd)
        }
        // SAFETY: `self` proves that the CPU has these features.
        unsafe { compiled(self, phase) }
    }

    #[inline(always)]
    fn keys(self, bounds: &KeyBox) -> Self::Keys {
        self.0.keys(bounds)
    }

    #[inline(always)]
    fn bounds(self, keys: Self::Keys) -> KeyBox {
        self.0.bounds(keys)
    }

    #[inline(always)]
    fn encode(self, min: &[u8; 12], max: &[u8; 12]) -> Option<Self::Keys> {
        self.0.encode(min, max)
    }

    #[inline(always)]
    fn encode_four(self, boxes: Four<'_>, old: &[KeyBox; 4], new: &mut [KeyBox; 4]) -> Option<u32> {
        self.0.encode_four(boxes, old, new)
    }

    #[inline(always)]
    fn above(self, a: Self::Keys, b: Self::Keys) -> u32 {
        self.0.above(a, b)
    }

    #[inline(always)]
    fn overlap(self, a: &KeyBox, b: &KeyBox) -> bool {
        self.0.overlap(a, b)
    }

    #[inline(always)]
    fn overlaps<I: Index>(self, boxes: &[KeyBox], pairs: &[Pair<I>]) -> usize {
        self.0.overlaps(boxes, pairs)
    }

    #[inline(always)]
    fn prefetch<T>(self, items: &[T], index: usize) {
        self.0.prefetch(items, index);
    }

    #[inline(always)]
    fn same(self, a: Self::Keys, b: Self::Keys) -> bool {
        self.0.same(a, b)
    }

    #[inline(always)]
    fn lower(self, a: Self::Keys, b: Self::Keys) -> Self::Keys {
        self.0.lower(a, b)
    }

    #[inline(always)]
    fn upper(self, a: Self::Keys, b: Self::Keys) -> Self::Keys {
        self.0.upper(a, b)
    }

    #[inline(always)]
    fn narrow(self, keys: Self::Keys) -> bool {
        self.0.narrow(keys)
    }

    #[inline(always)]
    fn suits(self, fat: &KeyBox, inner: Self::Keys, margin: Option<f32>) -> bool {
        self.0.suits(fat, inner, margin)
    }

    #[inline(always)]
    fn axis(self, axis: usize) -> Self::Axis {
        self.0.axis(axis)
    }

    #[inline(always)]
    fn row(self, axis: Self::Axis, record: &Record) -> Row {
        self.0.row(axis, record)
    }

    #[inline(always)]
    fn query(self, [_, query]: Self::Axis, record: &Record) -> __m512i {
        // SAFETY: `self` proves AVX-512 F.
        unsafe { _mm512_broadcastd_epi32(_mm_shuffle_epi8(bytemuck::cast(*record), query)) }
    }

    #[inline(always)]
    fn window(self, rows: &[Row; WINDOW], count: usize, query: __m512i) -> u64 {
        let [a, b, c, d]: &[[u8; 64]; 4] = bytemuck::cast_ref(rows);
        // SAFETY: `self` proves AVX-512 BW and BMI2.
        unsafe {
            let first = _mm512_kunpackw(quarter(self, b, query).into(), quarter(self, a, query).into());
            let second = _mm512_kunpackw(quarter(self, d, query).into(), quarter(self, c, query).into());
            _bzhi_u64(_mm512_kunpackd(second.into(), first.into()), count.min(WINDOW) as u32)
        }
    }

    #[inline(always)]
    fn half_window(self, rows: &[Row; HALF], count: usize, query: __m512i) -> u32 {
        let [a, b]: &[[u8; 64]; 2] = bytemuck::cast_ref(rows);
        // SAFETY: `self` proves AVX-512 BW and BMI2.
        unsafe {
            let mask = _mm512_kunpackw(quarter(self, b, query).into(), quarter(self, a, query).into());
            _bzhi_u32(mask, count.min(HALF) as u32)
        }
    }

    #[inline(always)]
    fn four<I: Index>(
        self,
        sorted: &[Record],
        base: u32,
        bits: u64,
        pairs: &mut [Pair<I>; 4],
    ) -> Option<usize> {
        self.0.four(sorted, base, bits, pairs)
    }

    #[inline(always)]
    fn test_candidates<I: Index>(
        self,
        sorted: &[Record],
        candidates: &mut [u32],
        pairs: &mut [Pair<I>],
    ) -> Tested {
        self.0.test_candidates(sorted, candidates, pairs)
    }

    #[inline(always)]
    fn contact(self, a: &Record, b: &Record) -> Contact {
        self.0.contact(a, b)
    }

    #[inline(always)]
    fn touching(self, records: &[Record; EIGHT], limit: Record) -> u32 {
        self.0.touching(records, limit)
    }

    #[inline(always)]
    fn span(self, slabs: &Slabs, min: [i32; 4], max: [i32; 4], far: f64) -> (f64, f64) {
        self.0.span(slabs, min, max, far)
    }

    #[inline(always)]
    fn enter(self, walk: &Walk, nodes: [&KeyBox; 2], until: f32) -> [f32; 2] {
        self.0.enter(walk, nodes, until)
    }

    #[inline(always)]
    fn crossed(self, records: &[Record; EIGHT], crossing: &Crossing) -> u32 {
        self.0.crossed(records, crossing)
    }

    #[inline(always)]
    fn met(self, records: &[Record; EIGHT], crossing: &Crossing) -> [f32; EIGHT] {
        self.0.met(records, crossing)
    }

    #[inline(always)]
    fn pop_min(self, numbers: &mut [u32; EIGHT]) -> u32 {
        self.0.pop_min(numbers)
    }

    #[inline(always)]
    fn record(self, frame: &Frame, keys: Self::Keys, tag: u32) -> Record {
        self.0.record(frame, keys, tag)
    }
}
