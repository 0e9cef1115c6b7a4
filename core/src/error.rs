//! The errors: small values that name the cause. The world stays as it was.

use crate::id::Id;
use core::fmt;

/// Why a call was refused. The world is then valid and unchanged, unless the variant says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// The slab is shorter than [`layout`](crate::layout) says.
    SlabTooSmall {
        /// Bytes that the configuration needs.
        needed: usize,
        /// Bytes that the slab has.
        given: usize,
    },
    /// The slab is not aligned as [`layout`](crate::layout) says.
    SlabMisaligned {
        /// The alignment in bytes.
        align: usize,
    },
    /// The slab holds no world of this index width and version.
    NotAWorld,
    /// The configuration needs more than the index width, the address space or the features of this build
    /// allow. Or a lean world is for more than 256 objects, or the number of workers is not from 1 to 32.
    CapacityTooLarge {
        /// What there is too much of.
        field: Field,
        /// The most that there can be; zero if this build lacks the feature.
        most: u64,
    },
    /// The memory of an owned world cannot be allocated. Only the crate `trisap` gives this.
    NoMemory {
        /// Bytes that were asked for.
        bytes: usize,
    },
    /// A margin is negative, not finite, or its bounds are out of order.
    BadMargin,
    /// A shift of the origin is not finite.
    BadShift,
    /// All slots are taken. A batch then inserts nothing.
    ObjectsFull {
        /// Objects that would have to fit.
        needed: u64,
        /// How many there is room for.
        room: u32,
    },
    /// The box has NaN in it or a minimum above its maximum. A batch then does nothing.
    BadBox {
        /// The position of the box in the batch; zero for a single one.
        index: u32,
    },
    /// The id names no living object. A batch then does nothing.
    StaleId {
        /// The id.
        id: Id,
    },
    /// The slot already has an object.
    SlotTaken {
        /// The object.
        id: Id,
    },
    /// The world was made without filters: see [`Config::with_filters`](crate::Config::with_filters).
    NoFilters,
    /// The world was made without values: see [`Config::with_values`](crate::Config::with_values).
    NoValues,
    /// The world was made without margins: see [`Config::with_margin`](crate::Config::with_margin).
    NoMargins,
    /// A class is 32 or more. Nothing is done.
    BadClass {
        /// The class.
        class: u32,
    },
    /// A query has NaN, or an infinity or a negative length that is not allowed. A batch answers nothing.
    BadQuery {
        /// The position of the query in the batch; zero for a single one.
        index: u32,
    },
    /// A query has more answers than fit into the output slice.
    OutputFull {
        /// Items that would have to fit.
        needed: u64,
        /// How many there is room for.
        room: usize,
    },
    /// The bytes are no snapshot, or have changed since it was taken.
    BadSnapshot,
    /// The two slots of a pair are the same one.
    BadPair,
    /// A world, a snapshot or contacts hold more than there is room for where they move to, or contacts are to
    /// hold more than there is room for. Nothing is done.
    NoRoom {
        /// What there is too much of.
        field: Field,
        /// How many would have to fit.
        needed: u32,
        /// How many there is room for.
        room: u32,
    },
    /// A world or a snapshot moves to a configuration that differs in what cannot change. Nothing is done.
    OtherConfig {
        /// What differs.
        field: Field,
    },
    /// The slices of a batch do not match: boxes and ids differ in number, or the output is too short.
    LengthMismatch {
        /// Items that are needed.
        needed: usize,
        /// Items that were given.
        given: usize,
    },
    /// An index into the memory of this world was out of range since the last step or since it was opened.
    /// That is a fault of this library, or something wrote to that memory. Pairs were missing, so the world
    /// has none. The next step finds all pairs anew; found and lost are then relative to the last complete
    /// step. `World::validate` (feature `validate`) tells more.
    InvariantBroken,
    /// There are more pairs than the capacity. [`World::pairs`](crate::World::pairs) holds the pairs that
    /// fit. Found and lost are empty; the next complete step tells them relative to the last complete one.
    PairsFull {
        /// Pairs that would have to fit.
        needed: u64,
        /// How many there is room for.
        room: u32,
    },
}

