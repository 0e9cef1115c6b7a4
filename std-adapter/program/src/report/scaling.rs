//! Time per step against the number of objects.

use super::measure::slope;
use super::result::{Axis, Bars, Figure, Section, Series, Table, Value, milliseconds};
use super::sizes::{Size, middle, verdict};
use trisap::Kernels;
use trisap::scene::{Kind, Objects};

pub(super) fn scaling(sizes: &[Size]) -> Section {
    let mut section = Section {
        id: "scaling",
        title: "How the time grows with the number of objects",
        text: vec![
            "Every box is given in every step, and every step returns the exact set of pairs, on one thread and with the best \
             kernels. Dashed, for the Brownian scene: the time in which this machine's memory can be read and written as \
             much as a step has to at least (24 bytes a box and 8 bytes a pair), measured at each size."
                .into(),
        ],
        verdict: verdict(sizes),
        ..Section::default()
    };
    let mut slopes = Table {
        id: "slopes",
        title: "The power by which the time grows with the number of objects".into(),
        columns: vec!["scene", "boxes", "kernels", "power"],
        rows: Vec::new(),
    };
    for objects in Objects::ALL {
        let mut series = Vec::new();
        for (colour, kind) in Kind::ALL.into_iter().enumerate() {
            let of: Vec<&Size> =
                sizes.iter().filter(|size| size.kind == kind && size.objects == objects).collect();
            let points = |time: &dyn Fn(&Size) -> f64| -> Vec<(f64, f64)> {
                of.iter().map(|size| (f64::from(size.count), time(size))).collect()
            };
            for (at, kernels) in Kernels::all().enumerate() {
                slopes.rows.push(vec![
                    kind.name().into(),
                    objects.name().into(),
                    kernels.name().into(),
                    Value::Number(slope(&points(&|size| size.measured[at].median)), 3),
                ]);
            }
            let best = points(&|size| size.best().median);
            series.push(Series { name: kind.name().into(), points: best, reference: false, colour });
            if colour == 0 {
                let points = points(&|size| size.limit);
                series.push(Series {
                    name: "reading and writing alone".into(),
                    points,
                    reference: true,
                    colour: 3,
                });
            }
        }
        section.figures.push(Figure {
            title: format!("Time of a step, {}", objects.name().to_lowercase()),
            note: "lower is better",
            x: Axis::logarithmic("objects (number)"),
            y: Axis::logarithmic("time per step (ms)"),
            series,
        });
    }
    if let Some(size) = middle(sizes) {
        section.bars.push(Bars {
            title: format!("What vectors gain: {} Brownian cubes, by instruction set", size.count),
            unit: "ms",
            note: "lower is better",
            decimals: 3,
            bars: size.measured.iter().map(|measured| (measured.name.clone(), measured.median)).collect(),
        });
    }
    section.tables = vec![slopes, times(sizes)];
    section
}

fn times(sizes: &[Size]) -> Table {
    let mut table = Table {
        id: "sizes",
        title: "All measurements".into(),
        columns: vec![
            "scene",
            "boxes",
            "objects",
            "kernels",
            "median (ms)",
            "95 % within (ms)",
            "memory limit (ms)",
            "pairs a step",
            "candidates a step",
            "bytes an object",
            "misses",
        ],
        rows: Vec::new(),
    };
    for size in sizes {
        for measured in &size.measured {
            let a_step = |sum: f64| Value::Number(sum / measured.stats.len() as f64, 0);
            table.rows.push(vec![
                size.kind.name().into(),
                size.objects.name().into(),
                size.count.into(),
                measured.name.as_str().into(),
                milliseconds(measured.median),
                milliseconds(measured.p95),
                milliseconds(size.limit),
                a_step(measured.sum(|stats| stats.pairs)),
                a_step(measured.sum(|stats| stats.candidates)),
                Value::Number(measured.world_bytes as f64 / f64::from(size.count), 1),
                measured.verdict.misses.into(),
            ]);
        }
    }
    table
}
