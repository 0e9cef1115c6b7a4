//! The counterexamples against the printed text, alone and with many other boxes around that force a tree.

mod common;

use common::{Random, brute_force, check};
use trisap_paper::{Aabb, Settings, World};

fn flat(min: f32, max: f32) -> Aabb {
    Aabb::new([min, 0.0, 0.0], [max, 1.0, 1.0])
}

/// The frames alone, and among 300 resting boxes.
fn alone_and_in_a_crowd(name: &str, frames: &[Vec<Aabb>]) {
    assert!(frames.iter().any(|boxes| !brute_force(boxes).is_empty()), "{name}: no pair to lose");
    check(name, frames);
    let mut random = Random(11);
    let mut corner = || [(); 3].map(|()| 12.0 * (random.unit() - 0.5));
    let crowd = [(); 300].map(|()| corner()).map(|min| Aabb::new(min, min.map(|x| x + 0.7)));
    let frames: Vec<Vec<Aabb>> = frames.iter().map(|boxes| [boxes.as_slice(), &crowd].concat()).collect();
    check(name, &frames);
}

#[test]
fn e1_a_still_box_is_static() {
    let boxes = [flat(0.0, 1.0), flat(0.5, 2.0)];
    let mut world = World::new(2, Settings::default());
    assert_eq!(world.step(&boxes), [[0, 1]]);
    assert_eq!(world.step(&boxes), [[0, 1]]);
    assert_eq!(world.counts().moved, 0);
}

#[test]
fn e2_the_unit_of_length_does_not_matter() {
    for unit in [0.01, 1.0, 1000.0] {
        let boxes = |shift: f32| [Aabb::new([shift * unit; 3], [(1.0 + shift) * unit; 3])];
        let mut world = World::new(1, Settings::default());
        let mut moved = |shift| {
            world.step(&boxes(shift));
            world.counts().moved
        };
        assert_eq!([moved(0.0), moved(0.009), moved(0.02)], [1, 0, 1], "{unit}");
    }
}

#[test]
fn e4_a_cube_falls_across_the_sweep_axis() {
    let cube = |y: f32| Aabb::new([0.0, y, 0.0], [1.0, y + 1.0, 1.0]);
    let floor = Aabb::new([-9.0, -1.0, -9.0], [9.0, 0.0, 9.0]);
    let frames: Vec<Vec<Aabb>> = [3.0, 2.0, 1.0, 0.0].map(|y| vec![floor, cube(y)]).into();
    alone_and_in_a_crowd("fall", &frames);
}

#[test]
fn e5_a_cube_creeps_through_another() {
    let frames: Vec<Vec<Aabb>> = (0..445)
        .step_by(3)
        .map(|step| 0.009 * step as f32 - 2.0)
        .map(|x| vec![flat(x, x + 1.0), flat(0.0, 1.0)])
        .collect();
    alone_and_in_a_crowd("creep", &frames);
    let after = vec![flat(0.009, 1.009), flat(1.005, 2.005)];
    alone_and_in_a_crowd("anchor", &[vec![flat(0.0, 1.0), flat(5.0, 6.0)], after]);
}

#[test]
fn e6_two_resting_cubes_stay_in_contact() {
    // A third one moves, or else no phase would have anything to do.
    let frames: Vec<Vec<Aabb>> =
        [5.0, 6.0, 7.0].map(|x| vec![flat(0.0, 1.0), flat(1.0, 2.0), flat(x, x + 0.5)]).into();
    alone_and_in_a_crowd("rest", &frames);
}

#[test]
fn e7_a_static_box_straddles_a_plane() {
    let before = vec![flat(-1.0, 0.5), flat(3.0, 3.2)];
    alone_and_in_a_crowd("straddler", &[before.clone(), before, vec![flat(-1.0, 0.5), flat(0.2, 0.4)]]);
}

#[test]
fn e8_the_plane_moves_and_the_object_does_not() {
    let boxes = |others: f32| {
        let mut boxes = vec![flat(1.0, 2.0), flat(1.6, 1.9)];
        boxes.extend((0..9).map(|i| flat(others + 0.1 * i as f32, others + 0.1 * i as f32 + 0.05)));
        boxes
    };
    alone_and_in_a_crowd("plane", &[boxes(0.5), boxes(1.1), boxes(-3.0), boxes(1.5)]);
}

#[test]
fn e10_the_minimum_is_the_key() {
    alone_and_in_a_crowd("key", &[vec![flat(0.0, 10.0), flat(1.0, 2.0), flat(3.0, 4.0)]]);
}

#[test]
fn e11_copies_are_few() {
    // Every plane cuts all boxes but a few.
    let long = |at: f32| Aabb::new([at, -at, at], [at + 100.0, 100.0 - at, at + 100.0]);
    let boxes: Vec<Aabb> = (0..300).map(|i| long(i as f32)).collect();
    let mut world = World::new(300, Settings { leaf: 2, margin: 0.0 });
    world.step(&boxes);
    assert!(world.counts().entries <= 1200, "{:?}", world.counts());
    check("long", &[boxes]);
}
