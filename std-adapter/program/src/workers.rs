//! `trisap run --workers-model`: what a step would take with many workers, and what it takes with two threads.

use crate::args::EngineArgs;
use crate::drive::{Frame, Visitor, drive};
use crate::figures::median;
use crate::setup::{Engine, WAKE};
use crate::source::Source;
use anyhow::{Error, Result};
use std::array;
use std::io::{Write, stdout};
use trisap::model::{Course, Job, blocks, nanoseconds};
use trisap::{Config, Stage};

/// Steps before those that are measured: they make planes and lists.
const FIRST: usize = 6;
/// Runs of a modelled step, of which the median counts: an interruption takes as long as a stage of many workers.
const RUNS: usize = 5;
/// Turns of one thread and two.
const ROUNDS: usize = 3;
/// Numbers of workers.
pub(crate) const COUNTS: [u32; 7] = [1, 2, 4, 8, 12, 16, 32];

/// The milliseconds of all steps, or what they cost in the model.
struct Steps<'e> {
    engine: &'e Engine,
    times: Vec<f64>,
    courses: Vec<Course>,
}

impl Visitor for Steps<'_> {
    fn start(&mut self) {
        self.times.clear();
        self.courses.clear();
    }

    fn visit(&mut self, frame: &Frame<'_>) -> Result<bool> {
        self.times.push(frame.time.as_secs_f64() * 1e3);
        self.courses.extend(self.engine.model.as_ref().map(trisap::model::Workers::course));
        Ok(true)
    }
}

fn steps<'e>(source: &mut Source, config: &mut Config, engine: &'e Engine) -> Result<Steps<'e>> {
    let mut steps = Steps { engine, times: Vec::new(), courses: Vec::new() };
    source.rewind()?;
    *config = drive(source, config.with_workers(engine.threads), engine, &mut steps)?;
    let first = FIRST.min(steps.times.len() / 2);
    steps.times.drain(..first);
    steps.courses.drain(..first.min(steps.courses.len()));
    Ok(steps)
}

/// What later steps cost with so many modelled workers.
pub(crate) fn courses(
    source: &mut Source,
    config: &mut Config,
    args: &EngineArgs,
    workers: u32,
) -> Result<Vec<Course>> {
    let engine = Engine::modelled(args, workers, (WAKE, nanoseconds))?;
    let runs: Vec<_> =
        (0..RUNS).map(|_| Ok(steps(source, config, &engine)?.courses)).collect::<Result<_>>()?;
    Ok((0..runs[0].len())
        .map(|step| middle(&runs.iter().map(|run| &run[step]).collect::<Vec<_>>()))
        .collect())
}

/// What a step cost, each part of it in the median of some runs. All runs do the same.
fn middle(runs: &[&Course]) -> Course {
    let of = |read: &dyn Fn(&Course) -> u64| {
        median(&runs.iter().map(|run| read(run) as f64).collect::<Vec<_>>()) as u64
    };
    let jobs = runs[0].jobs.iter().enumerate();
    let job = |(at, first): (usize, &Job)| {
        let (work, span) = (of(&|run| run.jobs[at].work), of(&|run| run.jobs[at].span));
        Job { work, span, ..*first }
    };
    Course { serial: array::from_fn(|stage| of(&|run| run.serial[stage])), jobs: jobs.map(job).collect() }
}

/// All blocks over those of the worker that has most, job by job: how many times as fast jobs would be if all blocks took as
/// long. It repeats.
fn by_blocks(source: &mut Source, config: &mut Config, args: &EngineArgs, workers: u32) -> Result<f64> {
    let courses = steps(source, config, &Engine::modelled(args, workers, (0, blocks))?)?.courses;
    let jobs = || courses.iter().flat_map(|course| &course.jobs);
    let of = |read: fn(&Job) -> u64| jobs().map(read).sum::<u64>() as f64;
    Ok(of(|job| job.work) / of(|job| job.span))
}

/// The median milliseconds of something that steps cost.
pub(crate) fn milliseconds(courses: &[Course], of: impl Fn(&Course) -> u64) -> f64 {
    median(&courses.iter().map(|course| of(course) as f64 / 1e6).collect::<Vec<_>>())
}

