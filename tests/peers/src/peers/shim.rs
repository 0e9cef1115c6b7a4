//! The C++ peers. Each is a file in `cpp/` that exports one table of functions (see `cpp/peer.h`).

use super::{Crowd, Entry, Output, Peer, Setting, Start};
use crate::recording::Padded;
use std::ffi::c_void;

/// The same as `struct Setting` in `cpp/peer.h`.
#[repr(C)]
struct CSetting {
    boxes: *const Padded,
    count: u32,
    movers: *const u32,
    mover_count: u32,
    threads: u32,
}

/// The same as `struct Peer` in `cpp/peer.h`.
#[repr(C)]
struct Table {
    start: unsafe extern "C" fn(setting: *const CSetting) -> *mut c_void,
    prepare: Option<unsafe extern "C" fn(state: *mut c_void, boxes: *const Padded)>,
    frame: unsafe extern "C" fn(state: *mut c_void, boxes: *const Padded),
    pairs: unsafe extern "C" fn(state: *mut c_void, pairs: *mut *const [u32; 2]) -> usize,
    stop: unsafe extern "C" fn(state: *mut c_void),
}

struct Shim {
    table: &'static Table,
    state: *mut c_void,
    boxes: Vec<Padded>,
}

/// Some of them lose pairs of boxes without end, or write outside of their memory.
fn ended(bounds: &Padded) -> Padded {
    bounds.map(|x| x.clamp(-1e9, 1e9))
}

impl Shim {
    fn start(table: &'static Table, setting: &Setting) -> Box<dyn Peer> {
        let &Setting { boxes, movers, threads } = setting;
        let boxes: Vec<Padded> = boxes.iter().map(ended).collect();
        let setting = CSetting {
            boxes: boxes.as_ptr(),
            count: boxes.len() as u32,
            movers: movers.as_ptr(),
            mover_count: movers.len() as u32,
            threads,
        };
        // SAFETY: as many boxes and movers are there for the call.
        let state = unsafe { (table.start)(&setting) };
        assert!(!state.is_null(), "the peer did not start");
        Box::new(Self { table, state, boxes })
    }
}

impl Peer for Shim {
    fn prepare(&mut self, boxes: &[Padded]) {
        for (to, from) in self.boxes.iter_mut().zip(boxes) {
            *to = ended(from);
        }
        if let Some(prepare) = self.table.prepare {
            // SAFETY: as for a frame.
            unsafe { prepare(self.state, self.boxes.as_ptr()) }
        }
    }

    fn frame(&mut self) {
        // SAFETY: the state is live, and there are as many boxes as at the start.
        unsafe { (self.table.frame)(self.state, self.boxes.as_ptr()) }
    }

    fn output(&mut self) -> Output<'_> {
        let mut first = std::ptr::null();
        // SAFETY: the state is live; the peer keeps the pairs until its next frame, which `&mut self` rules out.
        let pairs = unsafe {
            match (self.table.pairs)(self.state, &mut first) {
                0 => &[],
                count => std::slice::from_raw_parts(first, count),
            }
        };
        Output::Pairs(pairs)
    }
}

impl Drop for Shim {
    fn drop(&mut self) {
        // SAFETY: the state is live and not used afterwards.
        unsafe { (self.table.stop)(self.state) }
    }
}

/// How to start the peer whose table has this name, if its feature is on.
macro_rules! start {
    ($feature:literal, $table:ident, $without:literal) => {{
        #[cfg(feature = $feature)]
        let start: Result<Start, &'static str> = {
            unsafe extern "C" {
                static $table: Table;
            }
            // SAFETY: a constant of the C++ file.
            Ok(|setting| Shim::start(unsafe { &$table }, setting))
        };
        #[cfg(not(feature = $feature))]
        let start: Result<Start, &'static str> = Err($without);
        start
    }};
}

pub(crate) fn embree() -> Entry {
    Entry {
        name: "Embree rtcCollide",
        setup: "user geometry, Morton build (quality low), exact test in the callback",
        events: false,
        fat: false,
        parallel: true,
        crowd: Crowd::Unsuited,
        start: start!("embree", embree_peer, "needs libembree-dev and --features embree"),
    }
}

pub(crate) fn cgal() -> Entry {
    Entry {
        name: "CGAL box_self_intersection_d",
        setup: "boxes by value, closed, the fastest of several cutoffs on the first frame",
        events: false,
        fat: false,
        parallel: true,
        crowd: Crowd::Unsuited,
        start: start!("cgal", cgal_peer, "needs libcgal-dev and --features cgal"),
    }
}

pub(crate) fn bullet() -> Entry {
    Entry {
        name: "Bullet btDbvtBroadphase",
        setup: "deferred collide, hashed pair cache, its own margin and clean-up share, 1 % incremental optimisation",
        events: false,
        fat: true,
        parallel: false,
        crowd: Crowd::All,
        start: start!("bullet", bullet_peer, "needs libbullet-dev and --features bullet"),
    }
}

pub(crate) fn jolt() -> Entry {
    Entry {
        name: "Jolt BroadPhaseQuadTree",
        setup: "one layer, all bodies dynamic, those handed over active, AVX2 build without profiler; bodies told of their boxes first",
        events: false,
        fat: false,
        parallel: false,
        crowd: Crowd::OfMovers,
        start: start!("jolt", jolt_peer, "needs --features jolt"),
    }
}

pub(crate) fn box3d() -> Entry {
    Entry {
        name: "Box3D dynamic tree",
        setup: "b3DynamicTree and pair set as in its step: margin, enlarge, query by moved, partial rebuild",
        events: false,
        fat: true,
        parallel: false,
        crowd: Crowd::All,
        start: start!("box3d", box3d_peer, "needs --features box3d"),
    }
}
