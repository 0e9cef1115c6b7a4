#![doc = include_str!("../README.md")]

mod broad_phase;
mod memory;
mod offer;
mod owned;
#[cfg(feature = "rayon")]
mod pool;
#[cfg(feature = "recording")]
pub mod recording;
#[cfg(feature = "scene")]
pub mod scene;
#[cfg(feature = "rayon")]
mod sharing;

pub use broad_phase::{AmongKeys, BroadPhase, KeyedError, KeyedRule, KeyedStep, KeyedStepper, Snapshot};
pub use offer::Offer;
pub use owned::OwnedWorld;
#[cfg(feature = "rayon")]
pub use pool::Rayon;
#[cfg(feature = "rayon")]
pub use sharing::Sharing;
pub use trisap_core::*;
