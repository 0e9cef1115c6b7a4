//! Temporal inference: who has moved, by expanded boxes.

use crate::Aabb;

#[derive(Clone, Debug)]
pub(crate) struct Inference {
    /// The expanded box of each object, which stays until the box leaves it (E5).
    pub(crate) expanded: Vec<Aabb>,
    /// Whether an object is dynamic: its expanded box is another one than in the last step.
    pub(crate) is_moved: Vec<bool>,
    margin: f32,
}

impl Inference {
    pub(crate) fn new(objects: usize, margin: f32) -> Self {
        // A box that contains none: everybody counts as moved at first (E6).
        let nothing = Aabb::new([f32::NAN; 3], [f32::NAN; 3]);
        Self { expanded: vec![nothing; objects], is_moved: vec![false; objects], margin }
    }

    /// Takes the boxes of a step, and tells how many objects have moved.
    pub(crate) fn update(&mut self, boxes: &[Aabb]) -> usize {
        assert_eq!(boxes.len(), self.expanded.len(), "a box for each object");
        let mut moved = 0;
        for ((aabb, expanded), is_moved) in boxes.iter().zip(&mut self.expanded).zip(&mut self.is_moved) {
            // E3, E4.
            *is_moved = !expanded.contains(aabb);
            if *is_moved {
                assert!(aabb.is_valid(), "{aabb:?} is no box");
                *expanded = aabb.expanded(self.margin);
                moved += 1;
            }
        }
        moved
    }
}
