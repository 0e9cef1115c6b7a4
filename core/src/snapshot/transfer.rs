//! Moves a world into another configuration: its objects, and what the next step compares its pairs with. The tree
//! stays behind.

use crate::access::{Access, bits};
use crate::config::{Config, Mode};
use crate::error::{Error, Field};
use crate::geometry::key::KeyBox;
use crate::id::{Index, Pair};
use crate::memory::layout::Sizes;
use crate::memory::slab::Parts;
use crate::memory::state::{Setup, State};
use crate::validate::content::{Content, InSlab, Set};
use crate::validate::pairs::previous;
use crate::world::World;

/// Growth.
impl<I: Index> World<'_, I> {
    /// Moves the world to other memory and another configuration: larger, or smaller if all fits. `slab` is as for
    /// [`new_in`](Self::new_in); what was in it is gone. This world stays as it is. O(bytes of the new slab).
    ///
    /// Everything goes on: ids, boxes, margins, filters, values, rest, and the last result, so the next step tells
    /// what is found and lost since. After [`Error::PairsFull`] the world can move to where there is room for the
    /// pairs; a step there tells events as if there had always been room. Only the tree is built anew, by the next
    /// step in which an object has moved.
    ///
    /// Capacities, workers, the margin of new objects and all choices about speed may change. The mode, events,
    /// filters, values and whether there are margins may not.
    ///
    /// # Errors
    /// [`Error::NoRoom`], which says what does not fit; [`Error::OtherConfig`]; the errors of `new_in`. Nothing is
    /// written then.
    ///
    /// ```
    /// use trisap_core::{Aabb, Capacity, Config, Error, InlineWorld, layout};
    ///
    /// const FEW: Config = Config::new(Capacity::for_objects(2).with_pairs(1)).with_events();
    /// const MORE: Config = Config::new(Capacity::for_objects(4).with_pairs(6)).with_events();
    /// let mut memory = InlineWorld::<{ layout::<u16>(&FEW).unwrap().bytes }>::EMPTY;
    /// let mut larger = InlineWorld::<{ layout::<u16>(&MORE).unwrap().bytes }>::EMPTY;
    ///
    /// let cube = Aabb::new([0.0; 3], [1.0; 3]);
    /// let mut world = memory.init::<u16>(&FEW)?;
    /// let ids = [world.insert(cube)?, world.insert(cube)?];
    /// world.step()?;
    /// assert_eq!(world.insert(cube), Err(Error::ObjectsFull { needed: 3, room: 2 }));
    ///
    /// let mut world = larger.receive(&world, &MORE)?;
    /// world.insert(cube)?;
    /// assert!(world.contains(ids[1]));
    /// assert_eq!(world.step()?.found().len(), 2);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn move_into<'n>(&self, slab: &'n mut [u8], config: &Config) -> Result<World<'n, I>, Error> {
        let sizes = Parts::<I>::sizes(config)?;
        let setup = Setup::new(config, size_of::<I>());
        if let Some(field) = self.parts.state.setup.difference(&setup) {
            return Err(Error::OtherConfig { field });
        }
        check_room(self.parts.state, &sizes)?;
        let mut world = World::new_in(slab, config)?;
        transfer(&InSlab(&self.parts), &mut world.parts);
        Ok(world)
    }
}

/// Checks that there is room for a world, its surplus aside, which can be found anew.
pub(super) fn check_room(from: &State, sizes: &Sizes) -> Result<(), Error> {
    let check = |field, needed: u64, room: usize| {
        let room = u32::try_from(room).unwrap_or(u32::MAX);
        // All counts fit into 32 bits.
        let needed = u32::try_from(needed).unwrap_or(u32::MAX);
        if needed > room { Err(Error::NoRoom { field, needed, room }) } else { Ok(()) }
    };
    check(Field::Objects, u64::from(from.objects.slots), sizes.objects)?;
    check(Field::Pairs, from.pairs.reported.max(of_the_step_before(from)), sizes.pairs)
}

/// The pairs of the step before: those that the last step lost, or all if it had no room for its pairs.
fn of_the_step_before(state: &State) -> u64 {
    // Parked pairs are not in the other buffer.
    let parked = if state.pairs.complete == 0 {
        u64::from(state.pairs.parked - state.pairs.surplus_parked)
    } else {
        0
    };
    previous(state) + parked
}

