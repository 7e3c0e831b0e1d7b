//! What a terminal program knows of the arm that it shows, and how that looks.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use magician::commands::Pose;
use magician::{Alarm, Event, Link, Status};
use magician_motion::{ArmModel, Range};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::Theme;

/// Readings that are kept.
const HISTORY: usize = 600;
/// Lines of the log that are kept.
const LOG: usize = 200;
/// What was seen so long ago says nothing of now, or so many readings ago if they are far apart.
const STALE: Duration = Duration::from_secs(1);
const MISSED: f64 = 3.0;
/// It takes so many readings after a motion to see that it is over: two that are equal.
const SETTLES: u8 = 2;
/// What is slower stands, mm/s and deg/s.
const STILL: f64 = 0.01;

/// How fast the tool is, mm/s, and each joint, deg/s, without direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Speeds {
    pub(crate) tool: f64,
    pub(crate) joints: [f64; 4],
}

impl Speeds {
    /// From one pose to another so many seconds later.
    fn between(before: &Pose, after: &Pose, seconds: f64) -> Self {
        let apart = |a: f32, b: f32| f64::from(a) - f64::from(b);
        let [x, y, z] = [
            apart(after.x, before.x),
            apart(after.y, before.y),
            apart(after.z, before.z),
        ];
        let mut joints = [0.0; 4];
        let angles = after.joint_angle.iter().zip(before.joint_angle);
        for (joint, (after, before)) in joints.iter_mut().zip(angles) {
            *joint = apart(*after, before).abs() / seconds;
        }
        Self {
            tool: (x * x + y * y + z * z).sqrt() / seconds,
            joints,
        }
    }

    fn is_still(&self) -> bool {
        self.tool < STILL && self.joints.iter().all(|speed| *speed < STILL)
    }
}

/// An arm as it was seen.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    /// Which arm, where.
    pub(crate) title: String,
    pub(crate) status: Option<Status>,
    /// Where on the rail, mm, if there is one.
    pub(crate) rail: Option<f32>,
    /// Commands that the queue holds.
    pub(crate) places: u32,
    /// Speeds from reading to reading, the latest last.
    pub(crate) speeds: VecDeque<Speeds>,
    /// Readings a second.
    pub(crate) rate: f64,
    /// What happened, with the seconds since the beginning, the latest last.
    pub(crate) log: VecDeque<(f64, String)>,
    /// How old the last reading was at the last look.
    age: Duration,
    /// From then on it is not news.
    stale: Duration,
    /// Readings to come until a motion that was begun can have been seen to be over.
    stirred: u8,
    begun: Instant,
}

impl Seen {
    pub(crate) fn new(title: String, places: u32) -> Self {
        Self {
            title,
            status: None,
            rail: None,
            places,
            speeds: VecDeque::new(),
            rate: 0.0,
            log: VecDeque::new(),
            age: Duration::ZERO,
            stale: STALE,
            stirred: 0,
            begun: Instant::now(),
        }
    }

    /// For so many readings a second.
    pub(crate) fn reading(mut self, rate: f64) -> Self {
        let missed = Duration::try_from_secs_f64(MISSED / rate).unwrap_or(Duration::MAX);
        self.stale = STALE.max(missed);
        self
    }

    /// Takes a reading.
    pub(crate) fn see(&mut self, status: Status) {
        if let Some(before) = &self.status {
            let seconds = status.at.saturating_duration_since(before.at).as_secs_f64();
            // A link that came or went tells the reading before once more.
            if seconds > 0.0 {
                self.keep(Speeds::between(&before.pose, &status.pose, seconds));
                let rate = seconds.recip();
                let known = if self.rate > 0.0 { self.rate } else { rate };
                self.rate = known + 0.1 * (rate - known);
                self.stirred = self.stirred.saturating_sub(1);
            }
        }
        self.status = Some(status);
    }

    /// Looks how old the last reading is by now.
    pub(crate) fn look(&mut self, now: Instant) {
        let last = self.status.as_ref().map_or(self.begun, |status| status.at);
        self.age = now.saturating_duration_since(last);
    }

    /// Something moves the arm: what was read before says nothing of where it is any more.
    pub(crate) fn stir(&mut self) {
        self.stirred = SETTLES;
    }

    /// Whether the arm has answered lately.
    pub(crate) fn answers(&self) -> bool {
        self.age < self.stale
    }

    fn keep(&mut self, speeds: Speeds) {
        if self.speeds.len() == HISTORY {
            self.speeds.pop_front();
        }
        self.speeds.push_back(speeds);
    }

    /// Adds a line to the log.
    pub(crate) fn note(&mut self, text: impl Into<String>) {
        if self.log.len() == LOG {
            self.log.pop_front();
        }
        let at = self.begun.elapsed().as_secs_f64();
        self.log.push_back((at, text.into()));
    }

    /// How fast it was at last.
    pub(crate) fn speed(&self) -> Speeds {
        self.speeds.back().copied().unwrap_or_default()
    }

    /// Whether it was seen to stand, lately and since it was moved last.
    pub(crate) fn stands(&self) -> bool {
        self.answers() && self.stirred == 0 && self.speed().is_still()
    }

