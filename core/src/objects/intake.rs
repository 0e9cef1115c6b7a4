//! Takes in the caller's bounds array: one pass, no copy, bad boxes found on the way.

use crate::access::{Access, bits};
use crate::config::{EVENTS as HAS_EVENTS, Mode};
use crate::geometry::boxes::{Boxes, CORNER};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::limits::{SLOT_BLOCKS, block_len};
use crate::memory::slab::Parts;
use crate::objects::Objects;
use crate::objects::margins::{FatBoxes, Motions};
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::simd::kernels::{Kernels, run};
use crate::simd::{Simd, call};

/// What the pass found in a block of slots, or in all.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Intake {
    pub(crate) motions: Motions,
    /// Boxes that were refused.
    pub(crate) rejected: u32,
    /// The lowest slot among them.
    pub(crate) first_rejected: u32,
}

impl Intake {
    #[cold]
    #[inline(never)]
    fn reject(&mut self, slot: usize) {
        if self.rejected == 0 {
            self.first_rejected = slot as u32;
        }
        self.rejected += 1;
    }
}

/// Gives every living object the box that stands at its slot. Objects beyond the array keep theirs, and so do
/// objects whose new box is refused.
pub(crate) fn ingest<I: Index>(
    parts: &mut Parts<'_, I>,
    bounds: &Boxes<'_>,
    context: StepContext<'_>,
) -> Intake {
    let slots = (parts.state.objects.slots as usize).min(bounds.len());
    if parts.sizes.is_small() {
        let mut objects = parts.objects();
        objects.now = core::mem::take(&mut objects.now).span_mut(0, slots);
        return ingest_block(context.kernels, 0, bounds, objects);
    }
    let mut sum = Intake::default();
    for intake in ingest_blocks(parts, bounds, slots, context) {
        sum.motions.moved_inside_margin |= intake.motions.moved_inside_margin;
        sum.motions.outran += intake.motions.outran;
        if sum.rejected == 0 {
            sum.first_rejected = intake.first_rejected;
        }
        sum.rejected += intake.rejected;
    }
    sum
}

/// Takes in the first slots of a world with a tree, in blocks.
// Its stack frame does not stand below the sweep's.
#[inline(never)]
fn ingest_blocks<I: Index>(
    parts: &mut Parts<'_, I>,
    bounds: &Boxes<'_>,
    slots: usize,
    context: StepContext<'_>,
) -> [Intake; SLOT_BLOCKS] {
    let len = block_len(slots);
    let (mode, (predicted, renews)) = (parts.mode(), parts.fat_boxes());
    let resting = if parts.state.objects.resting != 0 { &*parts.resting } else { &[] };
    let fat = if parts.boxes.tight { &mut [] } else { &mut *parts.boxes.fat };
    let margins = &*parts.boxes.margins;
    let mut found = [Intake::default(); SLOT_BLOCKS];
    let blocks = (
        Chunks::new(parts.boxes.now.span_mut(0, slots), len),
        Chunks::optional(fat, len),
        Chunks::optional(parts.boxes.before, len),
        (parts.moved.blocks(len), parts.changed.blocks(len)),
        Chunks::new(&mut found, 1),
    );
    context.each(blocks, |block, (now, fat, before, (moved, changed), found)| {
        let first = block * len;
        let margins = margins.get(first..).unwrap_or_default();
        let fat = FatBoxes { boxes: fat, margins, predicted, renews, motions: Motions::default() };
        let (moved, changed) = (moved.into(), changed.into());
        let resting = resting.get(first / 32..).unwrap_or_default();
        let objects = Objects { now, cut: &mut [], fat, moved, changed, before, resting, mode };
        found.fill(ingest_block(context.kernels, first, bounds, objects));
    });
    found
}

/// Takes in the boxes of some consecutive slots.
fn ingest_block(kernels: Kernels, first: usize, bounds: &Boxes<'_>, objects: Objects<'_>) -> Intake {
    run!(kernels, |simd| take_in_words(simd, first, bounds, objects))
}

#[inline(always)]
fn take_in_words<S: Simd>(simd: S, first: usize, bounds: &Boxes<'_>, mut objects: Objects<'_>) -> Intake {
    let mut intake = Intake::default();
    let words = objects.now.len().div_ceil(32);
    // A pool of objects that are not used.
    let all_rest = objects.resting.get(..words).is_some_and(|all| all.iter().all(|word| *word == u32::MAX));
    for word in 0..if all_rest { 0 } else { words } {
        if objects.resting.get(word) == Some(&u32::MAX) {
            continue;
        }
        if !HAS_EVENTS || objects.before.is_empty() {
            take_in::<S, false>(simd, first, bounds, &mut objects, word, &mut intake);
        } else {
            take_in::<S, true>(simd, first, bounds, &mut objects, word, &mut intake);
        }
    }
    intake.motions = objects.fat.motions;
    intake
}

