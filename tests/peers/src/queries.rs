//! Queries side by side: the boxes of one frame at rest, box queries and rays in turn, answers compared.

use crate::{
    options::Options,
    oracle,
    ours::kernels,
    recording::{Padded, Recording},
};
use parry3d::{
    math::Vector,
    partitioning::{Bvh, BvhBuildStrategy},
    query::{Ray, RayCast},
};
use std::{fmt::Write, hint::black_box, time::Instant};
use trisap::{Aabb, Boxes, Capacity, Cast, Config, Kernels, OwnedWorld, Region, World};

/// Queries of each kind in a round, and rounds.
const QUERIES: usize = 10_000;
const ROUNDS: usize = 15;
/// Steps before the queries, all but the first without a mover: the world is at rest.
const STEPS: usize = 100;

/// Answers a round of queries: the number of overlaps, or the sum of the distances, and how many rays hit.
trait Side {
    fn name(&self) -> &'static str;
    fn boxes(&mut self, regions: &[Padded]) -> u64;
    fn rays(&mut self, rays: &[Line]) -> (u64, f64);
}

/// A ray without an end.
struct Line {
    origin: [f32; 3],
    direction: [f32; 3],
}

/// The Markdown table of one scene, or what was wrong.
pub(crate) fn scene(recording: &Recording, options: &Options) -> Result<String, String> {
    let boxes = recording.frame(0);
    let (regions, rays) = (regions(boxes), rays(boxes));
    let mut sides: Vec<Box<dyn Side>> =
        vec![Box::new(Ours::new(boxes, kernels(options)?)?), Box::new(Parry::new(boxes))];
    #[cfg(feature = "embree")]
    sides.push(Box::new(embree::Embree::new(boxes)));
    let mut times = vec![[const { Vec::new() }; 2]; sides.len()];
    let expected: u64 = regions
        .iter()
        .take(100)
        .map(|region| boxes.iter().filter(|other| oracle::overlap(region, other)).count() as u64)
        .sum();
    for side in &mut sides {
        if side.boxes(&regions[..100]) != expected {
            return Err(format!("{}: wrong boxes", side.name()));
        }
    }
    for _ in 0..ROUNDS {
        let mut answers = Vec::new();
        for (side, [box_times, ray_times]) in sides.iter_mut().zip(&mut times) {
            let start = Instant::now();
            let found = black_box(side.boxes(&regions));
            box_times.push(start.elapsed().as_secs_f64() * 1e9 / QUERIES as f64);
            let start = Instant::now();
            let (hits, distance) = black_box(side.rays(&rays));
            ray_times.push(start.elapsed().as_secs_f64() * 1e9 / QUERIES as f64);
            answers.push((side.name(), found, hits, distance));
        }
        let (_, found, hits, distance) = answers[0];
        for (name, f, h, d) in &answers[1..] {
            // The others compute in `f32`: a ray that grazes a box may go either way.
            let near = h.abs_diff(hits) <= 5 && (d - distance).abs() <= 1e-3 * distance;
            if *f != found || !near {
                return Err(format!("{name}: {f} boxes, {h} hits, {d}; trisap: {found}, {hits}, {distance}"));
            }
        }
    }
    let mut text = format!(
        "\n{} {}, at rest: ns a query\n\n| | boxes | rays |\n|---|---|---|",
        recording.name, recording.objects
    );
    let median = |times: &mut Vec<f64>| {
        times.sort_unstable_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let ours = times[0].each_mut().map(median);
    for (side, times) in sides.iter().zip(&mut times) {
        let [b, r] = times.each_mut().map(median);
        _ = write!(
            text,
            "\n| {} | {b:.0} ({:.2}x) | {r:.0} ({:.2}x) |",
            side.name(),
            b / ours[0],
            r / ours[1]
        );
    }
    Ok(text + "\n")
}

fn corners(b: &Padded) -> ([f32; 3], [f32; 3]) {
    ([b[0], b[1], b[2]], [b[4], b[5], b[6]])
}

/// Numbers from zero to one, the same in every run.
fn numbers() -> impl FnMut() -> f32 {
    let mut state = 1u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// A point inside the bounds of all boxes, and how large the first box is.
fn points(boxes: &[Padded]) -> (impl FnMut() -> [f32; 3], f32) {
    let side = |k: usize| {
        let low = boxes.iter().map(|b| b[k]).fold(f32::INFINITY, f32::min);
        let high = boxes.iter().map(|b| b[k + 4]).fold(f32::NEG_INFINITY, f32::max);
        (low, high - low)
    };
    let sides = [side(0), side(1), side(2)];
    let mut number = numbers();
    (move || sides.map(|(low, length)| low + length * number()), boxes[0][4] - boxes[0][0])
}

/// Boxes half as large again as an object, anywhere among the objects.
fn regions(boxes: &[Padded]) -> Vec<Padded> {
    let (mut point, size) = points(boxes);
    let region = |_| {
        let [x, y, z] = point();
        let size = 1.5 * size;
        [x, y, z, 0.0, x + size, y + size, z + size, 0.0]
    };
    (0..QUERIES).map(region).collect()
}

/// Rays from anywhere among the objects to anywhere.
fn rays(boxes: &[Padded]) -> Vec<Line> {
    let (mut point, _) = points(boxes);
    let ray = |_| {
        let (origin, to) = (point(), point());
        Line { origin, direction: std::array::from_fn(|k| to[k] - origin[k]) }
    };
    (0..QUERIES).map(ray).collect()
}

struct Ours {
    world: OwnedWorld,
    kernels: Kernels,
}

impl Ours {
    fn new(boxes: &[Padded], kernels: Kernels) -> Result<Self, String> {
        let boxes: Vec<Aabb> = boxes.iter().map(corners).map(|(min, max)| Aabb::new(min, max)).collect();
        let mut world = OwnedWorld::new(&Config::new(Capacity::for_objects(boxes.len() as u32)))
            .map_err(|error| error.to_string())?;
        let mut fill = || {
            let mut world: World<'_> = world.world();
            world.insert_many(Boxes::new(&boxes))?;
            (0..STEPS).try_for_each(|_| world.set_kernels(kernels).step().map(drop))
        };
        fill().map_err(|error| error.to_string())?;
        Ok(Self { world, kernels })
    }
}

impl Side for Ours {
    fn name(&self) -> &'static str {
        "trisap"
    }

    fn boxes(&mut self, regions: &[Padded]) -> u64 {
        let mut world = self.world.world();
        let mut out = [None; 1024];
        let count = |region: &Padded| {
            let (min, max) = corners(region);
            world
                .set_kernels(self.kernels)
                .overlaps(&Region::Aabb(Aabb::new(min, max)), &mut out)
                .unwrap_or(0) as u64
        };
        regions.iter().map(count).sum()
    }

    fn rays(&mut self, rays: &[Line]) -> (u64, f64) {
        let mut world = self.world.world();
        rays.iter().fold((0, 0.0), |(hits, sum), ray| {
            let cast = Cast::ray(ray.origin, ray.direction, f32::INFINITY);
            match world.set_kernels(self.kernels).first_hit(&cast) {
                Ok(Some(hit)) => (hits + 1, sum + hit.distance),
                _ => (hits, sum),
            }
        })
    }
}

struct Parry {
    bvh: Bvh,
    boxes: Vec<parry3d::bounding_volume::Aabb>,
}

fn vector([x, y, z]: [f32; 3]) -> Vector {
    Vector::new(x, y, z)
}

fn parry_box(b: &Padded) -> parry3d::bounding_volume::Aabb {
    let (min, max) = corners(b);
    parry3d::bounding_volume::Aabb::new(vector(min), vector(max))
}

impl Parry {
    fn new(boxes: &[Padded]) -> Self {
        let boxes: Vec<_> = boxes.iter().map(parry_box).collect();
        Self { bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes), boxes }
    }
}

