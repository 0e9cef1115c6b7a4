//! Kernels and threads by the command line.

use crate::args::EngineArgs;
use anyhow::{Context, Result, anyhow};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::thread;
use std::time::Instant;
use trisap::model::{Clock, Workers};
use trisap::{Executor, Kernels, Rayon, Serial, Stage};

/// What to step with.
pub(crate) struct Engine {
    pub(crate) kernels: Kernels,
    pub(crate) threads: u32,
    pool: Option<ThreadPool>,
    /// Modelled workers, in place of threads.
    pub(crate) model: Option<Workers>,
    /// How many nanoseconds after the caller another thread began with the first job of each step, and with later ones.
    pub(crate) begins: RefCell<[Vec<f64>; 2]>,
}

/// Nanoseconds after a job is on offer until other workers than the caller begin, in models: as threads do that are awake.
pub(crate) const WAKE: u64 = 1_000;

impl Engine {
    pub(crate) fn new(args: &EngineArgs) -> Result<Self> {
        let pool = match args.threads {
            1 => None,
            // The calling thread works too.
            threads => {
                let pool = ThreadPoolBuilder::new().num_threads(threads as usize - 1).build();
                Some(pool.context("cannot start threads")?)
            }
        };
        let begins = RefCell::default();
        Ok(Self { kernels: kernels(&args.kernels)?, threads: args.threads, pool, model: None, begins })
    }

    /// A model of so many workers, on a clock.
    pub(crate) fn modelled(args: &EngineArgs, workers: u32, (wake, clock): (u64, Clock)) -> Result<Self> {
        let model = Some(Workers::new(workers, wake, clock));
        let begins = RefCell::default();
        Ok(Self { kernels: kernels(&args.kernels)?, threads: workers, pool: None, model, begins })
    }

    /// Calls `f` with an executor of as many workers as threads were asked for.
    pub(crate) fn with_executor<T>(&self, f: impl FnOnce(&dyn Executor) -> T) -> T {
        match (&self.model, &self.pool) {
            (Some(model), _) => f(model),
            (None, None) => f(&Serial),
            (None, Some(pool)) => {
                let executor = Rayon::in_pool(pool);
                f(&Noted { executor, begins: &self.begins, is_first: Cell::new(true) })
            }
        }
    }
}

/// Notes when other threads begin.
struct Noted<'e> {
    executor: Rayon<'e>,
    begins: &'e RefCell<[Vec<f64>; 2]>,
    /// The step has had no job yet.
    is_first: Cell<bool>,
}

impl Executor for Noted<'_> {
    fn workers(&self) -> u32 {
        self.executor.workers()
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        let (begun, caller) = (Instant::now(), thread::current().id());
        let other = AtomicU64::new(u64::MAX);
        self.executor.fork_join(width, &|| {
            if thread::current().id() != caller {
                other.fetch_min(begun.elapsed().as_nanos() as u64, Relaxed);
            }
            job();
        });
        let (is_first, other) = (self.is_first.replace(false), other.into_inner());
        if other != u64::MAX {
            self.begins.borrow_mut()[usize::from(!is_first)].push(other as f64);
        }
    }

    fn enter(&self, stage: Stage) {
        self.is_first.set(self.is_first.get() || stage == Stage::Done);
        self.executor.enter(stage);
    }
}

fn kernels(name: &str) -> Result<Kernels> {
    if name == "auto" {
        return Ok(trisap::Kernels::detect());
    }
    Kernels::by_name(name).ok_or_else(|| {
        let names: Vec<_> = Kernels::all().map(Kernels::name).collect();
        anyhow!("this CPU has no kernels named '{name}'; there are auto, {}", names.join(", "))
    })
}

/// How many boxes fit a world with 16-bit indices.
pub(crate) fn fits_u16(objects: u32) -> bool {
    objects <= <u16 as trisap::Index>::MAX_OBJECTS
}
