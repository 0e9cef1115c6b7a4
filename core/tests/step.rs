//! Steps of worlds of all sizes against brute force. The conformance crate in `tests/` goes further.

use trisap_core::{
    Aabb, Boxes, Capacity, Config, Executor, Kernels, Margin, Mode, Path, Serial, World, layout,
};

#[repr(C, align(64))]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Line([u8; 64]);

struct Threads(u32);

impl Executor for Threads {
    fn workers(&self) -> u32 {
        self.0
    }
    fn fork_join(&self, width: u32, job: &(dyn Fn() + Sync)) {
        std::thread::scope(|scope| {
            for _ in 0..width {
                scope.spawn(job);
            }
        });
    }
}

/// A small generator, so that the boxes never change.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }
    fn boxed(&mut self, side: f32) -> Aabb {
        let min = [self.next() * side, self.next() * side, self.next() * side];
        let size = if self.next() < 0.01 { 8.0 } else { 1.0 };
        Aabb::new(min, min.map(|x| x + size * (0.5 + self.0 as u8 as f32 / 256.0)))
    }
}

fn brute_force(boxes: &[Aabb]) -> Vec<[u32; 2]> {
    let mut pairs = vec![];
    for b in 0..boxes.len() {
        for a in 0..b {
            if boxes[a].overlaps(&boxes[b]) {
                pairs.push([a as u32, b as u32]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

fn run(config: Config, count: usize, kernels: Kernels, executor: &dyn Executor) -> Vec<Vec<[u32; 2]>> {
    let bytes = layout::<u32>(&config).unwrap().bytes;
    let mut slab = vec![Line([0; 64]); bytes / 64];
    let mut world = World::<u32>::new_in(bytemuck::cast_slice_mut(&mut slab), &config).unwrap();
    let mut random = Random(count as u64);
    let side = (count as f32 * 6.0).cbrt();
    let mut boxes: Vec<_> = (0..count).map(|_| random.boxed(side)).collect();
    world.insert_many(Boxes::new(&boxes)).unwrap();
    let mut results = vec![];
    let mut last = vec![];
    for frame in 0..8 {
        let step = world.set_kernels(kernels).on(executor).step_over(Boxes::new(&boxes)).unwrap();
        let mut pairs = step.pairs().to_vec();
        results.push(step.pairs().to_vec());
        let stats = step.stats();
        pairs.sort_unstable();
        let expected = brute_force(&boxes);
        if matches!(stats.path, Path::Lists | Path::Full | Path::Rebuilt) {
            assert!(stats.candidates >= stats.pairs, "{stats:?}");
        }
        assert!(stats.tied <= stats.candidates, "{stats:?}");
        if config.mode == Mode::Exact {
            assert_eq!(pairs, expected, "{count} boxes, frame {frame}, {stats:?}");
            assert_eq!(step.surplus(), 0);
        } else {
            assert_eq!(step.surplus() as usize, pairs.len() - expected.len());
            assert!(expected.iter().all(|pair| pairs.binary_search(pair).is_ok()));
        }
        if config.events {
            let mut after: Vec<[u32; 2]> = last.clone();
            after.retain(|pair| !step.lost().contains(pair));
            assert_eq!(after.len() + step.lost().len(), last.len());
            after.extend_from_slice(step.found());
            after.sort_unstable();
            assert_eq!(after, pairs, "events of frame {frame}, {stats:?}");
        }
        last = pairs;
        if frame == 4 && count > 600 && config.margin.is_none() {
            assert_eq!(stats.path, Path::Movers, "{stats:?}");
        }
        world.validate().unwrap();
        let movers = if frame == 3 || frame == 4 { count / 40 } else { count };
        for aabb in &mut boxes[..movers] {
            let by = [random.next() - 0.5, random.next() - 0.5, random.next() - 0.5];
            *aabb = Aabb::new(
                std::array::from_fn(|k| aabb.min[k] + by[k]),
                std::array::from_fn(|k| aabb.max[k] + by[k]),
            );
        }
        if frame == 5 {
            boxes.iter_mut().for_each(|aabb| *aabb = random.boxed(side));
        }
    }
    results
}

#[test]
fn every_path_finds_the_pairs_of_brute_force() {
    for count in [0, 1, 2, 3, 100, 512, 513, 2000, 5000] {
        let config = Config::new(
            Capacity::for_objects(count as u32)
                .with_leaf_refs(count as u32 / 2)
                .with_pairs(20 * count as u32),
        )
        .with_events();
        let first = run(config, count, Kernels::SCALAR, &Serial);
        for kernels in Kernels::all() {
            for executor in [&Serial as &dyn Executor, &Threads(2), &Threads(5)] {
                assert!(
                    first == run(config.with_workers(3), count, kernels, executor),
                    "{count}, {}",
                    kernels.name()
                );
            }
        }
    }
}

#[test]
fn margins_change_speed_alone() {
    for count in [100, 3000] {
        let capacity = Capacity::for_objects(count).with_leaf_refs(count).with_pairs(40 * count);
        let config = Config::new(capacity).with_events().with_margin(Margin::share(0.2));
        run(config, count as usize, Kernels::detect(), &Serial);
        run(config.with_mode(Mode::Fat), count as usize, Kernels::detect(), &Serial);
    }
}

/// Of boxes that touch no grid can tell, wherever its steps lie.
#[test]
fn ties_are_counted() {
    let boxes: Vec<_> = (0..1000)
        .map(|i| [i % 10, i / 10 % 10, i / 100].map(|x| x as f32))
        .map(|low| Aabb::new(low, low.map(|x| x + 1.0)))
        .collect();
    let config = Config::new(Capacity::for_objects(1000).with_pairs(20_000));
    let mut slab = vec![Line([0; 64]); layout::<u32>(&config).unwrap().bytes / 64];
    let mut world = World::<u32>::new_in(bytemuck::cast_slice_mut(&mut slab), &config).unwrap();
    world.insert_many(Boxes::new(&boxes)).unwrap();
    for kernels in Kernels::all() {
        let stats = world.set_kernels(kernels).step_over(Boxes::new(&boxes)).unwrap().stats();
        assert!(stats.path == Path::Unchanged || stats.tied > 1000, "{stats:?}");
    }
    // Few of ordinary boxes.
    let mut random = Random(3);
    let boxes: Vec<_> = (0..1000).map(|_| random.boxed(18.0)).collect();
    let stats = world.step_over(Boxes::new(&boxes)).unwrap().stats();
    assert!(stats.candidates > 1000 && stats.tied < stats.candidates / 20, "{stats:?}");
}

#[test]
fn a_world_without_leaf_references_has_one_leaf() {
    let config = Config::new(Capacity::for_objects(5000).with_leaf_refs(0).with_pairs(100_000));
    run(config, 5000, Kernels::detect(), &Serial);
}
