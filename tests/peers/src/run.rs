//! The race: trisap and one peer in turn, frame by frame.

use crate::{
    clock::Clock,
    options::{Events, Options},
    oracle::{self, Digest},
    ours::ours,
    peers::{Crowd, Entry, Output, Peer, Setting, Start},
    recording::{Padded, Recording},
    report::{Outcome, Race, Report, Scene},
};
use std::{
    collections::HashSet,
    ops::Range,
    panic::{self, AssertUnwindSafe},
    time::Duration,
};

/// Frames before the timed ones: caches, allocations and adaptive parts settle.
const WARM_UP: usize = 8;
/// The same in a crowd at rest, where trisap divides its leaves, some in each step.
const CROWD_WARM_UP: usize = 100;

/// Races trisap against every peer on one recording.
pub(crate) fn scene(recording: &Recording, options: &Options, report: &mut Report) {
    let objects = recording.objects;
    let count = options.movers.unwrap_or(objects).min(objects);
    let movers: Vec<u32> = (0..count).map(|index| (index * objects / count) as u32).collect();
    let mut moving = vec![false; objects];
    movers.iter().for_each(|&mover| moving[mover as usize] = true);
    let (warm_up, usual) =
        if count < objects { (CROWD_WARM_UP, 50) } else { (WARM_UP, (2_000_000 / objects).clamp(15, 300)) };
    let timed = options.frames.unwrap_or(usual);
    eprintln!("{} {objects}, of which {count} move: {timed} frames", recording.name);
    let frames = warm_up..warm_up + timed;
    let used = (0..frames.end).map(|step| recording.index(step)).max().unwrap_or(0);
    let mut boxes = recording.frame(0).to_vec();
    let mut expected = [Vec::new(), Vec::new()];
    for step in 0..recording.len().min(used + 1) {
        advance(&mut boxes, &movers, recording.frame(step));
        expected[0].push(oracle::pairs(&boxes, |_, _| true));
        if count < objects {
            expected[1].push(oracle::pairs(&boxes, |a, b| moving[a as usize] || moving[b as usize]));
        }
    }
    let pairs = expected[0].iter().map(|digest| digest.count).sum::<u64>() / expected[0].len() as u64;
    report.scenes.push(Scene { name: recording.name.clone(), objects, movers: count, frames: timed, pairs });

    for entry in options.entries() {
        let outcome = match entry.start {
            Err(reason) => Outcome::LeftOut(reason.into()),
            Ok(_) if options.threads > 1 && !entry.parallel => Outcome::LeftOut("one thread only".into()),
            Ok(_) if count < objects && entry.crowd == Crowd::Unsuited => {
                Outcome::LeftOut("goes over all boxes".into())
            }
            Ok(start) => {
                let race = || race(recording, &movers, &expected, &frames, options, &entry, start);
                // Some peers do not bear infinite boxes, which is no reason to lose what the others do.
                panic::catch_unwind(AssertUnwindSafe(race))
                    .unwrap_or_else(|_| Outcome::Wrong("panicked".into()))
            }
        };
        eprintln!("  {}: {outcome}", entry.name);
        report.add(&entry, outcome);
    }
}

/// Gives the movers their boxes of a frame.
fn advance(boxes: &mut [Padded], movers: &[u32], frame: &[Padded]) {
    for &mover in movers {
        boxes[mover as usize] = frame[mover as usize];
    }
}

