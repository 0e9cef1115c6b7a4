//! trisap beside avian's own broad phase: in every step both have to find the same pairs.

#[path = "../examples/steps/scenes.rs"]
#[allow(dead_code, reason = "the measurement takes all of them")]
mod scenes;

use avian3d::collider_tree::{ColliderTreeSystems, ColliderTrees, MovedProxies};
use avian3d::dynamics::joints::joint_graph::JointGraph;
use avian3d::prelude::*;
use bevy::ecs::system::{StaticSystemParam, SystemParamItem};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use std::collections::BTreeSet;
use std::time::Duration;
use trisap_avian::{Known, Pairs, TrisapBroadPhasePlugin};

type Contacts = BTreeSet<[Entity; 2]>;

/// What trisap has found in this step, what there was before, and how many pairs there were in all.
#[derive(Resource, Default)]
struct Shadow {
    found: Contacts,
    before: Contacts,
    total: usize,
}

fn contacts(graph: &ContactGraph) -> Contacts {
    let pairs = graph.active_pairs().iter().chain(graph.sleeping_pairs());
    pairs.map(|pair| sorted(pair.collider1, pair.collider2)).collect()
}

fn sorted(a: Entity, b: Entity) -> [Entity; 2] {
    if a < b { [a, b] } else { [b, a] }
}

fn look<H: CollisionHooks + 'static>(
    mut pairs: ResMut<Pairs>,
    mut shadow: ResMut<Shadow>,
    (trees, moved, graph, joints): (
        Res<ColliderTrees>,
        Res<MovedProxies>,
        Res<ContactGraph>,
        Res<JointGraph>,
    ),
    hooks: StaticSystemParam<H>,
    mut commands: Commands,
) where
    for<'w, 's> SystemParamItem<'w, 's, H>: CollisionHooks,
{
    let known = Known { trees: &trees, moved: &moved, contacts: &graph, joints: &joints };
    let found = pairs.find(&known, &hooks.into_inner(), &mut commands).expect("memory");
    let colliders =
        found.iter().map(|pair| pair.map(|key| trees.get_proxy(key).expect("a living proxy").collider));
    shadow.found = colliders.map(|[a, b]| sorted(a, b)).collect();
    assert_eq!(shadow.found.len(), found.len(), "a pair twice");
    shadow.before = contacts(&graph);
}

fn compare(mut shadow: ResMut<Shadow>, graph: Res<ContactGraph>, mut step: Local<u32>) {
    *step += 1;
    let new: Contacts = contacts(&graph).difference(&shadow.before).copied().collect();
    let missed: Vec<_> = new.difference(&shadow.found).collect();
    let surplus: Vec<_> = shadow.found.difference(&new).collect();
    assert!(
        missed.is_empty() && surplus.is_empty(),
        "step {}: missed {missed:?}, surplus {surplus:?}",
        *step
    );
    shadow.total += new.len();
}

fn app_with<H: CollisionHooks + 'static>() -> App
where
    for<'w, 's> SystemParamItem<'w, 's, H>: CollisionHooks,
{
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, PhysicsPlugins::default().with_collision_hooks::<H>()));
    app.insert_resource(Time::from_hz(60.0))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)))
        .init_resource::<Pairs>()
        .init_resource::<Shadow>();
    app.add_systems(
        PhysicsSchedule,
        (
            look::<H>.after(ColliderTreeSystems::UpdateAabbs).before(BroadPhaseSystems::CollectCollisions),
            compare.after(BroadPhaseSystems::CollectCollisions).before(BroadPhaseSystems::Last),
        ),
    );
    app
}

/// Runs a scene; how many pairs both have found.
fn run(mut app: App, steps: usize) -> usize {
    app.finish();
    app.cleanup();
    for _ in 0..steps {
        app.update();
    }
    app.world().resource::<Shadow>().total
}

#[test]
fn scenes_of_the_measurement() {
    for (scene, steps, least) in
        [("falling", 150, 4_000), ("swarm", 60, 1_000), ("bullets", 60, 500), ("pyramids", 3, 10_000)]
    {
        let mut app = app_with::<()>();
        scenes::add(&mut app, scene).expect("a scene");
        let total = run(app, steps);
        assert!(total > least, "{scene}: {total} pairs");
    }
}

/// Says no to pairs of entities with odd sums of indices.
#[derive(bevy::ecs::system::SystemParam)]
struct Parity;

impl CollisionHooks for Parity {
    fn filter_pairs(&self, a: Entity, b: Entity, _commands: &mut Commands) -> bool {
        (a.index_u32() + b.index_u32()) % 2 == 0
    }
}

/// The same numbers everywhere (an xorshift generator).
#[derive(Resource)]
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 20) % bound
    }

    fn place(&mut self) -> Vec3 {
        let mut number = || self.below(1000) as f32 * 0.01 - 5.0;
        Vec3::new(number(), number(), number())
    }
}

