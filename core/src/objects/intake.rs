//! Takes in the caller's bounds array: one pass, no copy, bad boxes found on the way.

use crate::access::{Access, bits};
use crate::config::{EVENTS, TREE};
use crate::geometry::boxes::Boxes;
use crate::geometry::key::{KeyBox, POSITIVE_INFINITY};
use crate::id::Index;
use crate::memory::limits::{SLOT_BLOCKS, block_len};
use crate::memory::slab::Parts;
use crate::memory::slot_set::SlotSet;
use crate::objects::Objects;
use crate::objects::margins::{FatBoxes, FatRule};
use crate::parallel::block_queue::Chunks;
use crate::parallel::context::StepContext;
use crate::simd::kernels::{Kernels, run};
use crate::simd::{Simd, call};

/// What the pass found in a block of slots, or in all.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Intake {
    /// Boxes that left their fat boxes.
    pub(crate) outran: u32,
    /// Boxes that were refused.
    pub(crate) rejected: u32,
    /// The lowest slot among them.
    pub(crate) first_rejected: Option<u32>,
}

impl Intake {
    #[cold]
    #[inline(never)]
    fn reject(&mut self, slot: usize) {
        self.first_rejected = self.first_rejected.or(Some(slot as u32));
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
        objects.fat.rule.regrows = regrows;
        return ingest_block(context.kernels, 0, bounds, objects);
    }
    ingest_blocks(parts, bounds, (slots, regrows), context)
}

/// Takes in the first slots of a world with a tree, in blocks.
// Its stack frame does not stand below the sweep's.
#[inline(never)]
fn ingest_blocks<I: Index>(
    parts: &mut Parts<'_, I>,
    bounds: &Boxes<'_>,
    (slots, regrows): (usize, bool),
    context: StepContext<'_>,
) -> Intake {
    let len = block_len(slots, SLOT_BLOCKS);
    let by_pairs = parts.state.pairs.before_unknown != 0;
    let Objects { now, given, fat: all, mut moved, mut changed, before, resting, .. } = parts.objects();
    // Then pairs tell events.
    let before = if by_pairs { &mut [] } else { before };
    let mut found = [Intake::default(); SLOT_BLOCKS];
    let blocks = (
        (Chunks::new(now.span_mut(0, slots), len), Chunks::optional(given, len)),
        Chunks::optional(all.boxes, len),
        Chunks::optional(before, len),
        (moved.blocks(len), changed.blocks(len)),
        Chunks::new(&mut found, 1),
    );
    context.each(blocks, |block, ((now, given), fat, before, (moved, changed), found)| {
        let first = block * len;
        let margins = all.margins.get(first..).unwrap_or_default();
        let fat = FatBoxes { boxes: fat, margins, rule: FatRule { regrows, ..all.rule } };
        let [moved, changed] = [moved, changed].map(|(words, groups)| SlotSet { words, groups });
        let resting = resting.get(first / 32..).unwrap_or_default();
        let objects = Objects { now, cut: &mut [], given, fat, moved, changed, before, resting };
        found.fill(ingest_block(context.kernels, first, bounds, objects));
    });
    found.iter().fold(Intake::default(), |sum, block| Intake {
        outran: sum.outran + block.outran,
        rejected: sum.rejected + block.rejected,
        first_rejected: sum.first_rejected.or(block.first_rejected),
    })
}

/// Takes in the boxes of some consecutive slots.
#[cfg_attr(not(feature = "large"), inline(always))]
fn ingest_block(kernels: Kernels, first: usize, bounds: &Boxes<'_>, objects: Objects<'_>) -> Intake {
    run!(kernels, |simd| take_in_words(simd, first, bounds, objects))
}

/// The slots of a word whose boxes are taken in, and resting ones.
#[derive(Clone, Copy, Default)]
struct Taken {
    done: u32,
    /// Slots that have other boxes now, and those that stay in their fat boxes.
    changed: u32,
    contained: u32,
}

