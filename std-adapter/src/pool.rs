//! The executor over rayon.

use rayon::{Scope, ThreadPool};
use trisap_core::Executor;

/// An executor over a rayon thread pool: the global one, or one of the caller's.
///
/// The calling thread takes part, whether it belongs to the pool or not. A pool of `n` threads promises `n` workers; for
/// a caller from outside that is one more thread than workers, and one of them stays idle. While a caller from inside the
/// pool waits for the last blocks, it may run other tasks of the pool, as always in rayon.
///
/// Give the world as many workers as the pool has threads, or fewer:
///
/// ```
/// use trisap::{Boxes, Capacity, Config, OwnedWorld, Rayon};
///
/// let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;
/// let config = Config::new(Capacity::for_objects(5000)).with_workers(2);
/// let mut owned = OwnedWorld::<u32>::new(&config)?;
/// let mut world = owned.world();
/// # let boxes: Vec<_> = (0..5000).map(|i| {
/// #     let corner = [(i % 17) as f32, (i / 17 % 17) as f32, (i / 289) as f32];
/// #     trisap::Aabb::new(corner, corner.map(|low| low + 0.5))
/// # }).collect();
/// world.insert_many(Boxes::new(&boxes), &mut vec![None; boxes.len()])?;
/// let step = world.step(trisap::detect(), &Rayon::in_pool(&pool))?;
/// # assert_eq!(step.pairs().len(), 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Rayon<'p> {
    pool: Option<&'p ThreadPool>,
}

impl Rayon<'static> {
    /// Over rayon's global pool, or over the pool that the calling thread belongs to.
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
    for _ in 1..width {
        scope.spawn(|_| job());
    }
    // A scope waits at its end without working, unless the thread belongs to the pool.
    job();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OwnedWorld;
    use rayon::ThreadPoolBuilder;
    use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
    use std::sync::Barrier;
    use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
    use trisap_core::{Aabb, Boxes, Capacity, Config, Kernels, Serial};

    fn pool(threads: usize) -> ThreadPool {
        ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads")
    }

    fn calls(executor: &dyn Executor, width: u32) -> u32 {
        let calls = AtomicU32::new(0);
        executor.fork_join(width, &|| {
            calls.fetch_add(1, Relaxed);
        });
        calls.into_inner()
    }

    #[test]
    fn as_many_calls_as_asked_have_returned() {
        let pool = pool(3);
        let executor = Rayon::in_pool(&pool);
        assert_eq!(executor.workers(), 3);
        for width in 2..10 {
            assert_eq!(calls(&executor, width), width);
            assert_eq!(calls(&Rayon::global(), width), width);
        }
    }

    #[test]
    fn works_from_inside_a_pool() {
        let pool = pool(1);
        pool.install(|| {
            assert_eq!(Rayon::global().workers(), 1);
            assert_eq!(calls(&Rayon::global(), 4), 4);
            assert_eq!(calls(&Rayon::in_pool(&pool), 4), 4);
        });
    }

    #[test]
    fn calls_run_at_the_same_time_and_one_of_them_here() {
        let pool = pool(2);
        let here = std::thread::current().id();
        let met = Barrier::new(3);
        let took_part = AtomicBool::new(false);
        // Would never end if the calls came one after another.
        Rayon::in_pool(&pool).fork_join(3, &|| {
            took_part.fetch_or(std::thread::current().id() == here, Relaxed);
            met.wait();
        });
        assert!(took_part.into_inner(), "the calling thread has stayed idle");
    }

    /// Cubes on a lattice that sways: neighbours touch in some frames and not in others.
    fn frame(count: usize, time: usize) -> Vec<Aabb> {
        let cube = |i: usize| {
            let corner = [i % 19, i / 19 % 19, i / 361].map(|at| at as f32 * 1.25);
            let sway = ((i * 7 + time * 5) % 11) as f32 / 16.0;
            let corner = [corner[0] + sway, corner[1] - sway, corner[2]];
            Aabb::new(corner, corner.map(|low| low + 1.0))
        };
        (0..count).map(cube).collect()
    }

    /// All that a world says over some frames.
    fn transcript(executor: &dyn Executor) -> String {
        const COUNT: usize = 6000;
        let config = Config::new(Capacity::for_objects(COUNT as u32)).with_events().with_workers(4);
        let mut owned = OwnedWorld::<u32>::new(&config).expect("memory");
        let mut world = owned.world();
        world.insert_many(Boxes::new(&frame(COUNT, 0)), &mut vec![None; COUNT]).expect("room");
        let mut transcript = String::new();
        for time in 0..6 {
            let boxes = frame(COUNT, time);
            let step = world.step_over(Boxes::new(&boxes), Kernels::detect(), executor).expect("room");
            assert!(!step.pairs().is_empty());
            transcript += &format!("{:?}{:?}{:?}{:?}", step.stats(), step.pairs(), step.found(), step.lost());
        }
        transcript
    }

    #[test]
    fn worlds_are_the_same_in_every_pool() {
        let serial = transcript(&Serial);
        assert!(transcript(&Rayon::global()) == serial);
        for threads in 1..=8 {
            let pool = pool(threads);
            assert!(transcript(&Rayon::in_pool(&pool)) == serial, "{threads} threads, from outside");
            assert!(
                pool.install(|| transcript(&Rayon::global())) == serial,
                "{threads} threads, from inside"
            );
        }
    }

    #[test]
    fn panics_of_other_tasks_stay_theirs() {
        let serial = transcript(&Serial);
        let pool = pool(2);
        let done = AtomicBool::new(false);
        let mut panics = 0;
        std::thread::scope(|scope| {
            let world = scope.spawn(|| {
                let transcripts =
                    [transcript(&Rayon::in_pool(&pool)), pool.install(|| transcript(&Rayon::global()))];
                done.store(true, Relaxed);
                transcripts
            });
            while !done.load(Relaxed) && !world.is_finished() {
                let task = || resume_unwind(Box::new("a neighbour's"));
                panics += u32::from(catch_unwind(AssertUnwindSafe(|| pool.install(task))).is_err());
            }
            assert!(
                world.join().expect("no panic comes over").iter().all(|transcript| *transcript == serial)
            );
        });
        assert!(panics > 0, "no neighbour has panicked");
    }
}
