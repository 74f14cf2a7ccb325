//! An allocator for Linux: large pieces of memory in huge pages. The polyreel program uses it.
//!
//! Linux hands memory out page by page, when each is touched for the first time, and for a page of 4 KiB that takes
//! longer than filling it: a sixth of the time of rendering a still. Pieces of 1 MiB and more are mapped here in pages
//! of 2 MiB (transparent huge pages, `madvise(2)`); all others come from the system's allocator. Where the kernel has
//! no huge pages to give, they are ordinary ones.
//!
//! A library leaves the choice of an allocator to the program, so `polyreel` the library does not use it. On other
//! systems this crate is empty.
//!
//! `cargo bench -p polyreel-bench --bench huge_pages` measures what it saves.
#![cfg(target_os = "linux")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr::null_mut;

use rustix::mm::{Advice, MapFlags, ProtFlags, madvise, mmap_anonymous, munmap};

/// Bytes of a huge page, on all processors with pages of 4 KiB.
const PAGE: usize = 2 << 20;

/// Pieces of this size in bytes and more are large: at most half of what they take is left over. Measured from a quarter of
/// a page on: a still takes no less time, a video more memory.
const LARGE: usize = PAGE / 2;

/// The allocator: see the [crate](crate).
///
/// ```
/// #[global_allocator]
/// static MEMORY: polyreel_huge_pages::HugePages = polyreel_huge_pages::HugePages;
/// let zeros = vec![0_u8; 8 << 20];
/// assert!(zeros.iter().all(|&byte| byte == 0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct HugePages;

/// The whole pages that a large piece of memory takes, in bytes; `None` for one that is the system's.
fn pages(layout: Layout) -> Option<usize> {
    if layout.size() < LARGE || layout.align() > PAGE {
        return None;
    }
    // A layout has at most isize::MAX bytes: this is no overflow.
    Some(layout.size().next_multiple_of(PAGE))
}

/// Maps `bytes`, whole pages, that begin where a page does; null where that fails. They are zero.
fn map(bytes: usize) -> *mut u8 {
    let (access, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::PRIVATE);
    // SAFETY: the kernel chooses an address where nothing is mapped.
    let Ok(mapped) = (unsafe { mmap_anonymous(null_mut(), bytes + PAGE, access, flags) }) else {
        return null_mut();
    };
    let before = mapped.addr().next_multiple_of(PAGE) - mapped.addr();
    let (begin, end) = (mapped.wrapping_byte_add(before), mapped.wrapping_byte_add(before + bytes));
    // SAFETY: all three ranges lie in what was mapped just now, which nobody knows of yet, and begin and end
    // with pages of 4 KiB: the mapping does, and before it, between and after it are whole numbers of them.
    // What is unmapped is not used again. That advice is not taken does no harm.
    unsafe {
        if before > 0 {
            let _ = munmap(mapped, before);
        }
        if before < PAGE {
            let _ = munmap(end, PAGE - before);
        }
        let _ = madvise(begin, bytes, Advice::LinuxHugepage);
    }
    begin.cast()
}

// SAFETY: `pages` tells from the layout alone who a piece of memory comes from, so that it goes back there.
// Mapped pieces are as long as was asked for or longer, aligned to PAGE, and of nobody else. The system's
// keep its promises. Nothing unwinds: overflow is excluded, and there is no other way to panic.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        match pages(layout) {
            Some(bytes) => map(bytes),
            // SAFETY: as the caller promises.
            None => unsafe { System.alloc(layout) },
        }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        match pages(layout) {
            Some(bytes) => map(bytes),
            // SAFETY: as the caller promises.
            None => unsafe { System.alloc_zeroed(layout) },
        }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller promises that `memory` was had here with this layout, and is used no more.
        unsafe {
            match pages(layout) {
                Some(bytes) => {
                    let _ = munmap(memory.cast(), bytes);
                }
                None => System.dealloc(memory, layout),
            }
        }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller promises that `size`, rounded up to the alignment, does not overflow, and that
        // `memory` was had here with this layout.
        unsafe {
            let new = Layout::from_size_align_unchecked(size, layout.align());
            match (pages(layout), pages(new)) {
                (None, None) => System.realloc(memory, layout, size),
                (Some(bytes), Some(wanted)) if bytes == wanted => memory,
                _ => {
                    let moved = self.alloc(new);
                    if !moved.is_null() {
                        moved.copy_from_nonoverlapping(memory, layout.size().min(size));
                        self.dealloc(memory, layout);
                    }
                    moved
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: [usize; 8] =
        [1, 4096, LARGE - 1, LARGE, PAGE - 1, PAGE, PAGE + 1, 3 * PAGE + 12345];

    fn layout(size: usize, align: usize) -> Layout {
        Layout::from_size_align(size, align).expect("a small size and a power of two")
    }

    /// Every byte of `memory` can be written and holds what is written.
    fn fill(memory: *mut u8, size: usize, seed: usize) {
        // SAFETY: `size` bytes were had there.
        let bytes = unsafe { std::slice::from_raw_parts_mut(memory, size) };
        bytes.iter_mut().enumerate().for_each(|(i, byte)| *byte = ((i * 31 + seed) % 251) as u8);
    }

    fn is_filled(memory: *mut u8, size: usize, seed: usize) -> bool {
        // SAFETY: as above.
        let bytes = unsafe { std::slice::from_raw_parts(memory, size) };
        bytes.iter().enumerate().all(|(i, &byte)| byte == ((i * 31 + seed) % 251) as u8)
    }

    #[test]
    fn pieces_are_aligned_apart_and_zero_where_asked() {
        for align in [1, 8, 64, 4096, PAGE, 2 * PAGE] {
            let had: Vec<_> = SIZES
                .iter()
                .map(|&size| {
                    let layout = layout(size, align);
                    // SAFETY: no size is 0.
                    let memory = unsafe { HugePages.alloc_zeroed(layout) };
                    assert!(!memory.is_null() && memory.addr().is_multiple_of(align));
                    // SAFETY: as long as that.
                    let bytes = unsafe { std::slice::from_raw_parts(memory, size) };
                    assert!(bytes.iter().all(|&byte| byte == 0), "{size} at {align}");
                    fill(memory, size, size);
                    (memory, layout)
                })
                .collect();
            for (memory, layout) in had {
                assert!(is_filled(memory, layout.size(), layout.size()), "{layout:?}");
                // SAFETY: had with this layout, once.
                unsafe { HugePages.dealloc(memory, layout) };
            }
        }
    }

    #[test]
    fn what_grows_or_shrinks_keeps_what_it_holds() {
        for (from, to) in SIZES.iter().flat_map(|&from| SIZES.map(|to| (from, to))) {
            for align in [1, 64] {
                // SAFETY: no size is 0; each piece is used and given back with the layout that it has.
                unsafe {
                    let memory = HugePages.alloc(layout(from, align));
                    fill(memory, from, to);
                    let memory = HugePages.realloc(memory, layout(from, align), to);
                    assert!(memory.addr().is_multiple_of(align));
                    assert!(is_filled(memory, from.min(to), to), "{from} to {to} at {align}");
                    fill(memory, to, from);
                    HugePages.dealloc(memory, layout(to, align));
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_had_is_null() {
        let vast = layout(isize::MAX as usize - PAGE, 1);
        // SAFETY: not 0 bytes.
        assert!(unsafe { HugePages.alloc(vast) }.is_null());
    }
}
