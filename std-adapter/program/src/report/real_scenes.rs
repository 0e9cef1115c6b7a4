//! Scenes as games and simulations have them, each stepped through once. Beside the world that has lived through a scene there
//! is a fresh one on its last frames: the two differ where a world keeps what some frame has made of it.

use super::lab::Lab;
use super::measure::{compare, roomier};
use super::result::{Bars, Section, Table, Value, Verdict, milliseconds, percent};
use crate::check;
use crate::drive::Pairs;
use crate::figures::median;
use crate::setup::fits_u16;
use anyhow::Result;
use std::time::Instant;
use trisap::scene::real::{Kind, Scene, Setup};
use trisap::{Boxes, Capacity, Config, Index, Mode, OwnedWorld, Stats, World};

/// Frames of a scene, and those at its end that a fresh world is stepped through too: after all that is sudden.
const FRAMES: u32 = 32;
const LAST: u32 = 12;

/// The most boxes of a spawn, all of whose pairs overlap at first.
const MOST_SPAWNED: u32 = 8000;

pub(super) fn real_scenes(lab: &Lab) -> Result<Section> {
    lab.expect(Kind::ALL.len());
    let mut runs = Vec::new();
    for kind in Kind::ALL {
        lab.next(kind.to_string());
        runs.push(run(kind, lab.plan.objects)?);
    }
    let mut section = Section {
        id: "real_scenes",
        title: "Scenes of games and simulations",
        text: vec![format!(
            "Each scene is stepped through once, in {FRAMES} frames; the times are those of single steps on one thread, and \
             the first, which builds the tree, is left out. The table also has the times of a world that begins \
             {LAST} frames before the end. Where the old world takes longer, that comes from what it went through. \
             All boxes are given in every step."
        )],
        bars: vec![Bars {
            title: format!("Time of a step, {} boxes", lab.plan.objects),
            unit: "ms",
            note: "medians of one thread; lower is better",
            decimals: 3,
            bars: runs.iter().map(|run| (run.setup.kind.to_string(), run.old.median())).collect(),
        }],
        tables: vec![table(&runs), frames(&runs)],
        ..Section::default()
    };
    runs.iter().for_each(|run| section.verdict.add(run.verdict));
    Ok(section)
}

/// A scene that was stepped through.
struct Run {
    setup: Setup,
    old: Life,
    fresh: Life,
    verdict: Verdict,
}

/// What a world went through.
#[derive(Default)]
struct Life {
    /// The number of each frame but the first, and the time of its step in milliseconds.
    times: Vec<(f64, f64)>,
    /// Of the last step.
    stats: Stats,
    /// Objects of the fullest leaf, after the last step; nothing without a tree.
    fullest: Option<u32>,
}

impl Life {
    fn step<I: Index>(&mut self, world: &mut World<'_, I>, frame: u32, boxes: Boxes<'_>) -> Result<()> {
        let start = Instant::now();
        let step = world.step_over(boxes)?;
        let time = start.elapsed().as_secs_f64() * 1e3;
        self.stats = step.stats();
        self.times.push((f64::from(frame), time));
        Ok(())
    }

    /// The median time of all frames.
    fn median(&self) -> f64 {
        median(&self.times.iter().map(|(_, time)| *time).collect::<Vec<_>>())
    }

    /// The median time of the last frames.
    fn late(&self) -> f64 {
        let late = self.times.iter().filter(|(frame, _)| *frame > f64::from(FRAMES - LAST));
        median(&late.map(|(_, time)| *time).collect::<Vec<_>>())
    }
}

fn run(kind: Kind, objects: u32) -> Result<Run> {
    let count = if kind == Kind::Spawn { objects.min(MOST_SPAWNED) } else { objects };
    let setup = Setup { kind, count, seed: 1 };
    let mut config = Config::new(Capacity::for_objects(count));
    loop {
        let played = if fits_u16(count) { play::<u16>(setup, &config) } else { play::<u32>(setup, &config) };
        match played {
            Err(error) => config = roomier(&config, &error).ok_or(error)?,
            played => return played,
        }
    }
}

