//! Asks the CPU for AVX2. A value is the proof that it was asked.

cpufeatures::new!(detected, "avx2", "bmi1", "bmi2", "popcnt");

/// Proof that the CPU has AVX2, BMI1, BMI2 and POPCNT, and that the operating system saves the wide registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(pub(super) ());

impl Avx2 {
    /// Asks the CPU.
    pub(crate) fn detect() -> Option<Self> {
        detected::get().then_some(Self(()))
    }
}
