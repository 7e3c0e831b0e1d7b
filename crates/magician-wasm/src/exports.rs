//! The exports of the module: what [`table`](crate::table) does, by addresses in its memory.
#![allow(unsafe_code)] // What the page hands over is an address and a length, and exports have names without a crate's.

use std::slice;
use std::sync::Once;

use crate::table;

/// Bytes that were handed in.
///
/// # Safety
/// They are `count` bytes at `at`, which stay as they are during the call: those of [`alloc`], or none.
unsafe fn given<'a>(at: *const u8, count: usize) -> &'a [u8] {
    if at.is_null() || count == 0 {
        return &[];
    }
    // SAFETY: by the caller's word; `alloc` gives no more than there can be.
    unsafe { slice::from_raw_parts(at, count) }
}

unsafe extern "C" {
    fn malloc(count: usize) -> *mut u8;
    fn __wasm_call_ctors();
}

/// What the C library wants done once. A linker that does not see it called takes the module for a program, and begins and ends that
/// program in every export.
static BEGUN: Once = Once::new();

/// Memory for so many bytes; null where no more can be had. The export `free` is that of the C library below, which knows how many they are
/// (`build.rs`): two of that name cannot be in one module.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn alloc(count: usize) -> *mut u8 {
    // SAFETY: it takes any size.
    unsafe { malloc(count) }
}

/// Opens a station.
///
/// # Safety
/// As for all bytes that are handed in: they are there.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn station_open(config: *const u8, count: usize) -> u32 {
    // SAFETY: it is called once.
    BEGUN.call_once(|| unsafe { __wasm_call_ctors() });
    // SAFETY: by the caller's word.
    table::station_open(unsafe { given(config, count) })
}

/// Text of a session.
///
/// # Safety
/// As for all bytes that are handed in: they are there.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn station_rpc(
    handle: u32,
    session: u32,
    text: *const u8,
    count: usize,
) {
    // SAFETY: by the caller's word.
    table::station_rpc(handle, session, unsafe { given(text, count) });
}

/// Does what is due.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn station_turn(handle: u32, now: f64) -> f64 {
    table::station_turn(handle, now)
}

/// What comes out, as address and length; 0 if nothing does.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn station_out(handle: u32) -> u64 {
    table::station_out(handle, place).unwrap_or(0)
}

/// Where bytes lie, as address and length.
fn place(bytes: &[u8]) -> u64 {
    (bytes.as_ptr().addr() as u64) << 32 | bytes.len() as u64
}

/// What came of a file.
///
/// # Safety
/// As for all bytes that are handed in: they are there.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn file_in(handle: u32, id: u32, answer: *const u8, count: usize) {
    // SAFETY: by the caller's word.
    table::file_in(handle, id, unsafe { given(answer, count) });
}

/// Keeps a program; why not, as address and length, or 0.
///
/// # Safety
/// As for all bytes that are handed in: they are there.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn program_in(
    handle: u32,
    name: *const u8,
    letters: usize,
    bytes: *const u8,
    count: usize,
) -> u64 {
    // SAFETY: by the caller's word.
    let (name, bytes) = unsafe { (given(name, letters), given(bytes, count)) };
    table::program_in(handle, name, bytes, place).unwrap_or(0)
}

/// Shows a program, as address and length, or 0. An empty one has an address.
///
/// # Safety
/// As for all bytes that are handed in: they are there.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn program_out(handle: u32, name: *const u8, letters: usize) -> u64 {
    // SAFETY: by the caller's word.
    table::program_out(handle, unsafe { given(name, letters) }, place).unwrap_or(0)
}

/// Bytes of the real arm.
///
/// # Safety
/// As for all bytes that are handed in: they are there.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn line_in(handle: u32, bytes: *const u8, count: usize) {
    // SAFETY: by the caller's word.
    table::line_in(handle, unsafe { given(bytes, count) });
}

/// The line broke.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn line_lost(handle: u32) {
    table::line_lost(handle);
}

/// The line is there again.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn line_found(handle: u32) {
    table::line_found(handle);
}
