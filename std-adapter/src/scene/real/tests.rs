//! What all kinds have in common, and what each one promises.

use super::*;

const SEED: u64 = 11;

fn scene(kind: Kind, count: u32) -> Scene {
    Scene::new(Setup { kind, count, seed: SEED }).expect("a good number of boxes")
}

/// The boxes of the first frames.
fn frames(kind: Kind, count: u32, frames: u32) -> Vec<Vec<Aabb>> {
    let mut scene = scene(kind, count);
    let mut next = |at| {
        assert_eq!(scene.frame(), at);
        let boxes = scene.boxes().to_vec();
        scene.advance();
        boxes
    };
    (0..frames).map(&mut next).collect()
}

/// By a sweep along x.
fn pairs(boxes: &[Aabb]) -> usize {
    let mut sorted = boxes.to_vec();
    sorted.sort_by(|a, b| a.min[0].total_cmp(&b.min[0]));
    let meets = |at: usize| {
        let a = sorted[at];
        let later = sorted[at + 1..].iter().take_while(move |b| b.min[0] <= a.max[0]);
        later.filter(|b| b.overlaps(&a)).count()
    };
    (0..sorted.len()).map(meets).sum()
}

fn edges(aabb: &Aabb) -> [f32; 3] {
    [0, 1, 2].map(|k| aabb.max[k] - aabb.min[k])
}

/// The greatest edge.
fn length(aabb: &Aabb) -> f32 {
    edges(aabb).into_iter().fold(0.0, f32::max)
}

/// How many boxes are not those of the frame before.
fn moved(before: &[Aabb], after: &[Aabb]) -> usize {
    before.iter().zip(after).filter(|(a, b)| a != b).count()
}

/// For how many of the boxes this is so.
fn count(boxes: &[Aabb], of: impl Fn(&Aabb) -> bool) -> usize {
    boxes.iter().filter(|aabb| of(aabb)).count()
}

#[test]
fn the_same_seed_gives_the_same_boxes() {
    for kind in Kind::ALL {
        for count in [*kind.counts().start(), 700] {
            let (mut a, mut b) = (scene(kind, count), scene(kind, count));
            let mut other = Scene::new(Setup { seed: 12, ..*a.setup() }).expect("a good number of boxes");
            for _ in 0..12 {
                assert_eq!(a.boxes(), b.boxes());
                assert_ne!(a.boxes(), other.boxes(), "{kind} {count}");
                for scene in [&mut a, &mut b, &mut other] {
                    scene.advance();
                }
            }
        }
    }
}

