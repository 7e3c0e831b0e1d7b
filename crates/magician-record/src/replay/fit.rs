//! Fit of a recorded session to the periods of an arm.
//!
//! An arm computes in periods of its own clock, which a trace does not show. The fit tries each
//! millisecond of a period as their start, and takes the middle of the best offsets, at which the
//! arm moves most like the recorded one.
//!
//! The host's clock jitters, so a command may have arrived in the neighbouring period, which shifts
//! the whole motion by a period. If the poses reveal that, the command is moved by half a period.

use std::time::Duration;

use magician_protocol::{Direction, Frame};
use magician_sim::Controller;

use super::Replay;
use super::report::{DifferenceKind, Report, Residue};

/// Step between tried phases, us.
const STEP: u64 = 1_000;
/// Number of packets used for the fit. Of longer sessions the beginning decides; it bounds the
/// work.
const PACKETS: usize = 50_000;

impl<'a> Replay<'a> {
    /// Returns the session with the best phase of the arm's periods, as additional uptime of the
    /// arm.
    ///
    /// The session is unchanged if it is answered equally without a shift, or if the arm computes
    /// in continuous time.
    #[must_use]
    pub fn fitted(self, arm: &Controller) -> Self {
        let period = u64::from(arm.arm_model().law.period_us());
        let head = Self {
            packets: self.packets.iter().take(PACKETS).cloned().collect(),
            ..self.clone()
        };
        let score = |shift_us: u64| {
            let shifted = head.clone().shifted(Duration::from_micros(shift_us));
            score(&shifted.against(&mut arm.clone()))
        };
        if period == 0 || score(0) == (0, 0) {
            return self;
        }
        let shifts: Vec<u64> = (0..period).step_by(STEP as usize).collect();
        let scores: Vec<_> = shifts.iter().map(|shift| score(*shift)).collect();
        let Some(best) = scores.iter().min() else {
            return self;
        };
        // Take the middle of the best phases, where errors of the times matter least. Phases wrap
        // around.
        let is_best = |at: usize| scores[at % scores.len()] == *best;
        let begin = (0..shifts.len()).find(|at| is_best(*at) && !is_best(at + shifts.len() - 1));
        let begin = begin.unwrap_or(0);
        let count = (begin..begin + shifts.len())
            .take_while(|at| is_best(*at))
            .count();
        let middle = shifts[(begin + count / 2) % shifts.len()];
        self.shifted(Duration::from_micros(middle))
    }

    /// Sets the additional uptime of the arm when the session begins.
    #[must_use]
    pub fn shifted(mut self, by: Duration) -> Self {
        self.shift = by;
        self
    }

    /// Additional uptime of the arm when the session begins.
    #[must_use]
    pub fn shift(&self) -> Duration {
        self.shift
    }
}

/// Largest shift of a command, us: half a period. It exceeds the jitter of one pose, because the
/// phase is uncertain where commands contradict each other.
const COMMAND_JITTER: u64 = 10_000;
/// Number of commands before a pose that may explain its deviation: a start, and its preparation.
const REASONS: usize = 3;
/// Most commands that are moved ..
const MOST_MOVED: usize = 200;
/// .. and most packets replayed for that: a few seconds of work.
const MOST_PACKETS: usize = 2_000_000;

impl Replay<'_> {
    /// Measures how far the recorded poses are from those of an arm. Commands are moved to a
    /// neighbouring period where the poses reveal that they arrived there.
    #[must_use]
    pub fn residue(mut self, arm: &Controller) -> Residue {
        let mut known = self.against(&mut arm.clone()).residue;
        let most = if arm.arm_model().law.is_continuous() {
            0
        } else {
            MOST_PACKETS / (2 * REASONS * self.packets.len().max(1))
        };
        for _ in 0..most.min(MOST_MOVED) {
            let Some(off) = known.first_off else { break };
            let before = self.packets.iter().enumerate().rev();
            let before = before.filter(|(_, packet)| self.time(packet.time) <= off);
            let commands = before.filter(|(_, packet)| {
                let frame = Frame::new(packet.bytes);
                packet.direction == Some(Direction::Request)
                    && frame.is_some_and(|frame| frame.ctrl().write() || frame.ctrl().queued())
            });
            let commands: Vec<usize> = commands.map(|(at, _)| at).take(REASONS).collect();
            let tried = commands.into_iter().flat_map(|at| {
                let earlier = self.packets[at].time.saturating_sub(COMMAND_JITTER);
                [(at, earlier), (at, self.packets[at].time + COMMAND_JITTER)]
            });
            let tried = tried.map(|(at, time)| {
                let mut session = self.clone();
                // The first packet defines the start of the trace, so nothing moves before it.
                let begin = self.packets.first().map_or(0, |packet| packet.time);
                session.packets[at].time = time.max(begin);
                session.packets.sort_by_key(|packet| packet.time);
                let residue = session.against(&mut arm.clone()).residue;
                (residue, session)
            });
            let last = |residue: &Residue| residue.first_off.map_or(u64::MAX, |at| at.as_micros());
            match tried.max_by_key(|(residue, _)| last(residue)) {
                Some((residue, session)) if last(&residue) > last(&known) => {
                    (known, self) = (residue, session);
                }
                _ => break,
            }
        }
        known
    }
}

/// Score of a report: number of differing measurements, then the sum of their differences in
/// thousandths.
fn score(report: &Report) -> (usize, u64) {
    let measured = report.differences.iter().filter_map(|found| {
        matches!(found.what, DifferenceKind::Value(_)).then(|| found.distance())?
    });
    let (mut count, mut all) = (0, 0.0);
    for off in measured {
        count += 1;
        all += f64::from(off.min(1e6));
    }
    let other = report.differences.iter();
    let other = other
        .filter(|found| found.what == DifferenceKind::Period)
        .count();
    (count + other + report.late as usize, (all * 1000.0) as u64)
}
