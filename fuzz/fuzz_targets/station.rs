#![no_main]
//! Clients and arms that do anything to a station: no panic, each request answered once, bounded memory, and no order that
//! moves an arm but for the holder of its lease.

use libfuzzer_sys::fuzz_target;

#[path = "../../crates/magician-station/tests/hostile/host/mod.rs"]
mod host;

fuzz_target!(|script: &[u8]| {
    let mut life = host::Life::default();
    life.live(&String::from_utf8_lossy(script));
    life.end();
});
