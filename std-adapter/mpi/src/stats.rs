//! What a step has done.

use rustix::time::{ClockId, clock_gettime};
use std::time::{Duration, Instant};

/// The parts of a step, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// New planes, where they move.
    Balance,
    /// Who has to hear what.
    Route,
    /// The sweep while messages travel.
    EarlySweep,
    /// Waiting for messages and for the census of all ranks.
    Exchange,
    /// Ghosts enter, move and leave.
    Apply,
    /// The sweep over all boxes.
    LastSweep,
    /// Which pairs were found and lost.
    Events,
}

impl Stage {
    /// All parts.
    pub const ALL: [Self; 7] = [
        Self::Balance,
        Self::Route,
        Self::EarlySweep,
        Self::Exchange,
        Self::Apply,
        Self::LastSweep,
        Self::Events,
    ];

    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Balance => "balance",
            Self::Route => "route",
            Self::EarlySweep => "early sweep",
            Self::Exchange => "exchange",
            Self::Apply => "apply",
            Self::LastSweep => "last sweep",
            Self::Events => "events",
        }
    }
}

/// What the last step has done on this rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Objects of all ranks.
    pub total: u64,
    /// Objects of the rank that had most when the step began.
    pub most: u64,
    /// Objects that this rank owns.
    pub objects: u64,
    /// Objects of other ranks that reach its cell.
    pub ghosts: u64,
    /// Objects that it owns since this step and another rank owned before.
    pub arrived: u64,
    /// Objects that it owned and another rank owns now.
    pub departed: u64,
    /// Bytes that it has sent.
    pub bytes: u64,
    /// Objects that it has told other ranks of, once for each rank: because they changed and reach or reached its cell.
    pub told: u64,
    /// Bytes of these that are boxes and keys of objects that had to travel: 32 for each object that the other rank knows, 56 for
    /// each that it does not, since only with the box of the last step it can tell a new pair from one that another rank had.
    pub bytes_needed: u64,
    /// Messages that it has sent.
    pub messages: u64,
    /// Messages of all ranks to ranks that did not expect one.
    pub far: u64,
    /// Reductions and gatherings of all ranks: one where planes need not move and all messages go to linked ranks.
    pub collectives: u64,
    /// Whether planes have moved.
    pub planes_moved: bool,
    /// Whether it swept while messages travelled.
    pub overlapped: bool,
    /// The time of each part of the step, in the order of [`Stage::ALL`].
    pub times: [Duration; Stage::ALL.len()],
    /// The time of the calling thread's processor in each of them. Where a rank waits it asks again and again, which counts.
    pub processor: [Duration; Stage::ALL.len()],
}

/// Takes the times of the stages.
pub(crate) struct Clock {
    last: Instant,
    processor: Duration,
}

impl Clock {
    pub(crate) fn start() -> Self {
        Self { last: Instant::now(), processor: processor_time() }
    }

    /// The time since the last call is that of a stage.
    pub(crate) fn end(&mut self, stage: Stage, stats: &mut Stats) {
        let (now, processor) = (Instant::now(), processor_time());
        stats.times[stage as usize] += now - self.last;
        stats.processor[stage as usize] += processor.saturating_sub(self.processor);
        (self.last, self.processor) = (now, processor);
    }
}

/// The time that this thread has had a processor.
fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec as u32)
}
