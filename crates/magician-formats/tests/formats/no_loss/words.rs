//! Words of other controllers and plotters, and curves as CAD programs write them.

use magician_formats::{Action, Content, Diagnostic, Format, Parsed, Plan, ReadOptions, read};

use super::{artwork, content, length, near, note_text, plan};

fn gcode(text: &str) -> Result<(Plan, String), Diagnostic> {
    match read(Format::Gcode, text.as_bytes(), &ReadOptions::default())? {
        Parsed {
            content: Content::Plan(plan),
            notes,
        } => Ok((plan, note_text(&notes))),
        other => panic!("{other:?}"),
    }
}

fn waits(plan: &Plan) -> Vec<u32> {
    let waits = plan.steps.iter().filter_map(|step| match step.action {
        Action::Wait(milliseconds) => Some(milliseconds),
        _ => None,
    });
    waits.collect()
}

#[test]
fn progress_of_a_slicer_is_left_out_and_saved_settings_are_refused() {
    let (plan, notes) = plan("m73.gcode");
    assert_eq!(
        plan.steps.iter().filter(|step| step.action.marks()).count(),
        3
    );
    assert!(
        note_text(&notes).contains("M73, the progress of a print, is left out (3 times)"),
        "{notes:?}"
    );
    for text in ["M73\nG1 X1", "M72 P1\nG1 X1"] {
        assert!(
            gcode(text)
                .unwrap_err()
                .message
                .contains("restores earlier settings")
        );
    }
}

#[test]
fn controller_commands_are_skipped_with_a_note() {
    let (plan, notes) = plan("lcnclaser.ngc");
    assert!(plan.steps.iter().any(|step| step.action.marks()));
    assert!(
        note_text(&notes).contains("line 4, column 10: the number of a spindle ($)"),
        "{notes:?}"
    );
    let (plan, notes) = gcode("?\nG0 X0 Y0 Z5\nG4\n!\nG1 Z0 F60\nG1 X5\n~\n").unwrap();
    assert!(waits(&plan).is_empty());
    assert!(
        notes.contains("line 1, column 1: a request to the controller")
            && notes.contains("(3 times)"),
        "{notes}"
    );
    assert!(
        notes.contains("line 3, column 1: G4 without P or S is left out"),
        "{notes}"
    );
}

#[test]
fn fractions_and_settings_make_pauses_count_seconds() {
    for (text, expected) in [
        ("G0 X0 Y0 Z5\nG4 P0.5\nG4 P2\n", vec![500, 2000]),
        ("$H\nG0 X0 Y0 Z5\nG4 P2\n", vec![2000]),
        ("; LightBurn 1.7\nG0 X0 Y0 Z5\nG4 P1\n", vec![1000]),
        ("G0 X0 Y0 Z5\nG4 P200\nG4 S1.5\n", vec![200, 1500]),
    ] {
        let (plan, notes) = gcode(text).unwrap();
        assert_eq!(waits(&plan), expected, "{text}");
        assert_eq!(
            notes.contains("counts seconds"),
            !text.contains("P200"),
            "{notes}"
        );
    }
}

#[test]
fn macros_and_corners_of_fanuc_are_named() {
    let refused = |name: &str| {
        content(name, &ReadOptions::default())
            .unwrap_err()
            .to_string()
    };
    let while_loop = refused("fanucmacro.nc");
    assert!(
        while_loop.contains("line 6") && while_loop.contains("WHILE of a Fanuc macro"),
        "{while_loop}"
    );
    let corner = refused("cornerR.nc");
    assert!(
        corner.contains("line 4, column 8") && corner.contains(",R"),
        "{corner}"
    );
    let of = |text: &str| gcode(text).unwrap_err().message;
    assert!(of("G0 X1\nIF [#1 GT 2] GOTO 5\n").contains("IF of a Fanuc macro"));
    assert!(of("G0 X1\nGOTO 5\n").contains("GOTO of a Fanuc macro"));
}

