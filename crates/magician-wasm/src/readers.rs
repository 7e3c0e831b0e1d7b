//! Exports of `files.wasm`.
#![allow(unsafe_code)] // What the page hands over is an address and a length, and exports have names without a crate's.

use std::alloc::{self, Layout};
use std::cell::RefCell;
use std::slice;

use magician_program::wire;

fn layout(count: usize) -> Option<Layout> {
    Layout::array::<u8>(count).ok().filter(|_| count > 0)
}

/// Allocates memory; null if it is exhausted.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn alloc(count: usize) -> *mut u8 {
    match layout(count) {
        // SAFETY: the layout is not empty.
        Some(layout) => unsafe { alloc::alloc(layout) },
        None => std::ptr::null_mut(),
    }
}

/// Frees memory.
///
/// # Safety
/// It must come from [`alloc`] with the same `count`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn free(at: *mut u8, count: usize) {
    if let Some(layout) = layout(count).filter(|_| !at.is_null()) {
        // SAFETY: guaranteed by the caller.
        unsafe { alloc::dealloc(at, layout) }
    }
}

/// Reads a file: returns the answer to a request as address and length.
///
/// # Safety
/// `count` bytes at `at` must be valid, such as those of [`alloc`]; or `at` is null.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn read(at: *const u8, count: usize) -> u64 {
    thread_local! {
        static ANSWER: RefCell<Vec<u8>> = RefCell::default();
    }
    let request = if at.is_null() {
        &[]
    } else {
        // SAFETY: guaranteed by the caller.
        unsafe { slice::from_raw_parts(at, count) }
    };
    ANSWER.with_borrow_mut(|answer| {
        // Free the previous answer first, because two may exceed the memory.
        *answer = Vec::new();
        *answer = wire::answer(request);
        (answer.as_ptr().addr() as u64) << 32 | answer.len() as u64
    })
}
