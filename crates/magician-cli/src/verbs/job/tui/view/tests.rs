//! Pictures of a job at every size of terminal.

use super::*;
use crate::terminal::test::{Example, assert_shows, screen, status};

fn model() -> Model {
    let mut observed = ObservedArm::new("arm at a port".to_owned(), 32);
    let mut first = status();
    first.left_space = 16;
    observed.arm.observe(first);
    observed.note("beginning at step 2");
    Model {
        verb: "draw",
        observed,
        around: Around::default(),
        sheet: Arc::new(Sheet::example()),
        doing: "running",
        step: 2,
        steps: Some(4),
        round: 1,
        rounds: Some(1),
        left: Some("0:12 left".to_owned()),
        help: None,
    }
}

/// Job in several states.
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
            "a job",
            &[
                "magician draw | arm at a port",
                "sheet",
                "running",
                "step 2 of 4",
                "0:12 left",
                "16/32",
                "○ suction ○ gripper ○ laser",
                "sent 0, again 0",
                "late 0, noise 0",
                "0x00 ResetOccurred:",
                "p pause space stop +- speed ? help",
            ],
            |_| {},
        ),
        example(
            "a job that is paused, in loops",
            &[
                "paused: p resumes",
                "step 7 of 12, loop 2 of 3",
                "1:05:00 left, at 50 %",
            ],
            |model| {
                model.doing = "paused: p resumes";
                (model.step, model.steps) = (7, Some(12));
                (model.round, model.rounds) = (2, Some(3));
                model.left = Some("1:05:00 left, at 50 %".to_owned());
            },
        ),
    ]
}

fn picture(model: &Model, width: u16, height: u16) -> Vec<String> {
    screen(width, height, |frame| draw(frame, model, Theme::PLAIN))
}

/// Counts the dots of the sheet that are set.
fn dots(picture: &[String]) -> u32 {
    let signs = picture.iter().flat_map(|line| line.chars());
    let braille = signs.filter(|sign| ('\u{2801}'..='\u{28FF}').contains(sign));
    braille
        .map(|sign| (u32::from(sign) - 0x2800).count_ones())
        .sum()
}

#[test]
fn the_sheet_fills_up() {
    let filled: Vec<u32> = [0, 2, 4]
        .map(|step| {
            let model = Model { step, ..model() };
            dots(&picture(&model, 80, 24))
        })
        .to_vec();
    assert!(
        filled[0] > 100,
        "the sheet's edge and what is to come: {filled:?}"
    );
    assert!(filled[1] > filled[0] + 30, "{filled:?}");
    assert!(filled[2] > filled[1] + 10, "{filled:?}");
    assert_shows(
        &picture(&model(), 80, 24),
        &["╭ sheet ", "╭ running ", "step 2 of 4"],
    );
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
