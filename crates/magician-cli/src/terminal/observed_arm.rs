//! State of the arm that terminal programs show, and its widgets.

use std::collections::VecDeque;
use std::time::Instant;

use magician::Link;
use magician_job::ObservedState;
use magician_motion::{ArmModel, Range};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::Theme;

/// Largest number of log lines kept.
const MAX_LOG_LINES: usize = 200;

/// Observed arm with a log.
#[derive(Clone, Debug)]
pub(crate) struct ObservedArm {
    /// Name and place of the arm.
    pub(crate) title: String,
    /// State derived from its readings.
    pub(crate) arm: ObservedState,
    /// Capacity of the command queue.
    pub(crate) queue_capacity: u32,
    /// Log: seconds since the beginning and text, newest last.
    pub(crate) log: VecDeque<(f64, String)>,
    begun: Instant,
}

impl ObservedArm {
    pub(crate) fn new(title: String, queue_capacity: u32) -> Self {
        Self {
            title,
            arm: ObservedState::default(),
            queue_capacity,
            log: VecDeque::new(),
            begun: Instant::now(),
        }
    }

    /// Sets the number of readings a second.
    pub(crate) fn with_reading_rate(mut self, rate: f64) -> Self {
        self.arm = self.arm.with_rate(rate);
        self
    }

    /// Adds a line to the log.
    pub(crate) fn note(&mut self, text: impl Into<String>) {
        if self.log.len() == MAX_LOG_LINES {
            self.log.pop_front();
        }
        let at = self.begun.elapsed().as_secs_f64();
        self.log.push_back((at, text.into()));
    }

    /// Formats the header: the arm, and at the right the state of its connection.
    pub(crate) fn header(&self, program: &str, width: u16, theme: Theme) -> Paragraph<'static> {
        let link = match self.arm.status.as_ref().map(|status| &status.link) {
            None => " waiting for the arm ".to_owned(),
            Some(Link::Up) if !self.arm.is_answering() => {
                format!(" NO ANSWER for {} s ", self.arm.age().as_secs())
            }
            Some(Link::Up) => format!(" link up {:.0}/s ", self.arm.rate),
            Some(Link::Lost { sought: true, .. }) => " LINK LOST, reconnecting ".to_owned(),
            Some(Link::Lost { .. }) => " LINK LOST ".to_owned(),
            Some(_) => " closed ".to_owned(),
        };
        let text = format!(" magician {program} | {}", self.title);
        let room = usize::from(width).saturating_sub(link.chars().count());
        let text: String = text.chars().take(room).collect();
        Paragraph::new(format!("{text:<room$}{link}")).style(theme.bar())
    }

    /// Formats the joints as bars within their limits, and the coupling of J2 and J3, in this many
    /// columns.
    pub(crate) fn joint_lines(&self, width: u16, theme: Theme) -> Vec<Line<'static>> {
        let Some(status) = &self.arm.status else {
            return Vec::new();
        };
        let limits = ArmModel::MAGICIAN.limits;
        let [j1, j2, j3, j4] = status.pose.joint_angle.map(f64::from);
        let rows = [
            ("J1", j1, limits.j1),
            ("J2", j2, limits.j2),
            ("J3", j3, limits.j3),
            ("J4", j4, limits.j4),
            ("2-3", j2 - j3, limits.j2_minus_j3),
        ];
        let row = |(name, value, range)| bar(name, value, range, width, theme);
        rows.into_iter().map(row).collect()
    }

    /// Formats the end of the log, newest last, wrapped.
    pub(crate) fn log_lines(&self, width: u16, room: u16, theme: Theme) -> Vec<Line<'static>> {
        let log = self.log.iter().rev();
        let log = log.map(|(at, text)| (format!("{at:>8.1}  "), text.as_str()));
        super::log_lines(log, width, room, theme)
    }

    /// Formats the active alarms.
    pub(crate) fn alarm_lines(&self, width: u16, room: u16, theme: Theme) -> Vec<Line<'static>> {
        let alarms = self.arm.status.as_ref().map(|status| status.alarms);
        super::alarm_lines(&alarms.unwrap_or_default(), width, room, theme)
    }
}

/// Formats a joint: name, angle, and a bar for its place between the limits.
fn bar(name: &str, value: f64, range: Range, width: u16, theme: Theme) -> Line<'static> {
    let style = match theme.near(value, range) {
        within if within == Style::new() => theme.good(),
        near => near,
    };
    let (low, high) = (format!("{:>5} ", range.min), format!(" {:<4}", range.max));
    let head = format!("{name:<3} {value:>7.1} ");
    let taken = head.len() + low.len() + high.len();
    let track = usize::from(width).saturating_sub(taken).min(60);
    if track < 5 {
        return Line::from(Span::styled(head, style));
    }
    let share = ((value - range.min) / (range.max - range.min)).clamp(0.0, 1.0);
    let at = ((track - 1) as f64 * share).round() as usize;
    Line::from(vec![
        Span::raw(head),
        Span::styled(low, theme.dim()),
        Span::styled("─".repeat(at), theme.dim()),
        Span::styled("●", style),
        Span::styled("─".repeat(track - 1 - at), theme.dim()),
        Span::styled(high, theme.dim()),
    ])
}

/// Formats values as a row of bars, newest at the right. The scale ends at the largest value shown,
/// or at `min_scale` if that is larger.
pub(crate) fn sparkline(
    values: &[f64],
    width: usize,
    min_scale: f64,
    style: Style,
) -> Span<'static> {
    const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let shown = &values[values.len().saturating_sub(width)..];
    let scale = shown.iter().copied().fold(min_scale, f64::max);
    let mut text = " ".repeat(width - shown.len());
    text.extend(shown.iter().map(|value| {
        let level = (value / scale * 8.0).ceil();
        match level as usize {
            0 => ' ',
            level => BARS[level.min(8) - 1],
        }
    }));
    Span::styled(text, style)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::terminal::test::status;

    #[test]
    fn silent_arm_is_shown_as_not_answering() {
        let mut observed_arm = ObservedArm::new(String::new(), 32);
        let status = status();
        observed_arm.arm.observe(status.clone());
        observed_arm
            .arm
            .tick(status.at + Duration::from_millis(2100));
        let screen = crate::terminal::test::screen(60, 1, |frame| {
            frame.render_widget(observed_arm.header("jog", 60, Theme::PLAIN), frame.area());
        });
        assert!(screen[0].contains("NO ANSWER for 2 s"), "{screen:?}");
    }
}
