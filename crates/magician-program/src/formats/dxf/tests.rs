use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use proptest::prelude::*;

use super::*;
use crate::{Format, Stroke, read};

const PLATE: &str = include_str!("../../../samples/plate.dxf");
const TOLERANCE: f64 = 0.01;

fn options() -> ReadOptions {
    ReadOptions {
        tolerance: TOLERANCE,
        ..ReadOptions::default()
    }
}

fn drawn(bytes: &[u8]) -> (Artwork, Vec<Problem>) {
    let reading = read(Format::Dxf, bytes, &options()).unwrap();
    match reading.content {
        Content::Artwork(artwork) => (artwork, reading.notes),
        other => panic!("{other:?}"),
    }
}

/// A file of codes and values, each a word.
fn file(words: &str) -> String {
    let mut text = words
        .split_whitespace()
        .fold(String::new(), |mut text, word| {
            writeln!(text, "{word}").unwrap();
            text
        });
    text.push_str("0\nEOF\n");
    text
}

/// The lines of entities in mm, and what is noted.
fn entities(words: &str) -> (Vec<Stroke>, Vec<String>) {
    let head = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES";
    let (artwork, notes) = drawn(file(&format!("{head} {words} 0 ENDSEC")).as_bytes());
    let notes = notes.iter().map(ToString::to_string);
    (artwork.strokes, notes.collect())
}

/// The only line of an entity, drawn without a note.
fn entity(words: &str) -> Vec<[f64; 2]> {
    let (strokes, notes) = entities(words);
    assert_eq!(notes, [""; 0]);
    let [stroke] = strokes.as_slice() else {
        panic!("{strokes:?}")
    };
    stroke.points.clone()
}

fn near(one: [f64; 2], other: [f64; 2]) -> bool {
    (one[0] - other[0]).hypot(one[1] - other[1]) < 1e-9
}

/// Chords of a curve within the tolerance are shorter than it, by so little.
fn is_length(stroke: &Stroke, length: f64) -> bool {
    stroke.length() <= length + 1e-9 && stroke.length() > length * 0.999
}

#[test]
fn the_plate_is_as_it_was_drawn() {
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
    assert_eq!(artwork.strokes.len(), lengths.len());
    for (stroke, length) in artwork.strokes.iter().zip(lengths) {
        assert!(
            length == 0.0 || is_length(stroke, length),
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
            .map(|at| ((at[0] - x).hypot(at[1] - y) - radius).abs());
        off.fold(0.0, f64::max)
    };
    assert!(off(&hole.points, [15.0, 25.0], 4.0) < 1e-9);
    assert!(off(&arc.points, [40.0, 25.0], 12.0) < 1e-9);
    assert!(off(&spline.points, [40.0, 15.0], 10.0) < 1e-9);
    assert!(near(across.points[0], [6.0, 8.0]) && near(up.points[1], [8.0, 10.0]));
    let notes: Vec<_> = notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "line 310, column 1: CIRCLE is left out: its layer is off or not plotted",
            "line 320, column 1: TEXT is left out: text is not drawn",
        ]
    );
}

#[test]
fn chords_are_as_near_to_a_curve_as_the_tolerance() {
    for (words, centre, radius) in [
        ("0 CIRCLE 10 0 20 0 40 100", [0.0, 0.0], 100.0),
        ("0 ARC 10 5 20 5 40 1 50 300 51 60", [5.0, 5.0], 1.0),
        ("0 LWPOLYLINE 10 0 20 0 42 1 10 60 20 0", [30.0, 0.0], 30.0),
        ("0 LWPOLYLINE 10 0 20 0 42 -1 10 60 20 0", [30.0, 0.0], 30.0),
    ] {
        let points = entity(words);
        let sagitta = points.windows(2).map(|pair| {
            let middle = [0, 1].map(|axis| f64::midpoint(pair[0][axis], pair[1][axis]));
            radius - (middle[0] - centre[0]).hypot(middle[1] - centre[1])
        });
        let most = sagitta.fold(0.0, f64::max);
        assert!(most <= TOLERANCE && points.len() > 2, "{words}: {most}");
        assert!(
            most > TOLERANCE / 8.0 || points.len() < 9,
            "{words}: {most}"
        );
    }
    // To the left of the way is counter-clockwise: through below.
    let [least, most] = bounds("0 LWPOLYLINE 10 0 20 0 42 1 10 60 20 0");
    assert!((least[1] + 30.0).abs() < TOLERANCE && most[1].abs() < 1e-9);
    let [least, most] = bounds("0 LWPOLYLINE 10 0 20 0 42 -0.5 10 60 20 0");
    assert!(least[1].abs() < 1e-9 && (most[1] - 15.0).abs() < TOLERANCE);
}

