//! Takes in the caller's bounds array: one pass, no copy, bad boxes found on the way.

use crate::access::Access;
use crate::geometry::aabb::Boxes;
use crate::id::Index;
use crate::memory::limits::{SLOT_BLOCKS, block_len};
use crate::memory::slab::Parts;
use crate::objects::{FatBoxes, Motions, Objects};
use crate::parallel::block_queue::{BlockQueue, Chunks};
use crate::parallel::executor::{self, Executor};
use crate::simd::kernels::Kernels;
use crate::simd::{Phase, Simd};

/// What the pass found in a block of slots, or in all.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Intake {
    pub(crate) motions: Motions,
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
    let (mode, fixed_margins) = (parts.mode(), parts.state.setup.has_fixed_margins());
    let resting = if parts.state.objects.resting != 0 { &*parts.resting } else { &[] };
    if parts.sizes.is_small() {
        let slots = (parts.state.objects.slots as usize).min(bounds.len());
        let now = parts.boxes.now.span_mut(0, slots);
        let (fat, margins) = (&mut *parts.boxes.fat, &*parts.boxes.margins);
        let (moved, changed) = (parts.moved.reborrow(), parts.changed.reborrow());
        let fat = FatBoxes { boxes: fat, margins, fixed_margins, motions: Motions::default() };
        let objects = Objects { now, fat, moved, changed, mode };
        return kernels.run(IngestBlock { first: 0, bounds, objects, resting });
    }
    let slots = (parts.state.objects.slots as usize).min(bounds.len());
    let len = block_len(slots);
    let margins = &*parts.boxes.margins;
    let mut found = [Intake::default(); SLOT_BLOCKS];
    let claims = BlockQueue::new((
        Chunks::new(parts.boxes.now.span_mut(0, slots), len),
        Chunks::optional(parts.boxes.fat, len),
        parts.moved.blocks(len),
        parts.changed.blocks(len),
        Chunks::new(&mut found, 1),
    ));
    executor::run(executor, parts.sizes.workers, claims.count(), &|| {
        while let Some((block, (now, fat, moved, changed, found))) = claims.claim() {
            let first = block * len;
            let margins = margins.get(first..).unwrap_or_default();
            let fat = FatBoxes { boxes: fat, margins, fixed_margins, motions: Motions::default() };
            let objects = Objects { now, fat, moved: moved.into(), changed: changed.into(), mode };
            let resting = resting.get(first / 32..).unwrap_or_default();
            found.fill(kernels.run(IngestBlock { first, bounds, objects, resting }));
        }
    });
    let mut sum = Intake::default();
    for intake in &found {
        sum.motions.moved_inside_margin |= intake.motions.moved_inside_margin;
        sum.motions.outran += intake.motions.outran;
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
        for word in 0..objects.now.len().div_ceil(32) {
            let resting = resting.get(word).copied().unwrap_or_default();
            if resting != u32::MAX {
                take_in(simd, first, bounds, &mut objects, word, resting, &mut intake);
            }
        }
        intake.motions = objects.fat.motions;
        intake
    }
}

/// Takes in the boxes of the slots of a word of the bit sets, but for those whose bit is set in `resting`.
#[inline(always)]
fn take_in<S: Simd>(
    simd: S,
    first: usize,
    bounds: &Boxes<'_>,
    objects: &mut Objects<'_>,
    word: usize,
    resting: u32,
    intake: &mut Intake,
) {
    let Objects { now, fat, .. } = objects;
    let end = now.len().min(word * 32 + 32);
    let now = now.get_mut(word * 32..end).unwrap_or_default();
    // Noted for all of them at once, since a small processor takes as long to set a bit in memory as to compare a box; and
    // shifted in, since it has few registers.
    let (mut changed, mut contained, mut resting, unused) = (0u32, 0, resting, 32 - now.len());
    let mut items = bounds.items_from(first + word * 32);
    for (at, old) in (word * 32..).zip(now) {
        let item = items;
        items = bounds.items_after(items);
        let skipped = resting & 1 != 0 || old.is_empty();
        (changed, resting) = (changed >> 1, resting >> 1);
        if skipped {
            continue;
        }
        match bounds.corners(item).and_then(|[min, max]| simd.encode(min, max)) {
            Some(keys) if simd.same(keys, simd.keys(old)) => {}
            Some(keys) => {
                let bounds = simd.bounds(keys);
                if fat.exist() {
                    contained |= u32::from(fat.follow(at, old, &bounds)) << (at % 32);
                }
                *old = bounds;
                changed |= 1 << 31;
            }
            None => {
                if intake.rejected == 0 {
                    intake.first_rejected = (first + at) as u32;
                }
                intake.rejected += 1;
            }
        }
    }
    objects.note(word, changed.checked_shr(unused as u32).unwrap_or_default(), contained);
}
