//! A number for each pair, from the step that finds it to the step that loses it.

use crate::border::{self, Answers};
use crate::report;
use crate::status::{Refusal, trisap_status};
use crate::structs::trisap_pair;
use ::trisap_contacts::Contacts;
use core::ffi::c_void;
use core::ops::Range;

/// No pair has this number.
pub const TRISAP_NO_CONTACT: u32 = u32::MAX;

/// Small numbers for pairs, in the caller's memory: whoever keeps something for each pair (a manifold, a sound, damage)
/// keeps it in an array.
///
/// A pair has a number from the step that finds it to the step that loses it; then the number is given again. Contacts
/// stand beside a world with events. They hold no pointers: a copy of their memory, kept beside a copy or a snapshot of
/// the world, gives each pair the same number after going back. One thread at a time may call; there is nothing to free.
pub struct trisap_contacts {
    _opaque: [u8; 0],
}

/// A contact of an object.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct trisap_contact {
    /// The number.
    pub contact: u32,
    /// The slot of the object's partner.
    pub partner: u32,
}

type Memory<'m> = &'m mut [u32];
/// Of no world: what the memory of contacts must stay out of.
const NOWHERE: Range<usize> = 0..0;

/// The bytes of memory for the contacts of a world of so many objects, if there are so many pairs at most: 4 an object and
/// 24 a pair. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_contacts_size(objects: u32, contacts: u32) -> usize {
    Contacts::words(objects, contacts).saturating_mul(size_of::<u32>())
}

/// Makes room for contacts in `memory`, which starts on a multiple of 4 bytes, and writes where they are, which is `memory`
/// itself, to `made`. What was in the memory does not matter, so this also clears them. O(objects).
///
/// Errors: `TRISAP_STATUS_MEMORY_TOO_SMALL`. Nothing is written then.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_contacts_init(
    memory: *mut c_void,
    bytes: usize,
    objects: u32,
    contacts: u32,
    made: *mut *mut trisap_contacts,
) -> trisap_status {
    let needed = trisap_contacts_size(objects, contacts);
    // SAFETY: the caller's promise.
    let make = || unsafe {
        let words = fresh(memory, bytes, needed, made)?;
        Contacts::new_in(words, objects, contacts)?;
        made.write(memory.cast());
        Ok(())
    };
    report::conclude(make())
}

/// Goes on with contacts in memory that is a copy of that of others, and writes where they are to `made`. All of it is checked:
/// O(bytes).
///
/// Errors: `TRISAP_STATUS_BAD_SNAPSHOT`, if these are not contacts.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_contacts_open(
    memory: *mut c_void,
    bytes: usize,
    made: *mut *mut trisap_contacts,
) -> trisap_status {
    let open = || {
        border::span(memory.cast::<u32>(), bytes / size_of::<u32>(), &NOWHERE)?;
        border::span(made, 1, &(memory.addr()..memory.addr() + bytes))?;
        // SAFETY: aligned, not null, and initialised by the caller's promise.
        let words =
            unsafe { core::slice::from_raw_parts_mut(memory.cast::<u32>(), bytes / size_of::<u32>()) };
        Contacts::open(words)?;
        // SAFETY: aligned, not null, and outside of the memory.
        unsafe { made.write(memory.cast()) };
        Ok(())
    };
    report::conclude(open())
}

/// Writes the same contacts, with the same numbers, to other memory, with room for so many objects and pairs, and where they
/// are to `made`. The old ones stay as they are. O(bytes).
///
/// Errors: `TRISAP_STATUS_MEMORY_TOO_SMALL`; `TRISAP_STATUS_OBJECTS_FULL` or `TRISAP_STATUS_PAIRS_FULL`, if there is not room for what there is.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_contacts_move(
    contacts: *const trisap_contacts,
    memory: *mut c_void,
    bytes: usize,
    objects: u32,
    pairs: u32,
    made: *mut *mut trisap_contacts,
) -> trisap_status {
    let needed = trisap_contacts_size(objects, pairs);
    // SAFETY: the caller's promise.
    let move_to = || unsafe {
        let (from, range) = inside(contacts.cast_mut())?;
        border::span(memory.cast::<u8>(), needed.min(bytes), &range)?;
        let [own, used] = [from.room()[0], from.end()];
        if own > objects || used > pairs {
            from.move_into(&mut [][..], objects, pairs)?;
        }
        let words = fresh(memory, bytes, needed, made)?;
        from.move_into(words, objects, pairs)?;
        made.write(memory.cast());
        Ok(())
    };
    report::conclude(move_to())
}

