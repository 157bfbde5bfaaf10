//! An allocator that counts, and refuses memory beyond a limit. The process then ends, and its parent reports the case.

#![expect(unsafe_code, reason = "an allocator is unsafe by its trait")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Bytes in use.
static LIVE: AtomicUsize = AtomicUsize::new(0);

/// The most that may be.
static LIMIT: AtomicUsize = AtomicUsize::new(usize::MAX);

pub(crate) struct Limited;

/// Runs a function that may use so many bytes more than there are in use.
pub(crate) fn within<T>(bytes: usize, f: impl FnOnce() -> T) -> T {
    let limit = LIVE.load(Ordering::Relaxed).saturating_add(bytes);
    LIMIT.store(limit, Ordering::Relaxed);
    let out = f();
    LIMIT.store(usize::MAX, Ordering::Relaxed);
    out
}

/// Whether so many bytes more may be used; then they are counted.
fn take(bytes: usize) -> bool {
    let before = LIVE.fetch_add(bytes, Ordering::Relaxed);
    let fits = before.saturating_add(bytes) <= LIMIT.load(Ordering::Relaxed);
    if !fits {
        give(bytes);
    }
    fits
}

fn give(bytes: usize) {
    LIVE.fetch_sub(bytes, Ordering::Relaxed);
}

// SAFETY: calls are passed on to the system's allocator unchanged, or answered by null, which means that there is no memory.
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if !take(layout.size()) {
            return std::ptr::null_mut();
        }
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if !take(layout.size()) {
            return std::ptr::null_mut();
        }
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if !take(size) {
            return std::ptr::null_mut();
        }
        give(layout.size());
        // SAFETY: the pointer came from this allocator, so from the system's; the caller keeps the rest of the contract.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        give(layout.size());
        // SAFETY: the pointer came from this allocator, so from the system's.
        unsafe { System.dealloc(pointer, layout) }
    }
}
