use super::*;
use crate::pool::Rayon;

fn boxes(count: usize, seed: u64, side: f32) -> Vec<Aabb> {
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let corner = |random: &mut dyn FnMut() -> f32| [(); 3].map(|()| random() * side);
    (0..count)
        .map(|_| {
            let low = corner(&mut random);
            Aabb::new(low, low.map(|x| x + 0.5 + random()))
        })
        .collect()
}

fn brute(a: &[Aabb], b: &[Aabb], itself: bool) -> Vec<[u32; 2]> {
    let from = |i: usize| if itself { i + 1 } else { 0 };
    let pair = |i: usize| {
        (from(i)..b.len()).filter(move |&j| a[i].overlaps(&b[j])).map(move |j| [i as u32, j as u32])
    };
    (0..a.len()).flat_map(pair).collect()
}

fn sorted(mut pairs: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    pairs.sort_unstable();
    pairs
}

#[test]
fn pairs_are_those_of_brute_force() -> Result<(), Error> {
    let (mut scratch, executor) = (Scratch::new(), Rayon::global());
    for (count, side) in [
        (0, 1.0),
        (1, 1.0),
        (2, 1.0),
        (60, 3.0),
        (300, 9.0),
        (3000, 14.0),
        (200, 1.0),
        (5000, 30.0),
        (700, 2.0),
    ] {
        let (a, b) = (boxes(count, 1, side), boxes(count / 3 + 1, 2, side));
        let want = brute(&a, &a, true);
        assert_eq!(sorted(pairs(&a)?), want, "{count}");
        assert_eq!(sorted(scratch.pairs(&a)?.collect()), want, "{count}");
        assert_eq!(sorted(scratch.on(&executor).pairs(a.iter().copied())?.to_vec()), want, "{count}");
        let want = brute(&a, &b, false);
        assert_eq!(sorted(pairs_between(&a, &b)?), want, "{count}");
        assert_eq!(sorted(scratch.on(&executor).pairs_between(&a, &b)?.collect()), want, "{count}");
    }
    Ok(())
}

/// More pairs than room is set aside for.
#[test]
fn a_heap_needs_no_room_of_the_callers() -> Result<(), Error> {
    let (heap, mut scratch) = (vec![[0.0f32, 0.0, 0.0, 1.0, 1.0, 1.0]; 1000], Scratch::new());
    for _ in 0..2 {
        assert_eq!(scratch.pairs(&heap)?.len(), 1000 * 999 / 2);
        assert_eq!(scratch.pairs_between(&heap[..400], &heap[400..])?.len(), 400 * 600);
        assert_eq!(scratch.pairs(&heap[..1])?.len(), 0);
    }
    Ok(())
}

#[test]
fn a_bad_box_is_named() {
    let mut all = boxes(700, 3, 9.0);
    all[650].max[1] = f32::NAN;
    assert_eq!(pairs(&all), Err(Error::BadBox { index: 650 }));
    assert_eq!(pairs_between(&all[..300], &all[300..]), Err(Error::BadBox { index: 650 }));
    let mut scratch = Scratch::new();
    assert!(scratch.pairs(&all).is_err());
    all.truncate(600);
    assert_eq!(sorted(scratch.pairs(&all).expect("good boxes").collect()), brute(&all, &all, true));
}

/// Boxes that touch in `f64` touch in `f32`, too.
#[test]
fn boxes_in_f64_are_rounded_outward() -> Result<(), Error> {
    let third = 1.0 / 3.0;
    let touching = [[0.0, 0.0, 0.0, third, 1.0, 1.0], [third, 0.0, 0.0, 1.0, 1.0, 1.0]];
    assert_eq!(pairs(touching)?, [[0, 1]]);
    Ok(())
}

/// From 65,536 boxes on, planes are those of a sample: boxes anywhere, in a layer, on a line, at few places, and large ones among
/// small ones.
#[test]
fn many_boxes_are_placed_by_a_sample() -> Result<(), Error> {
    let (mut scratch, executor) = (Scratch::new(), Rayon::global());
    let shapes: [fn(usize, Aabb) -> Aabb; 5] = [
        |_, aabb| aabb,
        |_, Aabb { min: [x, y, _], max: [u, v, _] }| {
            Aabb::new([x * 9.0, y * 9.0, 0.0], [x * 9.0 + u - x, y * 9.0 + v - y, 0.0])
        },
        |_, Aabb { min: [x, ..], max: [u, ..] }| {
            Aabb::new([x * 900.0, 0.0, 0.0], [x * 900.0 + u - x, 0.0, 0.0])
        },
        |at, _| Aabb::new([(at / 5) as f32, 0.0, 0.0], [(at / 5) as f32, 1.0, 1.0]),
        |at, Aabb { min, max }| {
            if at % 7 == 0 { Aabb::new(min, max.map(|x| x + 3.0)) } else { Aabb::new(min, min) }
        },
    ];
    for (number, shape) in shapes.into_iter().enumerate() {
        let boxes: Vec<_> =
            boxes(70_000, 5, 60.0).into_iter().enumerate().map(|(at, aabb)| shape(at, aabb)).collect();
        let found = pairs(&boxes)?;
        assert_eq!(
            scratch.on(&executor).pairs(&boxes)?.to_vec(),
            found,
            "shape {number}: the same for any workers"
        );
        assert_eq!(sorted(found), swept(&boxes), "shape {number}");
    }
    Ok(())
}

/// An own sweep along x.
fn swept(boxes: &[Aabb]) -> Vec<[u32; 2]> {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let of = |at: u32| &boxes[at as usize];
    order.sort_by(|&a, &b| of(a).min[0].total_cmp(&of(b).min[0]));
    let mut pairs = Vec::new();
    for (rank, &a) in order.iter().enumerate() {
        let near = order[rank + 1..].iter().take_while(|&&b| of(b).min[0] <= of(a).max[0]);
        pairs.extend(near.filter(|&&b| of(a).overlaps(of(b))).map(|&b| [a.min(b), a.max(b)]));
    }
    sorted(pairs)
}
