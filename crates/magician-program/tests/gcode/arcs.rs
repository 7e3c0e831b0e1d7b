//! Arcs against circles.

use magician_program::Action;
use magician_program::formats::Arcs;

use crate::{actions, actions_with, motions, notes, path, problem, travel};

/// The points that a program's arcs and lines go through, but for the first move.
fn points(actions: &[Action]) -> Vec<[f64; 3]> {
    let place = |[x, y, z, _]: [f32; 4]| [x, y, z].map(f64::from);
    let points = actions.iter().flat_map(|action| match *action {
        Action::Arc { via, to } => vec![place(via), place(to)],
        Action::Path { to } => vec![to.map(f64::from)],
        Action::Burn { to, .. } => vec![to.map(f64::from)],
        _ => vec![],
    });
    points.collect()
}

/// All are on the circle, and they go round it so far (degrees, counter-clockwise).
fn goes_round(points: &[[f64; 3]], from: [f64; 2], centre: [f64; 2], turn: f64) {
    let angle = |x: f64, y: f64| (y - centre[1]).atan2(x - centre[0]).to_degrees();
    let radius = (from[0] - centre[0]).hypot(from[1] - centre[1]);
    let (mut last, mut sum) = (angle(from[0], from[1]), 0.0);
    for [x, y, _] in points {
        assert!(
            ((x - centre[0]).hypot(y - centre[1]) - radius).abs() < 1e-3,
            "{x} {y}"
        );
        // Any two points that follow each other are less than half a turn apart.
        let step = (angle(*x, *y) - last + 540.0).rem_euclid(360.0) - 180.0;
        (last, sum) = (last + step, sum + step);
    }
    assert!((sum - turn).abs() < 1e-2, "{sum} for {turn}");
}

#[test]
fn every_way_to_say_an_arc_is_the_same_circle() {
    let start = "G0 X250 Y0 Z0 F600\n";
    for (arc, centre, turn) in [
        ("G3 X230 Y20 I-20 J0", [230.0, 0.0], 90.0),
        ("G2 X230 Y20 I-20", [230.0, 0.0], -270.0),
        ("G3 X230 Y20 R20", [230.0, 0.0], 90.0),
        ("G2 X230 Y20 R-20", [230.0, 0.0], -270.0),
        ("G2 X230 Y20 R20", [250.0, 20.0], -90.0),
        ("G3 X230 Y20 R-20", [250.0, 20.0], 270.0),
        ("G3 X210 Y0 I-20", [230.0, 0.0], 180.0),
        ("G2 X210 R20", [230.0, 0.0], -180.0),
        ("G2 I-20", [230.0, 0.0], -360.0),
        ("G3 X250 Y0 I0 J10", [250.0, 10.0], 360.0),
        ("G3 J10 P3", [250.0, 10.0], 1080.0),
        ("G2 X250.0000 Y1 I0 J0.5", [250.0, 0.5], -180.0),
        ("G90.1 G3 X230 Y20 I230 J0", [230.0, 0.0], 90.0),
        ("G91 G3 X-20 Y20 I-20 J0", [230.0, 0.0], 90.0),
        ("G91 G2 X-20 Y20 R20", [250.0, 20.0], -90.0),
        ("G92 X0 Y0\nG3 X-20 Y20 I-20", [230.0, 0.0], 90.0),
        ("G92 X0 Y0\nG90.1 G3 X-20 Y20 I-20 J0", [230.0, 0.0], 90.0),
        ("G91 G20 G3 X-1 Y1 I-1", [224.6, 0.0], 90.0),
        ("G2\nI-20 J0", [230.0, 0.0], -360.0),
    ] {
        let program = format!("{start}{arc}\n");
        let arms = actions(&program);
        let count = arms
            .iter()
            .filter(|one| matches!(one, Action::Arc { .. }))
            .count();
        assert!(count > 0, "{arc}");
        goes_round(&points(&arms), [250.0, 0.0], centre, turn);
        let lines = actions_with(&program, |options| options.arcs = Arcs::Lines);
        assert!(
            lines.iter().all(|one| !matches!(one, Action::Arc { .. })),
            "{arc}"
        );
        goes_round(&points(&lines), [250.0, 0.0], centre, turn);
        let burnt = actions(&format!("M3 S255\n{program}"));
        assert!(
            burnt.iter().all(|one| !matches!(one, Action::Arc { .. })),
            "{arc}"
        );
        goes_round(&points(&burnt), [250.0, 0.0], centre, turn);
    }
}

#[test]
fn a_helix_is_lines_that_rise_steadily() {
    let helix = actions("G0 X250 Y0 Z0\nG3 I-20 Z8 F600\n");
    let points = points(&helix);
    assert!(points.len() > 20);
    goes_round(&points, [250.0, 0.0], [230.0, 0.0], 360.0);
    let steps = points.len() as f64;
    for (nth, [_, _, z]) in (1..).zip(&points) {
        assert!((z - 8.0 * f64::from(nth) / steps).abs() < 1e-5);
    }
}

#[test]
fn an_arc_as_flat_as_the_tolerance_is_a_line_of_the_path() {
    // 2 mm of a circle of 20 mm are 0.025 mm high.
    assert_eq!(
        motions("G0 X250 Y0 Z0\nG3 X249.9 Y1.998 R20\n"),
        [travel(250.0, 0.0, 0.0), path(249.9, 1.998, 0.0)]
    );
}

#[test]
fn arcs_that_are_none_are_refused_with_what_is_wrong() {
    let start = "G0 X250 Y0 Z0\n";
    for (arc, message) in [
        (
            "G2 X240 Y0 I-20 J0",
            "line 2, column 1: the arc begins 20.000 mm from its centre and ends 10.000 mm from it",
        ),
        (
            "G2 X210 R10",
            "line 2, column 1: a radius of 10.000 mm is too small for ends that are 40.000 mm apart; it takes 20.000 mm",
        ),
        (
            "G2 R10",
            "line 2, column 1: an arc given by its radius must end somewhere else; a circle needs I and J",
        ),
        (
            "G2 X240",
            "line 2, column 1: the arc has neither a centre (I, J) nor a radius (R)",
        ),
        (
            "G2 X240 I-5 R5",
            "line 2, column 1: the arc has both a centre (I, J) and a radius (R)",
        ),
        ("G2 I0 J0", "line 2, column 1: the arc begins at its centre"),
        (
            "G18 G2 X240 I-5",
            "line 2, column 1: arcs in the plane of G18 are not done, only those of G17",
        ),
        (
            "G2 I-20 P0.5",
            "line 2, column 9: the arc makes 0.5 turns; 1 to 100 are possible",
        ),
        (
            "M3 S1\nG2 I-900000",
            "line 3, column 1: the arc has a radius of 900000 mm and takes 9425 lines; 2000 are the most",
        ),
    ] {
        assert_eq!(problem(&format!("{start}{arc}\n")), message);
    }
    // Programs round: within a twentieth of a millimetre the ends may differ.
    assert_eq!(notes(&format!("{start}G3 X230 Y20.03 I-20 J0\n")), [""; 0]);
    assert!(problem("G2 X240 Y0 I5").contains("it is not known where"));
}
