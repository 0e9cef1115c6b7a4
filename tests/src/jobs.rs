//! Job systems, from obedient to perverse. The contract of [`Executor`] allows all of them, so none may change
//! a byte of a result.

use crate::denormals::flushed;
use std::panic::{catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::thread;
use trisap_core::Executor;

/// A job system for tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jobs {
    /// Everything on the calling thread, and it says so.
    Serial,
    /// Starts the threads that it is asked for, and waits.
    Threads(u32),
    /// Promises many workers and runs nothing.
    Never,
    /// Runs every job twice, one call after the other, on the calling thread.
    Twice,
    /// Runs every job many more times than asked, one call after the other.
    Often,
    /// Starts more threads than it is asked for.
    Crowd,
    /// Starts the threads that it is asked for, and these flush denormals while the calling thread does not.
    Flushed,
    /// Promises many workers and makes one call, on another thread.
    Few,
    /// Starts the threads that it is asked for; each runs only when all that were started after it have ended.
    Reversed,
    /// Does all of the work, and then starts the threads that it was asked for.
    Late,
    /// The calling thread takes part, as in most engines.
    Helping(u32),
    /// Starts the threads that it is asked for; each has a neighbour that panics, and has just survived a panic of
    /// its own.
    Panicking,
    /// Promises no worker, one, or more than there can be, and never the same twice.
    Fickle,
}

impl Jobs {
    /// Those that every small counterexample is played under.
    pub const ALL: [Self; 7] =
        [Self::Serial, Self::Threads(2), Self::Never, Self::Twice, Self::Often, Self::Crowd, Self::Flushed];

    /// The other ways to bend the contract, which are the same whatever the boxes: `executors.rs` has them all.
    pub const PERVERSE: [Self; 5] = [Self::Few, Self::Reversed, Self::Late, Self::Panicking, Self::Fickle];

    /// The two that users have.
    pub const USUAL: [Self; 2] = [Self::Serial, Self::Threads(2)];
}

impl Executor for Jobs {
    fn workers(&self) -> u32 {
        match self {
            Self::Serial => 1,
            Self::Threads(count) | Self::Helping(count) => *count,
            Self::Twice | Self::Flushed => 2,
            Self::Never | Self::Few | Self::Late => 8,
            Self::Often | Self::Crowd | Self::Reversed | Self::Panicking => 3,
            Self::Fickle => fickle(),
        }
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        match self {
            Self::Serial | Self::Never => {}
            Self::Twice => (0..2).for_each(|_| job()),
            Self::Often => (0..5 * width + 5).for_each(|_| job()),
            Self::Threads(_) | Self::Fickle => on_threads(width, job),
            Self::Crowd => on_threads(width + 5, job),
            Self::Flushed => on_threads(width, &|| flushed(job)),
            Self::Few => on_threads(1, job),
            Self::Reversed => reversed(width, job),
            Self::Late => {
                job();
                on_threads(width, job);
            }
            Self::Helping(_) => thread::scope(|scope| {
                for _ in 1..width {
                    scope.spawn(job);
                }
                job();
            }),
            Self::Panicking => among_panics(width, job),
        }
    }
}

fn on_threads(count: u32, job: &(dyn Fn() + Sync)) {
    thread::scope(|scope| {
        for _ in 0..count {
            scope.spawn(job);
        }
    });
}

/// Every thread starts the next one and waits for it, so that the last to start is the first to work.
fn reversed(count: u32, job: &(dyn Fn() + Sync)) {
    if count > 0 {
        thread::scope(|scope| {
            scope.spawn(|| {
                reversed(count - 1, job);
                job();
            });
        });
    }
}

fn among_panics(count: u32, job: &(dyn Fn() + Sync)) {
    // Unlike `panic!`, this does not write a message for each.
    let panics = || resume_unwind(Box::new(()));
    thread::scope(|scope| {
        let neighbours: Vec<_> = (0..count).map(|_| scope.spawn(panics)).collect();
        for _ in 0..count {
            scope.spawn(|| {
                assert!(catch_unwind(panics).is_err());
                job();
            });
        }
        for neighbour in neighbours {
            assert!(neighbour.join().is_err(), "the neighbour has panicked");
        }
    });
}

fn fickle() -> u32 {
    static ASKED: AtomicU32 = AtomicU32::new(0);
    let promises = [u32::MAX, 2, 0, 7, 3, 1, 5];
    promises[ASKED.fetch_add(1, Relaxed) as usize % promises.len()]
}
