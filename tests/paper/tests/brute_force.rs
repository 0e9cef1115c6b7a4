//! The pairs of every step are those of brute force: random scenes, degenerate ones, synthetic ones and the recordings.

mod common;

use common::{Random, brute_force, check};
use std::path::Path;
use trisap::Boxes;
use trisap::recording::Recording;
use trisap::scene::{Kind, Objects, Setup, Synthetic};
use trisap_paper::{Aabb, Settings, World};

/// A box at a random place. With a grid, corners of different boxes are often equal.
fn place(random: &mut Random, side: f32, size: f32, grid: bool) -> Aabb {
    let round = |x: f32| if grid { x.round() } else { x };
    let min: [f32; 3] = std::array::from_fn(|_| round(side * (random.unit() - 0.5)));
    let max = min.map(|x| x + round(size * random.unit()));
    Aabb::new(min, max)
}

/// An index below `limit`.
fn pick(random: &mut Random, limit: usize) -> usize {
    (random.unit() * limit as f32) as usize
}

#[test]
fn random_scenes() {
    let mut random = Random(1);
    for round in 0..60 {
        let objects = [1, 2, 3, 17, 130, 400][round % 6];
        let (grid, size) = (round % 2 == 0, [0.5, 2.0, 6.0][round / 2 % 3]);
        let movers = [1.0, 0.2, 0.01][round / 6 % 3];
        let slow = round % 4 < 2;
        let mut boxes: Vec<Aabb> = (0..objects).map(|_| place(&mut random, 10.0, size, grid)).collect();
        let mut frames = Vec::new();
        for _ in 0..12 {
            frames.push(boxes.clone());
            for aabb in &mut boxes {
                if random.unit() >= movers {
                    continue;
                }
                if slow {
                    let by = [(); 3].map(|()| 0.1 * (random.unit() - 0.5));
                    *aabb = Aabb::new(
                        std::array::from_fn(|k| aabb.min[k] + by[k]),
                        std::array::from_fn(|k| aabb.max[k] + by[k]),
                    );
                } else {
                    *aabb = place(&mut random, 10.0, size, grid);
                }
            }
        }
        check(&format!("round {round}"), &frames);
    }
}

#[test]
fn all_boxes_are_equal() {
    let one = Aabb::new([1.0; 3], [2.0; 3]);
    let point = Aabb::new([1.0; 3], [1.0; 3]);
    check("equal", &[vec![point; 200], vec![one; 200], vec![point; 200]]);
}

#[test]
fn boxes_touch_at_planes() {
    // Each box of a grid touches 26 others, and every plane of the tree runs through faces.
    let frame = |at: f32| -> Vec<Aabb> {
        let corners = (0..512).map(|i| [i % 8, i / 8 % 8, i / 64].map(|x| x as f32 + at));
        corners.map(|min| Aabb::new(min, min.map(|x| x + 1.0))).collect()
    };
    let frames = [frame(0.0), frame(0.0), frame(64.0)];
    assert_eq!(brute_force(&frames[0]).len(), (22_usize.pow(3) - 512) / 2);
    check("grid", &frames);
}

#[test]
fn ties_and_signed_zeros() {
    let mut random = Random(5);
    let mut coordinate = || [-1.0, -0.0, 0.0, 1.0][pick(&mut random, 4)];
    let mut aabb = || {
        let ends = [(); 3].map(|()| (coordinate(), coordinate()));
        // Of two zeros, either may be the minimum.
        Aabb::new(
            ends.map(|(a, b)| if a <= b { a } else { b }),
            ends.map(|(a, b)| if a <= b { b } else { a }),
        )
    };
    let frames: Vec<Vec<Aabb>> = (0..8).map(|_| (0..150).map(|_| aabb()).collect()).collect();
    check("signed zeros", &frames);
}

#[test]
fn endless_and_flat_boxes() {
    const ENDS: [f32; 7] = [f32::NEG_INFINITY, -f32::MAX, -3.0, 0.0, 3.0, f32::MAX, f32::INFINITY];
    let mut random = Random(9);
    let mut aabb = || {
        let ends = [(); 3].map(|()| [pick(&mut random, 7), pick(&mut random, 7)]);
        Aabb::new(ends.map(|[a, b]| ENDS[a.min(b)]), ends.map(|[a, b]| ENDS[a.max(b)]))
    };
    let frames: Vec<Vec<Aabb>> = (0..6).map(|_| (0..120).map(|_| aabb()).collect()).collect();
    check("endless", &frames);
}

#[test]
fn one_plane_among_many_cubes() {
    let mut random = Random(2);
    let mut boxes: Vec<Aabb> = (0..400).map(|_| place(&mut random, 20.0, 1.0, false)).collect();
    boxes[7] = Aabb::new([f32::NEG_INFINITY, -1.0, f32::NEG_INFINITY], [f32::INFINITY, 0.0, f32::INFINITY]);
    check("plane", &[boxes.clone(), boxes]);
}

#[test]
fn nobody_and_somebody() {
    check("nobody", &[vec![], vec![]]);
    check("one", &[vec![Aabb::new([0.0; 3], [1.0; 3])], vec![Aabb::new([5.0; 3], [6.0; 3])]]);
}

#[test]
fn synthetic_scenes() {
    for kind in Kind::ALL {
        for objects in Objects::ALL {
            let mut scene = Synthetic::new(Setup { kind, objects, count: 1200, seed: 4 });
            (0..30).for_each(|_| scene.advance());
            let mut frame = || {
                scene.advance();
                scene.boxes().iter().map(|b| Aabb::new(b.min, b.max)).collect()
            };
            let frames: Vec<Vec<Aabb>> = (0..4).map(|_| frame()).collect();
            check(&format!("{} {}", kind.name(), objects.name()), &frames);
        }
    }
}

#[test]
fn recordings() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    let mut seen = 0;
    for entry in folder.read_dir().expect("the folder of the recordings") {
        let path = entry.expect("an entry").path();
        let recording = Recording::open(&path).expect("a recording");
        let aabb = |b: trisap::Aabb| Aabb::new(b.min, b.max);
        let frames: Vec<Vec<Aabb>> = recording
            .frames()
            .map(Boxes::padded)
            .map(|boxes| (0..boxes.len()).filter_map(|at| boxes.get(at)).map(aabb).collect())
            .collect();
        check(&path.display().to_string(), &frames);
        seen += 1;
    }
    assert!(seen >= 3, "{seen} recordings");
}

#[test]
fn the_tree_is_a_tree() {
    let mut random = Random(3);
    let boxes: Vec<Aabb> = (0..4000).map(|_| place(&mut random, 30.0, 1.0, false)).collect();
    let mut world = World::new(boxes.len(), Settings::default());
    world.step(&boxes);
    let first = world.counts();
    assert!(first.leaves > 4000 / Settings::default().leaf, "{first:?}");
    assert!(first.entries > 4000 && first.entries <= 16_000, "{first:?}");
    assert_eq!((first.moved, first.sorted, first.moves), (4000, 3, 0));
    world.step(&boxes);
    assert_eq!((world.counts().moved, world.counts().leaves), (0, first.leaves));
}

#[test]
#[should_panic = "is no box"]
fn a_box_that_is_not_a_number_is_refused() {
    World::new(1, Settings::default()).step(&[Aabb::new([f32::NAN; 3], [1.0; 3])]);
}
