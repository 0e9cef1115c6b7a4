//! Filters: whom an object meets. They are asked before a pair is written, so unwanted pairs take no room.

use bytemuck::{Pod, Zeroable};

/// Classes that the class matrix knows.
pub(crate) const CLASSES: usize = 32;

/// Whom an object meets. Two objects make a pair if each one's mask has a group of the other, and their
/// classes meet (see [`World::set_classes`](crate::World::set_classes)).
#[doc(alias("InteractionGroups", "CollisionLayers"))]
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Pod, Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Filter {
    /// The groups that the object is in, one bit each.
    #[doc(alias("memberships", "category"))]
    pub group: u32,
    /// The groups that it meets.
    pub mask: u32,
    /// Its class, below 32: static, kinematic, dynamic or sensor, for instance.
    pub class: u32,
}

impl Filter {
    /// The filter of a new object: in all groups, meets all groups, class 0.
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

/// A rule of the caller: whether the objects in two slots, the lower one first, make a pair.
///
/// Any worker may ask it at any time in the step, only about boxes that overlap with what is around them:
/// margins and [predicted boxes](crate::Config::predicted). It has to answer the same until one of the
/// objects is [refiltered](crate::World::refilter), as pairs at rest are not asked about again. Panics: see
/// [`World::step`](crate::World::step).
#[doc(alias("pair_filter", "filter_contact_pair"))]
pub type Rule<'r> = dyn Fn(u32, u32) -> bool + Sync + 'r;

/// Whether two filters meet; `row` gives the rows of the class matrix.
#[inline(always)]
pub(crate) fn meet(a: &Filter, b: &Filter, row: impl Fn(usize) -> u32) -> bool {
    let class = |a: &Filter, b: &Filter| row(a.class as usize % CLASSES) >> (b.class % 32) & 1;
    let groups = a.group & b.mask != 0 && b.group & a.mask != 0;
    groups && class(a, b) & class(b, a) != 0
}

/// Groups, masks and classes fold to so many bits each, so that one number tells of many filters.
const FOLD: u32 = 10;
const FIELD: u32 = (1 << FOLD) - 1;

const fn folded([class, group, mask]: [u32; 3]) -> u32 {
    const fn fold(bits: u32) -> u32 {
        (bits | bits >> FOLD | bits >> (2 * FOLD) | bits >> (3 * FOLD)) & FIELD
    }
    fold(class) | fold(group) << FOLD | fold(mask) << (2 * FOLD)
}

/// What the filter in a slot has that others may look for. Those of many objects are joined by "or".
pub(crate) fn offer(filters: &[Filter], slot: usize) -> u32 {
    filters.get(slot).map_or(0, |of| folded([1 << (of.class % 32), of.group, of.mask]))
}

/// What a filter looks for in [others](offer); `None` if all.
pub(crate) fn demand(of: &Filter, row: u32) -> Option<u32> {
    (of.group & of.mask & row != u32::MAX).then_some(folded([row, of.mask, of.group]))
}

/// Whether there may be somebody to meet. `false` is certain.
pub(crate) const fn may_meet(demand: u32, offer: u32) -> bool {
    let both = demand & offer;
    // Each of the three has a bit.
    both & FIELD != 0 && both >> FOLD & FIELD != 0 && both >> (2 * FOLD) != 0
}

/// Whether every two of these filters meet. `true` is certain; `false` may be wrong. Filters of free slots
/// count too. O(filters).
#[inline(always)]
pub(crate) fn all_meet(filters: &[Filter], row: impl Fn(usize) -> u32) -> bool {
    // An object in all groups needs no look: it meets every mask that is not empty.
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
