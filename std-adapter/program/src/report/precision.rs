//! Boxes far from the origin, given in `f64`: what rounding them to `f32` does.

use super::lab::Lab;
use super::measure::compare;
use super::result::{Axis, Figure, Section, Series, Table, Value, Verdict, percent};
use anyhow::{Result, ensure};
use trisap::scene::Random;
use trisap::{Aabb, Boxes, Capacity, Config, Mode, OwnedWorld, Pair};

/// A box in `f64`.
struct Wide {
    centre: [f64; 3],
    half: f64,
}

impl Wide {
    fn min(&self) -> [f64; 3] {
        self.centre.map(|x| x - self.half)
    }

    fn max(&self) -> [f64; 3] {
        self.centre.map(|x| x + self.half)
    }

    fn overlaps(&self, other: &Self) -> bool {
        let holds = |k: usize| self.min()[k] <= other.max()[k] && other.min()[k] <= self.max()[k];
        (0..3).all(holds)
    }

    /// Whether a box in `f32` that is seen from an origin has all of this one in it.
    fn is_within(&self, narrow: &Aabb, origin: f64) -> bool {
        (0..3).all(|k| {
            f64::from(narrow.min[k]) <= self.min()[k] - origin
                && f64::from(narrow.max[k]) >= self.max()[k] - origin
        })
    }
}

/// The ways from `f64` to `f32`.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// Centre and half extent are rounded, and the corners are computed in `f32`.
    NearestCentre,
    /// Each corner is rounded to the nearest `f32`.
    NearestCorners,
    /// `Aabb::from_f64`: minima down, maxima up.
    Outward,
    /// The world's origin is shifted to the boxes, and they are given again.
    Shifted,
}

impl Way {
    const ALL: [Self; 4] = [Self::NearestCentre, Self::NearestCorners, Self::Outward, Self::Shifted];

    fn name(self) -> &'static str {
        match self {
            Self::NearestCentre => "nearest: centre and half extent",
            Self::NearestCorners => "nearest: corners",
            Self::Outward => "outward (Aabb::from_f64)",
            Self::Shifted => "outward, after World::shift_origin",
        }
    }

    /// Whether trisap answers for the result; the others are there for comparison.
    fn is_ours(self) -> bool {
        matches!(self, Self::Outward | Self::Shifted)
    }

    fn round(self, wide: &Wide, origin: f64) -> Aabb {
        match self {
            Self::NearestCentre => {
                let (centre, half) = (wide.centre.map(|x| x as f32), wide.half as f32);
                Aabb::new(centre.map(|x| x - half), centre.map(|x| x + half))
            }
            Self::NearestCorners => Aabb::new(wide.min().map(|x| x as f32), wide.max().map(|x| x as f32)),
            Self::Outward | Self::Shifted => Aabb::from_f64(wide.min(), wide.max(), [origin; 3]),
        }
    }
}

pub(super) fn precision(lab: &Lab) -> Result<Section> {
    let mut section = Section {
        id: "precision",
        title: "Precision far from the origin",
        text: vec![
            format!(
                "{} unit cubes, given in f64 at a distance from the origin on all axes. Their pairs in f64, by brute force, are \
                 compared with those that a world finds after rounding to f32. Surplus pairs do not overlap in f64; misses \
                 overlap there and were not found. Nearest rounding keeps the order of the corners, but not what is inside: \
                 boxes that do not hold their own f64 box any more are counted, and where corners are computed in f32 after \
                 rounding, pairs are missed. Outward rounding must have neither: a miss in its two rows is an error of trisap.",
                lab.plan.distant_boxes
            ),
            "World::is_coarse warns where boxes are too small for f32 at their place.".into(),
        ],
        ..Section::default()
    };
    let mut table = Table {
        id: "precision",
        title: "All distances".into(),
        columns: vec![
            "distance (edges)",
            "rounding",
            "pairs in f64",
            "pairs found",
            "surplus (%)",
            "misses",
            "boxes that lost part of themselves",
            "too coarse",
        ],
        rows: Vec::new(),
    };
    let mut series: Vec<Series> = (Way::ALL.into_iter().enumerate())
        .map(|(colour, way)| Series {
            name: way.name().into(),
            points: Vec::new(),
            // One of them hides the others where they are alike.
            reference: !way.is_ours(),
            colour,
        })
        .collect();
    lab.expect(lab.plan.distances.len());
    for &distance in &lab.plan.distances {
        lab.next(format!("precision at {distance}"));
        let boxes = boxes(lab.plan.distant_boxes, distance);
        let expected = brute_force(&boxes);
        for (way, series) in Way::ALL.into_iter().zip(&mut series) {
            let found = find(&boxes, distance, way)?;
            let verdict = compare(&expected, &found.pairs, Mode::Exact, 0);
            if way.is_ours() {
                // Surplus pairs are what outward rounding costs; near the origin and after the shift there is none.
                let faults = if way == Way::Shifted { verdict.faults } else { 0 } + found.cut;
                section.verdict.add(Verdict { faults, ..verdict });
            }
            let surplus = (found.pairs.len() as u64 + verdict.misses).saturating_sub(verdict.pairs) as f64;
            let share = percent(surplus, found.pairs.len() as f64);
            if let (true, Value::Number(percent, _)) = (distance > 0.0, &share) {
                series.points.push((distance, *percent));
            }
            table.rows.push(vec![
                Value::Number(distance, 0),
                way.name().into(),
                verdict.pairs.into(),
                (found.pairs.len() as u64).into(),
                share,
                verdict.misses.into(),
                found.cut.into(),
                if found.coarse { "yes" } else { "no" }.into(),
            ]);
        }
    }
    section.figures.push(Figure {
        title: "Surplus by rounding".into(),
        note: "lower is better; dashed: not trisap's rounding",
        x: Axis::logarithmic("distance from the origin (edges)"),
        y: Axis::linear("surplus pairs (%)"),
        series,
    });
    section.tables.push(table);
    Ok(section)
}

