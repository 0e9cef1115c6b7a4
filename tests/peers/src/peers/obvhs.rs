//! obvhs's binary BVH: built anew by PLOC and traversed against itself, or driven as avian3d's broad phase drives it.

use super::{Crowd, Entry, Output, Peer, Setting};
use crate::recording::Padded;
use hashbrown::HashSet;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision, rebuild::compute_rebuild_path_flags},
};

pub(crate) fn rebuild() -> Entry {
    Entry {
        name: "obvhs PLOC, rebuild",
        setup: "PLOC build in every frame, shortest search distance, 64-bit codes; self-traversal, ours, as it has none",
        events: false,
        fat: false,
        parallel: false,
        crowd: Crowd::Unsuited,
        start: Ok(|setting| Box::new(Rebuild::new(setting.boxes))),
    }
}

pub(crate) fn avian() -> Entry {
    Entry {
        name: "obvhs as in avian3d",
        setup: "enlarged boxes, refit, a query for each box that left its enlarged one, contact set; then reinsertion, \
                partial or full PLOC rebuild by the share of these",
        events: false,
        fat: true,
        parallel: false,
        crowd: Crowd::All,
        start: Ok(|setting| Box::new(Avian::new(setting))),
    }
}

/// As avian3d has them: the fastest build.
const DISTANCE: PlocSearchDistance = PlocSearchDistance::Minimum;
const PRECISION: SortPrecision = SortPrecision::U64;

fn aabb(b: &Padded) -> Aabb {
    Aabb::new([b[0], b[1], b[2]].into(), [b[4], b[5], b[6]].into())
}

#[derive(Default)]
struct Rebuild {
    boxes: Vec<Aabb>,
    builder: PlocBuilder,
    bvh: Bvh2,
    /// Nodes that overlap and are still to be taken apart.
    stack: Vec<[u32; 2]>,
    pairs: Vec<[u32; 2]>,
}

impl Rebuild {
    fn new(boxes: &[Padded]) -> Self {
        Self { boxes: boxes.iter().map(aabb).collect(), ..Self::default() }
    }

    /// All overlaps: of each inner node's two children, downwards.
    fn traverse(&mut self) {
        let Self { bvh, stack, pairs, .. } = self;
        let nodes = &bvh.nodes;
        pairs.clear();
        let meet = |stack: &mut Vec<[u32; 2]>, a: u32, b: u32| {
            if nodes[a as usize].aabb().intersect_aabb(nodes[b as usize].aabb()) {
                stack.push([a, b]);
            }
        };
        for parent in nodes.iter().filter(|node| !node.is_leaf()) {
            meet(stack, parent.first_index, parent.first_index + 1);
            while let Some([a, b]) = stack.pop() {
                let [one, other] = [&nodes[a as usize], &nodes[b as usize]];
                match [one.is_leaf(), other.is_leaf()] {
                    // A leaf is one box.
                    [true, true] => pairs.push([
                        bvh.primitive_indices[one.first_index as usize],
                        bvh.primitive_indices[other.first_index as usize],
                    ]),
                    [true, false] => (0..2).for_each(|child| meet(stack, a, other.first_index + child)),
                    [false, true] => (0..2).for_each(|child| meet(stack, one.first_index + child, b)),
                    [false, false] => (0..4).for_each(|child| {
                        meet(stack, one.first_index + child / 2, other.first_index + child % 2);
                    }),
                }
            }
        }
    }
}

impl Peer for Rebuild {
    fn prepare(&mut self, boxes: &[Padded]) {
        self.boxes.iter_mut().zip(boxes).for_each(|(to, from)| *to = aabb(from));
    }

    fn frame(&mut self) {
        let Self { boxes, builder, bvh, .. } = self;
        // The memory of the last frame's.
        let mut indices = std::mem::take(&mut bvh.primitive_indices);
        indices.clear();
        indices.extend(0..boxes.len() as u32);
        builder.build_with_bvh(bvh, DISTANCE, boxes, indices, PRECISION, 0);
        self.traverse();
    }

    fn output(&mut self) -> Output<'_> {
        Output::Pairs(&self.pairs)
    }
}

/// avian3d's tree of dynamic colliders and its contact graph, as they go through a step of the engine. Its defaults: the
/// margin, the shares at which the tree is optimised in another way or refitted whole.
struct Avian {
    boxes: Vec<Aabb>,
    margins: Vec<f32>,
    movers: Vec<u32>,
    is_mover: Vec<bool>,
    enlarged: Vec<Aabb>,
    /// Those whose enlarged box has changed in this frame.
    moved: Vec<u32>,
    is_moved: Vec<bool>,
    bvh: Bvh2,
    builder: PlocBuilder,
    optimizer: ReinsertionOptimizer,
    leaves: Vec<u32>,
    flags: Vec<bool>,
    /// All contacts, and those that can end: contacts between sleeping bodies are not looked at.
    set: HashSet<u64>,
    active: Vec<[u32; 2]>,
    sleeping: Vec<[u32; 2]>,
    told: Vec<[u32; 2]>,
    started: bool,
}

/// Of a box's bounding radius, and in units of length.
const MARGIN_SHARE: f32 = 0.125;
const MOST_MARGIN: f32 = 0.05;

/// Below these shares of moved boxes: reinsertion, partial rebuild. Above: full rebuild.
const REINSERT: f32 = 0.15;
const PARTIAL: f32 = 0.45;

