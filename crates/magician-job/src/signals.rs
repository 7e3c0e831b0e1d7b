//! Rule that turns signals into stops, without handling signals or reading a clock.
//!
//! A terminal that closes sends SIGHUP two or three times within milliseconds (kernel, shell,
//! tmux), a shell forwards a Ctrl-C that the terminal has already sent to its job, and keys bounce.
//! None of these is an impatient person, so none may cut short what the first stop has begun:
//! lifting the pen and restoring the settings.

use std::time::Duration;

/// Time from the first stop until a second one counts. Repeats by kernel and shell come within
/// 0.1 s; a person who sees that the arm still moves takes longer.
pub const SECOND_STOP_DELAY: Duration = Duration::from_millis(500);

/// Signal or request to end a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StopSignal {
    /// Ctrl-C (SIGINT).
    Interrupt,
    /// Another program or the system ends this one (SIGTERM).
    Terminate,
    /// The terminal is gone (SIGHUP).
    HangUp,
    /// Key or input line instead of a signal.
    Request,
}

/// Order to a run that follows from a [`StopSignal`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StopOrder {
    /// The arm stops, the laser goes off, the pen goes up, settings are restored.
    Stop,
    /// The arm stops where it is, and nothing moves afterwards. Settings are restored.
    Halt,
}

/// Decides which signals stop a run, and how.
///
/// The first signal stops the run. The first Ctrl-C or SIGTERM at least [`SECOND_STOP_DELAY`] later
/// stops it at once. All others change nothing.
///
/// ```
/// use std::time::Duration;
///
/// use magician_job::{StopOrder, StopRule, StopSignal};
///
/// let mut rule = StopRule::default();
/// let mut order = |signal, ms| rule.order_for(signal, Duration::from_millis(ms));
/// assert_eq!(order(StopSignal::Interrupt, 0), Some(StopOrder::Stop));
/// assert_eq!(order(StopSignal::Interrupt, 80), None);
/// assert_eq!(order(StopSignal::HangUp, 700), None);
/// assert_eq!(order(StopSignal::Interrupt, 900), Some(StopOrder::Halt));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StopRule {
    /// Time of the first signal.
    first: Option<Duration>,
    /// True once the second stop was ordered: there is no third.
    is_halted: bool,
}

impl StopRule {
    /// Order that follows from a signal at `at`, counted from any fixed instant; `None` if it
    /// changes nothing.
    pub fn order_for(&mut self, signal: StopSignal, at: Duration) -> Option<StopOrder> {
        let Some(first) = self.first else {
            self.first = Some(at);
            return Some(StopOrder::Stop);
        };
        let insists = matches!(signal, StopSignal::Interrupt | StopSignal::Terminate);
        if self.is_halted || !insists || at.saturating_sub(first) < SECOND_STOP_DELAY {
            return None;
        }
        self.is_halted = true;
        Some(StopOrder::Halt)
    }

    /// True if a stop was ordered.
    #[must_use]
    pub const fn is_stopping(&self) -> bool {
        self.first.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::StopSignal::{HangUp, Interrupt, Request, Terminate};
    use super::*;

    const SIGNALS: [StopSignal; 4] = [Interrupt, Terminate, HangUp, Request];
    /// Delays before a signal: immediate, forwarded, just too early, just late enough, long after.
    const PAUSES_MS: [u64; 5] = [0, 100, 499, 500, 5_000];

    /// Calls `check` with each sequence of up to `most` signals.
    fn sequences(most: usize, check: &mut impl FnMut(&[(StopSignal, Duration)])) {
        let mut sequences: Vec<Vec<(StopSignal, Duration)>> = vec![Vec::new()];
        for _ in 0..most {
            let mut longer = Vec::new();
            for sequence in &sequences {
                let last = sequence.last().map_or(Duration::ZERO, |(_, at)| *at);
                for signal in SIGNALS {
                    for pause in PAUSES_MS {
                        let mut next = sequence.clone();
                        next.push((signal, last + Duration::from_millis(pause)));
                        check(&next);
                        longer.push(next);
                    }
                }
            }
            sequences = longer;
        }
    }

    fn orders(sequence: &[(StopSignal, Duration)]) -> Vec<Option<StopOrder>> {
        let mut rule = StopRule::default();
        let orders = sequence
            .iter()
            .map(|(signal, at)| rule.order_for(*signal, *at));
        orders.collect()
    }

    #[test]
    fn only_a_late_ctrl_c_or_sigterm_halts() {
        let (mut count, mut halted) = (0, 0);
        sequences(4, &mut |sequence| {
            count += 1;
            let orders = orders(sequence);
            assert_eq!(orders[0], Some(StopOrder::Stop), "{sequence:?}");
            let first = sequence[0].1;
            let late = |(signal, at): &(StopSignal, Duration)| {
                matches!(signal, Interrupt | Terminate) && *at >= first + Duration::from_millis(500)
            };
            let expected = sequence.iter().skip(1).position(late).map(|nth| nth + 1);
            for (nth, order) in orders.iter().enumerate().skip(1) {
                let due = (expected == Some(nth)).then_some(StopOrder::Halt);
                assert_eq!(*order, due, "signal {nth} of {sequence:?}");
            }
            halted += usize::from(expected.is_some());
        });
        assert_eq!(count, 20 + 400 + 8_000 + 160_000);
        assert!(halted > 10_000, "{halted}");
    }

    #[test]
    fn hang_ups_never_halt() {
        sequences(4, &mut |sequence| {
            if sequence.iter().all(|(signal, _)| *signal == HangUp) {
                let orders = orders(sequence);
                assert!(orders[1..].iter().all(Option::is_none), "{sequence:?}");
            }
        });
    }

    #[test]
    fn two_signals_within_100_ms_count_as_one() {
        for first in SIGNALS {
            for second in SIGNALS {
                for ms in [0, 20, 100] {
                    let orders =
                        orders(&[(first, Duration::ZERO), (second, Duration::from_millis(ms))]);
                    assert_eq!(
                        orders,
                        [Some(StopOrder::Stop), None],
                        "{first:?} {second:?}"
                    );
                }
            }
        }
    }
}
