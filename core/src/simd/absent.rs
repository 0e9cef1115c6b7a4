//! Stands in for 128-bit vectors on targets without them. No value of the level exists, so it costs nothing.

use super::Phase;

/// A level that no CPU of the target has.
#[derive(Clone, Copy, Debug)]
pub(super) enum Level {}

impl Level {
    pub(super) const NAME: &'static str = "";
    pub(super) const GUARANTEED: Option<Self> = None;

    pub(super) const fn detect() -> Option<Self> {
        None
    }

    pub(super) fn call<P: Phase>(self, _: P) -> P::Output {
        match self {}
    }
}
