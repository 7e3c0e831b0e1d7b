#![no_main]
//! Bytes as a state of an arm: no panic, and what is read is written as it was.

use libfuzzer_sys::fuzz_target;
use magician_station::StateFrame;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(frame) = StateFrame::read(bytes) {
        assert_eq!(frame.to_bytes(), bytes);
    }
});
