//! Job systems, from obedient to perverse. The contract of [`Executor`] allows all of them, so none may change
//! a byte of a result.

use crate::denormals::flushed;
use std::thread;
use trisap_core::Executor;

/// A job system for tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jobs {
    /// Everything on the calling thread, and it says so.
    Serial,
    /// Starts the threads that it is asked for.
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
}

impl Jobs {
    /// One of each kind.
    pub const ALL: [Self; 7] =
        [Self::Serial, Self::Threads(2), Self::Never, Self::Twice, Self::Often, Self::Crowd, Self::Flushed];

    /// The two that users have.
    pub const USUAL: [Self; 2] = [Self::Serial, Self::Threads(2)];
}

impl Executor for Jobs {
    fn workers(&self) -> u32 {
        match self {
            Self::Serial => 1,
            Self::Threads(count) => *count,
            Self::Twice | Self::Flushed => 2,
            Self::Never => 8,
            Self::Often | Self::Crowd => 3,
        }
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        match self {
            Self::Serial | Self::Never => {}
            Self::Twice => (0..2).for_each(|_| job()),
            Self::Often => (0..5 * width + 5).for_each(|_| job()),
            Self::Threads(_) => on_threads(width, job),
            Self::Crowd => on_threads(width + 5, job),
            Self::Flushed => on_threads(width, &|| flushed(job)),
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