fn bounds(words: &str) -> [[f64; 2]; 2] {
    let strokes = entities(words).0;
    let artwork = Artwork {
        strokes,
        ..Artwork::default()
    };
    artwork.bounds().unwrap()
}

#[test]
fn ellipses_follow_their_axes() {
    let whole = entity("0 ELLIPSE 10 1 20 2 11 3 21 4 40 0.5");
    assert_eq!(whole.first(), whole.last());
    let (cos, sin) = (0.6, 0.8);
    for [x, y] in &whole {
        let (x, y) = (x - 1.0, y - 2.0);
        let along = (x * cos + y * sin) / 5.0;
        let aside = (y * cos - x * sin) / 2.5;
        assert!((along.hypot(aside) - 1.0).abs() < 1e-9);
    }
    let quarter = format!("0 ELLIPSE 10 0 20 0 11 4 21 0 40 0.5 41 0 42 {}", PI / 2.0);
    let points = entity(&quarter);
    assert!(near(points[0], [4.0, 0.0]) && near(points[points.len() - 1], [0.0, 2.0]));
    // Seen from below, the minor axis points the other way.
    let points = entity(&format!("{quarter} 230 -1"));
    assert!(near(points[points.len() - 1], [0.0, -2.0]));
}

#[test]
fn a_plane_seen_from_behind_is_mirrored() {
    let points = entity("0 ARC 10 10 20 0 40 5 50 0 51 90 210 0 220 0 230 -1");
    assert!(near(points[0], [-15.0, 0.0]) && near(points[points.len() - 1], [-10.0, 5.0]));
    let points = entity("0 LWPOLYLINE 10 1 20 2 10 3 20 4 230 -1");
    assert_eq!(points, [[-1.0, 2.0], [-3.0, 4.0]]);
    // A line's points are those of the drawing whatever its thickness does.
    assert_eq!(
        entity("0 LINE 10 1 20 2 11 3 21 4 230 -1"),
        [[1.0, 2.0], [3.0, 4.0]]
    );
    // A circle that stands upright is a line from above, at its height along the normal.
    let points = entity("0 CIRCLE 10 0 20 0 30 7 40 2 210 1 220 0 230 0");
    assert!(
        points
            .iter()
            .all(|[x, y]| (x - 7.0).abs() < 1e-9 && y.abs() < 2.0 + 1e-9)
    );
}

#[test]
fn polylines_of_both_kinds_are_the_same() {
    let light = entity("0 LWPOLYLINE 70 1 10 0 20 0 42 0.3 10 9 20 0 10 9 20 9");
    let heavy = "0 POLYLINE 66 1 70 1 10 0 20 0 30 0 \
        0 VERTEX 10 0 20 0 42 0.3 0 VERTEX 10 9 20 0 0 VERTEX 70 16 10 50 20 50 0 VERTEX 10 9 20 9 0 SEQEND";
    assert_eq!(entity(heavy), light);
    assert_eq!(light.first(), light.last());

    let rising = "0 POLYLINE 70 8 0 VERTEX 10 0 20 0 30 0 42 1 0 VERTEX 10 5 20 0 30 5 0 SEQEND";
    let (strokes, notes) = entities(rising);
    assert_eq!(strokes[0].points, [[0.0, 0.0], [5.0, 0.0]]);
    assert!(notes[0].contains("seen from above"), "{notes:?}");
    let (strokes, notes) = entities("0 POLYLINE 70 64 0 VERTEX 10 0 20 0 0 SEQEND 0 POLYLINE");
    assert_eq!((strokes.len(), notes.len()), (0, 2));
}