/// Moves everything into an empty world with enough room.
pub(super) fn transfer<I: Index>(from: &impl Content<I>, to: &mut Parts<'_, I>) {
    let state = from.state();
    *to.state = to.state.with_objects_of(state);
    to.boxes.tight = false;
    objects(from, to);
    sets(from, to);
    pairs(from, to);
    if to.sizes.previous > 0 {
        let mut end = 0;
        let previous = (0..previous(state) as usize).map(|at| from.previous(at));
        let parked = state.pairs.result().start..state.pairs.parked as usize;
        let parked = if state.pairs.complete == 0 { parked } else { 0..0 };
        for pair in previous.chain(parked.map(|at| from.pair(at))) {
            to.output.previous.put(end, pair);
            end += 1;
        }
        to.state.pairs.previous = end as u64;
    }
}

/// Everything by slot.
fn objects<I: Index>(from: &impl Content<I>, to: &mut Parts<'_, I>) {
    let fat = from.state().setup.mode() == Mode::Fat && !to.boxes.fat.is_empty();
    let (mut rank, mut former) = (0, 0);
    to.boxes.margins.fill(0.0);
    to.filters.of.fill(Default::default());
    to.values.of.fill(0);
    for slot in 0..from.state().objects.slots as usize {
        to.boxes.now.put(slot, from.now(slot));
        to.generations.put(slot, from.generation(slot));
        if !to.boxes.fat.is_empty() {
            let fat = from.fat(slot);
            to.boxes.fat.put(slot, if fat.is_empty() { KeyBox::EMPTY } else { fat });
            to.boxes.margins.put(slot, from.margin(slot));
        }
        if !to.filters.of.is_empty() {
            to.filters.of.put(slot, from.filter(slot));
        }
        if !to.values.of.is_empty() {
            to.values.of.put(slot, from.value(slot));
        }
        if !to.boxes.before.is_empty() {
            let changed = from.is_in(Set::Changed, slot);
            let reported = if fat { from.fat(slot) } else { from.now(slot) };
            to.boxes.before.put(slot, if changed { from.before(slot, rank) } else { reported });
            rank += usize::from(changed);
            if from.is_in(Set::Reused, slot) {
                to.former.generations.put(slot, from.former(slot, former));
                if !to.values.former.is_empty() {
                    to.values.former.put(slot, from.former_value(slot, former));
                }
                former += 1;
            }
        }
    }
    for class in 0..to.filters.classes.len() {
        to.filters.classes.put(class, from.class(class));
    }
}

/// The sets of slots.
fn sets<I: Index>(from: &impl Content<I>, to: &mut Parts<'_, I>) {
    let slots = from.state().objects.slots as usize;
    let known = from.word(Set::Changed, 0).is_some();
    for index in 0..bits::words(slots) {
        let word = |set| from.word(set, index).unwrap_or_default();
        to.resting.put(index, word(Set::Resting));
        to.moved.add(index, word(Set::Moved));
        to.filters.changed.add(index, word(Set::Refiltered));
        to.former.reused.add(index, word(Set::Reused));
        // If the old world does not note which objects moved inside their margins, any object may have.
        let anybody = u32::MAX >> 32usize.saturating_sub(slots - index * 32).min(31);
        let changed = match from.state().objects.moved_inside_margin {
            _ if known => word(Set::Changed),
            0 => word(Set::Moved),
            _ => anybody,
        };
        to.changed.add(index, changed);
    }
}

/// The pairs, none of them parked: result, surplus.
fn pairs<I: Index>(from: &impl Content<I>, to: &mut Parts<'_, I>) {
    let state = from.state();
    let (result, swept) = (state.pairs.result(), state.pairs.swept as usize);
    let fits = swept <= to.sizes.pairs;
    let surplus = (0..result.start).chain(result.end..swept);
    let surplus = if fits { surplus } else { (0..0).chain(0..0) };
    let mut end = 0;
    let mut put = |pair: Pair<I>| {
        to.output.pairs.put(end, pair);
        end += 1;
    };
    result.chain(surplus).for_each(|at| put(from.pair(at)));
    to.state.pairs.swept = end as u64;
    // Then the next step cannot keep pairs of fat boxes.
    to.state.pairs.without_surplus |= u8::from(!fits);
}
