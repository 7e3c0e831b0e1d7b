//! Hold-to-run control: the arm moves only while the control is held (a dead man's switch).
//!
//! Some controls report their release: the jog lasts from press to release. Others (keys of most
//! terminals) report only presses, and a held key as repeated presses, of which the second comes
//! half a second after the first. For these a single press jogs for a moment, so a tap is a nudge.
//! A repeat within [`MAX_REPEAT_DELAY`] means that the key is held: the jog continues until repeats
//! stop. The first reported release shows which kind the control is.

use std::time::Duration;

use super::JogDirection;

/// Time for which a jog continues after the last report that its control is held.
const RELEASE_TIMEOUT: Duration = Duration::from_millis(250);
/// Hold time given to the driver: slightly longer than [`RELEASE_TIMEOUT`], it takes effect only if
/// this program hangs.
const DRIVER_HOLD_TIME: Duration = Duration::from_millis(300);
/// Duration of a tap's jog if releases are not reported.
const TAP_DURATION: Duration = Duration::from_millis(150);
/// A press repeated within this time is a hold: longer than the longest delay before keys repeat
/// (660 ms under X).
const MAX_REPEAT_DELAY: Duration = Duration::from_millis(700);

/// Action that follows from a report of the control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldAction {
    /// Start a jog. It ends by itself after `keep` unless kept alive.
    Begin {
        /// Direction of the jog.
        direction: JogDirection,
        /// Hold time without a keep-alive.
        keep: Duration,
    },
    /// Send a keep-alive for the jog.
    Keep,
    /// End the jog.
    End,
    /// No action.
    Nothing,
}

/// State of the control, and what is known of its kind. Times count from any fixed origin, the same
/// for all calls.
///
/// ```
/// use std::time::Duration;
///
/// use magician_job::jog::{Axis, HoldAction, HoldToRun, JogDirection};
///
/// let at = Duration::from_millis;
/// let up = JogDirection { axis: Axis::Z, forward: true };
/// let mut hold = HoldToRun::new();
/// hold.set_reports_releases(true);
/// assert!(matches!(hold.press(up, at(0)), HoldAction::Begin { .. }));
/// assert_eq!(hold.tick(at(50)), HoldAction::Keep);
/// assert_eq!(hold.release(Some(up)), HoldAction::End);
/// ```
#[derive(Clone, Debug)]
pub struct HoldToRun {
    /// True if releases are reported.
    releases: bool,
    held: Option<HeldControl>,
    /// Last press and its time.
    last: Option<(JogDirection, Duration)>,
}

#[derive(Clone, Copy, Debug)]
struct HeldControl {
    direction: JogDirection,
    seen: Duration,
    /// True while the press may be a tap: the jog is not kept alive.
    tap: bool,
    /// True once repeats were reported: if they stop, the release was lost.
    repeats: bool,
}

impl Default for HoldToRun {
    fn default() -> Self {
        Self::new()
    }
}

