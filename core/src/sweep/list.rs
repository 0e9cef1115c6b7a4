//! Sweeps a small world straight from one of its sorted lists: one bag, no tree, no sort.

use super::scratch::Scratch;
use super::{Sink, bag};
use crate::arch::{Phase, Simd};
use crate::id::Index;
use crate::key::KeyBox;
use crate::tree::Frame;

/// See the module.
pub(crate) struct SweepList<'p, 's, 'b, I> {
    /// The slots by ascending minimum on `axis`.
    pub(crate) order: &'b [I],
    pub(crate) axis: usize,
    pub(crate) frame: Frame,
    pub(crate) boxes: &'b [KeyBox],
    pub(crate) scratch: &'p mut Scratch<'s, I>,
    pub(crate) sink: &'p mut dyn Sink<I>,
}

impl<I: Index> Phase for SweepList<'_, '_, '_, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        bag::sweep_listed(
            simd,
            self.order,
            &self.frame,
            self.axis,
            &mut self.scratch.bench,
            self.boxes,
            self.sink,
        );
    }
}
