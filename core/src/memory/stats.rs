//! The statistics of a step: what it did, and why.

use bytemuck::Contiguous;

/// How a step found its pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Contiguous)]
#[repr(u8)]
#[non_exhaustive]
pub enum Path {
    /// Nothing has moved: the pairs stay.
    #[default]
    Unchanged,
    /// A world for few objects, or a lean one: every two boxes were tested, or, in one for more than 32
    /// objects, those that overlap along a sorted list.
    Lists,
    /// Few have moved: each mover was tested against the leaves that it reaches, and the other pairs stay.
    Movers,
    /// Many have moved: all leaves were filled and swept.
    Full,
    /// As `Full`, after new planes for the whole tree.
    Rebuilt,
    /// Many have moved, but most pairs stay: as `Full`, but leaves were swept for the pairs of moved objects
    /// alone, and the other pairs stay.
    MoversByLeaf,
}

/// Why a step took its [`Path`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Contiguous)]
#[repr(u8)]
#[non_exhaustive]
pub enum Reason {
    /// Unchanged: nothing has moved.
    #[default]
    NoMovers,
    /// Lists: the world has no tree.
    FewObjects,
    /// Movers: few have moved. That is at most one object in 13 if there are no pairs, one in 16 with a pair
    /// or two an object, one in 28 with six.
    FewMovers,
    /// Full or movers by leaf: more have moved.
    ManyMovers,
    /// Movers, movers by leaf or full: a test has fixed it.
    Fixed,
    /// Full or rebuilt: there were no leaves of a complete step to use again. So it is in the first step,
    /// after one with too many pairs or few objects, and after a shift of the origin.
    NothingKept,
    /// Full or rebuilt: few have moved, but a leaf and its neighbours had no room for one of them.
    NoRoom,
    /// Rebuilt: the tree had too many leaves or levels.
    Outgrown,
    /// Rebuilt: three steps in a row tested far more pairs in vain, or had far more ghosts, than new planes.
    OutOfBalance,
    /// Lists, full or rebuilt: a world had no room in its pair buffer for the overlaps of fat boxes, and also
    /// found those of the boxes that it reports. With more room steps are cheaper: see
    /// [`Capacity::pairs`](crate::Capacity::pairs).
    NoRoomForSurplus,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Route {
    pub(crate) path: Path,
    pub(crate) reason: Reason,
}

impl Route {
    pub(crate) const UNCHANGED: Self = Self { path: Path::Unchanged, reason: Reason::NoMovers };
}

/// What a step did, and what it chose. All of it follows from counts, so equal calls give equal statistics on
/// every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Stats {
    /// Living objects.
    pub objects: u32,
    /// Objects that are new or gone, or have left their fat box (without one: have another box, in a fat world
    /// another one with its margin) since the last complete step.
    pub moved: u32,
    /// How the pairs were found.
    pub path: Path,
    /// Why they were found that way.
    pub reason: Reason,
    /// Whether leaves are divided into sub-leaves, for steps with few movers.
    pub fine_leaves: bool,
    /// Whether the work was offered to the executor's workers: from 4,096 objects on, in worlds with a tree.
    pub shared: bool,
    /// How many boxes left their fat boxes since the last complete step, or are others where all fat boxes were
    /// made anew; in a fat world how many left their margins.
    pub outran: u32,
    /// Leaves of the tree; 1 in a world without one.
    pub leaves: u32,
    /// Leaves that had members when all leaves were last filled. If they are far fewer than `leaves`, the
    /// planes do not fit the scene.
    pub leaves_in_use: u32,
    /// Members of the fullest leaf then. About 500 is usual. Far more means boxes that no plane can part, or
    /// a bad tree.
    pub fullest_leaf: u32,
    /// Ghosts: boxes swept in leaves where they are not at home.
    pub copies: u64,
    /// Pairs of boxes that were tested on all axes.
    pub candidates: u64,
    /// Pairs of boxes in the same leaf that were not compared, since their filters do not meet.
    pub spared: u64,
    /// Candidates whose sides share a step of their leaf's 16-bit grid, so that the `f32` boxes had to
    /// decide. Zero in worlds without a tree, which compare nothing else.
    pub tied: u64,
    /// Overlapping pairs.
    pub pairs: u64,
    /// Pairs that the last step did not have.
    pub found: u64,
    /// Pairs that only the last step had.
    pub lost: u64,
    /// Overlaps of fat boxes that the test of the boxes dropped.
    pub surplus: u64,
    /// Large objects: far larger than the leaves that they reach, they are in a list of their own.
    pub large: u32,
    /// Objects whose leaves got new planes.
    pub rebalanced: u32,
}