    /// Which arm, and at the right how the line to it is.
    pub(crate) fn header(&self, program: &str, width: u16, theme: Theme) -> Paragraph<'static> {
        let link = match self.status.as_ref().map(|status| &status.link) {
            None => " waiting for the arm ".to_owned(),
            Some(Link::Up) if !self.answers() => {
                format!(" NO ANSWER for {} s ", self.age.as_secs())
            }
            Some(Link::Up) => format!(" link up {:.0}/s ", self.rate),
            Some(Link::Lost { sought: true, .. }) => " LINK LOST, looking for it ".to_owned(),
            Some(Link::Lost { .. }) => " LINK LOST ".to_owned(),
            Some(_) => " closed ".to_owned(),
        };
        let text = format!(" magician {program} | {}", self.title);
        let room = usize::from(width).saturating_sub(link.chars().count());
        let text: String = text.chars().take(room).collect();
        Paragraph::new(format!("{text:<room$}{link}")).style(theme.bar())
    }

    /// The joints with bars against their limits, and the coupling of J2 and J3; as many columns wide.
    pub(crate) fn joint_lines(&self, width: u16, theme: Theme) -> Vec<Line<'static>> {
        let Some(status) = &self.status else {
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

    /// The latest lines of the log, the newest last; long ones go on in the next line.
    pub(crate) fn log_lines(&self, width: u16, room: u16, theme: Theme) -> Vec<Line<'static>> {
        let log = self.log.iter().rev();
        let log = log.map(|(at, text)| (format!("{at:>8.1}  "), text.as_str()));
        super::log_lines(log, width, room, theme)
    }

    /// The alarms that stand, in words.
    pub(crate) fn alarm_lines(&self, width: u16, room: u16, theme: Theme) -> Vec<Line<'static>> {
        let alarms = self.status.as_ref().map(|status| status.alarms);
        super::alarm_lines(&alarms.unwrap_or_default(), width, room, theme)
    }
}

/// A joint: name, angle, and where that is between its limits.
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

/// What happened, in words.
pub(crate) fn event_text(event: &Event) -> String {
    let alarm = |code: u8| match Alarm::with_code(code) {
        Some(alarm) => format!("{code:#04x} {}: {}", alarm.name, alarm.cause),
        None => format!("{code:#04x}"),
    };
    match event {
        Event::AlarmRaised { code } => format!("alarm {}", alarm(*code)),
        Event::AlarmCleared { code } => {
            let name = Alarm::with_code(*code).map_or("", |alarm| alarm.name);
            format!("alarm {code:#04x} {name} is gone")
        }
        Event::CommandFinished { first, last } if first == last => {
            format!("command {} finished", first.0)
        }
        Event::CommandFinished { first, last } => {
            format!("commands {} to {} finished", first.0, last.0)
        }
        Event::LinkLost { why } => format!("the line broke: {why}"),
        Event::LinkFound { reset: true } => "the line is back; the arm was reset".to_owned(),
        Event::LinkFound { .. } => "the line is back".to_owned(),
        Event::Reset { gone: None } => "the arm was reset".to_owned(),
        Event::Reset {
            gone: Some((first, last)),
        } => format!(
            "the arm was reset: commands {} to {} are lost",
            first.0, last.0
        ),
        Event::Unaccounted { from, to } => {
            format!(
                "commands {} to {} were queued by somebody else",
                from.0, to.0
            )
        }
        Event::Missed { events } => format!("{events} events were missed"),
        _ => "something happened that this program does not know".to_owned(),
    }
}

/// Values as a row of bars, the latest at the right; as high as the highest that is shown, at least `least`.
pub(crate) fn sparkline(values: &[f64], width: usize, least: f64, style: Style) -> Span<'static> {
    const SIGNS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let shown = &values[values.len().saturating_sub(width)..];
    let most = shown.iter().copied().fold(least, f64::max);
    let mut text = " ".repeat(width - shown.len());
    text.extend(shown.iter().map(|value| {
        let level = (value / most * 8.0).ceil();
        match level as usize {
            0 => ' ',
            level => SIGNS[level.min(8) - 1],
        }
    }));
    Span::styled(text, style)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terminal::test::status;

    const READING: Duration = Duration::from_millis(50);

    /// Readings of an arm that stands, 50 ms apart.
    fn read(seen: &mut Seen, times: u32) {
        for _ in 0..times {
            let mut next = seen.status.clone().unwrap_or_else(status);
            next.at += READING;
            seen.look(next.at);
            seen.see(next);
        }
    }

    #[test]
    fn an_arm_that_was_moved_stands_again_when_two_readings_say_so() {
        let mut seen = Seen::new(String::new(), 32);
        read(&mut seen, 3);
        assert!(seen.stands());
        seen.stir();
        assert!(!seen.stands());
        read(&mut seen, 1);
        assert!(!seen.stands());
        read(&mut seen, 1);
        assert!(seen.stands());
    }

    #[test]
    fn what_was_read_long_ago_is_not_how_it_is() {
        let mut seen = Seen::new(String::new(), 32);
        read(&mut seen, 3);
        let last = seen.status.as_ref().unwrap().at;
        seen.look(last + Duration::from_millis(900));
        assert!(seen.answers() && seen.stands());
        seen.look(last + Duration::from_millis(2100));
        assert!(!seen.answers() && !seen.stands());
        let screen = crate::terminal::test::screen(60, 1, |frame| {
            frame.render_widget(seen.header("jog", 60, Theme::PLAIN), frame.area());
        });
        assert!(screen[0].contains("NO ANSWER for 2 s"), "{screen:?}");
        // Where readings are far apart they are news for longer.
        let mut seen = seen.reading(0.5);
        seen.look(last + Duration::from_millis(2100));
        assert!(seen.answers());
    }
}
