//! Allocates the memory of an owned world: zeroed, aligned, and backed by pages from the start, so that no step waits
//! for them.

use core::ops::{Deref, DerefMut, Range};

/// The alignment of a world.
const ALIGN: usize = 64;

pub(crate) enum Memory {
    /// Plain bytes, and which of them are aligned. To have the allocator align them takes twice as long, as glibc then writes zeros
    /// to pages that are zero, and finds no use for what was given back.
    Heap(Box<[u8]>, Range<usize>),
    #[cfg(target_os = "linux")]
    Pages(memmap2::MmapMut),
}

impl Memory {
    /// Zeroed memory of so many bytes or a few more; `None` if it cannot be had.
    pub(crate) fn zeroed(bytes: usize) -> Option<Self> {
        let mut memory = Self::reserved(bytes)?;
        // Written, so that its pages exist.
        memory.fill(0);
        Some(memory)
    }

    /// The same; on most systems, pages of fresh memory come when they are first used.
    pub(crate) fn reserved(bytes: usize) -> Option<Self> {
        #[cfg(target_os = "linux")]
        if bytes >= huge::PAGE {
            return huge::reserved(bytes).map(Self::Pages);
        }
        let room = bytemuck::allocation::try_zeroed_slice_box(bytes.checked_add(ALIGN - 1)?).ok()?;
        let start = <[u8]>::as_ptr(&room).align_offset(ALIGN);
        Some(Self::Heap(room, start..start + bytes))
    }
}

impl Deref for Memory {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Heap(room, aligned) => &room[aligned.clone()],
            #[cfg(target_os = "linux")]
            Self::Pages(pages) => pages,
        }
    }
}

impl DerefMut for Memory {
    fn deref_mut(&mut self) -> &mut [u8] {
        match self {
            Self::Heap(room, aligned) => &mut room[aligned.clone()],
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
            assert!(memory.as_ptr().addr().is_multiple_of(ALIGN));
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
