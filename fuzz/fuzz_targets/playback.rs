#![no_main]
//! Playback file of arbitrary bytes: refused with a place in the file, or written back unchanged
//! and converted to a plan, whose own playback file can be read.

use libfuzzer_sys::fuzz_target;
use magician_formats::formats::playback::Playback;

fuzz_target!(|data: &[u8]| {
    let Ok(playback) = Playback::read(data) else {
        return;
    };
    let again = Playback::read(playback.to_xml().as_bytes()).expect("what we have written");
    assert_eq!(again, playback);
    let plan = playback.to_plan().content;
    assert!(plan.steps.len() >= playback.rows.len());
    if let Ok(made) = Playback::from_plan(&plan) {
        let read = Playback::read(made.to_xml().as_bytes()).expect("what we have made");
        assert_eq!(read, made);
    }
});
