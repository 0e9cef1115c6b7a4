//! A model of many workers on one thread: what a step would take with as many as one likes, whatever the machine has.
//!
//! Each worker is a coroutine with a stack of its own. One runs at a time, and each time that it claims a block, the worker
//! that is the least far in its own time goes on. So blocks go to the workers that would get them if all ran at once. Times are
//! read from a clock of the caller's. All workers share the caches of one processor, and none has to share memory with another.
//!
//! ```
//! use trisap::{Aabb, Capacity, Config, OwnedWorld, model};
//!
//! let mut owned = OwnedWorld::new(&Config::new(Capacity::for_objects(5000)).with_workers(8))?;
//! let mut world = owned.world();
//! for k in 0..5000u16 {
//!     world.insert(Aabb::from_center([f32::from(k); 3], [1.0; 3]))?;
//! }
//! let workers = model::Workers::new(8, 2_000, model::nanoseconds);
//! world.on(&workers).step()?;
//! let course = workers.course();
//! assert!(course.jobs.len() > 1 && course.length() > course.serial.iter().sum());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::Offer;
use generator::{Generator, Gn};
use std::cell::{Cell, RefCell};
use std::hint::black_box;
use std::mem::ManuallyDrop;
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::Instant;
use trisap_core::{Executor, Stage, before_claims};

/// A clock, in whatever unit.
pub type Clock = fn() -> u64;

/// What one job cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Job {
    /// The stage that it was in.
    pub stage: Stage,
    /// How many workers it was offered to.
    pub width: u32,
    /// How often they claimed.
    pub claims: u64,
    /// The sum of all workers' time.
    pub work: u64,
    /// The time until the last worker had ended.
    pub span: u64,
}

/// What a step cost.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Course {
    /// The time outside all jobs, by stage.
    pub serial: [u64; 6],
    /// All jobs, in order.
    pub jobs: Vec<Job>,
}

impl Course {
    /// How long a step would take.
    #[must_use]
    pub fn length(&self) -> u64 {
        self.serial.iter().sum::<u64>() + self.jobs.iter().map(|job| job.span).sum::<u64>()
    }

    /// How long a stage would take.
    #[must_use]
    pub fn of(&self, stage: Stage) -> u64 {
        self.serial[stage as usize] + self.jobs_of(stage).map(|job| job.span).sum::<u64>()
    }

    /// The jobs of a stage.
    pub fn jobs_of(&self, stage: Stage) -> impl Iterator<Item = &Job> {
        self.jobs.iter().filter(move |job| job.stage == stage)
    }
}

/// An executor that models many workers.
pub struct Workers {
    count: u32,
    /// How much later than the caller the other workers begin.
    wake: u64,
    clock: Clock,
    /// What a turn in which nothing is done takes: to ask the clock and to change stacks, which threads need not.
    asking: u64,
    now: RefCell<(Stage, u64, Course)>,
}

impl Workers {
    /// So many workers. All but the caller begin a while after a job has been offered.
    #[must_use]
    pub fn new(count: u32, wake: u64, clock: Clock) -> Self {
        static CALL: fn() = claim;
        before_claims(&CALL);
        let now = RefCell::new((Stage::Done, clock(), Course::default()));
        let mut workers = Self { count, wake, clock, asking: 0, now };
        let mut asked: Vec<u64> = (0..99)
            .map(|_| {
                workers.fork_join(2, &|| (0..20).for_each(|_| pause(true)));
                workers.now.get_mut().2.jobs.pop().map_or(0, |job| job.work / job.claims)
            })
            .collect();
        asked.sort_unstable();
        workers.asking = asked[asked.len() / 2];
        workers
    }

    /// What the step cost that ended last.
    #[must_use]
    pub fn course(&self) -> Course {
        self.now.borrow().2.clone()
    }

    /// The caller's time since the last call was its own.
    fn note_serial(&self) {
        let (stage, since, course) = &mut *self.now.borrow_mut();
        let now = (self.clock)();
        course.serial[*stage as usize] += (now - *since).saturating_sub(self.asking);
        *since = now;
    }
}

