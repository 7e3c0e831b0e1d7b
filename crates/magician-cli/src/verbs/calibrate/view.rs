//! Screen of a calibration in the terminal: the points to touch at the left, the arm at the right.

use magician_motion::TopView;
use magician_program::Diagnostic;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::answer::{TOUCHED_BY, lines as found_lines};
use super::session::{Model, Touched};
use super::sketch::sketch;
use super::subject::{CalibrationResult, Subject};
use crate::terminal::{Theme, header_body_footer, panel, wrapped};
use crate::verbs::jog::{MOVES, foot, side_panel};
use crate::voice::Command;

const KEYS: [(&str, &str); 12] = [
    (
        "Enter",
        "take the point at the arm's position; at the end: save, for drawings",
    ),
    ("Backspace", "undo the last point"),
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
    ("q Ctrl-C", "quit without saving"),
    ("Ctrl-L", "redraw the screen"),
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
    let Model {
        observed,
        pad,
        touched,
    } = model;
    let hints: &[(&str, &str)] = match touched.result {
        Some(Ok(_)) => &SAVE,
        _ => &TOUCH,
    };
    let foot = foot(pad, hints, frame.area().width, theme);
    let [header, middle, footer] = header_body_footer(frame.area(), &foot);
    let program = format!("calibrate {}", touched.subject.name());
    frame.render_widget(observed.header(&program, header.width, theme), header);
    let left = side_panel(frame, middle, observed, pad, theme);
    task_panel(frame, left, touched, pad.view, theme);
    frame.render_widget(Paragraph::new(foot), footer);
    if let Some(help) = pad.help {
        help.draw(frame, middle, &KEYS, theme);
    }
}

fn task_panel(frame: &mut Frame<'_>, area: Rect, touched: &Touched, view: TopView, theme: Theme) {
    let block = panel(format!("touch with the tool {}", touched.tool), theme);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let point_lines = point_lines(touched, theme);
    let rows = u16::try_from(point_lines.len()).unwrap_or(u16::MAX);
    // The list of points keeps its rows; the text above is cut first.
    let room = inner.height.saturating_sub(rows).min(MAX_CONTENT_ROWS);
    let [above, list] =
        Layout::vertical([Constraint::Length(room), Constraint::Length(rows)]).areas(inner);
    match &touched.result {
        None => instruction_panel(frame, above, touched, view, theme),
        Some(result) => {
            let lines = result_lines(result, touched, above.width, theme);
            frame.render_widget(Paragraph::new(lines), above);
        }
    }
    frame.render_widget(Paragraph::new(point_lines), list);
}

/// Draws the instruction with the sketch below it, or beside it if only that fits, or else the
/// instruction alone.
fn instruction_panel(
    frame: &mut Frame<'_>,
    area: Rect,
    touched: &Touched,
    view: TopView,
    theme: Theme,
) {
    let instruction = |width: u16| -> Vec<Line<'static>> {
        let lines = wrapped(touched.subject.instruction(), width.into());
        lines.into_iter().map(Line::raw).collect()
    };
    let rows = |lines: &[Line<'_>]| u16::try_from(lines.len()).unwrap_or(u16::MAX);
    let sketch = sketch(touched, view, theme);
    let sketch_width = sketch.iter().map(Line::width).max().unwrap_or(0);
    let sketch_width = u16::try_from(sketch_width)
        .unwrap_or(u16::MAX)
        .saturating_add(2);
    let below = instruction(area.width);
    let total_rows = rows(&below).saturating_add(rows(&sketch));
    if total_rows <= area.height && sketch_width <= area.width {
        let [top, _, bottom] = Layout::vertical([
            Constraint::Length(rows(&below)),
            Constraint::Length((area.height - total_rows).min(1)),
            Constraint::Fill(1),
        ])
        .areas(area);
        frame.render_widget(Paragraph::new(below), top);
        frame.render_widget(Paragraph::new(sketch), bottom);
        return;
    }
    let [left, right] =
        Layout::horizontal([Constraint::Length(sketch_width), Constraint::Fill(1)]).areas(area);
    let beside = instruction(right.width);
    if right.width > 0 && rows(&beside).max(rows(&sketch)) <= area.height {
        frame.render_widget(Paragraph::new(sketch), left);
        frame.render_widget(Paragraph::new(beside), right);
        return;
    }
    frame.render_widget(Paragraph::new(below), area);
}

/// Returns the lines that show the result, or the problem with the touched points.
fn result_lines(
    result: &Result<CalibrationResult, Diagnostic>,
    touched: &Touched,
    width: u16,
    theme: Theme,
) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    let styled_lines = |text: &str, style: Style| -> Vec<Line<'static>> {
        let text = wrapped(text, width.into()).into_iter();
        text.map(|text| Line::styled(text, style)).collect()
    };
    match result {
        Ok(found) => {
            // The title names the tool already.
            let found = found_lines(found, touched.tool).into_iter();
            for [name, value] in found.filter(|[name, _]| name != TOUCHED_BY) {
                let values = wrapped(&value, usize::from(width).saturating_sub(LABEL_WIDTH));
                lines.extend(values.into_iter().enumerate().map(|(nth, value)| {
                    let name = if nth == 0 { name.as_str() } else { "" };
                    Line::from(vec![
                        Span::styled(format!("{name:<LABEL_WIDTH$}"), theme.dim()),
                        Span::raw(value),
                    ])
                }));
            }
        }
        Err(problem) => {
            lines.extend(styled_lines(&problem.message, theme.bad()));
            let advice = problem.advice(&Command).into_iter();
            lines.extend(advice.flat_map(|advice| styled_lines(&advice, Style::new())));
            lines.extend(styled_lines(
                "Backspace undoes the last point.",
                theme.note(),
            ));
        }
    }
    lines
}

/// Largest number of rows above the list of points: the height of the tallest content.
const MAX_CONTENT_ROWS: u16 = 12;
/// Columns of the labels of results.
const LABEL_WIDTH: usize = 11;

/// Returns the list of points: taken ones with their values, and the next one.
fn point_lines(touched: &Touched, theme: Theme) -> Vec<Line<'static>> {
    let row = |(nth, name): (usize, &&str)| {
        let (symbol, style) = point_symbol(touched, nth, theme);
        let position = touched.touches.get(nth).map(|touch| touch.pose);
        let position = match (position, touched.subject) {
            (Some([x, y, _, r]), Subject::Tool) => format!("x{x:8.2} y{y:8.2} r{r:8.2}"),
            (Some([x, y, z, _]), _) => format!("x{x:8.2} y{y:8.2} z{z:8.2}"),
            (None, _) if nth == touched.touches.len() => "next".to_owned(),
            (None, _) => String::new(),
        };
        Line::from(vec![
            Span::styled(format!("{symbol} {} {name:<12} ", nth + 1), style),
            Span::raw(position),
        ])
    };
    let names = touched.subject.points().iter();
    names.enumerate().map(row).collect()
}

/// Returns symbol and style of a point: taken, next, or later.
pub(super) fn point_symbol(touched: &Touched, nth: usize, theme: Theme) -> (&'static str, Style) {
    match nth.cmp(&touched.touches.len()) {
        std::cmp::Ordering::Less => ("●", theme.good()),
        std::cmp::Ordering::Equal => ("▶", theme.key()),
        std::cmp::Ordering::Greater => ("○", theme.dim()),
    }
}

#[cfg(test)]
pub(super) mod tests;
