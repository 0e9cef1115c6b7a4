//! Threads as audio and game hosts set them: denormal results are flushed to zero and denormal inputs count as
//! zero.

#![allow(unsafe_code, reason = "sets the mode of the processor")]

/// Runs `work` on this thread with denormals flushed.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
pub fn flushed<T>(work: impl FnOnce() -> T) -> T {
    // SAFETY: Rust's own rules know only the default mode; what can happen in the other one is that folded
    // constants and values computed at run time differ for denormals. The tests that run here exist to show that
    // no result depends on such a value. The mode is put back before anything else runs.
    unsafe { no_denormals::no_denormals(work) }
}

/// Runs `work`: this target has no such mode that a test could set.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
pub fn flushed<T>(work: impl FnOnce() -> T) -> T {
    work()
}

#[cfg(all(test, any(target_arch = "x86_64", target_arch = "aarch64")))]
mod tests {
    use super::*;
    use std::hint::black_box;

    // The outer black boxes keep the compiler from moving the operation out of the mode that it does not know of.

    #[test]
    fn the_mode_is_on_inside_and_off_after() {
        let halved = || black_box(black_box(f32::MIN_POSITIVE) * 0.5);
        assert_eq!(flushed(halved), 0.0);
        assert_ne!(halved(), 0.0);
    }

    #[test]
    #[cfg(target_arch = "x86_64")]
    fn denormal_inputs_count_as_zero() {
        let equal = || black_box(black_box(f32::from_bits(1)) == black_box(0.0));
        assert!(flushed(equal));
        assert!(!equal());
    }
}
