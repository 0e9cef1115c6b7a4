//! The suite of hard inputs: what goes in, what comes out, how long it takes. The pairs and events of every step, on
//! every kernel, are compared with brute force.

mod boxes;
mod lives;

use super::lab::Lab;
use super::result::{Section, Table, Value, Verdict};
use crate::args::EngineArgs;
use crate::check::Checker;
use crate::drive::{Frame, Visitor, drive};
use crate::figures::{counted, median};
use crate::setup::Engine;
use crate::source::Source;
use anyhow::Result;
use trisap::{Aabb, Capacity, Config, Kernels};

/// Boxes that move, and a world to step through them.
struct Case {
    input: &'static str,
    /// What trisap does with it.
    answer: &'static str,
    /// The capacity does not matter.
    config: Config,
    frames: Vec<Vec<Aabb>>,
}

pub(super) fn hard_cases(lab: &Lab) -> Result<Section> {
    let mut section = Section {
        id: "hard_cases",
        title: "Hard cases",
        text: vec![
            "Pairs, found and lost pairs and refused boxes of every step are compared with brute force, on every kernel; the \
             time is that of the best kernels."
                .into(),
        ],
        ..Section::default()
    };
    let mut table = Table {
        id: "hard_cases",
        title: "All inputs".into(),
        columns: vec![
            "input",
            "what trisap does",
            "objects",
            "pairs compared",
            "result",
            "median time of a step (µs)",
        ],
        rows: Vec::new(),
    };
    let cases = boxes::cases();
    lab.expect(cases.len() + lives::LIVES.len());
    for case in cases {
        lab.next(case.input.to_owned());
        let objects = case.frames[0].len() as u64;
        let (input, answer) = (case.input, case.answer);
        let played = play(case)?;
        section.verdict.add(played.verdict);
        table.rows.push(vec![
            input.into(),
            answer.into(),
            objects.into(),
            played.verdict.pairs.into(),
            Value::Text(played.result),
            Value::Number(played.microseconds, 1),
        ]);
    }
    for life in lives::LIVES {
        lab.next(life.input.to_owned());
        let wrong = Kernels::all().find_map(|kernels| (life.live)(kernels).err());
        section.verdict.add(Verdict { faults: u64::from(wrong.is_some()), ..Verdict::default() });
        table.rows.push(vec![
            life.input.into(),
            life.answer.into(),
            Value::Missing,
            Value::Missing,
            wrong.map_or("as expected".into(), |wrong| Value::Text(format!("WRONG: {wrong:#}"))),
            Value::Missing,
        ]);
    }
    section.tables.push(table);
    Ok(section)
}

struct Played {
    verdict: Verdict,
    result: String,
    microseconds: f64,
}

/// Plays a case on all kernels; what is told is that of the last ones, which are the best, or of the first that are wrong.
fn play(case: Case) -> Result<Played> {
    let objects = case.frames[0].len() as u32;
    let config = case.config.with_capacity(Capacity::for_objects(objects)).with_events();
    let mut source = Source::of_frames(case.input, case.frames);
    let mut verdict = Verdict::default();
    let mut watch = Watch::new(&config);
    for kernels in Kernels::all() {
        let engine = Engine::new(&EngineArgs { threads: 1, kernels: kernels.name().into() })?;
        source.rewind()?;
        watch = Watch::new(&config);
        drive(&mut source, config, &engine, &mut watch)?;
        verdict.frames += watch.microseconds.len() as u64;
        verdict.pairs += watch.checker.compared;
        if watch.wrong.is_some() {
            verdict.faults += 1;
            break;
        }
    }
    let refused = match watch.refused {
        0 => String::new(),
        refused => format!("; refused {}", counted(refused, "time")),
    };
    let result = match watch.wrong {
        Some(wrong) => format!("WRONG: {wrong}"),
        None => format!("as brute force{refused}"),
    };
    Ok(Played { verdict, result, microseconds: median(&watch.microseconds) })
}

/// Compares frame by frame.
struct Watch {
    config: Config,
    checker: Checker,
    wrong: Option<String>,
    refused: u64,
    microseconds: Vec<f64>,
}

impl Watch {
    fn new(config: &Config) -> Self {
        let checker = Checker::new(config.mode, config.events);
        Self { config: *config, checker, wrong: None, refused: 0, microseconds: Vec::new() }
    }
}

impl Visitor for Watch {
    fn start(&mut self) {
        *self = Self::new(&self.config);
    }

    fn visit(&mut self, frame: &Frame<'_>) -> Result<bool> {
        self.microseconds.push(frame.time.as_secs_f64() * 1e6);
        self.refused += frame.rejected.map_or(0, |rejected| rejected.count.into());
        self.wrong =
            self.checker.compare(frame).err().map(|wrong| format!("frame {}: {wrong}", frame.number));
        Ok(self.wrong.is_none())
    }
}
