//! Offers a job to threads that outlive it. Only here the lifetime is taken off a pointer to a job.

#![allow(unsafe_code, reason = "a job is lent to threads that outlive it")]

use core::cell::UnsafeCell;
use core::hint::spin_loop;
use core::mem::transmute;
use core::sync::atomic::AtomicU32;
use core::sync::atomic::Ordering::{AcqRel, Acquire, Relaxed, Release};

/// A job, without its lifetime.
type Job = *const (dyn Fn() + Sync);

/// Set while a caller holds the offer.
const HELD: u32 = 1 << 31;
/// The lowest bit of the seats: how many more calls may begin. They end below [`HELD`].
const SEAT: u32 = 1 << 16;
const SEATS: u32 = HELD - SEAT;
/// The bits that count the calls of others that have begun and not returned.
const RUNNING: u32 = SEAT - 1;

/// A job on offer to other threads, for executors: the caller waits only for calls that have begun.
///
/// [`lend`](Self::lend) calls the job on the calling thread, while any thread may [`take part`](Self::take_part).
/// When the caller finds no work left, the offer ends. A thread that has not come by then is not waited for, so a
/// thread that the operating system has not let run costs nothing.
///
/// # When others want the processors
/// A step waits for the last call of each of its jobs. Beside other busy threads an executor that spins and waits can make
/// it several times slower than one thread. It never does if it follows these rules, and it keeps its gain where processors
/// are free:
/// - **Wait only for calls that have begun.** When the caller's own call has returned, no work is left: take the other calls
///   back, as an offer does. A thread that sleeps or may not run then costs nothing.
/// - **Spin for microseconds only,** in the caller that waits for a call and a thread that waits for a job. Then let others
///   run (`yield_now`), then sleep, so that a thread that holds a block but no processor gets this one.
/// - **Work alone after a long wait,** for many times as long as the wait was, longer each time that it happens again. To
///   work alone, [`workers`](crate::Executor::workers) returns 1, or `fork_join` makes one call.
/// - **Compare.** Who works on what never changes a byte, so time may decide. If shared steps are no faster than steps
///   alone, stay alone and try again later. [`enter`](crate::Executor::enter) tells when steps begin and end.
///
/// `trisap::Rayon` does all of this, and `ffi/examples/job_system.hpp` all but the last in C++.
///
/// ```
/// use trisap::{Executor, Offer};
///
/// /// The threads of an engine call `take_part` whenever they have nothing else to do.
/// struct Engine {
///     offer: Offer,
///     threads: u32,
/// }
///
/// impl Executor for Engine {
///     fn workers(&self) -> u32 {
///         self.threads + 1
///     }
///     fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
///         // If another world's job is on offer, the step does this one itself.
///         self.offer.lend(width - 1, job, std::thread::yield_now);
///     }
/// }
/// ```
#[derive(Debug)]
pub struct Offer {
    state: AtomicU32,
    /// The caller that holds the offer writes it before there are seats; a thread that has taken a seat reads it.
    job: UnsafeCell<Option<Job>>,
}

// SAFETY: only the caller that has set HELD writes `job`, while there are no seats and no call is running. Only a thread
// that has taken a seat and not yet returned reads it. What it points to is `Sync`, and alive until no call is running:
// see `lend`.
unsafe impl Sync for Offer {}
// SAFETY: as above; where the offer itself is does not matter.
unsafe impl Send for Offer {}

impl Default for Offer {
    fn default() -> Self {
        Self::new()
    }
}

impl Offer {
    /// An empty offer.
    #[must_use]
    pub fn new() -> Self {
        Self { state: AtomicU32::new(0), job: UnsafeCell::new(None) }
    }

