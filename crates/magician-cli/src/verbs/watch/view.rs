//! Layout of a watched arm.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::readings::Around;
use crate::terminal::{Help, ObservedArm, Theme, fitted, lamp, panel, sparkline};
use crate::verbs::io::{self, PIN_COUNT, Pin};
use crate::verbs::jog::{
    COMPACT_ROWS, alarm_panel, compact_panel, joint_bars, log_panel, tool_lines,
};

/// Everything that is shown.
#[derive(Clone, Debug)]
pub(super) struct Model {
    pub(super) observed: ObservedArm,
    pub(super) around: Around,
    /// Pins in order of their address; `None` if not read yet.
    pub(super) pins: Vec<Option<Pin>>,
    /// List of keys while it is shown.
    pub(super) help: Option<Help>,
}

impl Model {
    pub(super) fn new(observed: ObservedArm) -> Self {
        Self {
            observed,
            around: Around::default(),
            pins: vec![None; PIN_COUNT.into()],
            help: None,
        }
    }

    /// Stores the reading of a pin.
    pub(super) fn note(&mut self, pin: Pin) {
        let place = usize::from(pin.address).checked_sub(1);
        if let Some(known) = place.and_then(|place| self.pins.get_mut(place)) {
            *known = Some(pin);
        }
    }
}

const KEYS: [(&str, &str); 7] = [
    ("q, Ctrl-C", "quit; the arm is not stopped"),
    ("?", "this help"),
    ("Ctrl-L", "redraw the screen"),
    ("", "Nothing here moves or changes anything."),
    (
        "io",
        "o output, w pulses, i input, a analog; a lamp for what is on",
    ),
    (
        "speeds",
        "from reading to reading; each row scaled to its maximum",
    ),
    ("2-3", "J2 - J3, which the parallelogram limits"),
];
const HINTS: [(&str, &str); 2] = [("q", "quit"), ("?", "help")];
/// Smallest width, in columns, for the pins as a list.
const MIN_WIDE_WIDTH: u16 = 120;
/// Smallest height, in rows, for joints with bars and separate panels for alarms and log.
const MIN_BARS_HEIGHT: u16 = 24;

/// Draws one frame.
pub(super) fn draw(frame: &mut Frame<'_>, model: &Model, theme: Theme) {
    let [header, middle, footer] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Fill(1),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    let header_text = model.observed.header("watch", header.width, theme);
    frame.render_widget(header_text, header);
    if middle.width >= MIN_WIDE_WIDTH && middle.height >= u16::from(PIN_COUNT) + 2 {
        wide(frame, middle, model, theme);
    } else if frame.area().height < MIN_BARS_HEIGHT {
        small(frame, middle, model, theme);
    } else {
        narrow(frame, middle, model, theme);
    }
    let keys = fitted(&HINTS, footer.width, theme);
    frame.render_widget(Paragraph::new(keys), footer);
    if let Some(help) = model.help {
        help.draw(frame, middle, &KEYS, theme);
    }
}

fn narrow(frame: &mut Frame<'_>, area: Rect, model: &Model, theme: Theme) {
    let columns = Layout::horizontal([Constraint::Length(29), Constraint::Fill(1)]);
    let [first, second, third] = Layout::vertical([
        Constraint::Length(7),
        Constraint::Length(7),
        Constraint::Fill(1),
    ])
    .areas(area);
    let [pose_area, joints] = columns.areas(first);
    let [queue_area, speeds_area] = columns.areas(second);
    let [pins_area, rest] = columns.areas(third);
    pose(frame, pose_area, model, theme);
    joint_bars(frame, joints, &model.observed, theme);
    queue_panel(
        frame,
        queue_area,
        &model.observed,
        model.around,
        true,
        theme,
    );
    speeds(frame, speeds_area, model, theme);
    lamps(frame, pins_area, model, theme);
    let [alarms, log] = Layout::vertical([Constraint::Length(5), Constraint::Fill(1)]).areas(rest);
    alarm_panel(frame, alarms, &model.observed, theme);
    log_panel(frame, log, &model.observed, theme);
}

