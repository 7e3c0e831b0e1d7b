#![no_main]
//! A Blockly workspace of any bytes: refused, or followed to its end in bounded work, the same way each time.

use libfuzzer_sys::fuzz_target;
use magician_formats::{Format, ReadOptions, read};

fuzz_target!(|data: &[u8]| {
    let options = ReadOptions::default();
    let first = read(Format::Blockly, data, &options);
    assert_eq!(first, read(Format::Blockly, data, &options));
});
