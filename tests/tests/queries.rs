//! Queries in every state that a world can be in: the answers are those of the boxes as they are at that moment.

use trisap_core::{Aabb, Boxes, Cast, Config, Error, Hit, Index, Margin, Mode, Planes, Region, World};
use trisap_tests::checked::Checked;
use trisap_tests::doing::On as _;
use trisap_tests::jobs::Jobs;
use trisap_tests::model::Model;
use trisap_tests::queries::{Counted, Near, Questions, ask_cast, ask_nearest, ask_region, ask_volume};
use trisap_tests::scenes::{self, Rng, cube, shifted};
use trisap_tests::worlds::{Setup, Slab, ample};

/// A few unbounded boxes, some large ones, strips through all of them, and cubes.
fn scene(count: usize, seed: u64) -> Vec<Aabb> {
    let mut boxes = scenes::uniform(count, seed);
    let side = scenes::side(count);
    let (low, high) = (f32::NEG_INFINITY, f32::INFINITY);
    let odd = [
        Aabb::new([low, low, low], [high, high, 0.5]),
        Aabb::new([low, 2.0, low], [high, 2.5, high]),
        Aabb::new([3.0, low, 1.0], [4.0, high, 2.0]),
        Aabb::new([-1.0; 3], [side + 1.0, side + 1.0, 1.5]),
        Aabb::new([side / 2.0; 3], [high; 3]),
        Aabb::new([-1e30; 3], [-1e29; 3]),
        Aabb::new([1.0; 3], [1.0; 3]),
    ];
    for (at, aabb) in odd.into_iter().enumerate().take(count / 9) {
        boxes[at * 9] = aabb;
    }
    for at in (80..count).step_by(10) {
        let (axis, strip) = (at / 10 % 3, &mut boxes[at]);
        (strip.max, strip.min[axis]) = (strip.min.map(|x| x + 0.01), 0.0);
        strip.max[axis] = side;
    }
    boxes
}

/// A world that has never made a step answers from its boxes alone.
fn ask_twin<I: Index>(world: &mut World<'_, I>, model: &Model, questions: &Questions, setup: Setup) {
    let boxes: Vec<Aabb> = model.boxes().iter().map(|aabb| aabb.unwrap_or(cube(0.0, 0.0, 0.0))).collect();
    let config = Config::new(ample(boxes.len(), 0));
    let mut slab = Slab::new::<u32>(&config);
    let mut twin = slab.world::<u32>(&config);
    twin.insert_many(Boxes::new(&boxes)).expect("room for all");
    for slot in (0..boxes.len() as u32).filter(|slot| model.id_at(*slot).is_none()) {
        twin.remove(twin.id_at(slot).expect("just inserted")).expect("alive");
    }
    let near = |hit: &Hit| (hit.id.slot(), hit.distance);
    for cast in &questions.casts {
        let mut one = vec![None; boxes.len()];
        let mut other = one.clone();
        let told: Result<usize, Error> = world.with(setup).hits(cast, &mut one);
        assert_eq!(told, twin.with(setup).hits(cast, &mut other), "{setup:?} {cast:?}");
        let one: Vec<Near> = one.iter().flatten().map(near).collect();
        let other: Vec<Near> = other.iter().flatten().map(near).collect();
        assert_eq!(one, other, "{setup:?} {cast:?}");
    }
}

fn ask<I: Index>(checked: &mut Checked<'_, I>, rng: &mut Rng, setup: Setup) {
    let (world, model) = checked.parts_mut();
    let questions = Questions::about(model, if world.len() > 500 { 9 } else { 24 }, rng);
    questions.ask(world, model, setup);
    questions.ask_batches(world, setup);
    ask_twin(world, model, &questions, setup);
}

