//! 128-bit vectors: SSE4.1 of x86, NEON of AArch64, simd128 of WebAssembly. The level is written once, over the
//! operations of [`Vectors`](vectors::Vectors) on 16 bytes. Each instruction set is a file that names its own
//! instructions.
//!
//! Why not a crate? `wide` (1.7) chooses its instructions when it is compiled, so a program for any x86-64 would get
//! SSE2, which has no byte shuffle. `pulp` (0.22) chooses while the program runs, but its portable part lacks the
//! byte shuffle and the saturating subtraction of bytes. `fearless_simd` (1.2) has both. Without `std` it does not
//! ask the CPU, so the caller does, and vouches for the level by an `unsafe` call, as here. It could replace the
//! three files of instruction sets; that was not tried.

mod casts;
mod encode;
mod fours;
mod keys;
mod level;
#[cfg(target_arch = "aarch64")]
mod neon;
mod overlaps;
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

/// As [`run!`](crate::simd::kernels::run) for this level.
pub(crate) use crate::simd::call as run;

/// The level of the target's vectors.
pub(crate) type Level = level::Narrow<Native>;

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
