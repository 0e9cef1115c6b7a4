//! What all experiments share: the plan, the scenes, the progress.

use super::clip::Clip;
use super::measure::{Contender, Measured, in_turns};
use super::plan::Plan;
use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use trisap::scene::{Kind, Objects, Setup};
use trisap::{Capacity, Config};

pub(super) struct Lab {
    pub(super) plan: Plan,
    /// Where recordings are kept.
    #[cfg_attr(not(feature = "record"), expect(dead_code, reason = "only recordings are kept"))]
    pub(super) recordings: PathBuf,
    pub(super) bar: ProgressBar,
}

/// The seed of all scenes.
const SEED: u64 = 1;

impl Lab {
    pub(super) fn new(plan: Plan, recordings: PathBuf) -> Self {
        let style = ProgressStyle::with_template("{elapsed} {wide_bar} {pos} of {len}: {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        Self { plan, recordings, bar: ProgressBar::new(0).with_style(style) }
    }

    /// Announces so many parts of work.
    pub(super) fn expect(&self, parts: usize) {
        self.bar.inc_length(parts as u64);
    }

    /// Says what is being done next.
    pub(super) fn next(&self, doing: String) {
        self.bar.set_message(doing);
        self.bar.inc(1);
    }

    pub(super) fn setup(&self, kind: Kind, objects: Objects, count: u32) -> Setup {
        Setup { kind, objects, count, seed: SEED }
    }

    /// A scene in motion.
    pub(super) fn scene(&self, kind: Kind, objects: Objects, count: u32) -> Result<Clip> {
        let setup = self.setup(kind, objects, count);
        #[cfg(feature = "record")]
        if self.plan.recorded {
            return self.recorded(setup);
        }
        Ok(Clip::synthetic(setup, self.plan.skip, self.plan.frames))
    }

    /// Where the boxes of [`scene`](Self::scene) come from.
    pub(super) fn origin(&self) -> &'static str {
        if self.plan.recorded {
            "The scenes are recorded rigid-body simulations of at most 8,000 bodies. Scenes with more boxes are those of fewer \
             bodies, each of which is made of 8 boxes, or of 64 or 512: these move as one, and neighbours among them touch in \
             every frame."
        } else if cfg!(feature = "record") {
            "The scenes are synthetic: their boxes move without a physics engine and pass through each other. The whole \
             report has recorded simulations."
        } else {
            "The scenes are synthetic: their boxes move without a physics engine and pass through each other. A program \
             that is built with the feature `record` has recorded simulations."
        }
    }

    /// Measures contenders in turns.
    pub(super) fn measure(&self, contenders: &[Contender<'_>]) -> Result<Vec<Measured>> {
        in_turns(contenders, self.plan.budget)
    }
}

/// An exact world for the boxes of a clip.
pub(super) fn exact(clip: &Clip) -> Config {
    Config::new(Capacity::for_objects(clip.objects()))
}
