//! What a step did, and why.

use super::scratch::Work;

/// How a step found its pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Path {
    /// Nothing has moved: the pairs stay.
    #[default]
    Unchanged,
    /// A world for few objects, or a lean one: swept box by box from a sorted list.
    Lists,
    /// Few have moved: each mover was tested against the leaves that it reaches, the other pairs stay.
    Movers,
    /// Many have moved: all leaves were filled and swept.
    Full,
    /// As `Full`, after new planes for the whole tree.
    Rebuilt,
    /// Some have moved, and the others have many pairs: as `Full`, but the pairs of two objects that have not moved stay, and
    /// leaves were swept for the others alone.
    MoversByLeaf,
}

impl Path {
    pub(crate) const ALL: [Self; 6] =
        [Self::Unchanged, Self::Lists, Self::Movers, Self::Full, Self::Rebuilt, Self::MoversByLeaf];
}

/// Why a step took its [`Path`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Reason {
    /// Unchanged: nothing has moved.
    #[default]
    NoMovers,
    /// Lists: the world is swept box by box.
    FewObjects,
    /// Movers: few have moved: at most one object in thirteen where there are no pairs, one in sixteen with a pair or two an object,
    /// one in 28 with six.
    FewMovers,
    /// Full or movers by leaf: more have moved.
    ManyMovers,
    /// Movers, by leaf or not, or full: a test has it so.
    Fixed,
    /// Full or rebuilt: there was no complete step whose leaves could be used again, but the first step of all, one with
    /// too many pairs, or few objects, or a shift of the origin.
    NothingKept,
    /// Full or rebuilt: few have moved, but neither a leaf nor its neighbours have room for one of them.
    NoRoom,
    /// Rebuilt: the planes were made for a much smaller or larger number of objects.
    Outgrown,
    /// Rebuilt: the leaves have become too uneven.
    OutOfBalance,
    /// Lists, full or rebuilt: an exact world with margins had no room in its pair buffer for the overlaps of fat boxes, and
    /// found those of the boxes as given besides. With more room steps are cheaper: see [`Capacity::pairs`](crate::Capacity::pairs).
    NoRoomForSurplus,
}

impl Reason {
    pub(crate) const ALL: [Self; 10] = [
        Self::NoMovers,
        Self::FewObjects,
        Self::FewMovers,
        Self::ManyMovers,
        Self::Fixed,
        Self::NothingKept,
        Self::NoRoom,
        Self::Outgrown,
        Self::OutOfBalance,
        Self::NoRoomForSurplus,
    ];
}

/// A path, and why it was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Route {
    pub(crate) path: Path,
    pub(crate) reason: Reason,
}

impl Route {
    pub(crate) const UNCHANGED: Self = Self { path: Path::Unchanged, reason: Reason::NoMovers };
}

/// What a step did, and what it chose. All are counts or follow from counts, so equal calls give equal statistics on any
/// machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Stats {
    /// Living objects.
    pub objects: u32,
    /// Objects that are new or gone, or have left their fat box (without a margin: whose box has changed) since
    /// the last complete step.
    pub moved: u32,
    /// How the pairs were found.
    pub path: Path,
    /// Why that way.
    pub reason: Reason,
    /// Whether the leaves are the small ones for steps with few movers: an eighth as large.
    pub fine_leaves: bool,
    /// Whether the work was offered to the workers of the executor: from 4,096 objects on, in worlds with scratch memory.
    pub shared: bool,
    /// With margins: boxes that were given since the last complete step and lie farther from the object's last box than its
    /// margin. Such an object has no margin until it is slower: see [`Config::fixed_margins`](crate::Config::fixed_margins).
    pub outran: u32,
    /// Leaves of the tree; 1 where the world is swept from a list.
    pub leaves: u32,
    /// Leaves that had members when all leaves were filled last. Much fewer than there are: the planes do not fit the scene.
    pub leaves_in_use: u32,
    /// Members of the fullest leaf then. About 500 is usual; much more: boxes that no plane can part, or a bad tree.
    pub fullest_leaf: u32,
    /// Boxes swept in leaves where they are not at home.
    pub copies: u64,
    /// Pairs of boxes that were tested on all axes.
    pub candidates: u64,
    /// Candidates that share a step of their leaf's 16-bit grid, so that the `f32` boxes had to decide. Zero in small
    /// worlds, which compare nothing else.
    pub tied: u64,
    /// Overlapping pairs.
    pub pairs: u64,
    /// Pairs that the last step did not have.
    pub found: u64,
    /// Pairs that only the last step had.
    pub lost: u64,
    /// Exact mode with a margin: overlaps of fat boxes that the exact test dropped.
    pub surplus: u64,
    /// Large objects, which live in a list of their own: they are far larger than the leaves that they reach.
    pub large: u32,
    /// Objects whose leaf got new planes.
    pub rebalanced: u32,
    /// Whether `f32` is too coarse for some box where it stands: a side of it is below four steps of its
    /// coordinate. Boxes without any side count where the world has not even steps enough to tell them apart. The pairs are
    /// those of the boxes as given, but the boxes may have lost their shape before; shift the origin. Looked for in steps that
    /// fill all leaves from the boxes, one in 33 full steps at least; in worlds swept box by box, in every eighth step and where
    /// objects are new.
    pub coarse_resolution: bool,
}

/// What a step has done so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Progress {
    /// Pairs of swept boxes, whether they fit or not.
    pub(crate) pairs: u64,
    pub(crate) work: Work,
    pub(crate) leaves: u32,
    pub(crate) rebalanced: u32,
    pub(crate) coarse: Option<bool>,
    /// How many pairs are found, where the step has told its events: they stand behind the others.
    pub(crate) found: Option<u64>,
}
