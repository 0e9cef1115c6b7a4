//! The executor over rayon.

use rayon::{Scope, ThreadPool, Yield};
use std::cell::Cell;
use std::hint::spin_loop;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use std::time::{Duration, Instant};
use trisap_core::Executor;

/// How long a thread looks for more after its last work: the stages of a step follow each other within microseconds,
/// and to wake a sleeping thread takes as long as a stage of ten thousand objects.
const LINGER: Duration = Duration::from_micros(200);

thread_local! {
    /// Whether this thread is inside `fork_join`. While it waits there it may run any task of the pool; one that looks for
    /// work until the job has ended would keep the job from ending.
    static FORKED: Cell<bool> = const { Cell::new(false) };
}

/// An executor over a rayon thread pool: the global one, or one of the caller's.
///
/// The calling thread takes part, whether it belongs to the pool or not: a pool of `n` threads promises `n` workers to a
/// caller from inside and `n + 1` to one from outside. While a caller from inside waits for the last blocks, it may run
/// other tasks of the pool, as always in rayon. A caller from outside is best served by a pool of one thread less than
/// the machine has cores.
///
/// The first stage of a step wakes the pool's threads. If such a stage is short, it does not wait for them. They stay
/// awake for 0.2 ms after their last work, and do whatever else the pool has to do meanwhile. So make one executor and
/// keep it: it knows which threads are awake, and when it is dropped they no longer wait for it.
///
/// ```
/// use trisap::{Boxes, Capacity, Config, OwnedWorld, Rayon};
///
/// let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
/// // Two workers: the pool's thread and this one.
/// let executor = Rayon::in_pool(&pool);
/// let config = Config::new(Capacity::for_objects(5000)).with_workers(2);
/// let mut owned = OwnedWorld::<u32>::new(&config)?;
/// let mut world = owned.world();
/// # let boxes: Vec<_> = (0..5000).map(|i| {
/// #     let corner = [(i % 17) as f32, (i / 17 % 17) as f32, (i / 289) as f32];
/// #     trisap::Aabb::new(corner, corner.map(|low| low + 0.5))
/// # }).collect();
/// world.insert_many(Boxes::new(&boxes), &mut vec![None; boxes.len()])?;
/// let step = world.step(trisap::detect(), &executor)?;
/// # assert_eq!(step.pairs().len(), 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct Rayon<'p> {
    pool: Option<&'p ThreadPool>,
    awake: Arc<Awake>,
}

/// The threads of the pool that look for work instead of sleeping.
#[derive(Debug, Default)]
struct Awake {
    threads: AtomicU32,
    /// A job is being done. There will be more when it ends.
    busy: AtomicBool,
    /// Nobody is going to have work for them.
    over: AtomicBool,
    /// The last job that found threads asleep was long enough to wait for them.
    patient: AtomicBool,
}

impl Rayon<'static> {
    /// Over rayon's global pool, or over the pool that the calling thread belongs to.
    #[must_use]
    pub fn global() -> Self {
        Self::default()
    }
}

impl<'p> Rayon<'p> {
    /// Over this pool.
    #[must_use]
    pub fn in_pool(pool: &'p ThreadPool) -> Self {
        Self { pool: Some(pool), awake: Arc::default() }
    }

    /// Has so many more threads look for work.
    fn wake(&self, threads: u32) {
        for _ in 0..threads {
            self.awake.threads.fetch_add(1, Relaxed);
            let awake = Arc::clone(&self.awake);
            match self.pool {
                Some(pool) => pool.spawn(move || awake.linger()),
                None => rayon::spawn(move || awake.linger()),
            }
        }
    }
}

impl Drop for Rayon<'_> {
    fn drop(&mut self) {
        self.awake.over.store(true, Relaxed);
    }
}

impl Awake {
    /// Runs what the pool has to do until there has been nothing for a while.
    fn linger(&self) {
        let mut last = Instant::now();
        while !FORKED.get() && !self.over.load(Relaxed) && last.elapsed() < LINGER {
            if rayon::yield_now() == Some(Yield::Executed) || self.busy.load(Relaxed) {
                last = Instant::now();
            }
            spin_loop();
        }
        self.threads.fetch_sub(1, Relaxed);
    }
}

