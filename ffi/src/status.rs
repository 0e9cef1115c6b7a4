//! Status codes.

use core::ffi::c_char;
use trisap_core::{Error, Field};

/// The result of a call. After every status but `TRISAP_STATUS_OK` and `TRISAP_STATUS_PAIRS_FULL` the world is as it
/// was before the call.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum trisap_status {
    /// Done.
    Ok = 0,
    /// A pointer is null that must not be.
    NullPointer = 1,
    /// A pointer is not aligned to its type, or the memory of a world not to `trisap_world_align()`.
    Misaligned = 2,
    /// A `struct_size` is not that of this ABI: the struct was not made by its `trisap_default_...` function, or by
    /// that of another version.
    StructSize = 3,
    /// An argument is out of its range.
    InvalidArgument = 4,
    /// An array reaches into the memory of the world.
    Overlap = 5,
    /// The memory is shorter than `trisap_world_size()` says.
    MemoryTooSmall = 6,
    /// The memory holds no world of this ABI version.
    NotAWorld = 7,
    /// The world is inside another call: one of another thread, or the step that has called the job system.
    Busy = 8,
    /// The capacity is beyond what the address space or the width of indices (2^27 objects) allows, or the number of
    /// workers is not 1 to 32. The detail is the most that there can be.
    CapacityTooLarge = 9,
    /// A margin is negative, not finite, or its bounds are out of order.
    BadMargin = 10,
    /// More objects than the capacity. The detail says how many would have to fit; for a world that moves and for a
    /// snapshot, slots that have been in use.
    ObjectsFull = 11,
    /// A box has NaN in it or a minimum above its maximum. The detail is its position in the batch.
    BadBox = 12,
    /// An id names no living object, or comes twice in a batch of removals. The detail is the id.
    StaleId = 13,
    /// More pairs than the capacity. The step has happened, the result holds the pairs that fit, and the detail says
    /// how many there are. Found and lost pairs are empty; the next complete step tells them relative to the last
    /// complete one. If a world moves or a snapshot is loaded, nothing has happened.
    PairsFull = 14,
    /// Something else has written to the memory of the world.
    Corrupt = 15,
    /// The world was made without `trisap_config::filters`.
    NoFilters = 16,
    /// A class is 32 or more. The detail is the class.
    BadClass = 17,
    /// A query has NaN, or an infinity or a negative length where none is allowed, or is of no known kind. The detail
    /// is its position in the batch.
    BadQuery = 18,
    /// More answers than there is room for. The detail says how many there are; the room holds as many as fit.
    OutputFull = 19,
    /// The bytes are no snapshot of a world of this configuration, or have changed since it was taken.
    BadSnapshot = 20,
    /// The shift of the origin is not finite.
    BadShift = 21,
    /// Refused for a reason that this version of the ABI has no name for.
    Other = 22,
    /// The world or the snapshot moves to a configuration that differs in what cannot change. The detail says in
    /// what: 1 mode, 2 whether there are margins, 3 events, 4 filters, 5 the width of slots, 6 values.
    OtherConfig = 23,
    /// The world was made without `trisap_config::values`.
    NoValues = 24,
    /// The world was made without `trisap_config::has_margin`.
    NoMargins = 25,
    /// The slot already has an object. The detail is its id.
    SlotTaken = 26,
}

impl trisap_status {
    /// The status of this number; `Other` for numbers that are no status.
    pub(crate) fn of(number: i32) -> Self {
        // SAFETY: the statuses are the numbers from zero to the last one.
        let known = |number| unsafe { core::mem::transmute::<i32, Self>(number) };
        if (0..=Self::SlotTaken as i32).contains(&number) { known(number) } else { Self::Other }
    }
}

