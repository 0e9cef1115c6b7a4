//! The results, as a Markdown table and as JSON.

use crate::{options::Options, peers::Entry};
use std::{
    fmt::{self, Write},
    time::Duration,
};

pub(crate) struct Scene {
    pub(crate) name: String,
    pub(crate) objects: usize,
    pub(crate) movers: usize,
    pub(crate) frames: usize,
    /// Mean over the frames.
    pub(crate) pairs: u64,
}

/// The times of both sides of a race.
pub(crate) struct Race {
    pub(crate) ours: Vec<Duration>,
    pub(crate) peer: Vec<Duration>,
    /// Whether trisap told found and lost pairs.
    pub(crate) events: bool,
    /// Pairs that the peer told and that do not overlap, as a share of those that do.
    pub(crate) surplus: f64,
}

pub(crate) enum Outcome {
    Raced(Race),
    LeftOut(String),
    Wrong(String),
}

impl Race {
    fn ratio(&self) -> f64 {
        median(&self.peer) / median(&self.ours)
    }
}

/// In milliseconds.
fn median(times: &[Duration]) -> f64 {
    let mut times = times.to_vec();
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64() * 1e3
}

fn worst(times: &[Duration]) -> f64 {
    times.iter().max().map_or(0.0, Duration::as_secs_f64) * 1e3
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Raced(race) => {
                write!(f, "{:.1}x ({:.3} / {:.3} ms)", race.ratio(), median(&race.peer), median(&race.ours))
            }
            Self::LeftOut(reason) => write!(f, "left out: {reason}"),
            Self::Wrong(what) => write!(f, "WRONG: {what}"),
        }
    }
}

/// What one peer did on each scene.
struct Row {
    name: &'static str,
    setup: &'static str,
    fat: bool,
    outcomes: Vec<Outcome>,
}

pub(crate) struct Report {
    kernels: &'static str,
    threads: u32,
    clock: &'static str,
    pub(crate) scenes: Vec<Scene>,
    rows: Vec<Row>,
}

