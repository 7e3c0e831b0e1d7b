//! The pad as it is seen.

use std::time::Instant;

use magician::Link;

use super::axis::{Axis, Heading};
use super::hands::What;
use super::pad::{self, Pad, Question, Tools, Way};
use super::view::{Model, draw};
use crate::terminal::test::{screen, shows};
use crate::terminal::{Seen, Theme};

fn model() -> Model {
    let mut seen = Seen::new("arm at a port".to_owned(), 32);
    seen.see(crate::terminal::test::status());
    Model {
        seen,
        pad: Pad::new(50.0, Tools::default(), false),
    }
}

fn picture(model: &Model, width: u16, height: u16) -> Vec<String> {
    screen(width, height, |frame| draw(frame, model, Theme::PLAIN))
}

#[test]
fn a_pad_on_a_narrow_and_on_a_wide_terminal() {
    for (width, height) in [(80, 24), (200, 50)] {
        shows(
            &picture(&model(), width, height),
            &[
                "magician jog | arm at a port",
                "link up",
                "x    259.10 mm  up down",
                "y      0.00 mm  left right",
                "J2     45.0    -5 ─",
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
fn what_is_done_and_asked_and_refused() {
    let mut model = model();
    model.pad.frame = pad::Frame::Joints;
    model.pad.way = Way::Hold;
    model.pad.tools.laser = true;
    let (axis, forward) = (Axis::J3, false);
    model.pad.doing = Some(What::Jog(Heading { axis, forward }));
    model.pad.refusal = Some("x+: x would be at 400.0 mm, limit 282.0 mm".to_owned());
    model.pad.question = Some(Question::Home);
    shows(
        &picture(&model, 80, 24),
        &[
            "moves joints J2 J1 J3 J4  by hold: moves while held",
            "jogs j3-",
            "● laser  ON",
            "refused x+: x would be at 400.0 mm, limit 282.0 mm",
            " home: the base turns",
        ],
    );
    model.pad.help = true;
    shows(&picture(&model, 80, 24), &["stop, whatever moves"]);
}

#[test]
fn a_line_that_is_lost_is_seen() {
    let mut model = model();
    let since = Instant::now();
    let (why, sought) = ("gone".into(), true);
    let link = Link::Lost { since, why, sought };
    if let Some(status) = &mut model.seen.status {
        status.link = link;
    }
    shows(&picture(&model, 80, 24), &["LINK LOST, looking for it"]);
}

#[test]
fn a_narrow_terminal_shows_whole_messages_and_where_the_keys_are() {
    let mut model = model();
    shows(
        &picture(&model, 60, 20),
        &["q quit  space STOP", "? all keys"],
    );
    let long = "x+: joint 2 would be at 91.3 deg, limit 90.0 deg, and this is the end";
    model.pad.say(pad::Tone::Bad, long);
    shows(&picture(&model, 40, 20), &["and this is the end"]);
    model.pad.help = true;
    shows(
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
