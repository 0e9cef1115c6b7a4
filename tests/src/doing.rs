//! What a failing test was at: each panic in a thread that made a world or random numbers says so, so that no test has to.

use crate::worlds::Setup;
use std::cell::RefCell;
use std::panic;
use std::sync::Once;
use std::thread;
use trisap_core::{Index, Stepper, World};

/// The last world of a thread, what its last step or query ran on, and the last random numbers.
#[derive(Clone, Debug, Default)]
struct Doing {
    width: usize,
    setup: Option<Setup>,
    steps: u32,
    seeds: Vec<u64>,
}

thread_local! {
    static DOING: RefCell<Doing> = RefCell::default();
}

/// As many of the last seeds are said.
const SEEDS: usize = 4;

fn note(change: impl FnOnce(&mut Doing)) {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            usual(info);
            DOING.with_borrow(|doing| {
                let Doing { width, setup, steps, seeds } = doing;
                if *width > 0 || !seeds.is_empty() {
                    let setup = setup.map_or_else(|| "no setup".to_owned(), |setup| format!("{setup:?}"));
                    eprintln!(
                        "at step {steps} of a world with slots of {width} bits, {setup}, seeds {seeds:?}"
                    );
                    // A test runs in a thread of its name.
                    if let Some(name) = thread::current().name() {
                        eprintln!("to repeat it: cargo test -p trisap-tests -- --exact {name}");
                    }
                }
            });
        }));
    });
    DOING.with_borrow_mut(change);
}

/// A world was made.
pub(crate) fn made<I: Index>() {
    note(|doing| (doing.width, doing.steps) = (8 * size_of::<I>(), 0));
}

/// Random numbers begin.
pub(crate) fn drew(seed: u64) {
    note(|doing| {
        doing.seeds.truncate(SEEDS - 1);
        doing.seeds.insert(0, seed);
    });
}

/// Runs a world on a setup.
pub trait On<'m, I: Index> {
    /// Uses its kernels.
    fn with(&mut self, setup: Setup) -> &mut World<'m, I>;
    /// A step on its kernels and jobs.
    fn under<'s>(&mut self, setup: &'s Setup) -> Stepper<'_, 'm, 's, I>;
}

impl<'m, I: Index> On<'m, I> for World<'m, I> {
    fn with(&mut self, setup: Setup) -> &mut World<'m, I> {
        note(|doing| doing.setup = Some(setup));
        self.set_kernels(setup.kernels)
    }

    fn under<'s>(&mut self, setup: &'s Setup) -> Stepper<'_, 'm, 's, I> {
        note(|doing| doing.steps += 1);
        self.with(*setup).on(&setup.jobs)
    }
}
