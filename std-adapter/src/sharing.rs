//! Decides when to share the work of steps: after time is lost by waiting for others, work is done alone for a while.

use std::mem;
use std::time::{Duration, Instant};

/// After a loss, work is done alone for so many times its length. So losses are a small part of the whole.
const REPAID: u32 = 32;
/// The same after a good time, which is one of twice that length.
const REPAID_AFTER_GOOD: u32 = 8;
/// The most, if losses follow each other: small ones are no reason for a long time alone.
const MOST_REPAID: u32 = 1000;
/// The longest time alone. After processors become free, it takes at most this long to find out.
const LONGEST: Duration = Duration::from_secs(1);
/// Calls of a job do not end in the same instant: each still has a block of work in hand when there are no more.
const SKEW: Duration = Duration::from_micros(20);

/// After so many steps for which nobody came, work is done alone for [`REPAID`] times the length of one: those who would
/// come have other work.
const UNANSWERED: u32 = 4;

/// After so many shared steps their time is compared with that of steps done alone.
const WINDOW: u32 = 16;
/// After so many windows in a row one step is done alone, to know what it takes.
const WINDOWS: u32 = 4;

/// How often the work of steps was shared: see [`Rayon::sharing`](crate::Rayon::sharing).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Sharing {
    /// Steps of which another thread has done a part.
    pub shared: u64,
    /// Steps that the calling thread has done alone: they were small, no thread came, or it was chosen.
    pub alone: u64,
    /// How often others were late, so that the executor chose to work alone for a while.
    pub losses: u64,
}

/// The choice between sharing and working alone.
#[derive(Debug, Default)]
pub(crate) struct Judge {
    pub(crate) counts: Sharing,
    /// Nothing is shared until then.
    alone_until: Option<Instant>,
    /// How long it was the last time.
    rest: Duration,
    /// For how long jobs have been shared without a loss.
    calm: Duration,
    /// When this step began.
    begun: Option<Instant>,
    /// Another thread has had a part in this step.
    taken: bool,
    /// This step is done alone by choice.
    refused: bool,
    /// Another thread was called for in this step, and in how many steps nobody came; half of them are forgiven where somebody has.
    called: bool,
    unanswered: u32,
    /// What a step takes alone: a mean of the last ones.
    one: Option<Duration>,
    /// How many steps were shared since the last comparison, and their time.
    window: (u32, Duration),
    /// Comparisons since a step was done alone.
    windows: u32,
}

/// How the calls of a job have ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job {
    pub(crate) took: Duration,
    /// When the first call ended, since the begin of the job: until then all have worked. None if no other thread has come.
    pub(crate) first: Option<Duration>,
}

impl Judge {
    /// Whether the work may be shared now.
    pub(crate) fn shares(&mut self, now: Instant) -> bool {
        let rests = self.alone_until.is_some_and(|until| now < until);
        // If steps are not reported, there is nothing to compare.
        let stepping = self.begun.is_some();
        let compares = stepping && self.windows >= WINDOWS && !self.taken;
        // A step that has begun alone ends alone, to measure how long that takes.
        self.refused = rests || compares || (stepping && self.refused);
        !self.refused
    }

    /// A job has ended now.
    pub(crate) fn ended(&mut self, job: Job, now: Instant) {
        self.called = true;
        let Some(first) = job.first else { return };
        self.taken = true;
        // Alone it would have taken about half as long again at least.
        let lost = job.took.saturating_sub(first + first / 2 + SKEW);
        if lost > Duration::ZERO {
            return self.lost(lost, now);
        }
        self.calm += job.took;
    }

    /// Sharing has cost so much.
    pub(crate) fn lost(&mut self, time: Duration, now: Instant) {
        self.counts.losses += 1;
        let calm = mem::take(&mut self.calm);
        self.rest = if calm > 2 * REPAID_AFTER_GOOD * time {
            REPAID_AFTER_GOOD * time
        } else {
            // Twice as long as the last time, within limits: a busy processor may be busy for long.
            let longer = (2 * self.rest).min(MOST_REPAID * time);
            (REPAID * time).max(longer).min(LONGEST)
        };
        self.window = Default::default();
        self.alone_until = Some(now + self.rest);
    }

    /// A step begins, or enters another stage.
    pub(crate) fn step_begun(&mut self, now: Instant) {
        self.begun.get_or_insert(now);
    }

    /// A step has ended.
    pub(crate) fn step_ended(&mut self, now: Instant) {
        let (taken, refused) = (mem::take(&mut self.taken), mem::take(&mut self.refused));
        let took = self.begun.take().map_or(Duration::ZERO, |begun| now - begun);
        let count = if taken { &mut self.counts.shared } else { &mut self.counts.alone };
        *count += 1;
        if mem::take(&mut self.called) {
            self.unanswered = if taken { self.unanswered / 2 } else { self.unanswered + 1 };
            if self.unanswered >= UNANSWERED {
                self.alone_until = Some(now + REPAID * took);
            }
        }
        match (taken, refused) {
            (false, true) => self.stepped_alone(took),
            (true, false) => self.stepped_shared(took, now),
            // The work was small, no thread came, or there was a loss within the step: nothing can be compared.
            _ => {}
        }
    }

    fn stepped_alone(&mut self, took: Duration) {
        self.windows = 0;
        self.one = Some(match self.one {
            // Noise makes steps longer, but never this much shorter.
            Some(one) if took > one / 2 => (7 * one + took.min(2 * one)) / 8,
            _ => took,
        });
    }