/// The life of a world, with questions in each of its states.
fn live<I: Index>(config: Config, count: usize, setup: Setup) {
    let capacity = ample(count + count / 4 + 8, 12 * count + 400);
    let config = setup.configure(config.with_capacity(capacity));
    let mut slab = Slab::new::<I>(&config);
    let mut world = Checked::<I>::new(slab.world(&config));
    let rng = &mut Rng::new(count as u64);
    ask(&mut world, rng, setup);
    let ids = world.insert_many(&scene(count, 1));
    ask(&mut world, rng, setup);
    world.step(setup);
    ask(&mut world, rng, setup);
    // Before the next step, with reused slots.
    world.remove_many(&ids[count / 2..count / 2 + count / 8]);
    ask(&mut world, rng, setup);
    world.insert_many(&scenes::uniform(count / 10, 2));
    let fresh = world.model().ids();
    world.update_many(&fresh[..count / 20], &scene(count, 3)[..count / 20]);
    ask(&mut world, rng, setup);
    world.step(setup);
    ask(&mut world, rng, setup);
    // Calm: nobody moves, few move, and in between there are questions.
    let ids = world.model().ids();
    let mut boxes: Vec<Aabb> = world.model().boxes().iter().map(|b| b.unwrap_or_default()).collect();
    let saved = world.save();
    for calm in 0..8 {
        if calm > 1 {
            let mover = ids[rng.below(ids.len())];
            let (slot, by) = (mover.slot() as usize, rng.point(-2.0, 2.0));
            boxes[slot] = shifted(&boxes[slot], by);
            world.set(mover, boxes[slot]);
            ask(&mut world, rng, setup);
        }
        if calm == 5 {
            let gone = world.insert(cube(1.0, 1.0, 1.0));
            world.step(setup);
            ask(&mut world, rng, setup);
            world.remove(gone);
        }
        world.step(setup);
        if calm % 2 == 1 {
            ask(&mut world, rng, setup);
        }
    }
    let calm = world.save();
    // All move, and inside their margins.
    scenes::walk(&mut boxes, 1000, 1.0, rng);
    world.step_over(&boxes, setup);
    ask(&mut world, rng, setup);
    scenes::walk(&mut boxes, 1000, 0.01, rng);
    world.step_over(&boxes, setup);
    ask(&mut world, rng, setup);
    // Too many pairs.
    let pile = vec![cube(0.0, 0.0, 0.0); boxes.len()];
    if count > 60 {
        world.try_step_over(&pile, setup).expect_err("no room for the pairs of a pile");
        ask(&mut world, rng, setup);
        let some = world.model().ids()[..20].to_vec();
        world.update_many(&some, &boxes[..20]);
        ask(&mut world, rng, setup);
        world.step_over(&boxes, setup);
        ask(&mut world, rng, setup);
    }
    for saved in [saved, calm] {
        world.load(&saved);
        ask(&mut world, rng, setup);
        world.step(setup);
        ask(&mut world, rng, setup);
    }
    let ids = world.model().ids();
    world.remove_many(&ids);
    ask(&mut world, rng, setup);
    world.step(setup);
    ask(&mut world, rng, setup);
}

fn configs() -> [Config; 3] {
    let plain = Config::new(ample(0, 0));
    let margin = plain.with_margin(Margin::length(0.1));
    [plain.with_events(), margin, margin.with_mode(Mode::Fat).with_events()]
}

#[test]
fn small_worlds_answer() {
    for setup in Setup::each(&Jobs::USUAL) {
        for config in configs() {
            live::<u16>(config, 20, setup);
            live::<u32>(config.with_lean(), 150, setup);
            live::<u32>(config, 300, setup);
        }
    }
}

#[test]
fn worlds_with_a_tree_answer() {
    for setup in Setup::each(&Jobs::USUAL) {
        for config in configs() {
            live::<u32>(config, 900, setup);
        }
        live::<u16>(configs()[0], 4200, setup);
    }
}

