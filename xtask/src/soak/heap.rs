//! Counts the heap memory in use by this thread, by a counting global allocator.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static IN_USE: Cell<isize> = const { Cell::new(0) };
}

/// System allocator with a counter.
struct CountingAllocator;

fn count(by: isize) {
    // The thread-local is gone while a thread ends, so errors are ignored.
    IN_USE.try_with(|bytes| bytes.set(bytes.get() + by)).ok();
}

// SAFETY: all is left to the system's allocator; counting allocates nothing.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Returns the bytes that this thread has allocated and not freed.
pub(super) fn in_use() -> usize {
    usize::try_from(IN_USE.get()).unwrap_or(0)
}
