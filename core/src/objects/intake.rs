//! Takes in the caller's bounds array: one pass, no copy, bad boxes found on the way.

use crate::access::{Access, bits};
use crate::config::{EVENTS, MARGINS};
use crate::geometry::boxes::{Boxes, CORNER};
use crate::geometry::key::KeyBox;
use crate::id::Index;
use crate::memory::layout::reports_margins;
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
/// objects whose new box is refused. In a fat world each new box `regrows` the one that is reported, or not.
pub(crate) fn ingest<I: Index>(
    parts: &mut Parts<'_, I>,
    bounds: &Boxes<'_>,
    regrows: bool,
    context: StepContext<'_>,
) -> Intake {
    let slots = (parts.state.objects.slots as usize).min(bounds.len());
    if parts.sizes.is_small() {
        let mut objects = parts.objects();
        objects.now = core::mem::take(&mut objects.now).span_mut(0, slots);
        objects.fat.regrows = regrows;
        return ingest_block(context.kernels, 0, bounds, objects);
    }
    let mut sum = Intake::default();
    for intake in ingest_blocks(parts, bounds, (slots, regrows), context) {
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
    (slots, regrows): (usize, bool),
    context: StepContext<'_>,
) -> [Intake; SLOT_BLOCKS] {
    let ((predicted, renews), len) = (parts.fat_boxes(), block_len(slots));
    let reports_margins = reports_margins(parts.config());
    let resting = if parts.state.objects.resting != 0 { &*parts.resting } else { &[] };
    let fat = if parts.boxes.tight { &mut [] } else { &mut *parts.boxes.fat };
    let margins = &*parts.boxes.margins;
    let mut found = [Intake::default(); SLOT_BLOCKS];
    let blocks = (
        (Chunks::new(parts.boxes.now.span_mut(0, slots), len), Chunks::optional(parts.boxes.given, len)),
        Chunks::optional(fat, len),
        Chunks::optional(parts.boxes.before, len),
        (parts.moved.blocks(len), parts.changed.blocks(len)),
        Chunks::new(&mut found, 1),
    );
    context.each(blocks, |block, ((now, given), fat, before, (moved, changed), found)| {
        let first = block * len;
        let margins = margins.get(first..).unwrap_or_default();
        let motions = Motions::default();
        let fat = FatBoxes { boxes: fat, margins, reports_margins, predicted, renews, regrows, motions };
        let (moved, changed) = (moved.into(), changed.into());
        let resting = resting.get(first / 32..).unwrap_or_default();
        let objects = Objects { now, cut: &mut [], given, fat, moved, changed, before, resting };
        found.fill(ingest_block(context.kernels, first, bounds, objects));
    });
    found
}

/// Takes in the boxes of some consecutive slots.
#[cfg_attr(not(feature = "large"), inline(always))]
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
        take_in(simd, first, bounds, &mut objects, word, &mut intake);
    }
    intake.motions = objects.fat.motions;
    intake
}

/// Takes in the boxes of the slots of a word of the bit sets, but for resting ones.
#[inline(always)]
fn take_in<S: Simd>(
    simd: S,
    first: usize,
    bounds: &Boxes<'_>,
    objects: &mut Objects<'_>,
    word: usize,
    intake: &mut Intake,
) {
    let count = (objects.now.len() - word * 32).min(32);
    let mut skipped = objects.resting.get(word).copied().unwrap_or_default();
    // Noted for all of them at once, since a small processor takes as long to set a bit in memory as to
    // compare a box.
    let (mut changed, mut contained, is_fat) = (0u32, 0u32, objects.is_fat());
    let (has_fat, has_events) = (objects.fat.exist(), EVENTS && !objects.before.is_empty());
    if S::ENCODES_FOUR {
        // One call for all kinds of worlds in a module for the web, whose bytes are loaded over a network;
        // and some for worlds with fat boxes and fat worlds, so that others pay nothing for them.
        let of = &mut *objects;
        let (taken, others, stay) = if MARGINS && (cfg!(target_family = "wasm") || is_fat) {
            call!(simd, take_in_fours::<S, true, true, true>(simd, first, bounds, of, word))
        } else if cfg!(target_family = "wasm") || has_fat {
            call!(simd, take_in_fours::<S, true, true, false>(simd, first, bounds, of, word))
        } else if has_events {
            take_in_fours::<S, true, false, false>(simd, first, bounds, of, word)
        } else {
            take_in_fours::<S, false, false, false>(simd, first, bounds, of, word)
        };
        if taken == u32::MAX >> (32 - count) {
            return objects.note(word, others, stay);
        }
        (skipped, changed, contained) = (skipped | taken, others, stay);
    }
    let at = word * 32;
    let Objects { now, given, fat, before, changed: kept, .. } = objects;
    // The boxes that events compare with are kept where they have not changed since the last complete step.
    let unkept = if has_events { !kept.words.at(word) } else { 0 };
    let has_margins = is_fat || has_fat;
    let apart = if has_margins { u32::MAX } else { unkept };
    for (bit, old) in (at..).zip(now.span_mut(at, count)) {
        let this = 1u32 << (bit % 32);
        if skipped & this != 0 || old.is_empty() {
            continue;
        }
        let room;
        let aabb = match bounds.packed.get(first + bit) {
            Some(aabb) => Some(aabb),
            None => {
                room = bounds.apart(first + bit);
                room.as_ref()
            }
        };
        let Some(new) = aabb.and_then(KeyBox::from_aabb) else {
            intake.reject(first + bit);
            continue;
        };
        if new.is_same(old) && !is_fat {
            continue;
        }
        if apart & this != 0 {
            let before = if unkept & this != 0 { before.get_mut(bit) } else { None };
            if has_margins {
                // In a function of its own, which is lent copies, so that the loop stays in registers.
                let (mut fat_boxes, to) = (FatBoxes { boxes: &mut *fat.boxes, ..*fat }, new);
                if let Some(stays) = fat_boxes.replace(given, bit, old, &to, before) {
                    (changed, contained) = (changed | this, contained | if stays { this } else { 0 });
                }
                fat.motions = fat_boxes.motions;
                continue;
            }
            if let Some(before) = before {
                // Number by number: a copy from one slice to another would be a call.
                let ([a, b, c], [d, e, f]) = (old.min, old.max);
                *before = KeyBox { min: [a, b, c], max: [d, e, f] };
            }
        }
        *old = new;
        changed |= this;
    }
    objects.note(word, changed, contained)
}

