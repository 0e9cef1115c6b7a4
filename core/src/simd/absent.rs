//! The level of 128-bit vectors where the target has none: no value of it exists, so that it costs nothing.

use super::Phase;

/// No CPU of the target has it.
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
