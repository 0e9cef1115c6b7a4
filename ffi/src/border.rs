//! Makes the caller's pointers Rust's. Everything that can be seen to be wrong is a status here, before a world is
//! touched.

use crate::status::{Refusal, trisap_status};
use crate::structs::{
    trisap_boxes, trisap_config, trisap_hit, trisap_id, trisap_jobs, trisap_result, trisap_stats,
};
use core::ffi::c_void;
use core::ops::Range;
use trisap_core::{Boxes, Hit, Id};

/// An id that an object has, or had.
pub(crate) fn living(id: trisap_id) -> Result<Id, Refusal> {
    let stale = Refusal { status: trisap_status::StaleId, detail: id, quiet: false };
    Id::from_bits(id).ok_or(stale)
}

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

/// What the pointer points to, if it is not null.
///
/// # Safety
/// A pointer that is not null points to a `T`.
pub(crate) unsafe fn optional<T: Copy>(pointer: *const T) -> Result<Option<T>, trisap_status> {
    if pointer.is_null() {
        return Ok(None);
    }
    check(pointer)?;
    // SAFETY: aligned, not null, and initialised by the caller's promise.
    Ok(Some(unsafe { pointer.read() }))
}

/// Whether there can be an array of `count` items outside of `world`.
pub(crate) fn span<T>(first: *const T, count: usize, world: &Range<usize>) -> Result<(), trisap_status> {
    check(first)?;
    extent(first, count.checked_mul(size_of::<T>()), world)
}

/// Whether there can be so many bytes outside of `world`.
fn extent<T>(first: *const T, bytes: Option<usize>, world: &Range<usize>) -> Result<(), trisap_status> {
    let bytes = bytes.filter(|bytes| isize::try_from(*bytes).is_ok());
    let end = bytes.and_then(|bytes| first.addr().checked_add(bytes));
    let end = end.ok_or(trisap_status::InvalidArgument)?;
    if first.addr() < world.end && world.start < end { Err(trisap_status::Overlap) } else { Ok(()) }
}

/// The caller's items, each so many bytes behind the one before.
pub(crate) struct Items<T> {
    first: *const T,
    stride: usize,
    count: usize,
}

impl<T: Copy> Items<T> {
    /// # Safety
    /// A pointer that is not null points to `count` items with this stride, for the life of the result.
    pub(crate) unsafe fn new(
        first: *const T,
        stride: usize,
        count: usize,
        world: &Range<usize>,
    ) -> Result<Self, trisap_status> {
        if stride != 0 && stride < size_of::<T>() {
            return Err(trisap_status::InvalidArgument);
        }
        if !stride.is_multiple_of(align_of::<T>()) {
            return Err(trisap_status::Misaligned);
        }
        if let Some(strides) = count.checked_sub(1) {
            check(first)?;
            let bytes = strides.checked_mul(stride).and_then(|bytes| bytes.checked_add(size_of::<T>()));
            extent(first, bytes, world)?;
        }
        Ok(Self { first, stride, count })
    }

    pub(crate) fn len(&self) -> usize {
        self.count
    }

    pub(crate) fn get(&self, index: usize) -> Option<T> {
        // SAFETY: `new` has found room for `count` items, aligned, which the caller has initialised.
        (index < self.count).then(|| unsafe { self.first.byte_add(index * self.stride).read() })
    }
}

/// Room for answers. Their number is known only at the end.
pub(crate) struct Answers<T> {
    first: *mut T,
    room: usize,
    count: usize,
    told: *mut usize,
}

impl<T> Answers<T> {
    /// # Safety
    /// Pointers that are not null point to room for `room` items and for their number, for the life of the result.
    pub(crate) unsafe fn new(
        first: *mut T,
        room: usize,
        told: *mut usize,
        world: &Range<usize>,
    ) -> Result<Self, trisap_status> {
        if room > 0 {
            span(first, room, world)?;
        }
        span(told, 1, world)?;
        Ok(Self { first, room, count: 0, told })
    }

    /// Writes another answer, or only counts it if there is no more room.
    pub(crate) fn push(&mut self, answer: T) {
        if self.count < self.room {
            // SAFETY: not null, aligned, and within the caller's room.
            unsafe { self.first.add(self.count).write(answer) };
        }
        self.count += 1;
    }

    /// The answers that were written.
    pub(crate) fn written(&mut self) -> &mut [T] {
        match self.count.min(self.room) {
            0 => &mut [],
            // SAFETY: not null, aligned, and `push` has initialised so many.
            count => unsafe { core::slice::from_raw_parts_mut(self.first, count) },
        }
    }

