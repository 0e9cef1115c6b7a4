//! Fixes what steps choose by counts, so that small worlds take all paths. The core has this door with the feature `validate`
//! alone.

use trisap_core::Config;

/// Whether steps do something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Counts decide, as in products.
    Automatic,
    /// Never.
    Never,
    /// Wherever possible.
    Always,
}

/// Configurations with fixed choices: see the core's `config.rs`.
pub trait Forced: Sized {
    /// The same with one of five choices fixed.
    #[must_use]
    fn with(self, which: u8, choice: Choice) -> Self;

    /// Whether steps test only the objects that have moved.
    #[must_use]
    fn with_movers_only(self, choice: Choice) -> Self {
        self.with(0, choice)
    }

    /// Whether leaves are divided in such steps.
    #[must_use]
    fn with_fine_leaves(self, choice: Choice) -> Self {
        self.with(1, choice)
    }

    /// Whether steps are shared between workers.
    #[must_use]
    fn with_sharing(self, choice: Choice) -> Self {
        self.with(2, choice)
    }

    /// Whether steps that fill all leaves find only the pairs of objects that have moved.
    #[must_use]
    fn with_movers_by_leaf(self, choice: Choice) -> Self {
        self.with(3, choice)
    }

    /// The same with a tree from 3 objects on and leaves of 16, so that small worlds take all paths.
    #[must_use]
    fn with_small_leaves(self) -> Self {
        self.with(4, Choice::Always)
    }
}

impl Forced for Config {
    fn with(self, which: u8, choice: Choice) -> Self {
        let always = match choice {
            Choice::Automatic => None,
            Choice::Never => Some(false),
            Choice::Always => Some(true),
        };
        self.with_forced(which, always)
    }
}
