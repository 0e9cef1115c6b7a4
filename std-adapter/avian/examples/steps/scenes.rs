//! Scenes: the two three-dimensional benches of avian3d's repository, and three in which more moves.

use avian3d::prelude::*;
use bevy::prelude::*;

pub const NAMES: [&str; 5] = ["pyramid", "pyramids", "falling", "swarm", "bullets"];

/// Adds what is in the scene, or nothing if there is no scene of this name.
pub fn add(app: &mut App, name: &str) -> Option<()> {
    match name {
        "pyramid" => app.add_systems(Startup, pyramid),
        "pyramids" => app.add_systems(Startup, pyramids),
        "falling" => app.add_systems(Startup, falling),
        "swarm" => app.insert_resource(Gravity::ZERO).add_systems(Startup, swarm),
        "bullets" => app.insert_resource(Gravity::ZERO).add_systems(Startup, bullets),
        _ => return None,
    };
    Some(())
}

/// avian's `large_pyramid` with its 100 rows: 5,050 cubes.
fn pyramid(mut commands: Commands) {
    commands.spawn(block(Vec3::new(0.0, -20.0, 0.0), Vec3::new(800.0, 40.0, 800.0)));
    for row in 0..100 {
        let y = (2.0 * row as f32 + 1.0) * 0.5 * 0.99;
        for column in row..100 {
            let x = (row as f32 + 1.0) * 0.5 + (column - row) as f32 - 50.0;
            commands.spawn(cube(Vec3::new(x, y, 0.0)));
        }
    }
}

/// avian's `many_pyramids`: 10 floors with 10 pyramids of 10 rows each, 5,500 cubes.
fn pyramids(mut commands: Commands) {
    const ROWS: usize = 10;
    let width = (10 * (ROWS + 1)) as f32;
    for floor in 0..10 {
        let base = floor as f32 * (ROWS + 1) as f32;
        commands.spawn(block(Vec3::new(0.0, base, 0.0), Vec3::new(width, 0.01, width)));
        for pyramid in 0..10 {
            let center = -width / 2.0 + pyramid as f32 * (ROWS + 1) as f32 + 0.5;
            for row in 0..ROWS {
                for column in row..ROWS {
                    let x = (row + 1) as f32 * 0.5 + (column - row) as f32 + center - 0.5;
                    commands.spawn(cube(Vec3::new(x, (2 * row + 1) as f32 * 0.5 + base, 0.0)));
                }
            }
        }
    }
}

/// 4,096 cubes that fall on a ground and pile up.
fn falling(mut commands: Commands) {
    commands.spawn(block(Vec3::new(0.0, -1.0, 0.0), Vec3::new(200.0, 2.0, 200.0)));
    let mut random = Random(1);
    for k in 0..4096_u32 {
        let place = Vec3::new((k % 16) as f32, (k / 256) as f32, (k / 16 % 16) as f32);
        commands.spawn(cube(place * 1.6 + random.vector() * 0.2 + Vec3::Y * 2.0));
    }
}

/// 10,000 balls that fly fast, without gravity, in a closed room with 1,000 blocks, and bounce.
fn swarm(mut commands: Commands) {
    let mut random = Random(2);
    level(&mut commands, &mut random);
    for _ in 0..10_000 {
        commands.spawn((
            RigidBody::Dynamic,
            Collider::sphere(0.3),
            Transform::from_translation(random.vector() * 58.0),
            LinearVelocity(random.vector() * 30.0),
            Restitution::new(1.0),
            Friction::new(0.0),
        ));
    }
}

/// 10,000 bullets that are sensors and meet nothing but the 1,000 blocks, and 1,000 targets that move.
fn bullets(mut commands: Commands) {
    let mut random = Random(3);
    level(&mut commands, &mut random);
    let (shots, others) = (LayerMask(2), LayerMask(1));
    for _ in 0..1_000 {
        commands.spawn((
            RigidBody::Kinematic,
            Collider::capsule(0.4, 1.0),
            Transform::from_translation(random.vector() * 58.0),
            LinearVelocity(random.vector() * 3.0),
        ));
    }
    for _ in 0..10_000 {
        commands.spawn((
            RigidBody::Kinematic,
            Sensor,
            Collider::sphere(0.1),
            CollisionLayers::new(shots, others),
            Transform::from_translation(random.vector() * 58.0),
            LinearVelocity(random.vector() * 30.0),
        ));
    }
}

/// A room of 120 to each side with 1,000 blocks in it.
fn level(commands: &mut Commands, random: &mut Random) {
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for side in [-61.0, 61.0] {
            commands.spawn(block(axis * side, Vec3::splat(124.0) - axis * 122.0));
        }
    }
    for _ in 0..1_000 {
        commands.spawn(block(random.vector() * 58.0, Vec3::splat(2.0) + random.vector()));
    }
}

fn cube(place: Vec3) -> impl Bundle {
    (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), Transform::from_translation(place))
}

fn block(place: Vec3, size: Vec3) -> impl Bundle {
    (RigidBody::Static, Collider::cuboid(size.x, size.y, size.z), Transform::from_translation(place))
}

/// The same numbers everywhere (SplitMix64).
struct Random(u64);

impl Random {
    /// From -1 to 1.
    fn number(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
}
