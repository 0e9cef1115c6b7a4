//! Views of boxes in the caller's memory.

use super::aabb::Aabb;
use bytemuck::NoUninit;

/// Boxes in the caller's memory. Each item has three `f32` of the minimum and three of the maximum at fixed
/// places. Nothing is copied, and any alignment is right.
#[derive(Clone, Copy, Debug)]
pub struct Boxes<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) stride: usize,
    /// Where the maximum corner ends in an item.
    pub(crate) end: usize,
    count: usize,
    /// The same boxes, if they are one after another and aligned. Others are read byte by byte.
    pub(crate) packed: &'a [Aabb],
}

/// The bytes of three `f32`.
pub(crate) const CORNER: usize = 12;

impl<'a> Boxes<'a> {
    /// Boxes one after another.
    #[must_use]
    pub fn new(boxes: &'a [Aabb]) -> Self {
        let bytes = bytemuck::cast_slice(boxes);
        Self { bytes, stride: 2 * CORNER, end: 2 * CORNER, count: boxes.len(), packed: boxes }
    }

    /// Boxes whose corners are padded to four floats, as in SIMD maths libraries and `.aabbs` recordings:
    /// `[min x, y, z, _, max x, y, z, _]`.
    #[must_use]
    pub fn padded(boxes: &'a [[f32; 8]]) -> Self {
        let bytes = bytemuck::cast_slice(boxes);
        Self { bytes, stride: 32, end: 28, count: boxes.len(), packed: &[] }
    }

    /// Boxes inside larger items of `stride` bytes. An item starts with its minimum corner and has its
    /// maximum corner `max_at` bytes later. `None` if the corners overlap or do not fit the stride. A last
    /// item that ends right after its maximum corner counts.
    #[must_use]
    pub fn strided(bytes: &'a [u8], stride: usize, max_at: usize) -> Option<Self> {
        let end = max_at.checked_add(CORNER)?;
        if max_at < CORNER || end > stride {
            return None;
        }
        let count = bytes.len() / stride + usize::from(bytes.len() % stride >= end);
        let is_packed = stride == 2 * CORNER;
        let packed = if is_packed { bytemuck::try_cast_slice(bytes).unwrap_or_default() } else { &[] };
        Some(Self { bytes, stride, end, count, packed })
    }

    /// The boxes inside the caller's own items: `Boxes::of(&bodies, |body| &body.aabb)`. `None` if the box is
    /// no part of its item.
    ///
    /// ```
    /// use trisap_core::{Aabb, Boxes};
    ///
    /// #[repr(C)]
    /// #[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
    /// struct Body {
    ///     mass: f32,
    ///     aabb: Aabb,
    /// }
    ///
    /// let bodies = [Body { mass: 1.0, aabb: Aabb::new([0.0; 3], [1.0; 3]) }; 2];
    /// let boxes = Boxes::of(&bodies, |body| &body.aabb).unwrap();
    /// assert_eq!((boxes.len(), boxes.get(1)), (2, Some(bodies[1].aabb)));
    /// assert!(boxes.iter().eq(bodies.map(|body| body.aabb)));
    /// ```
    #[must_use]
    pub fn of<T: NoUninit>(items: &'a [T], aabb: impl Fn(&T) -> &Aabb) -> Option<Self> {
        let Some(first) = items.first() else { return Some(Self::new(&[])) };
        let at = (&raw const *aabb(first)).addr().checked_sub((&raw const *first).addr())?;
        if at.checked_add(size_of::<Aabb>())? > size_of::<T>() {
            return None;
        }
        let bytes = bytemuck::cast_slice::<T, u8>(items).get(at..)?;
        Self::strided(bytes, size_of::<T>(), CORNER)
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
    pub fn get(&self, index: usize) -> Option<Aabb> {
        self.packed.get(index).copied().or_else(|| self.apart(index))
    }

    /// The same, number by number.
    #[cold]
    #[inline(never)]
    pub(crate) fn apart(&self, index: usize) -> Option<Aabb> {
        let item = self.items_from(index).get(..self.end)?;
        let corner = |b: &[u8; CORNER]| {
            let word = |k: usize| f32::from_ne_bytes([b[k], b[k + 1], b[k + 2], b[k + 3]]);
            [word(0), word(4), word(8)]
        };
        Some(Aabb { min: corner(item.first_chunk()?), max: corner(item.last_chunk()?) })
    }

    /// All boxes in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Aabb> + use<'a> {
        let boxes = *self;
        (0..self.count).map(move |index| boxes.get(index).unwrap_or_default())
    }

    /// The bytes of the items from `index` on.
    pub(crate) fn items_from(&self, index: usize) -> &'a [u8] {
        // For a larger index the product could overflow.
        if index >= self.count {
            return &[];
        }
        self.bytes.get(index * self.stride..).unwrap_or_default()
    }

    /// Takes the next four of some items: such boxes, and their end.
    #[inline(always)]
    pub(crate) fn four(&self, items: &mut &'a [u8]) -> Self {
        let four = Self { bytes: items, ..*self };
        *items = items.get(4 * self.stride..).unwrap_or_default();
        four
    }
}

/// Slices, arrays and vectors.
impl<'a, T: AsRef<[Aabb]> + ?Sized> From<&'a T> for Boxes<'a> {
    fn from(boxes: &'a T) -> Self {
        Self::new(boxes.as_ref())
    }
}
