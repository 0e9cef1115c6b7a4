use super::*;
use crate::OwnedWorld;
use rayon::ThreadPoolBuilder;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Barrier;
use trisap_core::{Aabb, Boxes, Capacity, Config, Serial};

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

/// Fails instead of waiting for ever.
fn wait_until(done: impl Fn() -> bool) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < Duration::from_secs(60), "it does not come");
        thread::yield_now();
    }
}

/// A job that needs `count` threads at once.
fn meet(executor: &dyn Executor, count: u32) {
    let met = AtomicU32::new(0);
    executor.fork_join(count, &|| {
        met.fetch_add(1, Relaxed);
        wait_until(|| met.load(Relaxed) == count);
    });
}

#[test]
fn there_are_as_many_workers_as_threads_that_can_take_part() {
    let pool = pool(3);
    let executor = Rayon::in_pool(&pool);
    assert_eq!(executor.workers(), 4);
    assert_eq!(pool.install(|| Rayon::in_pool(&pool).workers()), 3);
    for width in 2..10 {
        assert!((1..=width).contains(&calls(&executor, width)));
        assert!((1..=width).contains(&calls(&Rayon::global(), width)));
    }
}

#[test]
fn a_thread_that_does_not_come_is_not_waited_for() {
    let pool = pool(1);
    let busy = Arc::new(Barrier::new(2));
    let other = Arc::clone(&busy);
    pool.spawn(move || {
        other.wait();
        other.wait();
    });
    // The only thread is busy from here to the second wait.
    busy.wait();
    let executor = Rayon::in_pool(&pool);
    for _ in 0..100 {
        assert_eq!(calls(&executor, 2), 1);
    }
    assert_eq!(executor.common.looking.load(Relaxed), 1, "it is called once");
    busy.wait();
    meet(&executor, 2);
}

#[test]
fn a_call_that_is_late_is_waited_for() {
    let pool = pool(1);
    let executor = Rayon::in_pool(&pool);
    let (here, came, late) = (thread::current().id(), AtomicBool::new(false), AtomicBool::new(false));
    executor.fork_join(2, &|| {
        if thread::current().id() == here {
            wait_until(|| came.load(Relaxed));
        } else {
            came.store(true, Relaxed);
            wait_until(|| executor.common.asleep.load(Relaxed));
            late.store(true, Relaxed);
        }
    });
    assert!(late.into_inner(), "the caller has not waited");
    // Whether that was a loss depends on how long the other was under way; `sharing` tests what follows.
    assert!(executor.sharing().losses <= 1);
}

#[test]
fn two_callers_do_not_wait_for_each_other() {
    let pool = pool(1);
    let executor = Rayon::in_pool(&pool);
    let inner = AtomicU32::new(0);
    let here = thread::current().id();
    executor.fork_join(2, &|| {
        if thread::current().id() == here {
            inner.fetch_add(calls(&executor, 2), Relaxed);
        }
    });
    assert_eq!(inner.into_inner(), 1);
}

#[test]
fn steps_are_counted() {
    let pool = pool(1);
    let executor = Rayon::in_pool(&pool);
    let step = |shared: bool| {
        executor.enter(Stage::Intake);
        if shared {
            meet(&executor, 2);
        }
        executor.enter(Stage::Done);
    };
    for shared in [true, false, true, false, false] {
        step(shared);
    }
    let Sharing { shared, alone, .. } = executor.sharing();
    assert_eq!((shared, alone), (2, 3));
}

/// A thread that looks for work runs what else the pool has to do. The call for another thread is not for it: the other one would
/// sleep on.
#[test]
fn each_call_for_a_thread_wakes_another() {
    let pool = pool(3);
    let executor = Rayon::in_pool(&pool);
    for _ in 0..200 {
        meet(&executor, 4);
        wait_until(|| executor.common.looking.load(Relaxed) == 0);
        assert_eq!(executor.common.passed_on.load(Relaxed), 0);
    }
}

#[test]
fn threads_go_to_sleep_again() {
    let pool = pool(3);
    let executor = Rayon::in_pool(&pool);
    meet(&executor, 4);
    let common = Arc::clone(&executor.common);
    wait_until(|| common.looking.load(Relaxed) == 0);
    // Nobody but the executor and this test refers to them.
    wait_until(|| Arc::strong_count(&common) == 2);
    meet(&executor, 4);
    drop(executor);
    assert!(common.over.load(Relaxed));
    wait_until(|| Arc::strong_count(&common) == 1);
}

