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

/// What margins a world has.
#[derive(Clone, Copy, PartialEq)]
enum MarginKind {
    None,
    Adapting,
    Fixed,
}

impl MarginKind {
    const fn name(self) -> &'static str {
        match self {
            Self::None => "none (exact mode)",
            Self::Adapting => "adapts",
            Self::Fixed => "fixed",
        }
    }
}

pub(super) fn margins(lab: &Lab) -> Result<Section> {
    let mut section = Section {
        id: "margins",
        title: "Fat mode: what a margin costs and buys",
        text: vec![
            "Exact mode needs none of this: it is the dashed line, and the first dot. Fat mode returns a superset of the overlaps, in which the boxes are grown by a margin, and a box counts as moved \
             only when it leaves its margin. Each dot is a margin, from 0.01 to 0.5 edges; at 0 stands the exact mode. The \
             surplus are the pairs whose boxes do not overlap, as a share of all pairs returned. Margins adapt where nobody \
             has fixed them: an object that goes farther in a step than its margin has none until it is slower."
                .into(),
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
            "kind of margin",
            "median (ms)",
            "moved (%)",
            "outran their margin (%)",
            "pairs a step",
            "surplus (%)",
            "misses",
        ],
        rows: Vec::new(),
    };
    let mut faster = (0, 0);
    lab.expect(Kind::ALL.len() + 1);
    let scenes = Kind::ALL.into_iter().map(Some).chain([None]);
    for kind in scenes {
        let name = kind.map_or("recorded FreeFall", Kind::name);
        lab.next(format!("margins, {name}"));
        let clip = match kind {
            Some(kind) => lab.scene(kind, Objects::Cubes, lab.plan.objects)?,
            // Of a physics engine, also in programs that have none.
            None => Clip::recorded(&Recording::parse(SHIPPED)?),
        };
        let contender = |kind: MarginKind, margin: f32| {
            let fat = exact(&clip).with_mode(Mode::Fat).with_margin(Margin::share(margin));
            let config = match kind {
                MarginKind::None => exact(&clip),
                MarginKind::Adapting => fat,
                MarginKind::Fixed => fat.with_fixed_margins(),
            };
            Contender { name: margin.to_string(), clip: &clip, config, kernels: trisap::Kernels::detect() }
        };
        let margins = lab.plan.margins.iter().filter(|margin| **margin > 0.0);
        let each = |kind| margins.clone().map(move |margin| (kind, *margin));
        let kinds: Vec<_> = std::iter::once((MarginKind::None, 0.0))
            .chain(each(MarginKind::Adapting))
            .chain(each(MarginKind::Fixed))
            .collect();
        let contenders: Vec<_> = kinds.iter().map(|(kind, margin)| contender(*kind, *margin)).collect();
        let measured = lab.measure(&contenders)?;
        for (of, (kind, margin)) in measured.iter().zip(&kinds) {
            section.verdict.add(of.verdict);
            let pairs = of.sum(|stats| stats.pairs);
            let objects = of.sum(|stats| stats.objects.into());
            table.rows.push(vec![
                name.into(),
                clip.objects().into(),
                Value::Number(f64::from(*margin), 2),
                kind.name().into(),
                milliseconds(of.median),
                percent(of.sum(|stats| stats.moved.into()), objects),
                percent(of.sum(|stats| stats.outran.into()), objects),
                Value::Number(pairs / of.stats.len() as f64, 0),
                percent(of.surplus as f64, pairs),
                of.verdict.misses.into(),
            ]);
        }
        let point = |of: &Measured| (100.0 * of.surplus as f64 / of.sum(|stats| stats.pairs), of.median);
        let points: Vec<_> = measured.iter().map(point).collect();
        faster.0 += points[1..].iter().filter(|(_, time)| *time < points[0].1).count();
        faster.1 += points.len() - 1;
        let furthest = points.iter().map(|(surplus, _)| *surplus).fold(0.0, f64::max);
        let reference = vec![(0.0, points[0].1), (furthest, points[0].1)];
        // The exact mode is where both lines begin.
        let line = |wanted| {
            let of = kinds
                .iter()
                .zip(&points)
                .filter(move |((kind, _), _)| *kind == wanted || *kind == MarginKind::None);
            of.map(|(_, point)| *point).collect()
        };
        section.figures.push(Figure {
            title: format!("{name}, {} cubes", clip.objects()),
            note: "lower is better",
            x: Axis::linear("surplus: pairs that do not overlap (%)"),
            y: Axis::linear("time per step (ms)"),
            series: vec![
                Series {
                    name: "margins that adapt".into(),
                    points: line(MarginKind::Adapting),
                    reference: false,
                    colour: 0,
                },
                Series {
                    name: "fixed margins".into(),
                    points: line(MarginKind::Fixed),
                    reference: false,
                    colour: 1,
                },
                Series { name: "exact mode".into(), points: reference, reference: true, colour: 2 },
            ],
        });
    }
    let (faster, all) = faster;
    section.text.insert(
        0,
        format!(
            "Of {all} worlds with a margin, {faster} were faster than the exact mode here. A margin pays where most objects stay \
             within theirs from step to step; where all move far, as in these scenes, it costs pairs that nobody wants."
        ),
    );
    section.tables.push(table);
    Ok(section)
}