    /// Calls `job` here, while up to `seats` calls may begin on other threads. Returns when all calls that have begun
    /// have returned; until then it calls `wait` again and again. Returns `false` if another thread uses the offer:
    /// then nothing has been called.
    pub fn lend(&self, seats: u32, job: &(dyn Fn() + Sync), mut wait: impl FnMut()) -> bool {
        // Acquire: the calls of the last job have read its pointer before this one is written.
        if self.state.compare_exchange(0, HELD, Acquire, Relaxed).is_err() {
            return false;
        }
        // SAFETY: only the lifetime in the type changes. `Held` does not let this function return or unwind while a call
        // is running or may begin, and `job` is alive until then.
        let pointer = unsafe { transmute::<*const (dyn Fn() + Sync + '_), Job>(job) };
        // SAFETY: HELD is ours, there are no seats, and no call is running.
        unsafe { *self.job.get() = Some(pointer) };
        let held = Held(self);
        // Release: a thread that takes a seat sees the pointer, and all that this thread did before.
        self.state.store(HELD | (SEAT * seats.min(SEATS / SEAT)), Release);
        job();
        held.close();
        while self.running() > 0 {
            wait();
        }
        true
    }

    /// Makes one call of the job on offer. Returns `false` if there is none, or no seat is left.
    pub fn take_part(&self) -> bool {
        let mut state = self.state.load(Relaxed);
        loop {
            if state & SEATS == 0 {
                return false;
            }
            // Acquire: what the caller wrote before the seats is seen here.
            match self.state.compare_exchange_weak(state, state - SEAT + 1, Acquire, Relaxed) {
                Ok(_) => break,
                Err(now) => state = now,
            }
        }
        let _running = Running(self);
        // SAFETY: this thread has taken a seat, so the pointer is written, and not written again before `Running` is
        // dropped.
        if let Some(job) = unsafe { *self.job.get() } {
            // SAFETY: the caller waits until no call is running, so the job is alive, and it is `Sync`.
            unsafe { (*job)() };
        }
        true
    }

    /// How many calls of other threads have begun and not returned.
    #[must_use]
    pub fn running(&self) -> u32 {
        // Acquire: a thread that sees that a call has returned also sees what it did.
        self.state.load(Acquire) & RUNNING
    }
}

/// The caller's hold on the offer.
struct Held<'o>(&'o Offer);

impl Held<'_> {
    /// Lets no more calls begin.
    fn close(&self) {
        self.0.state.fetch_and(!SEATS, AcqRel);
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        // Also where the job or `wait` unwinds.
        self.close();
        while self.0.running() > 0 {
            spin_loop();
        }
        self.0.state.store(0, Release);
    }
}

/// A call that has begun.
struct Running<'o>(&'o Offer);

impl Drop for Running<'_> {
    fn drop(&mut self) {
        // Release: what the call has done comes before the end of the job.
        self.0.state.fetch_sub(1, Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
    use std::sync::Barrier;
    use std::thread;

    fn idle(offer: &Offer) -> bool {
        offer.state.load(Relaxed) == 0 && !offer.take_part()
    }

    #[test]
    fn nobody_is_waited_for_who_has_not_come() {
        let (offer, calls) = (Offer::new(), AtomicU32::new(0));
        let job = || {
            calls.fetch_add(1, Relaxed);
        };
        assert!(offer.lend(3, &job, || unreachable!("nobody has come")));
        assert_eq!(calls.into_inner(), 1);
        assert!(idle(&offer));
    }

    #[test]
    fn all_who_have_come_are_waited_for() {
        let (offer, met, calls) = (Offer::new(), Barrier::new(3), AtomicU32::new(0));
        thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(|| {
                    while !offer.take_part() {
                        thread::yield_now();
                    }
                });
            }
            let here = thread::current().id();
            let job = || {
                met.wait();
                if thread::current().id() != here {
                    thread::yield_now();
                    calls.fetch_add(1, Relaxed);
                }
            };
            assert!(offer.lend(2, &job, thread::yield_now));
            assert_eq!(calls.load(Relaxed), 2);
        });
        assert!(idle(&offer));
    }

    #[test]
    fn no_more_come_than_there_are_seats() {
        let (offer, calls) = (Offer::new(), AtomicU32::new(0));
        // A call from inside the job counts as one of another thread.
        let job = || {
            if calls.fetch_add(1, Relaxed) == 0 {
                assert!(offer.take_part() && offer.take_part() && !offer.take_part());
                assert!(!offer.lend(1, &|| unreachable!("the offer is in use"), || {}));
            }
        };
        assert!(offer.lend(2, &job, || {}));
        assert_eq!(calls.into_inner(), 3);
        assert!(idle(&offer));
    }

    #[test]
    fn a_job_that_panics_leaves_nothing_on_offer() {
        let (offer, calls) = (Offer::new(), AtomicU32::new(0));
        let job = || {
            if calls.fetch_add(1, Relaxed) == 0 {
                assert!(catch_unwind(AssertUnwindSafe(|| offer.take_part())).is_err());
            }
            resume_unwind(Box::new(()));
        };
        assert!(catch_unwind(AssertUnwindSafe(|| offer.lend(2, &job, || {}))).is_err());
        assert_eq!(calls.into_inner(), 2);
        assert!(idle(&offer));
    }
}
