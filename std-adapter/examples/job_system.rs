//! A world inside an engine's own job system: threads that live as long as the engine, one queue of tasks for all that it
//! does, and nobody who sleeps while there is a task. `cargo run --release -p trisap --example job_system`

#![allow(unsafe_code, reason = "hands a job to threads that outlive it")]

use std::collections::VecDeque;
use std::mem::transmute;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use trisap::{Aabb, Boxes, Capacity, Config, Error, Executor, OwnedWorld, Serial, Stats};

/// Anything that the engine wants done.
type Task = Box<dyn FnOnce() + Send>;

/// The engine's job system.
struct JobSystem {
    queue: Arc<Queue>,
    threads: Vec<JoinHandle<()>>,
}

/// What the threads share.
#[derive(Default)]
struct Queue {
    state: Mutex<State>,
    /// A task has come, a group of tasks has ended, or the engine stops.
    news: Condvar,
}

#[derive(Default)]
struct State {
    tasks: VecDeque<Task>,
    stopping: bool,
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, State> {
        // No task runs while it is held.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, task: Task) {
        self.lock().tasks.push_back(task);
        self.news.notify_one();
    }

    /// Runs tasks until `done`; sleeps only when there are none.
    fn work_until(&self, done: impl Fn(&State) -> bool) {
        let mut state = self.lock();
        while !done(&state) {
            match state.tasks.pop_front() {
                Some(task) => {
                    drop(state);
                    // A task that panics is its owner's affair: the thread and all other tasks go on.
                    drop(catch_unwind(AssertUnwindSafe(task)));
                    state = self.lock();
                }
                None => state = self.news.wait(state).unwrap_or_else(PoisonError::into_inner),
            }
        }
        drop(state);
        // The news that ended the wait may have been meant for another.
        self.news.notify_one();
    }
}

impl JobSystem {
    /// Starts threads; the one that makes it works too, whenever it waits.
    fn new(threads: u32) -> Self {
        let queue = Arc::<Queue>::default();
        let thread = |_| {
            let queue = Arc::clone(&queue);
            thread::spawn(move || queue.work_until(|state| state.stopping))
        };
        Self { threads: (0..threads).map(thread).collect(), queue }
    }

    /// Gives the engine something to do.
    fn spawn(&self, task: impl FnOnce() + Send + 'static) {
        self.queue.push(Box::new(task));
    }
}

impl Drop for JobSystem {
    fn drop(&mut self) {
        self.queue.lock().stopping = true;
        self.queue.news.notify_all();
        for thread in self.threads.drain(..) {
            // Tasks cannot make it panic.
            drop(thread.join());
        }
    }
}

impl Executor for JobSystem {
    fn workers(&self) -> u32 {
        self.threads.len() as u32 + 1
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        let group = Group { queue: &self.queue, open: Arc::new(AtomicU32::new(width - 1)) };
        // SAFETY: nothing but the lifetime in the pointer's type changes.
        let lent = unsafe { transmute::<*const (dyn Fn() + Sync + '_), *const (dyn Fn() + Sync)>(job) };
        for _ in 1..width {
            let call = Call { job: lent, queue: Arc::clone(&self.queue), open: Arc::clone(&group.open) };
            self.spawn(move || call.run());
        }
        job();
        // Here, or where this thread unwinds, the group waits.
    }
}

/// The calls of one job.
struct Group<'q> {
    queue: &'q Queue,
    open: Arc<AtomicU32>,
}

impl Drop for Group<'_> {
    /// Helps until the last call has returned. One that nobody has begun is at hand in the queue.
    fn drop(&mut self) {
        // Acquire: what the calls have done is seen by the step.
        self.queue.work_until(|_| self.open.load(Ordering::Acquire) == 0);
    }
}

/// One of the calls, open until it is dropped. Points to the job, since a reference would have to live as long as this.
struct Call {
    job: *const (dyn Fn() + Sync),
    queue: Arc<Queue>,
    open: Arc<AtomicU32>,
}

// SAFETY: what the pointer leads to is `Sync`.
unsafe impl Send for Call {}

impl Call {
    fn run(self) {
        // SAFETY: the job is alive as long as its `Group`, which does not let `fork_join` return or unwind while a call is
        // open; this one is until `self` is dropped, after the job has returned or panicked.
        unsafe { (*self.job)() }
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        // Release: what this call has done comes before the end of the group.
        if self.open.fetch_sub(1, Ordering::Release) == 1 {
            // Who has just seen it open is asleep by the time that the lock is free.
            drop(self.queue.lock());
            self.queue.news.notify_all();
        }
    }
}

/// A crowd of boxes that walk in circles.
fn crowd(count: usize, frame: usize) -> Vec<Aabb> {
    let side = (count as f32).cbrt().ceil() as usize;
    let walk = |i: usize| {
        let angle = (frame * (i % 5 + 1)) as f32 * 0.1;
        let place = [i % side, i / side % side, i / side / side].map(|at| at as f32 * 1.1);
        let corner = [place[0] + angle.sin(), place[1] + angle.cos(), place[2]];
        Aabb::new(corner, corner.map(|low| low + 1.0))
    };
    (0..count).map(walk).collect()
}

