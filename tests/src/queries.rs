//! What queries must answer, by definition: every box is asked, in `f64`, without a tree. And the comparison of a world's
//! answers with that.

use crate::doing::On as _;
use crate::model::Model;
use crate::scenes::Rng;
use crate::worlds::Setup;
use std::cell::Cell;
use std::ops::ControlFlow::{Break, Continue};
use trisap_core::{Aabb, Cast, Error, Hit, Id, Index, Planes, Region, Side, Volume, World};

/// A slot and a distance.
pub type Near = (u32, f64);

fn live(boxes: &[Option<Aabb>]) -> impl Iterator<Item = (u32, Aabb)> + '_ {
    boxes.iter().zip(0..).filter_map(|(aabb, slot)| aabb.map(|aabb| (slot, aabb)))
}

/// The square of the distance from a point to the nearest point of a box.
fn squared(point: [f32; 3], aabb: &Aabb) -> f64 {
    let gap = |k: usize| {
        let x = f64::from(point[k]);
        x - x.clamp(f64::from(aabb.min[k]), f64::from(aabb.max[k]))
    };
    gap(0).powi(2) + gap(1).powi(2) + gap(2).powi(2)
}

/// The least `f32` that is not below a number.
fn above(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// The slots of the boxes that share a point with a region, ascending.
#[must_use]
pub fn overlapping(boxes: &[Option<Aabb>], region: &Region) -> Vec<u32> {
    let meets = |aabb: &Aabb| match *region {
        Region::Aabb(other) => (0..3).all(|k| aabb.min[k] <= other.max[k] && aabb.max[k] >= other.min[k]),
        Region::Point(point) => (0..3).all(|k| aabb.min[k] <= point[k] && aabb.max[k] >= point[k]),
        // The box of the ball decides about gaps so small that the distance rounds to the radius.
        Region::Sphere { center, radius } => {
            let beyond = |k: usize| {
                let (center, radius) = (f64::from(center[k]), f64::from(radius));
                aabb.min[k] > above(center + radius) || aabb.max[k] < -above(radius - center)
            };
            squared(center, aabb) <= f64::from(radius).powi(2) && !(0..3).any(beyond)
        }
        region => panic!("{region:?} has no oracle"),
    };
    live(boxes).filter(|(_, aabb)| meets(aabb)).map(|(slot, _)| slot).collect()
}

/// The `count` boxes nearest to a point: by distance, equal ones by slot.
#[must_use]
pub fn nearest(boxes: &[Option<Aabb>], point: [f32; 3], count: usize) -> Vec<Near> {
    let mut all: Vec<Near> = live(boxes).map(|(slot, aabb)| (slot, squared(point, &aabb))).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    all.truncate(count);
    all.into_iter().map(|(slot, squared)| (slot, squared.sqrt())).collect()
}

/// What a cast meets.
#[derive(Clone, Debug, Default)]
pub struct Met {
    /// The boxes that it meets, and where.
    pub sure: Vec<Near>,
    /// Boxes that it grazes so closely that rounding decides.
    pub grazed: Vec<Near>,
}

/// The boxes that a cast meets: it is inside the slabs of all three axes at once, touching included.
#[must_use]
pub fn met(boxes: &[Option<Aabb>], cast: &Cast) -> Met {
    // Dividing by a power of two rounds nothing.
    let exact = cast.direction.iter().all(|d| d.to_bits() << 9 == 0);
    let mut met = Met::default();
    for (slot, aabb) in live(boxes) {
        // However far it goes, a cast does not get to what is at infinity alone.
        let (mut enter, mut exit) = (0.0_f64, f64::from(cast.distance).min(f64::MAX));
        let mut missed = false;
        for k in 0..3 {
            let speed = f64::from(cast.direction[k]);
            let front = f64::from(aabb.min[k]) - f64::from(cast.start.max[k]);
            let back = f64::from(aabb.max[k]) - f64::from(cast.start.min[k]);
            if speed == 0.0 {
                missed |= front > 0.0 || back < 0.0;
            } else if speed > 0.0 {
                (enter, exit) = (enter.max(front / speed), exit.min(back / speed));
            } else {
                (enter, exit) = (enter.max(back / speed), exit.min(front / speed));
            }
        }
        let close = !exact && (enter - exit).abs() <= 1e-12 * enter.abs().max(exit.abs());
        if missed {
        } else if close {
            met.grazed.push((slot, enter));
        } else if enter <= exit {
            met.sure.push((slot, enter));
        }
    }
    met
}

fn slots(ids: &[Option<Id>]) -> Vec<u32> {
    ids.iter().map(|id| id.expect("an id for each object").slot()).collect()
}

/// Asks a world about a region in every way.
///
/// # Panics
/// If an answer is wrong.
pub fn ask_region<I: Index>(world: &mut World<'_, I>, model: &Model, region: &Region, setup: Setup) {
    let world = &*world.with(setup);
    let expected = overlapping(model.boxes(), region);
    let mut out = vec![None; expected.len()];
    let count = world.overlaps(region, &mut out);
    assert_eq!(count, Ok(expected.len()), "{setup:?} {region:?}");
    assert_eq!(slots(&out), expected, "{setup:?} {region:?}");
    assert!(out.iter().flatten().all(|id| model.contains(*id)));
    if let Some((_, less)) = out.split_first_mut() {
        let full = Error::OutputFull { needed: expected.len() as u64, room: less.len() };
        assert_eq!(world.overlaps(region, less), Err(full), "{region:?}");
    }
    let visit = |most: usize| {
        let mut visited = Vec::new();
        let mut each = |id: Id| {
            visited.push(id.slot());
            if visited.len() < most { Continue(()) } else { Break(()) }
        };
        world.visit_overlaps(region, &mut each).expect("a good region");
        visited
    };
    let all = visit(usize::MAX);
    let mut ascending = all.clone();
    ascending.sort_unstable();
    assert_eq!(ascending, expected, "each object is visited once: {region:?}");
    for most in [1, all.len() / 2, all.len()].into_iter().filter(|most| *most > 0) {
        assert_eq!(visit(most), all[..most.min(all.len())], "the same order, until the visitor breaks");
    }
}

/// Asks a world for the nearest objects.
///
/// # Panics
/// If an answer is wrong.
pub fn ask_nearest<I: Index>(
    world: &mut World<'_, I>,
    model: &Model,
    point: [f32; 3],
    count: usize,
    setup: Setup,
) {
    let world = &*world.with(setup);
    let expected = nearest(model.boxes(), point, count);
    // What stands there before does not matter.
    let stale = model.ids().first().map(|&id| Hit { id, distance: -1.0 });
    let mut out = vec![stale; count];
    assert_eq!(world.nearest(point, &mut out), Ok(expected.len()), "{point:?} {setup:?}");
    let told: Vec<Near> =
        out[..expected.len()].iter().flatten().map(|hit| (hit.id.slot(), hit.distance)).collect();
    assert_eq!(told, expected, "the {count} nearest to {point:?} with {setup:?}");
    visit_nearest(world, &nearest(model.boxes(), point, usize::MAX), point, expected.last());
}

/// Visits the nearest objects in every way: `all` of them, the nearest first, `last` the farthest one that is wanted.
fn visit_nearest<I: Index>(world: &World<'_, I>, all: &[Near], point: [f32; 3], last: Option<&Near>) {
    let visit = |distance: f64, far: &dyn Fn(Near) -> f64| {
        let mut visited: Vec<Near> = Vec::new();
        let mut each = |hit: Hit| {
            visited.push((hit.id.slot(), hit.distance));
            far((hit.id.slot(), hit.distance))
        };
        world.visit_nearest(point, distance, &mut each).expect("a good point");
        visited
    };
    let in_order = |mut visited: Vec<Near>| {
        visited.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        visited
    };
    // Different squares can have the same root: then the slot decides here.
    let all = &in_order(all.to_vec())[..];
    let each = visit(f64::INFINITY, &|_| f64::INFINITY);
    assert_eq!(visit(f64::INFINITY, &|_| f64::NAN), each, "the same order each time");
    assert_eq!(in_order(each.clone()), all, "each object is visited once: {point:?}");
    assert_eq!(visit(f64::INFINITY, &|_| -1.0), each[..each.len().min(1)], "a visitor can stop");
    if let Some(&(_, distance)) = last {
        let within = &all[..all.partition_point(|near| near.1 <= distance)];
        assert_eq!(in_order(visit(distance, &|_| f64::INFINITY)), within, "up to {distance} from {point:?}");
        assert_eq!(in_order(visit(distance.next_down().max(0.0), &|_| f64::INFINITY)), {
            let nearer = all.partition_point(|near| near.1 <= distance.next_down().max(0.0));
            &all[..nearer]
        });
    }
    let nearer = visit(f64::INFINITY, &|near| near.1);
    assert!(nearer.windows(2).all(|two| two[1].1 <= two[0].1), "only nearer ones: {nearer:?}");
    // One in three is refused, and shapes are farther than their boxes: as many as are as near as that have been visited.
    let shape = |(slot, distance): Near| distance + f64::from(slot % 5);
    let wanted = |near: &&Near| !near.0.is_multiple_of(3);
    let visited = visit(f64::INFINITY, &|near| if wanted(&&near) { shape(near) } else { f64::INFINITY });
    let least = |nears: &[Near]| nears.iter().filter(wanted).map(|near| shape(*near)).reduce(f64::min);
    assert_eq!(least(&visited), least(all), "the nearest shape: {point:?}");
}

/// Asks a world about a cast in every way.
///
/// # Panics
/// If an answer is wrong.
pub fn ask_cast<I: Index>(world: &mut World<'_, I>, model: &Model, cast: &Cast, setup: Setup) {
    let world = &*world.with(setup);
    let met = met(model.boxes(), cast);
    let mut out = vec![None; met.sure.len() + met.grazed.len()];
    let count = world.hits(cast, &mut out).unwrap_or_else(|error| panic!("{error}: {cast:?}"));
    let hits: Vec<Hit> = out[..count].iter().map(|hit| hit.expect("a hit for each object")).collect();
    let order = |hit: &Hit| (hit.distance, hit.id.slot());
    assert!(hits.windows(2).all(|two| order(&two[0]) < order(&two[1])), "near ones first: {hits:?}");
    let find = |slot: u32| hits.iter().find(|hit| hit.id.slot() == slot);
    for (slot, distance) in &met.sure {
        let hit = find(*slot).unwrap_or_else(|| {
            panic!("{setup:?} {cast:?} misses {slot} at {distance}: {:?}", model.boxes()[*slot as usize])
        });
        let wrong = (hit.distance - distance).abs();
        assert!(
            hit.distance == *distance || wrong <= 1e-12 * distance,
            "{cast:?} meets {slot} at {distance}: {hit:?}"
        );
        assert!(model.contains(hit.id));
    }
    let grazed = met.grazed.iter().filter(|(slot, _)| find(*slot).is_some()).count();
    assert_eq!(count, met.sure.len() + grazed, "{setup:?} {cast:?} meets what it does not: {hits:?} {met:?}");
    if count > 0 {
        let full = Error::OutputFull { needed: count as u64, room: count - 1 };
        assert_eq!(world.hits(cast, &mut out[..count - 1]), Err(full), "{cast:?}");
    }
    assert_eq!(world.first_hit(cast), Ok(hits.first().copied()), "the first of {cast:?}");
    let visit = |mut far: Box<dyn FnMut(&Hit) -> f64>| {
        let mut visited = Vec::new();
        let mut each = |hit: Hit| {
            visited.push(hit);
            far(&hit)
        };
        world.visit_hits(cast, &mut each).expect("a good cast");
        visited
    };
    let distance = f64::from(cast.distance);
    let all = visit(Box::new(move |_| distance));
    assert_eq!(all, visit(Box::new(|_| f64::INFINITY)), "the same order each time");
    let mut by_distance = all.clone();
    by_distance.sort_by(|a, b| order(a).partial_cmp(&order(b)).expect("distances are numbers"));
    assert_eq!(by_distance, hits, "each object is visited once: {cast:?}");
    assert_eq!(visit(Box::new(|_| -1.0)), all[..all.len().min(1)], "a visitor can stop");
    let nearer = visit(Box::new(|hit| hit.distance));
    assert!(nearer.windows(2).all(|two| two[1].distance <= two[0].distance), "only nearer ones: {nearer:?}");
    assert_eq!(
        nearer.iter().map(|hit| hit.distance).reduce(f64::min),
        hits.first().map(|hit| hit.distance),
        "the nearest is among them"
    );
}

/// A volume that counts how often it is asked.
pub struct Counted<'v>(pub &'v dyn Volume, pub Cell<u64>);

