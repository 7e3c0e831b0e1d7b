//! How touching looks: what to touch at the left, the arm at the right.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use super::answer::lines as found_lines;
use super::session::{Model, Touched};
use super::subject::Subject;
use crate::terminal::{Theme, help, panel};
use crate::verbs::jog::{MOVES, at_the_right, foot, thirds};

const KEYS: [(&str, &str); 12] = [
    (
        "Enter",
        "take the point where the arm stands; in the end: save",
    ),
    ("Backspace", "take the last point back"),
    MOVES[0],
    MOVES[1],
    MOVES[2],
    MOVES[3],
    MOVES[4],
    MOVES[5],
    (
        "m  + -  . ,",
        "hold or step; length of steps; faster, slower",
    ),
    ("h  c", "home; clear alarms"),
    ("q Ctrl-C", "leave, and save nothing"),
    ("Ctrl-L", "draw everything anew"),
];
const TOUCH: [(&str, &str); 6] = [
    ("Enter", "take the point"),
    ("Bksp", "back"),
    ("q", "quit"),
    ("m", "hold/step"),
    ("+ -", "step"),
    ("?", "all keys"),
];
const SAVE: [(&str, &str); 3] = [
    ("Enter", "save it"),
    ("Bksp", "touch the last one again"),
    ("q", "quit without saving"),
];
/// Draws one frame.
pub(super) fn draw(frame: &mut Frame<'_>, model: &Model, theme: Theme) {
    let Model { seen, pad, touched } = model;
    let hints: &[(&str, &str)] = match touched.result {
        Some(Ok(_)) => &SAVE,
        _ => &TOUCH,
    };
    let foot = foot(pad, hints, frame.area().width, theme);
    let [header, middle, footer] = thirds(frame.area(), &foot);
    let program = format!("calibrate {}", touched.subject.name());
    frame.render_widget(seen.header(&program, header.width, theme), header);
    let left = at_the_right(frame, middle, seen, pad, theme);
    task(frame, left, touched, theme);
    frame.render_widget(Paragraph::new(foot), footer);
    if pad.help {
        help(frame, middle, &KEYS, theme);
    }
}

fn task(frame: &mut Frame<'_>, area: Rect, touched: &Touched, theme: Theme) {
    let mut lines = Vec::new();
    match &touched.result {
        None => {
            lines.push(Line::raw(touched.subject.instruction()));
            lines.push(Line::default());
            lines.extend(sketch(touched, theme));
        }
        Some(Ok(found)) => {
            for [name, value] in found_lines(found, touched.tool) {
                lines.push(Line::from(vec![
                    Span::styled(format!("{name:<11}"), theme.dim()),
                    Span::raw(value),
                ]));
            }
            lines.push(Line::default());
            lines.push(Line::styled(
                "Enter saves it: drawings then use it.",
                theme.note(),
            ));
        }
        Some(Err(problem)) => {
            lines.push(Line::styled(problem.message.clone(), theme.bad()));
            if let Some(help) = &problem.help {
                lines.push(Line::raw(help.clone()));
            }
            lines.push(Line::styled(
                "Backspace takes the last point back.",
                theme.note(),
            ));
        }
    }
    lines.push(Line::default());
    lines.extend(points(touched, theme));
    let title = format!("touch with the tool {}", touched.tool);
    let text = Paragraph::new(lines).wrap(Wrap { trim: false });
    frame.render_widget(text.block(panel(title, theme)), area);
}

/// The points: what was taken, and which is next.
fn points(touched: &Touched, theme: Theme) -> Vec<Line<'static>> {
    let row = |(nth, name): (usize, &&str)| {
        let (sign, style) = sign(touched, nth, theme);
        let place = touched.touches.get(nth).map(|touch| touch.pose);
        let place = match (place, touched.subject) {
            (Some([x, y, _, r]), Subject::Tool) => format!("x{x:8.2} y{y:8.2} r{r:8.2}"),
            (Some([x, y, z, _]), _) => format!("x{x:8.2} y{y:8.2} z{z:8.2}"),
            (None, _) if nth == touched.touches.len() => "next".to_owned(),
            (None, _) => String::new(),
        };
        Line::from(vec![
            Span::styled(format!("{sign} {} {name:<12} ", nth + 1), style),
            Span::raw(place),
        ])
    };
    let names = touched.subject.points().iter();
    names.enumerate().map(row).collect()
}