/// `expected`: all pairs of each frame, and those of movers. `frames`: those that are timed.
fn race(
    recording: &Recording,
    movers: &[u32],
    expected: &[Vec<Digest>; 2],
    frames: &Range<usize>,
    options: &Options,
    entry: &Entry,
    start: Start,
) -> Outcome {
    let events = match options.events {
        Events::Auto => entry.events,
        Events::On => true,
        Events::Off => false,
    };
    let [all, of_movers] = expected;
    let most = all.iter().map(|digest| digest.count).max().unwrap_or(0);
    let mut boxes = recording.frame(0).to_vec();
    let setting = Setting { boxes: &boxes, movers, threads: options.threads };
    let of_peer = if setting.is_crowd() && entry.crowd == Crowd::OfMovers { of_movers } else { all };
    let mut ours = match ours(&setting, most, options, events, entry.fat) {
        Ok(ours) => Runner::new(ours, entry.fat, options.clock),
        Err(reason) => return Outcome::Wrong(reason),
    };
    let mut peer = Runner::new(start(&setting), entry.fat, options.clock);
    for step in 0..frames.end {
        advance(&mut boxes, movers, recording.frame(step));
        for (name, runner, expected) in [("trisap", &mut ours, all), (entry.name, &mut peer, of_peer)] {
            let want = expected[recording.index(step)];
            let have = runner.run(&boxes);
            if have != want {
                return Outcome::Wrong(format!(
                    "{name}, frame {step}: {} pairs where {} overlap{}",
                    have.count,
                    want.count,
                    if have.count == want.count { ", not the same ones" } else { "" }
                ));
            }
        }
    }
    let surplus = peer.surplus as f64 / peer.kept.max(1) as f64;
    Outcome::Raced(Race { ours: ours.times(frames.start), peer: peer.times(frames.start), events, surplus })
}

/// One side of a race: times the frames and keeps its pair set.
struct Runner {
    peer: Box<dyn Peer>,
    fat: bool,
    clock: Clock,
    times: Vec<Duration>,
    /// Of the pair set so far, for exact peers with events.
    digest: Digest,
    /// The pair set so far, for fat peers with events.
    set: HashSet<[u32; 2]>,
    /// Pairs told that do not overlap, and pairs that do, over all frames.
    surplus: u64,
    kept: u64,
}

impl Runner {
    fn new(peer: Box<dyn Peer>, fat: bool, clock: Clock) -> Self {
        Self {
            peer,
            fat,
            clock,
            times: Vec::new(),
            digest: Digest::default(),
            set: HashSet::new(),
            surplus: 0,
            kept: 0,
        }
    }

    /// One frame, and the pairs that overlap among those told.
    fn run(&mut self, boxes: &[Padded]) -> Digest {
        self.peer.prepare(boxes);
        let start = self.clock.now();
        self.peer.frame();
        self.times.push(self.clock.now() - start);

        let Self { digest, set, .. } = self;
        let filtered = |pairs: &mut dyn Iterator<Item = [u32; 2]>| {
            let (mut exact, mut told) = (Digest::default(), 0);
            for [a, b] in pairs {
                told += 1;
                if oracle::overlap(&boxes[a as usize], &boxes[b as usize]) {
                    exact.add([a, b]);
                }
            }
            (exact, told)
        };
        let (exact, told) = match self.peer.output() {
            Output::Pairs(pairs) if self.fat => filtered(&mut pairs.iter().copied()),
            Output::Pairs(pairs) => {
                *digest = Digest::default();
                pairs.iter().for_each(|&pair| digest.add(pair));
                (*digest, digest.count)
            }
            Output::Events { found, lost } if self.fat => {
                lost.iter().for_each(|[a, b]| _ = set.remove(&[*a.min(b), *a.max(b)]));
                set.extend(found.iter().map(|[a, b]| [*a.min(b), *a.max(b)]));
                filtered(&mut set.iter().copied())
            }
            Output::Events { found, lost } => {
                lost.iter().for_each(|&pair| digest.remove(pair));
                found.iter().for_each(|&pair| digest.add(pair));
                (*digest, digest.count)
            }
        };
        self.surplus += told - exact.count;
        self.kept += exact.count;
        exact
    }

    /// The times of the frames after the first so many.
    fn times(&self, warm_up: usize) -> Vec<Duration> {
        self.times[warm_up..].to_vec()
    }
}
