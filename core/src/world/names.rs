//! Names pairs by ids, which stay right when slots go to other objects.

use super::{Step, World};
use crate::access::{Access, bits};
use crate::id::{Id, Index, Pair};

/// Results by id, also of objects that are gone.
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Cast, Config, Error, Filter, Id, InlineWorld, Region, Serial, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8)).with_events();
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// let [a, b] = [world.insert(cube(0.0))?, world.insert(cube(0.5))?];
/// assert!(world.step()?.found_ids().eq([[a, b]]));
/// world.remove(b)?;
/// let other = world.insert(cube(9.0))?;
/// assert_eq!(other.slot(), b.slot()); // so a pair of slots no longer says who it was
/// let step = world.step()?;
/// assert_eq!(step.lost(), [[0, 1]]);
/// assert!(step.lost_ids().eq([[a, b]]));
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// [`pairs`](Self::pairs) by id, without those of objects that were removed since the step, also where another
    /// object has got the slot since.
    pub fn pair_ids(&self) -> impl Iterator<Item = [Id; 2]> {
        self.living(self.pairs())
    }

    /// [`found`](Self::found) by id, without those of objects that were removed since the step.
    pub fn found_ids(&self) -> impl Iterator<Item = [Id; 2]> {
        self.living(self.found())
    }

    /// [`lost`](Self::lost) by the ids of the objects that were the pair, also if they are gone and others have their
    /// slots. Ask before you insert an object: until then these are the ids of the last two steps.
    pub fn lost_ids(&self) -> impl Iterator<Item = [Id; 2]> {
        self.lost().iter().filter_map(|pair| {
            let [a, b] = pair.map(|slot| self.former_id(slot.at()));
            Some([a?, b?])
        })
    }

    fn living(&self, pairs: &[Pair<I>]) -> impl Iterator<Item = [Id; 2]> {
        let state = &*self.parts.state;
        let some_are_new = state.objects.has_inserted != 0 && state.pairs.complete != 0;
        let new: &[u32] = if some_are_new { self.parts.former.reused.words } else { &[] };
        let id = move |slot: I| {
            let is_new = !new.is_empty() && bits::test(new, slot.at());
            if is_new { None } else { self.id_at(slot.slot()) }
        };
        pairs.iter().filter_map(move |pair| {
            let [a, b] = pair.map(id);
            Some([a?, b?])
        })
    }

    /// The object that had a slot in the complete step before the last one.
    fn former_id(&self, slot: usize) -> Option<Id> {
        let former = &self.parts.former;
        let is_reused = bits::test(former.reused.words, slot);
        let generations = if is_reused { &former.generations } else { &self.parts.generations };
        Id::new(slot as u32, generations.at(slot))
    }
}

impl<'w, I: Index> Step<'w, I> {
    /// See [`World::pair_ids`]; here none is missing.
    pub fn pair_ids(&self) -> impl Iterator<Item = [Id; 2]> + use<'w, I> {
        self.world.pair_ids()
    }

    /// See [`World::found_ids`]; here none is missing.
    pub fn found_ids(&self) -> impl Iterator<Item = [Id; 2]> + use<'w, I> {
        self.world.found_ids()
    }

    /// See [`World::lost_ids`].
    pub fn lost_ids(&self) -> impl Iterator<Item = [Id; 2]> + use<'w, I> {
        self.world.lost_ids()
    }
}
