#![no_main]
//! Blockly workspace of arbitrary bytes: refused, or executed in bounded work, with the same result
//! each time.

use libfuzzer_sys::fuzz_target;
use magician_formats::{Format, ReadOptions, read};

fuzz_target!(|data: &[u8]| {
    let options = ReadOptions::default();
    let first = read(Format::Blockly, data, &options);
    assert_eq!(first, read(Format::Blockly, data, &options));
});
