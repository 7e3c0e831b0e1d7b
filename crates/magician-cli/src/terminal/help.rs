//! List of all keys, shown over the picture.

use ratatui::Frame;
use ratatui::crossterm::event::KeyCode;
use ratatui::layout::{Constraint, Flex, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType, Clear, Paragraph};

use super::{Theme, wrapped};

/// Width of the column with the keys.
const KEY_COLUMN_WIDTH: usize = 13;
/// Smallest width of the list where the screen has room.
const MIN_WIDTH: usize = 68;

/// List of keys while it is shown, one page at a time if the screen is too small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Help {
    /// Page relative to the first; may be negative, since the number of pages depends on the screen
    /// and is applied as a modulus.
    page: isize,
}

impl Help {
    /// Returns the list after a key, or `None` if the key closes it.
    pub(crate) fn after(self, code: KeyCode) -> Option<Self> {
        let by = match code {
            KeyCode::Down | KeyCode::Right | KeyCode::PageDown => 1,
            KeyCode::Up | KeyCode::Left | KeyCode::PageUp => -1,
            _ => return None,
        };
        let page = self.page.wrapping_add(by);
        Some(Self { page })
    }

    /// Draws the list over the middle of an area.
    pub(crate) fn draw(
        self,
        frame: &mut Frame<'_>,
        area: Rect,
        keys: &[(&str, &str)],
        theme: Theme,
    ) {
        let longest = keys.iter().map(|(_, what)| what.chars().count() + 16);
        let width = longest.max().unwrap_or(0).max(MIN_WIDTH);
        let width = u16::try_from(width).unwrap_or(u16::MAX).min(area.width);
        let room = usize::from(width).saturating_sub(2 + KEY_COLUMN_WIDTH);
        let height = usize::from(area.height).saturating_sub(2).max(1);
        let pages = pages(keys, room, height, theme);
        let count = isize::try_from(pages.len()).unwrap_or(isize::MAX).max(1);
        let shown = self.page.rem_euclid(count);
        let foot = match count {
            1 => " ? closes ".to_owned(),
            _ => format!(
                " page {} of {count}: arrows turn pages, ? closes ",
                shown + 1
            ),
        };
        let lines = pages
            .into_iter()
            .nth(shown.unsigned_abs())
            .unwrap_or_default();
        let height = u16::try_from(lines.len() + 2).unwrap_or(u16::MAX);
        let [across] = Layout::horizontal([Constraint::Length(width)])
            .flex(Flex::Center)
            .areas(area);
        let [area] = Layout::vertical([Constraint::Length(height.min(area.height))])
            .flex(Flex::Center)
            .areas(across);
        let block = Block::bordered()
            .border_type(BorderType::Rounded)
            .title(Span::styled(" keys ", theme.title()))
            .title_bottom(Span::styled(foot, theme.dim()));
        frame.render_widget(Clear, area);
        frame.render_widget(Paragraph::new(lines).block(block), area);
    }
}

/// Splits the list into pages. A description is never split between two pages.
fn pages(
    keys: &[(&str, &str)],
    room: usize,
    height: usize,
    theme: Theme,
) -> Vec<Vec<Line<'static>>> {
    let mut pages: Vec<Vec<Line<'static>>> = vec![Vec::new()];
    for (key, what) in keys {
        let lines = key_lines(key, what, room, theme);
        match pages.last_mut() {
            Some(page) if page.is_empty() || page.len() + lines.len() <= height => {
                page.extend(lines);
            }
            _ => pages.push(lines),
        }
    }
    pages
}

/// Returns a key and its description, wrapped.
fn key_lines(key: &str, what: &str, room: usize, theme: Theme) -> Vec<Line<'static>> {
    let lines = wrapped(what, room).into_iter().enumerate();
    let line = |(nth, text)| {
        let key = if nth == 0 { key } else { "" };
        let key = format!(" {key:<width$}", width = KEY_COLUMN_WIDTH - 1);
        Line::from(vec![Span::styled(key, theme.key()), Span::raw(text)])
    };
    lines.map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terminal::test::{assert_shows, screen};

    #[test]
    fn arrows_cycle_through_pages_and_other_keys_close() {
        let keys: Vec<_> = (0..9).map(|_| ("key", "what it does")).collect();
        let drawn = |help: Help, height| {
            screen(60, height, |frame| {
                help.draw(frame, frame.area(), &keys, Theme::PLAIN);
            })
        };
        let first = Help::default();
        assert_shows(&drawn(first, 12), &["? closes"]);
        assert_shows(&drawn(first, 7), &["page 1 of 2: arrows turn pages"]);
        let second = first.after(KeyCode::Down).unwrap();
        assert_shows(&drawn(second, 7), &["page 2 of 2"]);
        assert_eq!(
            drawn(first.after(KeyCode::Up).unwrap(), 7),
            drawn(second, 7)
        );
        assert_shows(
            &drawn(second.after(KeyCode::PageDown).unwrap(), 7),
            &["1 of"],
        );
        assert_eq!(second.after(KeyCode::Esc), None);
        assert_eq!(second.after(KeyCode::Char('?')), None);
    }
}