#[test]
fn every_scene_answers() {
    for setup in Setup::each(&[Jobs::Serial]) {
        for scene in scenes::all(1500, 6) {
            let config = Config::new(ample(1500, 400_000));
            let mut slab = Slab::new::<u32>(&config);
            let mut world = Checked::<u32>::new(slab.world(&config));
            world.insert_many(&scene.boxes);
            for calm in 0..3 {
                world.step(setup);
                ask(&mut world, &mut Rng::new(calm), setup);
            }
        }
    }
}

/// A frustum along the diagonal of 100,000 boxes: objects in nodes that are inside are not asked about.
#[test]
fn what_is_in_a_frustum_is_taken_whole() {
    let rng = &mut Rng::new(7);
    let cube = |_| {
        let low = rng.point(0.0, 200.0);
        Aabb::new(low, low.map(|x| x + 1.0))
    };
    let boxes: Vec<Aabb> = (0..100_000).map(cube).collect();
    let config = Config::new(ample(boxes.len(), 2 * boxes.len()));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    world.insert_many(&boxes);
    world.step(Setup::REFERENCE);
    // From the origin along (1, 1, 1), half a radian to each side.
    let (forward, up, right) = (3f64.sqrt().recip(), 6f64.sqrt().recip(), 2f64.sqrt().recip());
    let (sin, cos) = (0.5f64.sin(), 0.5f64.cos());
    let side = |[x, y, z]: [f64; 3]| {
        let normal = [x, y, z].map(|part| part * cos - forward * sin);
        [normal[0], normal[1], normal[2], 0.0]
    };
    let planes = [
        side([-up, -up, 2.0 * up]),
        side([up, up, -2.0 * up]),
        side([right, -right, 0.0]),
        side([-right, right, 0.0]),
        [forward, forward, forward, 200.0],
        [-forward, -forward, -forward, -0.1],
    ];
    // After a step that found all anew, and in a world that is only asked, whose leaves are divided by and by.
    for (refreshes, tenths) in [(0, 18), (100, 11)] {
        for _ in 0..refreshes {
            world.world_mut().refresh().expect("a world");
        }
        let (asked, model) = world.parts_mut();
        ask_volume(asked, model, &Planes(&planes), Setup::REFERENCE);
        let counted = Counted(&Planes(&planes), Default::default());
        let mut out = vec![None; boxes.len()];
        let answers = asked.within(&counted, &mut out).expect("room") as u64;
        let asked = counted.1.get();
        assert!(answers > 10_000 && asked * 10 <= answers * tenths, "{asked} boxes for {answers} answers");
    }
}

/// Where thousands hold the point, those that come too late are not measured.
#[test]
fn the_nearest_of_a_crowd_are_the_first_slots() {
    for setup in Setup::each(&[Jobs::Serial]) {
        let config = Config::new(ample(3000, 0));
        let mut slab = Slab::new::<u16>(&config);
        let mut world = Checked::<u16>::new(slab.world(&config));
        let rng = &mut Rng::new(3);
        let boxes: Vec<Aabb> = (0..3000)
            .map(|_| {
                let low = rng.point(-1.0, 0.1);
                Aabb::new(low, low.map(|x| x + 1.0))
            })
            .collect();
        world.insert_many(&boxes);
        for _ in 0..2 {
            let (asked, model) = world.parts_mut();
            for count in [1, 8, 100] {
                ask_nearest(asked, model, [0.0; 3], count, setup);
                ask_nearest(asked, model, [0.05, 0.0, 0.5], count, setup);
            }
            world.try_step_over(&boxes, setup).expect_err("no room for the pairs");
        }
    }
}

