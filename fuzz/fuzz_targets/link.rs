#![no_main]
//! Program for DobotLink that sends anything, and a station that answers anything: no panic,
//! exactly one answer per call, and an end.

use libfuzzer_sys::fuzz_target;
use magician_link::LinkOptions;

#[path = "../../crates/magician-link/tests/hostile/host/mod.rs"]
mod host;

fuzz_target!(|script: &[u8]| {
    let mut options = LinkOptions::default();
    (options.dangerous, options.laser) = (true, true);
    let mut harness = host::Harness::new(options);
    harness.run_script(&String::from_utf8_lossy(script));
    harness.end();
});