impl Volume for Counted<'_> {
    fn side(&self, aabb: &Aabb) -> Side {
        self.1.set(self.1.get() + 1);
        self.0.side(aabb)
    }
}

/// A ball around a segment, so far as bisection tells: a volume of the caller's own.
pub struct Capsule {
    /// The ends of the segment.
    pub ends: [[f32; 3]; 2],
    /// The radius of the ball.
    pub radius: f64,
}

impl Capsule {
    fn at(&self, t: f64) -> [f32; 3] {
        let [from, to] = self.ends;
        [0, 1, 2].map(|k| (f64::from(from[k]) * (1.0 - t) + f64::from(to[k]) * t) as f32)
    }
}

impl Volume for Capsule {
    fn side(&self, aabb: &Aabb) -> Side {
        // The square of the distance is convex along the segment.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
            if squared(self.at(a), aabb) <= squared(self.at(b), aabb) { high = b } else { low = a }
        }
        let nearest = squared(self.at(low), aabb).min(squared(self.at(high), aabb)).sqrt();
        // Boxes around many are told generously, as bisection of floats is not monotone.
        if nearest <= self.radius {
            Side::Across
        } else if nearest > self.radius * 1.001 + 0.001 || aabb.max[0] - aabb.min[0] < 1.0 {
            Side::Outside
        } else {
            Side::Across
        }
    }
}