/// The text of a status, in English and without a full stop. Never null, also for numbers that are no status. O(1).
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn trisap_status_text(status: i32) -> *const c_char {
    const TEXTS: [&core::ffi::CStr; 27] = [
        c"done",
        c"a pointer is null",
        c"a pointer is misaligned",
        c"the struct_size is not that of this ABI version",
        c"an argument is out of its range",
        c"an array reaches into the memory of the world",
        c"the memory is too small for the world",
        c"the memory holds no world of this ABI version",
        c"the world is inside another call",
        c"the capacity is too large, or the number of workers is not 1 to 32",
        c"a margin is negative, not finite or out of order",
        c"more objects than the capacity",
        c"a box has NaN in it or a minimum above its maximum",
        c"an id names no living object",
        c"more pairs than the capacity",
        c"the memory of the world was written to by others",
        c"the world was made without filters",
        c"a class is not below 32",
        c"a query has NaN, infinities or negative lengths where they make no sense",
        c"more answers than there is room for",
        c"the bytes are no snapshot of a world of this configuration",
        c"a part of the shift is not finite",
        c"refused",
        c"the configurations differ in what cannot change",
        c"the world was made without values",
        c"the world was made without margins",
        c"the slot already has an object",
    ];
    const _: () = assert!(TEXTS.len() == trisap_status::SlotTaken as usize + 1);
    let text = usize::try_from(status).ok().and_then(|status| TEXTS.get(status));
    text.copied().unwrap_or(c"not a status").as_ptr()
}

/// A status other than `Ok`, and its detail.
pub(crate) struct Refusal {
    pub(crate) status: trisap_status,
    pub(crate) detail: u64,
    /// Not to be reported.
    pub(crate) quiet: bool,
}

impl From<trisap_status> for Refusal {
    fn from(status: trisap_status) -> Self {
        Self { status, detail: 0, quiet: false }
    }
}

impl From<Error> for Refusal {
    fn from(error: Error) -> Self {
        let (status, detail) = match error {
            Error::SlabTooSmall { needed, .. } => (trisap_status::MemoryTooSmall, needed as u64),
            Error::SlabMisaligned { align } => (trisap_status::Misaligned, align as u64),
            Error::NotAWorld => (trisap_status::Corrupt, 0),
            Error::CapacityTooLarge { most, .. } => (trisap_status::CapacityTooLarge, most),
            Error::NoMemory { bytes } => (trisap_status::MemoryTooSmall, bytes as u64),
            Error::BadMargin => (trisap_status::BadMargin, 0),
            Error::ObjectsFull { needed, .. } => (trisap_status::ObjectsFull, needed),
            Error::BadBox { index } => (trisap_status::BadBox, u64::from(index)),
            Error::StaleId { id } => (trisap_status::StaleId, id.to_bits()),
            Error::SlotTaken { id } => (trisap_status::SlotTaken, id.to_bits()),
            Error::LengthMismatch { needed, .. } => (trisap_status::InvalidArgument, needed as u64),
            Error::InvariantBroken => (trisap_status::Corrupt, 0),
            Error::PairsFull { needed, .. } => (trisap_status::PairsFull, needed),
            Error::NoFilters => (trisap_status::NoFilters, 0),
            Error::NoValues => (trisap_status::NoValues, 0),
            Error::NoMargins => (trisap_status::NoMargins, 0),
            Error::BadClass { class } => (trisap_status::BadClass, u64::from(class)),
            Error::BadQuery { index } => (trisap_status::BadQuery, u64::from(index)),
            Error::OutputFull { needed, .. } => (trisap_status::OutputFull, needed),
            Error::BadSnapshot => (trisap_status::BadSnapshot, 0),
            Error::BadPair => (trisap_status::InvalidArgument, 0),
            Error::BadShift => (trisap_status::BadShift, 0),
            Error::NoRoom { field: Field::Objects, needed, .. } => {
                (trisap_status::ObjectsFull, u64::from(needed))
            }
            Error::NoRoom { needed, .. } => (trisap_status::PairsFull, u64::from(needed)),
            Error::OtherConfig { field } => (trisap_status::OtherConfig, number(field)),
            _ => (trisap_status::Other, 0),
        };
        Self { status, detail, quiet: false }
    }
}

/// The number of what differs.
const fn number(field: Field) -> u64 {
    match field {
        Field::Mode => 1,
        Field::Margin => 2,
        Field::Events => 3,
        Field::Filters => 4,
        Field::Index => 5,
        Field::Values => 6,
        _ => 0,
    }
}
