//! The copies of the boxes of a small world, in the stripes that they are swept in.

use bytemuck::{Pod, Zeroable};

/// A box that is swept, and whose it is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Member {
    /// Along the axis of the sweep, across the stripes, and along the third axis.
    pub(crate) min: [i32; 3],
    pub(crate) max: [i32; 3],
    /// The slot, and above it the strip.
    pub(crate) tag: u32,
}

/// Strips that a world is cut into.
pub(crate) const STRIPES: usize = 8;

/// Where the stripes begin, in ascending order.
pub(crate) type Planes = [i32; STRIPES];