impl Avian {
    fn new(setting: &Setting) -> Self {
        let boxes: Vec<Aabb> = setting.boxes.iter().map(aabb).collect();
        let margin = |b: &Aabb| MOST_MARGIN.min(MARGIN_SHARE * 0.5 * b.diagonal().length());
        let margins: Vec<f32> = boxes.iter().map(margin).collect();
        let enlarged: Vec<Aabb> = boxes.iter().zip(&margins).map(|(b, &margin)| enlarge(b, margin)).collect();
        let mut builder = PlocBuilder::new();
        let all: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut bvh = builder.build(DISTANCE, &enlarged, all.clone(), PRECISION, 0);
        bvh.init_primitives_to_nodes_if_uninit();
        let mut is_mover = vec![false; boxes.len()];
        setting.movers.iter().for_each(|&mover| is_mover[mover as usize] = true);
        Self {
            margins,
            movers: setting.movers.to_vec(),
            is_mover,
            enlarged,
            is_moved: vec![true; boxes.len()],
            moved: all,
            boxes,
            bvh,
            builder,
            optimizer: ReinsertionOptimizer::default(),
            leaves: Vec::new(),
            flags: Vec::new(),
            set: HashSet::new(),
            active: Vec::new(),
            sleeping: Vec::new(),
            told: Vec::new(),
            started: false,
        }
    }

    /// Enlarges the boxes that have left their enlarged ones, and fits the tree to them.
    fn update_tree(&mut self) {
        let Self { boxes, margins, movers, enlarged, moved, is_moved, bvh, .. } = self;
        moved.drain(..).for_each(|id| is_moved[id as usize] = false);
        for &id in movers.iter() {
            let at = id as usize;
            let (b, old) = (&boxes[at], &mut enlarged[at]);
            if !(old.min.cmple(b.min) & b.max.cmple(old.max)).all() {
                *old = enlarge(b, margins[at]);
                is_moved[at] = true;
                moved.push(id);
            }
        }
        let whole = if bvh.children_are_ordered_after_parents { 0.06 } else { 0.3 };
        if (moved.len() as f32) < whole * boxes.len() as f32 {
            bvh.init_parents_if_uninit();
            for &id in moved.iter() {
                bvh.resize_node(bvh.primitives_to_nodes[id as usize] as usize, enlarged[id as usize]);
            }
        } else {
            for &id in moved.iter() {
                let node = bvh.primitives_to_nodes[id as usize];
                bvh.nodes[node as usize].set_aabb(enlarged[id as usize]);
            }
            bvh.refit_all();
        }
    }

    /// Adds the contacts of those that have moved.
    fn collect_pairs(&mut self) {
        let Self { moved, is_moved, is_mover, enlarged, bvh, set, active, sleeping, .. } = self;
        for &a in moved.iter() {
            bvh.aabb_traverse(enlarged[a as usize], |bvh, node| {
                let node = &bvh.nodes[node as usize];
                let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                for &b in &bvh.primitive_indices[range] {
                    // Of two that have moved, the lower one's query tells the pair.
                    if a == b || (b < a && is_moved[b as usize]) {
                        continue;
                    }
                    let pair = [a.min(b), a.max(b)];
                    if set.insert(key(pair)) {
                        let awake = pair.iter().any(|&id| is_mover[id as usize]);
                        if awake { active.push(pair) } else { sleeping.push(pair) }
                    }
                }
                true
            });
        }
    }

    /// Ends contacts whose enlarged boxes have parted, as avian3d's narrow phase does first.
    fn end_contacts(&mut self) {
        let Self { enlarged, set, active, .. } = self;
        active.retain(|&[a, b]| {
            let touch = enlarged[a as usize].intersect_aabb(&enlarged[b as usize]);
            if !touch {
                set.remove(&key([a, b]));
            }
            touch
        });
    }

    fn optimize(&mut self) {
        let Self { moved, bvh, builder, optimizer, leaves, flags, boxes, .. } = self;
        let share = moved.len() as f32 / boxes.len() as f32;
        if moved.is_empty() {
            return;
        }
        leaves.clear();
        leaves.extend(moved.iter().map(|&id| bvh.primitives_to_nodes[id as usize]));
        if share < REINSERT {
            optimizer.run_with_candidates(bvh, leaves, 1);
        } else if share < PARTIAL {
            bvh.init_parents_if_uninit();
            compute_rebuild_path_flags(bvh, leaves.iter(), flags);
            builder.partial_rebuild(bvh, |node| flags[node], DISTANCE, PRECISION, 0);
        } else {
            builder.full_rebuild(bvh, DISTANCE, PRECISION, 0);
        }
    }
}

fn enlarge(b: &Aabb, margin: f32) -> Aabb {
    Aabb::new(b.min - margin, b.max + margin)
}

fn key([a, b]: [u32; 2]) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

impl Peer for Avian {
    fn prepare(&mut self, boxes: &[Padded]) {
        for &id in &self.movers {
            self.boxes[id as usize] = aabb(&boxes[id as usize]);
        }
    }

    fn frame(&mut self) {
        // The tree is made of the first frame's boxes, all of which count as moved.
        if std::mem::replace(&mut self.started, true) {
            self.update_tree();
        }
        self.collect_pairs();
        self.end_contacts();
        self.optimize();
    }

    fn output(&mut self) -> Output<'_> {
        self.told.clear();
        self.told.extend(self.active.iter().chain(&self.sleeping));
        Output::Pairs(&self.told)
    }
}
