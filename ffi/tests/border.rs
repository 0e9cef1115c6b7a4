//! The C functions as C calls them, for Miri: pointers that C keeps stay good, and nothing is touched that is not lent.

#![allow(unsafe_code, reason = "calls the C ABI")]

use std::ffi::{c_char, c_void};
use std::ptr::{null, null_mut};
use trisap_ffi::aabb::*;
use trisap_ffi::batch::*;
use trisap_ffi::filter::*;
use trisap_ffi::jobs::*;
use trisap_ffi::moving::*;
use trisap_ffi::objects::*;
use trisap_ffi::query::*;
use trisap_ffi::resting::*;
use trisap_ffi::snapshot::*;
use trisap_ffi::stats::*;
use trisap_ffi::status::trisap_status;
use trisap_ffi::step::*;
use trisap_ffi::structs::*;
use trisap_ffi::view::*;
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

unsafe extern "C" fn odd_sums(user: *mut c_void, a: u32, b: u32) -> u32 {
    // SAFETY: the user of the step below.
    unsafe { *user.cast::<u32>() += 1 };
    (a + b) % 2
}

unsafe extern "C" fn count_ids(user: *mut c_void, _: trisap_id) -> u32 {
    // SAFETY: the user of the visit below.
    unsafe { *user.cast::<u32>() += 1 };
    1
}

unsafe extern "C" fn first_only(user: *mut c_void, hit: trisap_hit) -> f64 {
    // SAFETY: the user of the visit below.
    unsafe { *user.cast::<f64>() = hit.distance };
    -1.0
}

unsafe extern "C" fn is_not(user: *mut c_void, id: trisap_id) -> u32 {
    // SAFETY: the user of the queries below.
    u32::from(id != unsafe { *user.cast::<trisap_id>() })
}

