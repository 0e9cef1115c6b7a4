//! Hard boxes.

use super::Case;
use trisap::scene::{Kind, Objects, Random, Setup, Synthetic};
use trisap::{Aabb, Capacity, Config, Margin, Mode};

const EXACT: Config = Config::new(Capacity::for_objects(0).with_leaf_refs(0).with_pairs(0));

/// Enough for a tree.
const COUNT: u32 = 1200;

fn exact(input: &'static str, answer: &'static str, frames: Vec<Vec<Aabb>>) -> Case {
    Case { input, answer, config: EXACT, frames }
}

fn fat(input: &'static str, answer: &'static str, margin: Margin, frames: Vec<Vec<Aabb>>) -> Case {
    Case { input, answer, config: EXACT.with_mode(Mode::Fat).with_margin(margin), frames }
}

pub(super) fn cases() -> Vec<Case> {
    let infinite = f32::INFINITY;
    vec![
        exact(
            "NaN in any coordinate, of either sign",
            "refuses those boxes; the objects keep their last good ones",
            spoilt(|aabb, k| {
                let nan = if k % 2 == 0 { f32::NAN } else { -f32::NAN };
                aabb.min[k % 3] = nan;
            }),
        ),
        exact(
            "minimum above maximum, by one step of f32",
            "refuses those boxes",
            spoilt(|aabb, k| aabb.min[k % 3] = aabb.max[k % 3].next_up()),
        ),
        exact(
            "infinite bounds: half-spaces, ground planes, all of space",
            "takes them as unbounded, in a list of their own",
            among(&[
                Aabb::new([-infinite; 3], [infinite; 3]),
                Aabb::new([-infinite; 3], [infinite, 0.0, infinite]),
                Aabb::new([1.0, -infinite, -infinite], [infinite; 3]),
                Aabb::new([infinite, 0.0, 0.0], [infinite, 1.0, 1.0]),
            ]),
        ),
        exact("-0.0 against +0.0", "takes them as equal: the boxes touch", signed_zeros()),
        exact(
            "denormals",
            "compares them exactly, one by one: the short records cannot tell them apart",
            lattice(f32::from_bits(1), 3),
        ),
        exact("touching faces, edges and corners", "counts them: boxes are closed", lattice(1.0, 1)),
        exact(
            "neighbours that overlap or miss each other by one step of f32",
            "tells them apart",
            one_step(),
        ),
        exact("boxes without volume", "counts their contacts", lattice(1.0, 0)),
        exact("all boxes identical", "reports each pair once", swaying(vec![CUBE; 600], 0.5)),
        exact(
            "a flat world",
            "cuts along the other axes",
            moving(|aabb| (aabb.min[2], aabb.max[2]) = (0.0, 0.0)),
        ),
        exact(
            "a world that is a line",
            "cuts along the line",
            moving(|aabb| {
                for k in 1..3 {
                    (aabb.min[k], aabb.max[k]) = (5.0, 6.0);
                }
            }),
        ),
        exact(
            "64 unit cubes at 1e9, where f32 has two places",
            "finds that they overlap as they are given",
            {
                let cube = |i: usize| [i % 4, i / 4 % 4, i / 16].map(|x| 1e9 + 20.0 * x as f32);
                let cubes = (0..64).map(cube).map(|low| Aabb::new(low, low.map(|x| x + 1.0)));
                swaying(cubes.collect(), 64.0)
            },
        ),
        exact("size ratio 1e12", "puts the large ones into a list of their own", {
            let mut small = Random::new(4, 0);
            let boxes = (0..COUNT).map(|i| {
                let low = [(); 3].map(|()| small.unit() * 1e-3);
                let edge = if i % 50 == 0 { 1e6 } else { 1e-6 };
                Aabb::new(low, low.map(|x| x + edge))
            });
            swaying(boxes.collect(), 1e-6)
        }),
        exact("everything overlaps", "counts in 64 bits", {
            let boxes = (0..600).map(|i| Aabb::new([i as f32 * 1e-3; 3], [10.0 + i as f32 * 1e-3; 3]));
            swaying(boxes.collect(), 0.5)
        }),
        exact("all objects teleport in every frame", "sorts anew, in linear time", {
            let kind = Kind::Brownian;
            let frame = |seed| Synthetic::new(Setup { kind, objects: Objects::Assorted, count: COUNT, seed });
            (0..6).map(|seed| frame(seed).boxes().to_vec()).collect()
        }),
        exact("objects swing between two places", "tells events from the pairs alone", {
            let there = moving(|_| {});
            (0..8).map(|frame| there[frame % 2].clone()).collect()
        }),
        Case {
            input: "slow creep inside the margin",
            answer: "tests the boxes that crept again",
            config: EXACT.with_margin(Margin::length(0.5)),
            frames: creeping(0.004),
        },
        fat(
            "a margin below one step of f32, at 262,144",
            "keeps every box inside its fat box",
            Margin::length(0.01),
            moving(|aabb| {
                aabb.min = aabb.min.map(|x| x + 262_144.0);
                aabb.max = aabb.max.map(|x| x + 262_144.0);
            }),
        ),
        fat(
            "a margin that overflows",
            "saturates: everything overlaps, the surplus is counted",
            Margin::share(f32::MAX),
            swaying(Synthetic::new(setup(300)).boxes().to_vec(), 0.5),
        ),
    ]
}