/// Asks a world about a volume in every way.
///
/// # Panics
/// If an answer is wrong, or what is inside is asked about one by one.
pub fn ask_volume<I: Index>(world: &mut World<'_, I>, model: &Model, volume: &dyn Volume, setup: Setup) {
    let world = &*world.set_kernels(setup.kernels);
    let is_in = |aabb: &Aabb| volume.side(aabb) != Side::Outside;
    let expected: Vec<u32> =
        live(model.boxes()).filter(|(_, aabb)| is_in(aabb)).map(|(slot, _)| slot).collect();
    let mut out = vec![None; expected.len()];
    assert_eq!(world.within(volume, &mut out), Ok(expected.len()), "{setup:?}");
    assert_eq!(slots(&out), expected, "{setup:?}");
    let some = |id: Id| !id.slot().is_multiple_of(3);
    let count = world.among(some).within(volume, &mut out).expect("room for more");
    assert!(slots(&out[..count]).into_iter().eq(expected.iter().copied().filter(|slot| slot % 3 != 0)));
    if let Some((_, less)) = out.split_first_mut() {
        let full = Error::OutputFull { needed: expected.len() as u64, room: less.len() };
        assert_eq!(world.within(volume, less), Err(full));
    }
    let mut visited = 0;
    let mut each = |_| {
        visited += 1;
        if visited < 3 { Continue(()) } else { Break(()) }
    };
    world.visit_within(volume, &mut each);
    assert_eq!(visited, expected.len().min(3), "a visitor can stop");
}

