//! What each optional part costs by itself: you pay for what you use.

use super::lab::{Lab, exact};
use super::measure::Contender;
use super::result::{Section, Table, Value, milliseconds};
use anyhow::Result;
use trisap::scene::{Kind, Objects};
use trisap::{Config, Margin, Mode};

/// The margin of the parts that have one, in edges.
const MARGIN: f32 = 0.05;

/// The parts, each with what it is compared with.
const PARTS: [(&str, usize); 6] = [
    ("exact pairs alone", 0),
    ("+ events", 0),
    ("+ filters (that let all pairs through)", 0),
    ("+ margins (fat mode)", 0),
    ("+ exact test (exact mode with margins)", 3),
    ("+ room for a second worker", 0),
];

fn configs(plain: Config) -> [Config; PARTS.len()] {
    let margin = plain.with_margin(Margin::share(MARGIN));
    let fat = margin.with_mode(Mode::Fat);
    [plain, plain.with_events(), plain.with_filters(), fat, margin, plain.with_workers(2)]
}

pub(super) fn parts(lab: &Lab) -> Result<Section> {
    let mut section = Section {
        id: "parts",
        title: "You pay for what you use",
        text: vec![format!(
            "Time and memory of worlds that have one optional part more than the one that they are compared with, measured in \
             turns. Margins are {MARGIN} edges. {} cubes.",
            lab.plan.objects
        )],
        ..Section::default()
    };
    let mut table = Table {
        id: "parts",
        title: "Measured differences".into(),
        columns: vec![
            "scene",
            "part",
            "compared with",
            "median (ms)",
            "difference (ms)",
            "difference (%)",
            "bytes an object",
            "misses",
        ],
        rows: Vec::new(),
    };
    lab.expect(Kind::ALL.len());
    for kind in Kind::ALL {
        lab.next(format!("parts, {}", kind.name()));
        let clip = lab.scene(kind, Objects::Cubes, lab.plan.objects)?;
        let contenders = configs(exact(&clip)).into_iter().zip(PARTS).map(|(config, (name, _))| Contender {
            name: name.into(),
            clip: &clip,
            config,
            kernels: trisap::Kernels::detect(),
        });
        let measured = lab.measure(&contenders.collect::<Vec<_>>())?;
        for (at, (of, (_, base))) in measured.iter().zip(PARTS).enumerate() {
            section.verdict.add(of.verdict);
            let base = &measured[base];
            let difference = of.median - base.median;
            let first = at == 0;
            table.rows.push(vec![
                kind.name().into(),
                of.name.as_str().into(),
                if first { Value::Missing } else { base.name.as_str().into() },
                milliseconds(of.median),
                if first { Value::Missing } else { milliseconds(difference) },
                if first { Value::Missing } else { Value::Number(100.0 * difference / base.median, 1) },
                Value::Number(of.world_bytes as f64 / f64::from(clip.objects()), 1),
                of.verdict.misses.into(),
            ]);
        }
    }
    section.tables.push(table);
    Ok(section)
}