#[inline(always)]
fn take_in_words<S: Simd>(simd: S, first: usize, bounds: &Boxes<'_>, mut objects: Objects<'_>) -> Intake {
    let mut intake = Intake::default();
    let has_fat = objects.is_fat() || objects.fat.exist();
    for word in 0..objects.now.len().div_ceil(32) {
        let all = u32::MAX >> (32 - (objects.now.len() - word * 32).min(32));
        let done = objects.resting.get(word).copied().unwrap_or_default();
        if done & all == all {
            continue;
        }
        let mut taken = Taken { done, ..Taken::default() };
        if S::ENCODES_FOUR && !has_fat {
            taken = take_in_quiet::<S, false>(simd, first, bounds, &mut objects, word, taken);
        } else if S::ENCODES_FOUR && !(objects.fat.rule.renews | objects.fat.rule.regrows) {
            taken = take_in_quiet::<S, true>(simd, first, bounds, &mut objects, word, taken);
        }
        if S::ENCODES_FOUR && has_fat && taken.done & all != all {
            let of = &mut objects;
            taken = if of.is_fat() || !S::MORE_CODE {
                call!(simd, take_in_leavers::<S, true>(simd, first, bounds, of, word, taken))
            } else {
                call!(simd, take_in_leavers::<S, false>(simd, first, bounds, of, word, taken))
            };
        }
        let (of, found) = (&mut objects, &mut intake);
        if S::ENCODES_FOUR && taken.done & all == all {
            of.note(word, taken.changed, taken.contained);
        } else if S::ENCODES_FOUR {
            call!(simd, take_in(first, bounds, of, word, taken, found));
        } else {
            take_in(first, bounds, of, word, taken, found);
        }
    }
    Intake { outran: objects.fat.rule.outran, ..intake }
}

/// Takes in the boxes of the slots of a word one by one, but for those that are done with.
#[inline(always)]
fn take_in(
    first: usize,
    bounds: &Boxes<'_>,
    objects: &mut Objects<'_>,
    word: usize,
    taken: Taken,
    intake: &mut Intake,
) {
    let count = (objects.now.len() - word * 32).min(32);
    let Taken { done, changed, mut contained } = taken;
    let mut same = done;
    let (is_fat, has_fat, at) = (objects.is_fat(), objects.fat.exist(), word * 32);
    let Objects { now, given, fat, before, changed: kept, .. } = objects;
    // The boxes that events compare with are kept where they have not changed since the last complete step.
    let unkept = if EVENTS && TREE && !before.is_empty() { !kept.words.at(word) } else { 0 };
    let has_margins = is_fat || has_fat;
    let apart = if has_margins { u32::MAX } else { unkept };
    // The bit of a slot, turned on from slot to slot, which takes a small processor less than to make each.
    let mut this = 1u32.rotate_right(1);
    for (bit, old) in (at..).zip(now.span_mut(at, count)) {
        this = this.rotate_left(1);
        // Only a free or a disabled slot has such a minimum.
        if done & this != 0 || old.min[0] > POSITIVE_INFINITY {
            same |= this;
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
            same |= this;
            continue;
        };
        if new.is_same(old) && !is_fat {
            same |= this;
            continue;
        }
        if apart & this != 0 {
            let before = if unkept & this != 0 { before.get_mut(bit) } else { None };
            if has_margins {
                // In a function of its own, which is lent copies, so that the loop stays in registers.
                let (mut fat_boxes, to) = (FatBoxes { boxes: &mut *fat.boxes, ..*fat }, new);
                if let Some(stays) = fat_boxes.replace(given, bit, old, &to, before) {
                    contained |= if stays { this } else { 0 };
                } else {
                    same |= this;
                }
                fat.rule = fat_boxes.rule;
                continue;
            }
            if let Some(before) = before {
                // Number by number: a copy from one slice to another would be a call.
                let ([a, b, c], [d, e, f]) = (old.min, old.max);
                *before = KeyBox { min: [a, b, c], max: [d, e, f] };
            }
        }
        *old = new;
    }
    objects.note(word, changed | u32::MAX >> (32 - count) & !same, contained)
}

