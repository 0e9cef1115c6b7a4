//! Stands in for 128-bit vectors on targets without them. No value of the level exists, so it costs nothing.

/// A level that no CPU of the target has.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Level {}

impl Level {
    pub(crate) const NAME: &'static str = "";
    pub(crate) const GUARANTEED: Option<Self> = None;

    pub(crate) const fn detect() -> Option<Self> {
        None
    }
}

/// As [`run!`](crate::simd::kernels::run) for this level.
macro_rules! run {
    ($simd:ident, $_:expr) => {
        match $simd {}
    };
}
pub(crate) use run;
