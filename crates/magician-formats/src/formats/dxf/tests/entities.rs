//! Tests of single entities, written as pairs of group code and value.

use std::f64::consts::PI;
use std::fmt::Write;

use super::*;

#[test]
fn chords_are_within_tolerance_of_the_curve() {
    for (words, centre, radius) in [
        ("0 CIRCLE 10 0 20 0 40 100", [0.0, 0.0], 100.0),
        ("0 ARC 10 5 20 5 40 1 50 300 51 60", [5.0, 5.0], 1.0),
        ("0 LWPOLYLINE 10 0 20 0 42 1 10 60 20 0", [30.0, 0.0], 30.0),
        ("0 LWPOLYLINE 10 0 20 0 42 -1 10 60 20 0", [30.0, 0.0], 30.0),
    ] {
        let points = entity(words);
        let sagitta = points.windows(2).map(|pair| {
            let middle = [0, 1].map(|axis| f64::midpoint(pair[0][axis], pair[1][axis]));
            radius - libm::hypot(middle[0] - centre[0], middle[1] - centre[1])
        });
        let most = sagitta.fold(0.0, f64::max);
        assert!(most <= TOLERANCE && points.len() > 2, "{words}: {most}");
        assert!(
            most > TOLERANCE / 8.0 || points.len() < 9,
            "{words}: {most}"
        );
    }
    // A positive bulge is counter-clockwise: the arc passes below.
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
        let across = (y * cos - x * sin) / 2.5;
        assert!((libm::hypot(along, across) - 1.0).abs() < 1e-9);
    }
    let quarter = format!("0 ELLIPSE 10 0 20 0 11 4 21 0 40 0.5 41 0 42 {}", PI / 2.0);
    let points = entity(&quarter);
    assert!(near(points[0], [4.0, 0.0]) && near(points[points.len() - 1], [0.0, 2.0]));
    // Seen from below, the minor axis points the other way.
    let points = entity(&format!("{quarter} 230 -1"));
    assert!(near(points[points.len() - 1], [0.0, -2.0]));
}

#[test]
fn reversed_extrusion_is_mirrored() {
    let points = entity("0 ARC 10 10 20 0 40 5 50 0 51 90 210 0 220 0 230 -1");
    assert!(near(points[0], [-15.0, 0.0]) && near(points[points.len() - 1], [-10.0, 5.0]));
    let points = entity("0 LWPOLYLINE 10 1 20 2 10 3 20 4 230 -1");
    assert_eq!(points, [[-1.0, 2.0], [-3.0, 4.0]]);
    // A line's points are in world coordinates regardless of its extrusion.
    assert_eq!(
        entity("0 LINE 10 1 20 2 11 3 21 4 230 -1"),
        [[1.0, 2.0], [3.0, 4.0]]
    );
    // An upright circle looks like a line from above, at its height along the normal.
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
    // Two triangles with a common edge. An outer edge of the second one is hidden.
    let faces = "0 POLYLINE 70 64 0 VERTEX 70 192 10 0 20 0 0 VERTEX 70 192 10 9 20 0 0 VERTEX 70 192 10 9 20 9 \
        0 VERTEX 70 192 10 0 20 9 0 VERTEX 70 128 10 0 20 0 71 1 72 2 73 3 0 VERTEX 70 128 10 0 20 0 71 1 72 -3 73 4 0 SEQEND";
    let lines = entities(faces).0;
    let total_length: f64 = lines.iter().map(Stroke::length).sum();
    assert!(
        (total_length - (27.0 + 9.0 * 2.0_f64.sqrt())).abs() < 1e-9,
        "{lines:?}"
    );
    // An open mesh of two by two vertices is a square.
    let mesh = "0 POLYLINE 70 16 71 2 72 2 0 VERTEX 70 64 10 0 20 0 0 VERTEX 70 64 10 0 20 9 \
        0 VERTEX 70 64 10 9 20 0 0 VERTEX 70 64 10 9 20 9 0 SEQEND";
    let total_length: f64 = entities(mesh).0.iter().map(Stroke::length).sum();
    assert!((total_length - 36.0).abs() < 1e-9);
    let (strokes, notes) = entities("0 POLYLINE 70 64 0 VERTEX 10 0 20 0 0 SEQEND 0 POLYLINE");
    assert_eq!((strokes.len(), notes.len()), (0, 2));
}