/// A lattice of cubes that touch: every query below ends exactly where boxes do.
#[test]
fn touching_counts() {
    let boxes = scenes::voxels(10);
    for setup in Setup::each(&[Jobs::Serial]) {
        let config = Config::new(ample(boxes.len(), 20 * boxes.len()));
        let mut slab = Slab::new::<u16>(&config);
        let mut world = Checked::<u16>::new(slab.world(&config));
        world.insert_many(&boxes);
        for calm in 0..3 {
            let (asked, model) = world.parts_mut();
            let mut count = |region: Region| {
                ask_region(asked, model, &region, setup);
                let mut out = vec![None; 1000];
                asked.with(setup).overlaps(&region, &mut out).expect("room for all")
            };
            assert_eq!(count(Region::Point([5.0; 3])), 8);
            assert_eq!(count(Region::Point([5.5, 5.0, 5.5])), 2);
            assert_eq!(count(Region::Aabb(Aabb::new([10.0, 4.0, 4.5], [11.0, 4.5, 4.5]))), 2);
            assert_eq!(count(Region::Aabb(Aabb::new([10.000_001, 4.0, 4.5], [11.0, 4.5, 4.5]))), 0);
            assert_eq!(count(Region::sphere([12.0, 5.5, 5.5], 2.0)), 1);
            assert_eq!(count(Region::sphere([12.0, 5.5, 5.5], 1.999_999_9)), 0);
            assert_eq!(count(Region::sphere([0.0; 3], f32::INFINITY)), 1000);
            assert_eq!(count(Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]).into()), 1000);
            let mut hits = |cast: Cast| {
                ask_cast(asked, model, &cast, setup);
                let mut out = vec![None; 1000];
                asked.with(setup).hits(&cast, &mut out).expect("room for all")
            };
            let along = [[1.0, 0.0, 0.0], [-0.5, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, -1e-3]];
            for direction in along {
                let start = direction.map(|d| {
                    if d > 0.0 {
                        -3.0
                    } else if d < 0.0 {
                        13.0
                    } else {
                        5.0
                    }
                });
                // Along an edge that four cubes share, along a face of two, and through the middle of one.
                assert_eq!(hits(Cast::ray(start, direction, f32::INFINITY)), 40);
                let rest = [0, 1, 2].map(|k| if direction[k] == 0.0 { 5.5 } else { start[k] });
                assert_eq!(hits(Cast::ray(rest, direction, f32::INFINITY)), 10);
                let rim = [0, 1, 2].map(|k| if direction[k] == 0.0 { 10.0 } else { start[k] });
                assert_eq!(hits(Cast::ray(rim, direction, f32::INFINITY)), 10);
                let beyond = [0, 1, 2].map(|k| if direction[k] == 0.0 { 10.000_001 } else { start[k] });
                assert_eq!(hits(Cast::ray(beyond, direction, f32::INFINITY)), 0);
            }
            // Just as far as the first cube, and not quite.
            let ray = Cast::ray([-2.0, 0.5, 0.5], [0.25, 0.0, 0.0], 8.0);
            assert_eq!(hits(ray), 1);
            assert_eq!(hits(Cast { distance: 8.0_f32.next_down(), ..ray }), 0);
            // A diagonal through corners: eight cubes at each of the nine inner ones, one at each end.
            assert_eq!(hits(Cast::ray([-1.0; 3], [1.0; 3], 1e9)), 10 + 9 * 6);
            // Where it starts, without and with a direction.
            assert_eq!(hits(Cast::ray([5.0; 3], [0.0; 3], 7.0)), 8);
            assert_eq!(hits(Cast::ray([5.0; 3], [1.0, 2.0, 3.0], 0.0)), 8);
            assert_eq!(hits(Cast::swept(Aabb::new([4.0; 3], [5.0; 3]), [0.0; 3])), 27);
            assert_eq!(hits(Cast::swept(Aabb::new([4.25; 3], [4.75; 3]), [2.0, 0.0, 0.0])), 3);
            assert_eq!(hits(Cast::swept(Aabb::new([4.25; 3], [4.75; 3]), [0.25, 0.0, 0.0])), 2);
            for (count, point) in [(0, [5.0; 3]), (8, [5.0; 3]), (9, [5.5; 3]), (1005, [-20.0, 3.0, 90.0])] {
                ask_nearest(asked, model, point, count, setup);
            }
            assert!(calm < 3);
            world.step(setup);
        }
    }
}

