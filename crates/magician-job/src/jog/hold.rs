//! A key that is held, as a dead man's control.
//!
//! Some terminals tell when a key is released: there the jog goes on from press to release. Most tell presses only, and a held
//! key as presses again and again, the second half a second after the first. There a press alone jogs for a moment, so that a
//! tap is a nudge; when it comes again soon it is being held, and the jog goes on from then until no more come. Which kind it is
//! shows with the first release that is told.

use std::time::Duration;

use super::axis::Heading;

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
pub enum Turn {
    /// Jog from now on; it ends by itself after `keep` unless kept up.
    Begin {
        /// Which way.
        heading: Heading,
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
pub struct Hold {
    /// Whether releases are told.
    releases: bool,
    held: Option<Held>,
    /// The last press.
    last: Option<(Heading, Duration)>,
}

#[derive(Clone, Copy, Debug)]
struct Held {
    heading: Heading,
    seen: Duration,
    /// It is a tap as far as is known: it is not kept up.
    tap: bool,
    /// Repeats were told: if they fail to come, the release was lost.
    repeats: bool,
}

impl Hold {
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
    pub fn tells_releases(&self) -> bool {
        self.releases
    }

    /// The way that is being jogged.
    #[must_use]
    pub fn heading(&self) -> Option<Heading> {
        self.held.map(|held| held.heading)
    }

    /// A press of a key.
    pub fn press(&mut self, heading: Heading, now: Duration) -> Turn {
        let again = self
            .last
            .is_some_and(|(last, at)| last == heading && now.saturating_sub(at) < REPEATS);
        self.last = Some((heading, now));
        match &mut self.held {
            Some(held) if held.heading == heading && !held.tap => {
                held.seen = now;
                Turn::Keep
            }
            _ => self.begin(heading, now, !self.releases && !again),
        }
    }

    /// A repeat that the terminal tells as one: then it tells releases too.
    pub fn repeat(&mut self, heading: Heading, now: Duration) -> Turn {
        self.releases = true;
        let turn = self.press(heading, now);
        if let Some(held) = &mut self.held {
            held.repeats = true;
        }
        turn
    }

    /// A release of the key that jogs this way; of another key with `None`.
    pub fn release(&mut self, heading: Option<Heading>) -> Turn {
        self.releases = true;
        match self.held {
            Some(held) if Some(held.heading) == heading => self.let_go(),
            _ => Turn::Nothing,
        }
    }

    /// The keyboard is well, and nothing has come of it.
    pub fn beat(&mut self, now: Duration) -> Turn {
        let Some(held) = self.held else {
            return Turn::Nothing;
        };
        let unseen = now.saturating_sub(held.seen);
        let over = match (held.tap, self.releases) {
            (true, _) => unseen >= TAP,
            (false, true) => held.repeats && unseen >= REPEATS,
            (false, false) => unseen >= HELD,
        };
        match over {
            true => self.let_go(),
            // Without releases only the key itself keeps it up.
            false if self.releases && !held.tap => Turn::Keep,
            false => Turn::Nothing,
        }
    }

    /// Ends it, whatever the key does.
    pub fn let_go(&mut self) -> Turn {
        match self.held.take() {
            Some(_) => Turn::End,
            None => Turn::Nothing,
        }
    }

    fn begin(&mut self, heading: Heading, now: Duration, tap: bool) -> Turn {
        self.held = Some(Held {
            heading,
            seen: now,
            tap,
            repeats: false,
        });
        Turn::Begin {
            heading,
            keep: KEEP,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::axis::Axis;
    use super::*;

    const UP: Heading = Heading {
        axis: Axis::X,
        forward: true,
    };
    const DOWN: Heading = Heading {
        axis: Axis::X,
        forward: false,
    };

    fn ms(time: u64) -> Duration {
        Duration::from_millis(time)
    }

    fn begin(heading: Heading) -> Turn {
        let keep = KEEP;
        Turn::Begin { heading, keep }
    }

    fn plain() -> Hold {
        Hold::new()
    }

    #[test]
    fn a_tap_is_a_short_jog_that_ends_by_itself() {
        let mut hold = plain();
        assert_eq!(hold.press(UP, ms(0)), begin(UP));
        assert_eq!(hold.beat(ms(50)), Turn::Nothing);
        assert_eq!(hold.beat(ms(150)), Turn::End);
        assert_eq!(hold.beat(ms(200)), Turn::Nothing);
        // A second tap much later is one again.
        assert_eq!(hold.press(UP, ms(1000)), begin(UP));
    }

    #[test]
    fn repeats_keep_it_up_until_no_more_come() {
        let mut hold = plain();
        hold.press(UP, ms(0));
        assert_eq!(hold.beat(ms(200)), Turn::End);
        assert_eq!(hold.press(UP, ms(500)), begin(UP));
        for time in (533..2000).step_by(33) {
            assert_eq!(hold.press(UP, ms(time)), Turn::Keep);
            assert_eq!(
                hold.beat(ms(time + 10)),
                Turn::Nothing,
                "beats keep nothing"
            );
        }
        assert_eq!(hold.beat(ms(2200)), Turn::Nothing);
        assert_eq!(hold.beat(ms(2300)), Turn::End);
    }

    #[test]
    fn a_terminal_with_releases_jogs_from_press_to_release() {
        let mut hold = plain();
        assert_eq!(hold.release(None), Turn::Nothing);
        assert!(hold.tells_releases());
        assert_eq!(hold.press(UP, ms(0)), begin(UP));
        for time in (50..450).step_by(50) {
            assert_eq!(hold.beat(ms(time)), Turn::Keep);
        }
        assert_eq!(hold.release(Some(DOWN)), Turn::Nothing);
        assert_eq!(hold.release(Some(UP)), Turn::End);
        assert_eq!(hold.beat(ms(500)), Turn::Nothing);
    }

    #[test]
    fn a_release_that_was_lost_shows_in_repeats_that_do_not_come() {
        let mut hold = plain();
        hold.release(None);
        hold.press(UP, ms(0));
        for time in (500..1000).step_by(33) {
            assert_eq!(hold.repeat(UP, ms(time)), Turn::Keep);
        }
        assert_eq!(hold.beat(ms(1600)), Turn::Keep);
        assert_eq!(hold.beat(ms(1700)), Turn::End);
    }

    #[test]
    fn another_way_takes_its_place() {
        let mut hold = plain();
        hold.press(UP, ms(0));
        assert_eq!(hold.press(DOWN, ms(20)), begin(DOWN));
        assert_eq!(hold.press(DOWN, ms(520)), begin(DOWN));
        assert_eq!(hold.heading(), Some(DOWN));
        assert_eq!(hold.let_go(), Turn::End);
        assert_eq!((hold.let_go(), hold.heading()), (Turn::Nothing, None));
    }
}
