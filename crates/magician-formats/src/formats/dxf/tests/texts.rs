//! Tests of texts, dimensions and leaders.

use proptest::prelude::*;

use super::*;

/// Bounding box of a drawing that causes no notes.
fn extent(words: &str) -> [f64; 4] {
    let (strokes, notes) = entities(words);
    assert_eq!(notes, [""; 0], "{words}");
    let artwork = Artwork {
        strokes,
        ..Artwork::default()
    };
    let [least, most] = artwork.bounds().expect(words);
    [least[0], least[1], most[0], most[1]]
}

fn about(found: [f64; 4], expected: [f64; 4], words: &str) {
    let off = |(one, other): (&f64, &f64)| (one - other).abs();
    let most = found.iter().zip(&expected).map(off).fold(0.0, f64::max);
    assert!(most < 1e-6, "{words}: {found:?} instead of {expected:?}");
}

#[test]
fn a_text_stands_where_its_alignment_says() {
    // In the font an H is 14 wide of 22, and 21 high. At height 15 that is 10 wide, with 3 on both
    // sides.
    let wide = 22.0 * 15.0 / 21.0;
    let (side, bar) = (4.0 * 15.0 / 21.0, 14.0 * 15.0 / 21.0);
    let text = "0 TEXT 1 H 40 15 10 5 20 7";
    about(
        extent(text),
        [5.0 + side, 7.0, 5.0 + side + bar, 22.0],
        "left",
    );
    for (codes, left, low) in [
        ("72 1 11 50 21 60", 50.0 - wide / 2.0, 60.0),
        ("72 2 11 50 21 60", 50.0 - wide, 60.0),
        ("72 4 11 50 21 60", 50.0 - wide / 2.0, 52.5),
        ("72 0 73 3 11 50 21 60", 50.0, 45.0),
        ("72 0 73 2 11 50 21 60", 50.0, 52.5),
        ("72 0 73 1 11 50 21 60", 50.0, 65.0),
    ] {
        let words = format!("{text} {codes}");
        let expected = [left + side, low, left + side + bar, low + 15.0];
        about(extent(&words), expected, &words);
    }
    // Stretched, rotated, upside down.
    let expected = [5.0 + 2.0 * side, 7.0, 5.0 + 2.0 * (side + bar), 22.0];
    about(extent(&format!("{text} 41 2")), expected, "wide");
    about(
        extent(&format!("{text} 50 90")),
        [5.0 - 15.0, 7.0 + side, 5.0, 7.0 + side + bar],
        "turned",
    );
    about(
        extent(&format!("{text} 71 4")),
        [5.0 + side, 7.0 - 15.0, 5.0 + side + bar, 7.0],
        "upside down",
    );
    // A fitted text keeps its height, an aligned one its proportions.
    let [.., high] = extent("0 TEXT 1 HHH 40 15 10 0 20 0 11 30 21 0 72 5");
    assert!((high - 15.0).abs() < 1e-9);
    let [left, _, right, high] = extent("0 TEXT 1 HHH 40 15 10 0 20 0 11 30 21 0 72 3");
    assert!((high - 30.0 / (3.0 * wide) * 15.0).abs() < 1e-9 && left > 0.0 && right < 30.0);
}

#[test]
fn text_codes_become_their_characters() {
    let same = |one: &str, other: &str| {
        let [one, other] = [one, other].map(|text| {
            let words = format!("0 TEXT 1 {text} 40 5 10 0 20 0");
            entities(&words)
                .0
                .into_iter()
                .map(|stroke| stroke.points)
                .collect::<Vec<_>>()
        });
        assert!(!one.is_empty());
        assert_eq!(one, other);
    };
    same("%%c12%%d%%p1", "Ø12°±1");
    same("%%uA%%u%%%%%065\\U+00C4", "A%AÄ");
    same("∅5", "Ø5");
    let (strokes, notes) = entities("0 TEXT 1 中 40 5 10 0 20 0");
    assert!(strokes.is_empty());
    assert!(notes[0].contains("U+4E2D '中' is left out"), "{notes:?}");
}

