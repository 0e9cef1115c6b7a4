//! Enters worlds: one call that changes a world, or any number that look at it.
//!
//! The memory of a world starts with a `Header`, a cache line that tells where the core's slab ends and which calls
//! are inside. The slab follows. A `Call` enters alone, or looks beside others, and opens the core's world in the
//! slab.

use crate::border;
use crate::report;
use crate::status::{Refusal, trisap_status};
use crate::version::TRISAP_ABI_VERSION;
use core::ffi::c_void;
use core::mem::MaybeUninit;
use core::ops::{Deref, Range};
use core::sync::atomic::{
    AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};
use trisap_core::World;

/// A world, in the caller's memory. It holds no pointers: a copy of its memory, at any other address of the same
/// alignment, can be opened and goes on as the world would have.
///
/// One thread at a time may change it. Any number may look at it: functions that take it as `const`. Other calls are
/// refused as busy. There is nothing to free.
pub struct trisap_world {
    _opaque: [u8; 0],
}

/// What comes before the core's slab.
#[repr(C, align(64))]
pub(crate) struct Header {
    magic: u32,
    abi_version: u32,
    slab_bytes: u64,
    /// The detail of the last refusal, in halves: several threads that look may be refused at once.
    detail: [AtomicU32; 2],
    /// How many calls look, or `ALONE`.
    inside: AtomicU32,
    /// Not 0 if full buffers are not reported: see `trisap_world_set_growing`.
    growing: AtomicU32,
}

const MAGIC: u32 = u32::from_le_bytes(*b"trsp");
/// A call that changes the world is inside.
const ALONE: u32 = u32::MAX;
pub(crate) const HEADER: usize = size_of::<Header>();
const _: () = assert!(HEADER == 64);

impl Header {
    pub(crate) fn new(slab_bytes: usize) -> Self {
        Self {
            magic: MAGIC,
            abi_version: TRISAP_ABI_VERSION,
            slab_bytes: slab_bytes as u64,
            detail: [const { AtomicU32::new(0) }; 2],
            inside: AtomicU32::new(0),
            growing: AtomicU32::new(0),
        }
    }

    /// No call is inside any more.
    pub(crate) fn release(&self) {
        self.inside.store(0, Release);
    }

    /// Full buffers are reported.
    pub(crate) fn report_all(&self) {
        self.growing.store(0, Relaxed);
    }

    /// Without atomic exchange there is one thread: refused are calls from inside a call.
    #[cfg(not(target_has_atomic = "32"))]
    fn take(&self, next: fn(u32) -> Option<u32>) -> bool {
        let taken = next(self.inside.load(Relaxed));
        taken.inspect(|taken| self.inside.store(*taken, Relaxed)).is_some()
    }

    #[cfg(target_has_atomic = "32")]
    fn take(&self, next: fn(u32) -> Option<u32>) -> bool {
        self.inside.fetch_update(Acquire, Relaxed, next).is_ok()
    }

    /// A call that looks leaves.
    fn leave(&self) {
        #[cfg(target_has_atomic = "32")]
        self.inside.fetch_sub(1, Release);
        #[cfg(not(target_has_atomic = "32"))]
        self.inside.store(self.inside.load(Acquire) - 1, Release);
    }
}

/// A world that a call is inside of.
pub(crate) struct Inside {
    header: *mut Header,
    slab_bytes: usize,
    /// Whether the call changes the world.
    alone: bool,
}

impl Inside {
    /// # Safety
    /// A pointer that is not null points to memory that `trisap_world_init` has made into a world, or at least to as
    /// much initialised memory as a header.
    pub(crate) unsafe fn enter(world: *const trisap_world, alone: bool) -> Result<Self, trisap_status> {
        // A caller of a `const` function must not see a change. This crate changes only `inside` and the detail,
        // which are no part of the world for the caller.
        let header = world.cast_mut().cast::<Header>();
        border::check(header)?;
        // SAFETY: aligned, not null, and a header by the caller's promise.
        let slab_bytes = unsafe { check_header(header)? };
        let next: fn(u32) -> Option<u32> = match alone {
            true => |inside| (inside == 0).then_some(ALONE),
            false => |inside| inside.checked_add(1).filter(|inside| *inside != ALONE),
        };
        // SAFETY: as above; the fields that change are atomic.
        if unsafe { (*header).take(next) } {
            Ok(Self { header, slab_bytes, alone })
        } else {
            Err(trisap_status::Busy)
        }
    }

    pub(crate) fn leave(&self) {
        if self.alone {
            self.header().release();
        } else {
            self.header().leave();
        }
    }

    /// Leaves, having noted what a refusal is about, and reports that.
    fn end(&self, mut outcome: Result<(), Refusal>) -> trisap_status {
        if let Err(refusal) = &mut outcome {
            self.note(refusal);
        }
        self.leave();
        report::conclude(outcome)
    }

