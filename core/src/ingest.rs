//! Takes in the caller's bounds array: one pass, no copy, bad boxes found on the way.

use crate::aabb::Boxes;
use crate::access::Access;
use crate::arch::claim::{Chunks, Claims};
use crate::arch::{Phase, Simd};
use crate::exec::{self, Executor};
use crate::id::Index;
use crate::kernels::Kernels;
use crate::layout::{SLOT_BLOCKS, SLOTS_PER_BLOCK};
use crate::objects::{Motions, Objects};
use crate::storage::Parts;

/// What the pass found in a block of slots, or in all.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Intake {
    pub(crate) told: Motions,
    /// Boxes that were refused.
    pub(crate) rejected: u32,
    /// The lowest slot among them.
    pub(crate) first_rejected: u32,
}

/// Gives every living object the box that stands at its slot. Objects beyond the array keep theirs, and so do those
/// whose new box is refused.
pub(crate) fn ingest<I: Index>(
    parts: &mut Parts<'_, I>,
    bounds: &Boxes<'_>,
    kernels: Kernels,
    executor: &dyn Executor,
) -> Intake {
    let (mode, fixed_margins) = (parts.mode(), parts.state.has_fixed_margins());
    let resting = if parts.state.resting != 0 { &*parts.resting } else { &[] };
    if parts.sizes.is_small() {
        let slots = (parts.state.slots as usize).min(bounds.len());
        let now = parts.boxes.now.span_mut(0, slots);
        let (fat, margins) = (&mut *parts.boxes.fat, &*parts.boxes.margins);
        let (moved, changed) = (&mut *parts.moved, &mut *parts.changed);
        let told = Motions::default();
        let objects = Objects { now, fat, margins, moved, changed, mode, fixed_margins, told };
        return kernels.run(IngestBlock { first: 0, bounds, objects, resting });
    }
    let slots = (parts.state.slots as usize).min(bounds.len());
    // Whole words of the bit sets, whole cache lines of the boxes.
    let len = slots.div_ceil(SLOT_BLOCKS).next_multiple_of(512).max(SLOTS_PER_BLOCK);
    let margins = &*parts.boxes.margins;
    let mut found = [Intake::default(); SLOT_BLOCKS];
    let blocks = slots.div_ceil(len);
    let claims = Claims::new((
        Chunks::new(parts.boxes.now.span_mut(0, slots), len),
        Chunks::optional(parts.boxes.fat, len),
        Chunks::new(parts.moved, len / 32),
        Chunks::optional(parts.changed, len / 32),
        Chunks::new(&mut found, 1),
    ));
    exec::run(executor, parts.sizes.workers, blocks, &|| {
        while let Some((block, (now, fat, moved, changed, found))) = claims.claim() {
            let first = block * len;
            let margins = margins.get(first..).unwrap_or_default();
            let told = Motions::default();
            let objects = Objects { now, fat, margins, moved, changed, mode, fixed_margins, told };
            let resting = resting.get(first / 32..).unwrap_or_default();
            found.fill(kernels.run(IngestBlock { first, bounds, objects, resting }));
        }
    });
    let mut sum = Intake::default();
    for intake in &found {
        sum.told.crept |= intake.told.crept;
        sum.told.outran += intake.told.outran;
        if sum.rejected == 0 {
            sum.first_rejected = intake.first_rejected;
        }
        sum.rejected += intake.rejected;
    }
    sum
}

struct IngestBlock<'b, 'o> {
    first: usize,
    bounds: &'b Boxes<'b>,
    objects: Objects<'o>,
    /// The objects whose boxes are not asked for; empty where there are none.
    resting: &'b [u32],
}

impl Phase for IngestBlock<'_, '_> {
    type Output = Intake;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Intake {
        let Self { first, bounds, mut objects, resting } = self;
        let mut intake = Intake::default();
        let slots = objects.now.len();
        if resting.is_empty() {
            take_in(simd, first, bounds, &mut objects, 0..slots, 0, &mut intake);
            intake.told = objects.told;
            return intake;
        }
        for (word, &resting) in resting.iter().take(slots.div_ceil(32)).enumerate() {
            if resting != u32::MAX {
                let slots = word * 32..slots.min(word * 32 + 32);
                take_in(simd, first, bounds, &mut objects, slots, resting, &mut intake);
            }
        }
        intake.told = objects.told;
        intake
    }
}

/// Takes in the boxes of some slots, but for those whose bit is set in `resting`: bit `k` is every 32nd slot's.
#[inline(always)]
fn take_in<S: Simd>(
    simd: S,
    first: usize,
    bounds: &Boxes<'_>,
    objects: &mut Objects<'_>,
    slots: core::ops::Range<usize>,
    resting: u32,
    intake: &mut Intake,
) {
    for at in slots {
        let old = objects.now.at(at);
        if old.is_empty() || resting >> (at % 32) & 1 != 0 {
            continue;
        }
        let slot = first + at;
        match bounds.corners(slot).and_then(|[min, max]| simd.encode(min, max)) {
            Some(keys) if simd.same(keys, simd.keys(&old)) => {}
            Some(keys) => objects.change(at, simd.bounds(keys)),
            None => {
                if intake.rejected == 0 {
                    intake.first_rejected = slot as u32;
                }
                intake.rejected += 1;
            }
        }
    }
}
