//! Sequences of operations, decoded from bytes, so that one harness serves proptest, a fuzzer, a long run and the C ABI.
//!
//! The first [`HEADER`](format::HEADER) bytes say what the world is like, every [`OPERATION`](format::OPERATION) bytes after them
//! what is done: a kind, an argument and the seed of the boxes, slots and numbers that it takes. So every sequence of bytes
//! means something, a change to one operation leaves the others as they are, and `tests/cpp/sequences.cpp` can do the same with the
//! C ABI: the counts and the hash of a [`Tally`] must agree.
//!
//! After every operation the world validates itself and agrees with a [`Model`](crate::model::Model), after every step with brute
//! force; and a twin with other kernels, workers and job systems says the same byte for byte.
//!
//! In half of the worlds leaves have 16 objects instead of 512, and trees begin at 3, so that small ones take all paths.

mod draw;
mod filters;
pub mod format;
mod life;
mod loading;
mod moving;
mod questions;
mod steps;
mod tally;
mod values;

pub use life::play;
pub use tally::Tally;
