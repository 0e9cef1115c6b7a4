//! rapier3d's broad phase as its pipeline drives it: fat leaves, change detection, found and lost pairs.

use super::{Crowd, Entry, Output, Peer, Pool, Setting};
use crate::recording::Padded;
use rapier3d::prelude::*;

pub(crate) fn entry() -> Entry {
    Entry {
        name: "rapier3d BroadPhaseBvh",
        setup: "cuboid colliders, those handed over changed, prediction distance 0, its own margin of 0.04",
        events: true,
        fat: true,
        parallel: Pool::PARALLEL,
        crowd: Crowd::All,
        start: Ok(|setting| Box::new(Rapier::new(setting))),
    }
}

struct Rapier {
    broad_phase: BroadPhaseBvh,
    parameters: IntegrationParameters,
    colliders: ColliderSet,
    bodies: RigidBodySet,
    handles: Vec<ColliderHandle>,
    /// Those of who may have another box.
    movers: Vec<ColliderHandle>,
    started: bool,
    pool: Pool,
    events: Vec<BroadPhasePairEvent>,
    found: Vec<[u32; 2]>,
    lost: Vec<[u32; 2]>,
}

impl Rapier {
    fn new(setting: &Setting) -> Self {
        let mut colliders = ColliderSet::new();
        let mut bodies = RigidBodySet::new();
        let handles: Vec<_> = (0..setting.boxes.len())
            .map(|id| {
                let apart = Vector::new(10.0 * id as f32, 0.0, 0.0);
                // Colliders without a body count as fixed, and pairs of fixed ones are filtered unless asked for.
                let all = ActiveCollisionTypes::all();
                colliders.insert(
                    ColliderBuilder::cuboid(0.5, 0.5, 0.5).translation(apart).active_collision_types(all),
                )
            })
            .collect();
        // Takes the mark of new colliders off (here they lie far apart): the broad phase would insert them anew
        // in every frame.
        CollisionPipeline::new().step(
            0.0,
            &mut IslandManager::new(),
            &mut BroadPhaseBvh::new(),
            &mut NarrowPhase::new(),
            &mut bodies,
            &mut colliders,
            &(),
            &(),
        );
        Self {
            broad_phase: BroadPhaseBvh::new(),
            parameters: IntegrationParameters { normalized_prediction_distance: 0.0, ..Default::default() },
            colliders,
            bodies,
            movers: setting.movers.iter().map(|&id| handles[id as usize]).collect(),
            handles,
            started: false,
            pool: Pool::new(setting.threads),
            events: Vec::new(),
            found: Vec::new(),
            lost: Vec::new(),
        }
    }
}

/// Where a cuboid ends whose box may be endless.
fn end(x: f32) -> f32 {
    x.clamp(-1e9, 1e9)
}

impl Peer for Rapier {
    fn prepare(&mut self, boxes: &[Padded]) {
        let movers = if self.started { &self.movers } else { &self.handles };
        for &handle in movers {
            let b = boxes[handle.into_raw_parts().0 as usize];
            let [low, high] = [0, 4].map(|at| Vector::new(end(b[at]), end(b[at + 1]), end(b[at + 2])));
            // A centre and half extents round: the cuboid must not be smaller than the box.
            let half = (high - low) * 0.5 + (low.abs() + high.abs()) * f32::EPSILON;
            let collider = self.colliders.get_mut(handle).expect("the collider lives");
            collider.set_translation((low + high) * 0.5);
            collider.shape_mut().as_cuboid_mut().expect("a cuboid").half_extents = half;
        }
    }

    fn frame(&mut self) {
        let Self {
            broad_phase, parameters, colliders, bodies, handles, movers, started, pool, events, ..
        } = self;
        events.clear();
        let handles = if *started { movers } else { handles };
        *started = true;
        pool.run(|| broad_phase.update(parameters, colliders, bodies, handles, &[], events));
    }

    fn output(&mut self) -> Output<'_> {
        self.found.clear();
        self.lost.clear();
        for event in &self.events {
            let ids =
                |pair: &ColliderPair| [pair.collider1.into_raw_parts().0, pair.collider2.into_raw_parts().0];
            match event {
                BroadPhasePairEvent::AddPair(pair) => self.found.push(ids(pair)),
                BroadPhasePairEvent::DeletePair(pair) => self.lost.push(ids(pair)),
            }
        }
        Output::Events { found: &self.found, lost: &self.lost }
    }
}
