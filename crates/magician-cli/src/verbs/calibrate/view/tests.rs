//! Pictures of the calibration at every size of terminal.

use magician_program::Tool;

use super::super::subject::Touch;
use super::*;
use crate::terminal::ObservedArm;
use crate::terminal::test::{Example, assert_shows, screen, status};
use crate::verbs::jog::Pad;
use magician_job::jog::{Pendant, ToolState};

fn model(subject: Subject, touches: &[[f64; 4]]) -> Model {
    let mut observed = ObservedArm::new("sim".to_owned(), 32);
    observed.arm.observe(status());
    let mut touched = Touched::new(subject, Tool::Pen);
    for pose in touches {
        touched.add(Touch { pose: *pose });
    }
    Model {
        observed,
        pad: Pad::new(Pendant::new(50.0, ToolState::default(), false)),
        touched,
    }
}

/// Calibration in all its states.
pub(in crate::verbs) fn examples() -> Vec<Example> {
    const CORNERS: [[f64; 4]; 3] = [
        [150.0, -105.0, -61.0, 0.0],
        [447.0, -105.0, -61.0, 0.0],
        [150.0, 105.6, -61.0, 0.0],
    ];
    const STEEP: [[f64; 4]; 3] = [
        [200.0, 0.0, 0.0, 0.0],
        [280.0, 0.0, 0.0, 0.0],
        [200.0, 80.0, 70.0, 0.0],
    ];
    let arm = [
        "x 259.10",
        "r 0.00",
        "J2 45.0",
        "step 5",
        "50 %",
        "stands",
        "0x00 ResetOccurred:",
        "home the arm",
        "touch with the tool pen",
    ];
    let example = |name, subject: Subject, touches: &'static [[f64; 4]], needs: &[&str]| {
        let shown = move |help| {
            let mut model = model(subject, touches);
            model.pad.help = help;
            model
        };
        let needs = [&arm[..], needs].concat();
        Example::new(name, &needs, &KEYS, shown, draw)
    };
    vec![
        example(
            "calibrate sheet",
            Subject::Sheet,
            &CORNERS[..1],
            &[
                Subject::Sheet.instruction(),
                "x+ ↑",
                "y+ ←",
                "─●1",
                "● 1 lower left x 150.00 y -105.00 z -61.00",
                "▶ 2 lower right next",
                "○ 3 upper left",
                "Enter take the point",
                "? all keys",
            ],
        ),
        example(
            "calibrate sheet, found",
            Subject::Sheet,
            &CORNERS,
            &[
                "size 297.0 by 210.6 mm",
                "paper looks like A4, landscape, 0.6 mm off",
                "lower left x 150.0 y -105.0",
                "rotation 0.0 deg to the left",
                "tilt 0.00 deg",
                "height z -61.00 mm at the lower left",
                "● 1 lower left x 150.00 y -105.00 z -61.00",
                "● 3 upper left x 150.00 y 105.60 z -61.00",
                "Enter save it",
                "q quit without saving",
            ],
        ),
        example(
            "calibrate sheet, refused",
            Subject::Sheet,
            &STEEP,
            &[
                "the surface is tilted by 41.2 deg",
                "Backspace undoes the last point.",
                "● 3 upper left x 200.00 y 80.00 z 70.00",
                "? all keys",
            ],
        ),
        example(
            "calibrate surface",
            Subject::Surface,
            &[],
            &[
                Subject::Surface.instruction(),
                "─────────┴───────── paper or table",
                "▶ 1 anywhere next",
            ],
        ),
        example(
            "calibrate tool",
            Subject::Tool,
            &[[230.0, 40.0, -60.0, 10.0]],
            &[
                Subject::Tool.instruction(),
                "────+──────────+──── the same mark",
                "● 1 the point x 230.00 y 40.00 r 10.00",
                "▶ 2 turned next",
            ],
        ),
    ]
}

fn drawn(model: &Model, width: u16, height: u16) -> Vec<String> {
    screen(width, height, |frame| draw(frame, model, Theme::PLAIN))
}

#[test]
fn sketch_marks_the_next_corner() {
    for (width, height) in [(80, 24), (200, 50)] {
        let model = model(Subject::Sheet, &[[180.0, -60.0, -61.0, 0.0]]);
        let screen = drawn(&model, width, height);
        assert_shows(
            &screen,
            &["touch with the tool pen", "3○────", "────●1", "┌────", "▶2"],
        );
        assert_shows(
            &screen,
            &["x  180.00 y  -60.00 z  -61.00", "Enter take the point"],
        );
    }
}

#[test]
fn sketch_is_oriented_like_the_keys() {
    let mut model = model(Subject::Sheet, &[]);
    // Corners at the lower left and the lower right of the screen, and the direction of y.
    for (corners, axes) in [
        (["3○────", "────▶1"], ["x+ ↑", "y+ ←"]),
        (["1▶────", "────○2"], ["x+ →", "y+ ↑"]),
        (["2○────", "────┘"], ["x+ ↓", "y+ →"]),
        (["└────", "────○3"], ["x+ ←", "y+ ↓"]),
    ] {
        for (width, height) in [(60, 20), (80, 24)] {
            let screen = drawn(&model, width, height);
            assert_shows(&screen, &corners);
            assert_shows(&screen, &axes);
        }
        model.pad.view = model.pad.view.turned();
    }
}

#[test]
fn result_is_shown_before_saving() {
    let touches = [
        [150.0, -105.0, -61.0, 0.0],
        [447.0, -105.0, -61.0, 0.0],
        [150.0, 105.6, -61.0, 0.0],
    ];
    let screen = drawn(&model(Subject::Sheet, &touches), 80, 24);
    assert_shows(
        &screen,
        &[
            "looks like A4, landscape, 0.6 mm off",
            "Enter save it",
            "0.0 deg to the left",
        ],
    );
    let steep = [
        [200.0, 0.0, 0.0, 0.0],
        [280.0, 0.0, 0.0, 0.0],
        [200.0, 80.0, 70.0, 0.0],
    ];
    let screen = drawn(&model(Subject::Sheet, &steep), 80, 24);
    assert_shows(
        &screen,
        &[
            "the surface is tilted by 41.2 deg",
            "Backspace undoes the last point",
        ],
    );
}

#[test]
fn a_tool_is_touched_twice() {
    let screen = drawn(&model(Subject::Tool, &[[230.0, 40.0, -60.0, 10.0]]), 80, 24);
    assert_shows(
        &screen,
        &["turned by J4", "● 1 the point", "r   10.00", "▶ 2 turned"],
    );
}
