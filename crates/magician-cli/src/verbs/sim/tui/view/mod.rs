//! Layout of the picture at every size.

mod arm;
mod lists;
mod pins;
mod reach;
mod status;
#[cfg(test)]
pub(super) mod tests;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph};

use super::app::App;
use super::arm_view::ArmView;
use super::keys::Mode;
use crate::terminal::{self, Theme};

/// Smallest size, in columns and rows, for a picture of the arm.
const MIN_PICTURE_SIZE: (u16, u16) = (72, 20);
/// Smallest width, in columns, for lists beside the pictures.
const MIN_WIDE_WIDTH: u16 = 120;

/// Keys and their effects.
const KEYS: [(&str, &str); 17] = [
    ("q, Ctrl-C", "quit: stop serving the arm"),
    ("space, k", "base key: run the stored program, or stop it"),
    ("K", "base key, held: home the arm"),
    ("u", "hold the unlock key, or release it: teach"),
    (
        "  arrows",
        "  guide the tool where they point, seen from above",
    ),
    ("  PgUp PgDn", "  guide the tool up and down"),
    ("  1-4 + -", "  choose a joint and turn it"),
    ("  f", "  steps of 0.5 mm and 0.2 deg, or 5 mm and 2 deg"),
    ("p", "pull the cable, or plug it in"),
    ("r", "reset the controller"),
    ("a", "raise an alarm"),
    ("s", "let a joint slip"),
    ("i", "choose an input and drive it high or low"),
    ("V", "turn the view from above, and the arrows with it"),
    ("Tab", "the next of several arms"),
    ("Ctrl-L", "redraw the screen"),
    ("", "Alarms are cleared by the host, as on the real arm."),
];

/// Data for drawing a panel.
#[derive(Clone, Copy)]
struct View<'a> {
    app: &'a App,
    look: &'a ArmView,
    theme: Theme,
}

/// Draws one frame.
pub(super) fn draw(frame: &mut Frame<'_>, app: &App, theme: Theme) {
    let Some(look) = &app.look else {
        return;
    };
    let view = View { app, look, theme };
    let foot = view.footer(frame.area().width);
    let [header, middle, footer] = terminal::header_body_footer(frame.area(), &foot);
    frame.render_widget(view.header(header.width), header);
    if middle.width < MIN_PICTURE_SIZE.0 || middle.height < MIN_PICTURE_SIZE.1 {
        view.brief(frame, middle);
    } else {
        view.panels(frame, middle);
    }
    frame.render_widget(Paragraph::new(foot), footer);
    if let Mode::Help(help) = app.mode {
        help.draw(frame, middle, &KEYS, theme);
    }
}

