//! What a second thread is worth, stage by stage, and what more of them would be.

use super::clip::Clip;
use super::lab::{Lab, exact};
use super::result::{Axis, Bars, Figure, Section, Series, Table, Value, Verdict, milliseconds};
use crate::args::EngineArgs;
use crate::figures::median;
use crate::setup::fits_u16;
use crate::source::Source;
use crate::stopwatch::{StageTime, Stopwatch};
use crate::workers;
use anyhow::{Context, Result};
use std::time::{Duration, Instant};
use trisap::model::Course;
use trisap::scene::{Kind, Objects};
use trisap::{Boxes, Config, Executor, Index, OwnedWorld, Rayon, Serial, Stage};

/// Steps that are measured at most.
const MOST_STEPS: usize = 300;

/// Shares every job with nobody: tells how much of a step could be shared.
struct Unaided;

impl Executor for Unaided {
    fn workers(&self) -> u32 {
        2
    }

    fn fork_join(&self, _width: u32, job: &(dyn Fn() + Sync)) {
        job();
    }
}

/// Medians of a stage, or of a whole step, in milliseconds.
struct Medians {
    name: String,
    one: f64,
    two: f64,
    /// The share of one thread's time that more threads cannot take over.
    serial: f64,
}

impl Medians {
    fn speed_up(&self) -> f64 {
        self.one / self.two
    }
}

pub(super) fn threads(lab: &Lab) -> Result<Section> {
    let mut section = Section {
        id: "threads",
        title: "A second thread",
        text: vec![
            "A step on one thread and on two of rayon's, frame by frame in turn; Brownian cubes. The serial share is what \
             one thread spends outside the jobs that threads can share."
                .into(),
        ],
        ..Section::default()
    };
    let mut measured = Table {
        id: "threads",
        title: "Measured".into(),
        columns: vec![
            "boxes",
            "events",
            "stage",
            "one thread (ms)",
            "two threads (ms)",
            "speed-up",
            "serial share (%)",
        ],
        rows: Vec::new(),
    };
    let (mut bars, mut lines) = (Vec::new(), Vec::new());
    lab.expect(3 * lab.plan.shared_sizes.len());
    for (colour, &count) in lab.plan.shared_sizes.iter().enumerate() {
        let setup = lab.setup(Kind::Brownian, Objects::Cubes, count);
        let clip = Clip::synthetic(setup, 2, lab.plan.frames);
        for events in [false, true] {
            lab.next(format!("threads, {count} boxes"));
            let play = if fits_u16(count) { play::<u16> } else { play::<u32> };
            let config = if events { exact(&clip).with_events() } else { exact(&clip) };
            let (stages, verdict) = play(&clip, config, lab.plan.budget)?;
            section.verdict.add(verdict);
            let events = if events { "yes" } else { "no" };
            for stage in &stages {
                measured.rows.push(vec![
                    count.into(),
                    events.into(),
                    stage.name.as_str().into(),
                    milliseconds(stage.one),
                    milliseconds(stage.two),
                    Value::Number(stage.speed_up(), 2),
                    Value::Number(100.0 * stage.serial, 1),
                ]);
            }
            if let Some(step) = stages.last() {
                let with = if events == "yes" { ", with events" } else { "" };
                bars.push((format!("{count} boxes{with}"), step.speed_up()));
            }
        }
        lab.next(format!("modelled workers, {count} boxes"));
        let points = model(&clip)?;
        lines.push(Series { name: format!("{count} boxes"), points, reference: false, colour });
    }
    section.figures.push(Figure {
        title: "A model, not a measurement: speed-up of a step with events by more workers".into(),
        note: "workers take turns on one thread, with the caches of one and all memory to themselves; higher is better",
        x: Axis::linear("workers (number)"),
        y: Axis::linear("speed-up (times)"),
        series: lines,
    });
    section.bars.push(Bars {
        title: "Speed-up of a step by a second thread".into(),
        unit: "times",
        note: "higher is better; 1 is no gain",
        decimals: 2,
        bars,
    });
    section.tables.push(measured);
    Ok(section)
}

