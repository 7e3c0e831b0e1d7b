//! Pictures of teaching at every size of terminal.

use super::super::pad::Prompt;
use super::*;
use crate::terminal::test::{Example, assert_shows, screen, status};
use magician_job::jog::{Pendant, ToolState};
use magician_job::teach::ProgramModel;

fn model() -> Model {
    let mut observed = ObservedArm::new("arm at a port".to_owned(), 32);
    let status = status();
    let mut lesson = ProgramModel::new("pick.playback", None);
    lesson.store(&status.pose);
    lesson.next_suction().unwrap();
    lesson.set_pause(500).unwrap();
    lesson.arc_through(&magician::commands::Pose {
        x: 220.0,
        y: 10.0,
        z: 0.0,
        r: 0.0,
        joint_angle: [0.0; 4],
    });
    observed.arm.observe(status);
    Model {
        observed,
        pad: Pad::new(Pendant::new(50.0, ToolState::default(), false)),
        teach: TeachPad::new(lesson, true),
    }
}

/// Lesson in several states.
pub(in crate::verbs) fn examples() -> Vec<Example> {
    fn example(name: &'static str, needs: &[&str], change: fn(&mut Model)) -> Example {
        let shown = move |help| {
            let mut model = model();
            change(&mut model);
            model.pad.help = help;
            model
        };
        Example::new(name, needs, &KEYS, shown, draw)
    }
    vec![
        example(
            "teach",
            &[
                "magician teach | arm at a port",
                "pick.playback*: 1 rows",
                "1 P1 MOVJ 259.1 0.0 -8.5",
                "suck 0.5s",
                "arc through 220.0 10.0 0.0 to ...",
                "x 259.10",
                "r 0.00",
                "J2 45.0",
                "J4 0.0",
                "step 5",
                "50 %",
                "stands",
                "○ suction ○ gripper ○ laser",
                "0x00 ResetOccurred:",
                "home the arm",
                "Enter store",
                "? all keys",
            ],
            |_| {},
        ),
        example(
            "teach nothing yet",
            &[
                "Move the arm with the arrow keys, w s and a d,",
                "or by hand with its unlock key held;",
                "Enter stores its position.",
            ],
            |model| model.teach = TeachPad::new(ProgramModel::new("new", None), false),
        ),
        example(
            "teach a row with a long name, among many",
            &[
                "from the tray at the back MOVJ 259.1 0.0 -8.5 0.0 grip suck 12.5s",
                "laser ON",
                "not saved. Save it? y saves, n discards, any other key stays",
            ],
            |model| {
                let pose = model.observed.arm.status.as_ref().unwrap().pose;
                let lesson = &mut model.teach.editor.program;
                (0..40).for_each(|_| drop(lesson.store(&pose)));
                lesson.rename("from the tray at the back").unwrap();
                lesson.next_gripper().unwrap();
                lesson.next_suction().unwrap();
                lesson.set_pause(12_500).unwrap();
                model.teach.prompt = Some(Prompt::Leave);
                model.pad.pendant.tools.laser = true;
            },
        ),
    ]
}

fn picture(model: &Model, width: u16, height: u16) -> Vec<String> {
    screen(width, height, |frame| draw(frame, model, Theme::PLAIN))
}

#[test]
fn the_list_at_the_left_and_the_arm_at_the_right() {
    for (width, height) in [(80, 24), (200, 50)] {
        let picture = picture(&model(), width, height);
        assert_shows(
            &picture,
            &[
                "magician teach | arm at a port",
                "pick.playback*: 1 rows",
                "  1 P1 ",
                " MOVJ  259.1    0.0   -8.5",
                " suck 0.5s",
                "arc through 220.0 10.0 0.0",
                "259.10",
                "45.0",
                "0x00 ResetOccurred",
                "Enter store",
                "? all keys",
            ],
        );
    }
}

#[test]
fn questions_are_shown_in_the_last_line() {
    let mut model = model();
    model.teach.prompt = Some(Prompt::Name("pick".to_owned()));
    assert_shows(&picture(&model, 80, 24), &[" name: pick_"]);
    model.teach.prompt = Some(Prompt::Leave);
    assert_shows(&picture(&model, 80, 24), &[" not saved. Save it?"]);
}

#[test]
fn every_size_has_a_picture() {
    let mut model = model();
    let pose = model.observed.arm.status.as_ref().unwrap().pose;
    (0..300).for_each(|_| drop(model.teach.editor.program.store(&pose)));
    for width in [1, 2, 5, 10, 29, 50, 80, 119, 120, 300] {
        for height in [1, 2, 3, 5, 10, 21, 24, 60] {
            assert_eq!(picture(&model, width, height).len(), usize::from(height));
        }
    }
    assert_shows(&picture(&model, 80, 24), &["301 P301 "]);
}