fn small(frame: &mut Frame<'_>, area: Rect, model: &Model, theme: Theme) {
    let columns = Layout::horizontal([Constraint::Length(29), Constraint::Fill(1)]);
    let [first, second, rest] = Layout::vertical([
        Constraint::Length(COMPACT_ROWS),
        Constraint::Length(7),
        Constraint::Fill(1),
    ])
    .areas(area);
    let [place, speeds_area] = columns.areas(first);
    let [queue_area, pins_area] = columns.areas(second);
    compact_panel(
        frame,
        place,
        pose_title(model),
        &model.observed,
        None,
        theme,
    );
    speeds(frame, speeds_area, model, theme);
    queue_panel(
        frame,
        queue_area,
        &model.observed,
        model.around,
        true,
        theme,
    );
    lamps(frame, pins_area, model, theme);
    alarms_and_log(frame, rest, &model.observed, theme);
}

/// Draws alarms and log in one panel.
pub(in crate::verbs) fn alarms_and_log(
    frame: &mut Frame<'_>,
    area: Rect,
    observed: &ObservedArm,
    theme: Theme,
) {
    let block = panel("alarms, log", theme);
    let inner = block.inner(area);
    let alarms = inner.height.saturating_sub(1).max(1);
    let mut lines = observed.alarm_lines(inner.width, alarms, theme);
    let left = usize::from(inner.height).saturating_sub(lines.len());
    let left = u16::try_from(left).unwrap_or_default();
    lines.extend(observed.log_lines(inner.width, left, theme));
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn wide(frame: &mut Frame<'_>, area: Rect, model: &Model, theme: Theme) {
    let [left, right] =
        Layout::horizontal([Constraint::Fill(1), Constraint::Length(48)]).areas(area);
    let columns = Layout::horizontal([Constraint::Length(29), Constraint::Fill(1)]);
    let [first, second, alarms, log] = Layout::vertical([
        Constraint::Length(7),
        Constraint::Length(7),
        Constraint::Length(6),
        Constraint::Fill(1),
    ])
    .areas(left);
    let [pose_area, joints] = columns.areas(first);
    let [queue_area, speeds_area] = columns.areas(second);
    pose(frame, pose_area, model, theme);
    joint_bars(frame, joints, &model.observed, theme);
    queue_panel(
        frame,
        queue_area,
        &model.observed,
        model.around,
        false,
        theme,
    );
    speeds(frame, speeds_area, model, theme);
    alarm_panel(frame, alarms, &model.observed, theme);
    log_panel(frame, log, &model.observed, theme);
    let [pins, line] = Layout::vertical([
        Constraint::Length(u16::from(PIN_COUNT) + 2),
        Constraint::Fill(1),
    ])
    .areas(right);
    list(frame, pins, model, theme);
    let text = Paragraph::new(line_lines(model.around)).block(panel("line", theme));
    frame.render_widget(text, line);
}

fn pose(frame: &mut Frame<'_>, area: Rect, model: &Model, theme: Theme) {
    let mut lines = Vec::new();
    if let Some(status) = &model.observed.arm.status {
        let p = &status.pose;
        let rows = [
            ("x", p.x, "mm"),
            ("y", p.y, "mm"),
            ("z", p.z, "mm"),
            ("r", p.r, "deg"),
        ];
        for (name, value, unit) in rows {
            lines.push(Line::from(format!("{name:<2}{value:>9.2} {unit}")));
        }
    }
    if let Some(rail) = model.observed.arm.rail {
        lines.push(Line::from(format!("l {rail:>9.2} mm")));
    }
    let block = panel(pose_title(model), theme);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn pose_title(model: &Model) -> &'static str {
    if model.observed.arm.is_at_rest() {
        "tool stands"
    } else if model.observed.arm.is_answering() {
        "tool moves"
    } else {
        "tool when last seen"
    }
}

/// Draws queue and tools and, if `with_line` is set, the counters of the connection.
pub(in crate::verbs) fn queue_panel(
    frame: &mut Frame<'_>,
    area: Rect,
    observed: &ObservedArm,
    around: Around,
    with_line: bool,
    theme: Theme,
) {
    let block = panel("queue and tools", theme);
    let width = usize::from(block.inner(area).width);
    let mut lines = Vec::new();
    if let Some(status) = &observed.arm.status {
        let places = observed.queue_capacity.max(1);
        let taken = places.saturating_sub(status.left_space);
        let figures = format!(" {taken}/{places}, done {}", status.current.0);
        let bar = width.saturating_sub(figures.len());
        let full = (bar * taken as usize).div_ceil(places as usize).min(bar);
        lines.push(Line::from(vec![
            Span::styled("█".repeat(full), theme.good()),
            Span::styled("░".repeat(bar - full), theme.dim()),
            Span::raw(figures),
        ]));
    }
    lines.extend(tool_lines(around.tools, block.inner(area).width, theme));
    if with_line {
        lines.extend(line_lines(around));
    }
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// Returns the counters of the connection.
fn line_lines(around: Around) -> Vec<Line<'static>> {
    let stats = around.stats;
    vec![
        Line::from(format!("sent {}, again {}", stats.sent, stats.resent)),
        Line::from(format!("late {}, noise {}", stats.late, stats.noise)),
    ]
}

fn speeds(frame: &mut Frame<'_>, area: Rect, model: &Model, theme: Theme) {
    let block = panel("speeds", theme);
    let width = usize::from(block.inner(area).width).saturating_sub(19);
    let observed = &model.observed;
    let now = observed.arm.speed();
    let tool: Vec<f64> = observed
        .arm
        .speeds
        .iter()
        .map(|speeds| speeds.tool)
        .collect();
    let mut lines = vec![row("tool", now.tool, "mm/s", &tool, width, theme)];
    for (nth, name) in ["J1", "J2", "J3", "J4"].into_iter().enumerate() {
        let joint: Vec<f64> = observed
            .arm
            .speeds
            .iter()
            .map(|speeds| speeds.joints[nth])
            .collect();
        lines.push(row(name, now.joints[nth], "deg/s", &joint, width, theme));
    }
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn row(
    name: &str,
    now: f64,
    unit: &str,
    values: &[f64],
    width: usize,
    theme: Theme,
) -> Line<'static> {
    Line::from(vec![
        Span::raw(format!("{name:<4} {now:>6.1} {unit:<6} ")),
        sparkline(values, width, 1.0, theme.good()),
    ])
}

/// Draws the pins as lamps, five in a row.
fn lamps(frame: &mut Frame<'_>, area: Rect, model: &Model, theme: Theme) {
    let lines: Vec<Line<'static>> = model
        .pins
        .chunks(5)
        .zip(0..)
        .map(|(pins, row)| {
            let cells = pins.iter().zip(1 + row * 5..);
            let cell = |(pin, address): (&Option<Pin>, i32)| {
                let letter = pin.as_ref().map_or(' ', Pin::letter);
                let lit = pin.as_ref().is_some_and(Pin::is_on);
                let text = format!("{address:>2}{letter}{} ", lamp(lit));
                Span::styled(text, shade(pin.as_ref(), theme))
            };
            cells.map(cell).collect()
        })
        .collect();
    frame.render_widget(Paragraph::new(lines).block(panel("io", theme)), area);
}

/// Draws the pins as text, one per row.
fn list(frame: &mut Frame<'_>, area: Rect, model: &Model, theme: Theme) {
    let lines = model.pins.iter().zip(1..).map(|(pin, address): (_, u8)| {
        let text = match pin {
            Some(pin) => {
                let function = pin.function().unwrap_or_default();
                format!("{} {function:<23} {}", lamp(pin.is_on()), io::state(pin))
            }
            None => "? not read yet".to_owned(),
        };
        let text = format!("{address:>2} {text}");
        Line::styled(text, shade(pin.as_ref(), theme))
    });
    let lines: Vec<_> = lines.collect();
    frame.render_widget(Paragraph::new(lines).block(panel("io", theme)), area);
}

fn shade(pin: Option<&Pin>, theme: Theme) -> Style {
    match pin {
        Some(pin) if pin.is_on() => theme.good(),
        Some(pin) if pin.has_function() => Style::new(),
        _ => theme.dim(),
    }
}

#[cfg(test)]
pub(super) mod tests;
