#![no_main]
//! DXF file of arbitrary bytes: refused with a place in the file, or lines of finite points, each
//! with its origin.

use libfuzzer_sys::fuzz_target;
use magician_formats::{Content, Format, ReadOptions, read};

fuzz_target!(|data: &[u8]| {
    let lines = String::from_utf8_lossy(data).lines().count();
    match read(Format::Dxf, data, &ReadOptions::default()) {
        Ok(reading) => {
            let Content::Artwork(artwork) = reading.content else {
                panic!("a drawing is artwork");
            };
            for stroke in &artwork.strokes {
                assert!(!stroke.points.is_empty());
                assert!(stroke.points.as_flattened().iter().all(|value| value.is_finite()));
                assert!(stroke.origin.line as usize <= lines);
                let name = stroke.origin.name_index().expect("it is on a layer");
                assert!(name < artwork.names.len());
            }
            assert!(reading.notes.iter().all(|note| note.origin.line as usize <= lines));
        }
        Err(problem) => {
            assert!(!problem.message.is_empty() && !problem.message.contains('\n'));
            assert!(problem.origin.line as usize <= lines);
        }
    }
});
