//! Layout of the full-screen picture of a job.

use std::sync::Arc;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::Line;
use ratatui::widgets::Paragraph;

use super::sheet::Sheet;
use crate::terminal::{Help, ObservedArm, Theme, fitted, panel, wrapped};
use crate::verbs::watch::{Around, alarms_and_log, queue_panel};

/// Everything that is shown.
#[derive(Clone, Debug)]
pub(in super::super) struct Model {
    /// Verb, as the title.
    pub(super) verb: &'static str,
    pub(super) observed: ObservedArm,
    pub(super) around: Around,
    pub(super) sheet: Arc<Sheet>,
    /// Activity in a word, or the keys that can be used.
    pub(in super::super) doing: &'static str,
    /// Completed steps, and their total.
    pub(in super::super) step: u64,
    pub(in super::super) steps: Option<u64>,
    /// Current loop, and the number of loops.
    pub(in super::super) round: u64,
    pub(super) rounds: Option<u64>,
    /// Time left, and the speed unless it is 100 %.
    pub(in super::super) left: Option<String>,
    /// List of keys while it is shown.
    pub(super) help: Option<Help>,
}

impl Model {
    /// Adds a line to the log.
    pub(in super::super) fn note(&mut self, text: &str) {
        self.observed.note(text);
    }
}

pub(super) const KEYS: [(&str, &str); 7] = [
    ("p", "pause, resume"),
    (
        "space, s",
        "stop and lift the pen; a second Ctrl-C does not lift",
    ),
    (
        "+ -",
        "faster, slower by 10 percent, for commands not yet sent",
    ),
    ("Ctrl-C", "stop"),
    ("Ctrl-Z", "pause, and suspend until `fg`"),
    ("?", "this help"),
    ("Ctrl-L", "redraw the screen"),
];
const HINTS: [(&str, &str); 4] = [
    ("p", "pause"),
    ("space", "stop"),
    ("+-", "speed"),
    ("?", "help"),
];
/// Width of the column beside the sheet.
const SIDE_COLUMN_WIDTH: u16 = 31;

/// Draws one frame.
pub(super) fn draw(frame: &mut Frame<'_>, model: &Model, theme: Theme) {
    let [header, middle, footer] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Fill(1),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    let text = model.observed.header(model.verb, header.width, theme);
    frame.render_widget(text, header);
    let [sheet, beside] =
        Layout::horizontal([Constraint::Fill(1), Constraint::Length(SIDE_COLUMN_WIDTH)])
            .areas(middle);
    let tip = model.observed.arm.status.as_ref();
    let tip = tip.map(|status| [status.pose.x, status.pose.y].map(f64::from));
    let done = (model.step, model.steps);
    model.sheet.draw(frame, sheet, done, tip, theme);
    let [job_area, queue_area, rest] = Layout::vertical([
        Constraint::Length(5),
        Constraint::Length(7),
        Constraint::Fill(1),
    ])
    .areas(beside);
    job(frame, job_area, model, theme);
    queue_panel(
        frame,
        queue_area,
        &model.observed,
        model.around,
        true,
        theme,
    );
    alarms_and_log(frame, rest, &model.observed, theme);
    let keys = fitted(&HINTS, footer.width, theme);
    frame.render_widget(Paragraph::new(keys), footer);
    if let Some(help) = model.help {
        help.draw(frame, middle, &KEYS, theme);
    }
}

fn job(frame: &mut Frame<'_>, area: Rect, model: &Model, theme: Theme) {
    let of = |all: Option<u64>| all.map_or_else(String::new, |all| format!(" of {all}"));
    let mut step = format!("step {}{}", model.step, of(model.steps));
    if model.rounds != Some(1) {
        step.push_str(&format!(", loop {}{}", model.round, of(model.rounds)));
    }
    let block = panel(model.doing, theme);
    let width = usize::from(block.inner(area).width);
    let mut lines = wrapped(&step, width);
    lines.extend(model.left.clone());
    let lines: Vec<Line<'_>> = lines.into_iter().map(Line::from).collect();
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

#[cfg(test)]
pub(in super::super) mod tests;