#[test]
fn curves_of_g5_are_drawn_within_the_tolerance() {
    let (plan, notes) = gcode("G21 G90\nG0 X0 Y0 Z5\nG1 Z0 F600\nG5 I0 J10 P0 Q10 X20 Y0\nG5 P0 Q-10 X40 Y0\nG5.1 I10 J10 X60\n").unwrap();
    assert_eq!(notes, "");
    let path: Vec<[f64; 2]> = plan
        .steps
        .iter()
        .filter_map(|step| match step.action {
            Action::Path { to } => Some([f64::from(to[0]), f64::from(to[1])]),
            _ => None,
        })
        .collect();
    assert_eq!(path.last(), Some(&[60.0, 0.0]));
    let highest = |from: f64, to: f64| {
        let within = path.iter().filter(|at| (from..=to).contains(&at[0]));
        within.map(|at| at[1].abs()).fold(0.0, f64::max)
    };
    // A cubic curve reaches three quarters of its handles' height, a quadratic one half of it.
    near(highest(0.0, 20.0), 7.5, 0.05);
    near(highest(20.0, 40.0), 7.5, 0.05);
    near(highest(40.0, 60.0), 5.0, 0.05);
    for pair in path.windows(2) {
        near(pair[0][0], pair[1][0], 4.0);
    }
    assert!(
        gcode("G0 X0 Y0 Z0\nG5 X5 Y5\n")
            .unwrap_err()
            .message
            .contains("I, J")
    );
}

#[test]
fn high_s_without_a_depth_advises_laser_and_pen() {
    let refused = content("mill_z0.nc", &ReadOptions::default()).unwrap_err();
    let acts: Vec<String> = refused
        .remedies
        .iter()
        .map(|remedy| format!("{:?} {}", remedy.act, remedy.effect))
        .collect();
    assert!(
        acts.len() == 2 && acts[1].contains("pen") && acts[1].contains("mill"),
        "{acts:?}"
    );
}

#[test]
fn instructions_of_roland_are_left_out_with_a_note() {
    let (drawn, notes) = artwork("roland.plt", &ReadOptions::default());
    near(length(&drawn), 100.0, 1e-6);
    assert!(
        note_text(&notes).contains("!PG, an instruction of Roland's own, is left out"),
        "{notes:?}"
    );
}

#[test]
fn spline_through_fit_points_is_interpolated() {
    let (drawn, notes) = artwork("splinefit.dxf", &ReadOptions::default());
    assert_eq!(drawn.strokes.len(), 1);
    assert!(!note_text(&notes).contains("left out"), "{notes:?}");
    let points = &drawn.strokes[0].points;
    for expected in [[0.0, 0.0], [10.0, 20.0], [20.0, -20.0], [30.0, 0.0]] {
        let nearest = points
            .iter()
            .map(|at| (at[0] - expected[0]).hypot(at[1] - expected[1]));
        assert!(nearest.fold(f64::MAX, f64::min) < 1e-6, "{expected:?}");
    }
    assert!(points.len() > 20);
    let dxf = |flags: i32, more: &str| {
        let text = format!(
            "0\nSECTION\n2\nENTITIES\n0\nSPLINE\n70\n{flags}\n71\n3\n{more}0\nENDSEC\n0\nEOF\n"
        );
        let parsed = read(Format::Dxf, text.as_bytes(), &ReadOptions::default()).unwrap();
        match parsed.content {
            Content::Artwork(artwork) => (artwork, note_text(&parsed.notes)),
            other => panic!("{other:?}"),
        }
    };
    // A circle from four quarter arcs.
    let (circle, _) = dxf(
        9,
        "11\n10\n21\n0\n11\n0\n21\n10\n11\n-10\n21\n0\n11\n0\n21\n-10\n",
    );
    assert!(circle.strokes[0].is_closed());
    for at in &circle.strokes[0].points {
        near(at[0].hypot(at[1]), 10.0, 0.5);
    }
    let (line, _) = dxf(8, "11\n0\n21\n0\n11\n10\n21\n0\n");
    near(length(&line), 10.0, 1e-6);
    let (none, notes) = dxf(8, "11\n1\n21\n1\n11\n1\n21\n1\n");
    assert!(
        none.strokes.is_empty() && notes.contains("left out"),
        "{notes}"
    );
}
