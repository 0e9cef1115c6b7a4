//! The C ABI of trisap. `include/trisap.h` is generated from this crate; `ffi/README.md` is its manual.
//!
//! Each public module is a part of the header. `border` is where the caller's pointers become Rust's, `call` where worlds are
//! entered.
//!
//! # Safety
//!
//! A mistake of the caller that can be seen is a status. The rest is the contract of every function here:
//!
//! - A pointer that is not null points to memory of the type, or of the length, that the function says. Input is
//!   initialised.
//! - Any number of threads may read what results point to, until the next step or load. Threads that change a world
//!   while others are inside are refused as busy, and so are those that look at one that is being changed.
//! - Ids are those of this world: the ids of another one are not told apart from them.
//! - Nothing else writes to the memory of a world, and it stays in its place while a call runs.
//! - Callbacks end only by returning: no exception, no `longjmp`.
//!
//! # Panics
//!
//! `trisap-core` does not panic, and neither does this crate. If they did, the panic would end the process and not
//! cross the border: Rust aborts if an unwinding panic reaches the end of an `extern "C"` function. So nothing is
//! caught here.

#![no_std]
#![allow(unsafe_code, reason = "this crate is the border to C")]
#![allow(non_camel_case_types, reason = "the types are named as in the header")]
#![allow(clippy::missing_safety_doc, reason = "one contract for all functions, above")]

#[cfg(any(feature = "std", test))]
extern crate std;

mod border;
#[cfg(all(feature = "panic-handler", not(feature = "std"), not(test)))]
mod panic;

// The rest in the order of use, in which the header declares it: a configuration, its size, a world, objects, steps, their results,
// queries, other memory, snapshots, boxes without a world.
pub mod version;

pub mod status;

pub mod aabb;

pub mod structs;

pub mod report;

mod call;

pub mod world;

pub mod objects;

pub mod filter;

pub mod resting;

pub mod jobs;

pub mod step;

pub mod events;

pub mod values;

pub mod contacts;

pub mod stats;

pub mod among;

pub mod query;

pub mod within;

pub mod batch;

pub mod view;

pub mod shift;

pub mod moving;

pub mod snapshot;

pub mod once;