/// Answers go to memory that was never initialised, as `malloc` gives it.
#[test]
fn answers_go_where_they_are_wanted() {
    let config = trisap_config { events: 1, filters: 1, ..trisap_default_config(COUNT as u32) };
    let mut world = null_mut();
    let mut ids = Vec::<trisap_id>::with_capacity(COUNT);
    let mut result = trisap_default_result();
    let boxes = boxes(0.0);
    let (left, right) = ([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
    // SAFETY: everything is as the functions say.
    unsafe {
        let bytes = trisap_world_size(&config);
        let memory = Memory::new(bytes);
        assert_eq!(trisap_world_init(memory.start.cast(), bytes, &config, &mut world), trisap_status::Ok);
        let view = trisap_default_boxes(boxes.as_ptr(), COUNT);
        assert_eq!(trisap_world_insert_many(world, &view, ids.as_mut_ptr()), trisap_status::Ok);
        ids.set_len(COUNT);

        let filter = trisap_filter { object_class: 2, ..trisap_default_filter() };
        let set = trisap_world_set_filter_many(world, ids.as_ptr(), &filter, 0, COUNT);
        assert_eq!(set, trisap_status::Ok);
        assert_eq!(trisap_world_set_classes(world, [u32::MAX; 32].as_ptr()), trisap_status::Ok);
        let mut known = trisap_default_filter();
        assert_eq!(trisap_world_filter(world, ids[9], &mut known), trisap_status::Ok);
        assert_eq!(known, filter);
        let mut asked = 0u32;
        let user: *mut u32 = &mut asked;
        let stepped =
            trisap_world_step_with_rule(world, null(), Some(odd_sums), user.cast(), null(), &mut result);
        assert_eq!(stepped, trisap_status::Ok);
        assert_eq!((result.pair_count, user.read()), (COUNT - 1, COUNT as u32 - 1));
        assert_eq!(trisap_world_set_resting(world, ids.as_ptr(), COUNT), trisap_status::Ok);
        assert_eq!(trisap_world_is_resting(world, ids[3]), 1);
        for enabled in [0, 1] {
            assert_eq!(trisap_world_set_enabled(world, &ids[3], 1, enabled), trisap_status::Ok);
            assert_eq!(trisap_world_is_enabled(world, ids[3]), enabled);
        }

        let region = trisap_region_aabb(&trisap_aabb { min: [0.0; 3], max: [2.0; 3] });
        let mut found = Vec::<trisap_id>::with_capacity(8);
        let mut count = 0;
        let told = trisap_world_overlaps(world, &region, None, null_mut(), found.as_mut_ptr(), 8, &mut count);
        assert_eq!((told, count), (trisap_status::Ok, 3));
        found.set_len(count);
        assert_eq!(found, ids[..3]);
        user.write(0);
        let visited = trisap_world_visit_overlaps(world, &region, Some(count_ids), user.cast());
        assert_eq!((visited, user.read()), (trisap_status::Ok, 3));
        let regions = [region, trisap_region_point([0.0; 3].as_ptr())];
        let mut all = Vec::<trisap_id>::with_capacity(5);
        let mut ends = Vec::<usize>::with_capacity(2);
        let (ids_out, ends_out) = (all.as_mut_ptr(), ends.as_mut_ptr());
        let (first, none) = (regions.as_ptr(), null_mut());
        let told = trisap_world_overlaps_many(world, first, 32, 2, None, none, null(), ids_out, 5, ends_out);
        assert_eq!(told, trisap_status::Ok);
        all.set_len(5);
        ends.set_len(2);
        assert_eq!((&*all, &*ends), (&[ids[0], ids[1], ids[2], ids[0], 0][..], &[3, 4][..]));

        let ray = trisap_cast_ray(left.as_ptr(), right.as_ptr(), 3.0);
        let miss = trisap_cast_ray(left.as_ptr(), right.as_ptr(), 0.5);
        let mut hits = Vec::<trisap_hit>::with_capacity(8);
        let told = trisap_world_hits(world, &ray, None, null_mut(), hits.as_mut_ptr(), 8, &mut count);
        assert_eq!((told, count), (trisap_status::Ok, 3));
        hits.set_len(3);
        assert_eq!(hits[2], trisap_hit { id: ids[2], distance: 2.5 });
        let casts = [ray, miss];
        let mut hits = Vec::<trisap_hit>::with_capacity(2);
        let (first, user) = (casts.as_ptr(), (&raw mut ids[0]).cast());
        let told =
            trisap_world_first_hits(world, first, 40, 2, Some(is_not), user, null(), hits.as_mut_ptr());
        assert_eq!(told, trisap_status::Ok);
        hits.set_len(2);
        assert_eq!(hits, [trisap_hit { id: ids[1], distance: 1.75 }, trisap_hit::default()]);
        let mut distance = 0.0f64;
        let user: *mut f64 = &mut distance;
        let visited = trisap_world_visit_hits(world, &ray, Some(first_only), user.cast());
        assert_eq!((visited, user.read() >= 1.0), (trisap_status::Ok, true));
        // Its square root is an instruction that Miri does not know.
        if !cfg!(miri) {
            let mut hits = Vec::<trisap_hit>::with_capacity(2);
            let told = trisap_world_nearest(
                world,
                left.as_ptr(),
                None,
                null_mut(),
                hits.as_mut_ptr(),
                2,
                &mut count,
            );
            assert_eq!((told, count), (trisap_status::Ok, 2));
            hits.set_len(2);
            assert_eq!(hits[1], trisap_hit { id: ids[1], distance: 1.75 });
        }
        assert_eq!(trisap_world_leaves(world, null_mut(), 0, &mut count), trisap_status::Ok);
        assert_eq!(count, 0);

        let room = trisap_world_snapshot_size(world);
        let snapshot = Memory::new(room + 1);
        let odd: *mut c_void = snapshot.start.add(1).cast();
        assert_eq!(trisap_world_save(world, odd, room, &mut count), trisap_status::Ok);
        assert_eq!(count, room);
        assert_eq!(trisap_world_remove_many(world, ids.as_ptr(), COUNT), trisap_status::Ok);
        assert_eq!(trisap_world_load(world, odd, room), trisap_status::Ok);
        assert_eq!(trisap_world_result(world, &mut result), trisap_status::Ok);
        assert_eq!((result.pair_count, trisap_world_len(world)), (COUNT - 1, COUNT as u32));
        snapshot.start.add(room / 2).write(!snapshot.start.add(room / 2).read());
        assert_eq!(trisap_world_load(world, odd, room), trisap_status::BadSnapshot);
    }
}

#[test]
fn tasks_run_on_other_threads() {
    // Enough for the work to be shared.
    const OBJECTS: usize = if cfg!(miri) { 600 } else { 4200 };
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

#[test]
fn paths_cross_the_border() {
    const OBJECTS: usize = 600;
    let first: Vec<trisap_aabb> = (0..OBJECTS)
        .map(|slot| {
            let corner = [(slot % 9) as f32, (slot / 9 % 9) as f32, (slot / 81) as f32].map(|x| x * 1.5);
            trisap_aabb { min: corner, max: corner.map(|x| x + 1.0) }
        })
        .collect();
    let mut second = first.clone();
    second[0].max[0] += 0.25;
    let plain = trisap_default_config(OBJECTS as u32);
    let mut world = null_mut();
    let mut ids = vec![0; OBJECTS];
    let (mut result, mut stats) = (trisap_default_result(), trisap_default_stats());
    // SAFETY: everything is as the functions say.
    unsafe {
        let bytes = trisap_world_size(&plain);
        let memory = Memory::new(bytes);
        let made = trisap_world_init(memory.start.cast(), bytes, &plain, &mut world);
        assert_eq!(made, trisap_status::Ok);
        let view = trisap_default_boxes(first.as_ptr(), OBJECTS);
        assert_eq!(trisap_world_insert_many(world, &view, ids.as_mut_ptr()), trisap_status::Ok);
        assert_eq!(trisap_world_step(world, null(), &mut result), trisap_status::Ok);
        assert_eq!(trisap_world_stats(world, &mut stats), trisap_status::Ok);
        assert_eq!((stats.path, stats.reason), (TRISAP_PATH_REBUILT, TRISAP_REASON_NOTHING_KEPT));
        let view = trisap_default_boxes(second.as_ptr(), OBJECTS);
        assert_eq!(trisap_world_step_over(world, &view, null(), &mut result), trisap_status::Ok);
        assert_eq!(trisap_world_stats(world, &mut stats), trisap_status::Ok);
    }
    let told = (stats.path, stats.reason, stats.fine_leaves, stats.shared);
    assert_eq!(told, (TRISAP_PATH_MOVERS, TRISAP_REASON_FEW_MOVERS, 0, 0));
}

#[test]
fn fat_boxes_cross_the_border() {
    // A world without a tree has no fat boxes.
    let few = COUNT as u32;
    for (room, has_margin, fixed_margins, predicted_boxes) in
        [(100, 1, 0, 0), (100, 1, 1, 0), (100, 1, 0, 1), (few, 1, 0, 1), (few, 0, 0, 1)]
    {
        let plain = trisap_default_config(room);
        let config = trisap_config { has_margin, margin_min: 0.1, fixed_margins, predicted_boxes, ..plain };
        let mut world = null_mut();
        let mut ids = vec![0; COUNT];
        let (mut result, mut stats) = (trisap_default_result(), trisap_default_stats());
        // SAFETY: everything is as the functions say.
        unsafe {
            let bytes = trisap_world_size(&config);
            let memory = Memory::new(bytes);
            let made = trisap_world_init(memory.start.cast(), bytes, &config, &mut world);
            assert_eq!(made, trisap_status::Ok);
            for shift in [0.0, 5.0] {
                let boxes = boxes(shift);
                let view = trisap_default_boxes(boxes.as_ptr(), COUNT);
                if shift == 0.0 {
                    assert_eq!(trisap_world_insert_many(world, &view, ids.as_mut_ptr()), trisap_status::Ok);
                }
                assert_eq!(trisap_world_step_over(world, &view, null(), &mut result), trisap_status::Ok);
            }
            assert_eq!(trisap_world_stats(world, &mut stats), trisap_status::Ok);
        }
        // Every other box has gone far.
        assert_eq!(stats.outran, if room > few { few / 2 } else { 0 });
    }
}

/// Mutable slices of the same bytes that nobody writes through: MIRIFLAGS=-Zmiri-tree-borrows watches it.
#[test]
fn several_threads_look_at_a_world() {
    struct Shared(*const trisap_world);
    // SAFETY: a world may be looked at from several threads.
    unsafe impl Sync for Shared {}
    let mut world = null_mut();
    let mut ids = [0; COUNT];
    let mut result = trisap_default_result();
    let config = trisap_default_config(COUNT as u32);
    // SAFETY: everything is as the functions say.
    unsafe {
        let bytes = trisap_world_size(&config);
        let memory = Memory::new(bytes);
        let made = trisap_world_init(memory.start.cast(), bytes, &config, &mut world);
        assert_eq!(made, trisap_status::Ok);
        let first = boxes(0.0);
        let view = trisap_default_boxes(first.as_ptr(), COUNT);
        assert_eq!(trisap_world_insert_many(world, &view, ids.as_mut_ptr()), trisap_status::Ok);
        assert_eq!(trisap_world_step(world, null(), &mut result), trisap_status::Ok);
        let shared = Shared(world);
        let shared = &shared;
        std::thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(move || {
                    let (mut found, mut count) = ([0; COUNT], 0);
                    let region = trisap_region_aabb(&boxes(0.0)[3]);
                    let status = trisap_world_overlaps(
                        shared.0,
                        &region,
                        None,
                        null_mut(),
                        found.as_mut_ptr(),
                        COUNT,
                        &mut count,
                    );
                    assert_eq!((status, count), (trisap_status::Ok, 3));
                    assert_eq!(trisap_world_contains(shared.0, found[0]), trisap_status::Ok);
                });
            }
        });
        assert_eq!(trisap_world_step(world, null(), &mut result), trisap_status::Ok);
    }
}

#[test]
fn a_panic_says_where_it_was() {
    let text = |file: &str, line, message: &str| {
        let bytes = trisap_ffi::report::place(file, line, message);
        std::ffi::CStr::from_bytes_until_nul(&bytes).expect("a zero at the end").to_str().map(str::to_owned)
    };
    assert_eq!(text("core/src/lib.rs", 12, "no").as_deref(), Ok("core/src/lib.rs:12: no"));
    assert_eq!(text("a", 0, "b").as_deref(), Ok("a:0: b"));
    assert_eq!(text("a", u32::MAX, "b").as_deref(), Ok("a:4294967295: b"));
    assert_eq!(text("a", 1, &"x".repeat(300)).map(|text| text.len()), Ok(255));
}
