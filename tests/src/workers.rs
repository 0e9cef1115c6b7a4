//! A model of many workers on one processor: each is a thread, one runs at a time, and each time that a worker claims a block, the
//! one that is the least far in its own time goes on. So blocks go to the workers that would get them if all ran at once, whatever
//! the machine has, and what a step costs is read from a clock of the caller's: one of a thread's time, or one that counts.

use std::cell::{Cell, RefCell};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use trisap_core::{Executor, Stage, before_claims};

/// A clock that only counts while the calling thread runs.
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
    /// What it takes to ask the clock, which is in each time.
    asking: u64,
    now: RefCell<(Stage, u64, Course)>,
}

impl Workers {
    /// So many workers, who begin a while after the caller has offered a job.
    #[must_use]
    pub fn new(count: u32, wake: u64, clock: Clock) -> Self {
        static CALL: fn() = claims;
        before_claims(&CALL);
        let asking =
            (0..1000).map(|_| clock()).collect::<Vec<_>>().windows(2).map(|two| two[1] - two[0]).min();
        Self {
            count,
            wake,
            clock,
            asking: asking.unwrap_or_default(),
            now: RefCell::new((Stage::Intake, clock(), Course::default())),
        }
    }

    /// A step begins, which tells a stage only when it has one.
    pub fn begin(&self) {
        *self.now.borrow_mut() = (Stage::Intake, (self.clock)(), Course::default());
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
        let race = Arc::new(Race::new(width as usize, self));
        std::thread::scope(|scope| {
            for worker in 1..width as usize {
                let race = race.clone();
                scope.spawn(move || race.run(worker, job));
            }
            race.run(0, job);
        });
        let (stage, since, course) = &mut *self.now.borrow_mut();
        let turns = race.turns();
        let (claims, work) = (turns.claims, turns.work);
        let span = turns.times.iter().copied().max().unwrap_or_default();
        course.jobs.push(Job { stage: *stage, width, claims, work, span });
        *since = (self.clock)();
    }

    fn enter(&self, stage: Stage) {
        self.note_serial();
        self.now.borrow_mut().0 = stage;
    }
}

thread_local! {
    /// The race in which this thread is a worker, and which one.
    static SEAT: RefCell<Option<(Arc<Race>, usize)>> = const { RefCell::new(None) };
    static CLAIMED: Cell<u64> = const { Cell::new(0) };
}

/// A clock that repeats: each block that this thread has claimed counts as one.
#[must_use]
pub fn blocks() -> u64 {
    CLAIMED.get()
}

fn claims() {
    CLAIMED.set(CLAIMED.get() + 1);
    SEAT.with_borrow(|seat| {
        if let Some((race, worker)) = seat {
            race.claim(*worker);
        }
    });
}

/// The workers of one job.
struct Race {
    clock: Clock,
    asking: u64,
    turns: Mutex<Turns>,
    /// A worker waits here for its turn.
    waits: Vec<Condvar>,
}

struct Turns {
    /// Whose turn it is.
    turn: usize,
    /// When the turn began.
    since: u64,
    /// How far each is in its own time.
    times: Vec<u64>,
    ended: Vec<bool>,
    claims: u64,
    work: u64,
}

impl Race {
    fn new(width: usize, of: &Workers) -> Self {
        let times = (0..width).map(|worker| if worker == 0 { 0 } else { of.wake }).collect();
        let turns = Turns { turn: 0, since: 0, times, ended: vec![false; width], claims: 0, work: 0 };
        Self {
            clock: of.clock,
            asking: of.asking,
            turns: Mutex::new(turns),
            waits: (0..width).map(|_| Condvar::new()).collect(),
        }
    }

    fn turns(&self) -> MutexGuard<'_, Turns> {
        self.turns.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One worker's call of the job.
    fn run(self: &Arc<Self>, worker: usize, job: &(dyn Fn() + Sync)) {
        self.wait(self.turns(), worker);
        SEAT.set(Some((self.clone(), worker)));
        job();
        SEAT.set(None);
        let mut turns = self.pause(worker);
        turns.ended[worker] = true;
        self.next(&mut turns);
    }

    /// The worker is about to claim a block.
    fn claim(&self, worker: usize) {
        let mut turns = self.pause(worker);
        turns.claims += 1;
        self.next(&mut turns);
        self.wait(turns, worker);
    }

    /// Ends the time of a turn.
    fn pause(&self, worker: usize) -> MutexGuard<'_, Turns> {
        let now = (self.clock)();
        let mut turns = self.turns();
        let time = (now - turns.since).saturating_sub(self.asking);
        turns.times[worker] += time;
        turns.work += time;
        turns
    }

    /// Gives the turn to the worker that is the least far.
    fn next(&self, turns: &mut Turns) {
        let open = (0..turns.times.len()).filter(|&worker| !turns.ended[worker]);
        if let Some(worker) = open.min_by_key(|&worker| turns.times[worker]) {
            turns.turn = worker;
            self.waits[worker].notify_one();
        }
    }

    /// Waits for the turn of a worker, and begins it.
    fn wait(&self, mut turns: MutexGuard<'_, Turns>, worker: usize) {
        while turns.turn != worker {
            turns = self.waits[worker].wait(turns).unwrap_or_else(PoisonError::into_inner);
        }
        turns.since = (self.clock)();
    }
}
