//! Messages between ranks. Nothing here waits for ever: after a time without an answer all ranks end with a message.

use mpi::collective::{SystemOperation, UserOperation};
use mpi::request::{Request, scope};
use mpi::topology::SimpleCommunicator;
use mpi::traits::*;
use std::cell::Cell;
use std::time::{Duration, Instant};
use trisap::{Executor, Stage};

/// What all ranks learn of each other in a step, in one reduction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Census {
    /// Objects of all ranks.
    pub(crate) objects: u64,
    /// Objects of the rank that had most when the step began.
    pub(crate) most: u64,
    /// Messages to ranks that did not expect one.
    pub(crate) far: u64,
}

/// A message from a rank.
pub(crate) type Letter = (usize, Vec<u8>);

/// The ranks of a communicator of our own, and how long to wait for them.
pub(crate) struct Exchange {
    comm: SimpleCommunicator,
    timeout: Duration,
    /// How many reductions and gatherings there have been.
    collectives: Cell<u64>,
}

/// The kinds of messages. Each has tags of its own in each of 1,000 steps.
const LINKED: i32 = 0;
const FAR: i32 = 1;
/// The tag of scattered messages, and one of no message.
const SCATTERED: i32 = 2000;
const NO_TAG: i32 = 2001;

impl Exchange {
    /// Over a communicator of its own, so that messages do not meet those of the caller. All ranks have to call it.
    pub(crate) fn new(comm: &SimpleCommunicator, timeout: Duration) -> Self {
        Self { comm: comm.duplicate(), timeout, collectives: Cell::new(0) }
    }

    /// This rank.
    pub(crate) fn rank(&self) -> usize {
        self.comm.rank() as usize
    }

    /// How many there are.
    pub(crate) fn ranks(&self) -> usize {
        self.comm.size() as usize
    }

    /// How many reductions and gatherings of all ranks there have been.
    pub(crate) fn collectives(&self) -> u64 {
        self.collectives.get()
    }

    fn count_collective(&self) {
        self.collectives.set(self.collectives.get() + 1);
    }

    /// Ends all ranks: this one has found something that makes a right answer impossible.
    pub(crate) fn end_all(&self, why: &str) -> ! {
        // In one piece, as others write, too.
        let line = format!("trisap-mpi: rank {}: {why}; all ranks end\n", self.rank());
        eprint!("{line}");
        self.comm.abort(70)
    }

    /// Asks again and again until there is an answer.
    fn wait<T>(&self, what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
        let begun = Instant::now();
        let mut asked = 0_u32;
        loop {
            if let Some(answer) = ask() {
                return answer;
            }
            asked += 1;
            if asked.is_multiple_of(64) {
                // Somebody else may need the core to answer.
                std::thread::yield_now();
                if begun.elapsed() > self.timeout {
                    self.end_all(&format!("no {what} within {} s", self.timeout.as_secs_f32()));
                }
            }
        }
    }

    fn finish<'a, D: ?Sized, S: mpi::request::Scope<'a>>(&self, what: &str, request: Request<'a, D, S>) {
        let mut request = Some(request);
        self.wait(what, || match request.take()?.test() {
            Ok(_) => Some(()),
            Err(pending) => {
                request = Some(pending);
                None
            }
        });
    }

    /// Receives a message from a rank.
    fn receive(&self, from: usize, tag: i32) -> Letter {
        let what = format!("message from rank {from}");
        let process = self.comm.process_at_rank(from as i32);
        let (message, status) = self.wait(&what, || process.immediate_matched_probe_with_tag(tag));
        let mut bytes = vec![0_u8; status.count(u8::equivalent_datatype()) as usize];
        scope(|scope| {
            let request = message.immediate_matched_receive_into(scope, bytes.as_mut_slice());
            self.finish(&what, request);
        });
        (from, bytes)
    }

    /// Receives so many messages from anybody.
    fn receive_any(&self, count: u64, tag: i32) -> Vec<Letter> {
        let any = self.comm.any_process();
        let receive = |_| {
            let what = "message from any rank";
            let (message, status) = self.wait(what, || any.immediate_matched_probe_with_tag(tag));
            let mut bytes = vec![0_u8; status.count(u8::equivalent_datatype()) as usize];
            scope(|scope| {
                let request = message.immediate_matched_receive_into(scope, bytes.as_mut_slice());
                self.finish(what, request);
            });
            (status.source_rank() as usize, bytes)
        };
        (0..count).map(receive).collect()
    }

