//! What overlaps a box, a ball or a point.

use super::{MembersNear, is_current, key_above, key_below, parts_near, prefetch_members, prefetch_parts};
use crate::access::Access;
use crate::error::Error;
use crate::geometry::aabb::{Aabb, widened};
use crate::geometry::key::{KeyBox, value};
use crate::id::{Id, Index};
use crate::memory::prefetch::{REGION_ANSWERS, REGION_LEAVES};
use crate::simd::Simd;
use crate::simd::kernels::run;
use crate::sort::heapsort;
use crate::tree::visit::Visit;
use crate::tree::{Record, SUB_LEAVES, leaf_of};
use crate::world::World;
use core::ops::ControlFlow;

/// A closed part of space to look for objects: touching counts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Region {
    /// A box. Decided exactly.
    Aabb(Aabb),
    /// A point. Decided exactly.
    Point([f32; 3]),
    /// A ball. The squared distance is computed in `f64`. An object that does not touch the least `f32` box of the
    /// ball does not touch the ball, however the distance is rounded.
    Sphere {
        /// The centre.
        center: [f32; 3],
        /// The radius, zero or more. An infinite ball holds everything.
        radius: f32,
    },
}

impl Region {
    /// The least box around the region; `None` if the region is not valid.
    fn bounds(&self) -> Option<KeyBox> {
        match *self {
            Self::Aabb(aabb) => KeyBox::from_aabb(&aabb),
            Self::Point(point) => KeyBox::from_aabb(&Aabb::new(point, point)),
            Self::Sphere { center, radius } => {
                let valid = radius >= 0.0 && center.iter().all(|x| x.is_finite());
                let low = center.map(|x| key_below(widened(x) - widened(radius)));
                let high = center.map(|x| key_above(widened(x) + widened(radius)));
                valid.then_some(KeyBox { min: low, max: high })
            }
        }
    }

    pub(super) fn is_valid(&self) -> bool {
        self.bounds().is_some()
    }

    /// Whether a box that overlaps the region's bounds overlaps the region.
    #[inline(always)]
    fn meets(&self, bounds: &KeyBox) -> bool {
        match *self {
            Self::Aabb(_) | Self::Point(_) => true,
            Self::Sphere { center, radius } => {
                squared_distance(&center, bounds) <= widened(radius) * widened(radius)
            }
        }
    }
}

/// The squared distance from a finite point to a box, in `f64`.
#[inline(always)]
pub(super) fn squared_distance(point: &[f32; 3], bounds: &KeyBox) -> f64 {
    let gap = |k: usize| {
        let x = widened(point[k]);
        let (low, high) = (widened(value(bounds.min[k])), widened(value(bounds.max[k])));
        let gap = if x < low {
            low - x
        } else if x > high {
            x - high
        } else {
            0.0
        };
        gap * gap
    };
    gap(0) + gap(1) + gap(2)
}

