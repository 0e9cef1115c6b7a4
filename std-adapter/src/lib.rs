#![doc = include_str!("../README.md")]
//!
//! ## The types that one needs
//!
//! [`BroadPhase`] holds boxes by key, [`KeyedStep`] is what a step has found, an [`Aabb`] is a box, a [`Config`] says what there is
//! beyond pairs, and a [`Cast`] or a [`Region`] asks. By slots: [`OwnedWorld`], and the [`World`] in it. The [`guide`] says which of
//! them to take, and how to do 2-D, planes, rest and rollback. All else comes up where it is needed.

mod broad_phase;
mod memory;
#[cfg(feature = "model")]
pub mod model;
mod offer;
mod once;
mod owned;
mod owners;
#[cfg(feature = "rayon")]
mod pool;
#[cfg(feature = "recording")]
pub mod recording;
#[cfg(feature = "scene")]
pub mod scene;
#[cfg(feature = "rayon")]
mod sharing;

#[doc = include_str!("../GUIDE.md")]
#[cfg(any(doc, doctest))]
pub mod guide {}

pub use broad_phase::{AmongKeys, BroadPhase, KeyedError, KeyedRule, KeyedStep, KeyedStepper, Snapshot};
pub use offer::Offer;
pub use once::{Bounded, Pairs, Scratch, ScratchOn, pairs, pairs_between};
pub use owned::OwnedWorld;
pub use owners::Owners;
#[cfg(feature = "rayon")]
pub use pool::Rayon;
#[cfg(feature = "rayon")]
pub use sharing::Sharing;
pub use trisap_contacts::Contacts;
pub use trisap_core::*;
