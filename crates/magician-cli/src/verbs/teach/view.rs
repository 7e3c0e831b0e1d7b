//! How a lesson looks: the list at the left, the arm at the right.

use magician_program::{Action, Grip, Travel};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::classroom::Classroom;
use super::lesson::Row;
use crate::terminal::{Seen, Theme, help, panel};
use crate::verbs::jog::{MOVES, Pad, at_the_right, foot, said, thirds};

/// What is shown.
#[derive(Clone, Debug)]
pub(super) struct Model {
    pub(super) seen: Seen,
    pub(super) pad: Pad,
    pub(super) room: Classroom,
}

const KEYS: [(&str, &str); 20] = [
    (
        "Enter space",
        "store where the arm stands, after the row chosen",
    ),
    ("j k  J K", "choose a row; move it down or up"),
    (
        "t",
        "how it is reached: MOVJ joints, MOVL straight, JUMP over",
    ),
    ("v", "an arc through here, to where Enter is pressed next"),
    ("r", "teach this row anew: where the arm is now"),
    ("n  P", "name it; pause there"),
    ("G S", "gripper or suction there: change nothing, on, off"),
    ("x  u U", "delete it; take a change back, make it anew"),
    ("o O", "play from here; play all (checked first)"),
    ("f", "store when the arm's unlock key is released, or not"),
    ("Ctrl-S  q", "save; leave (asks if not saved)"),
    MOVES[0],
    MOVES[1],
    MOVES[2],
    MOVES[3],
    ("space", "stop, while anything moves"),
    MOVES[5],
    (
        "m  + -  . ,",
        "hold or step; length of steps; faster, slower",
    ),
    ("p g l", "suction, gripper, laser now"),
    ("h c  Ctrl-L", "home; clear alarms; draw everything anew"),
];
const HINTS: [(&str, &str); 8] = [
    ("Enter", "store"),
    ("j k", "choose"),
    ("t", "way"),
    ("o O", "play"),
    ("u", "undo"),
    ("^S", "save"),
    ("q", "quit"),
    ("?", "all keys"),
];
/// A list this wide has room for long names and rotations.
const ROOMY: u16 = 64;

/// Draws one frame.
pub(super) fn draw(frame: &mut Frame<'_>, model: &Model, theme: Theme) {
    let Model { seen, pad, room } = model;
    let width = frame.area().width;
    let foot = match &room.prompt {
        Some(prompt) => said(&prompt.text(), width, theme.note()),
        None => foot(pad, &HINTS, width, theme),
    };
    let [header, middle, footer] = thirds(frame.area(), &foot);
    frame.render_widget(seen.header("teach", header.width, theme), header);
    let left = at_the_right(frame, middle, seen, pad, theme);
    list(frame, left, room, theme);
    frame.render_widget(Paragraph::new(foot), footer);
    if pad.help {
        help(frame, middle, &KEYS, theme);
    }
}