/// What overlaps a box, a ball or a point.
///
/// ```
/// # use trisap_core::{Aabb, Boxes, Capacity, Cast, Config, Error, Filter, Id, InlineWorld, Region, Serial, layout};
/// # const CONFIG: Config = Config::new(Capacity::for_objects(8));
/// # let mut memory = InlineWorld::<{ layout::<u16>(&CONFIG).unwrap().bytes }>::EMPTY;
/// # let mut world = memory.init::<u16>(&CONFIG)?;
/// # let cube = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
/// # use core::ops::ControlFlow;
/// let [a, b] = [world.insert(cube(0.0))?, world.insert(cube(3.0))?];
/// let mut found = [None; 8];
/// assert_eq!(world.overlaps(&Region::Point([0.5; 3]), &mut found)?, 1);
/// assert_eq!(found[0], Some(a));
///
/// let ball = Region::Sphere { center: [2.0, 0.5, 0.5], radius: 1.0 };
/// let mut touched = None;
/// world.visit_overlaps(&ball, &mut |id| {
///     touched = Some(id);
///     ControlFlow::Break(()) // one is enough
/// })?;
/// assert!(touched == Some(a) || touched == Some(b));
/// # Ok::<(), Error>(())
/// ```
impl<I: Index> World<'_, I> {
    /// Visits the objects whose boxes overlap a region, each once, until the visitor breaks. The same calls give the
    /// same order. O(log n + answers + movers since the last step), or O(n) before there is a tree. A visitor that panics
    /// leaves the world as it was, as do those of [`visit_hits`](Self::visit_hits) and [`visit_nearest`](Self::visit_nearest) and
    /// the conditions of [`among`](Self::among): queries only look.
    ///
    /// # Errors
    /// [`Error::BadQuery`] if the region is not valid: NaN, a minimum above its maximum, a negative radius.
    pub fn visit_overlaps(
        &self,
        region: &Region,
        visit: &mut dyn FnMut(Id) -> ControlFlow<()>,
    ) -> Result<(), Error> {
        let bounds = region.bounds().ok_or(Error::BadQuery { index: 0 })?;
        run!(self.kernels, |simd| visit_region(simd, self, region, bounds, visit));
        Ok(())
    }

    /// Writes the objects whose boxes overlap a region to `out`, by ascending slot. Returns how many there are.
    ///
    /// # Errors
    /// [`Error::BadQuery`], or [`Error::OutputFull`], which says how many there are; `out` then holds some of them.
    #[doc(alias("query_aabb", "intersections_with_aabb", "aabb_intersections"))]
    pub fn overlaps(&self, region: &Region, out: &mut [Option<Id>]) -> Result<usize, Error> {
        self.overlaps_of(region, out, |_| true)
    }

    /// The same of the objects that may answer.
    pub(super) fn overlaps_of(
        &self,
        region: &Region,
        out: &mut [Option<Id>],
        condition: impl Fn(Id) -> bool,
    ) -> Result<usize, Error> {
        collected(out, &condition, |visit| self.visit_overlaps(region, visit))
    }
}

/// Writes what is visited and may answer to `out`, by ascending slot. Returns how many there are.
pub(super) fn collected(
    out: &mut [Option<Id>],
    condition: &dyn Fn(Id) -> bool,
    look: impl FnOnce(&mut dyn FnMut(Id) -> ControlFlow<()>) -> Result<(), Error>,
) -> Result<usize, Error> {
    let mut count = 0;
    look(&mut |id| {
        if condition(id) {
            if let Some(place) = out.get_mut(count) {
                *place = Some(id);
            }
            count += 1;
        }
        ControlFlow::Continue(())
    })?;
    if count > out.len() {
        return Err(Error::OutputFull { needed: count as u64, room: out.len() });
    }
    // Slots are the low half of an id, and no two ids here share one.
    let slot = |id: Option<Id>| id.map_or(0, Id::slot);
    heapsort(out.span_mut(0, count), |a, b| slot(a) < slot(b));
    Ok(count)
}

#[inline(always)]
fn visit_region<S: Simd, I: Index>(
    simd: S,
    world: &World<'_, I>,
    region: &Region,
    bounds: KeyBox,
    visit: &mut dyn FnMut(Id) -> ControlFlow<()>,
) {
    let parts = &world.parts;
    if world.has_tree() {
        let tree = &parts.tree;
        let sub_levels = parts.state.tree.sub_levels();
        let home = leaf_of(tree.splits, &bounds.min);
        let mut visits = Visit::new(simd, tree.nodes(), home, bounds);
        let mut wholes = [0; REGION_LEAVES];
        let mut near = Near {
            world,
            region,
            bounds,
            records: [Record::NOTHING; REGION_LEAVES],
            leaves: [(0, 0); REGION_LEAVES * SUB_LEAVES],
            leaf_count: 0,
            slots: [(0, false); REGION_ANSWERS],
            slot_count: 0,
        };
        loop {
            let mut count = 0;
            while let Some(place) = wholes.get_mut(count) {
                let Some(whole) = visits.next(simd) else { break };
                prefetch_parts(simd, parts, whole);
                *place = whole;
                count += 1;
            }
            for (index, &whole) in wholes.span(0, count).iter().enumerate() {
                let (record, mut mask) = parts_near(simd, parts, whole, &bounds);
                near.records.put(index, record);
                while mask != 0 {
                    let leaf = (whole << sub_levels) + mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    simd.prefetch(tree.leaves, leaf);
                    near.leaves.put(near.leaf_count, (leaf as u32, index as u32));
                    near.leaf_count += 1;
                }
            }
            if near.scan(simd, visit) {
                return;
            }
            if count < REGION_LEAVES {
                break;
            }
        }
        if near.flush(simd, visit) {
            return;
        }
    }
    if let Some(large) = world.large_objects() {
        let mut groups = large.visit(bounds);
        while let Some(group) = groups.next(simd) {
            for straddler in large.group(group) {
                let slot = straddler.slot as usize;
                if simd.overlap(&straddler.bounds, &bounds)
                    && is_current(parts, slot)
                    && meet(simd, world, region, &bounds, slot, visit)
                {
                    return;
                }
            }
        }
    }
    if world.has_apart() {
        for slot in world.apart_from_tree() {
            if meet(simd, world, region, &bounds, slot, visit) {
                return;
            }
        }
    }
}

