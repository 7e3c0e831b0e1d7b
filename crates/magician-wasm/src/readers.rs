//! The exports of `files.wasm`.
#![allow(unsafe_code)] // What the page hands over is an address and a length, and exports have names without a crate's.

use std::alloc::{self, Layout};
use std::cell::RefCell;
use std::slice;

use magician_program::wire;

fn layout(count: usize) -> Option<Layout> {
    Layout::array::<u8>(count).ok().filter(|_| count > 0)
}

/// Memory for so many bytes; null where no more can be had.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn alloc(count: usize) -> *mut u8 {
    match layout(count) {
        // SAFETY: it is more than nothing.
        Some(layout) => unsafe { alloc::alloc(layout) },
        None => std::ptr::null_mut(),
    }
}

/// Gives memory back.
///
/// # Safety
/// It is that of [`alloc`], of so many bytes.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn free(at: *mut u8, count: usize) {
    if let Some(layout) = layout(count).filter(|_| !at.is_null()) {
        // SAFETY: by the caller's word.
        unsafe { alloc::dealloc(at, layout) }
    }
}

/// Reads a file: the answer to a request, as address and length.
///
/// # Safety
/// The request is `count` bytes at `at`: those of [`alloc`], or none.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn read(at: *const u8, count: usize) -> u64 {
    thread_local! {
        static ANSWER: RefCell<Vec<u8>> = RefCell::default();
    }
    let request = if at.is_null() {
        &[]
    } else {
        // SAFETY: by the caller's word.
        unsafe { slice::from_raw_parts(at, count) }
    };
    ANSWER.with_borrow_mut(|answer| {
        // The last one goes first: two of them may be more than there is room for.
        *answer = Vec::new();
        *answer = wire::answer(request);
        (answer.as_ptr().addr() as u64) << 32 | answer.len() as u64
    })
}
