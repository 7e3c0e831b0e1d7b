//! Modules whose sizes `interop/wasm/sizes` prints, one per set of features. Each export passes
//! bytes from outside to a library and returns its output, so that the linker removes nothing of
//! what is measured and the module contains nothing else.
#![allow(unsafe_code)] // Only for the names of exports.

#[cfg(feature = "arm")]
mod arm;
#[cfg(feature = "host")]
mod host;
#[cfg(feature = "program")]
mod program;

use std::cell::RefCell;

thread_local! {
    static GIVEN: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static MADE: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Appends a byte to the input of the next call.
#[unsafe(no_mangle)]
pub extern "C" fn give(byte: u32) {
    GIVEN.with_borrow_mut(|given| given.push(byte as u8));
}

/// Removes and returns the last byte of the output; -1 if it is empty.
#[unsafe(no_mangle)]
pub extern "C" fn take() -> i32 {
    MADE.with_borrow_mut(|made| made.pop().map_or(-1, i32::from))
}

/// Takes the input given since the last call.
#[cfg_attr(
    not(any(feature = "arm", feature = "host", feature = "program")),
    expect(dead_code)
)]
fn given() -> Vec<u8> {
    GIVEN.take()
}

#[cfg_attr(
    not(any(feature = "arm", feature = "host", feature = "program")),
    expect(dead_code)
)]
fn made(bytes: &[u8]) {
    MADE.with_borrow_mut(|made| made.extend(bytes));
}