/// Worlds that are stepped by the pool's own threads: nobody lingers for one that has stepped.
#[test]
fn threads_do_not_linger_for_a_world_of_their_own_pool() {
    let pool = pool(2);
    let busy = Barrier::new(2);
    let executor = Rayon::in_pool(&pool);
    const STEPS: u64 = 50;
    pool.scope(|scope| {
        // The other thread has work of its own.
        scope.spawn(|_| {
            busy.wait();
        });
        for _ in 0..STEPS {
            executor.enter(Stage::Intake);
            assert!(executor.workers() <= 2);
            assert_eq!(calls(&executor, 2), 1);
            executor.enter(Stage::Done);
        }
        busy.wait();
    });
    wait_until(|| executor.common.looking.load(Relaxed) == 0);
    let looks = executor.common.looks.load(Relaxed);
    assert!(looks <= 2 * STEPS, "{looks} looks for work after {STEPS} steps");
}

/// Calls that nobody answers get rarer.
#[test]
fn who_never_comes_is_called_for_less_and_less() {
    let pool = pool(2);
    let busy = Barrier::new(2);
    let executor = Rayon::in_pool(&pool);
    pool.scope(|scope| {
        scope.spawn(|_| {
            busy.wait();
        });
        for _ in 0..100 {
            executor.enter(Stage::Intake);
            if executor.workers() > 1 {
                executor.fork_join(2, &|| thread::sleep(Duration::from_micros(50)));
            }
            executor.enter(Stage::Done);
        }
        assert!(!lock(&executor.common.judge).shares(Instant::now()));
        busy.wait();
    });
    assert_eq!(executor.sharing(), Sharing { shared: 0, alone: 100, losses: 0 });
}

#[test]
fn works_from_inside_a_pool() {
    let pool = pool(2);
    pool.install(|| {
        let executor = Rayon::global();
        assert_eq!(executor.workers(), 2);
        meet(&executor, 2);
        meet(&Rayon::in_pool(&pool), 2);
    });
}

#[test]
fn calls_run_at_the_same_time_and_one_of_them_here() {
    let pool = pool(2);
    let here = thread::current().id();
    let met = Barrier::new(3);
    let took_part = AtomicBool::new(false);
    // Would never end if the calls came one after another.
    Rayon::in_pool(&pool).fork_join(3, &|| {
        took_part.fetch_or(thread::current().id() == here, Relaxed);
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
    world.insert_many(Boxes::new(&frame(COUNT, 0))).expect("room");
    let mut transcript = String::new();
    for time in 0..6 {
        let boxes = frame(COUNT, time);
        let step = world.on(executor).step_over(Boxes::new(&boxes)).expect("room");
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
        assert!(pool.install(|| transcript(&Rayon::global())) == serial, "{threads} threads, from inside");
    }
}

#[test]
fn a_panic_on_a_thread_of_the_pool_comes_over() {
    let pool = pool(2);
    let executor = Rayon::in_pool(&pool);
    for _ in 0..3 {
        let (caller, came) = (thread::current().id(), AtomicBool::new(false));
        let job = || {
            if thread::current().id() == caller {
                return wait_until(|| came.load(Relaxed));
            }
            came.store(true, Relaxed);
            resume_unwind(Box::new("a rule's"));
        };
        let panic =
            catch_unwind(AssertUnwindSafe(|| executor.fork_join(3, &job))).expect_err("it comes over");
        assert_eq!(panic.downcast_ref(), Some(&"a rule's"));
    }
    assert!(calls(&executor, 3) > 0);
}

#[test]
fn panics_of_other_tasks_stay_theirs() {
    let serial = transcript(&Serial);
    let pool = pool(2);
    let done = AtomicBool::new(false);
    let mut panics = 0;
    thread::scope(|scope| {
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
        assert!(world.join().expect("no panic comes over").iter().all(|transcript| *transcript == serial));
    });
    assert!(panics > 0, "no neighbour has panicked");
}
