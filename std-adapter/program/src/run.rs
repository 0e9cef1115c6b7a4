//! `trisap run`: steps through a scene and reports.

use crate::Outcome;
use crate::args::{ModeName, RunArgs};
use crate::check::Checker;
use crate::drive::drive;
use crate::dump::Dump;
use crate::figures::median;
use crate::setup::{Engine, fits_u16};
use crate::source::Source;
use crate::stopwatch::StageTimes;
use crate::summary::{Bytes, Check, Counts, Settings, Summary, Times, after_first};
use crate::tally::Tally;
use crate::workers;
use anyhow::{Context, Result};
use std::io::stdout;
use std::time::Duration;
use trisap::{Capacity, Config, Margin, Mode, Stage, Stats, layout};

/// The margin of the fat mode where none is given, as a share of the largest extent.
const FAT_MARGIN: f32 = 0.1;

pub(crate) fn run(args: &RunArgs) -> Result<Outcome> {
    let engine = Engine::new(&args.engine)?;
    let mut source = Source::of(&args.scene, args.frames)?;
    if args.workers_model {
        let config = config(args, source.objects());
        workers::print(&mut source, config, &args.engine, args.jobs)?;
        return Ok(Outcome::Good);
    }
    let dump = args.dump_svg.as_deref().map(|values| Dump::new(values, source.frames())).transpose()?;
    let config = config(args, source.objects());
    let (mode, events) = (config.mode, config.events);
    let new_checker: Option<Box<dyn Fn() -> Checker>> =
        if args.check { Some(Box::new(move || Checker::new(mode, events))) } else { None };
    let mut tally = Tally::new(source.frames(), new_checker);
    let config = drive(&mut source, config, &engine, &mut tally)?;
    let summary = summary(&source, &config, &engine, &tally)?;
    drop(tally);
    if let Some(dump) = dump {
        dump.draw(&mut source, &config, &engine)?;
    }

    if args.json { summary.write_json(stdout().lock()) } else { summary.write_text(stdout().lock()) }?;
    let failed = summary.check.is_some_and(|check| !check.passed);
    Ok(if failed { Outcome::CheckFailed } else { Outcome::Good })
}

fn config(args: &RunArgs, objects: u32) -> Config {
    let mut config = Config::new(Capacity::for_objects(objects)).with_workers(args.engine.threads);
    let mut margin = args.margin;
    if args.mode == ModeName::Fat {
        config = config.with_mode(Mode::Fat);
        margin = margin.or(Some(FAT_MARGIN));
    }
    if let Some(share) = margin {
        config = config.with_margin(Margin::share(share));
    }
    if args.events {
        config = config.with_events();
    }
    config
}

fn summary(source: &Source, config: &Config, engine: &Engine, tally: &Tally) -> Result<Summary> {
    let objects = source.objects();
    let later = after_first(&tally.stats);
    let medians = |of: fn(&Stats) -> u64| median(&later.iter().map(of).collect::<Vec<_>>());
    let step_ms = Times::of(&tally.milliseconds);
    // In the first frame all objects are new and all pairs are found.
    let counts = |of: fn(&Stats) -> u64| config.events.then(|| Counts::of(later.iter().map(of)));
    Ok(Summary {
        scene: source.name().to_owned(),
        objects,
        frames: tally.stats.len(),
        ns_per_object: step_ms.median() * 1e6 / f64::from(objects),
        step_ms,
        stages_ms: Stage::ALL
            .iter()
            .filter(|stage| **stage != Stage::Done)
            .map(|stage| {
                let times = after_first(&tally.stages)
                    .iter()
                    .map(|times| times[*stage as usize].all.as_secs_f64() * 1e3);
                (format!("{stage:?}").to_lowercase(), median(&times.collect::<Vec<_>>()))
            })
            .collect(),
        unshared_ms: (engine.threads > 1).then(|| {
            let unshared =
                |times: &StageTimes| times.iter().map(|time| time.all - time.shared).sum::<Duration>();
            median(
                &after_first(&tally.stages)
                    .iter()
                    .map(|times| unshared(times).as_secs_f64() * 1e3)
                    .collect::<Vec<_>>(),
            )
        }),
        pairs: Counts::of(tally.stats.iter().map(|stats| stats.pairs)),
        found: counts(|stats| stats.found),
        lost: counts(|stats| stats.lost),
        moved_share: medians(|stats| stats.moved.into()) as f64 / f64::from(objects),
        paths: tally.paths.clone(),
        leaves: medians(|stats| stats.leaves.into()) as u32,
        copies: medians(|stats| stats.copies),
        candidates: medians(|stats| stats.candidates),
        surplus: median(after_first(&tally.surplus)),
        large: medians(|stats| stats.large.into()) as u32,
        bytes: bytes(config)?,
        rejected: tally.rejected,
        coarse_frames: tally.coarse,
        check: tally.checker.as_ref().map(|checker| Check {
            method: Checker::method(objects),
            passed: tally.wrong.is_none(),
            pairs: checker.compared,
            wrong: tally.wrong.clone(),
        }),
        settings: Settings {
            mode: match config.mode {
                Mode::Exact => "exact",
                Mode::Fat => "fat",
            },
            margin: config.margin.map(|margin| margin.per_extent),
            events: config.events,
            threads: engine.threads,
            kernels: engine.kernels.name(),
            index_bits: if fits_u16(objects) { 16 } else { 32 },
            pair_capacity: config.capacity.pairs,
        },
    })
}

fn bytes(config: &Config) -> Result<Bytes> {
    let objects = config.capacity.objects;
    let world = |config: &Config| {
        let layout = if fits_u16(objects) { layout::<u16>(config) } else { layout::<u32>(config) };
        layout.map(|layout| layout.bytes).context("no such world")
    };
    let mut without_pairs = *config;
    without_pairs.capacity.pairs = 0;
    let all = world(config)?;
    Ok(Bytes {
        world: all,
        per_object: all as f64 / f64::from(objects),
        per_object_without_pairs: world(&without_pairs)? as f64 / f64::from(objects),
    })
}
