//! One number that stands for all pairs of a run.

use trisap_core::Pair;

/// 64-bit FNV-1a.
pub struct Digest(pub u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    /// Adds pairs in their order; the length keeps apart what follows one another.
    pub fn pairs(&mut self, pairs: &[Pair<u16>]) {
        self.word(pairs.len() as u32);
        for &[a, b] in pairs {
            self.word(u32::from(a) << 16 | u32::from(b));
        }
    }

    fn word(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
