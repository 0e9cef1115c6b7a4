//! What a world is made for.

use crate::error::Error;
use bytemuck::{Pod, Zeroable};

// What a build has beside pairs and lean worlds. `Sizes::of` refuses a configuration that asks for more.
pub(crate) const TREE: bool = cfg!(feature = "large");
pub(crate) const LISTS: bool = cfg!(feature = "lists");
pub(crate) const EVENTS: bool = cfg!(feature = "events");
pub(crate) const MARGINS: bool = cfg!(feature = "margins");
pub(crate) const FILTERS: bool = cfg!(feature = "filters");
pub(crate) const VALUES: bool = cfg!(feature = "values");

/// Methods that give the same value with another field. What that means stands there.
macro_rules! with {
    ($($name:ident($($given:ident: $type:ty)?), $field:ident = $value:expr;)+) => {$(
        #[doc = concat!("The same with another [", stringify!($field), "](Self::", stringify!($field), ").")]
        #[must_use]
        pub const fn $name(self $(, $given: $type)?) -> Self {
            Self { $field: $value, ..self }
        }
    )+};
}
pub(crate) use with;

/// How much fits into a world. No limit loses anything silently: see each field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Capacity {
    /// The most living objects. One more is [`Error::ObjectsFull`].
    pub objects: u32,
    /// The most boxes that reach beyond their leaf. If a scene has more, the tree uses larger leaves, which
    /// is slower; with zero it is one leaf. Half of `objects` suits most scenes. Worlds for up to 64 objects
    /// and lean ones have no tree and do not use this.
    pub leaf_refs: u32,
    /// The most pairs that a step can return. If there are more, the step counts them and reports
    /// [`Error::PairsFull`]. A world also keeps the overlaps of its fat boxes here; without room for
    /// them its steps are slower: [`Reason::NoRoomForSurplus`](crate::Reason::NoRoomForSurplus).
    pub pairs: u32,
}

/// That of [`Config::default`].
impl Default for Capacity {
    fn default() -> Self {
        Self::for_objects(1024)
    }
}

impl Capacity {
    /// A capacity that suits most scenes: half as many leaf references as objects, and eight pairs an object.
    #[must_use]
    pub const fn for_objects(objects: u32) -> Self {
        Self { objects, leaf_refs: objects / 2, pairs: objects.saturating_mul(8) }
    }

    with! {
        with_pairs(pairs: u32), pairs = pairs;
        with_leaf_refs(leaf_refs: u32), leaf_refs = leaf_refs;
    }
}

/// Which pairs a step returns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Mode {
    /// Exactly the closed overlaps of the boxes as given.
    #[default]
    Exact,
    /// The overlaps of the boxes with their margins: a superset that changes less often. The surplus is
    /// counted by [`Step::surplus`](crate::Step::surplus). Where the host flushes denormals and there is no
    /// margin, a denormal side may count as zero, outwards.
    Fat,
}

/// How far a box may move before it counts as moved. Its fat box is the box of its last move, grown by
/// `clamp(per_extent * extent, min, max)` on every side (erratum E2). The extent is the largest side of the
/// box, or less for flat boxes: see [`per_extent`](Self::per_extent). A box that is given by itself also gets
/// a new one where the largest side of the old one is more than 16 times its own and its margin.
///
/// In [`Mode::Fat`] these boxes are what the pairs are of; where one in 16 is left in a step that hands over
/// all boxes, all are made anew. In an exact world a margin changes no pair, and in one without a tree no step.
/// It pays there where many objects rest or move little; it is enough that the moving ones have one: see
/// [`World::set_margin`](crate::World::set_margin). Where many leave their fat boxes in each step, these are
/// left unused: see [`Config::fixed_margins`]. Unless the caller leaves that out, what is swept is also
/// [predicted](Config::predicted), so that it holds objects that move steadily.
#[doc(alias("fat_aabb", "skin", "speculative_margin"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Margin {
    /// A share of the object's largest side. That side counts only up to eight times the smallest one above
    /// zero. A box without bounds counts as size zero.
    pub per_extent: f32,
    /// Lower bound, a length.
    pub min: f32,
    /// Upper bound, a length.
    pub max: f32,
}

impl Margin {
    /// The same length for objects of every size.
    #[must_use]
    pub const fn length(length: f32) -> Self {
        Self { per_extent: 0.0, min: length, max: length }
    }

    /// A share of the object's size, without bounds.
    #[must_use]
    pub const fn share(per_extent: f32) -> Self {
        Self { per_extent, min: 0.0, max: f32::MAX }
    }

    /// Whether all parts are finite, none is negative, and the bounds are in order.
    pub(crate) const fn is_valid(&self) -> bool {
        // NaN is not at least zero.
        self.per_extent >= 0.0
            && self.per_extent <= f32::MAX
            && self.min >= 0.0
            && self.min <= self.max
            && self.max <= f32::MAX
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.is_valid() { Ok(()) } else { Err(Error::BadMargin) }
    }
}

