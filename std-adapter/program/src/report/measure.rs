//! Steps worlds through clips and takes the time: the one way in which the report measures.
//!
//! What is to be compared is measured in turns, in one run: a pass over the clip for each contender, and so on until the
//! time is up. A change of the machine's pace meets all of them, and the medians of all steps can be compared. Before
//! that, each contender's results are compared with those of an independent method.

use super::clip::Clip;
use super::result::Verdict;
use crate::check::differences;
use crate::drive::Pairs;
use crate::figures::{median, quantile};
use crate::setup::fits_u16;
use anyhow::{Context, Result};
use std::time::{Duration, Instant};
use trisap::{Boxes, Config, Error, Index, Kernels, Mode, OwnedWorld, Pair, Stats};

/// What is measured: a world, what it is stepped with, and what it is stepped through.
pub(super) struct Contender<'c> {
    pub(super) name: String,
    pub(super) clip: &'c Clip,
    /// With any capacity for pairs: it is raised as far as needed.
    pub(super) config: Config,
    pub(super) kernels: Kernels,
}

/// What has come of it.
#[derive(Default)]
pub(super) struct Measured {
    pub(super) name: String,
    /// Of a step, in milliseconds, the intake of all boxes included.
    pub(super) median: f64,
    pub(super) p95: f64,
    /// Of the steps after the first, in one pass.
    pub(super) stats: Vec<Stats>,
    /// Pairs of the fat mode whose boxes do not overlap, in the same steps.
    pub(super) surplus: u64,
    pub(super) world_bytes: usize,
    pub(super) verdict: Verdict,
}

impl Measured {
    /// The sum of a count over the steps of one pass.
    pub(super) fn sum(&self, of: impl Fn(&Stats) -> u64) -> f64 {
        self.stats.iter().map(of).sum::<u64>() as f64
    }

    /// Pairs an object and step.
    pub(super) fn pairs_per_object(&self) -> f64 {
        self.sum(|stats| stats.pairs) / self.sum(|stats| stats.objects.into())
    }
}

/// Passes that are measured at most: enough for any median.
const MOST_PASSES: u32 = 200;

/// Measures contenders in turns for about `budget` each.
pub(super) fn in_turns(contenders: &[Contender<'_>], budget: Duration) -> Result<Vec<Measured>> {
    Ok(in_turns_with(contenders, Vec::new(), budget)?.0)
}

/// The same with others than trisap in the turns, which come second in the result.
pub(super) fn in_turns_with<'c>(
    contenders: &[Contender<'c>],
    others: Vec<Started<'c>>,
    budget: Duration,
) -> Result<(Vec<Measured>, Vec<Measured>)> {
    let mut runners = Vec::new();
    for contender in contenders {
        runners.push(runner(contender, contender.config)?);
    }
    runners.extend(others);
    let start = Instant::now();
    for pass in 0..MOST_PASSES {
        // Nobody comes first always.
        for turn in 0..runners.len() {
            let at = (turn + pass as usize) % runners.len();
            if let (Some(roomier), Some(contender)) = (runners[at].0.pass()?, contenders.get(at)) {
                runners[at] = runner(contender, roomier)?;
            }
        }
        if start.elapsed() > budget * runners.len() as u32 {
            break;
        }
    }
    let mut measured = runners.into_iter().map(|(runner, mut measured)| {
        let milliseconds = runner.milliseconds();
        measured.median = median(milliseconds);
        measured.p95 = quantile(milliseconds, 0.95);
        measured
    });
    Ok((measured.by_ref().take(contenders.len()).collect(), measured.collect()))
}

/// What has been played through once and compared, and what has come of that.
pub(super) type Started<'c> = (Box<dyn Runner + 'c>, Measured);

/// Plays a clip forwards and backwards.
pub(super) trait Runner {
    /// Plays it to its other end. Where there was no room for all pairs, tells the configuration that has more: fat boxes
    /// on the way back are not those of the way there.
    fn pass(&mut self) -> Result<Option<Config>>;
    fn milliseconds(&self) -> &[f64];
}

struct Played<'c, I: Index> {
    clip: &'c Clip,
    config: Config,
    kernels: Kernels,
    owned: OwnedWorld<I>,
    at_end: bool,
    milliseconds: Vec<f64>,
}

