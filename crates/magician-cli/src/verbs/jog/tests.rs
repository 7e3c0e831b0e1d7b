//! Pictures of the jog pad.

use std::time::Instant;

use magician::Link;
use magician_job::jog::{Activity, Axis, JogDirection, JogFrame, JogMode, Pendant, ToolState};
use magician_program::Grip;

use super::pad::{self, Pad, Question};
use super::view::{Model, draw};
use crate::terminal::test::{Example, assert_shows, screen};
use crate::terminal::{Help, ObservedArm, Theme};

fn model() -> Model {
    let mut observed = ObservedArm::new("arm at a port".to_owned(), 32);
    observed.arm.observe(crate::terminal::test::status());
    Model {
        observed,
        pad: Pad::new(Pendant::new(50.0, ToolState::default(), false)),
    }
}

/// Pad in several states.
pub(in crate::verbs) fn examples() -> Vec<Example> {
    fn example(name: &'static str, needs: &[&str], change: fn(&mut Model)) -> Example {
        let shown = move |help| {
            let mut model = model();
            change(&mut model);
            model.pad.help = help;
            model
        };
        Example::new(name, needs, &super::view::KEYS, shown, draw)
    }
    let always = ["magician jog | arm at a port", "link up"];
    let stands = [
        "x 259.10",
        "y 0.00",
        "z -8.49",
        "r 0.00",
        "J1 0.0",
        "J2 45.0",
        "J3 45.0",
        "J4 0.0",
        "2-3 0.0",
        "step 5",
        "50 %",
        "stands 0.0 mm/s",
        "○ suction ○ gripper ○ laser",
        "0x00 ResetOccurred:",
        "home the arm",
        "? all keys",
    ];
    let need = |more: &[&'static str]| [&always[..], more].concat();
    vec![
        example("jog", &need(&stands), |_| {}),
        example(
            "jog with a rail, its laser on, refused",
            &need(&[
                "l 125.50",
                "jogs j3-",
                "joints",
                "hold",
                "laser ON",
                "x+: joint 2 would be at 91.3 deg, limit 90.0 deg: move it the other way",
                "J2 45.0",
                "0x00 ResetOccurred",
            ]),
            |model| {
                model.observed.arm.rail = Some(125.5);
                model.pad.pendant.rail = true;
                model.pad.pendant.frame = JogFrame::Joints;
                model.pad.pendant.mode = JogMode::Hold;
                model.pad.pendant.tools.laser = true;
                model.pad.pendant.tools.gripper = Grip::Close;
                let (axis, forward) = (Axis::J3, false);
                model.pad.pendant.activity = Some(Activity::Jog(JogDirection { axis, forward }));
                let why = "x+: joint 2 would be at 91.3 deg, limit 90.0 deg: move it the other way";
                model.pad.refusal = Some(why.to_owned());
                model.observed.note(why);
            },
        ),
        example(
            "jog that asks",
            &need(&[
                "home: the base turns to its end and back, half a minute. Way clear? y/n",
                "x 259.10",
                "J4 0.0",
                "○ suction ○ gripper ○ laser",
                "0x00 ResetOccurred",
            ]),
            |model| model.pad.question = Some(Question::Home),
        ),
    ]
}

fn picture(model: &Model, width: u16, height: u16) -> Vec<String> {
    screen(width, height, |frame| draw(frame, model, Theme::PLAIN))
}

#[test]
fn a_pad_on_a_narrow_and_on_a_wide_terminal() {
    for (width, height) in [(80, 24), (200, 50)] {
        assert_shows(
            &picture(&model(), width, height),
            &[
                "magician jog | arm at a port",
                "link up",
                "x    259.10 mm  up down",
                "y      0.00 mm  left right",
                "J2     45.0 -13.5 ─",
                "2-3     0.0   -70 ─",
                "moves coordinates  by step 5 mm or deg  speed 50 %",
                "stands",
                "○ suction ○ gripper ○ laser",
                "0x00 ResetOccurred",
                "space STOP",
                "? all keys",
            ],
        );
    }
}

#[test]
fn keys_at_the_coordinates_rotate_with_the_view() {
    let mut model = model();
    model.pad.view = model.pad.view.turned();
    assert_shows(
        &picture(&model, 80, 24),
        &["x    259.10 mm  right left", "y      0.00 mm  up down"],
    );
    assert_shows(
        &picture(&model, 60, 20),
        &["x   259.10 →←", "y     0.00 ↑↓"],
    );
}

#[test]
fn activity_question_and_refusal_are_shown() {
    let mut model = model();
    model.pad.pendant.frame = JogFrame::Joints;
    model.pad.pendant.mode = JogMode::Hold;
    model.pad.pendant.tools.laser = true;
    let (axis, forward) = (Axis::J3, false);
    model.pad.pendant.activity = Some(Activity::Jog(JogDirection { axis, forward }));
    model.pad.refusal = Some("x+: x would be at 400.0 mm, limit 282.0 mm".to_owned());
    model.pad.question = Some(Question::Home);
    assert_shows(
        &picture(&model, 80, 24),
        &[
            "moves joints J2 J1 J3 J4  by hold: moves while held",
            "jogs j3-",
            "● laser  ON",
            "refused x+: x would be at 400.0 mm, limit 282.0 mm",
            " home: the base turns",
        ],
    );
    model.pad.help = Some(Help::default());
    assert_shows(&picture(&model, 80, 24), &["stop all motion"]);
}

#[test]
fn a_line_that_is_lost_is_seen() {
    let mut model = model();
    let since = Instant::now();
    let (why, sought) = ("gone".into(), true);
    let link = Link::Lost { since, why, sought };
    if let Some(status) = &mut model.observed.arm.status {
        status.link = link;
    }
    assert_shows(&picture(&model, 80, 24), &["LINK LOST, reconnecting"]);
}

#[test]
fn narrow_terminal_shows_whole_messages_and_the_help_key() {
    let mut model = model();
    assert_shows(
        &picture(&model, 60, 20),
        &["q quit  space STOP", "? all keys"],
    );
    let long = "x+: joint 2 would be at 91.3 deg, limit 90.0 deg, and this is the end";
    model.pad.say(pad::Tone::Bad, long);
    assert_shows(&picture(&model, 40, 20), &["and this is the end"]);
    model.pad.help = Some(Help::default());
    assert_shows(
        &picture(&model, 60, 30),
        &["move; hold: it", "moves while held"],
    );
}

#[test]
fn every_size_has_a_picture() {
    let model = model();
    for width in [1, 2, 5, 10, 29, 50, 80, 119, 300] {
        for height in [1, 2, 3, 5, 10, 21, 24, 60] {
            assert_eq!(picture(&model, width, height).len(), usize::from(height));
        }
    }
}