impl Report {
    pub(crate) fn new(kernels: &'static str, options: &Options) -> Self {
        Self {
            kernels,
            threads: options.threads,
            clock: options.clock.name(),
            scenes: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// What a peer did on the last scene.
    pub(crate) fn add(&mut self, entry: &Entry, outcome: Outcome) {
        match self.rows.iter_mut().find(|row| row.name == entry.name) {
            Some(row) => row.outcomes.push(outcome),
            None => {
                let outcomes = vec![outcome];
                self.rows.push(Row { name: entry.name, setup: entry.setup, fat: entry.fat, outcomes });
            }
        }
    }

    /// Whether nobody told a wrong pair set.
    pub(crate) fn all_right(&self) -> bool {
        self.rows.iter().flat_map(|row| &row.outcomes).all(|outcome| !matches!(outcome, Outcome::Wrong(_)))
    }

    pub(crate) fn markdown(&self) -> String {
        let mut text = format!(
            "Peer's median over trisap's (peer / trisap in ms a frame); trisap kernels: {}, threads: {}, {}.\n\n\
             | peer |",
            self.kernels, self.threads, self.clock
        );
        for scene in &self.scenes {
            _ = write!(text, " {} {}", scene.name, scene.objects);
            if scene.movers < scene.objects {
                _ = write!(text, ", {} move", scene.movers);
            }
            _ = write!(text, ", {} pairs |", scene.pairs);
        }
        text += "\n|---|";
        text += &"---|".repeat(self.scenes.len());
        for row in &self.rows {
            _ = write!(text, "\n| {} |", row.name);
            for outcome in &row.outcomes {
                _ = write!(text, " {outcome} |");
            }
        }
        text += "\n\nSet-ups:\n";
        for row in &self.rows {
            _ = write!(text, "\n- {}: {}", row.name, row.setup);
            let raced = row.outcomes.iter().filter_map(|outcome| match outcome {
                Outcome::Raced(race) => Some(race),
                _ => None,
            });
            let surplus: Vec<String> = raced.map(|race| format!("{:.0} %", 100.0 * race.surplus)).collect();
            if row.fat && !surplus.is_empty() {
                _ = write!(text, "; tells a superset, by {} of the overlaps", surplus.join(", "));
            }
        }
        text + "\n"
    }

    /// The ratios alone, with a line for each scene, of the peers that took part in any.
    pub(crate) fn table(&self) -> String {
        let raced = |row: &&Row| row.outcomes.iter().any(|outcome| !matches!(outcome, Outcome::LeftOut(_)));
        let rows: Vec<&Row> = self.rows.iter().filter(raced).collect();
        let mut text = format!(
            "Peer's median over trisap's; trisap kernels: {}, threads: {}, {}. ⊇: a superset of the pairs, \
             beside one of trisap.\n\n\
             | scene | objects | pairs | trisap, ms | trisap ⊇, ms |",
            self.kernels, self.threads, self.clock
        );
        rows.iter().for_each(|row| _ = write!(text, " {}{} |", row.name, if row.fat { " ⊇" } else { "" }));
        text += "\n|---|---:|---:|---:|---:|";
        text += &"---:|".repeat(rows.len());
        for (at, scene) in self.scenes.iter().enumerate() {
            _ = write!(text, "\n| {} | {} | {} |", scene.name, scene.objects, scene.pairs);
            let outcomes = || rows.iter().filter_map(|row| row.outcomes.get(at));
            for fat in [false, true] {
                // Of all races in which trisap told pairs, as most peers do.
                let mut ours = Vec::new();
                for row in rows.iter().filter(|row| row.fat == fat) {
                    if let Some(Outcome::Raced(race)) = row.outcomes.get(at)
                        && !race.events
                    {
                        ours.extend_from_slice(&race.ours);
                    }
                }
                _ = if ours.is_empty() {
                    write!(text, " |")
                } else {
                    write!(text, " {:.3} |", median(&ours))
                };
            }
            for outcome in outcomes() {
                _ = match outcome {
                    Outcome::Raced(race) if race.ratio() < 0.95 => write!(text, " {:.2} |", race.ratio()),
                    Outcome::Raced(race) => write!(text, " {:.1} |", race.ratio()),
                    Outcome::LeftOut(_) => write!(text, " |"),
                    Outcome::Wrong(_) => write!(text, " wrong |"),
                };
            }
        }
        text + "\n"
    }

    pub(crate) fn json(&self) -> String {
        let mut text = format!(
            "{{\"kernels\":{:?},\"threads\":{},\"clock\":{:?},\"races\":[",
            self.kernels, self.threads, self.clock
        );
        let mut separator = "";
        for row in &self.rows {
            for (scene, outcome) in self.scenes.iter().zip(&row.outcomes) {
                _ = write!(
                    text,
                    "{separator}\n{{\"peer\":{:?},\"scene\":{:?},\"objects\":{},\"movers\":{},\"frames\":{},\"pairs\":{},",
                    row.name, scene.name, scene.objects, scene.movers, scene.frames, scene.pairs
                );
                separator = ",";
                _ = match outcome {
                    Outcome::Raced(race) => write!(
                        text,
                        "\"ratio\":{},\"peer_ms\":{},\"trisap_ms\":{},\"peer_worst_ms\":{},\"trisap_worst_ms\":{},\
                         \"trisap_events\":{},\"surplus\":{}}}",
                        race.ratio(),
                        median(&race.peer),
                        median(&race.ours),
                        worst(&race.peer),
                        worst(&race.ours),
                        race.events,
                        race.surplus
                    ),
                    Outcome::LeftOut(reason) => write!(text, "\"left_out\":{reason:?}}}"),
                    Outcome::Wrong(what) => write!(text, "\"wrong\":{what:?}}}"),
                };
            }
        }
        text + "\n]}\n"
    }
}