    /// Writes how many there are.
    pub(crate) fn conclude(self) -> Result<(), Refusal> {
        // SAFETY: `new` has checked the pointer.
        unsafe { self.told.write(self.count) };
        let full = Refusal { status: trisap_status::OutputFull, detail: self.count as u64, quiet: false };
        if self.count > self.room { Err(full) } else { Ok(()) }
    }
}

/// The caller's boxes, in place.
///
/// # Safety
/// A view that is not null says correctly where `count` boxes are, for the life of the result.
pub(crate) unsafe fn boxes<'a>(
    view: *const trisap_boxes,
    world: &Range<usize>,
) -> Result<Boxes<'a>, trisap_status> {
    // SAFETY: the same promise.
    let view = unsafe { read(view)? };
    let (stride, max_offset) = (view.stride, view.max_offset as usize);
    let no_boxes = Boxes::strided(&[], stride, max_offset).ok_or(trisap_status::InvalidArgument)?;
    let Some(strides) = view.count.checked_sub(1) else { return Ok(no_boxes) };
    // The last item ends with its maximum: the rest of it may be beyond the end of the memory.
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
    // Without an exit from the loop, so that it becomes vector code.
    if bits.iter().fold(false, |any, bits| any | Id::from_bits(*bits).is_none()) {
        let stale = bits.iter().find(|bits| Id::from_bits(**bits).is_none());
        return Err(Refusal {
            status: trisap_status::StaleId,
            detail: stale.copied().unwrap_or_default(),
            quiet: false,
        });
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
    // SAFETY: the caller's promise, and zero is `None` (asserted below).
    unsafe { zeros(first.cast::<Option<Id>>(), count, world) }
}

/// Room for items, made zero.
///
/// # Safety
/// A pointer that is not null points to room for `count` items, for the life of the result. Zero is an item.
pub(crate) unsafe fn zeros<'a, T>(
    first: *mut T,
    count: usize,
    world: &Range<usize>,
) -> Result<&'a mut [T], trisap_status> {
    if count == 0 {
        return Ok(&mut []);
    }
    span(first, count, world)?;
    // SAFETY: not null, aligned, and by the caller's promise there is room. A slice needs initialised memory.
    unsafe { first.write_bytes(0, count) };
    // SAFETY: no longer than a slice may be, and initialised just now.
    Ok(unsafe { core::slice::from_raw_parts_mut(first, count) })
}

/// Room for hits, which the core fills in its own form.
pub(crate) struct Hits {
    first: *mut trisap_hit,
    count: usize,
}

impl Hits {
    /// # Safety
    /// A pointer that is not null points to room for `count` hits, for the life of the result.
    pub(crate) unsafe fn new(
        first: *mut trisap_hit,
        count: usize,
        world: &Range<usize>,
    ) -> Result<Self, trisap_status> {
        if count > 0 {
            span(first, count, world)?;
        }
        for index in 0..count {
            // SAFETY: not null, aligned and large enough (asserted below), and by the caller's promise there is room.
            unsafe { first.add(index).cast::<Option<Hit>>().write(None) };
        }
        Ok(Self { first, count })
    }

    pub(crate) fn as_options(&mut self) -> &mut [Option<Hit>] {
        if self.count == 0 {
            return &mut [];
        }
        // SAFETY: no longer than a slice may be, and `new` has initialised it.
        unsafe { core::slice::from_raw_parts_mut(self.first.cast::<Option<Hit>>(), self.count) }
    }

    /// Brings the hits to the caller's form.
    pub(crate) fn settle(self) {
        for index in 0..self.count {
            // SAFETY: within the room, and in the core's form until here.
            let hit = unsafe { self.first.add(index).cast::<Option<Hit>>().read() };
            // SAFETY: within the room.
            unsafe { self.first.add(index).write(hit.map_or(trisap_hit::NONE, Into::into)) };
        }
    }
}

// A hit fits where one of the caller's does.
const _: () = {
    assert!(size_of::<Option<Hit>>() == size_of::<trisap_hit>());
    assert!(align_of::<Option<Hit>>() == align_of::<trisap_hit>());
};

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

/// The pointer, derived from the pointer to the world, so that it stays valid after the slice.
pub(crate) fn lend<T, P>(slab: *const c_void, slice: &[T]) -> (*const P, usize) {
    // An empty slice may come from anywhere.
    let offset = if slice.is_empty() { 0 } else { slice.as_ptr().addr() - slab.addr() };
    (slab.wrapping_byte_add(offset).cast(), slice.len())
}