/// Planes near a box, through corners of it or beside it.
fn any_planes(aabb: &Aabb, rng: &mut Rng) -> Vec<[f64; 4]> {
    let count = rng.below(7);
    let plane = |_| {
        let (at, mut normal) = (any_point(aabb, rng), rng.point(-1.0, 1.0));
        if rng.once_in(2) {
            normal = normal.map(f32::round);
        }
        let [x, y, z] = normal.map(f64::from);
        let distance = x * f64::from(at[0]) + y * f64::from(at[1]) + z * f64::from(at[2]);
        [x, y, z, distance + f64::from([0.0, rng.between(-0.5, 9.0)][rng.below(2)])]
    };
    (0..count).map(plane).collect()
}

/// Queries near the boxes of a model.
#[derive(Clone, Debug, Default)]
pub struct Questions {
    /// For what is between planes.
    pub planes: Vec<Vec<[f64; 4]>>,
    /// For overlaps.
    pub regions: Vec<Region>,
    /// For rays and moving boxes.
    pub casts: Vec<Cast>,
    /// For the nearest, and how many of them.
    pub points: Vec<([f32; 3], usize)>,
}

impl Questions {
    /// `count` of each kind, of all sorts.
    #[must_use]
    pub fn about(model: &Model, count: usize, rng: &mut Rng) -> Self {
        let boxes: Vec<Aabb> = model.boxes().iter().flatten().copied().collect();
        let mut questions = Self::default();
        for _ in 0..count {
            let aabb = any_box(&boxes, rng);
            questions.regions.push(any_region(&aabb, rng));
            questions.planes.push(any_planes(&aabb, rng));
            let target = any_box(&boxes, rng);
            questions.casts.push(any_cast(&aabb, &target, rng));
            let far = [[1e30, -1e30, 0.0], [f32::MAX; 3], [0.0, -f32::MAX, 1e-40]][rng.below(3)];
            let point = if rng.once_in(12) { far } else { any_point(&aabb, rng) };
            questions.points.push((point, [0, 1, 1, 2, 7, 40, boxes.len(), boxes.len() + 3][rng.below(8)]));
        }
        questions
    }

