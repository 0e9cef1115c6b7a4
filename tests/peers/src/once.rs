//! Pairs of boxes that are there once: from an array of boxes to a list of pairs, in a process of its own for each side and
//! round, so that the first call is the first of a process.

use crate::{
    clock::Clock,
    options::Options,
    oracle::{self, Digest},
    recording::Padded,
};
use parry3d::{
    math::Vector,
    partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace},
};
use rstar::{
    AABB, RTree,
    primitives::{GeomWithData, Rectangle},
};
use std::{env, fmt::Write, hint::black_box, process::Command, time::Duration};
use trisap::{Aabb, Boxes, Capacity, Config, OwnedWorld};

const SIZES: [usize; 3] = [1_000, 100_000, 1_000_000];
/// Processes of each side, in turns, and calls in each.
const ROUNDS: usize = 5;
const CALLS: usize = 5;

/// Gives the pairs of boxes that it has in its own form.
type Call = Box<dyn FnMut() -> Vec<[u32; 2]>>;

struct Side {
    name: &'static str,
    /// Whether bars are set by it: how many times as long as trisap it takes at least, at 100,000 boxes.
    start: fn(&[Padded]) -> Call,
}

const SIDES: &[Side] = &[
    Side {
        name: "trisap, pairs",
        start: |boxes| {
            let boxes = aabbs(boxes);
            Box::new(move || trisap::pairs(&boxes).expect("good boxes"))
        },
    },
    Side {
        name: "trisap, a world that knows its room",
        start: |boxes| {
            let (boxes, known) = (aabbs(boxes), oracle::pairs(boxes, |_, _| true).count as u32);
            let capacity = Capacity::for_objects(boxes.len() as u32).with_pairs(known);
            Box::new(move || {
                let mut owned = OwnedWorld::new(&Config::new(capacity)).expect("memory");
                let mut world = owned.world();
                drop(world.insert_many(Boxes::new(&boxes)).expect("good boxes"));
                world.step().expect("room").pairs().to_vec()
            })
        },
    },
    Side { name: "parry3d, binned", start: |boxes| parry(boxes, BvhBuildStrategy::Binned) },
    Side { name: "parry3d, PLOC", start: |boxes| parry(boxes, BvhBuildStrategy::Ploc) },
    Side {
        name: "rstar, tree with itself",
        start: |boxes| {
            let items = rectangles(boxes);
            Box::new(move || {
                let tree = RTree::bulk_load(items.clone());
                let both = tree.intersection_candidates_with_other_tree(&tree);
                both.filter(|(a, b)| a.data < b.data).map(|(a, b)| [a.data, b.data]).collect()
            })
        },
    },
    Side {
        name: "rstar, box by box",
        start: |boxes| {
            let items = rectangles(boxes);
            Box::new(move || {
                let tree = RTree::bulk_load(items.clone());
                let near = |a: &GeomWithData<Rectangle<[f32; 3]>, u32>| {
                    let (id, envelope) = (a.data, rstar::RTreeObject::envelope(a));
                    tree.locate_in_envelope_intersecting(envelope)
                        .map(move |b| [id, b.data])
                        .filter(|[a, b]| a < b)
                };
                items.iter().flat_map(near).collect()
            })
        },
    },
    #[cfg(feature = "cgal")]
    Side {
        name: "CGAL box_self_intersection_d",
        start: |boxes| {
            unsafe extern "C" {
                fn cgal_once(boxes: *const Padded, count: u32, pairs: *mut *const [u32; 2]) -> usize;
            }
            let boxes = boxes.to_vec();
            Box::new(move || {
                let mut first = std::ptr::null();
                // SAFETY: as many boxes are there for the call, and the pairs stay until the next one.
                unsafe {
                    let count = cgal_once(boxes.as_ptr(), boxes.len() as u32, &mut first);
                    if count == 0 { Vec::new() } else { std::slice::from_raw_parts(first, count).to_vec() }
                }
            })
        },
    },
];

fn aabbs(boxes: &[Padded]) -> Vec<Aabb> {
    boxes.iter().map(|b| Aabb::new([b[0], b[1], b[2]], [b[4], b[5], b[6]])).collect()
}

fn rectangles(boxes: &[Padded]) -> Vec<GeomWithData<Rectangle<[f32; 3]>, u32>> {
    let rectangle =
        |b: &Padded| Rectangle::from_aabb(AABB::from_corners([b[0], b[1], b[2]], [b[4], b[5], b[6]]));
    boxes.iter().zip(0..).map(|(b, id)| GeomWithData::new(rectangle(b), id)).collect()
}

