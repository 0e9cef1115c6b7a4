//! When the tree changes, and how much of it in one step. The table of constants in `NOTEBOOK.md` says what
//! was measured for each.

// When planes are made anew.

/// A sweep is heavy if it tests this many times as many pairs in vain as the first one after new planes.
pub(crate) const HEAVY: u64 = 4;
/// It is also heavy if it has half as many ghosts again as that first one, and one for this many objects.
pub(crate) const GHOSTS_SHARE: u64 = 32;
/// This many heavy sweeps in a row are a reason for new planes: a single one may be an odd frame.
pub(crate) const HEAVY_STEPS: u8 = 3;
/// The most full steps from one try at better planes, or at more levels, to the next.
pub(crate) const PATIENCE: u8 = 64;

// How a plane is chosen.

/// Boxes that are sampled to choose an axis.
pub(crate) const AXIS_SAMPLE: usize = 512;
/// From so many objects on, one in so many tells where the planes of a leaf are to be. Odd, since every
/// second object may be of another kind.
pub(crate) const SAMPLED_FROM: usize = 65_536;
pub(crate) const SAMPLED_SHARE: usize = 7;
/// Members of a leaf that are sampled for the planes of its sub-leaves.
pub(crate) const SUB_SAMPLE: usize = 128;
/// One in this many of the boxes below a plane may cross it: every crossing box is swept on both sides.
pub(crate) const CROSSING: usize = 2;
/// A plane is lopsided with less than one in this many of the objects on a side.
pub(crate) const LOPSIDED: usize = 4;
/// A box is a large object if it reaches this many times the size of its cell beyond it.
pub(crate) const FAR: f32 = 1.0;
/// Large objects may have this many ghosts for each object. With more, larger leaves cost less.
pub(crate) const LARGE_PER_OBJECT: u64 = 8;

// Where most objects are.

/// Minima in a sample of where most are.
pub(crate) const SPREAD_SAMPLE: usize = 32;
/// The least and the greatest numbers of a whole sample on an axis that do not count.
pub(crate) const OUTLIERS: usize = 2;
/// An extent this many times as long as where most minima are is too long for the steps of a grid.
pub(crate) const SPARSE: f32 = 8.0;

// How much changes in one step.

/// Where all leaves are filled in each step, full ones are divided once they have one in this many objects.
pub(crate) const CROWDED_SHARE: u32 = 16;
/// Leaves with one in this many objects are divided in one step.
pub(crate) const DIVIDED_SHARE: u32 = 64;
/// Leaves with at least this many objects are divided in one step.
pub(crate) const DIVIDED_AT_LEAST: u32 = 1024;
/// A leaf is made tight for so many times its members as there were movers.
pub(crate) const REFIT_SHARE: usize = 4;