/// Takes in the boxes of the slots of a word of the bit sets, but for resting ones.
#[inline(always)]
fn take_in<S: Simd, const EVENTS: bool>(
    simd: S,
    first: usize,
    bounds: &Boxes<'_>,
    objects: &mut Objects<'_>,
    word: usize,
    intake: &mut Intake,
) {
    let Objects { now, fat, changed: kept, before, resting, mode, .. } = objects;
    let end = now.len().min(word * 32 + 32);
    let now = now.get_mut(word * 32..end).unwrap_or_default();
    // The boxes that events compare with are kept where they have not changed since the last complete step.
    let before = before.get_mut(word * 32..end).unwrap_or_default();
    let kept = if EVENTS { kept.words.at(word) } else { u32::MAX };
    // Noted for all of them at once, since a small processor takes as long to set a bit in memory as to
    // compare a box.
    let (mut changed, mut contained, unused) = (0u32, 0u32, 32 - now.len());
    let mut items = bounds.items_from(first + word * 32);
    let (mut skipped, mut four_changed) = (resting.get(word).copied().unwrap_or_default(), 0);
    if S::ENCODES_FOUR {
        let fours = Fours { bounds, items, now, before, kept, skipped, fat, first: word * 32, mode: *mode };
        // One call for all kinds of worlds in a module for the web, whose bytes are loaded over a network;
        // and one for worlds with fat boxes, so that others pay nothing for them.
        let (taken, others, stay) = if cfg!(target_family = "wasm") || fours.fat.exist() {
            call!(simd, take_in_fours::<S, true, true>(simd, fours))
        } else {
            take_in_fours::<S, EVENTS, false>(simd, fours)
        };
        if taken == u32::MAX >> unused {
            return objects.note(word, others, stay);
        }
        (skipped, four_changed, contained) = (skipped | taken, others, stay);
    }
    for (bit, old) in (0..32).zip(now) {
        let (item, this) = (items, 1u32 << bit);
        items = bounds.items_after(1, items);
        if skipped & this != 0 || old.is_empty() {
            continue;
        }
        let Some(bounds) = bounds.first(item).and_then(|aabb| KeyBox::from_aabb(&aabb)) else {
            intake.reject(first + word * 32 + bit);
            continue;
        };
        if bounds.is_same(old) {
            continue;
        }
        if EVENTS && kept & this == 0 {
            // Number by number: a copy from one slice to another would be a call.
            let ([a, b, c], [d, e, f]) = (old.min, old.max);
            let old = KeyBox { min: [a, b, c], max: [d, e, f] };
            before.put(bit, fat.reported(*mode, word * 32 + bit, &old));
        }
        if fat.exist() && fat.follow_apart(word * 32 + bit, old, &bounds) {
            contained |= this;
        }
        *old = bounds;
        changed |= this;
    }
    objects.note(word, changed | four_changed, contained)
}

/// The boxes of the slots of a word, to be taken in four at a time.
struct Fours<'f, 'b, 'o> {
    bounds: &'f Boxes<'b>,
    items: &'b [u8],
    now: &'f mut [KeyBox],
    before: &'f mut [KeyBox],
    kept: u32,
    /// The bits of slots that are not asked for.
    skipped: u32,
    fat: &'f mut FatBoxes<'o>,
    /// The first slot of the word.
    first: usize,
    mode: Mode,
}

/// Takes in boxes of the slots of a word four at a time, where all four are good, and of objects that live
/// and do not rest. Returns the bits of the slots that are done with, of slots among them that have other
/// boxes now, and of slots that stay in their fat boxes.
#[inline(always)]
fn take_in_fours<S: Simd, const EVENTS: bool, const FAT: bool>(
    simd: S,
    fours: Fours<'_, '_, '_>,
) -> (u32, u32, u32) {
    let Fours { bounds, mut items, now, before, kept, skipped, fat, first: word, mode } = fours;
    let (mut taken, mut changed, mut contained, mut lie) = (0, 0, 0, false);
    let (all, mut room) = ([KeyBox::ALL; 4], [0; 8 * CORNER]);
    let before = before.as_chunks_mut::<4>().0;
    for (four, old) in now.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let first = 4 * four;
        let Some(boxes) = bounds.four(items, &mut room) else { break };
        items = bounds.items_after(4, items);
        if skipped >> first & 0b1111 != 0 {
            continue;
        }
        let mut new = [KeyBox::EMPTY; 4];
        // In most steps all stay in their fat boxes. Where four lie still, the next ones probably do.
        let held = if FAT && !fat.renews { fat.boxes.get(word + first..) } else { None };
        let quiet = match held.and_then(|held| held.first_chunk()) {
            Some(held) => match if lie { simd.encode_four(boxes, old, old, &mut new) } else { None } {
                None => simd.encode_four(boxes, held, old, &mut new),
                same => same,
            },
            None => None,
        };
        lie = quiet == Some(0);
        let others = match quiet {
            Some(others) => others,
            None => match simd.encode_four(boxes, &all, old, &mut new) {
                Some(others) => others,
                None => continue,
            },
        };
        let unkept = others & !(kept >> first);
        if unkept == 0b1111
            && (!FAT || mode == Mode::Exact)
            && let Some(before) = before.get_mut(four)
        {
            *before = *old;
        } else if EVENTS && let Some(before) = before.get_mut(four) {
            for bit in bits::of_word(unkept) {
                let old = KeyBox::of(old, bit);
                before.put(bit, if FAT { fat.reported(mode, word + first + bit, old) } else { *old });
            }
        }
        if quiet.is_some() {
            fat.motions.moved_inside_margin |= others != 0;
            contained |= others << first;
        } else if FAT && fat.renew_four(word + first, old, &new, others) {
        } else if FAT && fat.exist() {
            for bit in bits::of_word(others) {
                let (old, new) = (KeyBox::of(old, bit), KeyBox::of(&new, bit));
                contained |= u32::from(fat.follow(word + first + bit, old, new)) << (first + bit);
            }
        }
        *old = new;
        taken |= 0b1111 << first;
        changed |= others << first;
    }
    (taken, changed, contained)
}
