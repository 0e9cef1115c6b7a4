//! trisap as the broad phase of avian3d, in place of its own walk through its trees:
//!
//! ```
//! use avian3d::prelude::*;
//! use bevy::prelude::*;
//! use trisap_avian::TrisapBroadPhasePlugin;
//!
//! let mut app = App::new();
//! app.add_plugins((
//!     MinimalPlugins,
//!     TransformPlugin,
//!     PhysicsPlugins::default().build().disable::<BvhBroadPhasePlugin>().add(TrisapBroadPhasePlugin::<()>::default()),
//! ));
//! # app.update();
//! ```
//!
//! It finds the contact pairs that avian's `BvhBroadPhasePlugin` finds, in another order. avian keeps its trees, since its
//! spatial queries ask them; so what is saved is the walk, not the upkeep of the trees.

mod pairs;

pub use pairs::{FoundPair, Known, Pairs};

use avian3d::collider_tree::{ColliderTreeProxyFlags, ColliderTrees, MovedProxies};
use avian3d::collision::CollisionDiagnostics;
use avian3d::collision::contact_types::ContactEdgeFlags;
use avian3d::dynamics::joints::joint_graph::JointGraph;
use avian3d::prelude::*;
use bevy::ecs::system::{StaticSystemParam, SystemParamItem};
use bevy::prelude::*;
use core::marker::PhantomData;
use std::time::Instant;

/// A plugin that finds contact pairs with trisap. `H` are the collision hooks, as for avian's own plugin.
pub struct TrisapBroadPhasePlugin<H: CollisionHooks = ()>(PhantomData<H>);

impl<H: CollisionHooks> Default for TrisapBroadPhasePlugin<H> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<H: CollisionHooks + 'static> Plugin for TrisapBroadPhasePlugin<H>
where
    for<'w, 's> SystemParamItem<'w, 's, H>: CollisionHooks,
{
    fn build(&self, app: &mut App) {
        app.init_resource::<Pairs>()
            .add_systems(PhysicsSchedule, collect_pairs::<H>.in_set(BroadPhaseSystems::CollectCollisions));
    }
}

/// Finds the new pairs and adds them to the contact graph.
///
/// # Errors
/// Where trisap gets no memory.
fn collect_pairs<H: CollisionHooks>(
    mut pairs: ResMut<Pairs>,
    trees: Res<ColliderTrees>,
    moved: Res<MovedProxies>,
    hooks: StaticSystemParam<H>,
    mut commands: Commands,
    mut contacts: ResMut<ContactGraph>,
    joints: Res<JointGraph>,
    mut diagnostics: ResMut<CollisionDiagnostics>,
) -> Result
where
    for<'w, 's> SystemParamItem<'w, 's, H>: CollisionHooks,
{
    let start = Instant::now();
    let known = Known { trees: &trees, moved: &moved, contacts: &contacts, joints: &joints };
    let found = pairs.find(&known, &hooks.into_inner(), &mut commands)?;
    for pair in found {
        add_edge(&mut contacts, &trees, *pair);
    }
    diagnostics.broad_phase += start.elapsed();
    Ok(())
}

/// What avian's own plugin makes of a pair.
fn add_edge(contacts: &mut ContactGraph, trees: &ColliderTrees, [first, second]: FoundPair) {
    let (Some(first), Some(second)) = (trees.get_proxy(first), trees.get_proxy(second)) else { return };
    let either = first.flags.union(second.flags);
    let mut edge = ContactEdge::new(first.collider, second.collider);
    edge.body1 = first.body;
    edge.body2 = second.body;
    edge.flags.set(ContactEdgeFlags::CONTACT_EVENTS, either.contains(ColliderTreeProxyFlags::CONTACT_EVENTS));
    contacts.add_edge_with(edge, |pair| {
        pair.body1 = first.body;
        pair.body2 = second.body;
        pair.flags
            .set(ContactPairFlags::MODIFY_CONTACTS, either.contains(ColliderTreeProxyFlags::MODIFY_CONTACTS));
        let mute = ColliderTreeProxyFlags::BODY_DISABLED.union(ColliderTreeProxyFlags::SENSOR);
        pair.flags.set(ContactPairFlags::GENERATE_CONSTRAINTS, !either.intersects(mute));
    });
}
