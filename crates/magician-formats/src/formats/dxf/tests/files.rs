//! Tests of whole files: the sample plate in text and binary form, refusals, and damaged files.

use std::f64::consts::{PI, TAU};

use proptest::prelude::*;

use super::*;

/// True if the stroke is as long as the curve, less the shortening by chords within the tolerance.
fn has_length(stroke: &Stroke, length: f64) -> bool {
    stroke.length() <= length + 1e-9 && stroke.length() > length * 0.999
}

#[test]
fn plate_sample_has_its_known_geometry() {
    let (artwork, notes) = drawn(PLATE.as_bytes());
    assert_eq!(artwork.bounds(), Some([[0.0, 0.0], [80.0, 50.0]]));
    assert_eq!(artwork.page, None);
    let lengths = [
        2.0 * (70.0 + 40.0) + TAU * 5.0,
        TAU * 4.0,
        TAU * 4.0,
        TAU * 12.0 / 3.0,
        20.0,
        PI * 5.0,
        4.0,
        4.0,
        2.0,
        2.0,
        0.0,
    ];
    // The lines of its lettering follow.
    assert!(artwork.strokes.len() > lengths.len());
    for (stroke, length) in artwork.strokes.iter().zip(lengths) {
        assert!(
            length == 0.0 || has_length(stroke, length),
            "{length} {stroke:?}"
        );
        let line = PLATE.lines().nth(stroke.origin.line as usize - 1).unwrap();
        assert_eq!(line.len() as u32, stroke.origin.length, "{line}");
    }
    let [outline, hole, _, arc, _, spline, across, up, ..] = artwork.strokes.as_slice() else {
        panic!("{artwork:?}")
    };
    assert!(outline.is_closed() && hole.is_closed() && !arc.is_closed());
    let name = outline.origin.name_index().unwrap();
    assert_eq!(artwork.names[name], "outline");
    let off = |points: &[[f64; 2]], [x, y]: [f64; 2], radius: f64| {
        let off = points
            .iter()
            .map(|at| (libm::hypot(at[0] - x, at[1] - y) - radius).abs());
        off.fold(0.0, f64::max)
    };
    assert!(off(&hole.points, [15.0, 25.0], 4.0) < 1e-9);
    assert!(off(&arc.points, [40.0, 25.0], 12.0) < 1e-9);
    assert!(off(&spline.points, [40.0, 15.0], 10.0) < 1e-9);
    assert!(near(across.points[0], [6.0, 8.0]) && near(up.points[1], [8.0, 10.0]));
    let notes: Vec<_> = notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        ["line 310, column 1: CIRCLE is left out: its layer is off or not plotted",]
    );
}

#[test]
fn non_dxf_error_has_an_origin() {
    let refusal = |text: &str| {
        let diagnostic = read(Format::Dxf, text.as_bytes(), &options()).unwrap_err();
        diagnostic.to_string()
    };
    assert_eq!(refusal(""), "the file is empty");
    assert_eq!(
        refusal("AC1027"),
        "this is a DWG drawing of AutoCAD, which is not read"
    );
    assert_eq!(
        refusal("0\nSECTION\n two\nENTITIES\n"),
        "line 3, column 2: expected a group code, found \"two\""
    );
    assert_eq!(
        refusal("0\nSECTION\n2\n"),
        "line 3, column 1: the file ends after a group code"
    );
    let entities = |words: &str| refusal(&file(&format!("0 SECTION 2 ENTITIES {words} 0 ENDSEC")));
    assert_eq!(
        entities("0 LINE 10 abc"),
        "line 8, column 1: expected a number, found \"abc\""
    );
    assert_eq!(
        entities("0 LINE 10 1 20 NaN 11 1"),
        "line 10, column 1: expected a number, found \"NaN\""
    );
    assert_eq!(
        entities("0 CIRCLE 10 1 20 1"),
        "line 6, column 1: CIRCLE has no value for group code 40"
    );
    assert!(
        entities("0 LINE 10 1 20 1 11 1e308 21 1e308 0 LWPOLYLINE 10 0 20 0 42 1e200 10 1 20 1")
            .contains("finite")
    );
    let unit = file("0 SECTION 2 HEADER 9 $INSUNITS 70 19 0 ENDSEC");
    assert!(refusal(&unit).starts_with("line 8, column 1: 19 is not a usable unit"));

    let (artwork, notes) = drawn(b"0\nSECTION\n2\nENTITIES\n0\nPOINT\n10\n1\n20\n2\n");
    assert_eq!(artwork.strokes[0].points, [[1.0, 2.0]]);
    assert!(notes[0].message.contains("mm is used"));
    assert!(notes[1].message.contains("cut short"));
}

/// The plate in binary form, with codes of one or two bytes.
fn binary(wide: bool) -> Vec<u8> {
    let mut bytes = b"AutoCAD Binary DXF\r\n\x1A\0".to_vec();
    let lines: Vec<&str> = PLATE.lines().map(str::trim).collect();
    for pair in lines.chunks_exact(2) {
        let code: i16 = pair[0].parse().unwrap();
        if wide {
            bytes.extend(code.to_le_bytes());
        } else {
            bytes.push(u8::try_from(code).unwrap());
        }
        match code {
            10..=59 => bytes.extend(pair[1].parse::<f64>().unwrap().to_le_bytes()),
            60..=79 => bytes.extend(pair[1].parse::<i16>().unwrap().to_le_bytes()),
            90..=99 => bytes.extend(pair[1].parse::<i32>().unwrap().to_le_bytes()),
            _ => bytes.extend(pair[1].bytes().chain([0])),
        }
    }
    bytes
}

#[test]
fn binary_file_draws_the_same_strokes_without_line_numbers() {
    let (text, _) = drawn(PLATE.as_bytes());
    for wide in [false, true] {
        let (artwork, notes) = drawn(&binary(wide));
        assert!(
            artwork
                .strokes
                .iter()
                .zip(&text.strokes)
                .all(|(one, other)| one.points == other.points)
        );
        assert_eq!(artwork.strokes.len(), text.strokes.len());
        let origins = artwork.strokes.iter().map(|stroke| stroke.origin);
        assert!(
            origins
                .chain(notes.iter().map(|note| note.origin))
                .all(|origin| !origin.is_known())
        );
        let cut = read(Format::Dxf, &binary(wide)[..100], &options()).unwrap_err();
        assert!(cut.message.contains("cut short"), "{cut}");
    }
}

proptest! {
    #[test]
    fn damaged_drawings_are_refused_or_drawn(
        which in 0..3_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
        moved in (any::<prop::sample::Index>(), any::<prop::sample::Index>()),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut lines: Vec<&str> = PLATE.lines().collect();
        let (from, to) = (moved.0.index(lines.len()), moved.1.index(lines.len()));
        lines.swap(from, to);
        let mut bytes = match which {
            0 => binary(true),
            1 => binary(false),
            _ => lines.join("\n").into_bytes(),
        };
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = if which == 2 { b"0123456789.-e\n AZ"[usize::from(value) % 17] } else { value };
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok(reading) = read(Format::Dxf, &bytes, &options()) {
            let Content::Artwork(artwork) = reading.content else {
                panic!("no artwork");
            };
            for stroke in &artwork.strokes {
                prop_assert!(!stroke.points.is_empty());
                prop_assert!(stroke.points.as_flattened().iter().all(|value| value.is_finite()));
            }
        }
    }

    #[test]
    fn any_bytes_are_refused_or_drawn(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = read(Format::Dxf, &bytes, &options());
    }
}
