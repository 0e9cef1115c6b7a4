//! Boxes.

/// A closed box: what lies on its faces belongs to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Aabb {
    /// The least x, y and z.
    pub min: [f32; 3],
    /// The greatest x, y and z.
    pub max: [f32; 3],
}

impl Aabb {
    /// A box from its corners.
    #[must_use]
    pub const fn new(min: [f32; 3], max: [f32; 3]) -> Self {
        Self { min, max }
    }

    /// Whether no minimum is above its maximum, or not a number. Infinity is allowed.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        (0..3).all(|k| self.min[k] <= self.max[k])
    }

    /// Whether two boxes share a point.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|k| self.overlaps_on(other, k))
    }

    pub(crate) fn overlaps_on(&self, other: &Self, k: usize) -> bool {
        self.min[k] <= other.max[k] && other.min[k] <= self.max[k]
    }

    pub(crate) fn contains(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.min[k] && other.max[k] <= self.max[k])
    }

    /// With a margin on each side, a share of the extent on each axis.
    pub(crate) fn expanded(&self, share: f32) -> Self {
        // Infinity less infinity is no number, and `max` takes the zero.
        let margin: [f32; 3] = std::array::from_fn(|k| (share * (self.max[k] - self.min[k])).max(0.0));
        Self {
            min: std::array::from_fn(|k| self.min[k] - margin[k]),
            max: std::array::from_fn(|k| self.max[k] + margin[k]),
        }
    }
}
