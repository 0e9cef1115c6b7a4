//! Broad-phase collision detection over many machines: worlds of ranks that answer as one world would.
//!
//! Space is divided into one cell for each rank ([MPI](https://www.mpi-forum.org) has the ranks). An object belongs to the rank
//! whose cell holds its minimum corner; it is known, as a ghost, to every other rank whose cell its box reaches. A pair belongs to
//! the rank whose cell holds the corner of both maxima of minima, which is in both boxes: that rank knows both objects, and no
//! other rank reports the pair. So each pair is found exactly once, without a second pass.
//!
//! ```no_run
//! use trisap::{Aabb, Serial};
//! use trisap_mpi::{Settings, SplitWorld};
//!
//! let universe = mpi::initialize().ok_or("MPI runs already")?;
//! let mut world = SplitWorld::new(&universe.world(), &Settings::default())?;
//! if world.rank() == 0 {
//!     world.insert(7, Aabb::new([0.0; 3], [1.0; 3]))?;
//!     world.insert(9, Aabb::new([0.5; 3], [1.5; 3]))?;
//! }
//! world.step(trisap::Kernels::detect(), &Serial)?;
//! // On one of the ranks:
//! world.visit_pairs(|[low, high]| println!("{low} touches {high}"));
//! // Each rank moves what it owns.
//! world.update(|_key, aabb| Aabb::new(aabb.min.map(|x| x + 0.1), aabb.max.map(|x| x + 0.1)))?;
//! world.step(trisap::Kernels::detect(), &Serial)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod balance;
mod events;
mod exchange;
mod fault;
mod file;
mod links;
mod local;
mod message;
mod objects;
mod overlap;
mod pairs;
mod route;
mod settings;
mod split;
mod stats;
mod table;
mod world;

pub use fault::Fault;
pub use message::VERSION;
pub use settings::Settings;
pub use stats::{Stage, Stats};
pub use table::KeyPair;
pub use world::SplitWorld;
