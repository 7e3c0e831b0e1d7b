//! The picture: what goes where, at every size.

mod arm;
mod lists;
mod pins;
mod reach;
mod status;
#[cfg(test)]
mod tests;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph};

use super::app::App;
use super::keys::Mode;
use super::look::Look;
use crate::terminal::{self, Theme};

/// Below this a picture of the arm says nothing.
const LEAST: (u16, u16) = (72, 20);
/// From here on there is room for lists beside the pictures.
const WIDE: u16 = 120;

/// What the keys do.
const KEYS: [(&str, &str); 16] = [
    ("q, Ctrl-C", "end: no longer serve the arm"),
    ("space, k", "base key: run the stored program, or stop it"),
    ("K", "base key, held: home the arm"),
    ("u", "hold the unlock key, or release it: teach"),
    ("  arrows", "  guide the tool forward, back, left, right"),
    ("  PgUp PgDn", "  guide the tool up and down"),
    ("  1-4 + -", "  choose a joint and turn it"),
    ("  f", "  steps of 0.5 mm and 0.2 deg, or 5 mm and 2 deg"),
    ("p", "pull the cable, or plug it in"),
    ("r", "reset the controller"),
    ("a", "raise an alarm"),
    ("s", "let a joint slip"),
    ("i", "choose an input and drive it high or low"),
    ("Tab", "the next of several arms"),
    ("Ctrl-L", "draw everything anew"),
    ("", "Alarms are cleared by the host, as on the real arm."),
];

/// What a panel is drawn from.
#[derive(Clone, Copy)]
struct View<'a> {
    app: &'a App,
    look: &'a Look,
    theme: Theme,
}

/// Draws one frame.
pub(super) fn draw(frame: &mut Frame<'_>, app: &App, theme: Theme) {
    let Some(look) = &app.look else {
        return;
    };
    let view = View { app, look, theme };
    let [header, middle, footer] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Fill(1),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    frame.render_widget(view.header(header.width), header);
    if middle.width < LEAST.0 || middle.height < LEAST.1 {
        view.brief(frame, middle);
    } else {
        view.panels(frame, middle);
    }
    frame.render_widget(view.footer(), footer);
    if app.mode == Mode::Help {
        terminal::help(frame, middle, &KEYS, theme);
    }
}

impl View<'_> {
    fn panels(self, frame: &mut Frame<'_>, area: Rect) {
        let wide = area.width >= WIDE;
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

    /// What can be said where there is no room for pictures: the first lines matter most.
    fn brief(self, frame: &mut Frame<'_>, area: Rect) {
        let mut lines = self.pose_lines();
        lines.push(self.queue_line());
        lines.extend(self.alarm_lines(usize::from(area.height)));
        lines.extend(self.tool_lines());
        lines.push(self.line_line());
        let room = usize::from(area.height).saturating_sub(lines.len());
        lines.extend(self.log_lines(room));
        frame.render_widget(Paragraph::new(lines), area);
    }

    /// Which arm, where it is served, and at the right the arm's clock.
    fn header(self, width: u16) -> Paragraph<'static> {
        let app = self.app;
        let mut text = String::from(" ");
        let (number, count) = app.number();
        if count > 1 {
            text.push_str(&format!("{number} of {count}: "));
        }
        text.push_str(&app.subject().title);
        for door in &app.told.doors {
            text.push_str(" | ");
            text.push_str(door);
        }
        let seconds = self.look.state.now / 1_000_000;
        let clock = format!(" {}:{:02} ", seconds / 60, seconds % 60);
        let room = usize::from(width).saturating_sub(clock.len());
        let text: String = text.chars().take(room).collect();
        Paragraph::new(format!("{text:<room$}{clock}")).style(self.theme.bar())
    }

    /// What a key came to; else what the keys do at the moment.
    fn footer(self) -> Paragraph<'static> {
        let app = self.app;
        let keys = |keys: &[(&str, &str)]| terminal::hints(keys, self.theme);
        let line = match (&app.message, &app.mode) {
            (Some(message), _) => Line::styled(format!(" {message}"), self.theme.note()),
            (_, Mode::Help) => keys(&[("any key", "back")]),
            (_, Mode::Ask { question, text }) => Line::from(vec![
                Span::styled(format!(" {}", question.prompt()), self.theme.key()),
                Span::raw(format!("{text}_  ")),
                Span::styled(question.meaning(text), self.theme.dim()),
            ]),
            (_, Mode::Inputs { address, .. }) => {
                let mut line = Line::styled(format!(" input {address} "), self.theme.key());
                line.extend(
                    keys(&[
                        ("digits arrows", "choose"),
                        ("space", "toggle"),
                        ("esc", "back"),
                    ])
                    .spans,
                );
                line
            }
            (_, Mode::Watch) if app.unlocked() => {
                let step = if app.fine { "fine" } else { "coarse" };
                let mut line = keys(&[
                    ("arrows", "x y"),
                    ("pgup/dn", "z"),
                    ("1-4", "joint"),
                    ("+ -", "turn"),
                    ("f", "fine"),
                    ("u", "lock"),
                    ("?", "help"),
                ]);
                line.push_span(Span::styled(
                    format!(" J{} {step}", app.joint),
                    self.theme.note(),
                ));
                line
            }
            (_, Mode::Watch) => {
                let mut all = vec![
                    ("q", "quit"),
                    ("?", "help"),
                    ("k K", "key"),
                    ("u", "unlock"),
                    ("p", "cable"),
                    ("r", "reset"),
                    ("a", "alarm"),
                    ("s", "slip"),
                    ("i", "input"),
                ];
                if app.number().1 > 1 {
                    all.insert(2, ("tab", "next arm"));
                }
                keys(&all)
            }
        };
        Paragraph::new(line)
    }

    /// A frame with a name.
    fn panel(self, title: impl Into<String>) -> Block<'static> {
        terminal::panel(title, self.theme)
    }
}
