//! Worlds inside an engine whose tasks must never wait, as those of task graphs and of fibres: a step is a chain. It begins on a
//! stack of its own; each stage is a few tasks, and when they are done the step goes on by itself; its end is a task again. No thread
//! of the engine ever waits for a step. `cargo run --release -p trisap --example task_graph`

use std::cell::Cell;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use trisap::scene::{Kind, Objects, Setup, Synthetic};
use trisap::{Capacity, Config, Error, Executor, Offer, OwnedWorld, Serial, Stats};

/// What the engine wants done. It runs to its end: it waits for nothing, and so may not step a world itself.
type Task = Box<dyn FnOnce() + Send>;

thread_local! {
    static IN_TASK: Cell<bool> = const { Cell::new(false) };
}

/// The engine: threads that run tasks in turn.
struct Engine {
    tasks: Option<Tasks>,
    threads: Vec<JoinHandle<()>>,
}

/// Where anybody puts tasks.
#[derive(Clone)]
struct Tasks {
    sender: Sender<Task>,
    threads: u32,
}

impl Engine {
    fn new(threads: u32) -> Self {
        let (sender, receiver) = channel::<Task>();
        let receiver = Arc::new(Mutex::new(receiver));
        let thread = |_| {
            let receiver = Arc::clone(&receiver);
            thread::spawn(move || while next(&receiver).map(run).is_some() {})
        };
        Self { threads: (0..threads).map(thread).collect(), tasks: Some(Tasks { sender, threads }) }
    }

    fn tasks(&self) -> Tasks {
        self.tasks.clone().expect("until it is dropped")
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.tasks = None;
        for thread in self.threads.drain(..) {
            thread.join().expect("no task panics");
        }
    }
}

/// The next task, unless nobody is left who could give one.
fn next(receiver: &Mutex<Receiver<Task>>) -> Option<Task> {
    receiver.lock().unwrap_or_else(PoisonError::into_inner).recv().ok()
}

fn run(task: Task) {
    IN_TASK.set(true);
    task();
    IN_TASK.set(false);
}

impl Tasks {
    fn push(&self, task: impl FnOnce() + Send + 'static) {
        // If the engine has ended, so has the need.
        drop(self.sender.send(Box::new(task)));
    }

    /// Begins a chain and returns at once: `steps` runs on a stack of its own, and what it returns goes to the task `then`. An engine
    /// with fibres takes one of these, whose `fork_join` gives the processor back until the calls that have begun have returned.
    fn begin<T: Send + 'static>(
        &self,
        steps: impl FnOnce(&dyn Executor) -> T + Send + 'static,
        then: impl FnOnce(T) + Send + 'static,
    ) {
        let stack = Stack { offer: Arc::new(Offer::new()), tasks: self.clone() };
        thread::spawn(move || {
            let done = steps(&stack);
            stack.tasks.push(move || then(done));
        });
    }
}

/// The stack of a chain of steps.
struct Stack {
    offer: Arc<Offer>,
    tasks: Tasks,
}

impl Executor for Stack {
    /// All threads, as if this one, which works as well, were none.
    fn workers(&self) -> u32 {
        self.tasks.threads
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        assert!(!IN_TASK.get(), "a task would wait");
        for _ in 1..width {
            let offer = Arc::clone(&self.offer);
            // It may come late, when another job is on offer, or none: then it does what it can, and ends.
            self.tasks.push(move || {
                offer.take_part();
            });
        }
        self.offer.lend(width - 1, job, thread::yield_now);
    }
}

/// What each step found, and the pairs of the last one.
type Played = (Vec<Stats>, Vec<[u32; 2]>);

/// Steps a world through some frames.
fn play(count: usize, executor: &dyn Executor) -> Result<Played, Error> {
    let config = Config::new(Capacity::for_objects(count as u32)).with_events().with_workers(4);
    let mut owned = OwnedWorld::<u32>::new(&config)?;
    let mut world = owned.world();
    let setup = Setup { kind: Kind::Brownian, objects: Objects::Cubes, count: count as u32, seed: 1 };
    let mut scene = Synthetic::new(setup);
    world.insert_many(scene.boxes())?;
    let mut step = |_| {
        scene.advance();
        world.on(executor).step_over(scene.boxes()).map(|step| step.stats())
    };
    let stats = (0..4).map(&mut step).collect::<Result<_, _>>()?;
    Ok((stats, world.pairs().to_vec()))
}

/// Plays worlds of several sizes at once, all on the threads of one engine.
fn play_all(threads: u32, counts: &[usize]) -> Vec<(usize, Played)> {
    let engine = Engine::new(threads);
    let (sender, played) = channel();
    for &count in counts {
        let (sender, tasks) = (sender.clone(), engine.tasks());
        // A task begins the chain, and another one has its result.
        engine.tasks().push(move || {
            tasks.begin(
                move |executor| play(count, executor).expect("room for all"),
                move |result| sender.send((count, result)).expect("somebody waits for it"),
            );
        });
    }
    drop(sender);
    let mut played: Vec<_> = played.iter().collect();
    played.sort_by_key(|(count, _)| *count);
    played
}

fn main() -> Result<(), Error> {
    for (count, (stats, pairs)) in play_all(3, &[5_000, 10_000, 20_000]) {
        let last = stats.last().expect("four steps");
        println!("{count} objects: {} pairs, {} found, {} lost", pairs.len(), last.found, last.lost);
        assert_eq!((stats, pairs), play(count, &Serial)?, "the same on one thread");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_worlds_step_at_once_where_no_task_may_wait() {
        // Miri is slow.
        let counts: &[usize] = if cfg!(miri) { &[4200] } else { &[5000, 5001, 5002, 6000, 6001, 9000] };
        let alone: Vec<_> = counts.iter().map(|&count| (count, play(count, &Serial).unwrap())).collect();
        for threads in [1, 2, 5] {
            assert_eq!(play_all(threads, counts), alone, "{threads} threads");
        }
    }
}
