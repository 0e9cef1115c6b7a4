//! A rule that drops pairs of one owner.

/// Whom each slot belongs to: up to three ids of yours, as a vertex, an edge or a triangle of a mesh has vertices, a part has its
/// body, a bullet who has shot it. Two objects that share one make no pair.
///
/// ```
/// use trisap::{Aabb, Boxes, Capacity, Config, OwnedWorld, Owners, Serial};
///
/// let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let [knight, arrow, shield, stranger] = [cube(0.0), cube(0.25), cube(0.5), cube(0.75)];
/// let owners = Owners::from_iter([&[7][..], &[7], &[7, 8], &[]]);
/// let mut owned = OwnedWorld::new(&Config::new(Capacity::for_objects(4)).with_filters())?;
/// let mut world = owned.world();
/// drop(world.insert_many(Boxes::new(&[knight, arrow, shield, stranger]))?);
/// let rule = owners.rule();
/// let step = world.on(&Serial).with_rule(&rule).step()?;
/// assert_eq!(step.pairs().len(), 3); // the stranger with each of them
/// # Ok::<(), trisap::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Owners(Vec<[u32; 3]>);

/// What stands where there is no owner.
const NOBODY: u32 = u32::MAX;

impl Owners {
    /// Nobody owns anything.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets whom a slot belongs to, up to three, none of them `u32::MAX`. In a world that has stepped, its pairs follow once it is
    /// [refiltered](trisap_core::World::refilter) or moves.
    ///
    /// # Panics
    /// If there are more than three.
    pub fn set(&mut self, slot: u32, owners: &[u32]) {
        let slot = slot as usize;
        if self.0.len() <= slot {
            self.0.resize(slot + 1, [NOBODY; 3]);
        }
        self.0[slot] = [NOBODY; 3];
        self.0[slot][..owners.len()].copy_from_slice(owners);
    }

    /// Whether two slots have no owner in common. O(1).
    #[must_use]
    pub fn are_apart(&self, a: u32, b: u32) -> bool {
        let of = |slot: u32| self.0.get(slot as usize).copied().unwrap_or([NOBODY; 3]);
        let [b0, b1, b2] = of(b);
        // Without a branch for each.
        !of(a).into_iter().fold(false, |any, a| any | ((a != NOBODY) & ((a == b0) | (a == b1) | (a == b2))))
    }

    /// The rule, for [`Stepper::with_rule`](trisap_core::Stepper::with_rule).
    pub fn rule(&self) -> impl Fn(u32, u32) -> bool + Sync + '_ {
        |a, b| self.are_apart(a, b)
    }
}

/// The owners of one slot after another.
impl<'o> FromIterator<&'o [u32]> for Owners {
    fn from_iter<T: IntoIterator<Item = &'o [u32]>>(owners: T) -> Self {
        let mut all = Self::new();
        owners.into_iter().zip(0..).for_each(|(owners, slot)| all.set(slot, owners));
        all
    }
}