    fn stepped_shared(&mut self, took: Duration, now: Instant) {
        let Some(one) = self.one else {
            self.windows = WINDOWS;
            return;
        };
        // What is far longer was a loss and is counted there.
        self.window.0 += 1;
        self.window.1 += took.min(2 * one);
        if self.window.0 == WINDOW {
            self.windows += 1;
            let (_, all) = mem::take(&mut self.window);
            // Less than a twentieth is no gain worth a second processor.
            let worth = WINDOW * one / 20 * 19;
            if all > worth {
                // No time was good that has gained nothing.
                self.calm = Duration::ZERO;
                self.lost(all - worth, now);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(count: u64) -> Duration {
        Duration::from_millis(count)
    }

    const QUIET: Job = Job { took: ms(2), first: Some(ms(2)) };
    const LATE: Job = Job { took: ms(7), first: Some(ms(2)) };

    #[test]
    fn a_loss_is_paid_back() {
        let (mut judge, now) = (Judge::default(), Instant::now());
        assert!(judge.shares(now));
        judge.ended(QUIET, now);
        assert!(judge.shares(now));
        judge.ended(LATE, now);
        assert!(!judge.shares(now));
        assert!(!judge.shares(now + 16 * ms(4)));
        assert!(judge.shares(now + REPAID * ms(4)));
        assert!(judge.shares(now + REPAID * ms(4)), "without steps nothing is compared");
        assert_eq!(judge.counts.losses, 1);
    }

    #[test]
    fn losses_are_ever_rarer_and_never_given_up_on() {
        let (mut judge, begin) = (Judge::default(), Instant::now());
        let (mut now, mut losses) = (begin, 0);
        while now < begin + ms(60_000) {
            if judge.shares(now) {
                judge.ended(LATE, now);
                losses += 1;
            }
            now += ms(1);
        }
        assert_eq!(judge.rest, LONGEST);
        assert_eq!(judge.counts.losses, losses);
        assert!((60..70).contains(&losses), "{losses} in a minute");
    }

    #[test]
    fn a_loss_after_a_good_time_is_cheaper() {
        let (mut judge, now) = (Judge::default(), Instant::now());
        for _ in 0..10 {
            judge.ended(LATE, now);
        }
        assert_eq!(judge.rest, LONGEST);
        for _ in 0..100 {
            judge.ended(QUIET, now);
        }
        judge.ended(LATE, now);
        assert!(judge.rest <= REPAID_AFTER_GOOD * ms(4));
        judge.ended(LATE, now);
        assert!(judge.rest >= REPAID * ms(3), "the time before the last loss does not count twice");
    }

    #[test]
    fn small_losses_are_no_reason_for_a_long_time_alone() {
        let (mut judge, now) = (Judge::default(), Instant::now());
        for _ in 0..100 {
            judge.lost(Duration::from_micros(3), now);
        }
        assert_eq!(judge.rest, ms(3));
    }

    /// Steps of which one takes `one` alone and `two` shared.
    fn steps((judge, now): &mut (Judge, Instant), count: u32, one: Duration, two: Duration) -> Sharing {
        let before = judge.counts;
        for _ in 0..count {
            judge.step_begun(*now);
            let shares = judge.shares(*now);
            let took = if shares { two } else { one };
            *now += took;
            if shares {
                judge.ended(Job { took, first: Some(took) }, *now);
            }
            judge.step_ended(*now);
        }
        let after = judge.counts;
        Sharing {
            shared: after.shared - before.shared,
            alone: after.alone - before.alone,
            losses: after.losses - before.losses,
        }
    }

    #[test]
    fn what_gains_is_shared() {
        let counts = steps(&mut (Judge::default(), Instant::now()), 1000, ms(3), ms(2));
        assert_eq!((counts.shared + counts.alone, counts.losses), (1000, 0));
        // One in `WINDOW * WINDOWS` is done alone.
        assert!((5..30).contains(&counts.alone), "{counts:?}");
    }

    #[test]
    fn what_gains_nothing_is_done_alone_but_tried_again() {
        let mut judge = (Judge::default(), Instant::now());
        let counts = steps(&mut judge, 10_000, ms(3), ms(3));
        assert!(counts.alone > 9 * counts.shared, "{counts:?}");
        assert!(counts.losses > 10);
        // Now it gains: that is found out.
        steps(&mut judge, 1000, ms(3), ms(2));
        let counts = steps(&mut judge, 1000, ms(3), ms(2));
        assert!(counts.shared > 900, "{counts:?}");
    }

    #[test]
    fn calls_do_not_end_at_once() {
        let (mut judge, now) = (Judge::default(), Instant::now());
        for took in [Duration::ZERO, ms(1), ms(100)] {
            judge.ended(Job { took: took + took / 2 + SKEW, first: Some(took) }, now);
        }
        assert!(judge.shares(now));
        assert_eq!(judge.counts.losses, 0);
    }

    #[test]
    fn a_step_is_shared_if_a_part_of_it_is() {
        let (mut judge, now) = (Judge::default(), Instant::now());
        judge.ended(Job { took: ms(1), first: None }, now);
        judge.step_ended(now);
        judge.ended(QUIET, now);
        judge.ended(Job { took: ms(1), first: None }, now);
        judge.step_ended(now);
        judge.step_ended(now);
        assert_eq!(judge.counts, Sharing { shared: 1, alone: 2, losses: 0 });
    }
}
