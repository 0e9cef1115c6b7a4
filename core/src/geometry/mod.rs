//! Boxes and what they are stored as: keys, records in the frame of a leaf; and the lines of casts.

pub(crate) mod aabb;
pub(crate) mod boxes;
pub(crate) mod key;
pub(crate) mod line;
pub(crate) mod record;

#[cfg(test)]
#[path = "../../tests/kernels/keys.rs"]
mod keys;