/// Leaves without any width, where the grid's steps are of no length to speak of, and casts that hardly move on an axis, or are far
/// away.
#[test]
fn casts_meet_a_wall() {
    for flat in 0..3 {
        let side = 30.0;
        let rng = &mut Rng::new(flat as u64);
        let place = |rng: &mut Rng| {
            let mut place = rng.point(0.0, side);
            place[flat] = 0.0;
            place
        };
        let boxes: Vec<Aabb> = (0..900).map(|_| place(rng)).map(|[x, y, z]| cube(x, y, z)).collect();
        let config = Config::new(ample(900, 40_000));
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        world.insert_many(&boxes);
        for calm in 0..10 {
            for setup in Setup::each(&[Jobs::Serial]).into_iter().filter(|_| calm % 3 == 0) {
                for _ in 0..60 {
                    let (mut direction, along) = (rng.point(-1.0, 1.0), rng.below(6));
                    for k in 0..3 {
                        let slow = if along < 3 { 0.0 } else { [1.0, 1.0, 1e-3, 1e-12, 1e-38][rng.below(5)] };
                        direction[k] *= if k == along { 1.0 } else { slow };
                    }
                    let (mut start, away) = (place(rng), [0.5, 2.0, 1e3, 1e7, 1e15, 1e25][rng.below(6)]);
                    for k in 0..3 {
                        start[k] -= away * direction[k];
                    }
                    let distance = [1.5, away, 2.0 * away, f32::INFINITY][rng.below(4)];
                    let (asked, model) = world.parts_mut();
                    ask_cast(asked, model, &Cast::ray(start, direction, distance), setup);
                }
            }
            world.step(Setup::REFERENCE);
        }
    }
}

/// A cast visits nearer leaves before farther ones, whichever way it goes and wherever it starts.
#[test]
fn casts_visit_nearer_leaves_first() {
    const COUNT: usize = 8000;
    let boxes: Vec<Aabb> = (0..COUNT).map(|x| cube(2.0 * x as f32, 0.0, 0.0)).collect();
    let config = Config::new(ample(COUNT, 100));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    world.insert_many(Boxes::new(&boxes)).expect("room for all");
    world.step().expect("no pairs");
    let ends: Vec<f32> = world.leaves().map(|leaf| leaf.cell.min[0]).collect();
    assert!(ends.len() >= 8 && ends.is_sorted(), "leaves side by side");
    let leaf_of = |slot: u32| ends.partition_point(|end| *end <= boxes[slot as usize].min[0]);
    for setup in Setup::each(&[Jobs::Serial]) {
        let world = &*world.with(setup);
        for start in [-10.0, 1500.5, 8400.5, 15_500.5, 16_010.0] {
            for direction in [1.0, -1.0] {
                let cast = Cast::ray([start, 0.5, 0.5], [direction, 0.0, 0.0], f32::INFINITY);
                let mut leaves = Vec::new();
                let mut visit = |hit: Hit| {
                    leaves.push(leaf_of(hit.id.slot()));
                    f64::INFINITY
                };
                world.visit_hits(&cast, &mut visit).expect("a good cast");
                if direction < 0.0 {
                    leaves.reverse();
                }
                assert!(leaves.is_sorted(), "{setup:?}: from {start} by {direction}: {leaves:?}");
            }
        }
    }
}