/// The time outside all jobs.
pub(crate) fn serial(course: &Course) -> u64 {
    course.serial.iter().sum()
}

pub(crate) fn print(source: &mut Source, mut config: Config, args: &EngineArgs, jobs: bool) -> Result<()> {
    let mut out = stdout().lock();
    let stages: Vec<Stage> = Stage::ALL.into_iter().filter(|stage| *stage != Stage::Done).collect();
    writeln!(out, "{}, {} objects", source.name(), source.objects())?;
    writeln!(
        out,
        "A model: workers take turns on one thread, and begin {} us after the caller. Milliseconds, medians of steps, each the \
         median of {RUNS} runs.",
        WAKE / 1000
    )?;
    writeln!(out, "workers  intake   build    fill   sweep results    step  serial  speed-up  by blocks")?;
    let (mut alone, mut by_two) = (0.0, 0.0);
    for workers in COUNTS {
        let courses = courses(source, &mut config, args, workers)?;
        let step = milliseconds(&courses, Course::length);
        match workers {
            1 => alone = step,
            2 => by_two = step,
            _ => {}
        }
        write!(out, "{workers:7}")?;
        for stage in &stages {
            write!(out, " {:7.3}", milliseconds(&courses, |course| course.of(*stage)))?;
        }
        // What no worker can take over, of the step of one.
        let share = if workers == 1 { 1.0 } else { milliseconds(&courses, serial) / alone };
        let by_blocks = if workers == 1 { 1.0 } else { by_blocks(source, &mut config, args, workers)? };
        writeln!(out, " {step:7.3} {:6.1}%  {:8.2}  {by_blocks:9.2}", 100.0 * share, alone / step)?;
        if jobs && workers > 1 {
            print_jobs(&mut out, &stages, &courses)?;
        }
    }
    let mut real = Vec::new();
    let mut begins = [Vec::new(), Vec::new()];
    for _ in 0..ROUNDS {
        let threads = |threads| Engine::new(&EngineArgs { threads, kernels: args.kernels.clone() });
        let [one, two] = [threads(1)?, threads(2)?];
        let mut time = |engine| Ok::<_, Error>(median(&steps(source, &mut config, engine)?.times));
        real.push(time(&one)? / time(&two)?);
        begins.iter_mut().zip(two.begins.take()).for_each(|(all, these)| all.extend(these));
    }
    let (real, modelled) = (median(&real), alone / by_two);
    writeln!(
        out,
        "two threads, {ROUNDS} times in turn with one: {real:.2} times as fast; two workers of the model: {modelled:.2}, {:+.0} %",
        100.0 * (modelled / real - 1.0)
    )?;
    for (begins, which) in begins.iter_mut().zip(["first job of a step", "later jobs"]) {
        begins.sort_unstable_by(f64::total_cmp);
        let at = |part: usize| begins.get(begins.len() * part / 4).map_or(0.0, |begin| begin / 1e3);
        let (low, middle, high) = (at(1), at(2), at(3));
        writeln!(
            out,
            "the second thread began the {which} {low:.1}, {middle:.1}, {high:.1} us late (quartiles of {})",
            begins.len()
        )?;
    }
    Ok(())
}

/// The jobs of a step and the serial parts.
fn print_jobs(out: &mut impl Write, stages: &[Stage], courses: &[Course]) -> Result<()> {
    let Some(last) = courses.last() else { return Ok(()) };
    for &stage in stages {
        let serial = 1e3 * milliseconds(courses, |course| course.serial[stage as usize]);
        writeln!(out, "        {stage:?}: serial {serial:.1}")?;
        for (at, Job { width, claims, .. }) in last.jobs_of(stage).enumerate() {
            let of = |read: fn(&Job) -> u64| {
                1e3 * milliseconds(courses, |course| course.jobs_of(stage).nth(at).map_or(0, read))
            };
            let (work, span) = (of(|job| job.work), of(|job| job.span));
            writeln!(
                out,
                "            {width} workers, {claims} claims, work {work:.1}, span {span:.1}, {:.2} times",
                work / span
            )?;
        }
    }
    Ok(())
}