/// Steps through all frames and compares the pairs of the old world.
fn play<I: Index>(setup: Setup, config: &Config) -> Result<Run> {
    let mut scene = Scene::new(setup)?;
    let mut run = Run { setup, old: Life::default(), fresh: Life::default(), verdict: Verdict::default() };
    let (mut old_memory, mut fresh_memory) =
        (OwnedWorld::<I>::with_index(config)?, OwnedWorld::<I>::with_index(config)?);
    let (mut old, mut fresh) = (old_memory.world(), fresh_memory.world());
    for frame in 0..FRAMES {
        let boxes = Boxes::new(scene.boxes());
        // Neither world always comes first.
        for turn in 0..2 {
            let (life, world, first) = if turn == frame % 2 {
                (&mut run.old, &mut old, 0)
            } else {
                (&mut run.fresh, &mut fresh, FRAMES - LAST)
            };
            if frame == first {
                world.insert_many(boxes)?;
                world.step()?;
            } else if frame > first {
                life.step(world, frame, boxes)?;
            }
        }
        let expected = check::pairs(scene.boxes());
        run.verdict.add(compare(&expected, &old.pairs().sorted(), Mode::Exact, 0));
        scene.advance();
    }
    for (life, world) in [(&mut run.old, &old), (&mut run.fresh, &fresh)] {
        life.fullest = world.leaves().map(|leaf| leaf.objects).max();
    }
    Ok(run)
}

/// All steps of all scenes.
fn frames(runs: &[Run]) -> Table {
    let mut rows = Vec::new();
    for Run { setup, old, fresh, .. } in runs {
        for (frame, time) in &old.times {
            let fresh = fresh.times.iter().find(|(number, _)| number == frame);
            rows.push(vec![
                Value::Text(setup.kind.to_string()),
                Value::Number(*frame, 0),
                milliseconds(*time),
                fresh.map_or(Value::Missing, |(_, time)| milliseconds(*time)),
            ]);
        }
    }
    let columns = vec!["scene", "frame", "step (ms)", "step of the fresh world (ms)"];
    Table { id: "real_frames", title: "All steps".into(), columns, rows }
}

fn table(runs: &[Run]) -> Table {
    let mut table = Table {
        id: "real_scenes",
        title: "All scenes; counts are those of the last step".into(),
        columns: vec![
            "scene",
            "objects",
            "median of all steps (ms)",
            "median of the last (ms)",
            "fresh world, median of the last (ms)",
            "longer than the fresh world (%)",
            "pairs an object",
            "candidates a pair",
            "leaves",
            "leaves of the fresh world",
            "copies",
            "large objects",
            "objects of the fullest leaf",
            "misses",
        ],
        rows: Vec::new(),
    };
    for Run { setup, old, fresh, verdict } in runs {
        let stats = &old.stats;
        let quotient = |number: u64, of: u64| match of {
            0 => Value::Missing,
            of => Value::Number(number as f64 / of as f64, 2),
        };
        table.rows.push(vec![
            setup.kind.name().into(),
            setup.count.into(),
            milliseconds(old.median()),
            milliseconds(old.late()),
            milliseconds(fresh.late()),
            percent(old.late() - fresh.late(), fresh.late()),
            quotient(stats.pairs, stats.objects.into()),
            quotient(stats.candidates, stats.pairs),
            stats.leaves.into(),
            fresh.stats.leaves.into(),
            stats.copies.into(),
            stats.large.into(),
            old.fullest.map_or(Value::Missing, Value::from),
            verdict.misses.into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_worlds_are_stepped_and_the_pairs_compared() -> Result<()> {
        for kind in [Kind::Spawn, Kind::Level] {
            let run = run(kind, 300)?;
            assert_eq!(
                (run.old.times.len(), run.fresh.times.len()),
                (FRAMES as usize - 1, LAST as usize - 1)
            );
            assert!(run.verdict.is_good() && run.verdict.frames == u64::from(FRAMES), "{:?}", run.verdict);
            assert_eq!(run.old.stats.pairs, run.fresh.stats.pairs);
            assert!(run.old.stats.pairs > 0 && run.old.late() > 0.0 && run.fresh.late() > 0.0);
        }
        Ok(())
    }
}
