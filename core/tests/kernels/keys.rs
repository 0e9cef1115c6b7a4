//! Keys are the order of floats.

use super::aabb::Aabb;
use super::key::{KeyBox, NEGATIVE_INFINITY, POSITIVE_INFINITY, key, value};

#[test]
fn keys_are_the_order_of_all_floats() {
    // From one infinity to the other, a block at a time: each float is below the next and has its key. On
    // emulated processors some blocks are enough: the machine code differs, not the rule.
    let blocks = (NEGATIVE_INFINITY..POSITIVE_INFINITY).step_by(1 << 16);
    for block in blocks.step_by(if cfg!(target_arch = "x86_64") { 1 } else { 61 }) {
        let is_right = |k: i32| value(k) < value(k.wrapping_add(1)) && key(value(k)) == k;
        let right = (block..block + (1 << 16)).fold(true, |right, k| right & is_right(k));
        assert!(right, "between {:?} and the next 65,536 floats", value(block));
    }
    // Beyond them is NaN.
    for bits in (0x7f80_0001..=0x7fff_ffff_u32).step_by(if cfg!(target_arch = "x86_64") { 1 } else { 61 }) {
        assert!(key(f32::from_bits(bits)) > POSITIVE_INFINITY);
        assert!(key(f32::from_bits(bits | 1 << 31)) < NEGATIVE_INFINITY);
    }
    assert_eq!([key(f32::INFINITY), key(f32::NEG_INFINITY)], [POSITIVE_INFINITY, NEGATIVE_INFINITY]);
    assert_eq!([key(-0.0), key(0.0)], [0; 2]);
}

#[test]
fn growth_saturates_and_never_shrinks() {
    let wide = KeyBox::from_aabb(&Aabb::new([f32::MIN; 3], [f32::MAX; 3])).unwrap();
    assert_eq!(wide.grown(1e38), wide);
    let far = KeyBox::from_aabb(&Aabb::new([1e9; 3], [1e9; 3])).unwrap();
    assert_eq!(far.grown(0.01), far, "a margin below one ulp changes nothing");
    let unbounded = KeyBox::from_aabb(&Aabb::new([f32::NEG_INFINITY; 3], [0.0; 3])).unwrap();
    assert!(unbounded.grown(1.0).contains(&unbounded));
}
