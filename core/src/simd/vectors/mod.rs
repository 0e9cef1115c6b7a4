//! Vectors of 32 bytes, as two halves of 16: a register of AVX2, or two of SSE4.1, NEON of AArch64 or simd128
//! of WebAssembly. What a step does with them is written once, over the operations of
//! [`Halves`](operations::Halves). Each instruction set is a file that names its own instructions.

#[cfg(all(target_arch = "x86_64", feature = "avx2"))]
mod avx2;
mod encode;
mod fours;
mod level;
#[cfg(target_arch = "aarch64")]
mod neon;
mod operations;
mod overlaps;
#[cfg(target_arch = "wasm32")]
mod simd128;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod sse41;
mod twice;

#[cfg(target_arch = "aarch64")]
use neon::Neon as Native;
#[cfg(target_arch = "wasm32")]
use simd128::Simd128 as Native;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use sse41::Sse41 as Native;

/// The level of the target's registers of 16 bytes.
#[allow(dead_code, reason = "x86-64 may have AVX2 alone")]
pub(crate) type Narrow = level::Level<twice::Twice<Native>>;

#[cfg(all(target_arch = "x86_64", feature = "avx2"))]
pub(crate) type Wide = level::Level<avx2::Avx2>;