/// FNV-1a over the bits of all boxes.
fn hash(boxes: &[Aabb]) -> u64 {
    let words = boxes.iter().flat_map(|aabb| aabb.min.into_iter().chain(aabb.max));
    words
        .flat_map(f32::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[test]
fn the_boxes_are_those_of_all_releases_and_platforms() {
    let hashes = Kind::ALL.map(|kind| hash(&frames(kind, 300, 20)[19]));
    let known = [
        0xbc48_6d4d_9def_c11b,
        0xe7e3_3e8e_de65_72e8,
        0x3a53_78e0_046f_1b88,
        0x385d_aad2_c3f3_c328,
        0x7244_f081_5fe6_f518,
        0x84f7_fd68_1651_d40b,
        0x4b2e_0f7f_81eb_8194,
        0x532c_bfdb_352a_3eba,
        0x5ef0_e40e_b16c_27e8,
        0x58e3_9576_1a38_4cc5,
        0x2b57_f5d4_a713_466e,
        0x092b_cc23_d42b_86a4,
        0x16b0_f985_aae6_e3e4,
        0x02ba_7f42_6ce7_3452,
    ];
    assert_eq!(hashes, known, "{hashes:#018x?}");
}

#[test]
fn every_box_is_valid_in_every_frame() {
    for kind in Kind::ALL {
        for count in [*kind.counts().start(), 101, 700] {
            for boxes in frames(kind, count, 40) {
                assert_eq!(boxes.len(), count as usize, "{kind}");
                assert!(boxes.iter().all(Aabb::is_valid), "{kind}");
                let is_endless = |aabb: &Aabb| !aabb.min.iter().chain(&aabb.max).all(|x| x.is_finite());
                let endless = boxes.iter().filter(|aabb| is_endless(aabb)).count();
                assert_eq!(endless, usize::from(kind == Kind::Ground(Ground::Infinite)), "{kind}");
            }
        }
    }
}

#[test]
fn pairs_are_as_many_as_promised() {
    for (kind, range) in Kind::ALL.into_iter().zip([
        0.05..0.2,
        1.0..1.2,
        1.0..1.2,
        1.0..1.2,
        2.0..4.0,
        1.5..3.0,
        7.0..11.0,
        1.5..4.0,
        3.0..5.0,
        0.4..0.7,
        0.3..0.6,
        0.3..0.6,
        0.5..1.0,
        0.7..1.2,
    ]) {
        for count in [700, 10_000] {
            let frames = frames(kind, count, 25);
            for at in [HITCH_FRAME - 1, HITCH_FRAME + 1, 24] {
                let an_object = pairs(&frames[at as usize]) as f64 / f64::from(count);
                assert!(range.contains(&an_object), "{kind} {count}: {an_object}");
            }
        }
    }
}

#[test]
fn numbers_of_boxes_that_cannot_be_are_refused() {
    for kind in Kind::ALL {
        let (least, most) = (*kind.counts().start(), *kind.counts().end());
        for count in [0, least - 1, most + 1, u32::MAX] {
            let error = Scene::new(Setup { kind, count, seed: 1 }).expect_err("a bad number of boxes");
            assert!(error.to_string().contains(kind.name()), "{error}");
        }
        assert_eq!(scene(kind, least).boxes().len(), least as usize);
    }
    let setup = Setup { kind: Kind::Town, count: 10, seed: 1 };
    assert_eq!(BadCount { setup }.to_string(), "the scene 'town' has 100 to 134217728 boxes, not 10");
}

#[test]
fn names_lead_to_their_kinds() {
    for kind in Kind::ALL {
        assert_eq!(Kind::by_name(kind.name()), Some(kind));
    }
    assert_eq!(Kind::by_name("ground"), Some(Kind::Ground(Ground::Pile)));
    assert_eq!(Kind::by_name("moon"), None);
}

#[test]
fn all_cubes_touch_the_ground() {
    for (kind, edge) in [(Ground::Pile, 54.0), (Ground::Wide, 2e4), (Ground::Infinite, f32::INFINITY)] {
        for boxes in frames(Kind::Ground(kind), 700, 5) {
            let ([ground], cubes) = boxes.split_at(1) else { panic!("no ground") };
            assert_eq!(edges(ground), [edge, 1.0, edge]);
            assert!(cubes.iter().all(|cube| cube.overlaps(ground) && (cube.max[1] - 1.0).abs() < 0.02));
        }
    }
    assert!(frames(Kind::Ground(Ground::None), 700, 1)[0].iter().all(|cube| length(cube) < 1.001));
}

#[test]
fn a_pile_creeps() {
    let frames = frames(Kind::Pile, 700, 9);
    for two in frames.windows(2) {
        for (a, b) in two[0].iter().zip(&two[1]) {
            let way = (0..3).map(|k| (a.min[k] - b.min[k]).powi(2)).sum::<f32>().sqrt();
            assert!(way < 0.0501 && (edges(a)[0] - 1.0).abs() < 1e-4, "{way} {a:?}");
        }
        assert!(moved(&two[0], &two[1]) > 690);
    }
}

#[test]
fn half_of_the_actors_of_a_town_rest() {
    let frames = frames(Kind::Town, 5000, 3);
    let moved = moved(&frames[1], &frames[2]);
    assert!((1700..1800).contains(&moved), "{moved} of 3,500 actors moved");
}

#[test]
fn log_normal_sizes_are_of_three_decades() {
    let boxes = &frames(Kind::LogNormal, 20_000, 1)[0];
    // Where a box stands, its edges are rounded.
    assert!(boxes.iter().all(|aabb| (0.031..31.7).contains(&length(aabb))));
    let below = |edge: f32| count(boxes, |aabb| length(aabb) < edge) as f64 / 20_000.0;
    assert!((0.48..0.52).contains(&below(1.0)) && below(0.1) > 0.015 && below(10.0) < 0.985);
}

#[test]
fn grains_have_three_radii() {
    let boxes = &frames(Kind::Grains, 3000, 4)[3];
    for radius in heaps::RADII {
        let found = count(boxes, |aabb| (length(aabb) - 2.0 * radius).abs() < 1e-4);
        assert!((900..1100).contains(&found), "{found} of radius {radius}");
    }
}

#[test]
fn one_in_twenty_is_a_bullet() {
    for boxes in &frames(Kind::Bullets, 1000, 10) {
        let is_cube = |aabb: &Aabb| edges(aabb).iter().all(|edge| (edge - 1.0).abs() < 1e-4);
        let bullets = count(boxes, |aabb| !is_cube(aabb));
        assert_eq!(bullets, 50);
        assert!(count(boxes, |aabb| length(aabb) > 2.0) > 40);
        assert!(boxes.iter().all(|aabb| length(aabb) < 10.2));
    }
}

#[test]
fn spawned_boxes_are_in_one_place_and_then_spread() {
    let frames = frames(Kind::Spawn, 700, 12);
    assert!(frames[0].iter().all(|aabb| *aabb == frames[0][0]));
    let spread = |boxes: &[Aabb]| {
        let (low, high) = boxes
            .iter()
            .fold((f32::MAX, f32::MIN), |(low, high), aabb| (low.min(aabb.min[0]), high.max(aabb.max[0])));
        high - low
    };
    let side = 7000_f32.cbrt();
    assert!(spread(&frames[1]) < 0.5 * side);
    assert!(frames[SPREAD_FRAMES as usize..].iter().all(|boxes| spread(boxes) > 0.9 * side));
    // Too many for one place.
    let mut starts = self::frames(Kind::Spawn, 10_000, 1).remove(0);
    starts.dedup();
    assert_eq!(starts.len(), 2);
}

#[test]
fn boxes_are_large_in_one_frame() {
    for (at, boxes) in frames(Kind::Hitch, 700, 20).iter().enumerate() {
        let large = count(boxes, |aabb| length(aabb) > 1.1);
        if at == HITCH_FRAME as usize {
            assert!(large > 690 && boxes.iter().all(|aabb| length(aabb) < 1.01 + 24.0 * 0.75), "{large}");
            let an_object = pairs(boxes) as f64 / 700.0;
            assert!((60.0..150.0).contains(&an_object), "{an_object}");
            let edge = boxes.iter().flat_map(edges).sum::<f32>() / 2100.0;
            assert!((6.0..8.0).contains(&edge), "{edge}");
        } else {
            assert_eq!(large, 0, "frame {at}");
        }
    }
}

#[test]
fn a_flat_world_has_no_depth() {
    for boxes in frames(Kind::Flat, 700, 10) {
        assert!(boxes.iter().all(|aabb| aabb.min[2] == 0.0 && aabb.max[2] == 0.0));
    }
}

#[test]
fn nearly_all_cars_are_parked() {
    for (cars, driving) in [(1, 1), (200, 1), (5000, 25)] {
        let frames = frames(Kind::Parking, cars, 3);
        assert_eq!(moved(&frames[0], &frames[1]), driving);
        assert_eq!(moved(&frames[1], &frames[2]), driving);
    }
}
