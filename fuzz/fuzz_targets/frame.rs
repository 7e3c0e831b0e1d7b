#![no_main]
//! Arbitrary bytes as the state of an arm: no panic, and a decoded state encodes to the same bytes.

use libfuzzer_sys::fuzz_target;
use magician_station::StateFrame;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(frame) = StateFrame::read(bytes) {
        assert_eq!(frame.to_bytes(), bytes);
    }
});