impl Side for Parry {
    fn name(&self) -> &'static str {
        "parry3d BVH, binned build"
    }

    fn boxes(&mut self, regions: &[Padded]) -> u64 {
        regions.iter().map(|region| self.bvh.intersect_aabb(&parry_box(region)).count() as u64).sum()
    }

    fn rays(&mut self, rays: &[Line]) -> (u64, f64) {
        rays.iter().fold((0, 0.0), |(hits, sum), line| {
            let ray = Ray::new(vector(line.origin), vector(line.direction));
            let leaf = |leaf: u32, best: f32| self.boxes[leaf as usize].cast_local_ray(&ray, best, true);
            match self.bvh.cast_ray(&ray, f32::MAX, leaf) {
                Some((_, distance)) => (hits + 1, sum + f64::from(distance)),
                None => (hits, sum),
            }
        })
    }
}

#[cfg(feature = "embree")]
mod embree {
    use super::{Line, Padded, Side};
    use std::ffi::c_void;

    unsafe extern "C" {
        fn embree_queries_start(boxes: *const Padded, count: u32) -> *mut c_void;
        fn embree_queries_ray(state: *mut c_void, origin: *const f32, direction: *const f32) -> f32;
        fn embree_queries_box(state: *mut c_void, region: *const Padded) -> u32;
        fn embree_queries_stop(state: *mut c_void);
    }

    pub(super) struct Embree {
        state: *mut c_void,
        /// Where the state points to.
        _boxes: Vec<Padded>,
    }

    impl Embree {
        pub(super) fn new(boxes: &[Padded]) -> Self {
            let boxes = boxes.to_vec();
            // SAFETY: the boxes live on the heap for as long as the state.
            let state = unsafe { embree_queries_start(boxes.as_ptr(), boxes.len() as u32) };
            Self { state, _boxes: boxes }
        }
    }

    impl Side for Embree {
        fn name(&self) -> &'static str {
            "Embree, user geometry, high quality build"
        }

        fn boxes(&mut self, regions: &[Padded]) -> u64 {
            // SAFETY: the state is live.
            regions.iter().map(|region| u64::from(unsafe { embree_queries_box(self.state, region) })).sum()
        }

        fn rays(&mut self, rays: &[Line]) -> (u64, f64) {
            rays.iter().fold((0, 0.0), |(hits, sum), ray| {
                // SAFETY: the state is live, and both arrays have three floats.
                let distance =
                    unsafe { embree_queries_ray(self.state, ray.origin.as_ptr(), ray.direction.as_ptr()) };
                if distance.is_finite() { (hits + 1, sum + f64::from(distance)) } else { (hits, sum) }
            })
        }
    }

    impl Drop for Embree {
        fn drop(&mut self) {
            // SAFETY: the state is live and not used afterwards.
            unsafe { embree_queries_stop(self.state) }
        }
    }
}
