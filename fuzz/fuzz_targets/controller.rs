#![no_main]
//! A hostile host at the virtual arm: no panic, no end that never comes, an arm that still takes orders, and the same story
//! to the bit however time is cut.

use libfuzzer_sys::fuzz_target;

#[path = "../../crates/magician-sim/tests/virtual_arm/host/mod.rs"]
mod host;

fuzz_target!(|script: &[u8]| {
    let mut life = host::Life::default();
    life.live(script);
    let mut pieces = host::Life::in_pieces();
    pieces.live(script);
    assert_eq!(life.story, pieces.story);
    life.end();
});
