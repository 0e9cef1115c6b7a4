//! Measures the stages of a step.

use std::cell::Cell;
use std::time::{Duration, Instant};
use trisap::{Executor, Stage};

/// Times by stage: an entry for each of [`Stage::ALL`].
pub(crate) type StageTimes = [Duration; Stage::ALL.len()];

/// An executor that notes when a step enters its stages.
pub(crate) struct Stopwatch<'e> {
    executor: &'e dyn Executor,
    running: Cell<Option<(Stage, Instant)>>,
    times: Cell<StageTimes>,
}

impl<'e> Stopwatch<'e> {
    pub(crate) fn new(executor: &'e dyn Executor) -> Self {
        Self { executor, running: Cell::new(None), times: Cell::default() }
    }

    pub(crate) fn times(&self) -> StageTimes {
        self.times.get()
    }
}

impl Executor for Stopwatch<'_> {
    fn workers(&self) -> u32 {
        self.executor.workers()
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        self.executor.fork_join(width, job);
    }

    fn enter(&self, stage: Stage) {
        let now = Instant::now();
        if let Some((last, start)) = self.running.replace(Some((stage, now))) {
            let mut times = self.times.get();
            times[last as usize] += now - start;
            self.times.set(times);
        }
    }
}
