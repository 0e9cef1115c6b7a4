//! Boxes as callers give them.

use proptest::prelude::*;
use trisap_core::{Aabb, Boxes};

/// Boxes whose corners are anywhere, near the ends of the range, or near powers of two.
fn corner() -> impl Strategy<Value = i32> {
    let near = (0u32..32, -2i32..3, any::<bool>()).prop_map(|(bit, off, negative)| {
        let x = (1u32 << bit).wrapping_add_signed(off) as i32;
        if negative { x.wrapping_neg() } else { x }
    });
    prop_oneof![any::<i32>(), -99i32..99, near, Just(i32::MIN), Just(i32::MAX)]
}

fn fixed_box() -> impl Strategy<Value = [[i32; 3]; 2]> {
    let corners = || [corner(), corner(), corner()];
    (corners(), corners()).prop_map(|(a, b)| {
        let each = |choose: fn(i32, i32) -> i32| [0, 1, 2].map(|k| choose(a[k], b[k]));
        [each(i32::min), each(i32::max)]
    })
}

fn in_f64(corner: [i32; 3], fraction_bits: u32) -> [f64; 3] {
    corner.map(|x| f64::from(x) / 2f64.powi(fraction_bits as i32))
}

fn overlap([a, b]: [[i32; 3]; 2], [c, d]: [[i32; 3]; 2]) -> bool {
    (0..3).all(|k| a[k] <= d[k] && c[k] <= b[k])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn fixed_point_is_rounded_as_f64_is([min, max] in fixed_box(), fraction_bits in 0u32..=126) {
        let aabb = Aabb::from_fixed(min, max, fraction_bits);
        let [low, high] = [min, max].map(|corner| in_f64(corner, fraction_bits));
        prop_assert_eq!(aabb, Aabb::from_f64(low, high, [0.0; 3]));
        prop_assert!(aabb.is_valid());
    }

    #[test]
    fn fixed_point_loses_no_overlap(a in fixed_box(), b in fixed_box(), fraction_bits in 0u32..=126) {
        let [first, second] = [a, b].map(|[min, max]| Aabb::from_fixed(min, max, fraction_bits));
        prop_assert!(first.overlaps(&second) || !overlap(a, b));
    }

    #[test]
    fn fixed_point_of_24_bits_is_exact(a in fixed_box(), b in fixed_box(), fraction_bits in 0u32..=126) {
        // 24 bits of amount, and the sign.
        let [a, b] = [a, b].map(|corners| corners.map(|corner| corner.map(|x| x >> 7)));
        let [first, second] = [a, b].map(|[min, max]| Aabb::from_fixed(min, max, fraction_bits));
        prop_assert_eq!(first.overlaps(&second), overlap(a, b));
        prop_assert_eq!(first.min.map(f64::from), in_f64(a[0], fraction_bits));
        prop_assert_eq!(first.max.map(f64::from), in_f64(a[1], fraction_bits));
    }
}

#[test]
fn items_end_where_one_is_cut_off() {
    let bytes = [0u8; 3 * 40 + 31];
    for (max_at, count) in [(12, 4), (19, 4), (20, 3)] {
        let boxes = Boxes::strided(&bytes, 40, max_at).unwrap();
        assert_eq!(boxes.len(), count);
        for index in [0, 1, 2, 3, 4, usize::MAX / 40 + 2, usize::MAX] {
            assert_eq!(boxes.get(index).is_some(), index < count, "{max_at}, {index}");
        }
    }
}

#[test]
fn too_many_fraction_bits_are_refused() {
    assert!(Aabb::from_fixed([1; 3], [i32::MAX; 3], 126).is_valid());
    assert!(!Aabb::from_fixed([1; 3], [i32::MAX; 3], 127).is_valid());
    assert!(!Aabb::from_fixed([i32::MIN; 3], [0; 3], u32::MAX).is_valid());
    assert!(!Aabb::from_fixed([0; 3], [0; 3], 127).is_valid());
}

#[test]
fn nan_of_either_sign_is_refused() {
    for (nan, side) in [f32::NAN, -f32::NAN].into_iter().flat_map(|nan| (0..6).map(move |side| (nan, side))) {
        let mut sides = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        sides[side] = nan;
        assert!(!bytemuck::cast::<[f32; 6], Aabb>(sides).is_valid(), "{nan} as side {side}");
    }
}
