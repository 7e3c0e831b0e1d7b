//! Tests of fonts defined in the drawing.

use crate::{Artwork, Content, DiagnosticCode, Format, Parsed, ReadOptions, TextLines, read};

/// Three letters with an em of 100: an open line (20 wide), a closed square and a space (50 wide).
const EMBEDDED_FONT: &str = r#"<defs><font id="f" horiz-adv-x="50"><font-face font-family="Ours" units-per-em="100" ascent="80" descent="-20"/>
<glyph unicode="l" horiz-adv-x="20" d="M10 0V70"/><glyph unicode="o" d="M10 0H40V30H10Z"/><glyph unicode=" "/></font></defs>"#;

fn svg(text: &str) -> String {
    // One unit is one millimetre.
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="100mm" viewBox="0 0 200 100">{EMBEDDED_FONT}{text}</svg>"#
    )
}

fn parsed(text: &str, options: &ReadOptions) -> (Artwork, Parsed) {
    let parsed = read(Format::Svg, svg(text).as_bytes(), options).unwrap();
    let Content::Artwork(artwork) = parsed.content.clone() else {
        panic!("no drawing");
    };
    (artwork, parsed)
}

/// Bounding box of each line, from the lower left corner of the page.
fn lines(text: &str) -> Vec<[f64; 4]> {
    let (artwork, _) = parsed(text, &ReadOptions::default());
    let bounds = artwork.strokes.iter().map(|stroke| {
        let none = [
            f64::INFINITY,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NEG_INFINITY,
        ];
        stroke.points.iter().fold(none, |[a, b, c, d], [x, y]| {
            [a.min(*x), b.min(*y), c.max(*x), d.max(*y)]
        })
    });
    bounds.collect()
}

fn near(found: &[[f64; 4]], wanted: &[[f64; 4]]) {
    let alike = |(a, b): (&[f64; 4], &[f64; 4])| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.01);
    let all = found.len() == wanted.len() && found.iter().zip(wanted).all(alike);
    assert!(all, "{found:?}");
}

#[test]
fn text_uses_the_glyphs_of_the_file() {
    let text = r#"<text x="10" y="90" font-size="20" font-family="Ours">lo l</text>"#;
    near(
        &lines(text),
        &[
            [12.0, 10.0, 12.0, 24.0],
            [16.0, 10.0, 22.0, 16.0],
            [36.0, 10.0, 36.0, 24.0],
        ],
    );
    // Single lines are drawn once, regardless of the option for fills.
    let (artwork, parsed) = parsed(text, &ReadOptions::default());
    assert_eq!(artwork.strokes[0].points.len(), 2);
    assert!(parsed.notes.is_empty(), "{:?}", parsed.notes);
}

#[test]
fn anchors_spans_and_rotated_texts_are_applied() {
    // 20 + 50 + 20 hundredths of 20 mm are 18 mm.
    let middle = r#"<text x="100" y="90" font-size="20" text-anchor="middle" style="font-family:'Ours',sans-serif">l<tspan font-size="20">o</tspan>l</text>"#;
    near(
        &lines(middle),
        &[
            [93.0, 10.0, 93.0, 24.0],
            [97.0, 10.0, 103.0, 16.0],
            [107.0, 10.0, 107.0, 24.0],
        ],
    );
    let turned = r#"<text transform="translate(50 50) rotate(90)" font-size="20" font-family="Ours">l</text>"#;
    near(&lines(turned), &[[50.0, 48.0, 64.0, 48.0]]);
}

#[test]
fn missing_glyphs_are_written_in_single_lines() {
    let text = r#"<text x="10" y="90" font-size="20" font-family="Ours">lXo</text>"#;
    let (artwork, parsed) = parsed(text, &ReadOptions::default());
    // The strokes of the X are as high as a capital of the font, and the next letter follows it.
    let found = lines(text);
    assert_eq!(found.len(), 4, "{found:?}");
    assert_eq!(artwork.strokes[0].points.len(), 2);
    assert!(found[1][3] < 24.1 && found[1][3] > 20.0, "{found:?}");
    assert!(found[3][0] > found[2][2], "{found:?}");
    let [note] = parsed.notes.as_slice() else {
        panic!("{:?}", parsed.notes);
    };
    assert!(note.message.contains("written in sans") && note.message.contains("'X'"));
    // A character that no font has.
    let text = "<text x='10' y='90' font-family='Ours'>l\u{E123}</text>";
    let (artwork, parsed) = self::parsed(text, &ReadOptions::default());
    assert_eq!(artwork.strokes.len(), 1);
    assert!(
        parsed.notes[0].message.contains("U+E123"),
        "{:?}",
        parsed.notes
    );
}

#[test]
fn weights_and_styles_of_a_family_are_distinguished() {
    let bold = r#"<font horiz-adv-x="50"><font-face font-family="Ours" font-weight="bold" units-per-em="100"/><glyph unicode="l" d="M20 0V70"/></font>"#;
    let text = |weight: &str| {
        format!(
            r#"{bold}<text x="10" y="90" font-size="20" font-family="Ours" font-weight="{weight}">l</text>"#
        )
    };
    near(&lines(&text("normal")), &[[12.0, 10.0, 12.0, 24.0]]);
    near(&lines(&text("bold")), &[[14.0, 10.0, 14.0, 24.0]]);
}

#[test]
fn closed_letters_are_filled_and_single_lines_are_not() {
    let options = ReadOptions {
        fills: crate::Fills::Areas,
        ..ReadOptions::default()
    };
    let text = r#"<text x="10" y="90" font-size="20" font-family="Ours">lo</text>"#;
    let (artwork, _) = parsed(text, &options);
    assert_eq!((artwork.strokes.len(), artwork.areas.len()), (1, 1));
}

#[test]
fn single_line_font_of_the_file_is_kept_if_all_text_is_single_line() {
    let options = ReadOptions {
        text_lines: TextLines::Stroke,
        ..ReadOptions::default()
    };
    let text = r#"<text x="10" y="90" font-size="20" font-family="Ours">l</text>"#;
    let (artwork, _) = parsed(text, &options);
    assert_eq!(artwork.strokes.len(), 1);
    assert!((artwork.strokes[0].points[0][0] - 12.0).abs() < 0.01);
}

#[test]
fn unreadable_font_is_noted_and_another_font_is_used() {
    let broken = r#"<font><font-face font-family="Broken"/><glyph unicode="l" d="M0 0 L"/></font>
<font><font-face font-family="Empty"/></font><font><font-face/></font>"#;
    let text =
        format!(r#"{broken}<text x="10" y="90" font-size="20" font-family="Broken">l</text>"#);
    let (artwork, parsed) = parsed(&text, &ReadOptions::default());
    assert!(!artwork.strokes.is_empty());
    let notes: Vec<String> = parsed.notes.iter().map(ToString::to_string).collect();
    let told = |what: &str| notes.iter().any(|note| note.contains(what));
    assert!(told("the font Broken is not used"), "{notes:?}");
    assert!(told("the font Empty is not used: the font has no glyph"));
    assert_eq!(parsed.notes[0].code, DiagnosticCode::LeftOut);
    assert!(parsed.notes[0].origin.line > 0);
}
