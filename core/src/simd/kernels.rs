//! The instruction set that a step uses.

use super::{Phase, scalar::Scalar};

#[cfg(target_arch = "x86_64")]
use super::{Simd, avx512::Avx512, detect::Avx2};

/// The instruction set that a step uses. A value is the proof that the CPU has it, so it can be kept and copied.
/// Every level gives the same bytes; they differ in speed alone.
#[derive(Clone, Copy, Debug)]
pub struct Kernels(Level);

#[derive(Clone, Copy, Debug)]
enum Level {
    Scalar(Scalar),
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Kernels {
    /// What every CPU of the target has.
    pub const SCALAR: Self = Self(Level::Scalar(Scalar));

    /// The best level that needs no detection.
    pub const BASELINE: Self = Self::SCALAR;

    /// The best level of this CPU. Asks the CPU once and remembers. AVX-512 from its second generation on (with VBMI2: Ice Lake,
    /// Zen 4): on the first one, where a step with it was measured, AVX2 is faster.
    #[must_use]
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(level) = Self::avx512().filter(|_| Avx512::pays()) {
            return level;
        }
        Self::avx2().unwrap_or(Self::BASELINE)
    }

    /// AVX2 of x86-64, where this CPU has it.
    #[must_use]
    pub fn avx2() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        return Avx2::detect().map(|token| Self(Level::Avx2(token)));
        #[cfg(not(target_arch = "x86_64"))]
        return None;
    }

    /// AVX-512 of x86-64 with the parts F, BW, DQ and VL, where this CPU has it: Skylake-X, Zen 4 and later.
    #[must_use]
    pub fn avx512() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        return Avx512::detect().map(|token| Self(Level::Avx512(token)));
        #[cfg(not(target_arch = "x86_64"))]
        return None;
    }

    /// Every level of this CPU, the plainest first.
    pub fn all() -> impl Iterator<Item = Self> {
        [Some(Self::SCALAR), Self::avx2(), Self::avx512()].into_iter().flatten()
    }

    /// The name of the level, as the program's `--kernels` takes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.0 {
            Level::Scalar(_) => "scalar",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(_) => "avx512",
        }
    }

    /// The level of this name, where this CPU has it.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        Self::all().find(|level| level.name() == name)
    }

    /// Runs a phase compiled for this level; for AVX2 where the CPU has AVX-512, whose masks and registers are only worth
    /// their price where many rows are compared.
    #[inline]
    pub(crate) fn run<P: Phase>(self, phase: P) -> P::Output {
        match self.0 {
            Level::Scalar(simd) => phase.run(simd),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(simd) => simd.call(phase),
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(simd) => simd.narrow().call(phase),
        }
    }

    /// As [`run`](Self::run), for AVX-512 too: where many rows are compared.
    #[inline]
    pub(crate) fn run_wide<P: Phase>(self, phase: P) -> P::Output {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(simd) => simd.call(phase),
            _ => self.run(phase),
        }
    }
}

impl Default for Kernels {
    /// The detected level.
    fn default() -> Self {
        Self::detect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_level_of_the_cpu_is_detected() {
        #[allow(unused_mut, reason = "other targets have one level")]
        let (mut levels, mut best) = (std::vec!["scalar"], "scalar");
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            if has!("avx2") && has!("bmi1") && has!("bmi2") && has!("popcnt") {
                levels.push("avx2");
                best = "avx2";
                if has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl") {
                    levels.push("avx512");
                    // The first generation is slower with it.
                    best = if has!("avx512vbmi2") { "avx512" } else { best };
                }
            }
        }
        assert!(Kernels::all().map(Kernels::name).eq(levels.iter().copied()), "{levels:?}");
        assert_eq!(Kernels::detect().name(), best);
        assert!(levels.iter().all(|name| Kernels::by_name(name).is_some_and(|level| level.name() == *name)));
    }
}
