//! Exports of the module: the functions of [`table`](crate::table), with addresses in its memory.
// Unsafe code: the page passes addresses and lengths, and exports have unmangled names.
#![allow(unsafe_code)]

use std::slice;
use std::sync::Once;

use crate::table;

/// Returns the bytes passed by the page.
///
/// # Safety
/// `count` bytes at `at` must be valid and unchanged during the call, such as those of [`alloc`];
/// or `count` is 0.
unsafe fn input<'a>(at: *const u8, count: usize) -> &'a [u8] {
    if at.is_null() || count == 0 {
        return &[];
    }
    // SAFETY: guaranteed by the caller; `alloc` returns no more than a slice may have.
    unsafe { slice::from_raw_parts(at, count) }
}

unsafe extern "C" {
    fn malloc(count: usize) -> *mut u8;
    fn __wasm_call_ctors();
}

/// Initialisation of the C library, once. If the linker does not see `__wasm_call_ctors` called, it
/// treats the module as a command, and every export would run the constructors and destructors.
static INITIALISED: Once = Once::new();

/// Allocates memory; null if it is exhausted. `build.rs` exports the C library's own `free`, which
/// knows the size of each block. This file defines none, because a module cannot export two
/// functions of that name.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn alloc(count: usize) -> *mut u8 {
    // SAFETY: `malloc` accepts any size.
    unsafe { malloc(count) }
}

/// Opens a station.
///
/// # Safety
/// The bytes must be valid, as for [`input`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn station_open(config: *const u8, count: usize) -> u32 {
    // SAFETY: called exactly once.
    INITIALISED.call_once(|| unsafe { __wasm_call_ctors() });
    // SAFETY: guaranteed by the caller.
    table::station_open(unsafe { input(config, count) })
}

/// Passes text of a session to the station.
///
/// # Safety
/// The bytes must be valid, as for [`input`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn station_rpc(
    handle: u32,
    session: u32,
    text: *const u8,
    count: usize,
) {
    // SAFETY: guaranteed by the caller.
    table::station_rpc(handle, session, unsafe { input(text, count) });
}

/// Runs everything that is due.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn station_turn(handle: u32, now: f64) -> f64 {
    table::station_turn(handle, now)
}

/// Returns the next output as address and length; 0 without further output.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn station_out(handle: u32) -> u64 {
    table::station_out(handle, pack).unwrap_or(0)
}

/// Packs the address and length of bytes.
fn pack(bytes: &[u8]) -> u64 {
    (bytes.as_ptr().addr() as u64) << 32 | bytes.len() as u64
}

/// Passes the result of reading a file.
///
/// # Safety
/// The bytes must be valid, as for [`input`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn file_in(handle: u32, id: u32, answer: *const u8, count: usize) {
    // SAFETY: guaranteed by the caller.
    table::file_in(handle, id, unsafe { input(answer, count) });
}

/// Stores a program. Returns the error as address and length, or 0.
///
/// # Safety
/// The bytes must be valid, as for [`input`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn program_in(
    handle: u32,
    name: *const u8,
    name_length: usize,
    bytes: *const u8,
    count: usize,
) -> u64 {
    // SAFETY: guaranteed by the caller.
    let (name, bytes) = unsafe { (input(name, name_length), input(bytes, count)) };
    table::program_in(handle, name, bytes, pack).unwrap_or(0)
}

/// Returns a program as address and length, or 0 if it does not exist. An empty program has an
/// address.
///
/// # Safety
/// The bytes must be valid, as for [`input`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn program_out(
    handle: u32,
    name: *const u8,
    name_length: usize,
) -> u64 {
    // SAFETY: guaranteed by the caller.
    table::program_out(handle, unsafe { input(name, name_length) }, pack).unwrap_or(0)
}

/// Passes bytes received from the real arm.
///
/// # Safety
/// The bytes must be valid, as for [`input`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn line_in(handle: u32, bytes: *const u8, count: usize) {
    // SAFETY: guaranteed by the caller.
    table::line_in(handle, unsafe { input(bytes, count) });
}

/// Reports that the line broke.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn line_lost(handle: u32) {
    table::line_lost(handle);
}

/// Reports that the line is back.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn line_found(handle: u32) {
    table::line_found(handle);
}
