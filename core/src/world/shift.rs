//! Moves the origin of a world close to its boxes, where `f32` is precise.

use crate::access::Access;
use crate::error::Error;
use crate::geometry::aabb::{Aabb, round_down, round_up, widened};
use crate::geometry::key::{KeyBox, key, value};
use crate::id::Index;
use crate::tree::{Split, axis_of, key_of, plane};
use crate::world::World;

/// Large scenes.
impl<I: Index> World<'_, I> {
    /// Moves the origin to the point `by`: subtracts it from all boxes. Give boxes relative to the new origin
    /// from then on. The next step fills all leaves anew. O(n).
    ///
    /// If a difference is no `f32`, minima are rounded down and maxima up: no pair is lost, but boxes may
    /// come to overlap. Returns the number of objects whose boxes were rounded. It is zero for shifts by
    /// multiples of the finest step of all coordinates, and then pairs and events are as without a shift.
    /// Infinite bounds stay infinite, and bounds that leave the range of `f32` become infinite outwards.
    ///
    /// Fat boxes are shifted too, not made anew. So a shift alone does not change the pairs in
    /// [`Mode::Fat`](crate::Mode::Fat) either, unless fat boxes are rounded; these are not counted.
    ///
    /// To win back precision that boxes have lost far from the origin, give them again from `f64`:
    ///
    /// ```
    /// use trisap_core::{Aabb, Capacity, Config, InlineWorld, layout};
    ///
    /// const CONFIG: Config = Config::new(Capacity::for_objects(16)).with_events();
    /// const BYTES: usize = layout::<u16>(&CONFIG).unwrap().bytes;
    ///
    /// // A metre apart, a million kilometres out.
    /// let cube = |x: f64, o: f64| Aabb::from_f64([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0], [o, 0.0, 0.0]);
    /// let mut memory = InlineWorld::<BYTES>::EMPTY;
    /// let mut world = memory.init::<u16>(&CONFIG)?;
    /// let ids = [world.insert(cube(1e9, 0.0))?, world.insert(cube(1e9 + 2.0, 0.0))?];
    /// assert_eq!(world.step()?.pairs(), [[0, 1]]);
    ///
    /// assert_eq!(world.shift_origin([1e9, 0.0, 0.0])?, 0);
    /// assert!(world.step()?.lost().is_empty());
    /// world.set_aabb(ids[0], cube(1e9, 1e9))?;
    /// world.set_aabb(ids[1], cube(1e9 + 2.0, 1e9))?;
    /// assert_eq!(world.step()?.lost(), [[0, 1]]);
    /// # Ok::<(), trisap_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::BadShift`] where a part of `by` is not finite.
    #[doc(alias = "floating_origin")]
    pub fn shift_origin(&mut self, by: [f64; 3]) -> Result<u32, Error> {
        if !by.iter().all(|x| x.is_finite()) {
            return Err(Error::BadShift);
        }
        let parts = &mut self.parts;
        let mut rounded = 0;
        for slot in 0..parts.state.objects.slots as usize {
            let now = parts.boxes.now.at(slot);
            if now.is_free() {
                continue;
            }
            // The boxes of the last complete step stay unshifted, since they are only compared with each
            // other. So events are exact even if boxes are rounded.
            let (bounds, exact) = shifted(parts.bounds(slot), by);
            let mut objects = parts.objects();
            objects.touch(slot);
            if now.is_empty() {
                objects.hide(slot, bounds);
            } else {
                // Rounding keeps the order of numbers, so each box still holds what it held.
                for boxes in [objects.now, objects.given, objects.fat.boxes] {
                    if let Some(bounds) = boxes.get_mut(slot) {
                        (*bounds, _) = shifted(*bounds, by);
                    }
                }
            }
            rounded += u32::from(!exact);
        }
        // Records are as the old origin had them.
        parts.state.tree.filled = 0;
        let nodes = parts.tree.splits.iter_mut().take(2 * parts.state.tree.count as usize).skip(1);
        for Split { plane, .. } in nodes.filter(|node| node.as_leaf().is_none()) {
            let axis = axis_of(*plane);
            *plane = self::plane(axis, key(round_down(widened(value(key_of(*plane))), by[axis])));
        }
        (parts.state.tree.extent, _) = shifted(parts.state.tree.extent, by);
        Ok(rounded)
    }
}

/// The least box that holds a box, relative to another origin; and whether it is exact.
fn shifted(bounds: KeyBox, by: [f64; 3]) -> (KeyBox, bool) {
    let Aabb { min, max } = bounds.to_aabb();
    let (mut low, mut high) = (min, max);
    let mut exact = true;
    for k in 0..3 {
        let (min, max) = (widened(min[k]), widened(max[k]));
        low[k] = round_down(min, by[k]);
        high[k] = round_up(max, by[k]);
        // By keys, since a host may take two denormals for equal.
        exact &= key(low[k]) == key(round_up(min, by[k])) && key(high[k]) == key(round_down(max, by[k]));
    }
    // Never NaN and never out of order, since `by` is finite.
    (KeyBox::from_aabb(&Aabb::new(low, high)).unwrap_or(bounds), exact)
}