fn parry(boxes: &[Padded], strategy: BvhBuildStrategy) -> Call {
    let corner = |b: &[f32]| Vector::new(b[0], b[1], b[2]);
    let boxes: Vec<_> =
        boxes.iter().map(|b| parry3d::bounding_volume::Aabb::new(corner(b), corner(&b[4..]))).collect();
    Box::new(move || {
        let (bvh, mut pairs) = (Bvh::from_leaves(strategy, &boxes), Vec::new());
        let mut workspace = BvhWorkspace::default();
        bvh.traverse_bvtt_single_tree::<false>(&mut workspace, &mut |a, b| pairs.push([a, b]));
        pairs
    })
}

/// Unit cubes anywhere in a cube, about two pairs each.
fn boxes(count: usize) -> Vec<Padded> {
    let mut state = 1u64;
    let mut number = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let side = (count as f32 * 2.0).cbrt();
    let cube = |[x, y, z]: [f32; 3]| [x, y, z, 0.0, x + 1.0, y + 1.0, z + 1.0, 0.0];
    (0..count).map(|_| cube([(); 3].map(|()| side * number()))).collect()
}

/// One side in this process: prints its times in nanoseconds and what it found.
pub(crate) fn child(side: usize, count: usize, clock: Clock) {
    let boxes = boxes(count);
    let mut call = (SIDES[side].start)(&boxes);
    for _ in 0..CALLS {
        let start = clock.now();
        let pairs = black_box(call());
        let time = clock.now() - start;
        let mut digest = Digest::default();
        pairs.into_iter().for_each(|pair| digest.add(pair));
        println!("{} {digest:?}", time.as_nanos());
    }
}

/// The Markdown table of all sizes, or what was wrong.
pub(crate) fn table(options: &Options) -> Result<String, String> {
    let mut text = String::from(
        "| boxes | pairs | side | first call, ms | later ones, ms | over trisap, first | later |\n|---:|---:|---|---:|---:|---:|---:|\n",
    );
    for count in SIZES {
        let expected = oracle::pairs(&boxes(count), |_, _| true);
        let mut times = vec![[const { Vec::new() }; 2]; SIDES.len()];
        for _ in 0..ROUNDS {
            for (side, [first, later]) in times.iter_mut().enumerate() {
                let (one, mut others) = run(side, count, options.clock, &expected)?;
                first.push(one);
                others.sort_unstable();
                later.push(others[others.len() / 2]);
            }
        }
        let median = |times: &mut Vec<Duration>| {
            times.sort_unstable();
            times[times.len() / 2].as_secs_f64() * 1e3
        };
        let medians: Vec<[f64; 2]> = times.iter_mut().map(|times| times.each_mut().map(median)).collect();
        let [ours, ours_later] = medians[0];
        for (side, [first, later]) in SIDES.iter().zip(&medians) {
            let pairs = expected.count;
            let (a, b) = (first / ours, later / ours_later);
            _ = writeln!(
                text,
                "| {count} | {pairs} | {} | {first:.3} | {later:.3} | {a:.2} | {b:.2} |",
                side.name
            );
        }
    }
    Ok(text)
}

/// Lets a process do all calls of one side: the first time, and those of the others.
fn run(
    side: usize,
    count: usize,
    clock: Clock,
    expected: &Digest,
) -> Result<(Duration, Vec<Duration>), String> {
    let program = env::current_exe().map_err(|error| error.to_string())?;
    let clock = if clock == Clock::Cpu { "cpu" } else { "wall" };
    let arguments = ["--once-side", &side.to_string(), &count.to_string(), "--clock", clock];
    let output = Command::new(program).args(arguments).output().map_err(|error| error.to_string())?;
    let name = SIDES[side].name;
    let mut times = Vec::new();
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let (time, found) = line.split_once(' ').ok_or("an empty line")?;
        if found != format!("{expected:?}") {
            return Err(format!("{name}, {count} boxes: {found} instead of {expected:?}"));
        }
        times.push(Duration::from_nanos(time.parse().map_err(|_| "no time")?));
    }
    if !output.status.success() || times.len() != CALLS {
        return Err(format!("{name}, {count} boxes: {}", String::from_utf8_lossy(&output.stderr)));
    }
    let first = times.remove(0);
    Ok((first, times))
}
