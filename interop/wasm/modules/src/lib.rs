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
    static INPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static OUTPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Appends a byte to the input of the next call.
#[unsafe(no_mangle)]
pub extern "C" fn give(byte: u32) {
    INPUT.with_borrow_mut(|given| given.push(byte as u8));
}

/// Removes and returns the last byte of the output; -1 if it is empty.
#[unsafe(no_mangle)]
pub extern "C" fn take() -> i32 {
    OUTPUT.with_borrow_mut(|made| made.pop().map_or(-1, i32::from))
}

/// Takes the input given since the last call.
#[cfg_attr(
    not(any(feature = "arm", feature = "host", feature = "program")),
    expect(dead_code)
)]
fn take_input() -> Vec<u8> {
    INPUT.take()
}

#[cfg_attr(
    not(any(feature = "arm", feature = "host", feature = "program")),
    expect(dead_code)
)]
fn set_output(bytes: &[u8]) {
    OUTPUT.with_borrow_mut(|made| made.extend(bytes));
}
