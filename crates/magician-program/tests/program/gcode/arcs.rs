//! Arcs compared with circles.

use magician_program::formats::Arcs;
use magician_program::{Action, Format, Frame, ReadOptions, Setup, Surface, Tool, read};

use super::{actions, actions_with, diagnostic, motions, notes, path, travel};

/// Points on a program's arcs and lines, except for the first move.
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

/// Asserts that all points are on the circle and cover this angle (degrees, counter-clockwise).
fn goes_round(points: &[[f64; 3]], from: [f64; 2], centre: [f64; 2], turn: f64) {
    let angle = |x: f64, y: f64| (y - centre[1]).atan2(x - centre[0]).to_degrees();
    let radius = (from[0] - centre[0]).hypot(from[1] - centre[1]);
    let (mut last, mut sum) = (angle(from[0], from[1]), 0.0);
    for [x, y, _] in points {
        assert!(
            ((x - centre[0]).hypot(y - centre[1]) - radius).abs() < 1e-3,
            "{x} {y}"
        );
        // Consecutive points are less than half a turn apart.
        let step = (angle(*x, *y) - last + 540.0).rem_euclid(360.0) - 180.0;
        (last, sum) = (last + step, sum + step);
    }
    assert!((sum - turn).abs() < 1e-2, "{sum} for {turn}");
}