/// Takes back the numbers of lost pairs, then gives the found ones numbers: those of a step, which may be used by their slots
/// alone. Writes the number of each lost pair to `ended` and that of each found one to `began`, as far as these are not null;
/// `TRISAP_NO_CONTACT` for a lost pair that had none. A world in which there are pairs already begins with all of them as found
/// ones. O(events), each times the partners of that object of the two which has fewer.
///
/// Errors: `TRISAP_STATUS_OBJECTS_FULL` or `TRISAP_STATUS_PAIRS_FULL`, whose `detail` (if it is not null) is how many would have to fit;
/// `TRISAP_STATUS_INVALID_ARGUMENT` for a pair of one slot. Nothing has changed then: with more room the same events fit. A lost
/// pair that was told twice may leave too little room: then some of the found ones have their numbers.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_contacts_update(
    contacts: *mut trisap_contacts,
    lost: *const trisap_pair,
    lost_count: usize,
    ended: *mut u32,
    found: *const trisap_pair,
    found_count: usize,
    began: *mut u32,
    detail: *mut u64,
) -> trisap_status {
    let update = || {
        // SAFETY: the caller's promise.
        let (mut contacts, range) = unsafe { inside(contacts)? };
        // SAFETY: the caller's promise.
        let (lost, found) = unsafe { (pairs(lost, lost_count, &range)?, pairs(found, found_count, &range)?) };
        for (numbers, count) in [(ended, lost_count), (began, found_count)] {
            if !numbers.is_null() && count > 0 {
                border::span(numbers, count, &range)?;
            }
        }
        // SAFETY: not null, aligned, and within the caller's room.
        let tell = |numbers: *mut u32, at: usize, contact| unsafe {
            if !numbers.is_null() {
                numbers.add(at).write(contact);
            }
        };
        (0..lost_count).for_each(|at| tell(ended, at, TRISAP_NO_CONTACT));
        // In their order, without the pairs that had no number.
        let mut places = lost.iter().enumerate();
        let gone = |pair, contact| {
            let place = places.find(|(_, lost)| **lost == pair);
            place.into_iter().for_each(|(at, _)| tell(ended, at, contact));
        };
        let mut at = 0..;
        contacts.update(lost, found, gone, |_, contact| {
            at.next().into_iter().for_each(|at| tell(began, at, contact));
        })?;
        Ok(())
    };
    let outcome: Result<(), Refusal> = update();
    if let Err(refusal) = &outcome
        && !detail.is_null()
        && detail.is_aligned()
    {
        // SAFETY: not null, aligned, and the caller's.
        unsafe { detail.write(refusal.detail) };
    }
    report::conclude(outcome)
}

/// The number of a pair of slots, in any order; `TRISAP_NO_CONTACT` if it has none, and for misuse. O(partners of that object of the
/// two which has fewer).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_contacts_get(contacts: *const trisap_contacts, a: u32, b: u32) -> u32 {
    // SAFETY: the caller's promise.
    let contacts = unsafe { inside(contacts.cast_mut()) };
    contacts.ok().and_then(|(contacts, _)| contacts.get(a, b)).unwrap_or(TRISAP_NO_CONTACT)
}

