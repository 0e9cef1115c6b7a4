//! What the conformance tests share: independent oracles, a naive model of a world, scenes, recordings, and
//! worlds on every kernel and under every kind of job system.
//!
//! Nothing here is fast or clever on purpose: it is what the fast code is compared with.

pub mod checked;
pub mod denormals;
pub mod doing;
pub mod forced;
pub mod forging;
pub mod golden;
pub mod jobs;
pub mod lives;
pub mod model;
pub mod oracle;
pub mod play;
pub mod queries;
pub mod recordings;
pub mod scenes;
pub mod sequence;
pub mod worlds;

/// The first lines of Rust that somebody sees.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;

/// A pair of slots, the lower one first, whatever the index width of the world that it comes from.
pub type SlotPair = [u32; 2];

/// The pairs in ascending order. As numbers, which are sorted in half the time.
#[must_use]
pub fn sorted(pairs: &[SlotPair]) -> Vec<SlotPair> {
    let mut numbers: Vec<u64> = pairs.iter().map(|[a, b]| u64::from(*a) << 32 | u64::from(*b)).collect();
    numbers.sort_unstable();
    numbers.iter().map(|number| [(number >> 32) as u32, *number as u32]).collect()
}

/// How many times as many cases a test should play: what `TRISAP_EFFORT` says, 1 where it is not set.
///
/// # Panics
/// If it says no number.
#[must_use]
pub fn effort() -> u32 {
    std::env::var("TRISAP_EFFORT").map_or(1, |effort| effort.parse().expect("a number"))
}