/// A world with room for all pairs that has been played through once and compared.
fn runner<'c>(contender: &Contender<'c>, mut config: Config) -> Result<Started<'c>> {
    let narrow = fits_u16(contender.clip.objects());
    loop {
        let made =
            if narrow { checked::<u16>(contender, &config) } else { checked::<u32>(contender, &config) };
        match made {
            Err(error) => {
                config = roomier(&config, &error).ok_or(error).with_context(|| contender.name.clone())?;
            }
            made => return made,
        }
    }
}

/// The same world with room for as many pairs as there were, and some more.
pub(super) fn roomier(config: &Config, error: &anyhow::Error) -> Option<Config> {
    let Some(Error::PairsFull { needed, .. }) = error.downcast_ref() else { return None };
    let pairs = u32::try_from(needed + needed / 4).ok()?;
    Some(config.with_capacity(config.capacity.with_pairs(pairs)))
}

/// Plays the clip once and compares what can be compared.
fn checked<'c, I: Index>(contender: &Contender<'c>, config: &Config) -> Result<Started<'c>> {
    let Contender { clip, kernels, .. } = *contender;
    let mut owned = OwnedWorld::<I>::with_index(config)?;
    let mut world = owned.world();
    world.insert_many(Boxes::new(&clip.frames[0]))?;
    let mut measured = Measured { name: contender.name.clone(), ..Measured::default() };
    let mut last = Vec::new();
    for (frame, boxes) in clip.frames.iter().enumerate() {
        let step = world.set_kernels(kernels).step_over(Boxes::new(boxes))?;
        if let Some(expected) = clip.pairs(frame) {
            let reported = step.pairs().sorted();
            measured.verdict.add(compare(expected, &reported, config.mode, step.surplus()));
            // Of the first frame all pairs are found; where frames are left out, events cannot be told.
            let consecutive = frame == 0 || clip.pairs(frame - 1).is_some();
            if config.events && consecutive {
                let (lost, found) = differences(&last, &reported);
                let told = (step.lost().sorted(), step.found().sorted());
                measured.verdict.faults += u64::from(told != (lost, found));
            }
            last = reported;
        }
        if frame > 0 {
            measured.stats.push(step.stats());
            measured.surplus += step.surplus();
        }
    }
    measured.world_bytes = owned.bytes();
    let played = Played { clip, config: *config, kernels, owned, at_end: true, milliseconds: Vec::new() };
    Ok((Box::new(played), measured))
}

/// Compares the pairs of one step.
pub(super) fn compare(expected: &[Pair], reported: &[Pair], mode: Mode, told_surplus: u64) -> Verdict {
    let (missing, surplus) = differences(expected, reported);
    let twice = reported.windows(2).filter(|pair| pair[0] == pair[1]).count() as u64;
    let allowed = mode == Mode::Fat && surplus.len() as u64 == told_surplus;
    Verdict {
        frames: 1,
        pairs: expected.len() as u64,
        misses: missing.len() as u64,
        faults: twice + if allowed { 0 } else { surplus.len() as u64 },
    }
}

impl<I: Index> Runner for Played<'_, I> {
    fn pass(&mut self) -> Result<Option<Config>> {
        let mut world = self.owned.world();
        let count = self.clip.frames.len();
        for k in 1..count {
            let frame = if self.at_end { count - 1 - k } else { k };
            let boxes = Boxes::new(&self.clip.frames[frame]);
            let start = Instant::now();
            if let Err(error) = world.set_kernels(self.kernels).step_over(boxes) {
                let error = error.into();
                return roomier(&self.config, &error).ok_or(error).map(Some);
            }
            self.milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
        }
        self.at_end = !self.at_end;
        Ok(None)
    }

    fn milliseconds(&self) -> &[f64] {
        &self.milliseconds
    }
}

/// The median time of a copy that reads and writes so many bytes in all, in milliseconds: what the machine's memory allows
/// at best.
pub(super) fn copy_milliseconds(bytes: u64, budget: Duration) -> f64 {
    let from = vec![1_u8; (bytes / 2).max(1) as usize];
    let mut to = vec![0_u8; from.len()];
    let start = Instant::now();
    let mut milliseconds = Vec::new();
    // The first copy meets pages that are not there yet.
    while milliseconds.len() < 4 || (start.elapsed() < budget && milliseconds.len() < 1000) {
        let start = Instant::now();
        std::hint::black_box(&mut to).copy_from_slice(std::hint::black_box(&from));
        milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
    }
    median(&milliseconds[1..])
}