impl View<'_> {
    fn panels(self, frame: &mut Frame<'_>, area: Rect) {
        let wide = area.width >= MIN_WIDE_WIDTH;
        let right = if wide { 44 } else { 28 };
        let [left, right] =
            Layout::horizontal([Constraint::Fill(1), Constraint::Length(right)]).areas(area);
        self.pictures_and_lists(frame, left, wide);
        let pins = pins::height(right);
        let [arm, queue, pins] = Layout::vertical([
            Constraint::Fill(1),
            Constraint::Length(5),
            Constraint::Length(pins),
        ])
        .areas(right);
        self.arm(frame, arm);
        self.queue(frame, queue);
        self.pins(frame, pins);
    }

    fn pictures_and_lists(self, frame: &mut Frame<'_>, area: Rect, wide: bool) {
        let pictures = (area.height * 3 / 5).max(12);
        let alarms = if area.height >= 30 { 7 } else { 4 };
        let [pictures, middle, log] = Layout::vertical([
            Constraint::Length(pictures),
            Constraint::Length(alarms),
            Constraint::Fill(1),
        ])
        .areas(area);
        let halves = [Constraint::Fill(1), Constraint::Fill(1)];
        let [above, beside] = Layout::horizontal(halves).areas(pictures);
        self.seen_from_above(frame, above);
        self.seen_from_the_side(frame, beside);
        if wide && !self.look.items.is_empty() {
            let [alarms, items] = Layout::horizontal(halves).areas(middle);
            self.alarms(frame, alarms);
            self.items(frame, items);
        } else {
            self.alarms(frame, middle);
        }
        self.log(frame, log);
    }

    /// Draws text alone where there is no room for pictures, most important lines first.
    fn brief(self, frame: &mut Frame<'_>, area: Rect) {
        let mut lines = self.pose_lines();
        lines.push(self.queue_line());
        let rest = self.tool_lines().into_iter().chain([self.line_line()]);
        let rest: Vec<_> = rest.collect();
        let left = |taken: usize| {
            let taken = u16::try_from(taken).unwrap_or(u16::MAX);
            area.height.saturating_sub(taken)
        };
        let room = left(lines.len() + rest.len());
        let alarms = &self.look.state.alarms;
        lines.extend(terminal::alarm_lines(alarms, area.width, room, self.theme));
        lines.extend(rest);
        lines.extend(self.log_lines(area.width, left(lines.len())));
        frame.render_widget(Paragraph::new(lines), area);
    }

    /// Returns the header: arm, endpoints, and the arm's clock at the right.
    fn header(self, width: u16) -> Paragraph<'static> {
        let app = self.app;
        let (number, count) = app.number();
        let number = match count {
            0 | 1 => String::new(),
            _ => format!("{number} of {count}: "),
        };
        let endpoints = app.feed_state.endpoints.join(" | ");
        let title = &app.subject().title;
        let text = if endpoints.is_empty() {
            format!(" {number}{title}")
        } else {
            format!(" {number}{title} | {endpoints}")
        };
        let seconds = self.look.state.now.as_micros() / 1_000_000;
        let clock = format!(" {}:{:02} ", seconds / 60, seconds % 60);
        let room = usize::from(width).saturating_sub(clock.len());
        // If there is little room, the endpoints matter more than the title.
        let text = if text.chars().count() <= room || endpoints.is_empty() {
            text
        } else {
            format!(" {number}{endpoints}")
        };
        let text: String = text.chars().take(room).collect();
        Paragraph::new(format!("{text:<room$}{clock}")).style(self.theme.bar())
    }

    /// Returns the footer: a message, a question, or the keys of the current mode.
    fn footer(self, width: u16) -> Vec<Line<'static>> {
        let app = self.app;
        let fitted = |keys: &[(&str, &str)], width| terminal::fitted(keys, width, self.theme);
        let line = match (&app.message, &app.mode) {
            (Some(message), _) => {
                return terminal::message_lines(message, width, self.theme.note());
            }
            (_, Mode::Help(_)) => fitted(&[("arrows", "pages"), ("?", "back")], width),
            (_, Mode::Ask { question, text }) => {
                let (asked, meaning) = (question.prompt(), question.meaning(text));
                let text = format!("{asked}{text}_  {meaning}");
                return terminal::message_lines(&text, width, self.theme.key());
            }
            (_, Mode::Inputs { address, .. }) => {
                let mut line = Line::styled(format!(" input {address} "), self.theme.key());
                let keys = [
                    ("digits arrows", "choose"),
                    ("space", "toggle"),
                    ("esc", "back"),
                ];
                line.extend(fitted(&keys, width).spans);
                line
            }
            (_, Mode::Watch) if app.is_unlocked() => {
                let step = if app.fine { "fine" } else { "coarse" };
                let told = format!(" J{} {step}", app.joint);
                let room = u16::try_from(told.len()).unwrap_or(u16::MAX);
                let axes = self.axes();
                let keys = [
                    ("arrows", axes.as_str()),
                    ("pgup/dn", "z"),
                    ("1-4", "joint"),
                    ("+ -", "turn"),
                    ("f", "fine"),
                    ("u", "lock"),
                    ("?", "help"),
                ];
                let mut line = fitted(&keys, width.saturating_sub(room));
                line.push_span(Span::styled(told, self.theme.note()));
                line
            }
            (_, Mode::Watch) => {
                let mut all = vec![
                    ("q", "quit"),
                    ("k K", "key"),
                    ("u", "unlock"),
                    ("p", "cable"),
                    ("r", "reset"),
                    ("a", "alarm"),
                    ("s", "slip"),
                    ("i", "input"),
                    ("?", "help"),
                ];
                if app.number().1 > 1 {
                    all.insert(1, ("tab", "next arm"));
                }
                fitted(&all, width)
            }
        };
        vec![line]
    }

    /// Returns a frame with a title.
    fn panel(self, title: impl Into<String>) -> Block<'static> {
        terminal::panel(title, self.theme)
    }
}