    /// Asks all of them.
    ///
    /// # Panics
    /// If an answer is wrong.
    pub fn ask<I: Index>(&self, world: &mut World<'_, I>, model: &Model, setup: Setup) {
        for region in &self.regions {
            ask_region(world, model, region, setup);
        }
        for planes in &self.planes {
            ask_volume(world, model, &Planes(planes), setup);
        }
        if let [(from, _), (to, _), ..] = self.points[..] {
            ask_volume(world, model, &Capsule { ends: [from, to], radius: 1.5 }, setup);
        }
        for cast in &self.casts {
            ask_cast(world, model, cast, setup);
        }
        for &(point, count) in &self.points {
            ask_nearest(world, model, point, count, setup);
        }
    }

    /// Asks for all casts at once and all regions at once, which must be the same as one by one; about all objects, and about some.
    ///
    /// # Panics
    /// If an answer differs.
    pub fn ask_batches<I: Index>(&self, world: &mut World<'_, I>, setup: Setup) {
        let Setup { kernels, jobs } = setup;
        let world = &*world.set_kernels(kernels);
        let mut hits = vec![None; self.casts.len() + 1];
        hits[self.casts.len()] = world.id_at(0).map(|id| Hit { id, distance: -1.0 });
        let last = hits[self.casts.len()];
        world.among(|_| true).first_hits(&self.casts, &jobs, &mut hits).expect("good casts and room");
        for (cast, hit) in self.casts.iter().zip(&hits) {
            assert_eq!(world.first_hit(cast), Ok(*hit), "{setup:?} {cast:?}");
        }
        assert_eq!(hits[self.casts.len()], last, "nothing is written behind the answers");
        let some = |id: Id| !id.slot().is_multiple_of(3);
        let among = world.among(some);
        among.first_hits(&self.casts, &jobs, &mut hits).expect("good casts and room");
        for (cast, hit) in self.casts.iter().zip(&hits) {
            assert_eq!(among.first_hit(cast), Ok(*hit), "{setup:?} {cast:?} among some");
        }

        let points: Vec<[f32; 3]> = self.points.iter().map(|(point, _)| *point).collect();
        for count in [0, 1, 5] {
            let mut all = vec![
                Some(Hit { id: Id::from_bits(1 << 32).expect("an id"), distance: 0.0 });
                count * points.len()
            ];
            world.among(|_| true).nearest_many(&points, &jobs, &mut all).expect("good points");
            let (mut one, mut few) = (vec![None; count], vec![None; count * points.len()]);
            among.nearest_many(&points, &jobs, &mut few).expect("good points");
            for (at, point) in points.iter().enumerate() {
                let found = world.nearest(*point, &mut one).expect("a good point");
                assert_eq!(all[at * count..][..found], one[..found], "{setup:?} {point:?}");
                assert!(all[at * count..][found..count].iter().all(Option::is_none));
                let found = among.nearest(*point, &mut one).expect("a good point");
                assert_eq!(few[at * count..][..found], one[..found], "{setup:?} {point:?} among some");
            }
        }
        if let Some(last) = points.len().checked_sub(1) {
            let mut bad = points.clone();
            bad[last][1] = f32::NAN;
            let refused = Err(Error::BadQuery { index: last as u32 });
            assert_eq!(world.among(|_| true).nearest_many(&bad, &jobs, &mut []), refused);
        }

        let regions = self.regions.len();
        let one_by_one: Vec<Vec<Option<Id>>> = self
            .regions
            .iter()
            .map(|region| {
                let mut out = vec![None; world.len() as usize];
                let count = world.overlaps(region, &mut out).expect("room for all");
                out.truncate(count);
                out
            })
            .collect();
        let total = one_by_one.iter().map(Vec::len).sum::<usize>();
        let (mut out, mut ends) = (vec![None; total], vec![9; regions]);
        let count = among.overlaps_many(&self.regions, &jobs, &mut out, &mut ends).expect("room for more");
        let expected = one_by_one.iter().flatten().filter(|id| id.is_some_and(some));
        assert!(out[..count].iter().eq(expected), "{setup:?}: among some");
        // Room for all, and not quite; shares that are enough for each block, and shares that are not.
        for room in [0, total / 2, total.saturating_sub(1), total, total + 9, total * regions] {
            let (mut out, mut ends) = (vec![None; room], vec![9; regions]);
            let told = world.among(|_| true).overlaps_many(&self.regions, &jobs, &mut out, &mut ends);
            let full = Error::OutputFull { needed: total as u64, room };
            assert_eq!(told, if total > room { Err(full) } else { Ok(total) }, "{setup:?}");
            let mut sum = 0;
            for (expected, end) in one_by_one.iter().zip(ends) {
                sum += expected.len();
                assert_eq!(end, sum, "{setup:?}");
            }
            let all: Vec<Option<Id>> = one_by_one.iter().flatten().copied().collect();
            assert!(told.is_err() || out[..total] == all, "{setup:?}, room for {room}");
        }
    }
}

