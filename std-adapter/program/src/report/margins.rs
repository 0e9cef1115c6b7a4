//! Speed against error: what a margin buys in time and costs in pairs that do not overlap.

use super::clip::Clip;
use super::lab::{Lab, exact};
use super::measure::{Contender, Measured};
use super::result::{Axis, Figure, Section, Series, Table, Value, milliseconds, percent};
use crate::source::SHIPPED;
use anyhow::Result;
use trisap::recording::Recording;
use trisap::scene::{Kind, Objects};
use trisap::{Margin, Mode};

pub(super) fn margins(lab: &Lab) -> Result<Section> {
    let mut section = Section {
        id: "margins",
        title: "Speed against error",
        text: vec![
            "Fat mode returns a superset of the overlaps, in which the boxes are grown by a margin, and a box counts as moved \
             only when it leaves its margin. Each dot is a margin, from 0.01 to 0.5 edges; at 0 stands the exact mode. The \
             surplus are the pairs whose boxes do not overlap, as a share of all pairs returned."
                .into(),
            lab.origin().into(),
            "The last scene is the recording that is built into the program: cubes that fall onto each other.".into(),
        ],
        ..Section::default()
    };
    let mut table = Table {
        id: "margins",
        title: "Cubes".into(),
        columns: vec![
            "scene",
            "objects",
            "margin (edges)",
            "median (ms)",
            "moved (%)",
            "pairs a step",
            "surplus (%)",
            "misses",
        ],
        rows: Vec::new(),
    };
    lab.expect(Kind::ALL.len() + 1);
    let scenes = Kind::ALL.into_iter().map(Some).chain([None]).enumerate();
    for (colour, kind) in scenes {
        let name = kind.map_or("recorded FreeFall", Kind::name);
        lab.next(format!("margins, {name}"));
        let clip = match kind {
            Some(kind) => lab.scene(kind, Objects::Cubes, lab.plan.objects)?,
            // Of a physics engine, also in programs that have none.
            None => Clip::recorded(&Recording::parse(SHIPPED)?),
        };
        let contender = |margin: &f32| {
            let mut config = exact(&clip);
            if *margin > 0.0 {
                config = config.with_mode(Mode::Fat).with_margin(Margin::share(*margin));
            }
            Contender { name: margin.to_string(), clip: &clip, config, kernels: trisap::detect() }
        };
        let measured = lab.measure(&lab.plan.margins.iter().map(contender).collect::<Vec<_>>())?;
        for (of, margin) in measured.iter().zip(&lab.plan.margins) {
            section.verdict.add(of.verdict);
            let pairs = of.sum(|stats| stats.pairs);
            table.rows.push(vec![
                name.into(),
                clip.objects().into(),
                Value::Number(f64::from(*margin), 2),
                milliseconds(of.median),
                percent(of.sum(|stats| stats.moved.into()), of.sum(|stats| stats.objects.into())),
                Value::Number(pairs / of.stats.len() as f64, 0),
                percent(of.surplus as f64, pairs),
                of.verdict.misses.into(),
            ]);
        }
        let point = |of: &Measured| (100.0 * of.surplus as f64 / of.sum(|stats| stats.pairs), of.median);
        let points: Vec<_> = measured.iter().map(point).collect();
        let furthest = points.iter().map(|(surplus, _)| *surplus).fold(0.0, f64::max);
        let reference = vec![(0.0, points[0].1), (furthest, points[0].1)];
        section.figures.push(Figure {
            title: format!("{name}, {} cubes", clip.objects()),
            x: Axis::linear("surplus: pairs that do not overlap (%)"),
            y: Axis::linear("time per step (ms)"),
            series: vec![
                Series { name: "margins up to 0.5 edges".into(), points, reference: false, colour },
                Series { name: "exact mode".into(), points: reference, reference: true, colour },
            ],
        });
    }
    section.tables.push(table);
    Ok(section)
}