/// How a point is shown: taken, next, or later.
fn sign(touched: &Touched, nth: usize, theme: Theme) -> (&'static str, Style) {
    match nth.cmp(&touched.touches.len()) {
        std::cmp::Ordering::Less => ("●", theme.good()),
        std::cmp::Ordering::Equal => ("▶", theme.key()),
        std::cmp::Ordering::Greater => ("○", theme.dim()),
    }
}

/// The paper as it lies before the arm, its corners numbered.
fn sketch(touched: &Touched, theme: Theme) -> Vec<Line<'static>> {
    let corner = |nth: usize| {
        let (sign, style) = sign(touched, nth, theme);
        Span::styled(format!("{} {sign}", nth + 1), style)
    };
    let edge = || Span::styled("────────────────", theme.dim());
    let side = |text: &str| Line::from(Span::styled(text.to_owned(), theme.dim()));
    match touched.subject {
        Subject::Sheet => vec![
            Line::from(vec![
                Span::raw("       "),
                corner(2),
                edge(),
                Span::styled("┐", theme.dim()),
            ]),
            side("         │                │    Y"),
            side(" ┌───┐   │     paper      │    ▲"),
            side(" │arm│   │                │    │"),
            side(" └───┘   │                │    └──▶ X"),
            Line::from(vec![
                Span::raw("       "),
                corner(0),
                edge(),
                flipped(corner(1)),
            ]),
        ],
        Subject::Surface => vec![
            side("            │ tool"),
            side("            ▼"),
            side("   ─────────┴───────── paper or table"),
        ],
        Subject::Tool => vec![
            side("     │              │"),
            side("     └─┐          ┌─┘   turned by J4"),
            side("       ▼          ▼"),
            side("   ────+──────────+──── the same mark"),
        ],
    }
}

/// The sign before the number.
fn flipped(corner: Span<'static>) -> Span<'static> {
    let text: Vec<&str> = corner.content.split(' ').collect();
    let text = text.into_iter().rev().collect::<Vec<_>>().join(" ");
    Span::styled(text, corner.style)
}

#[cfg(test)]
mod tests {
    use magician_program::Tool;

    use super::super::subject::Touch;
    use super::*;
    use crate::terminal::Seen;
    use crate::terminal::test::{screen, shows, status};
    use crate::verbs::jog::{Pad, Tools};

    fn model(subject: Subject, touches: &[[f64; 4]]) -> Model {
        let mut seen = Seen::new("sim".to_owned(), 32);
        seen.see(status());
        let mut touched = Touched::new(subject, Tool::Pen);
        for pose in touches {
            touched.take(Touch { pose: *pose });
        }
        Model {
            seen,
            pad: Pad::new(50.0, Tools::default(), false),
            touched,
        }
    }

    fn drawn(model: &Model, width: u16, height: u16) -> Vec<String> {
        screen(width, height, |frame| draw(frame, model, Theme::PLAIN))
    }

    #[test]
    fn the_sketch_says_which_corner_is_next() {
        for (width, height) in [(80, 24), (200, 50)] {
            let model = model(Subject::Sheet, &[[180.0, -60.0, -61.0, 0.0]]);
            let screen = drawn(&model, width, height);
            shows(
                &screen,
                &["touch with the tool pen", "1 ●────", "▶ 2", "3 ○"],
            );
            shows(
                &screen,
                &["x  180.00 y  -60.00 z  -61.00", "Enter take the point"],
            );
        }
    }

    #[test]
    fn what_was_found_is_shown_before_it_is_saved() {
        let touches = [
            [150.0, -105.0, -61.0, 0.0],
            [447.0, -105.0, -61.0, 0.0],
            [150.0, 105.6, -61.0, 0.0],
        ];
        let screen = drawn(&model(Subject::Sheet, &touches), 80, 24);
        shows(
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
        shows(
            &screen,
            &[
                "the surface is tilted by 41.2 deg",
                "Backspace takes the last point back",
            ],
        );
    }

    #[test]
    fn a_tool_is_touched_twice() {
        let screen = drawn(&model(Subject::Tool, &[[230.0, 40.0, -60.0, 10.0]]), 80, 24);
        shows(
            &screen,
            &["turned by J4", "● 1 the point", "r   10.00", "▶ 2 turned"],
        );
    }
}
