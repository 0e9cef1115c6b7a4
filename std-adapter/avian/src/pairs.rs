//! Which colliders get a contact in this step.

use avian3d::collider_tree::{
    ColliderTreeProxy, ColliderTreeProxyFlags, ColliderTreeProxyKey, ColliderTreeType, ColliderTrees,
    MovedProxies, ProxyId,
};
use avian3d::dynamics::joints::joint_graph::JointGraph;
use avian3d::prelude::*;
use bevy::prelude::*;
use trisap::{Aabb, Boxes, BroadPhase, Capacity, Config, Error, Id};

/// Two colliders by their keys in avian's trees: the one that has moved first, and of two that have, the one that avian asks.
pub type FoundPair = [ColliderTreeProxyKey; 2];

/// What avian knows when pairs are to be found.
pub struct Known<'w> {
    pub trees: &'w ColliderTrees,
    pub moved: &'w MovedProxies,
    pub contacts: &'w ContactGraph,
    pub joints: &'w JointGraph,
}

/// The boxes of all colliders, and the pairs of them that are new.
///
/// The boxes are avian's enlarged ones, so one of them changes only where a collider has left it. Layers, bodies, sensors, joints
/// and hooks are not told to trisap but looked at for each pair: avian may change them without telling, and they count when one of
/// the colliders moves next.
#[derive(Resource)]
pub struct Pairs {
    boxes: BroadPhase<ColliderTreeProxyKey>,
    /// By slot.
    objects: Vec<Object>,
    /// Of each proxy, by tree.
    ids: [Vec<Option<Id>>; 4],
    step: u32,
    moved_ids: Vec<Id>,
    moved_boxes: Vec<Aabb>,
    found: Vec<FoundPair>,
}

#[derive(Clone, Copy)]
struct Object {
    key: ColliderTreeProxyKey,
    /// The last step in which it has moved, and its turn among those that had.
    step: u32,
    turn: u32,
}

impl Default for Pairs {
    fn default() -> Self {
        let config = Config::new(Capacity::for_objects(1024));
        Self {
            boxes: BroadPhase::with_config(&config).expect("a small world"),
            objects: Vec::new(),
            ids: Default::default(),
            step: 0,
            moved_ids: Vec::new(),
            moved_boxes: Vec::new(),
            found: Vec::new(),
        }
    }
}

impl Pairs {
    /// The pairs that are to become contacts: their boxes overlap, at least one of them has moved, there is no contact yet, and
    /// neither layers nor bodies nor joints nor hooks object. O(m log n + p) for m that have moved among n, and p pairs that
    /// overlap.
    ///
    /// # Errors
    /// Where trisap gets no memory.
    pub fn find(
        &mut self,
        known: &Known<'_>,
        hooks: &impl CollisionHooks,
        commands: &mut Commands<'_, '_>,
    ) -> Result<&[FoundPair], Error> {
        self.found.clear();
        self.step = self.step.wrapping_add(1);
        self.remove_gone(known.trees);
        if known.moved.proxies().is_empty() {
            return Ok(&self.found);
        }
        self.tell_moved(known)?;
        let step = self.boxes.step()?;
        for [a, b] in step.world().pairs().iter().copied() {
            let (a, b) = (self.objects[a as usize], self.objects[b as usize]);
            let turn = |object: Object| (object.step == self.step).then_some(object.turn);
            let Some(pair) = in_order(known, (a.key, turn(a)), (b.key, turn(b))) else { continue };
            if is_wanted(known, pair, hooks, commands) {
                self.found.push(pair);
            }
        }
        // Contacts are solved in the order in which they come. That of the colliders keeps neighbours together.
        self.found.sort_unstable_by_key(|[first, second]| (rank(*first), rank(*second)));
        Ok(&self.found)
    }

    /// Proxies go without a word, and their places are given to others. Those whose places are free are removed here; those whose
    /// places are taken have become these others, which count as moved.
    fn remove_gone(&mut self, trees: &ColliderTrees) {
        let living: usize = trees.iter_trees().map(|tree| tree.proxies.len()).sum();
        if self.boxes.len() == living {
            return;
        }
        for (tree, ids) in ColliderTreeType::ALL.into_iter().zip(&mut self.ids) {
            for (place, id) in ids.iter_mut().enumerate() {
                let key = ColliderTreeProxyKey::new(ProxyId::new(place as u32), tree);
                if id.is_some() && trees.get_proxy(key).is_none() {
                    self.boxes.remove(&key);
                    *id = None;
                }
            }
        }
    }

