//! The levels of vectors that a target may have: of 128 bits, and on x86-64 AVX2. A level that it has not is
//! a type without values, so it costs nothing.

#[cfg(any(
    all(any(target_arch = "x86", target_arch = "x86_64"), feature = "sse41"),
    all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"),
    all(target_arch = "wasm32", target_feature = "simd128")
))]
pub(crate) use {super::call as run_narrow, super::vectors::Narrow};

#[cfg(all(target_arch = "x86_64", feature = "avx2"))]
pub(crate) use {super::call as run_wide, super::vectors::Wide};

// A name from above goes before one from here.
#[allow(unused_imports, reason = "some targets have all levels")]
pub(crate) use absent::*;

#[allow(dead_code, unused_imports, unused_macros, reason = "some targets have all levels")]
mod absent {
    /// A level that no CPU of the target has.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub(crate) enum Absent {}

    impl Absent {
        pub(crate) const NAME: &'static str = "";
        pub(crate) const GUARANTEED: Option<Self> = None;

        pub(crate) const fn detect() -> Option<Self> {
            None
        }
    }

    /// As [`call!`](super::super::call) for a level that there is not.
    macro_rules! run_absent {
        ($simd:ident, $_:expr) => {
            match $simd {}
        };
    }
    pub(crate) use {Absent as Narrow, Absent as Wide, run_absent as run_narrow, run_absent as run_wide};
}
