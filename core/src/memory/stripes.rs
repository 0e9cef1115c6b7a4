//! The items of a world that is swept in stripes: copies of its boxes, and where stripes start.

use bytemuck::{Pod, Zeroable};

/// The copy of a box, and whose it is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct Member {
    /// Along the axis of the sweep, across the stripes, and along the third axis.
    pub(crate) min: [i32; 3],
    pub(crate) max: [i32; 3],
    /// The slot, and above it the stripe.
    pub(crate) tag: u32,
}

/// Stripes that a world is cut into.
pub(crate) const STRIPES: usize = 8;

/// Where the stripes start, in ascending order.
pub(crate) type StripeStarts = [i32; STRIPES];
