#![no_main]
//! HPGL: no panic, and accepted steps of finite numbers with their origin.

use libfuzzer_sys::fuzz_target;
use magician_formats::{Content, Format, ReadOptions, read};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(reading) = read(Format::Hpgl, bytes, &ReadOptions::default()) {
        let Content::Artwork(artwork) = reading.content else {
            panic!("a plot is artwork");
        };
        for stroke in &artwork.strokes {
            assert!(stroke.origin.is_known() && !stroke.points.is_empty());
            assert!(stroke.points.iter().flatten().all(|number| number.is_finite()));
        }
    }
});
