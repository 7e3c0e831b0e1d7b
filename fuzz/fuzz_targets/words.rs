#![no_main]
//! Text and fonts: the first line is the text, the rest a font file. No panic, and accepted steps
//! of finite numbers.

use libfuzzer_sys::fuzz_target;
use magician_formats::{Content, FontChoice, Format, ReadOptions, read};

fuzz_target!(|bytes: &[u8]| {
    let mut parts = bytes.splitn(2, |byte| *byte == b'\n');
    let text = parts.next().unwrap_or_default();
    let mut options = ReadOptions::default();
    options.text.wrap = Some(60.0);
    if let Some(font) = parts.next() {
        options.text.font = FontChoice::file("font", font);
    }
    if let Ok(reading) = read(Format::Text, text, &options) {
        let Content::Artwork(artwork) = reading.content else {
            panic!("text is artwork");
        };
        for stroke in &artwork.strokes {
            assert!(stroke.origin.is_known() && !stroke.points.is_empty());
            assert!(stroke.points.iter().flatten().all(|number| number.is_finite()));
        }
    }
});
