//! The paper's Fig. 6, Table 1 and Table 2: trisap, the paper's own method on the same boxes, and the printed figures.

use super::printed;
use super::result::{Axis, Figure, Section, Series, Table, Value, milliseconds};
use super::sizes::Size;
use trisap::scene::{Kind, Objects};

pub(super) fn paper(sizes: &[Size]) -> Section {
    let mut section = Section {
        id: "paper",
        title: "Beside the method that it came from",
        text: vec![
            "The paper's method, to the letter (tests/paper): three linked lists that insertion sort repairs, a KD-tree that is \
             split from them in each step, copies of straddling boxes, temporal inference, a sweep in each leaf; without \
             vector instructions, as the paper has none, and corrected only where the text loses or repeats pairs. It and \
             trisap were measured in turns, in this run, on the same boxes, with one thread each, trisap with its best \
             kernels; every step of both was compared with an independent method as far as the report compares."
                .into(),
            "The printed times are those of ANOTHER MACHINE, an Intel i7-8700 under Windows 10 that sweeps leaves in parallel, \
             and of the authors' own runs of the scenes. So they stand in the tables alone."
                .into(),
            "The collision ratio (Fig. 6) is the number of pairs divided by the number of objects. All methods that are exact \
             have the same. The paper shows it as a picture, without numbers that could stand here."
                .into(),
        ],
        ..Section::default()
    };
    for (objects, id, name) in
        [(Objects::Cubes, "table_1", "Table 1: cubes"), (Objects::Assorted, "table_2", "Table 2: assorted")]
    {
        let mut table = Table {
            id,
            title: format!("{name}; printed figures: another machine"),
            columns: vec![
                "scene",
                "objects",
                "trisap (ms)",
                "the paper's method (ms)",
                "the paper's method / trisap",
                "printed, another machine (ms)",
                "collision ratio (pairs an object)",
            ],
            rows: Vec::new(),
        };
        let mut series = Vec::new();
        for (colour, kind) in Kind::ALL.into_iter().enumerate() {
            let (mut ours, mut as_printed) = (Vec::new(), Vec::new());
            for size in sizes.iter().filter(|size| size.kind == kind && size.objects == objects) {
                let (time, of_method) = (size.best().median, size.as_printed.median);
                section.verdict.add(size.as_printed.verdict);
                let printed = printed::time(kind, objects, size.count);
                ours.push((f64::from(size.count), time));
                as_printed.push((f64::from(size.count), of_method));
                table.rows.push(vec![
                    kind.name().into(),
                    size.count.into(),
                    milliseconds(time),
                    milliseconds(of_method),
                    Value::Number(of_method / time, 2),
                    printed.map_or(Value::Missing, |time| Value::Number(time, 2)),
                    Value::Number(size.best().pairs_per_object(), 3),
                ]);
            }
            series.push(Series { name: kind.name().into(), points: ours, reference: false, colour });
            series.push(Series { name: String::new(), points: as_printed, reference: true, colour });
        }
        section.figures.push(Figure {
            title: name.into(),
            note: "lines: trisap; dashed: the paper's method. Lower is better",
            x: Axis::logarithmic("objects (number)"),
            y: Axis::logarithmic("time per step (ms)"),
            series,
        });
        section.tables.push(table);
    }
    for objects in Objects::ALL {
        section.figures.push(ratios(sizes, objects));
    }
    section
}

fn ratios(sizes: &[Size], objects: Objects) -> Figure {
    let series = Kind::ALL.into_iter().enumerate().map(|(colour, kind)| {
        let of = sizes.iter().filter(|size| size.kind == kind && size.objects == objects);
        let points = of.map(|size| (f64::from(size.count), size.best().pairs_per_object())).collect();
        Series { name: kind.name().into(), points, reference: false, colour }
    });
    Figure {
        title: format!("Fig. 6: collision ratio, {}", objects.name().to_lowercase()),
        note: "the same for every exact method",
        x: Axis::logarithmic("objects (number)"),
        y: Axis::linear("collision ratio (pairs an object)"),
        series: series.collect(),
    }
}