fn random_body(random: &mut Random, commands: &mut Commands) -> Entity {
    let kinds = [RigidBody::Dynamic, RigidBody::Dynamic, RigidBody::Kinematic, RigidBody::Static];
    let layers = CollisionLayers::new(LayerMask(1 << random.below(3)), LayerMask(1 + random.below(7) as u32));
    let mut entity = commands.spawn((
        Collider::cuboid(1.0, 0.5 + random.below(4) as f32, 1.0),
        Transform::from_translation(random.place()),
        layers,
    ));
    // One in eight belongs to no body.
    if random.below(8) > 0 {
        entity.insert((kinds[random.below(4) as usize], LinearVelocity(random.place())));
    }
    if random.below(4) == 0 {
        entity.insert(Sensor);
    }
    if random.below(3) == 0 {
        entity.insert(ActiveCollisionHooks::FILTER_PAIRS);
    }
    entity.id()
}

/// Of two bodies with a joint that keeps them from colliding.
#[derive(Component)]
struct Jointed;

fn jointed_body(random: &mut Random, commands: &mut Commands) -> Entity {
    let place = Transform::from_translation(random.place());
    commands.spawn((Jointed, RigidBody::Dynamic, Collider::cuboid(2.0, 2.0, 2.0), place)).id()
}

/// Everything that changes whom a collider meets, at random moments.
fn disturb(
    mut random: ResMut<Random>,
    mut commands: Commands,
    bodies: Query<Entity, (With<Collider>, Without<Jointed>)>,
    mut places: Query<&mut Position>,
) {
    let random = &mut *random;
    let all: Vec<Entity> = bodies.iter().collect();
    for _ in 0..12 {
        let one = all[random.below(all.len() as u64) as usize];
        let mut entity = commands.entity(one);
        match random.below(12) {
            0 => drop(random_body(random, &mut commands)),
            1 if all.len() > 60 => entity.try_despawn(),
            2 => drop(entity.try_insert(ColliderDisabled)),
            3 | 4 => drop(entity.try_remove::<ColliderDisabled>()),
            5 => drop(entity.try_insert(RigidBody::Static)),
            6 => drop(entity.try_insert(RigidBody::Dynamic)),
            7 => drop(entity.try_insert(Sensor)),
            8 => drop(entity.try_remove::<Sensor>()),
            9 => drop(
                entity
                    .try_insert(CollisionLayers::new(LayerMask::ALL, LayerMask(1 + random.below(7) as u32))),
            ),
            10 => drop(entity.try_insert(Collider::sphere(0.5 + random.below(3) as f32))),
            _ => {
                if let Ok(mut position) = places.get_mut(one) {
                    position.0 = random.place();
                }
            }
        }
    }
}

#[test]
fn whatever_changes_whom_a_collider_meets() {
    for seed in 1..=8 {
        let mut app = app_with::<Parity>();
        app.insert_resource(Random(seed * 0x9E37_79B9)).insert_resource(Gravity::ZERO);
        app.add_systems(Startup, |mut random: ResMut<Random>, mut commands: Commands| {
            for _ in 0..100 {
                random_body(&mut random, &mut commands);
            }
            for _ in 0..10 {
                let [a, b] = [(); 2].map(|()| jointed_body(&mut random, &mut commands));
                commands.spawn((DistanceJoint::new(a, b), JointCollisionDisabled));
            }
        });
        app.add_systems(Update, disturb);
        let total = run(app, 150);
        assert!(total > 1_000, "seed {seed}: {total} pairs");
    }
}

/// The contacts after the first step of a scene, with all that the broad phase says of them.
fn first_contacts(with_trisap: bool) -> Vec<String> {
    let physics = PhysicsPlugins::default().with_collision_hooks::<Parity>().build();
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin));
    if with_trisap {
        let broad_phase = TrisapBroadPhasePlugin::<Parity>::default();
        app.add_plugins(physics.disable::<BvhBroadPhasePlugin<Parity>>().add(broad_phase));
    } else {
        // A resource is an entity, too: with it, bodies have the same names in both.
        app.init_resource::<Pairs>().add_plugins(physics);
    }
    app.insert_resource(Time::from_hz(60.0))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)))
        .insert_resource(Random(7));
    app.add_systems(Startup, |mut random: ResMut<Random>, mut commands: Commands| {
        for k in 0..200 {
            let body = random_body(&mut random, &mut commands);
            if k % 5 == 0 {
                commands.entity(body).insert(CollisionEventsEnabled);
            }
            if k % 7 == 0 {
                commands.entity(body).insert(RigidBodyDisabled);
            }
        }
    });
    app.finish();
    app.cleanup();
    app.update();
    app.update();
    let graph = app.world().resource::<ContactGraph>();
    let said = graph.active_pairs().iter().map(|pair| {
        let edge = graph.get_edge(pair.collider1, pair.collider2).expect("an edge for each pair");
        let bodies = sorted_bodies(pair.body1, pair.body2);
        format!("{:?} {bodies:?} {:?} {:?}", sorted(pair.collider1, pair.collider2), pair.flags, edge.flags)
    });
    let mut said: Vec<String> = said.collect();
    said.sort();
    said
}

fn sorted_bodies(a: Option<Entity>, b: Option<Entity>) -> [Option<Entity>; 2] {
    if a < b { [a, b] } else { [b, a] }
}

#[test]
fn the_plugin_says_of_contacts_what_avian_says() {
    let (ours, avians) = (first_contacts(true), first_contacts(false));
    assert!(ours.len() > 30, "{} contacts", ours.len());
    assert_eq!(ours, avians);
}
