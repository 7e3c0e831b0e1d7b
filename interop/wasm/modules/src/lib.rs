//! Modules whose sizes `interop/wasm/sizes` prints, one for each set of features. An export hands bytes from outside to a library, and
//! keeps what comes of them for outside; so nothing that it reaches is optimised away, and nothing else is in the module.
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

/// A byte for the next call.
#[unsafe(no_mangle)]
pub extern "C" fn give(byte: u32) {
    GIVEN.with_borrow_mut(|given| given.push(byte as u8));
}

/// The last byte of what was made and not taken yet; -1 if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn take() -> i32 {
    MADE.with_borrow_mut(|made| made.pop().map_or(-1, i32::from))
}

/// What was given since the call before.
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
