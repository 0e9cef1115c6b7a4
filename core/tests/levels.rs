//! The levels of this CPU.

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use std::arch::is_x86_feature_detected as has;
use trisap_core::Kernels;

#[test]
fn the_best_level_of_the_cpu_is_detected() {
    let plain = cfg!(feature = "scalar") || Kernels::BASELINE.name() == "scalar";
    let mut levels = if plain { std::vec!["scalar"] } else { std::vec![] };
    if cfg!(target_arch = "aarch64") {
        levels.push("neon");
    }
    if cfg!(target_feature = "simd128") {
        levels.push("simd128");
    }
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if cfg!(feature = "sse41") && has!("ssse3") && has!("sse4.1") && has!("popcnt") {
        levels.push("sse4.1");
    }
    #[allow(unused_mut, reason = "of x86-64 alone")]
    let mut best = levels[levels.len() - 1];
    #[cfg(target_arch = "x86_64")]
    if cfg!(feature = "avx2") && has!("avx2") && has!("bmi1") && has!("bmi2") && has!("popcnt") {
        levels.push("avx2");
        best = "avx2";
    }
    assert!(Kernels::all().map(Kernels::name).eq(levels.iter().copied()), "{levels:?}");
    assert_eq!(Kernels::detect().name(), best);
    // What the target promises.
    let baseline = if cfg!(target_arch = "aarch64") {
        "neon"
    } else if cfg!(target_feature = "simd128") {
        "simd128"
    } else if cfg!(all(
        target_arch = "x86_64",
        target_feature = "avx2",
        target_feature = "bmi1",
        target_feature = "bmi2",
        target_feature = "popcnt"
    )) {
        "avx2"
    } else if cfg!(all(target_feature = "sse4.1", target_feature = "popcnt")) {
        "sse4.1"
    } else {
        "scalar"
    };
    assert_eq!(Kernels::BASELINE.name(), baseline);
    assert!(levels.contains(&baseline));
    assert!(levels.iter().all(|name| Kernels::by_name(name).is_some_and(|level| level.name() == *name)));
}
