//! Layout of teaching: the list of steps at the left, the arm at the right.

use magician_job::teach::TeachStep;
use magician_program::{Action, Grip, Travel};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::pad::TeachPad;
use crate::terminal::{ObservedArm, Theme, header_body_footer, message_lines, panel, wrapped};
use crate::verbs::jog::{MOVES, Pad, foot, side_panel};

/// Everything that is shown.
#[derive(Clone, Debug)]
pub(super) struct Model {
    pub(super) observed: ObservedArm,
    pub(super) pad: Pad,
    pub(super) teach: TeachPad,
}

const KEYS: [(&str, &str); 20] = [
    (
        "Enter space",
        "store the arm's position after the selected row",
    ),
    ("j k  J K", "select a row; move it down or up"),
    ("t", "its motion: MOVJ joints, MOVL straight, JUMP over"),
    ("v", "an arc through here to the next point of Enter"),
    ("r", "move this row's point to the arm's position"),
    ("n  P", "name it; pause there"),
    ("G S", "gripper or suction there: unchanged, on, off"),
    ("x  u U", "delete it; undo a change, redo it"),
    ("o O", "play from here; play all (checked first)"),
    ("f", "store on release of the arm's unlock key, or not"),
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
    ("h c  Ctrl-L", "home; clear alarms; redraw the screen"),
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
/// Smallest width of the list, in columns, for long names and rotations.
const MIN_LONG_LINE_WIDTH: u16 = 64;

/// Draws one frame.
pub(super) fn draw(frame: &mut Frame<'_>, model: &Model, theme: Theme) {
    let Model {
        observed,
        pad,
        teach,
    } = model;
    let width = frame.area().width;
    let foot = match &teach.prompt {
        Some(prompt) => message_lines(&prompt.text(), width, theme.note()),
        None => foot(pad, &HINTS, width, theme),
    };
    let [header, middle, footer] = header_body_footer(frame.area(), &foot);
    frame.render_widget(observed.header("teach", header.width, theme), header);
    let left = side_panel(frame, middle, observed, pad, theme);
    list(frame, left, teach, theme);
    frame.render_widget(Paragraph::new(foot), footer);
    if let Some(help) = pad.help {
        help.draw(frame, middle, &KEYS, theme);
    }
}

fn list(frame: &mut Frame<'_>, area: Rect, teach: &TeachPad, theme: Theme) {
    let lesson = &teach.editor.program;
    let star = if lesson.is_saved() { "" } else { "*" };
    let tool = lesson
        .tool
        .map_or_else(String::new, |tool| format!(", {tool}"));
    let follows = match teach.editor.hand_guiding {
        Some(true) => ", by hand too",
        _ => "",
    };
    let count = lesson.steps().len();
    let block = panel(
        format!("{}{star}: {count} rows{tool}{follows}", lesson.title),
        theme,
    );
    let inner = block.inner(area);
    let width = usize::from(inner.width);
    let chosen = lesson.steps().get(lesson.selected());
    let chosen = chosen.map_or_else(Vec::new, |row| {
        full_row(
            row,
            lesson.selected(),
            width,
            area.width >= MIN_LONG_LINE_WIDTH,
        )
    });
    // Rows left for the list beside a begun arc and the additional lines of the selected row.
    let more = chosen.len().saturating_sub(1) + usize::from(lesson.via().is_some());
    let height = usize::from(inner.height).saturating_sub(more);
    let mut lines = Vec::new();
    // Scrolls so that the selected row stays visible with all of its lines.
    let first = (lesson.selected() + 1).saturating_sub(height.max(1));
    for (nth, row) in lesson.steps().iter().enumerate().skip(first).take(height) {
        let texts = if nth == lesson.selected() {
            chosen.clone()
        } else {
            vec![numbered(
                nth,
                &describe(row, area.width >= MIN_LONG_LINE_WIDTH),
            )]
        };
        let plays = teach.editor.playing() == Some(nth);
        let style = match (nth == lesson.selected(), plays) {
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
    if let Some([x, y, z, _]) = lesson.via() {
        let text = format!("    arc through {x:.1} {y:.1} {z:.1} to ...");
        lines.push(Line::styled(text, theme.note()));
    }
    if lesson.steps().is_empty() && lesson.via().is_none() {
        for text in [
            "Move the arm with the arrow keys, w s and a d,",
            "or by hand with its unlock key held;",
            "Enter stores its position.",
        ] {
            lines.push(Line::styled(text, theme.dim()));
        }
    }
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn numbered(nth: usize, text: &str) -> String {
    format!("{:>2} {text}", nth + 1)
}

/// Returns a row with its full name and position, on several lines if necessary.
fn full_row(row: &TeachStep, nth: usize, width: usize, roomy: bool) -> Vec<String> {
    let kept = if roomy { LONG_NAME } else { SHORT_NAME };
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

/// Letters shown of a name, in narrow and in wide lists.
const SHORT_NAME: usize = 7;
const LONG_NAME: usize = 16;

/// Returns a row on one line: name, motion, position, action.
fn describe(row: &TeachStep, roomy: bool) -> String {
    let kept = if roomy { LONG_NAME } else { SHORT_NAME };
    let name: String = row.name.chars().take(kept).collect();
    format!("{name:<kept$} {}", motion(row, roomy))
}

/// Returns motion, position and action of a row.
fn motion(row: &TeachStep, roomy: bool) -> String {
    let way = |by: &Travel| match by {
        Travel::Joints => "MOVJ",
        Travel::Line => "MOVL",
        Travel::Jump => "JUMP",
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    };
    let at = |[a, b, c, d]: [f32; 4]| {
        if roomy {
            format!("{a:>6.1}{b:>7.1}{c:>7.1}{d:>7.1}")
        } else {
            format!("{a:>6.1}{b:>7.1}{c:>7.1}")
        }
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
        Some(other) => match other.command() {
            Some(command) => command.row().set_name.to_owned(),
            None => other.name().to_owned(),
        },
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
pub(super) mod tests;
