//! Whom an object meets: asked before a pair is written, so that a pair that nobody wants costs no room.

use bytemuck::{Pod, Zeroable};

/// Whether there can be filters. A lean program does without their code.
pub(crate) const FILTERS: bool = cfg!(feature = "large");

/// Classes that the class matrix knows.
pub(crate) const CLASSES: usize = 32;

/// Whom an object meets. Two objects make a pair if each one's group is in the other one's mask, and their classes meet (see
/// [`World::set_classes`](crate::World::set_classes)).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Pod, Zeroable)]
pub struct Filter {
    /// The groups that the object is in, one bit each.
    pub group: u32,
    /// The groups that it meets.
    pub mask: u32,
    /// Its class, below 32: for instance static, kinematic, dynamic, sensor.
    pub class: u32,
}

impl Filter {
    /// In all groups, meets all groups, class 0: what a new object has.
    pub const ALL: Self = Self { group: u32::MAX, mask: u32::MAX, class: 0 };

    /// Of a class, in all groups, meets all groups.
    #[must_use]
    pub const fn class(class: u32) -> Self {
        Self { class, ..Self::ALL }
    }

    /// Class 0, with a group and a mask.
    #[must_use]
    pub const fn groups(group: u32, mask: u32) -> Self {
        Self { group, mask, class: 0 }
    }
}

impl Default for Filter {
    fn default() -> Self {
        Self::ALL
    }
}

/// A caller's own rule: whether the objects in two slots, the lower one first, make a pair.
///
/// It is asked from any worker, at any time during the step, only of boxes that overlap (with their
/// margins), and has to answer the same as long
/// as neither object was [refiltered](crate::World::refilter): pairs of resting objects are not asked about again.
pub type Rule<'r> = dyn Fn(u32, u32) -> bool + Sync + 'r;

/// Whether two objects make a pair by their filters and the rows of the class matrix.
#[inline(always)]
pub(crate) fn meet(a: &Filter, b: &Filter, row: impl Fn(usize) -> u32) -> bool {
    let class = |a: &Filter, b: &Filter| row(a.class as usize % CLASSES) >> (b.class % 32) & 1;
    let groups = a.group & b.mask != 0 && b.group & a.mask != 0;
    groups && class(a, b) & class(b, a) != 0
}