#[test]
fn layout_sheet_is_drawn_if_model_space_is_empty() {
    let sheet = "0 LINE 67 1 10 0 20 0 11 9 21 0";
    let (strokes, notes) = entities(sheet);
    assert_eq!(strokes.len(), 1);
    assert_eq!(
        notes,
        ["the drawing itself is empty: what lies on the sheet of its layout is drawn"]
    );
    let (strokes, notes) = entities(&format!("{sheet} 0 LINE 10 0 20 5 11 9 21 5"));
    assert_eq!(strokes[0].points, [[0.0, 5.0], [9.0, 5.0]]);
    assert!(
        strokes.len() == 1 && notes[0].contains("on the sheet of a layout"),
        "{notes:?}"
    );
}

#[test]
fn splines_of_any_degree_and_knots_are_followed() {
    // Straight, regardless of its knots.
    let straight = "0 SPLINE 71 3 10 0 20 0 10 1 20 1 10 5 20 5 10 6 20 6 10 9 20 9";
    let points = entity(straight);
    assert_eq!((points[0], points[points.len() - 1]), ([0.0; 2], [9.0; 2]));
    assert!(points.iter().all(|[x, y]| (x - y).abs() < 1e-9));

    // A parabola whose height is half that of its control point.
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

    // The axis of a helix is stored after its spline, and its points are not points of the spline.
    let helix = "71 2 40 0 40 0 40 0 40 1 40 1 40 1 10 0 20 0 10 50 20 100 10 100 20 0";
    let axis = "100 AcDbHelix 10 7 20 7 11 9 21 9 12 0 22 0 32 1 40 5 41 3";
    let followed = entity(&format!("0 HELIX 100 AcDbSpline {helix} {axis}"));
    assert_eq!(followed, points);

    // A full circle of nine control points with inner knots.
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
            .all(|[x, y]| (libm::hypot(*x, *y) - 10.0).abs() < 1e-9)
    );

    for (invalid, why) in [
        ("0 SPLINE 71 3 11 5 21 5", "no control points"),
        ("0 SPLINE 71 0 10 0 20 0", "degree 0"),
        ("0 SPLINE 71 99 10 0 20 0", "degree 99"),
        ("0 SPLINE 71 3 10 0 20 0 10 1 20 1", "more than 2 points"),
        (
            "0 SPLINE 71 1 40 0 40 1 10 0 20 0 10 1 20 1",
            "has 2 knots, and needs 4",
        ),
        (
            "0 SPLINE 71 1 40 0 40 1 40 0 40 1 10 0 20 0 10 1 20 1",
            "do not increase",
        ),
        ("0 SPLINE 71 1 41 0 41 1 10 0 20 0 10 1 20 1", "above 0"),
    ] {
        let (strokes, notes) = entities(invalid);
        assert!(
            strokes.is_empty() && notes[0].contains(why),
            "{invalid}: {notes:?}"
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
fn touching_lines_are_joined() {
    let drawn = |words: &str| {
        let (strokes, _) = entities(words);
        let points = strokes.into_iter().map(|stroke| stroke.points);
        points.collect::<Vec<_>>()
    };
    // Some lines are reversed, and the first one is in the middle of its chain.
    let open = "0 LINE 10 1 20 0 11 2 21 0 0 POINT 10 2 20 0 0 LINE 10 3 20 0 11 2 21 0 \
        0 LINE 10 0 20 5 11 1 21 0 0 LINE 8 other 10 0 20 5 11 0 21 9";
    assert_eq!(
        drawn(open),
        [
            vec![[0.0, 5.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]],
            vec![[2.0, 0.0]],
            vec![[0.0, 5.0], [0.0, 9.0]],
        ]
    );
    let round = "0 LINE 10 0 20 0 11 9 21 0 0 LINE 10 0 20 0 11 0 21 9 \
        0 LINE 10 9 20 0.00001 11 0.00001 21 9";
    let [closed] = drawn(round).try_into().unwrap();
    assert_eq!(closed.len(), 4);
    assert_eq!(closed.first(), closed.last());
    // At a junction of three it is unknown which two belong together.
    let fork = "0 LINE 10 0 20 0 11 1 21 0 0 LINE 10 1 20 0 11 2 21 1 0 LINE 10 1 20 0 11 2 21 -1";
    assert_eq!(drawn(fork).len(), 3);
}