/// Along an axis, so that the other two alone decide, from where a step of the grid is nothing.
#[test]
fn rays_come_from_far_away() {
    let config = Config::new(ample(900, 40_000));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    let (boxes, side) = (scenes::uniform(900, 4), scenes::side(900));
    world.insert_many(Boxes::new(&boxes)).expect("room for all");
    let rng = &mut Rng::new(9);
    for _ in 0..10 {
        world.set_kernels(Setup::REFERENCE.kernels).on(&Jobs::Serial).step().expect("room for the pairs");
    }
    for setup in Setup::each(&[Jobs::Serial]) {
        for away in [1.0, 1e10, 1e20, 1e30, 1e31, 1e32, 1e33, 1e34, 1e35, 1e38] {
            for axis in 0..3 {
                let (mut start, mut direction) = (rng.point(0.0, side), [0.0f32; 3]);
                direction[axis] = [1.0f32, -1.0, 0.3][rng.below(3)];
                start[axis] = side / 2.0 - direction[axis].signum() * (side + away);
                let meets = |aabb: &&Aabb| {
                    (0..3).all(|k| k == axis || aabb.min[k] <= start[k] && start[k] <= aabb.max[k])
                };
                let ray = Cast::ray(start, direction, f32::INFINITY);
                let met = world.with(setup).hits(&ray, &mut [None; 900]);
                assert_eq!(met, Ok(boxes.iter().filter(meets).count()), "{setup:?} {ray:?}");
            }
        }
    }
}

#[test]
fn bad_queries_are_refused() {
    let config = Config::new(ample(8, 8));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    world.insert(cube(0.0, 0.0, 0.0)).expect("room");
    let kernels = Setup::REFERENCE.kernels;
    let bad = Error::BadQuery { index: 0 };
    let mut regions = vec![
        Region::Aabb(Aabb::new([1.0, 0.0, 0.0], [0.0, 1.0, 1.0])),
        Region::Sphere { center: [0.0; 3], radius: -1.0 },
        Region::Sphere { center: [0.0; 3], radius: f32::NAN },
    ];
    let ray = Cast::ray([0.0; 3], [1.0, 0.0, 0.0], 1.0);
    let mut casts = vec![
        Cast { distance: -1.0, ..ray },
        Cast { distance: f32::NAN, ..ray },
        Cast { start: Aabb::new([1.0; 3], [0.0; 3]), ..ray },
    ];
    for k in 0..3 {
        let with = |x: f32| {
            let mut point = [0.0; 3];
            point[k] = x;
            point
        };
        regions.push(Region::Point(with(f32::NAN)));
        regions.push(Region::Aabb(Aabb::new(with(f32::NAN), [1.0; 3])));
        regions.push(Region::Aabb(Aabb::new([-1.0; 3], with(f32::NAN))));
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            regions.push(Region::Sphere { center: with(x), radius: 1.0 });
            casts.push(Cast::ray(with(x), [1.0; 3], 1.0));
            casts.push(Cast::ray([0.0; 3], with(x), 1.0));
            casts.push(Cast::swept(Aabb::new([-1.0; 3], with(x)), [1.0; 3]));
            assert_eq!(world.set_kernels(kernels).nearest(with(x), &mut [None]), Err(bad));
            let visited = world.visit_nearest(with(x), 1.0, &mut |_| panic!("nothing is answered"));
            assert_eq!(visited, Err(bad));
        }
    }
    let good = Region::Point([0.5; 3]);
    for region in regions {
        assert_eq!(world.set_kernels(kernels).overlaps(&region, &mut [None]), Err(bad), "{region:?}");
        let visited =
            world.set_kernels(kernels).visit_overlaps(&region, &mut |_| panic!("nothing is answered"));
        assert_eq!(visited, Err(bad), "{region:?}");
        let (mut out, mut ends) = ([None; 9], [7; 3]);
        let batch = [good, good, region];
        let told = world.set_kernels(kernels).among(|_| true).overlaps_many(
            &batch,
            &Jobs::Threads(2),
            &mut out,
            &mut ends,
        );
        assert_eq!(told, Err(Error::BadQuery { index: 2 }));
        assert_eq!((out, ends), ([None; 9], [7; 3]), "nothing is written");
    }
    for cast in casts {
        assert_eq!(world.set_kernels(kernels).first_hit(&cast), Err(bad), "{cast:?}");
        assert_eq!(world.set_kernels(kernels).hits(&cast, &mut [None]), Err(bad), "{cast:?}");
        assert_eq!(
            world.set_kernels(kernels).visit_hits(&cast, &mut |_| panic!("nothing is answered")),
            Err(bad),
            "{cast:?}"
        );
        let mut out = [None; 2];
        let told =
            world.set_kernels(kernels).among(|_| true).first_hits(&[ray, cast], &Jobs::Serial, &mut out);
        assert_eq!((told, out), (Err(Error::BadQuery { index: 1 }), [None; 2]));
    }
    for distance in [f64::NAN, -1.0, f64::NEG_INFINITY] {
        let visited = world.visit_nearest([0.0; 3], distance, &mut |_| panic!("nothing is answered"));
        assert_eq!(visited, Err(bad), "{distance}");
    }
    let short = Error::LengthMismatch { needed: 2, given: 1 };
    let told = world.set_kernels(kernels).among(|_| true).first_hits(&[ray, ray], &Jobs::Serial, &mut [None]);
    assert_eq!(told, Err(short));
    let told = world.set_kernels(kernels).among(|_| true).overlaps_many(
        &[good, good],
        &Jobs::Serial,
        &mut [None; 4],
        &mut [0],
    );
    assert_eq!(told, Err(short));
    // Nothing asked is nothing answered.
    assert_eq!(world.set_kernels(kernels).among(|_| true).first_hits(&[], &Jobs::Serial, &mut []), Ok(()));
    assert_eq!(
        world.set_kernels(kernels).among(|_| true).overlaps_many(&[], &Jobs::Serial, &mut [], &mut []),
        Ok(0)
    );
}

