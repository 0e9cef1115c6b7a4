//! 128-bit vectors: SSE4.1 of x86, NEON of AArch64, simd128 of WebAssembly. The level is written once, over the operations on
//! 16 bytes of [`Vectors`](vectors::Vectors); each instruction set is a file that names its own.
//!
//! Why not a crate: `wide` chooses its instructions when it is compiled, so a program for any x86 would get SSE2 and its slow
//! replacements of a byte shuffle. `pulp` and `fearless_simd` choose while the program runs, but their portable part lacks what
//! this level consists of: saturating subtraction of bytes, shuffles by a table, packing, masks of bytes. For these their users
//! call the intrinsics themselves, as here, and have the crate's dispatch beside ours.

mod casts;
mod fours;
mod keys;
mod level;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(target_arch = "wasm32")]
mod simd128;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod sse41;
mod vectors;

#[cfg(target_arch = "aarch64")]
use neon::Neon as Native;
#[cfg(target_arch = "wasm32")]
use simd128::Simd128 as Native;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use sse41::Sse41 as Native;
use vectors::Vectors;

/// The level of the target's vectors.
pub(super) type Level = level::Narrow<Native>;

impl Level {
    /// The name of the level.
    pub(super) const NAME: &'static str = Native::NAME;

    /// The level, where the target guarantees it.
    pub(super) const GUARANTEED: Option<Self> = match Native::GUARANTEED {
        Some(vectors) => Some(level::Narrow(vectors)),
        None => None,
    };

    /// The level, where this CPU has it.
    pub(super) fn detect() -> Option<Self> {
        Native::detect().map(level::Narrow)
    }
}
