//! Recordings of moving boxes in Broadmark's `.aabbs` format: the boxes of every object in every frame.
//!
//! A [`Recording`] is read at once; a [`Reader`] goes frame by frame through files that are larger than memory; a
//! [`Writer`] writes them. The length of a file is compared with its header before anything is allocated, so a
//! file that is cut off, too long or no recording at all is an [`Error`] that says so.
//!
//! The format is little endian: `char scene[128]; char objects[128]; i32 count; i32 frames; i32 0; i32 0;
//! f32 world_min[4]; f32 world_max[4]`, then `frames + 1` blocks of `count` boxes, a box being
//! `f32 min[4]; f32 max[4]` with an unused fourth component. [`Header::frames`] counts the blocks.

mod error;
mod header;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use error::Error;
pub use header::Header;
pub use read::{Reader, Recording};
pub use write::Writer;

/// A box as it stands in a file: the minimum corner, zero, the maximum corner, zero.
/// [`Boxes::padded`](crate::Boxes::padded) takes slices of it.
pub type PaddedBox = [f32; 8];
