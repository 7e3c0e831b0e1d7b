//! Alarms in words.

use magician::{Alarm, AlarmSet};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use super::Theme;

/// Alarms as they fit into so many columns and rows: with their causes if all of that finds room, else what to do about them.
pub(crate) fn alarms(alarms: &AlarmSet, width: u16, room: u16, theme: Theme) -> Paragraph<'static> {
    let (width, room) = (usize::from(width), usize::from(room));
    let with_causes = alarm_lines(alarms, room, true, theme);
    let fit =
        alarms.codes().count() * 2 <= room && with_causes.iter().all(|line| line.width() <= width);
    let lines = match fit {
        true => with_causes,
        false => alarm_lines(alarms, room, false, theme),
    };
    Paragraph::new(lines).wrap(Wrap { trim: false })
}

/// Alarms and what to do about them, each on a line, or with their causes on two.
pub(crate) fn alarm_lines(
    alarms: &AlarmSet,
    room: usize,
    causes: bool,
    theme: Theme,
) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    for code in alarms.codes().take(room) {
        let style = match Alarm::blocks(code) {
            true => theme.bad(),
            false => theme.note(),
        };
        let Some(alarm) = Alarm::with_code(code) else {
            lines.push(Line::styled(format!("{code:#04x}"), style));
            continue;
        };
        let name = Span::styled(format!("{code:#04x} {}", alarm.name), style);
        if causes {
            lines.push(Line::from(vec![
                name,
                Span::raw(format!(": {}", alarm.cause)),
            ]));
            lines.push(Line::from(format!("     {}", alarm.cure)));
        } else {
            lines.push(Line::from(vec![
                name,
                Span::raw(format!(": {}", alarm.cure)),
            ]));
        }
    }
    if lines.is_empty() {
        lines.push(Line::styled("no alarm", theme.dim()));
    }
    lines
}