impl Executor for Workers {
    fn workers(&self) -> u32 {
        self.count
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        self.note_serial();
        let Self { wake, clock, asking, .. } = *self;
        let done = Mutex::new((0, 0, 0));
        let call = || {
            if COUNTS.get() {
                pause(true);
                return job();
            }
            // The caller's own call: all workers are coroutines.
            *done.lock().unwrap_or_else(PoisonError::into_inner) = take_turns(width, wake, clock, asking);
        };
        OFFER.with(|offer| offer.lend(width, &call, || ()));
        let (claims, work, span) = done.into_inner().unwrap_or_else(PoisonError::into_inner);
        let (stage, since, course) = &mut *self.now.borrow_mut();
        course.jobs.push(Job { stage: *stage, width, claims, work, span });
        *since = (self.clock)();
    }

    fn enter(&self, stage: Stage) {
        self.note_serial();
        let (last, _, course) = &mut *self.now.borrow_mut();
        if std::mem::replace(last, stage) == Stage::Done {
            *course = Course::default();
        }
    }
}

/// Has so many workers do the job on offer. Returns how often they claimed, the sum of their times, and the last one's.
fn take_turns(width: u32, wake: u64, clock: Clock, asking: u64) -> (u64, u64, u64) {
    let mut workers = WORKERS.take();
    while workers.len() < width as usize {
        // They stay for later jobs, as threads do, so their stacks are in the cache; for as long as there is their thread.
        workers.push(ManuallyDrop::new(Gn::new_opt(STACK, || {
            touch_stack();
            loop {
                OFFER.with(Offer::take_part);
                pause(false);
            }
        })));
    }
    COUNTS.set(true);
    let mut times: Vec<_> = (0..width).map(|worker| (if worker == 0 { 0 } else { wake }, true)).collect();
    for worker in workers.iter_mut().take(times.len()) {
        worker.resume();
    }
    let (mut claims, mut work) = (0, 0);
    while let Some(next) =
        (0..times.len()).filter(|worker| times[*worker].1).min_by_key(|worker| times[*worker].0)
    {
        let since = clock();
        let goes_on = workers[next].resume() == Some(true);
        let time = (clock() - since).saturating_sub(asking);
        times[next] = (times[next].0 + time, goes_on);
        work += time;
        claims += u64::from(goes_on);
    }
    COUNTS.set(false);
    WORKERS.set(workers);
    (claims, work, times.iter().map(|(time, _)| *time).max().unwrap_or_default())
}

/// Of a worker, in words. It needs less than 16 KiB; more where nothing is optimised.
const STACK: usize = 0x4000;

/// The pages that a worker will need are there before its time is taken.
#[inline(never)]
fn touch_stack() {
    black_box(&mut [0u8; 16 << 10]);
}

thread_local! {
    static OFFER: Offer = Offer::new();
    static WORKERS: RefCell<Vec<ManuallyDrop<Generator<'static, (), bool>>>> = const { RefCell::new(Vec::new()) };
    /// Whether this thread is one of the workers.
    static COUNTS: Cell<bool> = const { Cell::new(false) };
    static CLAIMED: Cell<u64> = const { Cell::new(0) };
}

/// A clock that repeats: each block that this thread has claimed counts as one.
#[must_use]
pub fn blocks() -> u64 {
    CLAIMED.get()
}

/// A clock of the time. What interrupts the thread counts, too: take the median of several runs of a step. A clock that stands
/// still meanwhile takes longer to be asked than some blocks do.
#[must_use]
pub fn nanoseconds() -> u64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_nanos() as u64
}

fn claim() {
    CLAIMED.set(CLAIMED.get() + 1);
    if COUNTS.get() {
        pause(true);
    }
}

/// Ends the turn of the worker that this is in, which goes on with its call or has ended it.
// Where blocks are claimed no scope of the generator is at hand.
#[expect(deprecated)]
fn pause(goes_on: bool) {
    generator::yield_with(goes_on);
}
