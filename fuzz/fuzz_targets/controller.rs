#![no_main]
//! A hostile host at the virtual arm: no panic, no end that never comes, and an arm that still takes orders.

use libfuzzer_sys::fuzz_target;

#[path = "../../crates/magician-sim/tests/host/mod.rs"]
mod host;

fuzz_target!(|script: &[u8]| {
    let mut life = host::Life::default();
    life.live(script);
    life.end();
});