/// What a world is made for: its capacity and the parts that it pays for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Config {
    /// How much fits.
    pub capacity: Capacity,
    /// Which pairs a step returns.
    pub mode: Mode,
    /// The margin of new objects: the least that a fat box has around the box. `None`: steps choose.
    pub margin: Option<Margin>,
    /// Whether steps tell found and lost pairs. Costs a second pair buffer and the boxes of the last step.
    pub events: bool,
    /// Whether objects have a [`Filter`](crate::Filter), which says whom they meet. Costs 12 bytes an object.
    /// Needs the feature `filters`.
    pub filters: bool,
    /// Whether objects have a value of 64 bits for the caller's use: see
    /// [`World::set_value`](crate::World::set_value). Costs 8 bytes an object, 16 with events, and no time of
    /// a step. Needs the feature `values`.
    pub values: bool,
    /// Whether a world for up to 256 objects does without a tree, vectors and scratch memory, as worlds for
    /// up to 64 always do. It takes a quarter to two fifths of the bytes and is faster on a microcontroller. On
    /// a processor with vectors it is slower from about 100 objects on.
    pub lean: bool,
    /// The most workers of a step, from 1 to 32. Each has its own scratch memory; more than one need a buffer
    /// to merge their pairs.
    pub workers: u32,
    /// Whether fat boxes stay in use however objects move, each until its box leaves it: so a step takes as
    /// long as few or many objects make it, and none is there for all of them at once. If not, all are made
    /// anew when that costs less than to search for the objects that leave theirs, and are left unused for
    /// some steps where they cost more than they spare. In [`Mode::Fat`] it changes which pairs are told.
    pub fixed_margins: bool,
    /// Whether steps sweep boxes that are predicted from each object's motion and hold it for some steps, so
    /// that steps in which things lie, hang, roll or fly on cost little. They are used while they pay, and
    /// change no result. In an exact world a margin is the least around each box; in a fat one boxes are
    /// predicted around the boxes with margins. 24 bytes an object. Worlds without a tree have none.
    pub predicted: bool,
    /// What tests have fixed.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) forced: Forced,
}

impl Default for Config {
    /// Room for 1,024 objects, with the proportions of [`Capacity::for_objects`].
    fn default() -> Self {
        Self::new(Capacity::default())
    }
}

impl Config {
    /// Exact pairs, one worker; predicted boxes; no margin, events, filters or values.
    #[must_use]
    pub const fn new(capacity: Capacity) -> Self {
        Self {
            capacity,
            mode: Mode::Exact,
            margin: None,
            events: false,
            filters: false,
            values: false,
            lean: false,
            workers: 1,
            fixed_margins: false,
            predicted: true,
            forced: Forced(0),
        }
    }

    with! {
        with_capacity(capacity: Capacity), capacity = capacity;
        with_mode(mode: Mode), mode = mode;
        with_margin(margin: Margin), margin = Some(margin);
        with_events(), events = true;
        with_filters(), filters = true;
        with_values(), values = true;
        with_lean(), lean = true;
        with_workers(workers: u32), workers = workers;
        with_fixed_margins(), fixed_margins = true;
        without_predicted_boxes(), predicted = false;
    }

    /// For tests: the same with a choice of steps fixed, or free again. No choice changes a pair.
    #[cfg(feature = "validate")]
    #[doc(hidden)]
    #[must_use]
    pub const fn with_forced(mut self, choice: u8, always: Option<bool>) -> Self {
        let how = match always {
            None => 0,
            Some(on) => 1 + on as u16,
        };
        self.forced = Forced(self.forced.0 & !(3 << (2 * choice)) | how << (2 * choice));
        self
    }
}

/// What tests have fixed, two bits a choice. Products have fixed nothing.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Forced(u16);

impl Forced {
    /// Whether a choice is fixed to never or always.
    pub(crate) const fn of(self, choice: u8) -> Option<bool> {
        match self.0 >> (2 * choice) & 3 {
            _ if !cfg!(feature = "validate") => None,
            0 => None,
            how => Some(how == 2),
        }
    }

    /// What sizes depend on, also in a snapshot.
    pub(crate) const fn of_sizes(self) -> Self {
        Self(self.0 & 3 << (2 * SMALL_LEAVES))
    }
}

/// Whether steps test only the objects that have moved. Always: after every complete step, if the scratch memory
/// has room for a list of them: a twelfth of all, a sixth with slots of 16 bits, or a third where there are few.
/// Never: every step finds all pairs anew, even if nothing has moved.
pub(crate) const MOVERS_ONLY: u8 = 0;
/// Whether leaves are divided in such steps. Always: from the first one on.
pub(crate) const FINE_LEAVES: u8 = 1;
/// Whether steps are shared between the workers of the executor.
pub(crate) const SHARING: u8 = 2;
/// Whether steps that fill all leaves find only the pairs of objects that have moved. Always: after every
/// complete step, if [`MOVERS_ONLY`] is free.
pub(crate) const MOVERS_BY_LEAF: u8 = 3;
/// Whether leaves have a 32nd of the usual number of objects. Always: small worlds take all paths.
pub(crate) const SMALL_LEAVES: u8 = 4;
