//! Kernels and threads by the command line.

use crate::args::EngineArgs;
use anyhow::{Context, Result, anyhow};
use rayon::{ThreadPool, ThreadPoolBuilder};
use trisap::model::{Workers, nanoseconds};
use trisap::{Executor, Kernels, Rayon, Serial};

/// What to step with.
pub(crate) struct Engine {
    pub(crate) kernels: Kernels,
    pub(crate) threads: u32,
    pool: Option<ThreadPool>,
    /// Modelled workers, in place of threads.
    pub(crate) model: Option<Workers>,
}

/// Nanoseconds after a job is on offer until other workers than the caller begin, in models.
pub(crate) const WAKE: u64 = 2_000;

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
        Ok(Self { kernels: kernels(&args.kernels)?, threads: args.threads, pool, model: None })
    }

    /// A model of so many workers.
    pub(crate) fn modelled(args: &EngineArgs, workers: u32) -> Result<Self> {
        let model = Some(Workers::new(workers, WAKE, nanoseconds));
        Ok(Self { kernels: kernels(&args.kernels)?, threads: workers, pool: None, model })
    }

    /// Calls `f` with an executor of as many workers as threads were asked for.
    pub(crate) fn with_executor<T>(&self, f: impl FnOnce(&dyn Executor) -> T) -> T {
        match (&self.model, &self.pool) {
            (Some(model), _) => f(model),
            (None, None) => f(&Serial),
            (None, Some(pool)) => f(&Rayon::in_pool(pool)),
        }
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