fn list(frame: &mut Frame<'_>, area: Rect, room: &Classroom, theme: Theme) {
    let lesson = &room.lesson;
    let star = if lesson.is_saved() { "" } else { "*" };
    let tool = lesson
        .tool
        .map_or_else(String::new, |tool| format!(", {tool}"));
    let follows = match room.follows {
        Some(true) => ", by hand too",
        _ => "",
    };
    let count = lesson.rows.len();
    let block = panel(
        format!("{}{star}: {count} rows{tool}{follows}", lesson.title),
        theme,
    );
    let height = usize::from(block.inner(area).height);
    let mut lines = Vec::new();
    // The row that is chosen stays in sight.
    let first = (lesson.selected + 1).saturating_sub(height.max(1));
    for (nth, row) in lesson.rows.iter().enumerate().skip(first).take(height) {
        let text = format!("{:>2} {}", nth + 1, describe(row, area.width >= ROOMY));
        let style = match (nth == lesson.selected, room.playing == Some(nth)) {
            (_, true) => theme.good(),
            (true, _) => theme.bar(),
            _ => ratatui::style::Style::new(),
        };
        let sign = if room.playing == Some(nth) {
            "▶"
        } else {
            " "
        };
        lines.push(Line::from(vec![
            Span::styled(sign, theme.good()),
            Span::styled(text, style),
        ]));
    }
    if let Some([x, y, z, _]) = lesson.via {
        let text = format!("    arc through {x:.1} {y:.1} {z:.1} to ...");
        lines.push(Line::styled(text, theme.note()));
    }
    if lesson.rows.is_empty() && lesson.via.is_none() {
        for text in [
            "Move the arm with the arrow keys, w s and a d,",
            "or by hand with its unlock key held;",
            "Enter stores where it stands.",
        ] {
            lines.push(Line::styled(text, theme.dim()));
        }
    }
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// A row in a line: name, way, place, what is done there.
fn describe(row: &Row, roomy: bool) -> String {
    let name: String = row.name.chars().take(if roomy { 16 } else { 7 }).collect();
    let way = |by: &Travel| match by {
        Travel::Joints => "MOVJ",
        Travel::Line => "MOVL",
        Travel::Jump => "JUMP",
    };
    let at = |[a, b, c, d]: [f32; 4]| match roomy {
        true => format!("{a:>6.1}{b:>7.1}{c:>7.1}{d:>7.1}"),
        false => format!("{a:>6.1}{b:>7.1}{c:>7.1}"),
    };
    let motion = match &row.motion {
        Some(Action::Move { to, by }) => format!("{} {}", way(by), at(*to)),
        Some(Action::Joints { to, by }) => format!("{} {} J", way(by), at(*to)),
        Some(Action::Arc { to, .. }) => format!("ARC  {}", at(*to)),
        Some(Action::Shift { by, .. }) => format!("by   {}", at(*by)),
        Some(Action::Path { to: [x, y, z] }) => format!("CP   {}", at([*x, *y, *z, 0.0])),
        Some(Action::Burn {
            to: [x, y, z],
            power,
        }) => {
            format!("CPLE {x:>6.1}{y:>7.1}{z:>7.1} {power:.0} %")
        }
        Some(Action::Home) => "home".to_owned(),
        Some(other) => other.command().row().set_name.to_owned(),
        None => "there".to_owned(),
    };
    let mut text = match roomy {
        true => format!("{name:<16} {motion}"),
        false => format!("{name:<7} {motion}"),
    };
    text.push_str(match row.gripper {
        Some(Grip::Close) => " grip",
        Some(Grip::Open) => " open",
        Some(Grip::Off) => " limp",
        None => "",
    });
    text.push_str(match row.suction {
        Some(true) => " suck",
        Some(false) => " drop",
        None => "",
    });
    if row.pause > 0 {
        text.push_str(&format!(" {}s", f64::from(row.pause) / 1000.0));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::classroom::Prompt;
    use super::super::lesson::Lesson;
    use super::*;
    use crate::terminal::test::{screen, shows, status};
    use crate::verbs::jog::Tools;

    fn model() -> Model {
        let mut seen = Seen::new("arm at a port".to_owned(), 32);
        let status = status();
        let mut lesson = Lesson::new("pick.playback", None);
        lesson.store(&status.pose);
        lesson.next_suction().unwrap();
        lesson.pause("0.5").unwrap();
        lesson.via = Some([220.0, 10.0, 0.0, 0.0]);
        seen.see(status);
        Model {
            seen,
            pad: Pad::new(50.0, Tools::default(), false),
            room: Classroom::new(lesson, true),
        }
    }

    fn picture(model: &Model, width: u16, height: u16) -> Vec<String> {
        screen(width, height, |frame| draw(frame, model, Theme::PLAIN))
    }

    #[test]
    fn the_list_at_the_left_and_the_arm_at_the_right() {
        for (width, height) in [(80, 24), (200, 50)] {
            let picture = picture(&model(), width, height);
            shows(
                &picture,
                &[
                    "magician teach | arm at a port",
                    "pick.playback*: 1 rows",
                    "  1 P1 ",
                    " MOVJ  259.1    0.0   -8.5",
                    " suck 0.5s",
                    "arc through 220.0 10.0 0.0",
                    "x    259.10 mm",
                    "J2     45.0",
                    "0x00 ResetOccurred",
                    "Enter store",
                    "? all keys",
                ],
            );
        }
    }

    #[test]
    fn what_is_asked_stands_in_the_last_line() {
        let mut model = model();
        model.room.prompt = Some(Prompt::Name("pick".to_owned()));
        shows(&picture(&model, 80, 24), &[" name: pick_"]);
        model.room.prompt = Some(Prompt::Leave);
        shows(&picture(&model, 80, 24), &[" not saved. Save it?"]);
    }

    #[test]
    fn every_size_has_a_picture() {
        let mut model = model();
        let pose = model.seen.status.as_ref().unwrap().pose;
        (0..300).for_each(|_| drop(model.room.lesson.store(&pose)));
        for width in [1, 2, 5, 10, 29, 50, 80, 119, 120, 300] {
            for height in [1, 2, 3, 5, 10, 21, 24, 60] {
                assert_eq!(picture(&model, width, height).len(), usize::from(height));
            }
        }
        shows(&picture(&model, 80, 24), &["301 P301 "]);
    }
}
