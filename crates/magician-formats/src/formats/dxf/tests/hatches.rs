//! Tests of hatches, solid shapes and clip boundaries.

use proptest::prelude::*;

use super::*;
use crate::Fills;

const SQUARE: &str = "91 1 92 3 72 0 73 1 93 4 10 0 20 0 10 10 20 0 10 10 20 10 10 0 20 10 97 0";

fn filled(words: &str) -> Artwork {
    let head = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC";
    let file = file(&format!("{head} {words} 0 ENDSEC"));
    let options = ReadOptions {
        fills: Fills::Areas,
        ..options()
    };
    match read(Format::Dxf, file.as_bytes(), &options)
        .unwrap()
        .content
    {
        Content::Artwork(artwork) => artwork,
        other => panic!("{other:?}"),
    }
}

#[test]
fn solid_hatches_are_areas_or_outlines_without_fill() {
    let words = format!("0 HATCH 10 0 20 0 30 0 2 SOLID 70 1 {SQUARE} 75 1 76 1");
    let (strokes, notes) = entities(&words);
    assert_eq!((strokes.len(), notes.len()), (1, 0));
    assert!(strokes[0].is_closed() && strokes[0].length() == 40.0);
    let artwork = filled(&format!("0 SECTION 2 ENTITIES {words}"));
    assert!(artwork.strokes.is_empty());
    assert_eq!(
        artwork.areas[0].area.rings,
        [vec![
            [0.0, 0.0],
            [10.0, 0.0],
            [10.0, 10.0],
            [0.0, 10.0],
            [0.0, 0.0]
        ]]
    );
    let artwork = filled("0 SECTION 2 ENTITIES 0 SOLID 10 0 20 0 11 9 21 0 12 0 22 9 13 9 23 9");
    assert_eq!(artwork.areas[0].area.rings[0][2], [9.0, 9.0]);
    // A merely closed shape is not an area: the file does not say that it is filled.
    let artwork = filled("0 SECTION 2 ENTITIES 0 LWPOLYLINE 70 1 10 0 20 0 10 9 20 0 10 9 20 9");
    assert!(artwork.areas.is_empty() && artwork.strokes.len() == 1);
}

#[test]
fn other_hatches_have_the_lines_of_their_pattern() {
    let hatch = |lines: &str| {
        format!("0 HATCH 10 0 20 0 30 0 2 ANSI31 70 0 {SQUARE} 75 1 76 1 52 0 41 1 77 0 {lines}")
    };
    let (strokes, notes) = entities(&hatch("78 1 53 0 43 0 44 1 45 0 46 4 79 0"));
    let lines: Vec<_> = strokes.iter().map(|stroke| stroke.points.clone()).collect();
    assert_eq!(notes, [""; 0]);
    assert_eq!(
        lines,
        [
            [[0.0, 1.0], [10.0, 1.0]],
            [[0.0, 5.0], [10.0, 5.0]],
            [[0.0, 9.0], [10.0, 9.0]]
        ]
    );
    let (strokes, notes) = entities(&hatch("78 1 53 0 43 0 44 1 45 0 46 0 79 0"));
    assert!(
        strokes.is_empty() && notes[0].contains("too many lines"),
        "{notes:?}"
    );
}

#[test]
fn boundaries_are_followed_along_their_edges() {
    // A half disc of an arc and a reversed line, with an elliptic hole.
    let words = "0 HATCH 10 0 20 0 30 0 70 1 91 2 \
        92 1 93 2 72 2 10 0 20 0 40 10 50 0 51 180 73 1 72 1 10 10 20 0 11 -10 21 0 97 0 \
        92 0 93 1 72 3 10 0 20 5 11 2 21 0 40 0.5 50 0 51 360 73 1 97 0 75 0 76 1";
    let (strokes, notes) = entities(words);
    assert_eq!(notes, [""; 0]);
    let arc = std::f64::consts::PI * 10.0 + 20.0;
    assert!(
        (strokes[0].length() - arc).abs() < 0.02,
        "{}",
        strokes[0].length()
    );
    assert!(strokes[1].is_closed());
    // A clockwise quarter.
    let words = "0 HATCH 10 0 20 0 30 0 70 1 91 1 \
        92 1 93 3 72 2 10 0 20 0 40 10 50 0 51 90 73 0 72 1 10 0 20 -10 11 0 21 0 72 1 10 0 20 0 11 10 21 0 97 0";
    let (strokes, _) = entities(words);
    let low = strokes[0]
        .points
        .iter()
        .map(|[_, y]| *y)
        .fold(0.0, f64::min);
    assert!((low + 10.0).abs() < 1e-9, "{low}");
}

#[test]
fn insert_is_clipped_at_its_boundary() {
    let words = |second: &str, on: u8| {
        file(&format!(
            "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 BLOCKS 0 BLOCK 2 B \
             0 LINE 10 -50 20 5 11 50 21 5 0 HATCH 10 0 20 0 30 0 70 1 {SQUARE} 0 ENDBLK 0 ENDSEC \
             0 SECTION 2 ENTITIES 0 INSERT 2 B 102 {{ACAD_XDICTIONARY 360 A1 102 }} 10 100 20 0 \
             0 LINE 10 0 20 90 11 9 21 90 0 ENDSEC 0 SECTION 2 OBJECTS \
             0 DICTIONARY 5 A1 3 ACAD_FILTER 360 A2 0 DICTIONARY 5 A2 3 SPATIAL 360 A3 \
             0 SPATIAL_FILTER 5 A3 70 2 10 102 20 0 {second} 210 0 220 0 230 1 11 0 21 0 31 0 71 {on} 72 0 73 0 \
             40 1 40 0 40 0 40 -100 40 0 40 1 40 0 40 0 40 0 40 0 40 1 40 0 \
             40 1 40 0 40 0 40 0 40 0 40 1 40 0 40 0 40 0 40 0 40 1 40 0 0 ENDSEC"
        ))
    };
    let (artwork, notes) = drawn(words("10 108 20 8", 1).as_bytes());
    assert!(notes.is_empty(), "{notes:?}");
    let lines: Vec<_> = artwork
        .strokes
        .iter()
        .map(|stroke| stroke.points.clone())
        .collect();
    assert!(
        lines.contains(&vec![[102.0, 5.0], [108.0, 5.0]]),
        "{lines:?}"
    );
    assert!(lines.contains(&vec![[0.0, 90.0], [9.0, 90.0]]), "{lines:?}");
    let (artwork, _) = drawn(words("10 108 20 8", 0).as_bytes());
    let ends = artwork
        .strokes
        .iter()
        .any(|stroke| stroke.points.contains(&[150.0, 5.0]));
    assert!(ends, "{artwork:?}");
}

proptest! {
    #[test]
    fn no_hatch_panics(codes in proptest::collection::vec((0..100_i32, -3.0..9.0_f64), 0..60)) {
        let pairs = codes.iter().fold(String::new(), |mut text, (code, value)| {
            writeln!(text, "{code}\n{value}").unwrap();
            text
        });
        for kind in ["HATCH", "LEADER", "MULTILEADER", "SOLID", "3DFACE"] {
            let file = format!("0\nSECTION\n2\nENTITIES\n0\n{kind}\n{pairs}0\nENDSEC\n0\nEOF\n");
            let _ = read(Format::Dxf, file.as_bytes(), &options());
        }
    }
}