    /// Hands the boxes of all that has moved or come to trisap.
    fn tell_moved(&mut self, known: &Known<'_>) -> Result<(), Error> {
        self.moved_ids.clear();
        self.moved_boxes.clear();
        for (turn, key) in (0..).zip(known.moved.proxies()) {
            let Some(enlarged) = known.trees.tree_for_type(key.tree_type()).get_proxy_aabb(key.id()) else {
                continue;
            };
            let aabb = Aabb::new(enlarged.min.to_array(), enlarged.max.to_array());
            let ids = &mut self.ids[key.tree_type() as usize];
            if ids.len() <= key.id().index() {
                ids.resize(key.id().index() + 1, None);
            }
            // A box with NaN in it overlaps nothing.
            if !aabb.is_valid() {
                self.boxes.remove(key);
                ids[key.id().index()] = None;
                continue;
            }
            let id = if let Some(id) = ids[key.id().index()] {
                self.moved_ids.push(id);
                self.moved_boxes.push(aabb);
                id
            } else {
                self.boxes.insert(*key, aabb)?;
                let Some(id) = self.boxes.id(key) else { continue };
                ids[key.id().index()] = Some(id);
                id
            };
            let object = Object { key: *key, step: self.step, turn };
            let slot = id.slot() as usize;
            if slot >= self.objects.len() {
                self.objects
                    .resize(slot + 1, Object { key: ColliderTreeProxyKey::PLACEHOLDER, step: 0, turn: 0 });
            }
            self.objects[slot] = object;
        }
        self.boxes.world().update_many(&self.moved_ids, Boxes::new(&self.moved_boxes))
    }
}

/// Of two that have moved, the one of lower rank is asked about the other.
fn rank(key: ColliderTreeProxyKey) -> (u8, u32) {
    (key.tree_type() as u8, key.id().id())
}

/// A pair with at least one that has moved, in the order in which avian finds it. Both are given with their turn among those that
/// have moved.
fn in_order(
    known: &Known<'_>,
    (a, a_turn): (ColliderTreeProxyKey, Option<u32>),
    (b, b_turn): (ColliderTreeProxyKey, Option<u32>),
) -> Option<FoundPair> {
    let is_sensor = |key| known.trees.get_proxy(key).is_some_and(ColliderTreeProxy::is_sensor);
    let both_static = a.is_static() && b.is_static();
    // One that moves asks for all others; but of two that move, the one of higher rank leaves it to the other, unless it is a sensor.
    // Of two that are static, only a sensor asks.
    let asks = |one, turn: Option<u32>, other, other_turn: Option<u32>| {
        turn.is_some_and(|_| {
            let leaves = other_turn.is_some() && rank(one) > rank(other);
            !(leaves || both_static) || is_sensor(one)
        })
    };
    match (asks(a, a_turn, b, b_turn), asks(b, b_turn, a, a_turn)) {
        (false, false) => None,
        (true, false) => Some([a, b]),
        (false, true) => Some([b, a]),
        // Whose turn is first.
        (true, true) => Some(if a_turn < b_turn { [a, b] } else { [b, a] }),
    }
}

/// Whether two whose boxes overlap get a contact. The cheap reasons against it come first, the caller's own last.
fn is_wanted(
    known: &Known<'_>,
    [first, second]: FoundPair,
    hooks: &impl CollisionHooks,
    commands: &mut Commands<'_, '_>,
) -> bool {
    let (Some(first), Some(second)) = (known.trees.get_proxy(first), known.trees.get_proxy(second)) else {
        return false;
    };
    if !first.layers.interacts_with(second.layers)
        || first.body == second.body
        || known.contacts.contains(first.collider, second.collider)
    {
        return false;
    }
    if let (Some(one), Some(other)) = (first.body, second.body)
        && known.joints.joints_between(one, other).any(|joint| joint.collision_disabled)
    {
        return false;
    }
    let asks = first.flags.union(second.flags).contains(ColliderTreeProxyFlags::CUSTOM_FILTER);
    !asks || hooks.filter_pairs(first.collider, second.collider, commands)
}
