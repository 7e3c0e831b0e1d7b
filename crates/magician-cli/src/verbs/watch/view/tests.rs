//! Pictures of a watched arm at every size of terminal.

use super::*;
use crate::terminal::test::{Example, assert_shows, screen, status};

fn model() -> Model {
    let mut observed = ObservedArm::new("arm at a port".to_owned(), 32);
    let first = status();
    let mut second = first.clone();
    second.pose.x += 5.0;
    second.left_space = 16;
    second.at = first.at + std::time::Duration::from_millis(100);
    observed.arm.observe(first);
    observed.arm.observe(second);
    observed.note("alarm 0x12 is gone");
    let mut model = Model::new(observed);
    model.note(Pin::analog(9, 2048));
    model
}

/// Watched arm in several states.
pub(in crate::verbs) fn examples() -> Vec<Example> {
    fn example(name: &'static str, needs: &[&str], change: fn(&mut Model)) -> Example {
        let shown = move |help| {
            let mut model = model();
            change(&mut model);
            model.help = help;
            model
        };
        Example::new(name, needs, &KEYS, shown, draw)
    }
    vec![
        example(
            "watch",
            &[
                "magician watch | arm at a port",
                "tool moves",
                "x 264.10",
                "y 0.00",
                "z -8.49",
                "r 0.00",
                "J1 0.0",
                "J2 45.0",
                "2-3 0.0",
                "16/32",
                "done 0",
                "tool 50.0 mm/s",
                "J4 0.0 deg/s",
                "○ suction ○ gripper ○ laser",
                "sent 0, again 0",
                "late 0, noise 0",
                "0x00 ResetOccurred:",
                "home the arm",
                "alarm 0x12 is gone",
                "q quit ? help",
            ],
            |_| {},
        ),
        example(
            "watch an arm that burns",
            &[
                "l 125.50",
                "● closed",
                "● laser ON",
                "sent 0, again 0",
                "late 0, noise 0",
            ],
            |model| {
                model.observed.arm.rail = Some(125.5);
                model.around.tools.laser = true;
                model.around.tools.gripper = magician_program::Grip::Close;
            },
        ),
    ]
}

fn picture(model: &Model, width: u16, height: u16) -> Vec<String> {
    screen(width, height, |frame| draw(frame, model, Theme::PLAIN))
}

#[test]
fn an_arm_on_a_narrow_and_on_a_wide_terminal() {
    let both = [
        "magician watch | arm at a port",
        "tool moves",
        "x    264.10 mm",
        "J2     45.0",
        "16/32",
        "done 0",
        "tool   50.0 mm/s",
        "J4      0.0 deg/s",
        "0x00 ResetOccurred",
        "alarm 0x12 is gone",
        "sent 0, again 0",
        "q quit",
    ];
    let (narrow, wide) = (picture(&model(), 80, 24), picture(&model(), 200, 50));
    assert_shows(&narrow, &both);
    assert_shows(&wide, &both);
    assert_shows(&narrow, &[" 8 ○  9a● 10 ○"]);
    assert_shows(&wide, &[" 9 ● analog-input            2048 of 4095"]);
    // The latest speed is the highest, at the right.
    assert!(narrow.iter().any(|line| line.contains("█│")));
}

#[test]
fn every_size_has_a_picture() {
    let mut model = model();
    for help in [false, true] {
        model.help = help.then(Help::default);
        for width in [1, 2, 5, 10, 29, 50, 80, 119, 120, 300] {
            for height in [1, 2, 3, 5, 10, 21, 23, 24, 60] {
                assert_eq!(picture(&model, width, height).len(), usize::from(height));
            }
        }
    }
}
