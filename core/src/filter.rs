//! Whom an object meets: asked before a pair is written, so that a pair that is not wanted takes no room.

use bytemuck::{Pod, Zeroable};

/// Whether there can be filters. A lean program does without their code.
pub(crate) const FILTERS: bool = cfg!(feature = "large");

/// Classes that the class matrix knows.
pub(crate) const CLASSES: usize = 32;

/// Whom an object meets. Two objects make a pair if each one's group is in the other one's mask, and their classes meet (see
/// [`World::set_classes`](crate::World::set_classes)).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Pod, Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

/// Whether every two objects with these filters make a pair: `true` only if it is so, `false` now and then though it is so. Filters
/// of slots that are free count as well. O(filters).
#[inline(always)]
pub(crate) fn all_meet(filters: &[Filter], row: impl Fn(usize) -> u32) -> bool {
    // An object in all groups is left out of `groups`: it meets every mask that is not empty.
    let (mut groups, mut masks, mut empty, mut classes) = (0, u32::MAX, false, 0);
    for filter in filters {
        groups |= if filter.group == u32::MAX { 0 } else { filter.group };
        masks &= filter.mask;
        empty |= filter.group == 0 || filter.mask == 0;
        classes |= 1u32 << (filter.class % 32);
    }
    let by_class = || (0..CLASSES).all(|class| classes >> class & 1 == 0 || classes & !row(class) == 0);
    !empty && groups & !masks == 0 && by_class()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over all sets of three filters of a few groups, masks and classes: where all are said to meet, they do, and it is said where
    /// it matters.
    #[test]
    fn all_are_said_to_meet_only_if_every_two_meet() {
        let bits = [0, 1, 2, 3, 0x8000_0001, u32::MAX];
        let filters: [Filter; 72] = core::array::from_fn(|at| Filter {
            group: bits[at % 6],
            mask: bits[at / 6 % 6],
            class: at as u32 / 36 * 31,
        });
        let (mut said, mut so) = (0, 0);
        for rows in
            [[u32::MAX; 32], [!(1 << 31); 32], core::array::from_fn(|at| if at == 0 { 1 } else { u32::MAX })]
        {
            let row = |class: usize| rows[class];
            for at in 0..72 * 72 * 72 {
                let set = [filters[at % 72], filters[at / 72 % 72], filters[at / 72 / 72]];
                let meet_all = set.iter().all(|a| set.iter().all(|b| meet(a, b, row)));
                let all_meet = all_meet(&set, row);
                assert!(meet_all || !all_meet, "{set:?} do not all meet");
                said += u32::from(all_meet);
                so += u32::from(meet_all);
            }
        }
        assert!(said > 0 && said < so);
    }
}