#[test]
fn splines_of_any_degree_and_knots_are_followed() {
    // Straight, whatever its knots.
    let straight = "0 SPLINE 71 3 10 0 20 0 10 1 20 1 10 5 20 5 10 6 20 6 10 9 20 9";
    let points = entity(straight);
    assert_eq!((points[0], points[points.len() - 1]), ([0.0; 2], [9.0; 2]));
    assert!(points.iter().all(|[x, y]| (x - y).abs() < 1e-9));

    // A parabola: y = x (2 - x) at twice its control point's height.
    let points =
        entity("0 SPLINE 71 2 40 0 40 0 40 0 40 1 40 1 40 1 10 0 20 0 10 50 20 100 10 100 20 0");
    assert!(points.len() > 10);
    let parabola = |x: f64| 200.0 * (x / 100.0) * (1.0 - x / 100.0);
    assert!(points.iter().all(|[x, y]| (y - parabola(*x)).abs() < 1e-9));
    for pair in points.windows(2) {
        let x = f64::midpoint(pair[0][0], pair[1][0]);
        let off = parabola(x) - f64::midpoint(pair[0][1], pair[1][1]);
        assert!(off.abs() < 3.0 * TOLERANCE, "{off}");
    }

    // A whole circle of nine points with knots inside.
    let mut circle = "0 SPLINE 70 1 71 2".to_owned();
    for knot in [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4] {
        write!(circle, " 40 {knot}").unwrap();
    }
    for (nth, [x, y]) in [
        [1, 0],
        [1, 1],
        [0, 1],
        [-1, 1],
        [-1, 0],
        [-1, -1],
        [0, -1],
        [1, -1],
        [1, 0],
    ]
    .iter()
    .enumerate()
    {
        let weight = if nth % 2 == 1 { 0.5_f64.sqrt() } else { 1.0 };
        write!(circle, " 41 {weight} 10 {} 20 {}", x * 10, y * 10).unwrap();
    }
    let points = entity(&circle);
    assert_eq!(points.first(), points.last());
    assert!(
        points
            .iter()
            .all(|[x, y]| (x.hypot(*y) - 10.0).abs() < 1e-9)
    );

    for (odd, why) in [
        ("0 SPLINE 71 3 11 0 21 0 11 5 21 5", "no control points"),
        ("0 SPLINE 71 0 10 0 20 0", "degree 0"),
        ("0 SPLINE 71 99 10 0 20 0", "degree 99"),
        ("0 SPLINE 71 3 10 0 20 0 10 1 20 1", "more than 2 points"),
        (
            "0 SPLINE 71 1 40 0 40 1 10 0 20 0 10 1 20 1",
            "has 2 knots, and needs 4",
        ),
        (
            "0 SPLINE 71 1 40 0 40 1 40 0 40 1 10 0 20 0 10 1 20 1",
            "do not rise",
        ),
        ("0 SPLINE 71 1 41 0 41 1 10 0 20 0 10 1 20 1", "above 0"),
    ] {
        let (strokes, notes) = entities(odd);
        assert!(
            strokes.is_empty() && notes[0].contains(why),
            "{odd}: {notes:?}"
        );
    }
}

#[test]
fn dots_faces_and_solids_are_lines() {
    assert_eq!(entity("0 POINT 10 3 20 4"), [[3.0, 4.0]]);
    assert_eq!(entity("0 LINE 10 3 20 4 11 3 21 4"), [[3.0, 4.0]]);
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
    assert_eq!(
        entity("0 SOLID 10 0 20 0 11 1 21 0 12 0 22 1 13 1 23 1"),
        square
    );
    assert_eq!(
        entity("0 3DFACE 10 0 20 0 11 1 21 0 12 1 22 1 13 0 23 1"),
        square
    );
}

