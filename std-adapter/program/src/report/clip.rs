//! The boxes of some consecutive frames, and the pairs that they have.

use crate::check;
use std::cell::OnceCell;
use trisap::recording::Recording;
use trisap::scene::{Setup, Synthetic};
use trisap::{Aabb, Boxes, Pair};

/// Boxes that move. Played to its end and back again, it has no jump however often that is done.
pub(super) struct Clip {
    pub(super) frames: Vec<Vec<Aabb>>,
    /// The pairs of the frames, where somebody has asked for them.
    pairs: Vec<OnceCell<Vec<Pair>>>,
}

/// With more boxes than this, the pairs of the last frame alone are compared: to find them takes longer than all steps.
const ALL_COMPARED: usize = 40_000;

impl Clip {
    pub(super) fn new(frames: Vec<Vec<Aabb>>) -> Self {
        let pairs = frames.iter().map(|_| OnceCell::new()).collect();
        Self { frames, pairs }
    }

    /// A synthetic scene from frame `skip` on.
    pub(super) fn synthetic(setup: Setup, skip: u32, frames: u32) -> Self {
        let mut scene = Synthetic::new(setup);
        for _ in 0..skip {
            scene.advance();
        }
        let mut next = || {
            let boxes = scene.boxes().to_vec();
            scene.advance();
            boxes
        };
        Self::new((0..frames).map(|_| next()).collect())
    }

    /// A recording.
    pub(super) fn recorded(recording: &Recording) -> Self {
        let boxes = |frame| {
            let boxes = Boxes::padded(frame);
            (0..boxes.len()).filter_map(|at| boxes.get(at)).collect()
        };
        Self::new(recording.frames().map(boxes).collect())
    }

    pub(super) fn objects(&self) -> u32 {
        self.frames[0].len() as u32
    }

    /// The pairs of a frame, ascending, found without trisap; `None` where they are not compared.
    pub(super) fn pairs(&self, frame: usize) -> Option<&[Pair]> {
        let compared = self.frames[frame].len() <= ALL_COMPARED || frame + 1 == self.frames.len();
        compared.then(|| self.pairs[frame].get_or_init(|| check::pairs(&self.frames[frame])).as_slice())
    }
}
