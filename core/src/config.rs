//! What a world is made for.

use crate::error::Error;

/// How much fits into a world. Nothing is ever lost at these limits: see each field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capacity {
    /// Objects that can live at once. One more is [`Error::ObjectsFull`].
    pub objects: u32,
    /// Boxes that may reach beyond the leaf that they live in. With fewer than a scene needs, the tree uses
    /// larger leaves, which is slower; zero means no tree at all. Half of `objects` suits most scenes.
    pub leaf_refs: u32,
    /// Pairs that a step can return. More are counted and reported as [`Error::PairsFull`].
    pub pairs: u32,
}

impl Capacity {
    /// A capacity for `objects` boxes with the proportions that suit most scenes: half as many leaf references,
    /// eight pairs an object.
    #[must_use]
    pub const fn for_objects(objects: u32) -> Self {
        Self { objects, leaf_refs: objects / 2, pairs: objects.saturating_mul(8) }
    }
}

/// Which pairs a step returns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Exactly the closed overlaps of the boxes as given.
    #[default]
    Exact,
    /// The overlaps of the boxes with their margins: a superset that changes less often. The surplus is counted
    /// by [`Step::surplus`](crate::Step::surplus).
    Fat,
}

/// How far a box may move before it counts as moved: its fat box is the box of its last move, grown by
/// `clamp(per_extent * largest extent, min, max)` on every side (erratum E2).
///
/// A margin pays where many objects rest or creep, and costs where all of them move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// Share of the object's largest extent.
    pub per_extent: f32,
    /// Lower bound, a length.
    pub min: f32,
    /// Upper bound, a length.
    pub max: f32,
}

impl Margin {
    /// The same margin for objects of every size.
    #[must_use]
    pub const fn length(length: f32) -> Self {
        Self { per_extent: 0.0, min: length, max: length }
    }

    /// A share of the object's largest extent, without bounds.
    #[must_use]
    pub const fn share(per_extent: f32) -> Self {
        Self { per_extent, min: 0.0, max: f32::MAX }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let finite = |x: f32| (0.0..=f32::MAX).contains(&x);
        let good = finite(self.per_extent) && finite(self.min) && finite(self.max) && self.min <= self.max;
        if good { Ok(()) } else { Err(Error::BadMargin) }
    }
}

/// What a world is made for: its capacity and the parts that it pays for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// How much fits.
    pub capacity: Capacity,
    /// Which pairs a step returns.
    pub mode: Mode,
    /// The margin of new objects; `None` stores no fat boxes: an object has moved when its box has changed.
    pub margin: Option<Margin>,
    /// Whether steps tell the found and lost pairs. Costs a second pair buffer and the boxes of the last step.
    pub events: bool,
    /// Whether objects have a [`Filter`](crate::Filter), which says whom they meet. Costs 12 bytes an object, and
    /// needs the feature `large`.
    pub filters: bool,
    /// Whether up to 256 objects are swept box by box, without vectors and their scratch memory, as worlds for up to 64
    /// are anyway: about three quarters of the bytes, and faster on a microcontroller. On a processor with vectors it costs
    /// time from about 100 objects on.
    pub lean: bool,
    /// The most workers that a step may use at once (1 to 32); each has its own scratch memory, and more than
    /// one needs a buffer to merge their pairs.
    pub workers: u32,
}

impl Config {
    /// Exact pairs, no margin, no events, no filters, one worker.
    #[must_use]
    pub const fn new(capacity: Capacity) -> Self {
        Self {
            capacity,
            mode: Mode::Exact,
            margin: None,
            events: false,
            filters: false,
            lean: false,
            workers: 1,
        }
    }

    /// The same with another mode.
    #[must_use]
    pub const fn with_mode(mut self, mode: Mode) -> Self {
        self.mode = mode;
        self
    }

    /// The same with a margin.
    #[must_use]
    pub const fn with_margin(mut self, margin: Margin) -> Self {
        self.margin = Some(margin);
        self
    }

    /// The same with found and lost pairs.
    #[must_use]
    pub const fn with_events(mut self) -> Self {
        self.events = true;
        self
    }

    /// The same with a filter for each object.
    #[must_use]
    pub const fn with_filters(mut self) -> Self {
        self.filters = true;
        self
    }

    /// The same without scratch memory, for up to 256 objects: see [`lean`](Self::lean).
    #[must_use]
    pub const fn with_lean(mut self) -> Self {
        self.lean = true;
        self
    }

    /// The same for several workers.
    #[must_use]
    pub const fn with_workers(mut self, workers: u32) -> Self {
        self.workers = workers;
        self
    }
}
