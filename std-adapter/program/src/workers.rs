//! `trisap run --workers-model`: what a step would take with many workers, and what it takes with two threads.

use crate::args::EngineArgs;
use crate::drive::{Frame, Visitor, drive};
use crate::figures::median;
use crate::setup::{Engine, WAKE};
use crate::source::Source;
use anyhow::Result;
use std::io::{Write, stdout};
use trisap::model::{Course, Job};
use trisap::{Config, Stage};

/// Steps before those that are measured: they make planes and lists.
const FIRST: usize = 6;
/// Turns of two threads and what they are compared with.
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
    Ok(steps(source, config, &Engine::modelled(args, workers)?)?.courses)
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
        "A model: workers take turns on one thread, and begin {} us after the caller. Milliseconds, medians.",
        WAKE / 1000
    )?;
    writeln!(out, "workers  intake   build    fill   sweep results    step  serial  speed-up")?;
    let mut alone = 0.0;
    for workers in COUNTS {
        let courses = courses(source, &mut config, args, workers)?;
        let step = milliseconds(&courses, Course::length);
        alone = if workers == 1 { step } else { alone };
        write!(out, "{workers:7}")?;
        for stage in &stages {
            write!(out, " {:7.3}", milliseconds(&courses, |course| course.of(*stage)))?;
        }
        // What no worker can take over, of the step of one.
        let share = if workers == 1 { 1.0 } else { milliseconds(&courses, serial) / alone };
        writeln!(out, " {step:7.3} {:6.1}%  {:8.2}", 100.0 * share, alone / step)?;
        if jobs && workers > 1 {
            print_jobs(&mut out, &stages, &courses)?;
        }
    }
    let (mut real, mut modelled) = (Vec::new(), Vec::new());
    let mut begins = [Vec::new(), Vec::new()];
    for _ in 0..ROUNDS {
        let mut one_and_two = |[one, two]: &[Engine; 2]| -> Result<(f64, Vec<Course>)> {
            let alone = steps(source, &mut config, one)?;
            let both = steps(source, &mut config, two)?;
            Ok((median(&alone.times) / median(&both.times), [alone.courses, both.courses].concat()))
        };
        let threads = |threads| Engine::new(&EngineArgs { threads, kernels: args.kernels.clone() });
        let real_threads = [threads(1)?, threads(2)?];
        real.push(one_and_two(&real_threads)?.0);
        begins.iter_mut().zip(real_threads[1].begins.take()).for_each(|(all, these)| all.extend(these));
        let (_, courses) = one_and_two(&[Engine::modelled(args, 1)?, Engine::modelled(args, 2)?])?;
        let (one, two) = courses.split_at(courses.len() / 2);
        modelled.push(milliseconds(one, Course::length) / milliseconds(two, Course::length));
    }
    let (real, modelled) = (median(&real), median(&modelled));
    writeln!(
        out,
        "two workers, {ROUNDS} times in turn: threads {real:.2} times one, the model {modelled:.2}: {:+.0} %",
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
