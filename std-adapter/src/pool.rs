//! The executor over rayon.

use crate::offer::Offer;
use crate::sharing::{Job, Judge, Sharing};
use rayon::{ThreadPool, Yield};
use std::cell::Cell;
use std::hint::spin_loop;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::ptr::null;
use std::sync::atomic::Ordering::{Relaxed, SeqCst};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, fence};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use trisap_core::{Executor, Stage};

/// How long a thread looks for more after its last work. The stages of a step follow each other within microseconds,
/// and to wake a sleeping thread takes as long as a stage of ten thousand objects.
const LINGER: Duration = Duration::from_micros(200);
/// How long a thread that waits keeps its processor. Then it lets others run.
const SPIN: Duration = Duration::from_micros(10);
/// How long a caller waits before it sleeps, so that the operating system lets the thread run that it waits for. And how long a
/// thread looks for more of a caller that belongs to its pool.
const AWAKE: Duration = Duration::from_micros(50);
/// If so much time is between two looks for work, the thread has lost its processor.
const GAP: Duration = Duration::from_micros(100);
/// Such a gap counts as a loss of one in so many parts of it.
const GAP_PART: u64 = 4;

/// An executor over a rayon thread pool: the global one, or one of the caller's.
///
/// The calling thread takes part, whether it belongs to the pool or not: a pool of `n` threads promises `n` workers to a
/// caller from inside and `n + 1` to one from outside. A caller from outside is best served by a pool of one thread less
/// than the machine has cores.
///
/// The first stage of a step wakes the pool's threads, and no stage waits for one that has not come by its end. They stay
/// awake for 0.2 ms after their last work, and do whatever else the pool has to do meanwhile; if the caller belongs to the
/// pool, they go when its step ends. So worlds that are stepped by `par_iter`, an executor each, take hardly more of the
/// processors than serial ones. Make one executor for a world and keep it: it knows which threads are awake, and when it
/// is dropped they no longer wait for it. While one world's stage is shared, another thread that uses the same executor
/// works alone. If a rule panics on a thread of the pool, the step panics on the calling one.
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
/// world.insert_many(Boxes::new(&boxes))?;
/// let step = world.on(&executor).step()?;
/// # assert_eq!(step.pairs().len(), 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias("pool", "thread_pool", "parallel"))]
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
    /// How many of them were called for by threads that look already, and have not come yet.
    passed_on: AtomicU32,
    /// How many callers have a job for them, or are about to.
    callers: AtomicU32,
    /// There will be no more work for them.
    over: AtomicBool,
    /// A step is being done.
    stepping: AtomicBool,
    /// The caller is a thread of the pool: then the others have worlds of their own, or whatever else the pool does.
    inside: AtomicBool,
    /// For how long a thread that was looking for work in a step had lost its processor, in nanoseconds.
    gap: AtomicU64,
    /// The caller sleeps until a call has ended.
    asleep: AtomicBool,
    sleep: Mutex<()>,
    ended: Condvar,
    judge: Mutex<Judge>,
    /// How often threads have looked for work.
    #[cfg(test)]
    looks: AtomicU64,
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

    /// Makes so many more threads look for work.
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

thread_local! {
    /// Whose work this thread looks for.
    static LOOKING: Cell<*const Common> = const { Cell::new(null()) };
}

/// This thread looks for work.
struct Looks(*const Common);

impl Looks {
    fn of(common: &Common) -> Self {
        Self(LOOKING.replace(common))
    }
}

impl Drop for Looks {
    fn drop(&mut self) {
        LOOKING.set(self.0);
    }
}

impl Common {
    /// Takes part in jobs and runs what else the pool has to do, until there has been nothing for a while.
    fn look_for_work(self: &Arc<Self>) {
        if LOOKING.get() == Arc::as_ptr(self) {
            // This thread has taken the call for another one, which would sleep on.
            self.passed_on.fetch_add(1, Relaxed);
            let common = Arc::clone(self);
            return rayon::spawn(move || {
                common.passed_on.fetch_sub(1, Relaxed);
                common.look_for_work();
            });
        }
        let _looks = Looks::of(self);
        loop {
            self.look_for_a_while();
            self.looking.fetch_sub(1, Relaxed);
            // Either the caller sees that this thread has gone and calls for another, or this thread sees the caller.
            fence(SeqCst);
            if self.callers.load(Relaxed) == 0 || self.over.load(Relaxed) {
                return;
            }
            self.looking.fetch_add(1, Relaxed);
        }
    }

    fn look_for_a_while(&self) {
        let mut last = Instant::now();
        let mut before = last;
        let mut stepping = false;
        while !self.over.load(Relaxed) {
            #[cfg(test)]
            self.looks.fetch_add(1, Relaxed);
            let took_part = self.offer.take_part();
            if took_part {
                self.tell_the_caller();
            }
            if !took_part && self.has_ended() {
                break;
            }
            // A thread that looks already leaves calls for others to these.
            let calls = self.passed_on.load(Relaxed) > 0;
            let worked = took_part || (!calls && rayon::yield_now() == Some(Yield::Executed));
            let now = Instant::now();
            if worked {
                last = now;
            } else if now - before > GAP {
                // Others want this processor: it may be the caller itself.
                if stepping {
                    self.gap.store((now - before).as_nanos() as u64, Relaxed);
                }
                break;
            } else if now - last > if self.inside.load(Relaxed) { AWAKE } else { LINGER } {
                break;
            } else if now - last > SPIN {
                thread::yield_now();
            } else {
                spin_loop();
            }
            before = now;
            stepping = self.stepping.load(Relaxed);
        }
    }

    /// A caller from inside the pool has no work any more, until its next step. The pool may have other work: who lingers
    /// beside that takes processors from it, and from other programs.
    fn has_ended(&self) -> bool {
        self.inside.load(Relaxed) && !self.stepping.load(Relaxed) && self.callers.load(Relaxed) == 0
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

/// A caller that has a job.
struct Calling<'c>(&'c AtomicU32);

impl Drop for Calling<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Relaxed);
    }
}

impl Executor for Rayon<'_> {
    fn workers(&self) -> u32 {
        let (threads, index) = match self.pool {
            Some(pool) => (pool.current_num_threads(), pool.current_thread_index()),
            None => (rayon::current_num_threads(), rayon::current_thread_index()),
        };
        self.common.inside.store(index.is_some(), Relaxed);
        if !lock(&self.common.judge).shares(Instant::now()) {
            return 1;
        }
        u32::try_from(threads).unwrap_or(u32::MAX).saturating_add(index.is_none().into())
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        let common = &*self.common;
        common.callers.fetch_add(1, Relaxed);
        let _calling = Calling(&common.callers);
        fence(SeqCst);
        self.wake((width - 1).saturating_sub(common.looking.load(Relaxed)));
        let begun = Instant::now();
        let (calls, first) = (AtomicU32::new(0), AtomicU64::new(u64::MAX));
        // A rule that panics on a thread of the pool would end the process there.
        let panicked = Mutex::new(None);
        let timed = || {
            if let Err(payload) = catch_unwind(AssertUnwindSafe(job)) {
                lock(&panicked).get_or_insert(payload);
            }
            calls.fetch_add(1, Relaxed);
            first.fetch_min(begun.elapsed().as_nanos() as u64, Relaxed);
        };
        let mut waits = None;
        if !common.offer.lend(width - 1, &timed, || common.wait(*waits.get_or_insert_with(Instant::now))) {
            // The pool's threads have another world's job.
            return job();
        }
        if let Some(payload) = panicked.into_inner().unwrap_or_else(PoisonError::into_inner) {
            resume_unwind(payload);
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
mod tests;
