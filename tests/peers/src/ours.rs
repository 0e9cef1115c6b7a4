//! trisap as one side of a race: every box handed over in every frame, exact pairs; beside a peer that tells a superset,
//! fat ones.

use crate::{
    options::Options,
    peers::{Output, Peer, Setting},
    recording::Padded,
};
use rayon::ThreadPoolBuilder;
use trisap::{
    Aabb, Boxes, Capacity, Config, Executor, Id, Index, Kernels, Margin, Mode, OwnedWorld, Rayon, Serial,
};

/// The level asked for, or the best of this CPU; the names of those there are where there is none such.
pub(crate) fn kernels(options: &Options) -> Result<Kernels, String> {
    match &options.kernels {
        None => Ok(trisap::Kernels::detect()),
        Some(name) => Kernels::by_name(name).ok_or_else(|| {
            let names: Vec<&str> = Kernels::all().map(Kernels::name).collect();
            format!("no kernels {name} here: {}", names.join(", "))
        }),
    }
}

/// The margin of fat worlds, a share of the extent: peers have about as much.
const FAT: f32 = 0.1;

/// A world with the boxes of the first frame, which has not stepped yet, in the narrowest indices that fit; `pairs`: the
/// most there will be.
pub(crate) fn ours(
    setting: &Setting,
    pairs: u64,
    options: &Options,
    events: bool,
    fat: bool,
) -> Result<Box<dyn Peer>, String> {
    if setting.boxes.len() <= u16::MAX_OBJECTS as usize {
        Ok(Box::new(Ours::<u16>::new(setting, pairs, options, events, fat)?))
    } else {
        Ok(Box::new(Ours::<u32>::new(setting, pairs, options, events, fat)?))
    }
}

struct Ours<I: Index> {
    world: OwnedWorld<I>,
    kernels: Kernels,
    executor: Box<dyn Executor>,
    events: bool,
    /// Of all, or of the movers.
    boxes: Vec<Aabb>,
    /// Those who may have another box, unless that is all.
    movers: Vec<Id>,
    /// Of the last frame: all pairs, or with events the found and the lost ones.
    told: [Vec<[u32; 2]>; 2],
}

fn aabb(b: &Padded) -> Aabb {
    Aabb::new([b[0], b[1], b[2]], [b[4], b[5], b[6]])
}

impl<I: Index> Ours<I> {
    fn new(
        setting: &Setting,
        pairs: u64,
        options: &Options,
        events: bool,
        fat: bool,
    ) -> Result<Self, String> {
        let boxes = setting.boxes;
        let capacity = Capacity::for_objects(boxes.len() as u32);
        // Room as `trisap run` has it: fat boxes overlap more often than boxes.
        let capacity = capacity.with_pairs(capacity.pairs.max((pairs + pairs / 4) as u32));
        let mut config = Config::new(capacity).with_workers(options.threads);
        if events {
            config = config.with_events();
        }
        if fat {
            config = config.with_mode(Mode::Fat);
        }
        if let Some(share) = options.margin.or(fat.then_some(FAT)) {
            // The surplus needs room as well.
            config.capacity = capacity.with_pairs(capacity.pairs.saturating_mul(2));
            config = config.with_margin(Margin::share(share));
        }
        let boxes: Vec<Aabb> = boxes.iter().map(aabb).collect();
        let build = || {
            let mut world = OwnedWorld::with_index(&config)?;
            let ids: Vec<_> = world.world().insert_many(Boxes::new(&boxes))?.collect();
            let movers = if setting.is_crowd() { setting.movers } else { &[] };
            Ok::<_, trisap::Error>((world, movers.iter().map(|&slot| ids[slot as usize]).collect()))
        };
        let (world, movers) = build().map_err(|error| format!("trisap: {error}"))?;
        let executor: Box<dyn Executor> = match options.threads {
            0 | 1 => Box::new(Serial),
            threads => {
                // The calling thread is one of them. A pool for the whole run: nobody waits for its end.
                let pool = ThreadPoolBuilder::new().num_threads(threads as usize - 1).build();
                Box::new(Rayon::in_pool(Box::leak(Box::new(pool.expect("threads can be had")))))
            }
        };
        let kernels = kernels(options)?;
        Ok(Self { world, kernels, executor, events, boxes, movers, told: Default::default() })
    }
}

impl<I: Index> Peer for Ours<I> {
    fn prepare(&mut self, boxes: &[Padded]) {
        self.boxes.clear();
        if self.movers.is_empty() {
            self.boxes.extend(boxes.iter().map(aabb));
        } else {
            self.boxes.extend(self.movers.iter().map(|id| aabb(&boxes[id.slot() as usize])));
        }
    }

    fn frame(&mut self) {
        let mut world = self.world.world();
        let boxes = Boxes::new(&self.boxes);
        let step = if self.movers.is_empty() {
            world.set_kernels(self.kernels).on(&*self.executor).step_over(boxes)
        } else {
            world
                .update_many(&self.movers, boxes)
                .and_then(|()| world.set_kernels(self.kernels).on(&*self.executor).step())
        };
        // A step that fails leaves too few pairs, which the check tells.
        _ = std::hint::black_box(step).is_ok();
    }

    fn output(&mut self) -> Output<'_> {
        let world = self.world.world();
        let [first, second] = &mut self.told;
        first.clear();
        second.clear();
        if self.events {
            first.extend(world.found().iter().map(|pair| pair.map(Index::slot)));
            second.extend(world.lost().iter().map(|pair| pair.map(Index::slot)));
            Output::Events { found: first, lost: second }
        } else {
            first.extend(world.pairs().iter().map(|pair| pair.map(Index::slot)));
            Output::Pairs(first)
        }
    }
}
