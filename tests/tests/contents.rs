//! What can be asked of a world and of a box beside its pairs.

use trisap_core::{Aabb, Capacity, Config, Margin, World};
use trisap_tests::checked::Checked;
use trisap_tests::lives::configs;
use trisap_tests::scenes::{self, Rng};
use trisap_tests::worlds::{Setup, Slab, ample};

#[test]
fn a_cleared_world_loses_all_pairs_and_knows_no_id() {
    for config in configs() {
        let config = config.with_capacity(ample(60, 900)).with_events();
        let mut slab = Slab::new::<u32>(&config);
        let mut checked = Checked::<u32>::new(slab.world(&config));
        let ids = checked.insert_many(&scenes::uniform(60, 3));
        checked.remove(ids[7]);
        let before = checked.step(Setup::REFERENCE);
        assert!(!before.pairs.is_empty());
        checked.world_mut().clear();
        for id in checked.model().ids() {
            checked.model_mut().remove(id);
        }
        checked.check();
        assert!(checked.world().is_empty() && ids.iter().all(|id| !checked.world().contains(*id)));
        let after = checked.step(Setup::REFERENCE);
        assert_eq!((after.lost.len(), after.pairs.len()), (before.pairs.len(), 0));
        checked.insert_many(&scenes::uniform(60, 3));
        checked.step(Setup::REFERENCE);
    }
}

#[test]
fn a_world_tells_what_it_has() {
    let config = Config::new(Capacity::for_objects(8)).with_margin(Margin::length(0.5)).with_events();
    let mut slab = Slab::new::<u16>(&config);
    let mut world: World<'_, u16> = slab.world(&config);
    let ids = [0.0, 0.5, 1.0, 5.0].map(|x| world.insert(scenes::cube(x, 0.0, 0.0)).expect("room"));
    world.set_margin(ids[1], 0.25).expect("alive");
    assert_eq!(ids.map(|id| world.margin(id)), [Some(0.5), Some(0.25), Some(0.5), Some(0.5)]);
    assert_eq!(world.capacity(), config.capacity);
    let step = world.step().expect("room");
    let told = format!("{step:?}");
    assert!(
        told.starts_with("Step { world: World { len: 4, pairs: 3, found: 3, lost: 0, config: Config {"),
        "{told}"
    );
    assert!(told.ends_with("rejected: None }"), "{told}");
    let mut met: Vec<_> = world.pairs_of(ids[1]).collect();
    met.sort_unstable();
    assert_eq!(met, [ids[0], ids[2]]);
    assert_eq!(world.pairs_of(ids[3]).count(), 0);
    assert!(
        format!("{world:?}").starts_with("World { len: 4, pairs: 3, found: 3, lost: 0, config: Config {")
    );
    assert!(world.iter().map(|(id, _)| id).eq(ids));
    world.remove(ids[0]).expect("alive");
    assert_eq!(world.margin(ids[0]), None);
    assert_eq!(world.pair_ids().count(), 1, "without the pairs of who is no more");
    assert_eq!(Config::default(), Config::new(Capacity::for_objects(1024)));
}

/// Against corners one by one.
#[test]
fn boxes_make_boxes() {
    let mut rng = Rng::new(5);
    for _ in 0..1000 {
        // On a lattice, where sums are exact.
        let mut number = || rng.below(33) as f32 * 0.25 - 4.0;
        let mut aabb = || {
            let (a, b) = ([(); 3].map(|()| number()), [(); 3].map(|()| number()));
            Aabb::new([0, 1, 2].map(|k| a[k].min(b[k])), [0, 1, 2].map(|k| a[k].max(b[k])))
        };
        let (a, b) = (aabb(), aabb());
        let both = a.union(&b);
        assert!(both.contains(&a) && both.contains(&b) && both == b.union(&a));
        for k in 0..3 {
            assert!(both.min[k] == a.min[k] || both.min[k] == b.min[k]);
            assert!(both.max[k] == a.max[k] || both.max[k] == b.max[k]);
        }
        assert_eq!(a.contains(&b), a.union(&b) == a);
        assert_eq!(Aabb::from_center(a.center(), a.extents().map(|side| side * 0.5)), a);
        assert_eq!(a.grown(0.5).grown(-0.5), a);
        assert!(a.grown(0.5).contains(&a) && !a.contains(&a.grown(0.5)));
        assert_eq!(a.translated(b.min).translated(b.min.map(|x| -x)), a);
        assert_eq!(a.translated(b.min).extents(), a.extents());
    }
    assert!(!Aabb::new([f32::NAN; 3], [1.0; 3]).contains(&Aabb::default()));
}