const CUBE: Aabb = Aabb::new([0.0; 3], [1.0; 3]);

fn setup(count: u32) -> Setup {
    Setup { kind: Kind::Gravity, objects: Objects::Assorted, count, seed: 2 }
}

/// An ordinary scene of which every box is changed.
fn moving(change: impl Fn(&mut Aabb)) -> Vec<Vec<Aabb>> {
    let mut scene = Synthetic::new(setup(COUNT));
    let mut next = || {
        scene.advance();
        let mut boxes = scene.boxes().to_vec();
        boxes.iter_mut().for_each(&change);
        boxes
    };
    (0..5).map(|_| next()).collect()
}

/// Boxes that go there and back along x.
fn swaying(boxes: Vec<Aabb>, by: f32) -> Vec<Vec<Aabb>> {
    let mut there = boxes.clone();
    for aabb in &mut there {
        aabb.min[0] += by;
        aabb.max[0] += by;
    }
    (0..5).map(|frame| if frame % 2 == 0 { boxes.clone() } else { there.clone() }).collect()
}

/// An ordinary scene in which, after the first frame, some boxes are spoilt, others in each frame.
fn spoilt(spoil: impl Fn(&mut Aabb, usize)) -> Vec<Vec<Aabb>> {
    let mut frames = moving(|_| {});
    for (frame, boxes) in frames.iter_mut().enumerate().skip(1) {
        for (k, aabb) in boxes.iter_mut().skip(frame).step_by(100).enumerate() {
            spoil(aabb, k);
        }
    }
    frames
}

/// An ordinary scene with other boxes in it.
fn among(others: &[Aabb]) -> Vec<Vec<Aabb>> {
    let mut frames = moving(|_| {});
    frames.iter_mut().for_each(|boxes| boxes.extend(others));
    frames
}

/// Boxes whose corners are on a grid of so many units, with edges of up to so many units.
fn lattice(unit: f32, most: u32) -> Vec<Vec<Aabb>> {
    let mut random = Random::new(6, 0);
    let mut boxed = |_| {
        let low = [(); 3].map(|()| random.below(12));
        let high = low.map(|x| x + if most > 0 { random.below(most) + 1 } else { 0 });
        Aabb::new(low.map(|x| x as f32 * unit), high.map(|x| x as f32 * unit))
    };
    (0..4).map(|_| (0..COUNT).map(&mut boxed).collect()).collect()
}

fn signed_zeros() -> Vec<Vec<Aabb>> {
    let boxed = |i: u32, frame: u32| {
        let zero = if (i + frame).is_multiple_of(2) { 0.0 } else { -0.0 };
        let [y, z] = [i / 40, i % 40].map(|x| x as f32);
        match i % 3 {
            0 => Aabb::new([-1.0, y, z], [zero, y + 1.0, z + 1.0]),
            1 => Aabb::new([zero, y, z], [1.0, y + 1.0, z + 1.0]),
            _ => Aabb::new([zero, y, z], [-zero, y + 1.0, z + 1.0]),
        }
    };
    (0..4).map(|frame| (0..COUNT).map(|i| boxed(i, frame)).collect()).collect()
}

/// Pairs of boxes of which the second begins where the first ends, or one step of `f32` before or behind that.
fn one_step() -> Vec<Vec<Aabb>> {
    let mut random = Random::new(8, 0);
    let mut two = |_| {
        let low = [(); 3].map(|()| random.unit() * 200.0 - 100.0);
        let first = Aabb::new(low, low.map(|x| x + 0.1 + random.unit()));
        let axis = random.below(3) as usize;
        let mut second = first;
        let end = first.max[axis];
        second.min[axis] = [end, end.next_up(), end.next_down()][random.below(3) as usize];
        second.max[axis] = second.min[axis] + 1.0;
        [first, second]
    };
    (0..4).map(|_| (0..COUNT / 2).flat_map(&mut two).collect()).collect()
}

/// A scene in which every box drifts a little in each frame.
fn creeping(by: f32) -> Vec<Vec<Aabb>> {
    let boxes = Synthetic::new(setup(COUNT)).boxes().to_vec();
    let drift = |i: usize, frame: usize| by * frame as f32 * (i % 7) as f32;
    let frame = |frame| {
        let crept = boxes.iter().enumerate().map(|(i, aabb)| {
            let add = |x: [f32; 3]| x.map(|x| x + drift(i, frame));
            Aabb::new(add(aabb.min), add(aabb.max))
        });
        crept.collect()
    };
    (0..12).map(frame).collect()
}