/// Writes the contacts of an object, those found last first, to `found`, which has room for `room`, and how many there are to
/// `count`. O(answers).
///
/// Errors: `TRISAP_STATUS_OUTPUT_FULL`. The number is right then, and the room holds as many as fit.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_contacts_of(
    contacts: *const trisap_contacts,
    slot: u32,
    found: *mut trisap_contact,
    room: usize,
    count: *mut usize,
) -> trisap_status {
    let ask = || {
        // SAFETY: the caller's promise.
        let (contacts, range) = unsafe { inside(contacts.cast_mut())? };
        // SAFETY: the caller's promise.
        let mut answers = unsafe { Answers::new(found, room, count, &range)? };
        contacts.of(slot).for_each(|(contact, partner)| answers.push(trisap_contact { contact, partner }));
        answers.conclude()
    };
    report::conclude(ask())
}

/// Takes back all numbers of an object: before it is removed, for those who cannot wait for the lost pairs of the next step. Ask
/// `trisap_contacts_of` which they are. O(answers).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_contacts_remove_all(
    contacts: *mut trisap_contacts,
    slot: u32,
) -> trisap_status {
    // SAFETY: the caller's promise.
    let remove = || unsafe { inside(contacts) }.map(|(mut contacts, _)| contacts.remove_all(slot, |_, _| {}));
    report::conclude(remove())
}

/// How many pairs have a number; 0 for misuse. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn trisap_contacts_count(contacts: *const trisap_contacts) -> usize {
    // SAFETY: the caller's promise.
    unsafe { inside(contacts.cast_mut()) }.map_or(0, |(contacts, _)| contacts.len())
}

/// The contacts at an address, and the addresses of their memory.
///
/// # Safety
/// A pointer that is not null points to what [`trisap_contacts_init`] has made, which nobody else uses.
unsafe fn inside<'m>(
    contacts: *mut trisap_contacts,
) -> Result<(Contacts<Memory<'m>>, Range<usize>), Refusal> {
    let first = contacts.cast::<u32>();
    border::check(first)?;
    // SAFETY: aligned, not null, and there are words in front that say how many there are.
    let front = unsafe { &*first.cast::<[u32; Contacts::words(0, 0)]>() };
    let [objects, pairs] = Contacts::reopen(front)?.room();
    let words = Contacts::words(objects, pairs);
    // SAFETY: so many were initialised.
    let words = unsafe { core::slice::from_raw_parts_mut(first, words) };
    let range = first.addr()..first.addr() + size_of_val(words);
    Ok((Contacts::reopen(words)?, range))
}

/// Words for contacts in the caller's memory, after everything has been checked.
///
/// # Safety
/// The memory has so many bytes, and nobody else uses it.
unsafe fn fresh<'m>(
    memory: *mut c_void,
    bytes: usize,
    needed: usize,
    made: *mut *mut trisap_contacts,
) -> Result<Memory<'m>, Refusal> {
    border::check(memory.cast::<u32>())?;
    if bytes < needed {
        return Err(Refusal { status: trisap_status::MemoryTooSmall, detail: needed as u64, quiet: false });
    }
    border::span(memory.cast::<u8>(), needed, &NOWHERE)?;
    border::span(made, 1, &(memory.addr()..memory.addr() + needed))?;
    // SAFETY: `needed` is no more than there is. A slice needs initialised memory.
    unsafe { memory.cast::<u8>().write_bytes(0, needed) };
    // SAFETY: aligned, not null, and initialised just now.
    Ok(unsafe { core::slice::from_raw_parts_mut(memory.cast(), needed / size_of::<u32>()) })
}

/// The caller's pairs.
///
/// # Safety
/// A pointer that is not null points to so many.
unsafe fn pairs<'p>(
    first: *const trisap_pair,
    count: usize,
    range: &Range<usize>,
) -> Result<&'p [[u32; 2]], Refusal> {
    if count == 0 {
        return Ok(&[]);
    }
    border::span(first, count, range)?;
    const { assert!(size_of::<trisap_pair>() == size_of::<[u32; 2]>()) };
    // SAFETY: not null, aligned, initialised by the caller's promise, and two numbers each.
    Ok(unsafe { core::slice::from_raw_parts(first.cast(), count) })
}

// The header asserts the same on the other side of the border.
const _: () = assert!(size_of::<trisap_contact>() == 8);
