//! Boxes, their keys, their records in the frame of a leaf, and the lines that casts move along.

pub(crate) mod aabb;
mod algebra;
pub(crate) mod extent;
pub(crate) mod key;
pub(crate) mod line;
pub(crate) mod record;
