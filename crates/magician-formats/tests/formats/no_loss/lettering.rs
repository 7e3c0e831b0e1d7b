//! Texts as single-line lettering, whatever font they name.

use magician_formats::{ReadOptions, TextLines};

use super::{artwork, length, near, note_text};

fn in_single_lines() -> ReadOptions {
    let mut options = ReadOptions::default();
    options.text_lines = TextLines::Stroke;
    options
}

#[test]
fn text_in_a_font_of_the_file_is_written_in_single_lines() {
    let (artwork, notes) = artwork("embedded-font.svg", &in_single_lines());
    // The frame is 164 mm long; an H is 10 mm high and as wide as in the file's font.
    near(length(&artwork), 164.0 + 35.0, 5.0);
    assert_eq!(note_text(&notes), "");
    // The three strokes of the H.
    let letter = artwork.strokes.iter().skip(1).take(3);
    let heights = letter.flat_map(|stroke| &stroke.points).map(|at| at[1]);
    let (least, most) = heights.fold((f64::MAX, f64::MIN), |(least, most), y| {
        (least.min(y), most.max(y))
    });
    // The capital height is 70 of 100 units, and the size 14 mm.
    near(most - least, 9.8, 0.1);
}

#[test]
fn text_in_a_font_without_capital_height_is_written_in_single_lines() {
    // The font is DejaVu where it is installed, and the bundled font otherwise: both have this
    // height.
    let (artwork, _) = artwork("installed-font.svg", &in_single_lines());
    near(length(&artwork), 164.0 + 87.0, 4.0);
}