impl HoldToRun {
    /// Creates a control that is not held, and not known to report releases.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            releases: false,
            held: None,
            last: None,
        }
    }

    /// Sets whether the control reports releases. The first reported release or repeat also sets
    /// it.
    pub const fn set_reports_releases(&mut self, reports: bool) {
        self.releases = reports;
    }

    /// True if the control is known to report releases.
    #[must_use]
    pub const fn reports_releases(&self) -> bool {
        self.releases
    }

    /// Direction that is held, if any.
    #[must_use]
    pub fn direction(&self) -> Option<JogDirection> {
        self.held.map(|held| held.direction)
    }

    /// Handles a press of the control for `direction`.
    pub fn press(&mut self, direction: JogDirection, now: Duration) -> HoldAction {
        let again = self.last.is_some_and(|(last, at)| {
            last == direction && now.saturating_sub(at) < MAX_REPEAT_DELAY
        });
        self.last = Some((direction, now));
        match &mut self.held {
            Some(held) if held.direction == direction && !held.tap => {
                held.seen = now;
                HoldAction::Keep
            }
            _ => self.begin(direction, now, !self.releases && !again),
        }
    }

    /// Handles a press reported as a repeat. A control that reports repeats also reports releases.
    pub fn repeat(&mut self, direction: JogDirection, now: Duration) -> HoldAction {
        self.releases = true;
        let action = self.press(direction, now);
        if let Some(held) = &mut self.held {
            held.repeats = true;
        }
        action
    }

    /// Handles the release of the control for `direction`; `None` means any other control.
    pub fn release(&mut self, direction: Option<JogDirection>) -> HoldAction {
        self.releases = true;
        match self.held {
            Some(held) if Some(held.direction) == direction => self.release_all(),
            _ => HoldAction::Nothing,
        }
    }

    /// Handles the passage of time. Call it several times a second while the source of the reports
    /// is alive.
    pub fn tick(&mut self, now: Duration) -> HoldAction {
        let Some(held) = self.held else {
            return HoldAction::Nothing;
        };
        let unseen = now.saturating_sub(held.seen);
        let over = match (held.tap, self.releases) {
            (true, _) => unseen >= TAP_DURATION,
            (false, true) => held.repeats && unseen >= MAX_REPEAT_DELAY,
            (false, false) => unseen >= RELEASE_TIMEOUT,
        };
        if over {
            self.release_all()
        } else if self.releases && !held.tap {
            HoldAction::Keep
        } else {
            // Without reported releases only further presses keep the jog alive.
            HoldAction::Nothing
        }
    }

    /// Ends the jog, whatever the control does.
    pub fn release_all(&mut self) -> HoldAction {
        match self.held.take() {
            Some(_) => HoldAction::End,
            None => HoldAction::Nothing,
        }
    }

    fn begin(&mut self, direction: JogDirection, now: Duration, tap: bool) -> HoldAction {
        self.held = Some(HeldControl {
            direction,
            seen: now,
            tap,
            repeats: false,
        });
        HoldAction::Begin {
            direction,
            keep: DRIVER_HOLD_TIME,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Axis;
    use super::*;

    const UP: JogDirection = JogDirection {
        axis: Axis::X,
        forward: true,
    };
    const DOWN: JogDirection = JogDirection {
        axis: Axis::X,
        forward: false,
    };

    fn ms(time: u64) -> Duration {
        Duration::from_millis(time)
    }

    fn begin(direction: JogDirection) -> HoldAction {
        let keep = DRIVER_HOLD_TIME;
        HoldAction::Begin { direction, keep }
    }

    fn plain() -> HoldToRun {
        HoldToRun::new()
    }

    #[test]
    fn tap_starts_a_short_jog_that_ends_by_itself() {
        let mut hold = plain();
        assert_eq!(hold.press(UP, ms(0)), begin(UP));
        assert_eq!(hold.tick(ms(50)), HoldAction::Nothing);
        assert_eq!(hold.tick(ms(150)), HoldAction::End);
        assert_eq!(hold.tick(ms(200)), HoldAction::Nothing);
        // A second tap much later is a new tap.
        assert_eq!(hold.press(UP, ms(1000)), begin(UP));
    }

    #[test]
    fn jog_lasts_while_key_repeats_arrive() {
        let mut hold = plain();
        hold.press(UP, ms(0));
        assert_eq!(hold.tick(ms(200)), HoldAction::End);
        assert_eq!(hold.press(UP, ms(500)), begin(UP));
        for time in (533..2000).step_by(33) {
            assert_eq!(hold.press(UP, ms(time)), HoldAction::Keep);
            assert_eq!(
                hold.tick(ms(time + 10)),
                HoldAction::Nothing,
                "beats keep nothing"
            );
        }
        assert_eq!(hold.tick(ms(2200)), HoldAction::Nothing);
        assert_eq!(hold.tick(ms(2300)), HoldAction::End);
    }

    #[test]
    fn control_with_releases_jogs_from_press_to_release() {
        let mut hold = plain();
        assert_eq!(hold.release(None), HoldAction::Nothing);
        assert!(hold.reports_releases());
        assert_eq!(hold.press(UP, ms(0)), begin(UP));
        for time in (50..450).step_by(50) {
            assert_eq!(hold.tick(ms(time)), HoldAction::Keep);
        }
        assert_eq!(hold.release(Some(DOWN)), HoldAction::Nothing);
        assert_eq!(hold.release(Some(UP)), HoldAction::End);
        assert_eq!(hold.tick(ms(500)), HoldAction::Nothing);
    }

    #[test]
    fn missing_repeats_reveal_a_lost_release() {
        let mut hold = plain();
        hold.release(None);
        hold.press(UP, ms(0));
        for time in (500..1000).step_by(33) {
            assert_eq!(hold.repeat(UP, ms(time)), HoldAction::Keep);
        }
        assert_eq!(hold.tick(ms(1600)), HoldAction::Keep);
        assert_eq!(hold.tick(ms(1700)), HoldAction::End);
    }

    #[test]
    fn other_direction_starts_a_new_jog() {
        // This model only reports the change; the driver brings the arm to rest between two axes.
        let mut hold = plain();
        hold.press(UP, ms(0));
        assert_eq!(hold.press(DOWN, ms(20)), begin(DOWN));
        assert_eq!(hold.press(DOWN, ms(520)), begin(DOWN));
        assert_eq!(hold.direction(), Some(DOWN));
        assert_eq!(hold.release_all(), HoldAction::End);
        assert_eq!(
            (hold.release_all(), hold.direction()),
            (HoldAction::Nothing, None)
        );
    }
}