impl Executor for Rayon<'_> {
    fn workers(&self) -> u32 {
        let (threads, index) = match self.pool {
            Some(pool) => (pool.current_num_threads(), pool.current_thread_index()),
            None => (rayon::current_num_threads(), rayon::current_thread_index()),
        };
        u32::try_from(threads).unwrap_or(u32::MAX).saturating_add(index.is_none().into())
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        let Awake { threads, busy, patient, .. } = &*self.awake;
        let asleep = (width - 1).saturating_sub(threads.load(Relaxed));
        busy.store(true, Relaxed);
        self.wake(asleep);
        let others = if patient.load(Relaxed) { width - 1 } else { width - 1 - asleep };
        let left = AtomicU32::new(others);
        let left = &left;
        let begun = Instant::now();
        let outer = FORKED.replace(true);
        match self.pool {
            Some(pool) => pool.in_place_scope(|scope| share(scope, left, job)),
            None => rayon::in_place_scope(|scope| share(scope, left, job)),
        }
        FORKED.set(outer);
        busy.store(false, Relaxed);
        if asleep > 0 {
            patient.store(begun.elapsed() > LINGER, Relaxed);
        }
    }
}

/// Makes as many calls in the pool as `left` counts, and one here.
fn share<'s>(scope: &Scope<'s>, left: &'s AtomicU32, job: &'s (dyn Fn() + Sync)) {
    for _ in 0..left.load(Relaxed) {
        scope.spawn(move |_| {
            job();
            left.fetch_sub(1, Relaxed);
        });
    }
    job();
    // The end of the scope puts this thread to sleep if it does not belong to the pool. The others are about to be done.
    let begun = Instant::now();
    while left.load(Relaxed) > 0 && begun.elapsed() < LINGER {
        spin_loop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OwnedWorld;
    use rayon::ThreadPoolBuilder;
    use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
    use std::sync::Barrier;
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

    /// Has the next job wait for threads that sleep.
    fn patient<'e, 'p>(executor: &'e Rayon<'p>) -> &'e Rayon<'p> {
        executor.awake.patient.store(true, Relaxed);
        executor
    }

    #[test]
    fn a_long_job_makes_the_next_one_patient() {
        let pool = pool(1);
        let executor = Rayon::in_pool(&pool);
        executor.fork_join(2, &|| std::thread::sleep(2 * LINGER));
        assert!(executor.awake.patient.load(Relaxed));
        assert_eq!(calls(&executor, 2), 2);
    }

    #[test]
    fn as_many_calls_as_asked_have_returned() {
        let pool = pool(3);
        let executor = Rayon::in_pool(&pool);
        let global = Rayon::global();
        assert_eq!(executor.workers(), 4);
        assert_eq!(pool.install(|| Rayon::in_pool(&pool).workers()), 3);
        for width in 2..10 {
            assert_eq!(calls(patient(&executor), width), width);
            assert_eq!(calls(patient(&global), width), width);
        }
    }

    #[test]
    fn a_short_job_does_not_wait_for_threads_to_wake() {
        let pool = pool(3);
        let executor = Rayon::in_pool(&pool);
        assert_eq!(calls(&executor, 4), 1);
        assert!(calls(&executor, 4) <= 4);
    }

    #[test]
    fn threads_go_to_sleep_again() {
        let pool = pool(3);
        let executor = Rayon::in_pool(&pool);
        assert_eq!(calls(patient(&executor), 4), 4);
        let awake = Arc::clone(&executor.awake);
        let begun = Instant::now();
        while awake.threads.load(Relaxed) > 0 {
            assert!(begun.elapsed() < Duration::from_secs(60), "threads stay awake for ever");
            std::thread::yield_now();
        }
        // Nobody but the executor and this test refers to them.
        while Arc::strong_count(&awake) > 2 {
            assert!(begun.elapsed() < Duration::from_secs(60), "a thread has not ended its task");
        }
        drop(executor);
        assert!(awake.over.load(Relaxed));
    }

    #[test]
    fn a_thread_that_waits_for_its_job_does_not_linger() {
        let awake = Awake { busy: AtomicBool::new(true), ..Awake::default() };
        awake.threads.store(1, Relaxed);
        FORKED.set(true);
        // Would never end: the job is being done.
        awake.linger();
        FORKED.set(false);
        assert_eq!(awake.threads.load(Relaxed), 0);
    }

    #[test]
    fn works_from_inside_a_pool() {
        let pool = pool(1);
        pool.install(|| {
            let executor = Rayon::global();
            assert_eq!(executor.workers(), 1);
            assert_eq!(calls(patient(&executor), 4), 4);
            assert_eq!(calls(patient(&Rayon::in_pool(&pool)), 4), 4);
        });
    }

    #[test]
    fn calls_run_at_the_same_time_and_one_of_them_here() {
        let pool = pool(2);
        let here = std::thread::current().id();
        let met = Barrier::new(3);
        let took_part = AtomicBool::new(false);
        // Would never end if the calls came one after another.
        patient(&Rayon::in_pool(&pool)).fork_join(3, &|| {
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
