//! Alarms as text for terminal programs.

use magician::{Alarm, AlarmSet};
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::{Theme, wrapped};

/// Formats alarms in lines of `width` columns, at most `room` lines: with causes if everything
/// fits, otherwise with remedies only. What does not fit even then is counted in the last line.
pub(crate) fn alarm_lines(
    alarms: &AlarmSet,
    width: u16,
    room: u16,
    theme: Theme,
) -> Vec<Line<'static>> {
    let (width, room) = (usize::from(width), usize::from(room));
    let lines_for = |causes| {
        let all = alarms.codes().map(move |code| alarm(code, causes));
        all.map(|(name, texts)| styled(&name, &texts, width, theme.alarm(name.code)))
            .collect::<Vec<_>>()
    };
    let mut all = lines_for(true);
    if all.iter().map(Vec::len).sum::<usize>() > room {
        all = lines_for(false);
    }
    if all.is_empty() {
        return vec![Line::styled("no alarm", theme.dim())];
    }
    let count = all.len();
    let mut lines: Vec<Line<'static>> = Vec::new();
    for (nth, alarm) in all.into_iter().enumerate() {
        let last = nth + 1 == count;
        // Keep a line free for the count of alarms left out.
        let fits = lines.len() + alarm.len() + usize::from(!last) <= room;
        if !fits && nth > 0 {
            lines.push(Line::styled(
                format!("and {} more", count - nth),
                theme.dim(),
            ));
            return lines;
        }
        lines.extend(alarm);
    }
    lines
}

/// Code and name of an alarm.
struct Name {
    code: u8,
    text: String,
}

/// Returns an alarm's name and description.
fn alarm(code: u8, causes: bool) -> (Name, Vec<String>) {
    let (text, texts) = match Alarm::with_code(code) {
        None => (format!("{code:#04x}"), vec![String::new()]),
        Some(alarm) => {
            let texts = if causes {
                vec![
                    format!(": {}", alarm.cause),
                    format!("     {}", alarm.remedy),
                ]
            } else {
                vec![format!(": {}", alarm.remedy)]
            };
            (format!("{code:#04x} {}", alarm.name), texts)
        }
    };
    (Name { code, text }, texts)
}

fn styled(name: &Name, texts: &[String], width: usize, style: Style) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    for (nth, text) in texts.iter().enumerate() {
        let indent = text.len() - text.trim_start().len();
        let text = match nth {
            0 => format!("{}{text}", name.text),
            _ => text.trim_start().to_owned(),
        };
        for (row, line) in wrapped(&text, width.saturating_sub(indent))
            .into_iter()
            .enumerate()
        {
            let named = line.strip_prefix(&name.text).filter(|_| nth + row == 0);
            lines.push(match named {
                Some(rest) => Line::from(vec![
                    Span::styled(name.text.clone(), style),
                    Span::raw(rest.to_owned()),
                ]),
                None => Line::raw(format!("{}{line}", " ".repeat(indent))),
            });
        }
    }
    lines
}
