//! Boxes as callers give them, and views of boxes in callers' memory.

use crate::key::KeyBox;
use bytemuck::{Pod, Zeroable};

/// An axis-aligned bounding box in `f32`, closed on all sides: touching boxes overlap.
///
/// Any unit will do, as long as it is the same for all. Infinite bounds are welcome (a ground plane, a
/// half-space); NaN and `min > max` are refused by the [`World`](crate::World).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Aabb {
    /// The lowest corner: x, y, z.
    pub min: [f32; 3],
    /// The highest corner: x, y, z.
    pub max: [f32; 3],
}

impl Aabb {
    /// A box from its lowest and highest corners.
    #[must_use]
    pub const fn new(min: [f32; 3], max: [f32; 3]) -> Self {
        Self { min, max }
    }

    /// The least box that holds a box in `f64`, seen from `origin`: minima are rounded down and maxima up, so that boxes
    /// that overlap in `f64` overlap in `f32` too. Nearest rounding would leave parts of objects outside their boxes.
    ///
    /// Keep `origin` near the objects; what is lost is precision alone, never a pair. A margin that the caller adds
    /// belongs into the `f64` box, so that the rounding comes after it.
    #[must_use]
    pub fn from_f64(min: [f64; 3], max: [f64; 3], origin: [f64; 3]) -> Self {
        let low = |k: usize| round_down(min[k], origin[k]);
        let high = |k: usize| round_up(max[k], origin[k]);
        Self { min: [low(0), low(1), low(2)], max: [high(0), high(1), high(2)] }
    }

    /// Whether the box can be accepted: no NaN, and `min <= max` on every axis.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        KeyBox::from_aabb(self).is_some()
    }

    /// Whether the closed boxes share a point; false where one of them is not [valid](Self::is_valid). Exact, also
    /// where the host flushes denormals to zero: integers are compared, as in a step.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        match (KeyBox::from_aabb(self), KeyBox::from_aabb(other)) {
            (Some(a), Some(b)) => a.overlaps(&b),
            _ => false,
        }
    }
}

/// The least `f32` that is not below `x - origin`, or NaN.
pub(crate) fn round_up(x: f64, origin: f64) -> f32 {
    -round_down(-x, -origin)
}

/// The greatest `f32` that is not above `x - origin`, or NaN.
pub(crate) fn round_down(x: f64, origin: f64) -> f32 {
    let difference = x - origin;
    // What the subtraction has rounded away, exactly; nothing where a number is infinite.
    let back = difference - x;
    let error = (x - (difference - back)) - (origin + back);
    let difference = if error < 0.0 { difference.next_down() } else { difference };
    let nearest = difference as f32;
    if f64::from(nearest) > difference { nearest.next_down() } else { nearest }
}

#[cfg(feature = "glam")]
impl From<(glam::Vec3, glam::Vec3)> for Aabb {
    fn from((min, max): (glam::Vec3, glam::Vec3)) -> Self {
        Self::new(min.to_array(), max.to_array())
    }
}

#[cfg(feature = "glam")]
impl From<Aabb> for (glam::Vec3, glam::Vec3) {
    fn from(aabb: Aabb) -> Self {
        (aabb.min.into(), aabb.max.into())
    }
}

/// Boxes in the caller's memory: three `f32` of the minimum and three of the maximum at fixed places in items
/// of a fixed size. Nothing is copied, and no alignment is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Boxes<'a> {
    bytes: &'a [u8],
    stride: usize,
    max_at: usize,
    count: usize,
}

/// The bytes of three `f32`.
const CORNER: usize = 12;

impl<'a> Boxes<'a> {
    /// Boxes one after another.
    #[must_use]
    pub fn new(boxes: &'a [Aabb]) -> Self {
        Self {
            bytes: bytemuck::cast_slice(boxes),
            stride: size_of::<Aabb>(),
            max_at: CORNER,
            count: boxes.len(),
        }
    }

    /// Boxes whose corners are padded to four floats, as SIMD maths libraries and `.aabbs` recordings have them:
    /// `[min x, y, z, _, max x, y, z, _]`.
    #[must_use]
    pub fn padded(boxes: &'a [[f32; 8]]) -> Self {
        Self { bytes: bytemuck::cast_slice(boxes), stride: 32, max_at: 16, count: boxes.len() }
    }

    /// Boxes inside larger items: an item starts with its minimum corner, is `stride` bytes long and has its
    /// maximum corner `max_at` bytes from its start. `None` where the corners overlap or do not fit the stride.
    /// A last item that is cut off after its maximum corner still counts.
    #[must_use]
    pub fn strided(bytes: &'a [u8], stride: usize, max_at: usize) -> Option<Self> {
        let item = max_at.checked_add(CORNER)?;
        if max_at < CORNER || item > stride {
            return None;
        }
        let count = bytes.len() / stride + usize::from(bytes.len() % stride >= item);
        Some(Self { bytes, stride, max_at, count })
    }

    /// How many boxes there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is no box.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The box at `index`.
    #[must_use]
    #[inline(always)]
    pub fn get(&self, index: usize) -> Option<Aabb> {
        let [min, max] = self.corners(index)?;
        Some(Aabb { min: bytemuck::cast(*min), max: bytemuck::cast(*max) })
    }

    /// The bytes of the corners of the box at `index`.
    #[inline(always)]
    pub(crate) fn corners(&self, index: usize) -> Option<[&'a [u8; CORNER]; 2]> {
        if index >= self.count {
            return None;
        }
        let item = self.bytes.get(index * self.stride..)?;
        Some([item.first_chunk()?, item.get(self.max_at..)?.first_chunk()?])
    }
}

impl<'a> From<&'a [Aabb]> for Boxes<'a> {
    fn from(boxes: &'a [Aabb]) -> Self {
        Self::new(boxes)
    }
}