/// Unit cubes that fill a tenth of a cube with its centre at a distance from the origin. All coordinates have their last
/// bit at 2^-20, so that none of them is rounded in `f64` at any distance.
fn boxes(count: u32, distance: f64) -> Vec<Wide> {
    let side = (10.0 * f64::from(count)).cbrt();
    let mut random = Random::new(11, 0);
    let mut coordinate = || {
        let x = (f64::from(random.unit()) - 0.5) * side;
        distance + (x * f64::from(1 << 20)).round() / f64::from(1 << 20)
    };
    (0..count).map(|_| Wide { centre: [(); 3].map(|()| coordinate()), half: 0.5 }).collect()
}

fn brute_force(boxes: &[Wide]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (a, low) in boxes.iter().enumerate() {
        let above = boxes.iter().enumerate().skip(a + 1).filter(|(_, high)| low.overlaps(high));
        pairs.extend(above.map(|(b, _)| [a as u32, b as u32]));
    }
    pairs
}

/// What a world makes of rounded boxes.
struct Found {
    pairs: Vec<Pair>,
    /// Boxes that do not hold their `f64` box.
    cut: u64,
    coarse: bool,
}

fn find(boxes: &[Wide], distance: f64, way: Way) -> Result<Found> {
    let count = boxes.len() as u32;
    // Far out everything overlaps.
    let all = Capacity::for_objects(count).with_pairs(count * (count - 1) / 2);
    let mut owned = OwnedWorld::<u32>::new(&Config::new(all))?;
    let mut world = owned.world();
    let mut rounded: Vec<Aabb> = boxes.iter().map(|wide| way.round(wide, 0.0)).collect();
    world.insert_many(Boxes::new(&rounded))?;
    let mut origin = 0.0;
    if way == Way::Shifted {
        world.step()?;
        origin = distance;
        world.shift_origin([origin; 3])?;
        // The same boxes, as far as f32 still knows them: no pair has gone.
        world.step()?;
        ensure!(world.stats().pairs >= brute_force(boxes).len() as u64, "the shift has lost pairs");
        rounded = boxes.iter().map(|wide| way.round(wide, origin)).collect();
    }
    let step = world.step_over(Boxes::new(&rounded))?;
    let mut pairs = step.pairs().to_vec();
    pairs.sort_unstable();
    let cut = boxes.iter().zip(&rounded).filter(|(wide, narrow)| !wide.is_within(narrow, origin)).count();
    Ok(Found { pairs, cut: cut as u64, coarse: step.is_coarse() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_of_rounding_shows() -> Result<()> {
        let mut missed = 0;
        for distance in [0.0, 1e5, 1e6, 1e7, 1e8, 1e9] {
            let boxes = boxes(300, distance);
            let expected = brute_force(&boxes);
            let [centre, corners, outward, shifted] = Way::ALL.map(|way| find(&boxes, distance, way));
            let missing = |found: &Found| expected.iter().filter(|pair| !found.pairs.contains(pair)).count();
            missed += missing(&centre?);
            let (corners, outward, shifted) = (corners?, outward?, shifted?);
            assert_eq!([&corners, &outward, &shifted].map(missing), [0; 3]);
            assert_eq!((outward.cut, shifted.cut), (0, 0));
            assert_eq!(corners.cut > 0, distance > 0.0, "at {distance}");
            assert_eq!(shifted.pairs, expected);
            assert!(!shifted.coarse);
            if distance == 1e9 {
                assert!(outward.coarse && outward.pairs.len() > 10 * expected.len());
            }
        }
        assert!(missed > 0, "centres never missed a pair: the comparison shows nothing");
        Ok(())
    }
}
