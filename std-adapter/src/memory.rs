//! Allocates the memory of an owned world: zeroed, aligned, and backed by pages from the start, so that no step waits
//! for them.

use bytemuck::{Pod, Zeroable};
use core::ops::{Deref, DerefMut};

/// A unit of memory with the alignment of a world.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Block([u8; 64]);

pub(crate) enum Memory {
    Heap(Box<[Block]>),
    #[cfg(target_os = "linux")]
    Pages(memmap2::MmapMut),
}

impl Memory {
    /// Zeroed memory of so many bytes or a few more; `None` if it cannot be had.
    pub(crate) fn zeroed(bytes: usize) -> Option<Self> {
        let mut memory = Self::reserved(bytes)?;
        #[cfg(target_os = "linux")]
        if let Self::Pages(pages) = &mut memory {
            // Written, so that its pages exist.
            pages.fill(0);
        }
        Some(memory)
    }

    /// The same; on most systems, pages of large memory come when they are first used.
    pub(crate) fn reserved(bytes: usize) -> Option<Self> {
        #[cfg(target_os = "linux")]
        if bytes >= huge::PAGE {
            return huge::reserved(bytes).map(Self::Pages);
        }
        bytemuck::allocation::try_zeroed_slice_box(bytes.div_ceil(size_of::<Block>())).ok().map(Self::Heap)
    }
}

impl Deref for Memory {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Heap(blocks) => bytemuck::cast_slice(blocks),
            #[cfg(target_os = "linux")]
            Self::Pages(pages) => pages,
        }
    }
}

impl DerefMut for Memory {
    fn deref_mut(&mut self) -> &mut [u8] {
        match self {
            Self::Heap(blocks) => bytemuck::cast_slice_mut(blocks),
            #[cfg(target_os = "linux")]
            Self::Pages(pages) => pages,
        }
    }
}

/// Memory in huge pages. A step with few movers touches a few dozen places in a large world for each of them. With
/// small pages, a fifth of its time goes into the translation of addresses.
#[cfg(target_os = "linux")]
mod huge {
    use memmap2::{Advice, MmapMut};

    /// The size of a huge page on most targets. If it is another one, or the system has none, pages are small.
    pub(super) const PAGE: usize = 2 << 20;

    pub(super) fn reserved(bytes: usize) -> Option<MmapMut> {
        // Whole huge pages: Linux aligns no others.
        let memory = MmapMut::map_anon(bytes.checked_next_multiple_of(PAGE)?).ok()?;
        // Refused if the system has no huge pages; small ones serve then.
        let _ = memory.advise(Advice::HugePage);
        Some(memory)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On both sides of a huge page.
    #[test]
    fn is_long_enough_aligned_and_zeroed() {
        for bytes in [0, 1, 100, (2 << 20) - 1, 2 << 20, (2 << 20) + 1] {
            let mut memory = Memory::zeroed(bytes).expect("a few MiB");
            assert!(memory.len() >= bytes, "{} of {bytes}", memory.len());
            assert!(memory.as_ptr().addr().is_multiple_of(align_of::<Block>()));
            assert!(memory.iter().all(|&byte| byte == 0));
            memory.fill(1);
            assert!(memory.iter().all(|&byte| byte == 1));
        }
    }

    #[test]
    fn what_cannot_be_had_is_none() {
        assert!(Memory::zeroed(isize::MAX as usize - (4 << 20)).is_none());
        assert!(Memory::zeroed(usize::MAX).is_none());
    }
}
