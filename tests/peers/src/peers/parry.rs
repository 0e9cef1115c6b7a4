//! parry3d's BVH over the tight boxes, traversed against itself: refitted and optimised a little, which suits slow
//! motion, or built anew, which suits fast motion.

use super::{Crowd, Entry, Output, Peer, Pool};
use crate::recording::Padded;
use parry3d::{
    bounding_volume::Aabb,
    math::Vector,
    partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace},
};

pub(crate) fn refit() -> Entry {
    Entry {
        name: "parry3d BVH, refit",
        setup: "binned build once; leaves in place, incremental optimisation, refit, self-traversal",
        events: false,
        fat: false,
        parallel: Pool::PARALLEL,
        crowd: Crowd::Unsuited,
        start: Ok(|setting| Box::new(Parry::new(setting.boxes, setting.threads, Policy::Refit))),
    }
}

pub(crate) fn rebuild() -> Entry {
    Entry {
        name: "parry3d BVH, rebuild",
        setup: "binned build in every frame, self-traversal",
        events: false,
        fat: false,
        parallel: Pool::PARALLEL,
        crowd: Crowd::Unsuited,
        start: Ok(|setting| Box::new(Parry::new(setting.boxes, setting.threads, Policy::Rebuild))),
    }
}

struct Parry {
    tree: Tree,
    boxes: Vec<Aabb>,
    pairs: Vec<[u32; 2]>,
    pool: Pool,
    threads: u32,
}

/// What happens to the tree in a frame.
#[derive(Clone, Copy)]
enum Policy {
    Refit,
    Rebuild,
}

struct Tree {
    policy: Policy,
    bvh: Bvh,
    workspace: BvhWorkspace,
    pairs: Vec<(u32, u32)>,
}

fn aabb(b: &Padded) -> Aabb {
    Aabb::new(Vector::new(b[0], b[1], b[2]), Vector::new(b[4], b[5], b[6]))
}

impl Parry {
    fn new(boxes: &[Padded], threads: u32, policy: Policy) -> Self {
        let boxes: Vec<Aabb> = boxes.iter().map(aabb).collect();
        let bvh = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        let tree = Tree { policy, bvh, workspace: BvhWorkspace::default(), pairs: Vec::new() };
        Self { tree, boxes, pairs: Vec::new(), pool: Pool::new(threads), threads }
    }
}

impl Tree {
    fn frame(&mut self, boxes: &[Aabb]) {
        for (id, &b) in boxes.iter().enumerate() {
            self.bvh.insert_or_update_partially(b, id as u32, 0.0);
        }
        match self.policy {
            Policy::Refit => {
                self.bvh.optimize_incremental(&mut self.workspace);
                self.bvh.refit(&mut self.workspace);
            }
            Policy::Rebuild => self.bvh.rebuild(&mut self.workspace, BvhBuildStrategy::Binned),
        }
        self.pairs.clear();
        let pairs = &mut self.pairs;
        self.bvh.traverse_bvtt_single_tree::<false>(&mut self.workspace, &mut |a, b| pairs.push((a, b)));
    }

    #[cfg(feature = "parallel")]
    fn frame_parallel(&mut self, boxes: &[Aabb]) {
        use rayon::prelude::*;
        let updates: Vec<_> = boxes.par_iter().enumerate().map(|(id, &b)| (b, id as u32, 0.0)).collect();
        self.bvh.insert_or_update_batch_partially_parallel(&updates, &mut Vec::new());
        match self.policy {
            Policy::Refit => {
                self.bvh.optimize_incremental(&mut self.workspace);
                self.bvh.refit_parallel(&mut self.workspace);
            }
            Policy::Rebuild => self.bvh.rebuild(&mut self.workspace, BvhBuildStrategy::Binned),
        }
        self.pairs = self.bvh.traverse_bvtt_single_tree_parallel::<false>();
    }
}

impl Peer for Parry {
    fn prepare(&mut self, boxes: &[Padded]) {
        self.boxes.iter_mut().zip(boxes).for_each(|(to, from)| *to = aabb(from));
    }

    fn frame(&mut self) {
        let Self { tree, boxes, pool, threads, .. } = self;
        match *threads {
            #[cfg(feature = "parallel")]
            2.. => pool.run(|| tree.frame_parallel(boxes)),
            _ => pool.run(|| tree.frame(boxes)),
        }
    }

    fn output(&mut self) -> Output<'_> {
        self.pairs.clear();
        self.pairs.extend(self.tree.pairs.iter().map(|&(a, b)| [a, b]));
        Output::Pairs(&self.pairs)
    }
}
