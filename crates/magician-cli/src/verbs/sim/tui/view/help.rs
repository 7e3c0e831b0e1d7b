//! The list of keys.

use ratatui::Frame;
use ratatui::layout::{Constraint, Flex, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph};

use crate::verbs::sim::tui::theme::Theme;

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
const WIDTH: u16 = 68;

pub(super) fn draw(frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let height = u16::try_from(KEYS.len() + 2).unwrap_or(u16::MAX);
    let [across] = Layout::horizontal([Constraint::Length(WIDTH.min(area.width))])
        .flex(Flex::Center)
        .areas(area);
    let [area] = Layout::vertical([Constraint::Length(height.min(area.height))])
        .flex(Flex::Center)
        .areas(across);
    let lines = KEYS.map(|(key, what)| {
        Line::from(vec![
            Span::styled(format!(" {key:<12}"), theme.key()),
            Span::raw(what),
        ])
    });
    let block = Block::bordered()
        .border_type(BorderType::Rounded)
        .title(Span::styled(" keys ", theme.title()));
    frame.render_widget(Clear, area);
    frame.render_widget(Paragraph::new(lines.to_vec()).block(block), area);
}
