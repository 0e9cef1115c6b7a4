//! Where temporal inference pays: time against the share of objects that move.

use super::clip::Clip;
use super::lab::{Lab, exact};
use super::measure::{Contender, Measured};
use super::result::{Axis, Figure, Section, Series, Table, Value, milliseconds};
use anyhow::Result;
use std::collections::BTreeMap;
use trisap::Config;
use trisap::scene::{Kind, Objects, Random};

pub(super) fn movers(lab: &Lab) -> Result<Section> {
    let mut section = Section {
        id: "movers",
        title: "Where few objects move",
        text: vec![format!(
            "{} cubes. In every step a share of them, others each time, goes to where they are in the scene by then; the \
                 rest stays. Automatic: the step chooses by the number of movers. In the other worlds the \
                 choice is fixed: all pairs found anew in every step; or the movers alone tested, however many they are, in leaves \
                 that become smaller or not.",
            lab.plan.objects
        )],
        ..Section::default()
    };
    let mut table = Table {
        id: "movers",
        title: "Share of movers".into(),
        columns: vec!["scene", "movers (%)", "world", "median (ms)", "paths", "automatic / best", "misses"],
        rows: Vec::new(),
    };
    let mut worst: (f64, String) = (0.0, String::new());
    lab.expect(Kind::ALL.len() * lab.plan.movers.len());
    for kind in Kind::ALL {
        let scene = lab.scene(kind, Objects::Cubes, lab.plan.objects)?;
        let mut lines: [Vec<(f64, f64)>; WORLDS.len()] = Default::default();
        for &share in &lab.plan.movers {
            let percent = (1e5 * share).round() / 1e3;
            lab.next(format!("{}, {percent:.1} % movers", kind.name()));
            let clip = clip(&scene, share);
            let measured = lab.measure(&contenders(&clip))?;
            let best = measured.iter().skip(1).map(|of| of.median).fold(f64::MAX, f64::min);
            for (at, of) in measured.iter().enumerate() {
                section.verdict.add(of.verdict);
                // Zero has no place among powers of ten; the table has it.
                if share > 0.0 {
                    lines[at].push((percent, of.median));
                }
                let above = of.median / best;
                if at == 0 && above > worst.0 {
                    worst = (above, format!("{}, {percent:.1} % movers", kind.name()));
                }
                table.rows.push(vec![
                    kind.name().into(),
                    Value::Number(percent, 1),
                    of.name.as_str().into(),
                    milliseconds(of.median),
                    Value::Text(paths(of)),
                    if at == 0 { Value::Number(above, 2) } else { Value::Missing },
                    of.verdict.misses.into(),
                ]);
            }
        }
        let series = WORLDS.iter().zip(lines).enumerate();
        section.figures.push(Figure {
            title: format!("{}, {} cubes", kind.name(), lab.plan.objects),
            note: "lower is better",
            x: Axis::logarithmic("objects that move (%)"),
            y: Axis::logarithmic("time per step (ms)"),
            series: series
                .map(|(colour, (name, points))| Series {
                    name: (*name).into(),
                    points,
                    reference: false,
                    colour,
                })
                .collect(),
        });
    }
    section.text.push(format!(
        "The automatic choice took {:.2} times as long as the best fixed one at most ({}).",
        worst.0, worst.1
    ));
    section.tables.push(table);
    Ok(section)
}

/// The automatic choice, and every choice that a caller can fix.
const WORLDS: [&str; 4] = ["automatic", "full", "movers only", "movers only, large leaves"];

fn contenders(clip: &Clip) -> Vec<Contender<'_>> {
    let plain = exact(clip);
    // What steps choose by counts, as the core's `config.rs` numbers it.
    let (movers_only, fine_leaves) = (0, 1);
    let movers = plain.with_forced(movers_only, Some(true));
    let configs: [Config; WORLDS.len()] = [
        plain,
        plain.with_forced(movers_only, Some(false)),
        movers.with_forced(fine_leaves, Some(true)),
        movers.with_forced(fine_leaves, Some(false)),
    ];
    let contender = |(name, config): (&&str, Config)| Contender {
        name: (*name).into(),
        clip,
        config,
        kernels: trisap::Kernels::detect(),
    };
    WORLDS.iter().zip(configs).map(contender).collect()
}

/// A scene in which a share of the boxes follows in each frame.
fn clip(scene: &Clip, share: f64) -> Clip {
    let mut boxes = scene.frames[0].clone();
    let mut random = Random::new(7, 0);
    let mut frames = vec![boxes.clone()];
    let movers = (share * boxes.len() as f64).round() as usize;
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    for frame in &scene.frames[1..] {
        // The first ones of a shuffled deck follow.
        for k in 0..movers {
            let left = (order.len() - k) as u32;
            order.swap(k, k + random.below(left) as usize);
            boxes[order[k]] = frame[order[k]];
        }
        frames.push(boxes.clone());
    }
    Clip::new(frames)
}

/// How often which path was taken.
fn paths(of: &Measured) -> String {
    let mut counts: BTreeMap<String, u32> = BTreeMap::new();
    for stats in &of.stats {
        *counts.entry(format!("{:?}", stats.path).to_lowercase()).or_default() += 1;
    }
    counts.iter().map(|(path, count)| format!("{path} {count}")).collect::<Vec<_>>().join(", ")
}