/// Any executor, more queries than a block, and the same answers as one by one.
#[test]
fn batches_are_the_same_under_every_executor() {
    let every: Vec<Jobs> = Jobs::ALL.into_iter().chain(Jobs::PERVERSE).chain([Jobs::Helping(3)]).collect();
    let config = Config::new(ample(2000, 40_000));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = Checked::<u32>::new(slab.world(&config));
    world.insert_many(&scene(2000, 8));
    world.step(Setup::REFERENCE);
    for count in [1, 31, 32, 33, 300] {
        let questions = Questions::about(world.model(), count, &mut Rng::new(count as u64));
        for setup in Setup::each(&every) {
            questions.ask_batches(world.world_mut(), setup);
        }
    }
}

/// A leaf that was empty in a full step has no box; who moves into it gives it one, with both its sides.
#[test]
fn a_leaf_that_was_empty_is_found_again() {
    let count = 3000;
    for setup in Setup::each(&Jobs::USUAL).into_iter().step_by(3) {
        let config =
            setup.configure(Config::new(ample(count, 12 * count)).without_predicted_boxes().with_events());
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        let mut boxes = scenes::uniform(count, 5);
        let ids = world.insert_many(&boxes);
        world.step(setup);
        let inside = |cell: &Aabb, aabb: &Aabb| {
            (0..3).all(|k| cell.min[k] <= aabb.min[k] && aabb.min[k] < cell.max[k])
        };
        let cell = world.world().leaves().next().expect("there is a tree").cell;
        let (gone, left): (Vec<_>, Vec<_>) =
            ids.into_iter().partition(|id| inside(&cell, &boxes[id.slot() as usize]));
        assert!(gone.len() > 8, "the leaf is not empty");
        world.remove_many(&gone);
        // All move a little, so that the step is a full one.
        let moved: Vec<Aabb> = left.iter().map(|id| shifted(&boxes[id.slot() as usize], [1e-3; 3])).collect();
        world.update_many(&left, &moved);
        world.step(setup);
        assert!(world.world().leaves().any(|leaf| leaf.cell == cell && leaf.objects == 0), "it is empty now");
        let rng = &mut Rng::new(7);
        for id in left.iter().step_by(left.len() / 4) {
            let slot = id.slot() as usize;
            let place = |k: usize| rng.between(cell.min[k].max(0.0), cell.max[k].min(scenes::side(count)));
            boxes[slot] = shifted(&cube(0.0, 0.0, 0.0), [0, 1, 2].map(place));
            world.set(*id, boxes[slot]);
            world.step(setup);
            let (asked, model) = world.parts_mut();
            ask_region(asked, model, &Region::Aabb(boxes[slot]), setup);
            let far = boxes[slot].min.map(|x| x - 50.0);
            ask_cast(asked, model, &Cast::ray(far, [1.0, 1.0, 1.0], 1e3), setup);
            ask_nearest(asked, model, boxes[slot].min, 3, setup);
        }
    }
}

