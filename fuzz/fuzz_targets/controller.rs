#![no_main]
//! Virtual arm against a hostile host: it must not panic or run for ever, must still accept
//! commands, and must give bit-equal results however time is split.

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