/// Takes in boxes of the slots of a word four at a time, where all four are good, and of objects that live
/// and do not rest. Returns the bits of the slots that are done with, of slots among them that have other
/// boxes now, and of slots that stay in their fat boxes.
#[inline(always)]
fn take_in_fours<S: Simd, const EVENTS: bool, const FAT: bool, const GIVEN: bool>(
    simd: S,
    first: usize,
    bounds: &Boxes<'_>,
    objects: &mut Objects<'_>,
    word: usize,
) -> (u32, u32, u32) {
    let mut items = bounds.items_from(first + word * 32);
    let Objects { now, given, fat, changed: kept, before, resting, .. } = objects;
    let (kept, word) = (if EVENTS { kept.words.get(word) } else { None }, word * 32);
    let kept = kept.copied().unwrap_or(u32::MAX);
    let skipped = resting.get(word / 32).copied().unwrap_or_default();
    let end = now.len().min(word + 32);
    let now = now.get_mut(word..end).unwrap_or_default();
    let before = before.get_mut(word..end).unwrap_or_default();
    let given = given.get_mut(word..end).unwrap_or_default();
    let (mut taken, mut changed, mut contained) = (0, 0, 0);
    let mut room = [0; 8 * CORNER];
    let (before, given) = (before.as_chunks_mut::<4>().0, given.as_chunks_mut::<4>().0);
    for (four, old) in now.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let first = 4 * four;
        let Some(boxes) = bounds.four(items, &mut room) else { break };
        items = bounds.items_after(4, items);
        if skipped >> first & 0b1111 != 0 {
            continue;
        }
        let mut given = if GIVEN { given.get_mut(four) } else { None };
        // In most steps all stay in their fat boxes, or in a fat world in the boxes that are reported.
        let renews = fat.renews | fat.regrows;
        if !(renews || cfg!(target_family = "wasm"))
            && let Some(given) = &mut given
            && simd.encode_four(boxes, Some((old, true)), old, given).is_some()
        {
            taken |= 0b1111 << first;
            continue;
        }
        let mut new = [KeyBox::EMPTY; 4];
        let held = if !FAT || renews {
            None
        } else if given.is_some() {
            Some((&*old, false))
        } else {
            fat.boxes.get(word + first..).and_then(|held| Some((held.first_chunk()?, false)))
        };
        let Some((mut others, quiet)) = simd.encode_four(boxes, held, old, &mut new) else { continue };
        taken |= 0b1111 << first;
        let (mut to, mut came) = (new, None);
        if let Some(given) = &mut given {
            let last = core::mem::replace(*given, new);
            if quiet {
                continue;
            }
            let from;
            (others, to, from) = fat.report(word + first, old, &last, &new);
            came = Some(from);
        }
        let unkept = others & !(kept >> first);
        if unkept == 0b1111
            && let Some(before) = before.get_mut(four)
        {
            *before = *old;
        } else if EVENTS && let Some(before) = before.get_mut(four) {
            bits::of_word(unkept).for_each(|bit| before.put(bit, *KeyBox::of(old, bit)));
        }
        if quiet {
            fat.motions.moved_inside_margin |= others != 0;
            contained |= others << first;
        } else if FAT {
            contained |= fat.follow(word + first, came.as_ref().unwrap_or(old), &to, others) << first;
        }
        *old = to;
        changed |= others << first;
    }
    (taken, changed, contained)
}