#[test]
fn texts_of_old_files_are_in_their_code_page() {
    let words = file("0 SECTION 2 ENTITIES 0 TEXT 1 @ 40 5 10 0 20 0 0 ENDSEC");
    let [latin, utf] = [b"\xC4".to_vec(), "Ä".as_bytes().to_vec()].map(|sign| {
        let parts: Vec<_> = words.as_bytes().split(|byte| *byte == b'@').collect();
        drawn(&parts.join(&sign[..])).0.strokes
    });
    assert_eq!(latin, utf);
}

#[test]
fn lines_of_an_mtext_hang_at_its_attachment_point() {
    let words = |more: &str| format!("0 MTEXT 40 3 10 0 20 0 1 H\\PH {more}");
    let [_, low, _, high] = extent(&words("71 1"));
    assert!((high, low) == (0.0, -3.0 - 5.0), "{low} {high}");
    let [_, low, _, high] = extent(&words("71 7"));
    assert!((low - 1.0).abs() < 1e-9 && (high - 9.0).abs() < 1e-9);
    let [_, low, _, high] = extent(&words("71 5"));
    assert!((low + high).abs() < 1e-9, "{low} {high}");
    let [left, _, right, _] = extent(&words("71 2"));
    assert!((left + right).abs() < 1e-9);
    // Direction and angle: whichever comes last counts.
    let [left, _, right, _] = extent(&words("71 1 50 0 11 0 21 1"));
    assert!((left.abs(), right) == (0.0, 8.0), "{left} {right}");
    let [left, low, ..] = extent(&words("71 1 11 0 21 1 50 0"));
    assert!(left > 0.0 && low < 0.0);
    // Wrapped between words.
    let broken = extent("0 MTEXT 40 3 10 0 20 0 71 1 41 9 1 HHH\\~H\\~~HHH");
    let forced = extent("0 MTEXT 40 3 10 0 20 0 71 1 41 5 1 H");
    assert!(broken[3] == 0.0 && forced[1] == -3.0);
}

#[test]
fn mtext_codes_are_applied_and_not_drawn() {
    let plain = |text: &str| {
        let rows = super::super::mtext::parsed(text, 2.0);
        let rows = rows.iter().map(|row| {
            let runs = row
                .iter()
                .map(|run| (run.text.as_str().to_owned(), run.size));
            runs.collect::<Vec<_>>()
        });
        rows.collect::<Vec<_>>()
    };
    let run = |text: &str, size: f64| (text.to_owned(), size);
    assert_eq!(
        plain("{\\fArial|b0|i0|c0|p34;\\C1;a{\\H1.5x;b}c}\\Pd\\\\\\{"),
        [
            vec![run("a", 1.0), run("b", 1.5), run("c", 1.0)],
            vec![run("d\\{", 1.0)]
        ]
    );
    assert_eq!(plain("\\A1;\\H4;x\\pxqc;y"), [[run("xy", 2.0)]]);
    assert_eq!(plain("1\\S1#2;"), [[run("11/2", 1.0)]]);
    assert_eq!(plain("\\S+1^-22;"), [[run("+1", 0.7), run("-22", 0.7)]]);
    assert_eq!(plain("a^Jb"), [[run("a", 1.0)], [run("b", 1.0)]]);
}

#[test]
fn insert_attributes_are_drawn_but_their_definitions_are_not() {
    let head = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 BLOCKS \
        0 BLOCK 2 B 0 ATTDEF 2 TAG 1 x 40 5 10 0 20 0 70 0 0 ENDBLK 0 ENDSEC 0 SECTION 2 ENTITIES";
    let count = |words: &str| {
        let (artwork, notes) = drawn(file(&format!("{head} {words} 0 ENDSEC")).as_bytes());
        assert!(notes.is_empty(), "{notes:?}");
        artwork.strokes.len()
    };
    assert_eq!(count("0 INSERT 2 B 10 0 20 0"), 0);
    let attribute = "0 INSERT 2 B 66 1 10 0 20 0 0 ATTRIB 2 TAG 1 V 40 5 10 0 20 0";
    assert!(count(&format!("{attribute} 70 0 0 SEQEND")) > 0);
    assert_eq!(count(&format!("{attribute} 70 1 0 SEQEND")), 0);
    assert!(count("0 ATTDEF 2 TAG 1 x 40 5 10 0 20 0") > 0);
}

