#![no_main]
//! Station with hostile clients and arms: no panic, exactly one answer per request, bounded memory,
//! and only the lease holder moves an arm.

use libfuzzer_sys::fuzz_target;

#[path = "../../crates/magician-station/tests/hostile/host/mod.rs"]
mod host;

fuzz_target!(|script: &[u8]| {
    let mut life = host::Simulation::default();
    life.live(&String::from_utf8_lossy(script));
    life.end();
});
