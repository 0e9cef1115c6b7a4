//! The race: trisap and one peer in turn, frame by frame.

use crate::{
    options::{Events, Options},
    oracle::{self, Digest},
    ours::ours,
    peers::{Entry, Output, Peer, Start},
    recording::{Padded, Recording},
    report::{Outcome, Race, Report, Scene},
};
use std::{
    collections::HashSet,
    time::{Duration, Instant},
};

/// Frames before the timed ones: caches, allocations and adaptive parts settle.
const WARM_UP: usize = 8;

/// Races trisap against every peer on one recording.
pub(crate) fn scene(recording: &Recording, options: &Options, report: &mut Report) {
    let objects = recording.objects;
    let frames = options.frames.unwrap_or((2_000_000 / objects).clamp(15, 300));
    let used = (0..WARM_UP + frames).map(|step| recording.index(step)).max().unwrap_or(0);
    eprintln!("{} {objects}: {frames} frames", recording.name);
    let expected: Vec<Digest> =
        (0..recording.len().min(used + 1)).map(|i| oracle::pairs(recording.frame(i))).collect();
    let pairs = expected.iter().map(|digest| digest.count).sum::<u64>() / expected.len() as u64;
    report.scenes.push(Scene { name: recording.name.clone(), objects, frames, pairs });

    for entry in options.entries() {
        let outcome = match entry.start {
            Err(reason) => Outcome::LeftOut(reason.into()),
            Ok(_) if options.threads > 1 && !entry.parallel => Outcome::LeftOut("one thread only".into()),
            Ok(start) => race(recording, &expected, frames, options, &entry, start),
        };
        eprintln!("  {}: {outcome}", entry.name);
        report.add(&entry, outcome);
    }
}

fn race(
    recording: &Recording,
    expected: &[Digest],
    frames: usize,
    options: &Options,
    entry: &Entry,
    start: Start,
) -> Outcome {
    let events = match options.events {
        Events::Auto => entry.events,
        Events::On => true,
        Events::Off => false,
    };
    let most = expected.iter().map(|digest| digest.count).max().unwrap_or(0);
    let mut ours = match ours(recording.frame(0), most, options, events) {
        Ok(ours) => Runner::new(ours, false),
        Err(reason) => return Outcome::Wrong(reason),
    };
    let mut peer = Runner::new(start(recording.frame(0), options.threads), entry.fat);
    for step in 0..WARM_UP + frames {
        let boxes = recording.frame(step);
        let want = expected[recording.index(step)];
        for (name, runner) in [("trisap", &mut ours), (entry.name, &mut peer)] {
            let have = runner.run(boxes);
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
    Outcome::Raced(Race { ours: ours.times(), peer: peer.times(), events, surplus })
}

/// One side of a race: times the frames and keeps its pair set.
struct Runner {
    peer: Box<dyn Peer>,
    fat: bool,
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
    fn new(peer: Box<dyn Peer>, fat: bool) -> Self {
        Self {
            peer,
            fat,
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
        let start = Instant::now();
        self.peer.frame();
        self.times.push(start.elapsed());

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

    /// The times of the timed frames.
    fn times(&self) -> Vec<Duration> {
        self.times[WARM_UP..].to_vec()
    }
}
