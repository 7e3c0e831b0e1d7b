//! How a lesson looks: the list at the left, the arm at the right.

use magician_program::{Action, Grip, Travel};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::classroom::Classroom;
use super::lesson::Row;
use crate::terminal::{Seen, Theme, panel, said, thirds, wrapped};
use crate::verbs::jog::{MOVES, Pad, beside, foot};

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
    let left = beside(frame, middle, seen, pad, theme);
    list(frame, left, room, theme);
    frame.render_widget(Paragraph::new(foot), footer);
    if let Some(help) = pad.help {
        help.draw(frame, middle, &KEYS, theme);
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
    let inner = block.inner(area);
    let width = usize::from(inner.width);
    let chosen = lesson.rows.get(lesson.selected);
    let chosen = chosen.map_or_else(Vec::new, |row| {
        whole(row, lesson.selected, width, area.width >= ROOMY)
    });
    // Rows that have a place beside what is begun and what the one that is chosen takes more.
    let more = chosen.len().saturating_sub(1) + usize::from(lesson.via.is_some());
    let height = usize::from(inner.height).saturating_sub(more);
    let mut lines = Vec::new();
    // The row that is chosen stays in sight, with all that there is to say of it.
    let first = (lesson.selected + 1).saturating_sub(height.max(1));
    for (nth, row) in lesson.rows.iter().enumerate().skip(first).take(height) {
        let texts = match nth == lesson.selected {
            true => chosen.clone(),
            false => vec![numbered(nth, &describe(row, area.width >= ROOMY))],
        };
        let plays = room.playing == Some(nth);
        let style = match (nth == lesson.selected, plays) {
            (_, true) => theme.good(),
            (true, _) => theme.bar(),
            _ => ratatui::style::Style::new(),
        };
        for (line, text) in texts.into_iter().enumerate() {
            let sign = if plays && line == 0 { "▶" } else { " " };
            lines.push(Line::from(vec![
                Span::styled(sign, theme.good()),
                Span::styled(text, style),
            ]));
        }
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

fn numbered(nth: usize, text: &str) -> String {
    format!("{:>2} {text}", nth + 1)
}

/// A row with its whole name and place, on more lines where one is too narrow.
fn whole(row: &Row, nth: usize, width: usize, roomy: bool) -> Vec<String> {
    let kept = if roomy { LONG } else { SHORT };
    let short = numbered(nth, &describe(row, roomy));
    if row.name.chars().count() <= kept && short.chars().count() < width {
        return vec![short];
    }
    let text = format!("{} {}", row.name, motion(row, true));
    let lines = wrapped(&text, width.saturating_sub(5)).into_iter();
    let line = |(line, text): (usize, String)| match line {
        0 => numbered(nth, &text),
        _ => format!("   {text}"),
    };
    lines.enumerate().map(line).collect()
}

/// Letters of a name that a row shows, where there is little room and where there is more.
const SHORT: usize = 7;
const LONG: usize = 16;

/// A row in a line: name, way, place, what is done there.
fn describe(row: &Row, roomy: bool) -> String {
    let kept = if roomy { LONG } else { SHORT };
    let name: String = row.name.chars().take(kept).collect();
    format!("{name:<kept$} {}", motion(row, roomy))
}

/// How its place is reached, where it is, what is done there.
fn motion(row: &Row, roomy: bool) -> String {
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
    let mut text = motion;
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
pub(super) mod tests {
    use super::super::classroom::Prompt;
    use super::super::lesson::Lesson;
    use super::*;
    use crate::terminal::test::{Example, screen, shows, status};
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

    /// A lesson in several states.
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
                    "clear the alarms",
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
                    "Enter stores where it stands.",
                ],
                |model| model.room = Classroom::new(Lesson::new("new", None), false),
            ),
            example(
                "teach a row with a long name, among many",
                &[
                    "from the tray at the back MOVJ 259.1 0.0 -8.5 0.0 grip suck 12.5s",
                    "laser ON",
                    "not saved. Save it? y saves, n leaves without, any other key stays",
                ],
                |model| {
                    let pose = model.seen.status.as_ref().unwrap().pose;
                    let lesson = &mut model.room.lesson;
                    (0..40).for_each(|_| drop(lesson.store(&pose)));
                    lesson.rename("from the tray at the back").unwrap();
                    lesson.next_grip().unwrap();
                    lesson.next_suction().unwrap();
                    lesson.pause("12.5").unwrap();
                    model.room.prompt = Some(Prompt::Leave);
                    model.pad.tools.laser = true;
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
            shows(
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