/// The slope of a straight line through the logarithms of all points: the power by which `y` grows with `x`.
pub(super) fn slope(points: &[(f64, f64)]) -> f64 {
    let logs = || points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let count = points.len() as f64;
    let (x, y) = logs().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
    let (over, under) = logs()
        .fold((0.0, 0.0), |(over, under), (a, b)| (over + (a - x) * (b - y), under + (a - x) * (a - x)));
    over / under
}

#[cfg(test)]
mod tests {
    use super::*;
    use trisap::Capacity;
    use trisap::scene::{Kind, Objects, Setup};
    use trisap::{Aabb, Margin};

    fn clip() -> Clip {
        let setup = Setup { kind: Kind::Gravity, objects: Objects::Cubes, count: 400, seed: 3 };
        Clip::synthetic(setup, 30, 5)
    }

    fn contender(clip: &Clip, config: Config) -> Contender<'_> {
        Contender { name: "it".into(), clip, config, kernels: Kernels::SCALAR }
    }

    #[test]
    fn all_contenders_are_measured_and_compared() -> Result<()> {
        let clip = clip();
        // Room for a single pair: it must be raised.
        let exact = Config::new(Capacity::for_objects(400).with_pairs(1));
        let fat = exact.with_events().with_mode(Mode::Fat).with_margin(Margin::length(0.2));
        let measured = in_turns(&[contender(&clip, exact), contender(&clip, fat)], Duration::ZERO)?;
        assert_eq!(measured.len(), 2);
        for of in &measured {
            assert!(of.verdict.is_good() && of.verdict.frames == 5 && of.verdict.pairs > 0);
            assert!(of.median > 0.0 && of.p95 >= of.median && of.stats.len() == 4);
        }
        assert_eq!(measured[0].surplus, 0);
        assert!(measured[1].surplus > 0);
        Ok(())
    }

    #[test]
    fn fat_boxes_of_the_way_back_get_room() -> Result<()> {
        // On the way there the second box stays inside the fat box of its start; on the way back it leaves another one, and
        // its new fat box meets the first.
        let place = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        let clip = Clip::new([1.5, 1.35, 1.6, 3.0].map(|x| vec![place(0.0), place(x)]).into());
        let config = Config::new(Capacity::for_objects(2).with_pairs(0));
        let fat = config.with_mode(Mode::Fat).with_margin(Margin::length(0.2)).with_fixed_margins();
        let contender = contender(&clip, fat);
        let (mut runner, measured) = runner(&contender, fat)?;
        assert_eq!(measured.sum(|stats| stats.pairs), 0.0);
        assert_eq!(runner.pass()?.map(|config| config.capacity.pairs), Some(1));
        assert!(in_turns(&[contender], Duration::from_millis(1))?[0].median > 0.0);
        Ok(())
    }

    #[test]
    fn what_is_wrong_is_seen() {
        let expected = [[0, 1], [0, 2]];
        let verdict = |reported: &[Pair], mode, told| {
            let Verdict { misses, faults, .. } = compare(&expected, reported, mode, told);
            (misses, faults)
        };
        assert_eq!(verdict(&[[0, 1], [0, 2]], Mode::Exact, 0), (0, 0));
        assert_eq!(verdict(&[[0, 2]], Mode::Exact, 0), (1, 0));
        assert_eq!(verdict(&[[0, 1], [0, 1], [0, 2]], Mode::Exact, 0), (0, 1));
        assert_eq!(verdict(&[[0, 1], [0, 2], [1, 2]], Mode::Exact, 1), (0, 1));
        assert_eq!(verdict(&[[0, 1], [0, 2], [1, 2]], Mode::Fat, 1), (0, 0));
        assert_eq!(verdict(&[[0, 1], [0, 2], [1, 2]], Mode::Fat, 0), (0, 1));
    }

    #[test]
    fn a_contender_that_cannot_be_is_an_error() {
        let clip = Clip::new(vec![vec![Aabb::new([1.0; 3], [0.0; 3])]; 2]);
        let config = Config::new(Capacity::for_objects(1));
        assert!(in_turns(&[contender(&clip, config)], Duration::ZERO).is_err());
    }

    #[test]
    fn slopes_are_powers() {
        let points = [1.0, 10.0, 1000.0].map(|x: f64| (x, 3.0 * x.powf(1.25)));
        assert!((slope(&points) - 1.25).abs() < 1e-9);
    }
}
