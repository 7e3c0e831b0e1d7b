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

/// What keys do, on one line so wide. The last one always has its place: it tells of all the others.
pub(crate) fn fitted(keys: &[(&str, &str)], width: u16, theme: Theme) -> Line<'static> {
    let mut shown = keys.to_vec();
    let mut line = hints(&shown, theme);
    while line.width() > usize::from(width) && shown.len() > 1 {
        shown.remove(shown.len() - 2);
        line = hints(&shown, theme);
    }
    line
}

/// Words in lines that are no wider than this; a longer word goes on in the next line.
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

/// What keys do.
pub(crate) fn hints(keys: &[(&str, &str)], theme: Theme) -> Line<'static> {
    let mut line = Line::default();
    for (key, what) in keys {
        line.push_span(Span::styled(format!(" {key}"), theme.key()));
        line.push_span(format!(" {what} "));
    }
    line
}

/// Columns of a list of keys before what they do.
const HANGING: usize = 13;

/// The list of all keys, over the middle of what is shown.
pub(crate) fn help(frame: &mut Frame<'_>, area: Rect, keys: &[(&str, &str)], theme: Theme) {
    const LEAST: usize = 68;
    let longest = keys.iter().map(|(_, what)| what.chars().count() + 16);
    let width = longest.max().unwrap_or(0).max(LEAST);
    let width = u16::try_from(width).unwrap_or(u16::MAX).min(area.width);
    let room = usize::from(width).saturating_sub(2 + HANGING);
    let lines: Vec<_> = keys
        .iter()
        .flat_map(|(key, what)| described(key, what, room, theme))
        .collect();
    let height = u16::try_from(lines.len() + 2).unwrap_or(u16::MAX);
    let [across] = Layout::horizontal([Constraint::Length(width)])
        .flex(Flex::Center)
        .areas(area);
    let [area] = Layout::vertical([Constraint::Length(height.min(area.height))])
        .flex(Flex::Center)
        .areas(across);
    let block = Block::bordered()
        .border_type(BorderType::Rounded)
        .title(Span::styled(" keys ", theme.title()));
    frame.render_widget(Clear, area);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// What a key does, on as many lines as that takes.
fn described(key: &str, what: &str, room: usize, theme: Theme) -> Vec<Line<'static>> {
    let lines = wrapped(what, room).into_iter().enumerate();
    let line = |(nth, text)| {
        let key = if nth == 0 { key } else { "" };
        let key = format!(" {key:<width$}", width = HANGING - 1);
        Line::from(vec![Span::styled(key, theme.key()), Span::raw(text)])
    };
    lines.map(line).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_hint_stays_where_there_is_little_room() {
        let keys = [("q", "quit"), ("m", "hold/step"), ("?", "all keys")];
        let text = |width| fitted(&keys, width, Theme::PLAIN).to_string();
        assert_eq!(text(80), " q quit  m hold/step  ? all keys ");
        assert_eq!(text(24), " q quit  ? all keys ");
        assert_eq!(text(3), " ? all keys ");
    }

    #[test]
    fn words_go_on_in_the_next_line() {
        assert_eq!(wrapped("one two three", 8), ["one two", "three"]);
        assert_eq!(wrapped("unbreakable", 4), ["unbr", "eaka", "ble"]);
        // Wide signs take two columns.
        assert_eq!(wrapped("名前 名前", 6), ["名前", "名前"]);
        assert_eq!(wrapped("", 6), [""]);
        assert_eq!(wrapped("a", 0), ["a"]);
    }
}
