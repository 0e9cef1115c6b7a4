//! Boxes from boxes: unions, boxes that are grown or moved.
//!
//! Plain `f32` operations, rounded to nearest. They are for the caller's own boxes; a step does not use them.

use super::aabb::Aabb;

impl Aabb {
    /// A box from its centre and its half extents.
    ///
    /// ```
    /// use trisap_core::Aabb;
    ///
    /// let cube = Aabb::from_center([1.0; 3], [0.5; 3]);
    /// assert_eq!(cube, Aabb::new([0.5; 3], [1.5; 3]));
    /// assert_eq!((cube.center(), cube.half_extents()), ([1.0; 3], [0.5; 3]));
    /// assert!(cube.contains_point([1.5; 3]) && !cube.contains_point([1.0, 1.0, 2.0]));
    /// ```
    #[doc(alias = "from_half_extents")]
    #[must_use]
    pub fn from_center(center: [f32; 3], half_extents: [f32; 3]) -> Self {
        let corner = |sign: f32| [0, 1, 2].map(|k| center[k] + sign * half_extents[k]);
        Self::new(corner(-1.0), corner(1.0))
    }

    /// The centre; NaN on an axis without bounds.
    #[must_use]
    pub fn center(&self) -> [f32; 3] {
        // Halves first, so that the sum cannot overflow.
        [0, 1, 2].map(|k| 0.5 * self.min[k] + 0.5 * self.max[k])
    }

    /// The lengths of the sides.
    #[must_use]
    pub fn extents(&self) -> [f32; 3] {
        [0, 1, 2].map(|k| self.max[k] - self.min[k])
    }

    /// Half of the lengths of the sides.
    #[must_use]
    pub fn half_extents(&self) -> [f32; 3] {
        self.extents().map(|length| 0.5 * length)
    }

    /// The least box that holds both.
    ///
    /// ```
    /// use trisap_core::Aabb;
    ///
    /// let (a, b) = (Aabb::new([0.0; 3], [1.0; 3]), Aabb::new([2.0; 3], [3.0; 3]));
    /// assert_eq!(a.union(&b), Aabb::new([0.0; 3], [3.0; 3]));
    /// assert!(a.union(&b).contains(&a) && !a.contains(&b));
    /// ```
    #[doc(alias("merged", "merge"))]
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: [0, 1, 2].map(|k| self.min[k].min(other.min[k])),
            max: [0, 1, 2].map(|k| self.max[k].max(other.max[k])),
        }
    }

    /// Whether the other box is inside this one, sides included. False if a number is NaN.
    #[must_use]
    pub fn contains(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.min[k] && other.max[k] <= self.max[k])
    }

    /// Whether a point is inside, sides included.
    #[must_use]
    pub fn contains_point(&self, point: [f32; 3]) -> bool {
        self.contains(&Self::new(point, point))
    }

    /// The box grown by a length on every side; a negative length makes it smaller.
    #[doc(alias("loosened", "inflate", "expand"))]
    #[must_use]
    pub fn grown(&self, length: f32) -> Self {
        Self { min: self.min.map(|low| low - length), max: self.max.map(|high| high + length) }
    }

    /// The box moved by a vector.
    #[must_use]
    pub fn translated(&self, by: [f32; 3]) -> Self {
        Self { min: [0, 1, 2].map(|k| self.min[k] + by[k]), max: [0, 1, 2].map(|k| self.max[k] + by[k]) }
    }
}
