//! Kernels and threads by the command line.

use crate::args::EngineArgs;
use anyhow::{Context, Result, anyhow};
use rayon::{ThreadPool, ThreadPoolBuilder};
use trisap::{Executor, Kernels, Rayon, Serial};

/// What to step with.
pub(crate) struct Engine {
    pub(crate) kernels: Kernels,
    pub(crate) threads: u32,
    pool: Option<ThreadPool>,
}

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
        Ok(Self { kernels: kernels(&args.kernels)?, threads: args.threads, pool })
    }

    /// Calls `f` with an executor of as many workers as threads were asked for.
    pub(crate) fn with_executor<T>(&self, f: impl FnOnce(&dyn Executor) -> T) -> T {
        match &self.pool {
            None => f(&Serial),
            Some(pool) => f(&Rayon::in_pool(pool)),
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