#[test]
fn equivalent_arc_words_give_the_same_circle() {
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
fn arcs_of_g18_and_g19_are_lines_within_the_tolerance() {
    let start = "G0 X250 Y0 Z0\n";
    // Each with its centre, its highest point, and the axis of X, Y and Z that it does not turn in.
    for (arc, centre, top, across) in [
        ("G18 G2 X240 I-5", [245.0, 0.0, 0.0], 5.0, 1),
        ("G18 G3 X260 I5 K0", [255.0, 0.0, 0.0], 5.0, 1),
        ("G18 G2 X240 R5", [245.0, 0.0, 0.0], 5.0, 1),
        ("G18 G3 X240 I-5", [245.0, 0.0, 0.0], 0.0, 1),
        ("G18 G2 X245 Z5 I-5", [245.0, 0.0, 0.0], 5.0, 1),
        ("G18 G90.1 G2 X240 I245 K0", [245.0, 0.0, 0.0], 5.0, 1),
        ("G18 G91 G2 X-10 I-5", [245.0, 0.0, 0.0], 5.0, 1),
        ("G18 G3 K5", [250.0, 0.0, 5.0], 10.0, 1),
        ("G19 G3 Y-10 J-5", [250.0, -5.0, 0.0], 5.0, 0),
        ("G19 G2 Y10 J5", [250.0, 5.0, 0.0], 5.0, 0),
        ("G19 G2 Y10 R5", [250.0, 5.0, 0.0], 5.0, 0),
        ("G19 G20 G2 Y0.4 J0.2", [250.0, 5.08, 0.0], 5.08, 0),
        // A helix: Y rises steadily while X and Z turn.
        ("G18 G2 X240 Y12 I-5", [245.0, 0.0, 0.0], 5.0, 1),
    ] {
        for setting in ["", "M3 S255\n"] {
            let program = format!("{setting}{start}{arc}\nG17\n");
            let arms = actions(&program);
            assert!(
                arms.iter().all(|one| !matches!(one, Action::Arc { .. })),
                "{arc}"
            );
            let points = points(&arms);
            assert!(points.len() > 5, "{arc}: {points:?}");
            let in_plane = |[x, y, z]: [f64; 3]| match across {
                0 => [y - centre[1], z - centre[2]],
                _ => [x - centre[0], z - centre[2]],
            };
            let radius = |point| in_plane(point)[0].hypot(in_plane(point)[1]);
            let size = radius([250.0, 0.0, 0.0]);
            let mut last = [250.0, 0.0, 0.0];
            for point in &points {
                assert!((radius(*point) - size).abs() < 1e-3, "{arc}: {point:?}");
                let middle = [0, 1, 2].map(|axis| f64::midpoint(last[axis], point[axis]));
                assert!(size - radius(middle) < 0.051, "{arc}: {point:?}");
                last = *point;
            }
            let highest = points.iter().map(|point| point[2]).fold(0.0, f64::max);
            assert!((highest - top).abs() < 0.06, "{arc}: {highest}");
            let steps = points.len() as f64;
            for (nth, point) in (1..).zip(&points) {
                let from = [250.0, 0.0, 0.0][across];
                let steady = from + (last[across] - from) * f64::from(nth) / steps;
                assert!((point[across] - steady).abs() < 1e-4, "{arc}: {point:?}");
            }
        }
    }
}

#[test]
fn an_arc_as_flat_as_the_tolerance_is_a_line_of_the_path() {
    // 2 mm of a circle with a radius of 20 mm are 0.025 mm high.
    assert_eq!(
        motions("G0 X250 Y0 Z0\nG3 X249.9 Y1.998 R20\n"),
        [travel(250.0, 0.0, 0.0), path(249.9, 1.998, 0.0)]
    );
}

#[test]
fn invalid_arcs_are_refused_with_the_reason() {
    let start = "G0 X250 Y0 Z0\n";
    for (arc, message) in [
        (
            "G2 X240 Y0 I-20 J0",
            "line 2, column 1: the arc begins 20.000 mm from its centre and ends 10.000 mm from it",
        ),
        (
            "G2 X210 R10",
            "line 2, column 1: a radius of 10.000 mm is too small for ends that are 40.000 mm apart, it must be at least 20.000 mm",
        ),
        (
            "G2 R10",
            "line 2, column 1: an arc given by its radius must not end where it begins; a circle \
                needs I and J",
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
            "G18 G2 X240",
            "line 2, column 1: the arc has neither a centre (I, K) nor a radius (R)",
        ),
        (
            "G19 G2 Y10 J5 R5",
            "line 2, column 1: the arc has both a centre (J, K) and a radius (R)",
        ),
        (
            "G19 G2 X260 R5",
            "line 2, column 1: an arc given by its radius must not end where it begins; a circle \
                needs J and K",
        ),
        (
            "G2 I-20 P0.5",
            "line 2, column 9: the arc makes 0.5 turns, it must be 1 to 100",
        ),
        (
            "M3 S1\nG2 I-900000",
            "line 3, column 1: the arc has a radius of 900000 mm and takes 9425 lines, limit 2000",
        ),
    ] {
        assert_eq!(diagnostic(&format!("{start}{arc}\n")), message);
    }
    // Programs round: the ends may differ by a twentieth of a millimetre.
    assert_eq!(notes(&format!("{start}G3 X230 Y20.03 I-20 J0\n")), [""; 0]);
    assert!(diagnostic("G2 X240 Y0 I5").contains("which is unknown"));
}

#[test]
fn a_placed_arc_of_g18_is_scaled_and_turned_across_and_keeps_its_heights() {
    let text = "G0 X0 Y0 Z5\nG1 Z0 F600\nX10\nG18 G3 X20 Y4 I5 K0\nG1 X30 Y0\nG0 Z5\n";
    let mut setup = Setup::default();
    setup.tool = Some(Tool::Pen);
    setup.default_surface = Some(Surface::level(-40.0));
    setup.placement.frame = Frame::Own;
    setup.placement.at = Some([240.0, 0.0]);
    for (mirror, rotate, scale) in [
        (false, 0.0, 1.0),
        (true, 90.0, 2.0),
        (false, 30.0, 0.5),
        (true, -45.0, 3.0),
    ] {
        setup.placement.mirror = mirror;
        (setup.placement.rotate, setup.placement.scale) = (rotate, scale);
        let mut options = ReadOptions::default();
        setup.set_gcode_options(&mut options.gcode, None);
        let reading = read(Format::Gcode, text.as_bytes(), &options).expect("it is read");
        let made = setup.plan(Format::Gcode, reading.content).expect("a plan");
        let points = points(
            &made
                .plan
                .steps
                .iter()
                .map(|step| step.action.clone())
                .collect::<Vec<_>>(),
        );
        // Back into the file's coordinates, where the marks are from 0 to 30 and 0 to 4.
        let (sin, cos) = f64::to_radians(-rotate).sin_cos();
        let own = points.iter().map(|[x, y, z]| {
            let [x, y] = [x - 240.0, *y];
            let [x, y] = [cos * x - sin * y, sin * x + cos * y].map(|value| value / scale);
            [if mirror { -x } else { x }, y, z + 40.0]
        });
        let arc: Vec<_> = own.filter(|[_, _, z]| *z > 1e-3).collect();
        assert!(arc.len() > 5, "{arc:?}");
        let first = arc[0];
        for [x, _, z] in &arc {
            assert!((0.0..5.05).contains(z), "{x} {z}");
        }
        let middle = f64::midpoint(first[0], arc[arc.len() - 1][0]);
        for [x, _, z] in &arc {
            assert!(((x - middle).hypot(*z) - 5.0).abs() < 1e-2, "{x} {z}");
        }
        let rise = arc[arc.len() - 1][1] - first[1];
        assert!(rise > 2.5, "the helix goes across: {rise}");
    }
}
