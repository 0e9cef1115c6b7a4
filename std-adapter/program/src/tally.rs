//! Collects the figures of all frames.

use crate::check::Checker;
use crate::drive::{Frame, Visitor};
use crate::progress;
use crate::stopwatch::StageTimes;
use anyhow::Result;
use indicatif::ProgressBar;
use std::collections::BTreeMap;
use trisap::{Path, Stats};

pub(crate) struct Tally {
    bar: ProgressBar,
    new_checker: Option<Box<dyn Fn() -> Checker>>,
    pub(crate) checker: Option<Checker>,
    /// What the check found wrong.
    pub(crate) wrong: Option<String>,
    pub(crate) milliseconds: Vec<f64>,
    pub(crate) stages: Vec<StageTimes>,
    pub(crate) stats: Vec<Stats>,
    pub(crate) surplus: Vec<u64>,
    /// Frames by the path that the step took.
    pub(crate) paths: BTreeMap<String, u32>,
    pub(crate) rejected: u64,
    pub(crate) coarse: usize,
}

impl Tally {
    /// For so many frames; with a function that begins a check, they are checked.
    pub(crate) fn new(frames: u32, new_checker: Option<Box<dyn Fn() -> Checker>>) -> Self {
        Self {
            bar: progress::bar(frames, "stepping"),
            new_checker,
            checker: None,
            wrong: None,
            milliseconds: Vec::new(),
            stages: Vec::new(),
            stats: Vec::new(),
            surplus: Vec::new(),
            paths: BTreeMap::new(),
            rejected: 0,
            coarse: 0,
        }
    }
}

impl Visitor for Tally {
    fn start(&mut self) {
        self.bar.reset();
        self.checker = self.new_checker.as_ref().map(|begin| begin());
        self.milliseconds.clear();
        self.stages.clear();
        self.stats.clear();
        self.surplus.clear();
        self.paths.clear();
        (self.rejected, self.coarse) = (0, 0);
    }

    fn visit(&mut self, frame: &Frame<'_>) -> Result<bool> {
        self.milliseconds.push(frame.time.as_secs_f64() * 1e3);
        self.stages.push(frame.stages);
        self.stats.push(frame.stats);
        // What the exact mode dropped, or what the fat mode kept.
        self.surplus.push(frame.surplus + frame.stats.surplus);
        let path = match frame.stats.path {
            Path::MoversByLeaf => "movers by leaf".into(),
            path => format!("{path:?}").to_lowercase(),
        };
        *self.paths.entry(path).or_default() += 1;
        self.rejected += u64::from(frame.rejected.map_or(0, |rejected| rejected.count));
        self.coarse += usize::from(frame.coarse);
        if let Some(checker) = &mut self.checker {
            self.wrong = checker.compare(frame).err().map(|wrong| format!("frame {}: {wrong}", frame.number));
        }
        self.bar.inc(1);
        Ok(self.wrong.is_none())
    }
}

impl Drop for Tally {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
