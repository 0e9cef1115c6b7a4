//! The C functions as C calls them, for Miri: pointers that C keeps stay good, and nothing is touched that is not lent.

use std::ffi::{c_char, c_void};
use std::ptr::{null, null_mut};
use trisap_ffi::objects::*;
use trisap_ffi::status::trisap_status;
use trisap_ffi::step::*;
use trisap_ffi::structs::*;
use trisap_ffi::world::*;

const COUNT: usize = 40;

fn boxes(shift: f32) -> Vec<trisap_aabb> {
    let aabb = |at: f32| trisap_aabb { min: [at, 0.0, 0.0], max: [at + 1.0, 1.0, 1.0] };
    (0..COUNT).map(|slot| aabb(0.75 * slot as f32 + shift * (slot % 2) as f32)).collect()
}

/// Memory as `malloc` gives it: not initialised.
struct Memory {
    start: *mut u8,
    layout: std::alloc::Layout,
}

impl Memory {
    fn new(bytes: usize) -> Self {
        let layout = std::alloc::Layout::from_size_align(bytes, trisap_world_align()).expect("a small world");
        // SAFETY: a world's size is not zero.
        Self { start: unsafe { std::alloc::alloc(layout) }, layout }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        // SAFETY: as it was allocated.
        unsafe { std::alloc::dealloc(self.start, self.layout) };
    }
}

struct Task(unsafe extern "C" fn(*mut c_void), *mut c_void);
// SAFETY: tasks are made to be called from other threads.
unsafe impl Send for Task {}

impl Task {
    fn call(self) {
        // SAFETY: called before `fork_join` returns.
        unsafe { self.0(self.1) };
    }
}

unsafe extern "C" fn fork_join(
    user: *mut c_void,
    run: Option<unsafe extern "C" fn(*mut c_void)>,
    task: *mut c_void,
    count: u32,
    _: *const c_char,
) {
    // SAFETY: the user of the jobs below.
    unsafe { *user.cast::<u32>() += count };
    let run = run.expect("a function");
    std::thread::scope(|scope| {
        for _ in 1..count {
            let task = Task(run, task);
            scope.spawn(move || task.call());
        }
        Task(run, task).call();
    });
}

#[test]
fn pointers_of_results_outlive_other_calls() {
    let config = trisap_config { events: 1, ..trisap_default_config(COUNT as u32) };
    let mut world = null_mut();
    let mut ids = Vec::<trisap_id>::with_capacity(COUNT);
    let mut result = trisap_default_result();
    // SAFETY: everything is as the functions say.
    unsafe {
        let bytes = trisap_world_size(&config);
        let memory = Memory::new(bytes);
        let made = trisap_world_init(memory.start.cast(), bytes, &config, &mut world);
        assert_eq!(made, trisap_status::Ok);
        let first = boxes(0.0);
        let view = trisap_default_boxes(first.as_ptr(), COUNT);
        assert_eq!(trisap_world_insert_many(world, &view, ids.as_mut_ptr()), trisap_status::Ok);
        ids.set_len(COUNT);
        assert_eq!(trisap_world_step(world, null(), &mut result), trisap_status::Ok);
        let seen =
            |result: &trisap_result| std::slice::from_raw_parts(result.pairs, result.pair_count).to_vec();
        let pairs = seen(&result);
        assert_eq!(pairs.len(), COUNT - 1);

        let second = boxes(10.0);
        let view = trisap_default_boxes(second.as_ptr(), COUNT);
        assert_eq!(trisap_world_update_many(world, ids.as_ptr(), &view), trisap_status::Ok);
        assert_eq!(trisap_world_remove(world, ids[3]), trisap_status::Ok);
        assert_eq!(trisap_world_remove(world, ids[3]), trisap_status::StaleId);
        assert_eq!(trisap_world_remove_many(world, [ids[4], 0].as_ptr(), 2), trisap_status::StaleId);
        assert_eq!(trisap_world_insert(world, &first[0], &mut ids[3]), trisap_status::Ok);
        assert_eq!(trisap_world_len(world), COUNT as u32);
        assert_eq!(seen(&result), pairs);

        assert_eq!(trisap_world_step_over(world, &view, null(), &mut result), trisap_status::Ok);
        assert!(result.found_count > 0 && result.lost_count > 0);
        assert_eq!(trisap_world_validate(world), trisap_status::Ok);

        let copy = Memory::new(bytes);
        copy.start.copy_from_nonoverlapping(memory.start, bytes);
        let mut opened = null_mut();
        assert_eq!(trisap_world_open(copy.start.cast(), bytes, &mut opened), trisap_status::Ok);
        let mut again = trisap_default_result();
        assert_eq!(trisap_world_result(opened, &mut again), trisap_status::Ok);
        assert_eq!(seen(&again), seen(&result));
    }
}

#[test]
fn tasks_run_on_other_threads() {
    // Enough for the work to be shared; under Miri all of it is.
    const OBJECTS: usize = if cfg!(miri) { 1100 } else { 6000 };
    let config = trisap_config { workers: 3, ..trisap_default_config(OBJECTS as u32) };
    let first: Vec<trisap_aabb> = (0..OBJECTS)
        .map(|slot| {
            let corner = [(slot % 11) as f32, (slot / 11 % 10) as f32, (slot / 110) as f32].map(|x| x * 1.5);
            trisap_aabb { min: corner, max: corner.map(|x| x + 1.0) }
        })
        .collect();
    let mut world = null_mut();
    let mut ids = vec![0; OBJECTS];
    let mut result = trisap_default_result();
    let mut calls = 0u32;
    let user: *mut u32 = &mut calls;
    let jobs = trisap_jobs {
        worker_count: 3,
        user: user.cast(),
        fork_join: Some(fork_join),
        ..trisap_default_jobs()
    };
    // SAFETY: everything is as the functions say.
    unsafe {
        let bytes = trisap_world_size(&config);
        let memory = Memory::new(bytes);
        let made = trisap_world_init(memory.start.cast(), bytes, &config, &mut world);
        assert_eq!(made, trisap_status::Ok);
        let view = trisap_default_boxes(first.as_ptr(), OBJECTS);
        assert_eq!(trisap_world_insert_many(world, &view, ids.as_mut_ptr()), trisap_status::Ok);
        assert_eq!(trisap_world_step_over(world, &view, &jobs, &mut result), trisap_status::Ok);
        assert_eq!(result.pair_count, 0);
        assert!(user.read() >= 2);
    }
}