/// The part of a configuration that an error is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Field {
    /// [`Capacity::objects`](crate::Capacity::objects), counted in slots: a free slot keeps its generation.
    Objects,
    /// [`Capacity::pairs`](crate::Capacity::pairs).
    Pairs,
    /// [`Config::mode`](crate::Config::mode).
    Mode,
    /// Whether there is a [`Config::margin`](crate::Config::margin).
    Margin,
    /// [`Config::events`](crate::Config::events).
    Events,
    /// [`Config::filters`](crate::Config::filters).
    Filters,
    /// [`Config::values`](crate::Config::values).
    Values,
    /// [`Config::workers`](crate::Config::workers).
    Workers,
    /// The memory of the world.
    Bytes,
    /// The width of slots.
    Index,
    /// The numbers of contacts.
    Contacts,
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Objects => "objects (slots that have been in use)",
            Self::Pairs => "pairs",
            Self::Mode => "mode",
            Self::Margin => "whether there are margins",
            Self::Events => "events",
            Self::Filters => "filters",
            Self::Values => "values",
            Self::Workers => "workers (at least one)",
            Self::Bytes => "bytes of memory",
            Self::Index => "the width of slots",
            Self::Contacts => "contacts",
        })
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SlabTooSmall { needed, given } => write!(f, "the slab has {given} of {needed} bytes"),
            Self::SlabMisaligned { align } => write!(f, "the slab must start on a multiple of {align} bytes"),
            Self::NotAWorld => f.write_str("the slab holds no world of this index width and version"),
            Self::CapacityTooLarge { field, most } => {
                write!(f, "at most {most} {field} for this width of slots, lean or not, and this build")
            }
            Self::NoMemory { bytes } => write!(f, "{bytes} bytes of memory cannot be had"),
            Self::BadMargin => f.write_str("a margin must be finite, not negative, and its bounds in order"),
            Self::BadShift => f.write_str("a shift of the origin must be finite"),
            Self::ObjectsFull { needed, room } => write!(f, "{needed} objects, but room for {room}"),
            Self::BadBox { index } => write!(f, "box {index} has NaN in it or a minimum above its maximum"),
            Self::StaleId { id } => write!(f, "{id} names no living object"),
            Self::SlotTaken { id } => write!(f, "slot {} has the object {id}", id.slot()),
            Self::NoFilters => f.write_str("the world was made without filters"),
            Self::NoValues => f.write_str("the world was made without values"),
            Self::NoMargins => f.write_str("the world was made without margins"),
            Self::BadClass { class } => write!(f, "class {class} is not below 32"),
            Self::BadQuery { index } => {
                write!(f, "query {index} has NaN, or an infinity or a negative length where none is allowed")
            }
            Self::OutputFull { needed, room } => {
                write!(f, "{needed} items, but room for {room} in the output")
            }
            Self::BadPair => f.write_str("the two slots of a pair are one"),
            Self::BadSnapshot => f.write_str("the bytes are no snapshot of a world of this configuration"),
            Self::NoRoom { field, needed, room } => write!(f, "{needed} {field}, but room for {room}"),
            Self::OtherConfig { field } => write!(f, "the configurations differ: {field}"),
            Self::LengthMismatch { needed, given } => {
                write!(f, "{given} items of a batch, but {needed} needed")
            }
            Self::InvariantBroken => f.write_str("an index was out of range: pairs may be missing"),
            Self::PairsFull { needed, room } => write!(f, "{needed} pairs, but room for {room}"),
        }
    }
}

impl core::error::Error for Error {}

/// The boxes in the caller's array that a step refused. These objects keep their last good boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rejected {
    /// The one with the lowest slot.
    pub first: Id,
    /// How many there are.
    pub count: u32,
}