/// Calm worlds divide their leaves some in each step: answers, pairs and snapshots are right all the way, and back.
#[test]
fn leaves_are_divided_step_by_step() {
    let count = 5000;
    for setup in Setup::each(&Jobs::USUAL).into_iter().step_by(3) {
        for margin in [None, Some(Margin::length(0.1))] {
            let mut config = setup.configure(Config::new(ample(count, 12 * count)).with_events());
            config.margin = margin;
            let mut slab = Slab::new::<u32>(&config);
            let mut world = Checked::<u32>::new(slab.world(&config));
            let ids = world.insert_many(&scene(count, 4));
            let rng = &mut Rng::new(8);
            let mut leaves = Vec::new();
            for frame in 0..10 {
                for _ in 0..frame * 2 {
                    let id = ids[rng.below(ids.len())];
                    let aabb = world.model().aabb(id.slot()).expect("alive");
                    world.set(id, shifted(&aabb, rng.point(-9.0, 9.0)));
                }
                world.step(setup);
                ask(&mut world, rng, setup);
                leaves.push(world.world().leaves().filter(|leaf| leaf.objects > 0).count());
            }
            assert!(leaves[1] < leaves[3] && leaves[3] < leaves[5], "some in each step: {leaves:?}");
            assert!(leaves[9] > 6 * leaves[1], "all in the end: {leaves:?}");
            let mut boxes = scene(count, 4);
            scenes::walk(&mut boxes, 1000, 1.0, rng);
            world.step_over(&boxes, setup);
            ask(&mut world, rng, setup);
            let few = world.world().leaves().filter(|leaf| leaf.objects > 0).count();
            assert!(few < 2 * leaves[0], "{few} after {leaves:?}");
            let saved = world.save();
            world.load(&saved);
            ask(&mut world, rng, setup);
        }
    }
}

/// Of two that are so far away that their distances are one number, `nearest` tells the nearer one first, by the squares; a visitor
/// is told the same distance of both.
#[test]
fn distances_that_round_to_one_number() {
    const FAR: f32 = 33_554_432.0;
    let point = |y: f32| Aabb::new([FAR, y, 0.0], [FAR, y, 0.0]);
    for (setup, count) in
        Setup::each(&[Jobs::Serial]).into_iter().flat_map(|setup| [(setup, 2), (setup, 900)])
    {
        let config = Config::new(ample(count, 10 * count));
        let mut slab = Slab::new::<u32>(&config);
        let mut world = Checked::<u32>::new(slab.world(&config));
        let mut boxes = vec![point(0.5), point(0.0)];
        boxes.extend((2..count).map(|k| scenes::at([2.0 * FAR + 64.0 * k as f32, 0.0, 0.0], [8.0; 3])));
        world.insert_many(&boxes);
        world.step(setup);
        let (asked, model) = world.parts_mut();
        let mut hits = [None; 2];
        assert_eq!(asked.nearest([0.0; 3], &mut hits), Ok(2));
        assert_eq!(
            hits.map(|hit| hit.map(|hit| (hit.id.slot(), hit.distance))),
            [1, 0].map(|slot| Some((slot, f64::from(FAR))))
        );
        ask_nearest(asked, model, [0.0; 3], 2, setup);
        ask_nearest(asked, model, [0.0; 3], 1, setup);
    }
}
