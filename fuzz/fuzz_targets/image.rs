#![no_main]
//! Image file of arbitrary bytes: refused, or engraved in every tone and traced.

use libfuzzer_sys::fuzz_target;
use magician_program::raster::{Engrave, Grid, Size, Tone, Trace};
use magician_program::{Action, Content, Format, Raster, ReadOptions, Surface, read};

/// Width of the engraving, mm; small, so that each input takes little time.
const WIDTH: f64 = 12.0;

fn engrave(image: &Raster, tone: Tone) {
    let Ok(size) = image.size(Size::Width(WIDTH)) else {
        return;
    };
    let mut engrave = Engrave::default();
    engrave.tone = tone;
    let grid = Grid::centred(size, [250.0, 0.0], 30.0, true);
    let Ok(plan) = engrave.plan(image, &grid, Surface::level(-60.0)) else {
        return;
    };
    for step in &plan.steps {
        assert!(step.origin.line as usize <= image.height);
        if let Action::Burn { to, power } = step.action {
            assert!(to.iter().all(|value| value.is_finite()) && (0.0..=100.0).contains(&power));
        }
    }
    let dark = plan.steps.iter().rev().nth(1).expect("it ends dark, and up");
    assert_eq!(dark.action, Action::Laser(false));
}

fuzz_target!(|data: &[u8]| {
    let Ok(reading) = read(Format::Image, data, &ReadOptions::default()) else {
        return;
    };
    let Content::Image(image) = reading.content else {
        panic!("an image is an image");
    };
    assert_eq!(image.grey.len(), image.width * image.height);
    for tone in [Tone::Grey, Tone::Threshold(100), Tone::Dither] {
        engrave(&image, tone);
    }
    if let Ok(traced) = Trace::default().lines(&image) {
        let artwork = traced.artwork;
        assert!(artwork.strokes.iter().all(|stroke| stroke.is_closed()));
    }
});
