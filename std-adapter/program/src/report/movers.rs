//! Where temporal inference pays: time against the share of objects that move.

use super::clip::Clip;
use super::lab::{Lab, exact};
use super::measure::{Contender, Measured};
use super::result::{Axis, Figure, Section, Series, Table, Value, milliseconds};
use anyhow::Result;
use std::collections::BTreeMap;
use trisap::Aabb;
use trisap::scene::{Kind, Objects, Random, Setup};

/// How far a mover goes in a frame, in edges.
const REACH: f32 = 0.25;

pub(super) fn movers(lab: &Lab) -> Result<Section> {
    let mut section = Section {
        id: "movers",
        title: "Where temporal inference pays",
        text: vec![
            format!(
                "{} unit cubes, of which a share moves by up to {REACH} edges in every step while the rest rests. Automatic: \
                 the step chooses its way by the number of movers. Full: the resting boxes are touched too (they change by one \
                 step of f32), so that all objects count as moved and all leaves are filled and swept.",
                lab.plan.objects
            ),
            "Without movers nothing is done but to look at all boxes.".into(),
        ],
        ..Section::default()
    };
    let mut table = Table {
        id: "movers",
        title: "Share of movers".into(),
        columns: vec!["movers (%)", "world", "median (ms)", "paths", "automatic / best", "misses"],
        rows: Vec::new(),
    };
    let mut lines: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
    lab.expect(lab.plan.movers.len());
    for &share in &lab.plan.movers {
        lab.next(format!("{} % movers", 100.0 * share));
        let clips = [Rest::Untouched, Rest::Touched].map(|rest| clip(lab, share, rest));
        let measured = lab.measure(&contenders(&clips))?;
        let best = measured.iter().map(|of| of.median).fold(f64::MAX, f64::min);
        for of in &measured {
            section.verdict.add(of.verdict);
            // Zero has no place among powers of ten; the table has it.
            if share > 0.0 {
                lines.entry(of.name.clone()).or_default().push((100.0 * share, of.median));
            }
            let automatic = of.name == AUTOMATIC;
            table.rows.push(vec![
                Value::Number(100.0 * share, 1),
                of.name.as_str().into(),
                milliseconds(of.median),
                Value::Text(paths(of)),
                if automatic { Value::Number(of.median / best, 2) } else { Value::Missing },
                of.verdict.misses.into(),
            ]);
        }
    }
    let series = lines.into_iter().enumerate();
    section.figures.push(Figure {
        title: format!("{} cubes", lab.plan.objects),
        x: Axis::logarithmic("objects that move (%)"),
        y: Axis::linear("time per step (ms)"),
        series: series
            .map(|(colour, (name, points))| Series { name, points, reference: false, colour })
            .collect(),
    });
    section.tables.push(table);
    Ok(section)
}

const AUTOMATIC: &str = "automatic";

/// All ways to step that are compared: the automatic choice and, beside it, every way that can be had by itself.
fn contenders(clips: &[Clip; 2]) -> Vec<Contender<'_>> {
    let [movers, touched] = clips;
    let contender = |name: &str, clip| Contender {
        name: name.into(),
        clip,
        config: exact(movers),
        kernels: trisap::detect(),
    };
    vec![contender(AUTOMATIC, movers), contender("full", touched)]
}

/// What happens to the boxes that do not move.
#[derive(Clone, Copy, PartialEq)]
enum Rest {
    Untouched,
    Touched,
}

fn clip(lab: &Lab, share: f64, rest: Rest) -> Clip {
    let count = lab.plan.objects;
    let setup = Setup { kind: Kind::Brownian, objects: Objects::Cubes, count, seed: 1 };
    let mut boxes: Vec<Aabb> =
        setup.bodies().map(|body| Aabb::new(body.position, body.position.map(|x| x + 1.0))).collect();
    let mut random = Random::new(7, 0);
    let mut frames = vec![boxes.clone()];
    let movers = (share * f64::from(count)).round() as usize;
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    for frame in 1..lab.plan.frames {
        // The first ones of a shuffled deck move.
        for k in 0..movers {
            let left = (order.len() - k) as u32;
            let other = k + random.below(left) as usize;
            order.swap(k, other);
            let by = [(); 3].map(|()| REACH * (2.0 * random.unit() - 1.0));
            shift(&mut boxes[order[k]], by);
        }
        if rest == Rest::Touched {
            for &at in &order[movers..] {
                let [low, _, _] = &mut boxes[at].min;
                *low = if frame % 2 == 0 { low.next_down() } else { low.next_up() };
            }
        }
        frames.push(boxes.clone());
    }
    Clip::new(frames)
}

fn shift(aabb: &mut Aabb, by: [f32; 3]) {
    for k in 0..3 {
        aabb.min[k] += by[k];
        aabb.max[k] = aabb.min[k] + 1.0;
    }
}

/// How often which path was taken.
fn paths(of: &Measured) -> String {
    let mut counts: BTreeMap<String, u32> = BTreeMap::new();
    for stats in &of.stats {
        *counts.entry(format!("{:?}", stats.path).to_lowercase()).or_default() += 1;
    }
    counts.iter().map(|(path, count)| format!("{path} {count}")).collect::<Vec<_>>().join(", ")
}
