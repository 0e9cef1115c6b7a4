//! Broad-phase collision detection for programs with `std`: everything of [`trisap_core`], and
//!
//! - [`BroadPhase`], boxes by the caller's own keys, which grows by itself: where most programs begin,
//! - [`OwnedWorld`], a world that brings its own memory,
//! - `Rayon`, an executor over a [rayon](https://docs.rs/rayon) thread pool (feature `rayon`, on by default),
//! - `recording`, Broadmark's `.aabbs` files (feature `recording`),
//! - `scene`, synthetic scenes of any size (feature `scene`).
//!
//! ```
//! use trisap::{Aabb, Boxes, Capacity, Config, OwnedWorld};
//!
//! let mut boxes = [
//!     Aabb::new([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
//!     Aabb::new([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]), // touches the first
//!     Aabb::new([5.0, 0.0, 0.0], [6.0, 1.0, 1.0]),
//! ];
//! let mut owned = OwnedWorld::new(&Config::new(Capacity::for_objects(3)))?;
//! let mut world = owned.world();
//! world.insert_many(Boxes::new(&boxes))?;
//! assert_eq!(world.step()?.pairs(), [[0, 1]]);
//!
//! boxes[2] = Aabb::new([1.5, 0.0, 0.0], [2.5, 1.0, 1.0]);
//! let step = world.step_over(Boxes::new(&boxes))?;
//! assert_eq!(step.pairs().len(), 2);
//! # Ok::<(), trisap::Error>(())
//! ```

mod broad_phase;
mod memory;
mod owned;
#[cfg(feature = "rayon")]
mod pool;
#[cfg(feature = "recording")]
pub mod recording;
#[cfg(feature = "scene")]
pub mod scene;
#[cfg(feature = "rayon")]
mod sharing;

pub use broad_phase::{BroadPhase, KeyedStep, Snapshot};
pub use owned::OwnedWorld;
#[cfg(feature = "rayon")]
pub use pool::Rayon;
#[cfg(feature = "rayon")]
pub use sharing::Sharing;
pub use trisap_core::*;
