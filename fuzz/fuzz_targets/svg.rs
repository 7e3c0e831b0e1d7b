#![no_main]
//! SVG: no panic, accepted steps of finite numbers with their origin, and nothing lost when lines
//! are reordered.

use libfuzzer_sys::fuzz_target;
use magician_formats::artwork::Order;
use magician_formats::{Content, Format, ReadOptions, read};

fuzz_target!(|bytes: &[u8]| {
    let Ok(reading) = read(Format::Svg, bytes, &ReadOptions::default()) else {
        return;
    };
    let Content::Artwork(mut artwork) = reading.content else {
        panic!("a drawing is artwork");
    };
    for stroke in &artwork.strokes {
        assert!(!stroke.points.is_empty());
        assert!(
            stroke
                .points
                .iter()
                .flatten()
                .all(|number| number.is_finite())
        );
        assert!(
            stroke
                .origin
                .name_index()
                .is_some_and(|name| name < artwork.names.len())
        );
    }
    let length = artwork.length();
    let order = Order {
        joining: -1.0,
        effort: 1_000_000,
        ..Order::default()
    };
    let saving = artwork.put_in_order(&order);
    assert!(saving.after_mm <= saving.before_mm);
    assert!((artwork.length() - length).abs() <= 1e-6 * (1.0 + length));
});
