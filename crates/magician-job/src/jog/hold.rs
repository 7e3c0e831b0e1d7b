//! A key that is held, as a dead man's control.
//!
//! Some terminals tell when a key is released: there the jog goes on from press to release. Most tell presses only, and a held
//! key as presses again and again, the second half a second after the first. There a press alone jogs for a moment, so that a
//! tap is a nudge; when it comes again soon it is being held, and the jog goes on from then until no more come. Which kind it is
//! shows with the first release that is told.

use std::time::Duration;

use super::axis::JogDirection;

/// How long a jog goes on after its key was seen held last.
const HELD: Duration = Duration::from_millis(250);
/// How long the driver lets it go on when it hears nothing from here: a little longer, for when this hangs.
const KEEP: Duration = Duration::from_millis(300);
/// How long a tap jogs, where releases are not told.
const TAP: Duration = Duration::from_millis(150);
/// A key that comes again within this time is being held: longer than the longest delay before keys repeat (660 ms under X).
const REPEATS: Duration = Duration::from_millis(700);

/// What a key comes to. Times are since some beginning.
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

/// The key that is held, and what the terminal tells of keys.
#[derive(Clone, Debug)]
pub struct HoldToRun {
    /// Whether releases are told.
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
    /// Repeats were told: if they fail to come, the release was lost.
    repeats: bool,
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

    /// Whether the terminal is known to tell releases.
    #[must_use]
    pub fn reports_releases(&self) -> bool {
        self.releases
    }

    /// The way that is being jogged.
    #[must_use]
    pub fn direction(&self) -> Option<JogDirection> {
        self.held.map(|held| held.direction)
    }

    /// A press of a key.
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

    /// A repeat that the terminal tells as one: then it tells releases too.
    pub fn repeat(&mut self, direction: JogDirection, now: Duration) -> HoldAction {
        self.releases = true;
        let turn = self.press(direction, now);
        if let Some(held) = &mut self.held {
            held.repeats = true;
        }
        turn
    }

    /// A release of the key that jogs this way; of another key with `None`.
    pub fn release(&mut self, direction: Option<JogDirection>) -> HoldAction {
        self.releases = true;
        match self.held {
            Some(held) if Some(held.direction) == direction => self.release_all(),
            _ => HoldAction::Nothing,
        }
    }

    /// The keyboard is well, and nothing has come of it.
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
        match over {
            true => self.release_all(),
            // Without releases only the key itself keeps it up.
            false if self.releases && !held.tap => HoldAction::Keep,
            false => HoldAction::Nothing,
        }
    }

    /// Ends it, whatever the key does.
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
    use super::super::axis::Axis;
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
    fn a_terminal_with_releases_jogs_from_press_to_release() {
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
    fn another_way_takes_its_place() {
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