/// Takes in boxes of the slots of a word four at a time, where all four are good, and of objects that live,
/// do not rest, and stay in their fat boxes, or in a fat world in the boxes that are reported.
#[inline(always)]
fn take_in_quiet<S: Simd, const FAT: bool>(
    simd: S,
    first: usize,
    bounds: &Boxes<'_>,
    objects: &mut Objects<'_>,
    word: usize,
    mut taken: Taken,
) -> Taken {
    let mut items = bounds.items_from(first + word * 32);
    let Objects { now, given, fat, changed: kept, before, .. } = objects;
    let kept = kept.words.get(word).copied().unwrap_or(u32::MAX);
    let (now, before, none) =
        (fours(now, word), fours(before, word), (Default::default(), Default::default()));
    let (given, held) = if FAT { (fours(given, word), fours(fat.boxes, word)) } else { none };
    for (four, old) in now.iter_mut().enumerate() {
        let (first, boxes) = (4 * four, bounds.four(&mut items));
        if taken.done >> first & 0b1111 != 0 {
            continue;
        }
        if let Some(given) = given.get_mut(four) {
            let stay = simd.encode_four(boxes, Some(old), old, given).is_some();
            taken.done |= if stay { 0b1111 << first } else { 0 };
            continue;
        }
        let mut new = <[KeyBox; 4]>::default();
        let Some(others) = simd.encode_four(boxes, held.get(four), old, &mut new) else { continue };
        if EVENTS && let Some(before) = before.get_mut(four) {
            keep(before, old, others & !(kept >> first));
        }
        *old = new;
        (taken.done, taken.changed) = (taken.done | 0b1111 << first, taken.changed | others << first);
    }
    taken.contained = if fat.exist() { taken.changed } else { 0 };
    taken
}

/// The boxes of the slots of a word, in fours.
#[inline(always)]
fn fours(boxes: &mut [KeyBox], word: usize) -> &mut [[KeyBox; 4]] {
    let end = boxes.len().min(word * 32 + 32);
    boxes.get_mut(word * 32..end).unwrap_or_default().as_chunks_mut().0
}

/// Keeps boxes that events compare with.
#[inline(always)]
fn keep(before: &mut [KeyBox; 4], old: &[KeyBox; 4], unkept: u32) {
    match unkept {
        0b1111 => *before = *old,
        some => bits::of_word(some).for_each(|bit| before.put(bit, *KeyBox::of(old, bit))),
    }
}

/// The same as [`take_in_quiet`], of objects that may leave these boxes. What belongs to four of them is found by
/// index: the ends of iterators would not stay in registers.
#[inline(always)]
fn take_in_leavers<S: Simd, const FAT: bool>(
    simd: S,
    first: usize,
    bounds: &Boxes<'_>,
    objects: &mut Objects<'_>,
    word: usize,
    mut taken: Taken,
) -> Taken {
    let mut items = bounds.items_from(first + word * 32);
    let Objects { now, given, fat, changed: kept, before, .. } = objects;
    let kept = kept.words.get(word).copied().unwrap_or(u32::MAX);
    let margins = fat.margins.get(word * 32..).unwrap_or_default().as_chunks().0;
    let (held, before, given) = (fours(fat.boxes, word), fours(before, word), fours(given, word));
    for (four, old) in fours(now, word).iter_mut().enumerate() {
        let (first, boxes) = (4 * four, bounds.four(&mut items));
        if taken.done >> first & 0b1111 != 0 {
            continue;
        }
        let mut new = <[KeyBox; 4]>::default();
        let Some(mut others) = simd.encode_four(boxes, None, old, &mut new) else { continue };
        // By reference, since boxes that came in one of two ways would be taken apart to numbers.
        let (reported, came);
        let (mut to, mut from) = (&new, &*old);
        let margins = margins.get(four).unwrap_or(&[0.0; 4]);
        if FAT && let Some(given) = given.get_mut(four) {
            let last = core::mem::replace(given, new);
            (others, reported) = fat.rule.report(simd, margins, old, &last, &new);
            came = core::array::from_fn(|k| reported[k].came_from(&last[k], &new[k]));
            (to, from) = (&reported, &came);
        }
        if EVENTS && let Some(before) = before.get_mut(four) {
            keep(before, old, others & !(kept >> first));
        }
        if let Some(held) = held.get_mut(four) {
            taken.contained |= fat.rule.follow(simd, margins, (from, to), others, held) << first;
        }
        *old = *to;
        (taken.done, taken.changed) = (taken.done | 0b1111 << first, taken.changed | others << first);
    }
    taken
}
