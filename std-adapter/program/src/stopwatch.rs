//! Measures the stages of a step.

use std::cell::Cell;
use std::time::{Duration, Instant};
use trisap::{Executor, Stage};

/// Times by stage: an entry for each of [`Stage::ALL`].
pub(crate) type StageTimes = [StageTime; Stage::ALL.len()];

/// The time of a stage.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StageTime {
    pub(crate) all: Duration,
    /// Of it in jobs that several threads can share.
    pub(crate) shared: Duration,
}

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

    /// Adds to the times of the stage that is running.
    fn add(&self, to: impl FnOnce(&mut StageTime)) {
        if let Some((stage, _)) = self.running.get() {
            let mut times = self.times.get();
            to(&mut times[stage as usize]);
            self.times.set(times);
        }
    }
}

impl Executor for Stopwatch<'_> {
    fn workers(&self) -> u32 {
        self.executor.workers()
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        let start = Instant::now();
        self.executor.fork_join(width, job);
        self.add(|time| time.shared += start.elapsed());
    }

    fn enter(&self, stage: Stage) {
        self.executor.enter(stage);
        let now = Instant::now();
        if let Some((_, start)) = self.running.get() {
            self.add(|time| time.all += now - start);
        }
        self.running.set(Some((stage, now)));
    }
}
