//! Where the caller's pointers become Rust's: everything that can be seen to be wrong is a status here, before a world
//! is touched.

use crate::status::{Refusal, trisap_status};
use crate::structs::{trisap_boxes, trisap_config, trisap_id, trisap_jobs, trisap_result, trisap_stats};
use core::ffi::c_void;
use core::ops::Range;
use trisap_core::{Boxes, Id};

/// Structs that begin with their `struct_size`.
pub(crate) trait Versioned: Copy {}
impl Versioned for trisap_config {}
impl Versioned for trisap_boxes {}
impl Versioned for trisap_jobs {}
impl Versioned for trisap_result {}
impl Versioned for trisap_stats {}

/// The pointer is neither null nor misaligned.
pub(crate) fn check<T>(pointer: *const T) -> Result<(), trisap_status> {
    if pointer.is_null() {
        Err(trisap_status::NullPointer)
    } else if !pointer.is_aligned() {
        Err(trisap_status::Misaligned)
    } else {
        Ok(())
    }
}

/// The pointer can be read from or written to as a `T` of this ABI version.
///
/// # Safety
/// A pointer that is not null points to a struct that begins with its size.
pub(crate) unsafe fn check_versioned<T: Versioned>(pointer: *const T) -> Result<(), trisap_status> {
    check(pointer)?;
    // SAFETY: aligned, not null, and by the caller's promise at least the size stands there.
    let struct_size = unsafe { pointer.cast::<u32>().read() };
    if struct_size as usize == size_of::<T>() { Ok(()) } else { Err(trisap_status::StructSize) }
}

/// A copy of the struct.
///
/// # Safety
/// As for [`check_versioned`].
pub(crate) unsafe fn read<T: Versioned>(pointer: *const T) -> Result<T, trisap_status> {
    // SAFETY: the same promise.
    unsafe { check_versioned(pointer)? };
    // SAFETY: aligned, not null, and as large as it says.
    Ok(unsafe { pointer.read() })
}

/// The address range of `count` items, if there can be such an array outside of `world`.
pub(crate) fn span<T>(first: *const T, count: usize, world: &Range<usize>) -> Result<(), trisap_status> {
    check(first)?;
    let bytes = count.checked_mul(size_of::<T>()).filter(|bytes| isize::try_from(*bytes).is_ok());
    let end = bytes.and_then(|bytes| first.addr().checked_add(bytes));
    let end = end.ok_or(trisap_status::InvalidArgument)?;
    if first.addr() < world.end && world.start < end { Err(trisap_status::Overlap) } else { Ok(()) }
}

/// The caller's boxes, where they stand.
///
/// # Safety
/// A view that is not null says truly where `count` boxes stand, for the life of the result.
pub(crate) unsafe fn boxes<'a>(
    view: *const trisap_boxes,
    world: &Range<usize>,
) -> Result<Boxes<'a>, trisap_status> {
    // SAFETY: the same promise.
    let view = unsafe { read(view)? };
    let (stride, max_offset) = (view.stride, view.max_offset as usize);
    let no_boxes = Boxes::strided(&[], stride, max_offset).ok_or(trisap_status::InvalidArgument)?;
    let Some(strides) = view.count.checked_sub(1) else { return Ok(no_boxes) };
    // The last item ends with its maximum: what else it holds may lie beyond the end of the memory.
    let bytes = strides.checked_mul(stride).and_then(|bytes| bytes.checked_add(max_offset + CORNER));
    let bytes = bytes.ok_or(trisap_status::InvalidArgument)?;
    let first = view.first.cast::<u8>();
    span(first, bytes, world)?;
    // SAFETY: not null, no longer than a slice may be, outside of the world, and by the caller's promise initialised:
    // only the corners are ever read.
    let bytes = unsafe { core::slice::from_raw_parts(first, bytes) };
    Boxes::strided(bytes, stride, max_offset).ok_or(trisap_status::InvalidArgument)
}

/// The bytes of three floats.
const CORNER: usize = 12;

/// The caller's ids.
///
/// # Safety
/// A pointer that is not null points to `count` ids, for the life of the result.
pub(crate) unsafe fn ids<'a>(
    first: *const trisap_id,
    count: usize,
    world: &Range<usize>,
) -> Result<&'a [Id], Refusal> {
    if count == 0 {
        return Ok(&[]);
    }
    span(first, count, world)?;
    // SAFETY: not null, aligned, no longer than a slice may be, and outside of the world.
    let bits = unsafe { core::slice::from_raw_parts(first, count) };
    // Without a way out of the loop, so that it becomes vector code.
    if bits.iter().fold(false, |any, bits| any | Id::from_bits(*bits).is_none()) {
        let stale = bits.iter().find(|bits| Id::from_bits(**bits).is_none());
        return Err(Refusal { status: trisap_status::StaleId, detail: stale.copied().unwrap_or_default() });
    }
    // SAFETY: an `Id` is its bits (asserted below), and all of these can be those of one.
    Ok(unsafe { core::slice::from_raw_parts(first.cast::<Id>(), count) })
}

/// Room for new ids, made null.
///
/// # Safety
/// A pointer that is not null points to room for `count` ids, for the life of the result.
pub(crate) unsafe fn new_ids<'a>(
    first: *mut trisap_id,
    count: usize,
    world: &Range<usize>,
) -> Result<&'a mut [Option<Id>], trisap_status> {
    if count == 0 {
        return Ok(&mut []);
    }
    span(first, count, world)?;
    // SAFETY: not null, aligned, and by the caller's promise there is room. A slice needs initialised memory.
    unsafe { first.write_bytes(0, count) };
    // SAFETY: no longer than a slice may be, and zero is `None` (asserted below).
    Ok(unsafe { core::slice::from_raw_parts_mut(first.cast::<Option<Id>>(), count) })
}

// An `Id` is its bits, with or without an `Option` around it, and zero is `None`.
const _: () = {
    assert!(size_of::<Id>() == 8 && align_of::<Id>() == align_of::<trisap_id>());
    assert!(size_of::<Option<Id>>() == 8);
    const BITS: u64 = (7 << 32) | 5;
    let Some(id) = Id::from_bits(BITS) else { panic!() };
    // SAFETY: of the same size, and every pattern is a `u64`.
    unsafe {
        assert!(core::mem::transmute::<Id, u64>(id) == BITS);
        assert!(core::mem::transmute::<Option<Id>, u64>(None) == 0);
    }
};

/// The pointer as one that a slice of the world's memory is derived from, so that it stays good after the slice.
pub(crate) fn lend<T, P>(slab: *const c_void, slice: &[T]) -> (*const P, usize) {
    // An empty slice may come from anywhere.
    let offset = if slice.is_empty() { 0 } else { slice.as_ptr().addr() - slab.addr() };
    (slab.wrapping_byte_add(offset).cast(), slice.len())
}
