//! A rigid-body simulation of a scene, by rapier.

use crate::split::Pose;
use rapier3d::dynamics::{RigidBodyBuilder, RigidBodyHandle};
use rapier3d::geometry::ColliderBuilder;
use rapier3d::math::Vector;
use rapier3d::pipeline::PhysicsWorld;
use trisap::scene::{FRAME_SECONDS, Gravity, Kind, Random, Setup};

/// Steps of the engine in a frame.
const SUB_STEPS: u32 = 4;

pub(crate) struct Simulation {
    setup: Setup,
    world: PhysicsWorld,
    gravity: Gravity,
    random: Random,
    bodies: Vec<(RigidBodyHandle, [f32; 3])>,
}

impl Simulation {
    /// The first frame.
    pub(crate) fn new(setup: &Setup) -> Self {
        let mut world = PhysicsWorld::new();
        world.integration_parameters.dt = FRAME_SECONDS / SUB_STEPS as f32;
        // Walls as thick as the cube is wide, so that nothing gets through, and overlapping at the edges. (Half-spaces
        // would do, but each of them would be tested against every body.)
        let side = setup.side();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut half = [1.5 * side; 3];
                let mut centre = [0.0; 3];
                half[axis] = 0.5 * side;
                centre[axis] = sign * side;
                let [x, y, z] = half;
                world.insert_collider(
                    ColliderBuilder::cuboid(x, y, z).translation(Vector::from_array(centre)),
                    None,
                );
            }
        }
        let bodies = setup
            .bodies()
            .map(|body| {
                let [hx, hy, hz] = body.edges.map(|edge| edge / 2.0);
                let rigid = RigidBodyBuilder::dynamic()
                    .translation(Vector::from_array(body.position))
                    .linvel(Vector::from_array(body.velocity))
                    // Sleepers would not notice that gravity turns.
                    .can_sleep(setup.kind != Kind::Gravity);
                let (handle, _) = world.insert(rigid, ColliderBuilder::cuboid(hx, hy, hz));
                (handle, [hx, hy, hz])
            })
            .collect();
        Self { setup: *setup, world, gravity: setup.gravity(), random: Random::new(setup.seed, 2), bodies }
    }

    /// Goes to the next frame.
    pub(crate) fn advance(&mut self) {
        self.world.gravity = Vector::from_array(self.gravity.next().unwrap_or_default());
        for (object, velocity) in self.setup.kicks(&mut self.random) {
            self.world.bodies[self.bodies[object].0].set_linvel(Vector::from_array(velocity), true);
        }
        for _ in 0..SUB_STEPS {
            self.world.step();
        }
    }

    /// Every body where it is now, in order.
    pub(crate) fn for_each_body(&self, mut f: impl FnMut(Pose)) {
        for &(handle, half) in &self.bodies {
            let body = &self.world.bodies[handle];
            let rotation = *body.rotation();
            f(Pose {
                centre: body.translation().to_array(),
                half,
                axes: [Vector::X, Vector::Y, Vector::Z].map(|axis| (rotation * axis).to_array()),
            });
        }
    }
}
