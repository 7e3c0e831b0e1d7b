//! Widgets: panels, lines of keys, wrapped text and symbols.

use magician_motion::TopView;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType};

use super::Theme;

/// Returns a frame with a title.
pub(crate) fn panel(title: impl Into<String>, theme: Theme) -> Block<'static> {
    let title = Span::styled(format!(" {} ", title.into()), theme.title());
    Block::bordered()
        .border_type(BorderType::Rounded)
        .border_style(theme.dim())
        .title(title)
}

/// Returns a line of key hints that fits this width. The last hint always stays: it is the key for
/// the full list.
pub(crate) fn fitted(keys: &[(&str, &str)], width: u16, theme: Theme) -> Line<'static> {
    let mut shown = keys.to_vec();
    let mut line = hints(&shown, theme);
    while line.width() > usize::from(width) && shown.len() > 1 {
        shown.remove(shown.len() - 2);
        line = hints(&shown, theme);
    }
    line
}

/// Wraps text to this width; a longer word is split.
pub(crate) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let wide = |text: &str| Span::raw(text).width();
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let mut line = lines.pop().unwrap_or_default();
        if !line.is_empty() && wide(&line) + 1 + wide(word) > width {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        for sign in word.chars() {
            if !line.is_empty() && wide(&line) + wide(sign.encode_utf8(&mut [0; 4])) > width {
                lines.push(std::mem::take(&mut line));
            }
            line.push(sign);
        }
        lines.push(line);
    }
    lines
}

/// Formats the end of a log for this many columns and rows. Entries come newest first and are shown
/// newest last; older ones are dropped or cut.
pub(crate) fn log_lines<'a>(
    newest_first: impl Iterator<Item = (String, &'a str)>,
    width: u16,
    room: u16,
    theme: Theme,
) -> Vec<Line<'static>> {
    let (width, mut left) = (usize::from(width), usize::from(room));
    let mut entries = Vec::new();
    for (at, text) in newest_first {
        let indent = at.chars().count();
        if left == 0 {
            break;
        }
        let width = width.saturating_sub(indent).max(1);
        let mut lines = wrapped(text, width);
        if lines.len() > left {
            lines.truncate(left);
            if let Some(last) = lines.last_mut() {
                *last = last.chars().take(width.saturating_sub(1)).collect();
                last.push('…');
            }
        }
        left -= lines.len();
        let line = |(nth, text)| {
            let head = match nth {
                0 => at.clone(),
                _ => " ".repeat(indent),
            };
            Line::from(vec![Span::styled(head, theme.dim()), Span::raw(text)])
        };
        entries.push(lines.into_iter().enumerate().map(line).collect::<Vec<_>>());
    }
    entries.into_iter().rev().flatten().collect()
}

/// Formats all key hints in one line.
fn hints(keys: &[(&str, &str)], theme: Theme) -> Line<'static> {
    let mut line = Line::default();
    for (key, what) in keys {
        line.push_span(Span::styled(format!(" {key}"), theme.key()));
        line.push_span(format!(" {what} "));
    }
    line
}

/// Formats a message for the foot of the screen, in at most three lines.
pub(crate) fn message_lines(text: &str, width: u16, style: Style) -> Vec<Line<'static>> {
    const MAX_LINES: usize = 3;
    let room = usize::from(width).saturating_sub(1).max(1);
    let lines = wrapped(text, room).into_iter().take(MAX_LINES);
    lines
        .map(|text| Line::styled(format!(" {text}"), style))
        .collect()
}

/// Splits an area into header, middle, and a foot of as many lines as given.
pub(crate) fn header_body_footer(area: Rect, foot: &[Line<'_>]) -> [Rect; 3] {
    let foot = u16::try_from(foot.len()).unwrap_or(1);
    Layout::vertical([
        Constraint::Length(1),
        Constraint::Fill(1),
        Constraint::Length(foot),
    ])
    .areas(area)
}

/// Returns the arrow for a ground direction x, y as the view shows it.
pub(crate) fn arrow(view: TopView, way: [f64; 2]) -> char {
    match view.project(way) {
        [_, up] if up > 0.5 => '↑',
        [_, up] if up < -0.5 => '↓',
        [right, _] if right > 0.0 => '→',
        _ => '←',
    }
}

/// Returns a symbol for on and off.
pub(crate) fn lamp(on: bool) -> &'static str {
    if on { "●" } else { "○" }
}

/// Formats a length or an angle with one decimal, without a trailing `.0`.
pub(crate) fn mm(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_line_keeps_the_last_hint() {
        let keys = [("q", "quit"), ("m", "hold/step"), ("?", "all keys")];
        let text = |width| fitted(&keys, width, Theme::PLAIN).to_string();
        assert_eq!(text(80), " q quit  m hold/step  ? all keys ");
        assert_eq!(text(24), " q quit  ? all keys ");
        assert_eq!(text(3), " ? all keys ");
    }

    #[test]
    fn newest_log_entry_is_whole_and_older_ones_are_truncated() {
        let log = |room| -> Vec<String> {
            let newest_first = [
                ("2 ".to_owned(), "new and long"),
                ("1 ".to_owned(), "old words"),
            ];
            let lines = log_lines(newest_first.into_iter(), 10, room, Theme::PLAIN);
            lines.iter().map(Line::to_string).collect()
        };
        assert_eq!(log(4), ["1 old", "  words", "2 new and", "  long"]);
        assert_eq!(log(3), ["1 old…", "2 new and", "  long"]);
        assert_eq!(log(1), ["2 new and…"]);
        assert_eq!(log(0), [""; 0]);
    }

    #[test]
    fn text_wraps_between_words() {
        assert_eq!(wrapped("one two three", 8), ["one two", "three"]);
        assert_eq!(wrapped("unbreakable", 4), ["unbr", "eaka", "ble"]);
        // CJK characters are two columns wide.
        assert_eq!(wrapped("名前 名前", 6), ["名前", "名前"]);
        assert_eq!(wrapped("", 6), [""]);
        assert_eq!(wrapped("a", 0), ["a"]);
    }
}
