//! What snapshots and slabs have to do with the build that made them.

use std::vec;
use std::vec::Vec;
use trisap_core::{Aabb, Boxes, Capacity, Config, Error, Kernels, Margin, World, layout};

#[repr(C, align(64))]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Line([u8; 64]);

fn slab(config: &Config) -> Vec<Line> {
    vec![Line([0; 64]); layout::<u16>(config).expect("a small world").bytes.div_ceil(64)]
}

fn config(objects: u32) -> Config {
    let config = Config::new(Capacity::for_objects(objects).with_leaf_refs(0).with_pairs(600));
    config.with_lean().with_events().with_margin(Margin::length(0.25))
}

/// A world that any build can have, in the middle of its life.
fn lived(slab: &mut [Line], config: &Config) -> Vec<u8> {
    let mut world = World::<u16>::new_in(bytemuck::cast_slice_mut(slab), config).expect("room");
    let place = |k: u16| [f32::from(k % 7), f32::from(k * 5 % 11), f32::from(k * 3 % 5)];
    let boxes: Vec<Aabb> =
        (0..config.capacity.objects as u16).map(place).map(|at| Aabb::new(at, at.map(|x| x + 1.0))).collect();
    let ids: Vec<_> = world.insert_many(Boxes::new(&boxes)).expect("room").collect();
    for step in 0..3 {
        world.set_aabb(ids[step], boxes[step + 9]).expect("alive");
        world.set_kernels(Kernels::BASELINE).step().expect("room for the pairs");
    }
    world.remove(ids[4]).expect("alive");
    let mut bytes = vec![0; world.snapshot_size()];
    assert_eq!(world.save(&mut bytes), Ok(bytes.len()));
    assert_eq!(world.load(&bytes), Ok(()));
    bytes
}

/// Builds with and without the feature `large` write the same bytes, so that they read each other's: these tests run in both.
#[test]
fn a_snapshot_is_the_same_in_any_build() {
    let hashes = [50, 70].map(|objects| {
        let config = config(objects);
        let bytes = lived(&mut slab(&config), &config);
        bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |sum, byte| {
            (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
        })
    });
    if cfg!(target_endian = "little") {
        // Where the format changes, or what a step leaves, so do these.
        assert_eq!(hashes, [14_621_417_282_571_568_904, 16_645_963_030_003_261_996]);
    }
}

/// A slab is laid out otherwise in a build with another choice, and refused there.
#[test]
fn a_slab_of_another_build_is_refused() {
    let config = config(50);
    let mut slab = slab(&config);
    lived(&mut slab, &config);
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut slab);
    assert_eq!(World::<u16>::open(bytes).map(|world| world.len()), Ok(49));
    // The first number of the state: the version, and a bit for each of these features.
    let magic = u32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    for (bit, has) in [(15, cfg!(feature = "large")), (14, cfg!(any(feature = "lists", feature = "large")))] {
        assert_eq!(magic >> bit & 1 != 0, has);
        bytes[..4].copy_from_slice(&(magic ^ 1 << bit).to_ne_bytes());
        assert_eq!(World::<u16>::open(bytes).map(|world| world.len()), Err(Error::NotAWorld));
    }
}
