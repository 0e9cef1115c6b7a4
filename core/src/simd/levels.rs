//! The levels of vectors that a target may have: of 128 bits, and on x86-64 AVX2. A level that it has not is
//! a type without values, so it costs nothing.

#[cfg(any(
    all(any(target_arch = "x86", target_arch = "x86_64"), feature = "sse41"),
    all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"),
    all(target_arch = "wasm32", target_feature = "simd128")
))]
pub(crate) use {super::call as run_narrow, super::vectors::Narrow};

#[cfg(not(any(
    all(any(target_arch = "x86", target_arch = "x86_64"), feature = "sse41"),
    all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"),
    all(target_arch = "wasm32", target_feature = "simd128")
)))]
pub(crate) use {Absent as Narrow, absent as run_narrow};

#[cfg(all(target_arch = "x86_64", feature = "avx2"))]
pub(crate) use {super::call as run_wide, super::vectors::Wide};

#[cfg(not(all(target_arch = "x86_64", feature = "avx2")))]
pub(crate) use {Absent as Wide, absent as run_wide};

/// A level that no CPU of the target has.
#[allow(dead_code, reason = "some targets have all levels")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Absent {}

#[allow(dead_code, reason = "some targets have all levels")]
impl Absent {
    pub(crate) const NAME: &'static str = "";
    pub(crate) const GUARANTEED: Option<Self> = None;

    pub(crate) const fn detect() -> Option<Self> {
        None
    }
}

/// As [`call!`](super::call) for a level that there is not.
#[allow(unused_macros, reason = "some targets have all levels")]
macro_rules! absent {
    ($simd:ident, $_:expr) => {
        match $simd {}
    };
}
#[allow(unused_imports, reason = "some targets have all levels")]
pub(crate) use absent;