    /// Opens the core's world.
    ///
    /// # Safety
    /// Nothing is written through it unless this call is alone; nothing else is opened while it is used.
    pub(crate) unsafe fn open<'m>(&self) -> Result<World<'m, u32>, Refusal> {
        // SAFETY: the header says how long the slab is, and `init` has initialised it. Other calls that look may have
        // slices of the same bytes, and nothing writes to these then: to open a world writes nothing. By Tree Borrows,
        // mutable references that nothing writes through may exist beside each other; Miri with -Zmiri-tree-borrows
        // checks that in ffi/tests/border.rs.
        let slab = unsafe { core::slice::from_raw_parts_mut(self.slab().cast::<u8>(), self.slab_bytes) };
        Ok(World::open(slab)?)
    }

    fn header(&self) -> &Header {
        // SAFETY: `enter` has checked it, and its fields that change are atomic.
        unsafe { &*self.header }
    }

    /// The core's slab.
    pub(crate) fn slab(&self) -> *mut c_void {
        self.header.wrapping_add(1).cast()
    }

    /// The addresses of the world's memory.
    pub(crate) fn range(&self) -> Range<usize> {
        memory_range(self.header.cast(), HEADER + self.slab_bytes)
    }

    /// What the last refusal was about.
    pub(crate) fn detail(&self) -> u64 {
        let [low, high] = self.header().detail.each_ref().map(|half| u64::from(half.load(Relaxed)));
        low | high << 32
    }

    /// Notes what a refusal is about, and whether nobody is told of it.
    fn note(&self, refusal: &mut Refusal) {
        let [low, high] = &self.header().detail;
        low.store(refusal.detail as u32, Relaxed);
        high.store((refusal.detail >> 32) as u32, Relaxed);
        let full = matches!(refusal.status, trisap_status::ObjectsFull | trisap_status::PairsFull);
        refusal.quiet = full && self.header().growing.load(Relaxed) != 0;
    }

    pub(crate) fn set_growing(&self, growing: bool) {
        self.header().growing.store(u32::from(growing), Relaxed);
    }
}

/// A call inside of a world. One that looks beside others has a shared reference to this.
pub(crate) struct Call<'m> {
    inside: Inside,
    pub(crate) world: World<'m, u32>,
}

impl Deref for Call<'_> {
    type Target = Inside;
    fn deref(&self) -> &Inside {
        &self.inside
    }
}

impl<'m> Call<'m> {
    /// Enters a world and opens it, in room of the caller's, as it would take long to move; or reports why not. Once for all
    /// calls, most of which are short; so is the end.
    ///
    /// # Safety
    /// As for [`Inside::enter`].
    #[inline(never)]
    unsafe fn begin(
        room: &mut MaybeUninit<Self>,
        world: *const trisap_world,
        alone: bool,
    ) -> Result<&mut Self, trisap_status> {
        // SAFETY: the same promise.
        let inside = match unsafe { Inside::enter(world, alone) } {
            Ok(inside) => inside,
            Err(status) => return Err(report::conclude(Err(status.into()))),
        };
        // SAFETY: `look` gives out a shared reference, `with` is alone.
        match unsafe { inside.open() } {
            Ok(world) => Ok(room.write(Self { inside, world })),
            Err(refusal) => Err(inside.end(Err(refusal))),
        }
    }

    #[inline(never)]
    fn end(&self, outcome: Result<(), Refusal>) -> trisap_status {
        self.inside.end(outcome)
    }
}

/// Does the work of a call that changes a world. A panic in it ends the program at the border, as in all functions of C.
///
/// # Safety
/// As for [`Inside::enter`].
pub(crate) unsafe fn with(
    world: *const trisap_world,
    work: impl FnOnce(&mut Call<'_>) -> Result<(), Refusal>,
) -> trisap_status {
    let mut room = MaybeUninit::uninit();
    // SAFETY: the same promise.
    match unsafe { Call::begin(&mut room, world, true) } {
        Ok(call) => {
            let outcome = work(call);
            call.end(outcome)
        }
        Err(status) => status,
    }
}

/// Does the work of a call that looks at a world.
///
/// # Safety
/// As for [`Inside::enter`].
pub(crate) unsafe fn look(
    world: *const trisap_world,
    work: impl FnOnce(&Call<'_>) -> Result<(), Refusal>,
) -> trisap_status {
    let mut room = MaybeUninit::uninit();
    // SAFETY: the same promise.
    match unsafe { Call::begin(&mut room, world, false) } {
        Ok(call) => call.end(work(call)),
        Err(status) => status,
    }
}

/// The length of the slab behind a header of this version.
///
/// # Safety
/// The pointer is aligned and points to as much initialised memory as a header.
pub(crate) unsafe fn check_header(header: *const Header) -> Result<usize, trisap_status> {
    // SAFETY: the caller's promise; no reference is made, as the memory may hold anything.
    let (magic, abi_version, slab_bytes) =
        unsafe { ((*header).magic, (*header).abi_version, (*header).slab_bytes) };
    if magic != MAGIC || abi_version != TRISAP_ABI_VERSION {
        return Err(trisap_status::NotAWorld);
    }
    usize::try_from(slab_bytes)
        .ok()
        .filter(|bytes| *bytes <= isize::MAX as usize - HEADER)
        .ok_or(trisap_status::NotAWorld)
}

/// The addresses of so many bytes.
pub(crate) fn memory_range(memory: *const c_void, bytes: usize) -> Range<usize> {
    memory.addr()..memory.addr().saturating_add(bytes)
}
