//! Broad-phase collision detection without an allocator.
//!
//! Give boxes each frame; get back every overlapping pair, exactly once. All memory is lent by the caller and sized by
//! [`layout`]; threads, if any, come from the caller's job system through [`Executor`]. No panics, no `unsafe`
//! outside `simd` and `parallel`, no recursion.
//!
//! ```
//! use trisap_core::{Aabb, Capacity, Config, InlineWorld, layout};
//!
//! const CONFIG: Config = Config::new(Capacity::for_objects(16));
//! const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;
//!
//! let mut memory = InlineWorld::<BYTES>::EMPTY;
//! let mut world = memory.init::<u16>(&CONFIG)?;
//! let floor = world.insert(Aabb::new([-9.0, -9.0, -1.0], [9.0, 9.0, 0.0]))?;
//! let ball = world.insert(Aabb::new([0.0, 0.0, 0.5], [1.0, 1.0, 1.5]))?;
//!
//! assert!(world.step()?.pairs().is_empty());
//! world.set_aabb(ball, Aabb::new([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]))?; // touching counts
//! assert_eq!(world.step()?.pairs(), [[floor.slot() as u16, ball.slot() as u16]]);
//! # Ok::<(), trisap_core::Error>(())
//! ```
//!
//! # The method
//!
//! Cao & Wang, *A Fast and Generalized Broad-Phase Collision Detection Method Based on KD-Tree Spatial Subdivision and
//! Sweep-and-Prune*, corrected where the printed text loses pairs. `E1` to `E18` in these docs number the
//! corrections. Its parts, where to find them:
//!
//! | in the paper | here |
//! |---|---|
//! | pre-sorted, shared linked lists | `lists` |
//! | construction of the KD-tree | `tree::build`, `tree::cells` |
//! | update of the tree; copies of straddling boxes | `tree::assign`, `tree::relocate`, `tree::refit`, `tree::balance` |
//! | temporal inference: dynamic and static objects | `objects`, `step::policy`, `pairs::persistent`, `pairs::results` |
//! | sweep-and-prune in the leaves | `sweep` |
//! | control pipeline | `world`, `step` |
//!
//! [`paper`] walks through the paper section by section, [`architecture`] through the code from the ground up.
//!
//! Around the pairs there are filters ([`Filter`]), queries ([`Cast`], [`Region`]), snapshots, shifts of the origin and the tree to
//! look at ([`LeafView`]).

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
mod lists;
mod memory;
mod objects;
mod pairs;
#[allow(unsafe_code, reason = "what workers share; each use says why it is sound")]
mod parallel;
mod query;
#[allow(unsafe_code, reason = "vectors; each use says why it is sound")]
mod simd;
mod snapshot;
mod sort;
mod step;
mod sweep;
mod tree;
mod validate;
mod world;

pub use config::{Capacity, Choice, Config, Margin, Mode};
pub use error::{Error, Field, Rejected};
pub use filter::{Filter, Rule};
pub use geometry::aabb::{Aabb, Boxes};
pub use id::{Id, Index, Pair};
pub use memory::layout::{Layout, layout};
pub use memory::stats::{Path, Reason, Stats};
pub use parallel::executor::{Executor, Serial, Stage};
#[cfg(target_has_atomic = "32")]
pub use parallel::offer::Offer;
pub use query::{Cast, Hit, Region};
pub use simd::kernels::Kernels;
pub use validate::Invalid;
pub use world::{InlineWorld, Inserted};
pub use world::{LeafView, PlaneView};
pub use world::{Step, Stepper, World};

#[doc = include_str!("../ARCHITECTURE.md")]
#[cfg(doc)]
pub mod architecture {}

#[doc = include_str!("../PAPER.md")]
#[cfg(doc)]
pub mod paper {}