/// How many times as fast a step would be with so many workers.
fn model(clip: &Clip) -> Result<Vec<(f64, f64)>> {
    let mut source = Source::of_frames("modelled", clip.frames.clone());
    let (mut config, args) = (exact(clip).with_events(), EngineArgs::default());
    let mut points: Vec<(f64, f64)> = Vec::new();
    for count in workers::COUNTS {
        let courses = workers::courses(&mut source, &mut config, &args, count)?;
        points.push((f64::from(count), workers::milliseconds(&courses, Course::length)));
    }
    let alone = points[0].1;
    Ok(points.into_iter().map(|(count, step)| (count, alone / step)).collect())
}

/// Plays the clip forwards and backwards in three worlds, frame by frame in turn.
fn play<I: Index>(clip: &Clip, config: Config, budget: Duration) -> Result<(Vec<Medians>, Verdict)> {
    // On the way back other pairs may be found than on the way there.
    let capacity = config.capacity.with_pairs(2 * config.capacity.pairs);
    let shared = config.with_capacity(capacity).with_workers(2);
    // The calling thread is the second one.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
    let rayon = Rayon::in_pool(&pool);
    let executors: [&dyn Executor; 3] = [&Serial, &Unaided, &rayon];
    let mut owned = [
        OwnedWorld::<I>::with_index(&shared.with_workers(1))?,
        OwnedWorld::with_index(&shared)?,
        OwnedWorld::with_index(&shared)?,
    ];
    for owned in &mut owned {
        owned.world().insert_many(Boxes::new(&clip.frames[0]))?;
    }
    let kernels = trisap::Kernels::detect();
    let mut verdict = Verdict::default();
    let mut times: [Vec<[StageTime; Stage::ALL.len()]>; 3] = Default::default();
    let begun = Instant::now();
    let last = clip.frames.len() - 1;
    for step in 0..MOST_STEPS {
        let at = step % (2 * last).max(1);
        let boxes = &clip.frames[at.min(2 * last - at)];
        let mut pairs = Vec::new();
        for (turn, ((owned, executor), times)) in owned.iter_mut().zip(executors).zip(&mut times).enumerate()
        {
            let stopwatch = Stopwatch::new(executor);
            let mut world = owned.world();
            let found = world.set_kernels(kernels).on(&stopwatch).step_over(Boxes::new(boxes))?;
            if step <= last {
                // The whole order, since that is what has to be the same.
                verdict.faults += u64::from(turn > 0 && found.pairs() != pairs);
                pairs = found.pairs().to_vec();
                continue;
            }
            times.push(stopwatch.times());
        }
        if step > 3 * last && begun.elapsed() > 3 * budget {
            break;
        }
    }
    Ok((medians(&times), verdict))
}

fn medians(times: &[Vec<[StageTime; Stage::ALL.len()]>; 3]) -> Vec<Medians> {
    let of = |turn: usize, time: &dyn Fn(&[StageTime]) -> Duration| {
        median(&times[turn].iter().map(|stages| time(stages).as_secs_f64() * 1e3).collect::<Vec<_>>())
    };
    let medians = |name: String, which: std::ops::Range<usize>| {
        let all = |stages: &[StageTime]| stages[which.clone()].iter().map(|stage| stage.all).sum();
        let serial =
            |stages: &[StageTime]| stages[which.clone()].iter().map(|stage| stage.all - stage.shared).sum();
        Medians { name, one: of(0, &all), two: of(2, &all), serial: of(1, &serial) / of(1, &all) }
    };
    let stages = Stage::ALL.iter().take(Stage::Done as usize);
    let mut rows: Vec<_> = stages
        .map(|stage| medians(format!("{stage:?}").to_lowercase(), *stage as usize..*stage as usize + 1))
        .collect();
    rows.push(medians("step".into(), 0..Stage::ALL.len()));
    rows.retain(|row| row.one > 0.0);
    rows
}