/// Steps a world through some frames; returns what each found.
fn play(count: usize, frames: usize, executor: &dyn Executor) -> Result<Vec<Stats>, Error> {
    let config = Config::new(Capacity::for_objects(count as u32)).with_events().with_workers(4);
    let mut owned = OwnedWorld::<u32>::new(&config)?;
    let mut world = owned.world();
    world.insert_many(Boxes::new(&crowd(count, 0)))?;
    let step =
        |frame| world.on(executor).step_over(Boxes::new(&crowd(count, frame))).map(|step| step.stats());
    (0..frames).map(step).collect()
}

fn main() -> Result<(), Error> {
    let jobs = JobSystem::new(1);
    let sounds = Arc::new(AtomicU32::new(0));
    for _ in 0..1000 {
        let sounds = Arc::clone(&sounds);
        jobs.spawn(move || {
            sounds.fetch_add(1, Ordering::Relaxed);
        });
    }
    let stats = play(20_000, 5, &jobs)?;
    for (frame, stats) in stats.iter().enumerate() {
        println!("frame {frame}: {} pairs, {} found, {} lost", stats.pairs, stats.found, stats.lost);
    }
    println!("{} other tasks were done meanwhile", sounds.load(Ordering::Relaxed));
    assert_eq!(stats, play(20_000, 5, &Serial)?, "the same on one thread");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::resume_unwind;
    use std::sync::Barrier;

    // Miri is slow.
    const COUNT: usize = if cfg!(miri) { 4200 } else { 6000 };
    const FRAMES: usize = if cfg!(miri) { 2 } else { 4 };

    #[test]
    fn a_world_is_the_same_on_any_number_of_threads() {
        let serial = play(COUNT, FRAMES, &Serial).unwrap();
        assert!(serial.iter().skip(1).all(|stats| stats.pairs > 0 && stats.leaves > 2));
        for threads in 0..8 {
            assert_eq!(play(COUNT, FRAMES, &JobSystem::new(threads)).unwrap(), serial, "{threads} threads");
        }
    }

    #[test]
    fn panics_of_other_tasks_stay_theirs() {
        let serial = play(COUNT, FRAMES, &Serial).unwrap();
        let jobs = JobSystem::new(2);
        let panics = Arc::new(AtomicU32::new(0));
        for _ in 0..FRAMES {
            for _ in 0..20 {
                let panics = Arc::clone(&panics);
                jobs.spawn(move || {
                    panics.fetch_add(1, Ordering::Relaxed);
                    resume_unwind(Box::new(()));
                });
            }
            assert_eq!(play(COUNT, FRAMES, &jobs).unwrap(), serial);
        }
        drop(jobs);
        assert!(panics.load(Ordering::Relaxed) > 0);
    }

    #[test]
    fn tasks_step_worlds_while_others_wait() {
        let serial = play(COUNT, FRAMES, &Serial).unwrap();
        let jobs = Arc::new(JobSystem::new(2));
        let (sender, worlds) = std::sync::mpsc::channel();
        for _ in 0..6 {
            let (jobs, sender) = (Arc::clone(&jobs), sender.clone());
            let task = move |jobs: &JobSystem| sender.send(play(COUNT, FRAMES, jobs).unwrap()).unwrap();
            let queue = Arc::clone(&jobs.queue);
            queue.push(Box::new(move || task(&jobs)));
        }
        assert_eq!(play(COUNT, FRAMES, &*jobs).unwrap(), serial);
        for _ in 0..6 {
            // The last thread to let go of the job system must not be one of its own.
            assert_eq!(worlds.recv().unwrap(), serial);
        }
        while Arc::strong_count(&jobs) > 1 {
            thread::yield_now();
        }
    }

    #[test]
    fn the_caller_takes_calls_back_that_nobody_begins() {
        let jobs = JobSystem::new(1);
        let busy = Arc::new(Barrier::new(2));
        let other = Arc::clone(&busy);
        jobs.spawn(move || {
            other.wait();
            other.wait();
        });
        // The only thread is busy from here to the second wait.
        busy.wait();
        let calls = AtomicU32::new(0);
        jobs.fork_join(4, &|| {
            calls.fetch_add(1, Ordering::Relaxed);
        });
        assert_eq!(calls.into_inner(), 4);
        busy.wait();
    }

    #[test]
    fn a_job_that_panics_is_waited_for() {
        let jobs = JobSystem::new(2);
        let calls = AtomicU32::new(0);
        let job = || {
            calls.fetch_add(1, Ordering::Relaxed);
            resume_unwind(Box::new(()));
        };
        assert!(catch_unwind(AssertUnwindSafe(|| jobs.fork_join(8, &job))).is_err());
        assert_eq!(calls.into_inner(), 8);
    }
}
