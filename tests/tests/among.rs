//! Queries among some of the objects: as if the others were not there.

use trisap_core::{Aabb, Boxes, Cast, Config, Filter, Id, Region};
use trisap_tests::doing::On as _;
use trisap_tests::jobs::Jobs;
use trisap_tests::queries::{nearest, overlapping};
use trisap_tests::scenes::{self, Rng};
use trisap_tests::worlds::{Setup, Slab, ample};

/// A random group, mask and class of a few.
fn filter(rng: &mut Rng) -> Filter {
    let class = rng.below(3) as u32;
    Filter { class, ..Filter::groups(1 << rng.below(3), 1 + rng.below(7) as u32) }
}

/// Whether two filters meet, by definition; class 1 does not meet class 2.
fn meet(a: Filter, b: Filter) -> bool {
    let apart = [[1, 2], [2, 1]].contains(&[a.class, b.class]);
    !apart && a.group & b.mask != 0 && b.group & a.mask != 0
}

#[test]
fn others_are_as_if_they_were_not_there() {
    let (mut answers, mut left_out) = (0, 0);
    for setup in Setup::each(&[Jobs::Serial]) {
        // Small, a list and a tree.
        for count in [9, 300, 1500] {
            let rng = &mut Rng::new(count as u64);
            let config = Config::new(ample(count, 100 * count)).with_filters();
            let mut slab = Slab::new::<u32>(&config);
            let mut world = slab.world::<u32>(&config);
            let boxes = scenes::uniform(count, 7);
            let ids: Vec<Id> = world.insert_many(Boxes::new(&boxes)).expect("room").collect();
            let filters: Vec<Filter> = ids.iter().map(|_| filter(rng)).collect();
            for (id, filter) in ids.iter().zip(&filters) {
                world.set_filter(*id, *filter).expect("alive");
            }
            let mut classes = [u32::MAX; 32];
            classes[1] &= !(1 << 2);
            world.set_classes(&classes).expect("filters");
            world.with(setup).step().expect("room");
            for _ in 0..40 {
                let (own, asks) = (ids[rng.below(count)], filter(rng));
                let others: Vec<Option<Aabb>> = (0..count)
                    .map(|at| (ids[at] != own && meet(filters[at], asks)).then_some(boxes[at]))
                    .collect();
                for (id, filter) in ids.iter().zip(&filters) {
                    assert_eq!(world.meets(*id, &asks), meet(*filter, asks));
                }
                let condition = |id: Id| id != own && world.meets(id, &asks);
                let among = world.among(condition);
                let center = world.aabb(own).expect("alive").min;

                let region = Region::Sphere { center, radius: rng.between(0.5, 3.0) };
                let mut out = vec![None; count];
                let found = among.overlaps(&region, &mut out).expect("a good region");
                let slots: Vec<u32> = out[..found].iter().flatten().map(|id| id.slot()).collect();
                assert_eq!(slots, overlapping(&others, &region), "{setup:?} {region:?}");
                answers += found;
                left_out += world.overlaps(&region, &mut out).expect("a good region") - found;

                let mut near = [None; 5];
                let found = among.nearest(center, &mut near).expect("a good point");
                let told: Vec<_> =
                    near[..found].iter().flatten().map(|h| (h.id.slot(), h.distance)).collect();
                assert_eq!(told, nearest(&others, center, 5), "{setup:?}");

                // All hits are tested with the queries.
                let cast = Cast::ray(center, rng.point(-1.0, 1.0), 9.0);
                let mut hits = vec![None; count];
                let met = world.hits(&cast, &mut hits).expect("a good ray");
                let expected: Vec<_> = hits[..met].iter().flatten().filter(|hit| condition(hit.id)).collect();
                let mut out = vec![None; count];
                let found = among.hits(&cast, &mut out).expect("a good ray");
                assert!(out[..found].iter().flatten().eq(expected.iter().copied()), "{setup:?} {cast:?}");
                assert_eq!(among.first_hit(&cast).expect("a good ray").as_ref(), expected.first().copied());
                answers += found;
            }
            assert!(!world.meets(Id::from_bits(7 << 32).expect("an id"), &Filter::ALL), "nobody");
        }
    }
    println!("{answers} answers, {left_out} left out");
    assert!(answers > 150 && left_out > 400);
}

#[test]
fn without_filters_everything_meets_all() {
    let config = Config::new(ample(2, 2));
    let mut slab = Slab::new::<u32>(&config);
    let mut world = slab.world::<u32>(&config);
    let id = world.insert(scenes::cube(0.0, 0.0, 0.0)).expect("room");
    assert!(world.meets(id, &Filter::ALL) && world.meets(id, &Filter::groups(1, 2)));
    assert!(!world.meets(id, &Filter::groups(1, 0)));
    // No object can have it.
    assert!(world.meets(id, &Filter::class(31)) && !world.meets(id, &Filter::class(32)));
}
