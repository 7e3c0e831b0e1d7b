//! A hold-to-run control: the arm moves only while it is held (a dead man's switch).
//!
//! Some controls report when they are released: there the jog goes on from press to release. Others report presses only, and a held
//! one as presses again and again, the second half a second after the first (keys of most terminals). There a press alone jogs for a
//! moment, so that a tap is a nudge; when it comes again soon the control is being held, and the jog goes on from then until no more
//! come. Which kind it is shows with the first release that is reported.

use std::time::Duration;

use super::JogDirection;

/// How long a jog goes on after its control was reported as held last.
const HELD: Duration = Duration::from_millis(250);
/// How long the driver lets it go on when it hears nothing from here: a little longer, for when this program hangs.
const KEEP: Duration = Duration::from_millis(300);
/// How long a tap jogs, where releases are not reported.
const TAP: Duration = Duration::from_millis(150);
/// A press that comes again within this time is a hold: longer than the longest delay before keys repeat (660 ms under X).
const REPEATS: Duration = Duration::from_millis(700);

/// What a report of the control comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldAction {
    /// Jog from now on; it ends by itself after `keep` unless kept up.
    Begin {
        /// Which way.
        direction: JogDirection,
        /// For how long without being kept up.
        keep: Duration,
    },
    /// Let it go on.
    Keep,
    /// End it.
    End,
    /// Nothing changes.
    Nothing,
}

/// The control that is held, and what is known of its kind. Times are since any beginning, the same for all calls.
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
    /// Whether releases are reported.
    releases: bool,
    held: Option<Held>,
    /// The last press.
    last: Option<(JogDirection, Duration)>,
}

#[derive(Clone, Copy, Debug)]
struct Held {
    direction: JogDirection,
    seen: Duration,
    /// It is a tap as far as is known: it is not kept up.
    tap: bool,
    /// Repeats were reported: if they fail to come, the release was lost.
    repeats: bool,
}

impl Default for HoldToRun {
    fn default() -> Self {
        Self::new()
    }
}

impl HoldToRun {
    /// Nothing is held, and nothing is known of releases.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            releases: false,
            held: None,
            last: None,
        }
    }

    /// Says that releases are reported, or are not as far as is known. The first release or repeat that is reported says so, too.
    pub const fn set_reports_releases(&mut self, reports: bool) {
        self.releases = reports;
    }

    /// Whether the control is known to report releases.
    #[must_use]
    pub const fn reports_releases(&self) -> bool {
        self.releases
    }

    /// The direction that is held.
    #[must_use]
    pub fn direction(&self) -> Option<JogDirection> {
        self.held.map(|held| held.direction)
    }

    /// The control of a direction was pressed.
    pub fn press(&mut self, direction: JogDirection, now: Duration) -> HoldAction {
        let again = self
            .last
            .is_some_and(|(last, at)| last == direction && now.saturating_sub(at) < REPEATS);
        self.last = Some((direction, now));
        match &mut self.held {
            Some(held) if held.direction == direction && !held.tap => {
                held.seen = now;
                HoldAction::Keep
            }
            _ => self.begin(direction, now, !self.releases && !again),
        }
    }

    /// A repeat that is reported as one: such a control reports releases, too.
    pub fn repeat(&mut self, direction: JogDirection, now: Duration) -> HoldAction {
        self.releases = true;
        let turn = self.press(direction, now);
        if let Some(held) = &mut self.held {
            held.repeats = true;
        }
        turn
    }

    /// The control of this direction was released; with `None` any other one.
    pub fn release(&mut self, direction: Option<JogDirection>) -> HoldAction {
        self.releases = true;
        match self.held {
            Some(held) if Some(held.direction) == direction => self.release_all(),
            _ => HoldAction::Nothing,
        }
    }

    /// The control is alive and nothing was reported: to be called several times a second.
    pub fn tick(&mut self, now: Duration) -> HoldAction {
        let Some(held) = self.held else {
            return HoldAction::Nothing;
        };
        let unseen = now.saturating_sub(held.seen);
        let over = match (held.tap, self.releases) {
            (true, _) => unseen >= TAP,
            (false, true) => held.repeats && unseen >= REPEATS,
            (false, false) => unseen >= HELD,
        };
        if over {
            self.release_all()
        } else if self.releases && !held.tap {
            HoldAction::Keep
        } else {
            // Without releases only further presses keep it up.
            HoldAction::Nothing
        }
    }

    /// Ends it, whatever the control does.
    pub fn release_all(&mut self) -> HoldAction {
        match self.held.take() {
            Some(_) => HoldAction::End,
            None => HoldAction::Nothing,
        }
    }

    fn begin(&mut self, direction: JogDirection, now: Duration, tap: bool) -> HoldAction {
        self.held = Some(Held {
            direction,
            seen: now,
            tap,
            repeats: false,
        });
        HoldAction::Begin {
            direction,
            keep: KEEP,
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
        let keep = KEEP;
        HoldAction::Begin { direction, keep }
    }

    fn plain() -> HoldToRun {
        HoldToRun::new()
    }

    #[test]
    fn a_tap_is_a_short_jog_that_ends_by_itself() {
        let mut hold = plain();
        assert_eq!(hold.press(UP, ms(0)), begin(UP));
        assert_eq!(hold.tick(ms(50)), HoldAction::Nothing);
        assert_eq!(hold.tick(ms(150)), HoldAction::End);
        assert_eq!(hold.tick(ms(200)), HoldAction::Nothing);
        // A second tap much later is one again.
        assert_eq!(hold.press(UP, ms(1000)), begin(UP));
    }

    #[test]
    fn repeats_keep_it_up_until_no_more_come() {
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
    fn a_control_with_releases_jogs_from_press_to_release() {
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
    fn a_release_that_was_lost_shows_in_repeats_that_do_not_come() {
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
    fn another_direction_is_a_jog_of_its_own() {
        // The control only says so; that the arm comes to rest between two axes is the driver's.
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
