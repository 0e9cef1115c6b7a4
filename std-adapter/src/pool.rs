//! The executor over rayon.

use rayon::{Scope, ThreadPool};
use trisap_core::Executor;

/// An executor over a rayon thread pool: the global one, or one of the caller's.
///
/// The calling thread works too, so a pool of `n` threads gives `n` workers and one of them may stay idle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rayon<'p> {
    pool: Option<&'p ThreadPool>,
}

impl Rayon<'static> {
    /// Over rayon's global pool (or the pool that the calling thread belongs to).
    #[must_use]
    pub const fn global() -> Self {
        Self { pool: None }
    }
}

impl<'p> Rayon<'p> {
    /// Over this pool.
    #[must_use]
    pub const fn in_pool(pool: &'p ThreadPool) -> Self {
        Self { pool: Some(pool) }
    }
}

impl Executor for Rayon<'_> {
    fn workers(&self) -> u32 {
        let threads = self.pool.map_or_else(rayon::current_num_threads, ThreadPool::current_num_threads);
        u32::try_from(threads).unwrap_or(u32::MAX)
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        match self.pool {
            Some(pool) => pool.in_place_scope(|scope| share(scope, width, job)),
            None => rayon::in_place_scope(|scope| share(scope, width, job)),
        }
    }
}

fn share<'s>(scope: &Scope<'s>, width: u32, job: &'s (dyn Fn() + Sync)) {
    for _ in 0..width {
        scope.spawn(|_| job());
    }
    // Else the calling thread would sleep until the pool has done all of the work.
    job();
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::ThreadPoolBuilder;
    use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

    fn calls(executor: &dyn Executor, width: u32) -> u32 {
        let calls = AtomicU32::new(0);
        executor.fork_join(width, &|| {
            calls.fetch_add(1, Relaxed);
        });
        calls.into_inner()
    }

    #[test]
    fn every_call_has_returned() {
        let pool = ThreadPoolBuilder::new().num_threads(3).build().expect("three threads");
        let executor = Rayon::in_pool(&pool);
        assert_eq!(executor.workers(), 3);
        // The calling thread's own call comes on top.
        assert_eq!(calls(&executor, 2), 3);
        assert_eq!(calls(&executor, 0), 1);
        assert_eq!(calls(&Rayon::global(), 5), 6);
    }

    #[test]
    fn works_from_inside_a_pool() {
        let pool = ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
        pool.install(|| {
            assert_eq!(Rayon::global().workers(), 1);
            assert_eq!(calls(&Rayon::global(), 4), 5);
            assert_eq!(calls(&Rayon::in_pool(&pool), 4), 5);
        });
    }
}