fn any_box(boxes: &[Aabb], rng: &mut Rng) -> Aabb {
    let finite = |aabb: &Aabb| aabb.min.iter().chain(&aabb.max).all(|x| x.abs() < 1e30);
    let aabb = if boxes.is_empty() { None } else { Some(boxes[rng.below(boxes.len())]) };
    aabb.filter(finite).unwrap_or(Aabb::new([-1.0; 3], [2.0; 3]))
}

/// On a corner, inside, or around a box.
fn any_point(aabb: &Aabb, rng: &mut Rng) -> [f32; 3] {
    [0, 1, 2].map(|k| match rng.below(4) {
        0 => aabb.min[k],
        1 => aabb.max[k],
        2 => rng.between(aabb.min[k], aabb.max[k]),
        _ => aabb.min[k] + rng.between(-5.0, 5.0),
    })
}

fn any_region(aabb: &Aabb, rng: &mut Rng) -> Region {
    let point = any_point(aabb, rng);
    match rng.below(8) {
        0 => Region::Point(point),
        1 => Region::Sphere { center: point, radius: 0.0 },
        2 | 3 => Region::Sphere { center: point, radius: rng.between(0.0, 3.0) },
        4 => {
            // Open to one side, or to several.
            let mut region = *aabb;
            region.max[rng.below(3)] = f32::INFINITY;
            region.min[rng.below(3)] = f32::NEG_INFINITY;
            Region::Aabb(region)
        }
        5 => {
            // It touches the box on one side, and nothing else of it.
            let (mut region, axis) = (*aabb, rng.below(3));
            region.min[axis] = aabb.max[axis];
            region.max[axis] = aabb.max[axis] + 1.0;
            Region::Aabb(region)
        }
        _ => {
            let other = any_point(aabb, rng);
            Region::Aabb(Aabb::new(
                [0, 1, 2].map(|k| point[k].min(other[k])),
                [0, 1, 2].map(|k| point[k].max(other[k])),
            ))
        }
    }
}

fn any_cast(from: &Aabb, to: &Aabb, rng: &mut Rng) -> Cast {
    let point = any_point(from, rng);
    let target = any_point(to, rng);
    let mut direction = [0, 1, 2].map(|k| target[k] - point[k]);
    match rng.below(8) {
        // Along an axis, along a side of the box where the point is on it.
        0 | 1 => {
            direction = [0.0; 3];
            direction[rng.below(3)] = [1.0, -1.0, 0.25, -8.0][rng.below(4)];
        }
        2 => direction[rng.below(3)] = [0.0, -0.0][rng.below(2)],
        3 => direction = [0.0, -0.0, 0.0],
        // Of any length.
        4 => {
            let length = [1e-30, 1e-6, 1e6, 1e20][rng.below(4)];
            direction = direction.map(|d| d * length);
        }
        5 => direction = [1.0, -1.0, 0.5].map(|d| if rng.once_in(3) { -d } else { d }),
        _ => {}
    }
    let distance = [0.0, 0.5, 1.0, 1.0, 30.0, f32::MAX, f32::INFINITY][rng.below(7)];
    let edges = if rng.once_in(2) { [0.0; 3] } else { rng.point(0.0, 2.0) };
    Cast { start: Aabb::new(point, [0, 1, 2].map(|k| point[k] + edges[k])), direction, distance }
}
