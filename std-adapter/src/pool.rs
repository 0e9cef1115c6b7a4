//! The executor over rayon.

use crate::sharing::{Job, Judge, Sharing};
use rayon::{ThreadPool, Yield};
use std::hint::spin_loop;
use std::sync::atomic::Ordering::{Relaxed, SeqCst};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, fence};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use trisap_core::{Executor, Offer, Stage};

/// How long a thread looks for more after its last work: the stages of a step follow each other within microseconds,
/// and to wake a sleeping thread takes as long as a stage of ten thousand objects.
const LINGER: Duration = Duration::from_micros(200);
/// For so long a thread that waits keeps its processor; then it lets others run, if there are any.
const SPIN: Duration = Duration::from_micros(10);
/// A caller that has waited for so long goes to sleep, so that the operating system brings whom it waits for here.
const AWAKE: Duration = Duration::from_micros(50);
/// A thread that looks for work and finds that so much time has gone by has not been running.
const GAP: Duration = Duration::from_micros(100);
/// Such a gap counts as a loss of this part of it.
const GAP_PART: u64 = 4;

/// An executor over a rayon thread pool: the global one, or one of the caller's.
///
/// The calling thread takes part, whether it belongs to the pool or not: a pool of `n` threads promises `n` workers to a
/// caller from inside and `n + 1` to one from outside. A caller from outside is best served by a pool of one thread less
/// than the machine has cores.
///
/// The first stage of a step wakes the pool's threads, and no stage waits for one that has not come by its end. They stay
/// awake for 0.2 ms after their last work, and do whatever else the pool has to do meanwhile. So make one executor for a
/// world and keep it: it knows which threads are awake, and when it is dropped they no longer wait for it. While one
/// world's stage is shared, another thread that uses the same executor works alone.
///
/// # Busy processors
/// A thread that has begun a block of work may lose its processor to another program, and then the step waits for it. After
/// such a loss the executor works alone for at least 32 times as long as it has waited, and longer if it happens again, up
/// to a second; then it tries anew. [`sharing`](Self::sharing) tells how often. The pairs are the same in any case.
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
    common: Arc<Common>,
}

/// What the caller and the threads of the pool share.
#[derive(Debug, Default)]
struct Common {
    offer: Offer,
    /// How many threads look for work instead of sleeping, or will when they have woken up.
    looking: AtomicU32,
    /// Nobody is going to have work for them.
    over: AtomicBool,
    /// A step is being done.
    stepping: AtomicBool,
    /// For how long a thread that was looking for work in a step had lost its processor, in nanoseconds.
    gap: AtomicU64,
    /// The caller sleeps until a call has ended.
    asleep: AtomicBool,
    sleep: Mutex<()>,
    ended: Condvar,
    judge: Mutex<Judge>,
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
        Self { pool: Some(pool), common: Arc::default() }
    }

    /// How often the work of a step was shared so far.
    #[must_use]
    pub fn sharing(&self) -> Sharing {
        lock(&self.common.judge).counts
    }

    /// Has so many more threads look for work.
    fn wake(&self, threads: u32) {
        for _ in 0..threads {
            self.common.looking.fetch_add(1, Relaxed);
            let common = Arc::clone(&self.common);
            match self.pool {
                Some(pool) => pool.spawn(move || common.look_for_work()),
                None => rayon::spawn(move || common.look_for_work()),
            }
        }
    }
}

impl Drop for Rayon<'_> {
    fn drop(&mut self) {
        self.common.over.store(true, Relaxed);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Nothing panics while it is held.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Common {
    /// Takes part in jobs and runs what else the pool has to do, until there has been nothing for a while.
    fn look_for_work(&self) {
        let mut last = Instant::now();
        let mut before = last;
        let mut stepping = false;
        while !self.over.load(Relaxed) {
            let took_part = self.offer.take_part();
            if took_part {
                self.tell_the_caller();
            }
            let worked = took_part || rayon::yield_now() == Some(Yield::Executed);
            let now = Instant::now();
            if worked {
                last = now;
            } else if now - before > GAP {
                // Others want this processor: it may be the caller itself.
                if stepping {
                    self.gap.store((now - before).as_nanos() as u64, Relaxed);
                }
                break;
            } else if now - last > LINGER {
                break;
            } else if now - last > SPIN {
                thread::yield_now();
            } else {
                spin_loop();
            }
            before = now;
            stepping = self.stepping.load(Relaxed);
        }
        self.looking.fetch_sub(1, Relaxed);
    }

    /// A call of this thread has ended.
    fn tell_the_caller(&self) {
        // Either this thread sees that the caller goes to sleep, or the caller sees that the call has ended.
        fence(SeqCst);
        if self.asleep.load(Relaxed) {
            drop(lock(&self.sleep));
            self.ended.notify_all();
        }
    }

    /// Waits a little for calls that have begun: since when is known.
    fn wait(&self, since: Instant) {
        let waited = since.elapsed();
        if waited < SPIN {
            spin_loop();
        } else if waited < AWAKE {
            thread::yield_now();
        } else {
            let guard = lock(&self.sleep);
            self.asleep.store(true, Relaxed);
            fence(SeqCst);
            if self.offer.running() > 0 {
                drop(self.ended.wait_timeout(guard, LINGER * 10));
            }
            self.asleep.store(false, Relaxed);
        }
    }
}

impl Executor for Rayon<'_> {
    fn workers(&self) -> u32 {
        let (threads, index) = match self.pool {
            Some(pool) => (pool.current_num_threads(), pool.current_thread_index()),
            None => (rayon::current_num_threads(), rayon::current_thread_index()),
        };
        if !lock(&self.common.judge).shares(Instant::now()) {
            return 1;
        }
        u32::try_from(threads).unwrap_or(u32::MAX).saturating_add(index.is_none().into())
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        let common = &*self.common;
        self.wake((width - 1).saturating_sub(common.looking.load(Relaxed)));
        let begun = Instant::now();
        let (calls, first) = (AtomicU32::new(0), AtomicU64::new(u64::MAX));
        let timed = || {
            job();
            calls.fetch_add(1, Relaxed);
            first.fetch_min(begun.elapsed().as_nanos() as u64, Relaxed);
        };
        let mut waits = None;
        if !common.offer.lend(width - 1, &timed, || common.wait(*waits.get_or_insert_with(Instant::now))) {
            // The pool's threads have another world's job.
            return job();
        }
        let took = begun.elapsed();
        let others = calls.into_inner() > 1;
        let first = others.then(|| Duration::from_nanos(first.into_inner()));
        let gap = if common.gap.load(Relaxed) > 0 { common.gap.swap(0, Relaxed) } else { 0 };
        let mut judge = lock(&common.judge);
        judge.ended(Job { took, first }, begun + took);
        if gap > 0 {
            judge.lost(Duration::from_nanos(gap / GAP_PART), begun + took);
        }
    }

    fn enter(&self, stage: Stage) {
        self.common.stepping.store(stage != Stage::Done, Relaxed);
        let (mut judge, now) = (lock(&self.common.judge), Instant::now());
        if stage == Stage::Done { judge.step_ended(now) } else { judge.step_begun(now) }
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