    /// The exchange of a step, with the counts of objects that this rank knows of and that it owned when the step began. Each
    /// linked rank gets a message and sends one; all other messages are far ones, which nobody expects before the reduction has
    /// told of them. `work` is done while messages travel.
    ///
    /// Returns what has come, and the census of all ranks.
    pub(crate) fn step(
        &self,
        step: u64,
        linked: &[Letter],
        far: &[Letter],
        [total, own]: [u64; 2],
        work: impl FnOnce(),
    ) -> (Vec<Letter>, Census) {
        if self.ranks() == 1 {
            work();
            return (Vec::new(), Census { objects: total, most: own, far: 0 });
        }
        let tag = (step % 1000) as i32 * 2;
        let mut letters = Vec::new();
        let told = [total, own, far.len() as u64];
        let mut heard = [0_u64; 3];
        // One reduction for a sum, a maximum and a sum.
        let operation = UserOperation::commutative(|more, sum| {
            if let (Some(more), Some(sum)) = (more.downcast::<u64>(), sum.downcast::<u64>()) {
                sum[0] += more[0];
                sum[1] = sum[1].max(more[1]);
                sum[2] += more[2];
            }
        });
        scope(|sending| {
            let mut sent = Vec::new();
            for (kind, list) in [(LINKED, linked), (FAR, far)] {
                for (to, bytes) in list {
                    let process = self.comm.process_at_rank(*to as i32);
                    sent.push(process.immediate_send_with_tag(sending, bytes.as_slice(), tag + kind));
                }
            }
            self.count_collective();
            scope(|reducing| {
                let request =
                    self.comm.immediate_all_reduce_into(reducing, &told[..], &mut heard[..], &operation);
                work();
                letters.extend(linked.iter().map(|(from, _)| self.receive(*from, tag + LINKED)));
                self.finish("census", request);
            });
            if heard[2] > 0 {
                let mut counts = vec![0; self.ranks()];
                far.iter().for_each(|(to, _)| counts[*to] += 1);
                let expected = self.sum(&counts)[self.rank()];
                letters.extend(self.receive_any(expected, tag + FAR));
            }
            for request in sent {
                self.finish("receipt of a message", request);
            }
        });
        (letters, Census { objects: heard[0], most: heard[1], far: heard[2] })
    }

    /// Sends messages to ranks that do not expect them, and receives those of others. All ranks have to call it.
    pub(crate) fn scatter(&self, letters: &[Letter]) -> Vec<Letter> {
        let mut counts = vec![0; self.ranks()];
        letters.iter().for_each(|(to, _)| counts[*to] += 1);
        // Two scatters in a row: a rank that is through with the first one has its messages already.
        let tag = SCATTERED;
        let mut received = Vec::new();
        scope(|sending| {
            let mut sent = Vec::new();
            for (to, bytes) in letters {
                let process = self.comm.process_at_rank(*to as i32);
                sent.push(process.immediate_send_with_tag(sending, bytes.as_slice(), tag));
            }
            let expected = self.sum(&counts)[self.rank()];
            received = self.receive_any(expected, tag);
            for request in sent {
                self.finish("receipt of a message", request);
            }
        });
        // Nobody sends the messages of another scatter before all have those of this one.
        self.sum(&[0]);
        received
    }

    /// The sums of all ranks' numbers, one by one.
    pub(crate) fn sum(&self, numbers: &[u64]) -> Vec<u64> {
        self.reduce(numbers, SystemOperation::sum())
    }

    /// The highest of all ranks' numbers, one by one.
    pub(crate) fn highest(&self, numbers: &[u64]) -> Vec<u64> {
        self.reduce(numbers, SystemOperation::max())
    }

    fn reduce(&self, numbers: &[u64], operation: SystemOperation) -> Vec<u64> {
        self.count_collective();
        let mut result = vec![0; numbers.len()];
        scope(|scope| {
            let request =
                self.comm.immediate_all_reduce_into(scope, numbers, result.as_mut_slice(), operation);
            self.finish("reduction", request);
        });
        result
    }

    /// The numbers of all ranks, as many from each, in the order of ranks.
    pub(crate) fn gather_all(&self, numbers: &[f32]) -> Vec<f32> {
        self.count_collective();
        let mut result = vec![0.0; numbers.len() * self.ranks()];
        scope(|scope| {
            let request = self.comm.immediate_all_gather_into(scope, numbers, result.as_mut_slice());
            self.finish("samples", request);
        });
        result
    }
}

/// An executor that lets MPI go on with long messages between the stages of a sweep: few MPIs do so by themselves.
pub(crate) struct Progress<'e> {
    pub(crate) executor: &'e dyn Executor,
    pub(crate) exchange: &'e Exchange,
}

impl Executor for Progress<'_> {
    fn workers(&self) -> u32 {
        self.executor.workers()
    }

    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        self.executor.fork_join(width, job);
    }

    fn enter(&self, stage: Stage) {
        // Nobody sends a message of this tag: what counts is that MPI looks.
        let _ = self.exchange.comm.any_process().immediate_probe_with_tag(NO_TAG);
        self.executor.enter(stage);
    }
}
