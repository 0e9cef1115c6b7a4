//! Indices out of range inside of the library: the step says so, and the next one finds all pairs.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};
use std::{vec, vec::Vec};
use trisap_core::{Aabb, Boxes, Capacity, Config, Error, Kernels, World, layout};

#[repr(C, align(64))]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Line([u8; 64]);

const COUNT: u32 = 6000;

fn config(count: u32) -> Config {
    Config::new(Capacity::for_objects(count)).with_events()
}

fn cube(x: f32) -> Aabb {
    Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])
}

fn slab(count: u32) -> Vec<Line> {
    vec![Line([0; 64]); layout::<u32>(&config(count)).unwrap().bytes / 64]
}

/// A row of cubes, each of which overlaps the next one.
fn row(slab: &mut [Line], count: u32) -> World<'_> {
    let mut world = World::<u32>::new_in(bytemuck::cast_slice_mut(slab), &config(count)).unwrap();
    let boxes: Vec<Aabb> = (0..count).map(|k| cube(k as f32)).collect();
    assert_eq!(world.insert_many(Boxes::new(&boxes)).unwrap().count(), count as usize);
    world.set_kernels(Kernels::BASELINE);
    assert_eq!(world.step().unwrap().pairs().len(), count as usize - 1);
    world
}

/// Faults of one world can be lost among many of others at the same time.
static ALONE: Mutex<()> = Mutex::new(());

/// A step in which many indices are out of range.
fn faulty_step(world: &mut World<'_>) {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    (0..999).for_each(|_| world.break_index());
    assert_eq!(world.step().err(), Some(Error::InvariantBroken));
    assert_eq!((world.pairs().len(), world.found().len(), world.lost().len()), (0, 0, 0));
    assert_eq!(world.validate(), Ok(()));
}

/// The step after a fault finds all pairs, and tells those that came and went since the last complete step: few objects have
/// moved, or all but some.
#[test]
fn events_are_relative_to_the_last_step_without_a_fault() {
    // A world for 60 has no tree.
    for (count, moved) in [(COUNT, 3), (COUNT, COUNT - 9), (60, 3), (60, 51)] {
        let mut slab = slab(count);
        let mut world = row(&mut slab, count);
        let before = world.step().unwrap().pairs().to_vec();
        for slot in 0..moved {
            let x = [-2.0, 0.125, 1.25][slot as usize % 3];
            world.set_aabb(world.id_at(slot).unwrap(), cube(x + slot as f32)).unwrap();
        }
        faulty_step(&mut world);
        let step = world.step().unwrap();
        let pairs = step.pairs();
        let set = |pairs: &[[u32; 2]]| pairs.iter().copied().collect::<BTreeSet<_>>();
        assert_eq!(set(step.found()), &set(pairs) - &set(&before));
        assert_eq!(set(step.lost()), &set(&before) - &set(pairs));
        assert_eq!(step.lost().len(), set(step.lost()).len(), "no pair is lost twice");
        assert!(!step.found().is_empty() && !step.lost().is_empty());
        assert_eq!(world.validate(), Ok(()));
    }
}

/// Worlds with faults, on the same thread and on another, do not disturb a world.
#[test]
fn a_fault_is_a_matter_of_one_world() {
    let (mut good, mut other, mut parallel) = (slab(COUNT), slab(COUNT), slab(COUNT));
    let mut good = row(&mut good, COUNT);
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Relaxed) {
                let mut world = row(&mut parallel, COUNT);
                world.set_aabb(world.id_at(7).unwrap(), cube(7.25)).unwrap();
                faulty_step(&mut world);
            }
        });
        for frame in 1..30u16 {
            let mut other = row(&mut other, COUNT);
            other.set_aabb(other.id_at(7).unwrap(), cube(7.25)).unwrap();
            faulty_step(&mut other);
            let id = good.id_at(u32::from(frame) * 3).unwrap();
            good.set_aabb(id, cube(-2.0 - f32::from(frame) * 3.0)).unwrap();
            assert!(good.step().is_ok_and(|step| step.lost().len() == 2), "frame {frame}");
        }
        done.store(true, Relaxed);
    });
}

/// A fault that was not reported yet goes with a world to other memory, and what was there before is gone.
#[test]
fn a_fault_goes_where_the_world_goes() {
    let (mut from, mut copy, mut grown) = (slab(COUNT), slab(COUNT), slab(COUNT + 1));
    let (mut from, mut copy) = (row(&mut from, COUNT), row(&mut copy, COUNT));
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    from.break_index();
    copy.copy_from(&from).unwrap();
    let mut grown = from.move_into(bytemuck::cast_slice_mut(&mut grown), &config(COUNT + 1)).unwrap();
    for world in [&mut copy, &mut grown] {
        assert_eq!(world.step().err(), Some(Error::InvariantBroken));
        assert!(world.step().is_ok());
    }
    copy.break_index();
    assert_eq!(from.step().err(), Some(Error::InvariantBroken));
    from.step().unwrap();
    copy.copy_from(&from).unwrap();
    assert!(copy.step().is_ok());
}

/// Only without debug assertions, which stop at once and leave nothing to report.
#[cfg(not(debug_assertions))]
#[test]
fn an_index_out_of_range_is_an_error_of_the_step() {
    let mut slab = slab(COUNT);
    row(&mut slab, 100);
    // All objects are in one leaf, in the order of their slots: somewhere these are their places.
    let words: &mut [u32] = bytemuck::cast_slice_mut(&mut slab);
    for at in 7..words.len() {
        if words[at - 7..].starts_with(&[0, 1, 2, 3, 4, 5, 6, 7, 8]) {
            words[at] = 1 << 30;
        }
    }
    let mut world = World::<u32>::open(bytemuck::cast_slice_mut(&mut slab)).unwrap();
    world.set_aabb(world.id_at(7).unwrap(), cube(7.01)).unwrap();
    let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    assert_eq!(world.step().err(), Some(Error::InvariantBroken));
    drop(alone);
    let step = world.step().unwrap();
    assert_eq!((step.pairs().len(), step.lost()), (98, &[[6, 7]][..]));
    assert_eq!(world.validate(), Ok(()));
}
