//! Where things hardly move: time against speed, beside the paper's own temporal inference.

use super::as_printed;
use super::clip::Clip;
use super::lab::{Lab, exact};
use super::measure::{Contender, Measured, in_turns_with};
use super::result::{Axis, Figure, Section, Series, Table, Value, milliseconds};
use anyhow::Result;
use trisap::scene::{Kind, Objects, Random};
use trisap::{Aabb, Config, Margin};

pub(super) fn speeds(lab: &Lab) -> Result<Section> {
    let mut section = Section {
        id: "speeds",
        title: "From still to fast",
        text: vec![format!(
            "{} cubes, each of which goes on in a direction of its own, {STEPS} steps there and back. By default trisap predicts a larger \
             box for each object, which holds it for some steps as it goes on, and leaves these boxes unused where they do not pay; a margin \
             of a tenth of an edge all around is left by the fast ones in each step. The paper's method has a margin of a hundredth. All \
             of them return the exact pairs.",
            lab.plan.objects
        )],
        ..Section::default()
    };
    let mut table = Table {
        id: "speeds",
        title: "Speed".into(),
        columns: vec!["edges a step", "world", "median (ms)", "objects searched for (%)", "misses"],
        rows: Vec::new(),
    };
    let scene = lab.scene(Kind::Brownian, Objects::Cubes, lab.plan.objects)?;
    let mut lines: [Vec<(f64, f64)>; WORLDS.len() + 1] = Default::default();
    lab.expect(lab.plan.speeds.len());
    for &speed in &lab.plan.speeds {
        lab.next(format!("{speed} edges a step"));
        let clip = clip(&scene.frames[0], speed);
        let (mut measured, others) =
            in_turns_with(&contenders(&clip), vec![as_printed::start(&clip)], lab.plan.budget)?;
        measured.extend(others);
        for (line, of) in lines.iter_mut().zip(&measured) {
            section.verdict.add(of.verdict);
            // Zero has no place among powers of ten; the table has it.
            if speed > 0.0 {
                line.push((f64::from(speed), of.median));
            }
            table.rows.push(vec![
                Value::Number(f64::from(speed), 3),
                of.name.as_str().into(),
                milliseconds(of.median),
                searched(of),
                of.verdict.misses.into(),
            ]);
        }
    }
    let names = WORLDS.iter().copied().chain(["the paper's method"]);
    section.figures.push(Figure {
        title: format!("{} cubes", lab.plan.objects),
        note: "lower is better",
        x: Axis::logarithmic("way of each cube in a step (edges)"),
        y: Axis::logarithmic("time per step (ms)"),
        series: (names.zip(lines).enumerate())
            .map(|(colour, (name, points))| Series { name: name.into(), points, reference: false, colour })
            .collect(),
    });
    section.tables.push(table);
    Ok(section)
}

const STEPS: usize = 24;

const WORLDS: [&str; 3] = ["trisap", "boxes as given", "a margin of 0.1"];

fn contenders(clip: &Clip) -> [Contender<'_>; WORLDS.len()] {
    let predicted = exact(clip);
    let given = predicted.without_predicted_boxes();
    let contender = |name: &str, config: Config| Contender {
        name: name.into(),
        clip,
        config,
        kernels: trisap::Kernels::detect(),
    };
    let configs = [predicted, given, given.with_margin(Margin::share(0.1))];
    std::array::from_fn(|at| contender(WORLDS[at], configs[at]))
}

/// Boxes that go on, each by so many edges of a cube a step.
fn clip(boxes: &[Aabb], speed: f32) -> Clip {
    let mut random = Random::new(11, 0);
    let mut direction = || {
        let way = random.in_ball(1.0);
        let length = way.iter().map(|along| along * along).sum::<f32>().sqrt().max(1e-3);
        way.map(|along| speed * along / length)
    };
    let ways: Vec<[f32; 3]> = boxes.iter().map(|_| direction()).collect();
    let at = |step: usize| {
        let moved = |(aabb, way): (&Aabb, &[f32; 3])| {
            let by = |side: [f32; 3]| std::array::from_fn(|k| side[k] + step as f32 * way[k]);
            Aabb::new(by(aabb.min), by(aabb.max))
        };
        boxes.iter().zip(&ways).map(moved).collect()
    };
    Clip::new((0..=STEPS).map(at).collect())
}

/// The share of objects whose pairs were searched for.
fn searched(of: &Measured) -> Value {
    if of.stats.is_empty() {
        return Value::Missing;
    }
    super::result::percent(of.sum(|stats| stats.moved.into()), of.sum(|stats| stats.objects.into()))
}