#[test]
fn blocks_are_inserted_turned_scaled_in_rows_and_within_one_another() {
    let words = |entities: &str| {
        file(&format!(
            "0 SECTION 2 HEADER 9 $INSUNITS 70 5 0 ENDSEC \
             0 SECTION 2 TABLES 0 TABLE 2 LAYER 0 LAYER 2 cold 70 1 0 LAYER 2 dark 62 -7 0 LAYER 2 blank 290 0 0 ENDSEC \
             0 SECTION 2 BLOCKS \
             0 BLOCK 2 Tick 10 1 20 1 0 LINE 8 0 10 1 20 1 11 2 21 1 0 ENDBLK \
             0 BLOCK 2 Pair 10 0 20 0 0 INSERT 2 tick 10 0 20 0 0 INSERT 2 TICK 10 0 20 5 50 90 0 ENDBLK \
             0 BLOCK 2 Snake 0 INSERT 2 SNAKE 10 0 20 0 0 POINT 10 0 20 0 0 ENDBLK \
             0 ENDSEC 0 SECTION 2 ENTITIES {entities} 0 ENDSEC"
        ))
    };
    let drawn = |entities: &str| {
        let (artwork, notes) = drawn(words(entities).as_bytes());
        let lines = artwork.strokes.iter().map(|stroke| {
            let rounded = |value: f64| (value * 1e6).round() as i64 / 1_000_000;
            let points = stroke.points.iter();
            points.map(|point| point.map(rounded)).collect::<Vec<_>>()
        });
        let notes: Vec<_> = notes.into_iter().map(|note| note.message).collect();
        (lines.collect::<Vec<_>>(), notes)
    };
    // In cm.
    let (lines, notes) = drawn("0 INSERT 2 Tick 10 3 20 4 41 2 50 180");
    assert_eq!((lines, notes.len()), (vec![vec![[30, 40], [10, 40]]], 0));
    let (lines, _) = drawn("0 INSERT 2 Tick 10 0 20 0 70 2 71 2 44 3 45 4 50 90");
    let starts: Vec<_> = lines.iter().map(|line| line[0]).collect();
    assert_eq!(starts, [[0, 0], [0, 30], [-40, 0], [-40, 30]]);
    let (lines, _) = drawn("0 INSERT 2 Pair 10 1 20 1 42 -1");
    assert_eq!(lines, [[[10, 10], [20, 10]], [[10, -40], [10, -50]]]);

    let (lines, notes) = drawn("0 INSERT 2 Snake 10 0 20 0 0 INSERT 2 Nobody 10 0 20 0");
    assert_eq!(lines.len(), 1);
    assert!(notes[0].contains("contains itself") && notes[1].contains("not in the file"));

    // What is on layer 0 of a block is on the layer that it is inserted on.
    for (layer, count) in [
        ("cold", 0),
        ("COLD", 0),
        ("dark", 0),
        ("blank", 0),
        ("other", 1),
    ] {
        let (lines, notes) = drawn(&format!("0 INSERT 8 {layer} 2 Tick 10 0 20 0"));
        assert_eq!((lines.len(), notes.len()), (count, 1 - count), "{layer}");
    }
}

#[test]
fn blocks_that_unfold_to_too_much_are_refused() {
    let mut words = "0 SECTION 2 BLOCKS 0 BLOCK 2 b0 0 POINT 10 0 20 0 0 ENDBLK".to_owned();
    for nth in 1..30 {
        let inner = format!("0 INSERT 2 b{} 10 0 20 0", nth - 1);
        write!(words, " 0 BLOCK 2 b{nth} {inner} {inner} 0 ENDBLK").unwrap();
    }
    words += " 0 ENDSEC 0 SECTION 2 ENTITIES 0 INSERT 2 b29 10 0 20 0 0 ENDSEC";
    let problem = read(Format::Dxf, file(&words).as_bytes(), &options()).unwrap_err();
    assert!(problem.message.contains("more than"), "{problem}");
    let rows = "0 SECTION 2 BLOCKS 0 BLOCK 2 b 0 ENDBLK 0 ENDSEC \
        0 SECTION 2 ENTITIES 0 INSERT 2 b 10 0 20 0 70 9000000 71 9000000 0 ENDSEC";
    read(Format::Dxf, file(rows).as_bytes(), &options()).unwrap_err();
}

#[test]
fn what_is_no_dxf_says_where() {
    let refusal = |text: &str| {
        let problem = read(Format::Dxf, text.as_bytes(), &options()).unwrap_err();
        problem.to_string()
    };
    assert_eq!(refusal(""), "this is no DXF file: it has no sections");
    assert_eq!(refusal("AC1027"), "this is a DWG file, not a DXF file");
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
            .contains("beyond")
    );
    let unit = file("0 SECTION 2 HEADER 9 $INSUNITS 70 19 0 ENDSEC");
    assert!(refusal(&unit).starts_with("line 8, column 1: 19 is no unit"));

    let (artwork, notes) = drawn(b"0\nSECTION\n2\nENTITIES\n0\nPOINT\n10\n1\n20\n2\n");
    assert_eq!(artwork.strokes[0].points, [[1.0, 2.0]]);
    assert!(notes[0].message.contains("taken as mm"));
    assert!(notes[1].message.contains("cut short"));
}

/// The plate in binary, with codes of one byte or two.
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
fn binary_files_are_the_same_without_lines() {
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
    fn broken_drawings_are_refused_or_drawn(
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
