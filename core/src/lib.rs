#![doc = include_str!("../README.md")]
//!
//! ## The types that one needs
//!
//! A [`Config`] says what there is, an [`InlineWorld`] is the memory, a [`World`] the view of it that does
//! everything, an [`Aabb`] a box, and a [`Step`] what a step has found. [`Cast`] and [`Region`] ask;
//! [`Boxes`] are an array of yours; an [`Executor`] is your job system. All else comes up where it is needed.
#![no_std]
#![warn(clippy::undocumented_unsafe_blocks)]

#[cfg(test)]
extern crate std;

mod access;
mod config;
mod error;
mod filter;
mod geometry;
mod id;
mod memory;
mod object;
mod objects;
mod pairs;
#[allow(unsafe_code, reason = "what workers share; each use says why it is sound")]
mod parallel;
#[allow(unsafe_code, reason = "vectors; each use says why it is sound")]
mod simd;
mod sort;
mod step;
mod sweep;
mod tree;

// In the order of use, in which the documentation of `World` lists the methods.
mod world;

mod query;

mod snapshot;

#[cfg(feature = "validate")]
mod validate;

pub use config::{Capacity, Config, Margin, Mode};
pub use error::{Error, Field, Rejected};
pub use filter::{Filter, Rule};
pub use geometry::aabb::Aabb;
pub use geometry::boxes::Boxes;
pub use id::{Id, Index, Pair};
pub use memory::layout::{Layout, layout};
pub use memory::stats::{Path, Reason, Stats};
pub use object::Object;
pub use parallel::executor::{Executor, Serial, Stage};
pub use query::{Among, Cast, Hit, Planes, Region, Side, Volume};
pub use simd::kernels::Kernels;
#[doc(hidden)]
pub use sort::heapsort;
#[cfg(feature = "validate")]
pub use {parallel::block_queue::before_claims, snapshot::check::Invalid};

pub use world::{InlineWorld, Inserted, LeafView, PlaneView, Step, Stepper, World};

#[doc = include_str!("../ARCHITECTURE.md")]
#[cfg(doc)]
pub mod architecture {}

#[doc = include_str!("../PAPER.md")]
#[cfg(doc)]
pub mod paper {}