/// Leaves that a region touches, and members that may overlap it, collected to be prefetched together.
struct Near<'n, 'm, I: Index> {
    world: &'n World<'m, I>,
    region: &'n Region,
    bounds: KeyBox,
    /// The region in the frames of whole leaves.
    records: [Record; REGION_LEAVES],
    /// A leaf, and which of these records is in its frame.
    leaves: [(u32, u32); REGION_LEAVES * SUB_LEAVES],
    leaf_count: usize,
    /// A slot, and whether the object certainly overlaps the region.
    slots: [(usize, bool); REGION_ANSWERS],
    slot_count: usize,
}

impl<I: Index> Near<'_, '_, I> {
    /// Looks for objects in the leaves. Returns whether to stop.
    #[inline(always)]
    fn scan<S: Simd>(&mut self, simd: S, visit: &mut dyn FnMut(Id) -> ControlFlow<()>) -> bool {
        let parts = &self.world.parts;
        // Records are those of swept boxes. Without margins these are the boxes themselves, so records can decide.
        let decides = parts.boxes.fat.is_empty() && !matches!(self.region, Region::Sphere { .. });
        for index in 0..self.leaf_count {
            prefetch_members(simd, parts, self.leaves.at(index).0 as usize);
        }
        for index in 0..self.leaf_count {
            let (leaf, record) = self.leaves.at(index);
            let region = self.records.at(record as usize);
            let mut members = MembersNear::new(simd, parts, leaf as usize, region);
            while let Some((slot, certain)) = members.next() {
                let certain = certain && decides;
                if !certain {
                    simd.prefetch(parts.boxes.now, slot);
                }
                simd.prefetch(parts.generations, slot);
                self.slots.put(self.slot_count, (slot, certain));
                self.slot_count += 1;
                if self.slot_count == REGION_ANSWERS && self.flush(simd, visit) {
                    return true;
                }
            }
        }
        self.leaf_count = 0;
        false
    }

    /// Visits the objects that overlap the region. Returns whether to stop.
    #[inline(always)]
    fn flush<S: Simd>(&mut self, simd: S, visit: &mut dyn FnMut(Id) -> ControlFlow<()>) -> bool {
        let Self { world, region, bounds, .. } = *self;
        for &(slot, certain) in self.slots.span(0, self.slot_count) {
            let stop = if certain {
                world.id_of(slot).is_some_and(|id| visit(id).is_break())
            } else {
                meet(simd, world, region, &bounds, slot, visit)
            };
            if stop {
                return true;
            }
        }
        self.slot_count = 0;
        false
    }
}

/// Visits an object if it overlaps the region. Returns whether to stop.
#[inline(always)]
fn meet<S: Simd, I: Index>(
    simd: S,
    world: &World<'_, I>,
    region: &Region,
    bounds: &KeyBox,
    slot: usize,
    visit: &mut dyn FnMut(Id) -> ControlFlow<()>,
) -> bool {
    let now = KeyBox::of(world.parts.boxes.now, slot);
    let overlaps = simd.overlap(now, bounds) && region.meets(now);
    overlaps && world.id_of(slot).is_some_and(|id| visit(id).is_break())
}
