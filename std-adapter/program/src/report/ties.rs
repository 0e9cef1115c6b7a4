//! What quantisation costs: candidates that 16 bits cannot tell apart.

use super::result::{Axis, Figure, Section, Series, Table, percent};
use super::sizes::Size;
use trisap::Stats;
use trisap::scene::{Kind, Objects};

pub(super) fn ties(sizes: &[Size]) -> Section {
    let mut table = Table {
        id: "ties",
        title: "Candidates that needed the f32 test".into(),
        columns: vec!["scene", "boxes", "objects", "candidates a step", "needed f32 a step", "share (%)"],
        rows: Vec::new(),
    };
    let mut figures = Vec::new();
    for objects in Objects::ALL {
        let mut series = Vec::new();
        for (colour, kind) in Kind::ALL.into_iter().enumerate() {
            let mut points = Vec::new();
            for size in sizes.iter().filter(|size| size.kind == kind && size.objects == objects) {
                let steps = size.best().stats.len() as f64;
                let a_step = |of: fn(&Stats) -> u64| size.best().sum(of) / steps;
                let (candidates, tied) = (a_step(|stats| stats.candidates), a_step(|stats| stats.tied));
                if candidates > 0.0 {
                    points.push((f64::from(size.count), 100.0 * tied / candidates));
                }
                table.rows.push(vec![
                    kind.name().into(),
                    objects.name().into(),
                    size.count.into(),
                    (candidates as u64).into(),
                    (tied as u64).into(),
                    percent(tied, candidates),
                ]);
            }
            series.push(Series { name: kind.name().into(), points, reference: false, colour });
        }
        figures.push(Figure {
            note: "lower is better",
            title: format!("Candidates that needed the f32 test, {}", objects.name().to_lowercase()),
            x: Axis::logarithmic("objects (number)"),
            y: Axis::linear("share of the candidates (%)"),
            series,
        });
    }
    Section {
        id: "ties",
        title: "Quantisation",
        text: vec![
            "Leaves keep boxes in 16 bits a coordinate. Two boxes that share a step of that grid may or may not touch, and the \
             f32 boxes decide. The fewer candidates need that, the less the short records cost."
                .into(),
        ],
        figures,
        tables: vec![table],
        ..Section::default()
    }
}