#[test]
fn dimensions_are_drawn_as_their_block_shows_them() {
    let words = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 BLOCKS \
        0 BLOCK 2 *D1 0 LINE 10 1 20 2 11 5 21 2 0 POINT 8 Defpoints 10 0 20 0 0 ENDBLK 0 ENDSEC \
        0 SECTION 2 ENTITIES 0 DIMENSION 2 *D1 10 9 20 9 0 DIMENSION 2 *D9 0 ENDSEC";
    let (artwork, notes) = drawn(file(words).as_bytes());
    let lines: Vec<_> = artwork
        .strokes
        .into_iter()
        .map(|stroke| stroke.points)
        .collect();
    assert_eq!(lines, [[[1.0, 2.0], [5.0, 2.0]]]);
    let notes: Vec<_> = notes.into_iter().map(|note| note.message).collect();
    assert_eq!(
        notes,
        [
            "POINT is left out: its layer is off or not plotted",
            "DIMENSION is left out: its block is not in the file"
        ]
    );
}

#[test]
fn leaders_have_an_arrow_at_their_first_point() {
    let (strokes, _) = entities("0 LEADER 71 1 10 0 20 0 10 20 20 0 10 25 20 5");
    let [line, arrow] = &strokes[..] else {
        panic!("{strokes:?}")
    };
    assert_eq!(line.points, [[0.0, 0.0], [20.0, 0.0], [25.0, 5.0]]);
    assert!(arrow.is_closed() && arrow.points[0] == [0.0, 0.0] && arrow.points[1][0] == 2.5);
    assert_eq!(entities("0 LEADER 71 0 10 0 20 0 10 20 20 0").0.len(), 1);

    let words = "0 MULTILEADER 300 CONTEXT_DATA{ 40 1 10 0 20 0 30 0 41 4 140 3 290 1 304 HI 12 30 22 10 32 0 13 1 23 0 \
        302 LEADER{ 10 25 20 8 30 0 11 1 21 0 40 2 304 LEADER_LINE{ 10 0 20 0 30 0 305 } 303 } 301 } 41 9";
    let (strokes, notes) = entities(words);
    assert_eq!(notes, [""; 0]);
    assert_eq!(strokes[0].points, [[0.0, 0.0], [25.0, 8.0], [27.0, 8.0]]);
    // The lines of its letters lie below the attachment point.
    let letters = strokes[2..].iter().flat_map(|stroke| &stroke.points);
    let (low, high) = letters.fold((f64::MAX, f64::MIN), |(low, high), [_, y]| {
        (low.min(*y), high.max(*y))
    });
    assert!(
        (low - 6.0).abs() < 1e-9 && (high - 10.0).abs() < 1e-9,
        "{low} {high}"
    );
}

proptest! {
    #[test]
    fn no_text_panics(content in "(?s).{0,60}", codes in "[\\\\{}HSWTQfUMP0-9x;^/#%+ ]{0,60}") {
        for text in [content, codes] {
            let text: String = text.chars().filter(|sign| !matches!(sign, '\n' | '\r')).collect();
            for kind in ["TEXT", "MTEXT"] {
                let file = format!(
                    "0\nSECTION\n2\nENTITIES\n0\n{kind}\n40\n2\n41\n7\n10\n0\n20\n0\n1\n{text}\n0\nENDSEC\n0\nEOF\n"
                );
                let _ = read(Format::Dxf, file.as_bytes(), &options());
            }
        }
    }
}
