//! The instruction set that a step uses.

use super::levels::{Narrow, Wide};
use super::scalar::Scalar;

/// The instruction set that a step uses. A value is the proof that the CPU has it, so it can be kept and
/// copied. All levels give the same bytes; only their speed differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kernels(Level);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    Scalar(Scalar),
    Narrow(Narrow),
    Wide(Wide),
}

/// The best vectors that every CPU of the target has.
const GUARANTEED: Option<Level> = match (Wide::GUARANTEED, Narrow::GUARANTEED) {
    (Some(level), _) => Some(Level::Wide(level)),
    (None, Some(level)) => Some(Level::Narrow(level)),
    (None, None) => None,
};

/// Whether scalar code is compiled. Each level compiles all phases once more, and a target with guaranteed
/// vectors needs no other.
const PLAIN: bool = cfg!(feature = "scalar") || GUARANTEED.is_none();

impl Kernels {
    /// No vectors. On a target that guarantees vectors, and in builds without the feature `scalar`, there is
    /// no such code, and this is [`BASELINE`](Self::BASELINE).
    pub const SCALAR: Self = Self(Self(Level::Scalar(Scalar)).level());

    /// The best level that needs no detection, since every CPU of the target has it: NEON of AArch64; simd128
    /// of WebAssembly, SSE4.1 and AVX2 of x86 if the program is compiled for these; else scalar code. The
    /// features `sse41` and `avx2`, on by default, are what these two need to be there at all.
    pub const BASELINE: Self = match GUARANTEED {
        Some(level) => Self(level),
        None => Self::SCALAR,
    };

    /// The best level of this CPU. Asks the CPU once and remembers.
    #[must_use]
    pub fn detect() -> Self {
        Self::avx2().or_else(Self::narrow).unwrap_or(Self::BASELINE)
    }

    /// 128-bit vectors, where this CPU has them: SSE4.1 of x86 with POPCNT, NEON of AArch64, simd128 of
    /// WebAssembly where the module is compiled with it.
    #[must_use]
    pub fn narrow() -> Option<Self> {
        Narrow::detect().map(|level| Self(Level::Narrow(level)))
    }

    /// AVX2 of x86-64, where this CPU has it.
    #[must_use]
    pub fn avx2() -> Option<Self> {
        Wide::detect().map(|level| Self(Level::Wide(level)))
    }

    /// Every level of this CPU, the plainest first.
    pub fn all() -> impl Iterator<Item = Self> {
        [PLAIN.then_some(Self::SCALAR), Self::narrow(), Self::avx2()].into_iter().flatten()
    }

    /// The name of the level, as for the option `--kernels` of the program `trisap`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.0 {
            Level::Scalar(_) => "scalar",
            Level::Narrow(_) => Narrow::NAME,
            Level::Wide(_) => Wide::NAME,
        }
    }

    /// The level of this name, where this CPU has it.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        Self::all().find(|level| level.name() == name)
    }

    /// The level, or what replaces scalar code if there is none.
    #[inline(always)]
    pub(crate) const fn level(self) -> Level {
        match (self.0, GUARANTEED) {
            (Level::Scalar(_), Some(vectors)) if !PLAIN => vectors,
            (level, _) => level,
        }
    }
}

/// Calls a function that is generic over [`Simd`](super::Simd), compiled for the level of some kernels:
/// `run!(kernels, |simd| sweep_leaf(simd, leaf))`.
macro_rules! run {
    ($kernels:expr, |$simd:ident| $call:expr) => {
        match $kernels.level() {
            $crate::simd::kernels::Level::Scalar($simd) => $call,
            $crate::simd::kernels::Level::Narrow($simd) => $crate::simd::levels::run_narrow!($simd, $call),
            $crate::simd::kernels::Level::Wide($simd) => $crate::simd::levels::run_wide!($simd, $call),
        }
    };
}
pub(crate) use run;

impl Default for Kernels {
    /// The detected level.
    fn default() -> Self {
        Self::detect()
    }
}
