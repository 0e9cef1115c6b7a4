//! PhysX's broad phase behind the trait of the peers.

use crate::peers::{Output, Peer, Setting};
use crate::recording::Padded;
use physx_sys::*;
use std::{ffi::c_void, ptr, sync::OnceLock};

unsafe extern "C" {
    fn physx_tasks_start(threads: u32) -> *mut c_void;
    fn physx_tasks_update(
        tasks: *mut c_void,
        broad_phase: *mut PxBroadPhase,
        data: *const PxBroadPhaseUpdateData,
    );
    fn physx_tasks_stop(tasks: *mut c_void);
}

/// PhysX allocates through one foundation a process; it lives as long as the process.
fn foundation() {
    static MADE: OnceLock<bool> = OnceLock::new();
    // SAFETY: called once, before anything else of PhysX.
    assert!(MADE.get_or_init(|| unsafe { !physx_create_foundation().is_null() }), "no PhysX foundation");
}

#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct Block([u8; 16]);

pub(super) struct Physx {
    broad_phase: *mut PxBroadPhase,
    /// Null on one thread.
    tasks: *mut c_void,
    /// PhysX loads four floats from three, so one more box than objects is kept behind the last.
    bounds: Vec<PxBounds3>,
    groups: Vec<u32>,
    distances: Vec<f32>,
    handles: Vec<u32>,
    /// Those of who may have another box.
    movers: Vec<u32>,
    started: bool,
    results: PxBroadPhaseResults,
    /// Saves PhysX its temporary allocations; it has to outlive the broad phase.
    _scratch: Vec<Block>,
}

impl Physx {
    pub(super) fn new(setting: &Setting) -> Self {
        let &Setting { boxes, movers, threads } = setting;
        foundation();
        let count = boxes.len() as u32;
        let mut scratch = vec![Block([0; 16]); 16 * boxes.len() + 4096];
        let kind = if threads > 1 { PxBroadPhaseType::Pabp } else { PxBroadPhaseType::Abp };
        // SAFETY: the foundation exists; the descriptor is read during the call only.
        let broad_phase = unsafe { phys_PxCreateBroadPhase(&PxBroadPhaseDesc_new(kind)) };
        assert!(!broad_phase.is_null(), "PxCreateBroadPhase failed");
        // SAFETY: the block has this size, is aligned to 16 bytes and is dropped after the broad phase.
        unsafe {
            PxBroadPhase_setScratchBlock_mut(
                broad_phase,
                scratch.as_mut_ptr().cast(),
                size_of_val(&scratch[..]) as u32,
            );
        }
        let zero = PxVec3 { x: 0.0, y: 0.0, z: 0.0 };
        Self {
            broad_phase,
            // SAFETY: the foundation exists.
            tasks: if threads > 1 { unsafe { physx_tasks_start(threads) } } else { ptr::null_mut() },
            bounds: vec![PxBounds3 { minimum: zero, maximum: zero }; boxes.len() + 2],
            // A group of its own for every object: pairs within a group are not reported.
            // SAFETY: a pure function of its argument.
            groups: (0..=count).map(|id| unsafe { phys_PxGetBroadPhaseDynamicFilterGroup(id) }).collect(),
            distances: vec![0.0; boxes.len() + 1],
            handles: (0..count).collect(),
            movers: movers.to_vec(),
            started: false,
            // SAFETY: a plain constructor.
            results: unsafe { PxBroadPhaseResults_new() },
            _scratch: scratch,
        }
    }
}

impl Peer for Physx {
    fn prepare(&mut self, boxes: &[Padded]) {
        for (bounds, b) in self.bounds.iter_mut().zip(boxes) {
            bounds.minimum = PxVec3 { x: b[0], y: b[1], z: b[2] };
            bounds.maximum = PxVec3 { x: b[4], y: b[5], z: b[6] };
        }
    }

    fn frame(&mut self) {
        let count = self.handles.len() as u32;
        let (created, updated) = if self.started { (0, self.movers.len() as u32) } else { (count, 0) };
        self.started = true;
        // SAFETY: all arrays have `capacity` entries (the bounds one more, as PhysX asks), live and stay unchanged
        // until the results are fetched, and every handle is created once and then updated.
        unsafe {
            let data = PxBroadPhaseUpdateData_new(
                self.handles.as_ptr(),
                created,
                self.movers.as_ptr(),
                updated,
                ptr::null(),
                0,
                self.bounds.as_ptr(),
                self.groups.as_ptr(),
                self.distances.as_ptr(),
                count + 1,
            );
            if self.tasks.is_null() {
                PxBroadPhase_update_mut(self.broad_phase, &data, ptr::null_mut());
            } else {
                physx_tasks_update(self.tasks, self.broad_phase, &data);
            }
            PxBroadPhase_fetchResults_mut(self.broad_phase, &mut self.results);
        }
    }

    fn output(&mut self) -> Output<'_> {
        Output::Events {
            found: pairs(self.results.mCreatedPairs, self.results.mNbCreatedPairs),
            lost: pairs(self.results.mDeletedPairs, self.results.mNbDeletedPairs),
        }
    }
}

fn pairs<'a>(first: *const PxBroadPhasePair, count: u32) -> &'a [[u32; 2]] {
    if count == 0 {
        return &[];
    }
    // SAFETY: PhysX keeps that many pairs there until its next update; a pair is two `u32` in a row.
    unsafe { std::slice::from_raw_parts(first.cast(), count as usize) }
}

impl Drop for Physx {
    fn drop(&mut self) {
        // SAFETY: both were made by `new` and are not used afterwards.
        unsafe {
            PxBroadPhase_release_mut(self.broad_phase);
            if !self.tasks.is_null() {
                physx_tasks_stop(self.tasks);
            }
        }
    }
}
