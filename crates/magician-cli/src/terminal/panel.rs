//! Frames, lists of keys, and small signs.

use ratatui::Frame;
use ratatui::layout::{Constraint, Flex, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph};

use super::Theme;

/// A frame with a name.
pub(crate) fn panel(title: impl Into<String>, theme: Theme) -> Block<'static> {
    let title = Span::styled(format!(" {} ", title.into()), theme.title());
    Block::bordered()
        .border_type(BorderType::Rounded)
        .border_style(theme.dim())
        .title(title)
}

/// What keys do, on one line.
pub(crate) fn hints(keys: &[(&str, &str)], theme: Theme) -> Line<'static> {
    let mut line = Line::default();
    for (key, what) in keys {
        line.push_span(Span::styled(format!(" {key}"), theme.key()));
        line.push_span(format!(" {what} "));
    }
    line
}

/// The list of all keys, over the middle of what is shown.
pub(crate) fn help(frame: &mut Frame<'_>, area: Rect, keys: &[(&str, &str)], theme: Theme) {
    const LEAST: usize = 68;
    let longest = keys.iter().map(|(_, what)| what.chars().count() + 16);
    let width = longest.max().unwrap_or(0).max(LEAST);
    let width = u16::try_from(width).unwrap_or(u16::MAX).min(area.width);
    let height = u16::try_from(keys.len() + 2).unwrap_or(u16::MAX);
    let [across] = Layout::horizontal([Constraint::Length(width)])
        .flex(Flex::Center)
        .areas(area);
    let [area] = Layout::vertical([Constraint::Length(height.min(area.height))])
        .flex(Flex::Center)
        .areas(across);
    let line = |(key, what): &(&str, &str)| {
        Line::from(vec![
            Span::styled(format!(" {key:<12}"), theme.key()),
            Span::raw((*what).to_owned()),
        ])
    };
    let lines: Vec<_> = keys.iter().map(line).collect();
    let block = Block::bordered()
        .border_type(BorderType::Rounded)
        .title(Span::styled(" keys ", theme.title()));
    frame.render_widget(Clear, area);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// A small sign for on and off.
pub(crate) fn lamp(on: bool) -> &'static str {
    if on { "●" } else { "○" }
}

/// A length or an angle with one place, without a point where nothing follows it.
pub(crate) fn mm(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}
