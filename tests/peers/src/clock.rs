//! The time of a frame.

use rustix::time::{ClockId, clock_gettime};
use std::time::Duration;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Clock {
    /// That passes.
    Wall,
    /// That all threads of the process have had of the CPU. Where others run as well, a long frame is interrupted more often
    /// than a short one, which counts against slow peers in the other clock.
    Cpu,
}

impl Clock {
    pub(crate) fn now(self) -> Duration {
        let time = clock_gettime(match self {
            Self::Wall => ClockId::Monotonic,
            Self::Cpu => ClockId::ProcessCPUTime,
        });
        Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
    }

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Wall => "wall clock",
            Self::Cpu => "CPU time",
        }
    }
}
