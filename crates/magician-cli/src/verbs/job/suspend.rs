//! Ctrl-Z while a job runs: what is done when, without a terminal and without an arm.
//!
//! The job pauses, the terminal is given back, this program stops. When it is continued the job goes on, unless a person had
//! paused it before, or it burns: a laser is lit again by a person only.

use magician_job::PauseError;

use crate::interrupt::Control;

/// What is to be done next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Act {
    Nothing,
    /// Pause the job; [`Suspension::paused`] wants to know what came of it.
    Pause,
    /// Give the terminal back, and stop this program.
    Stop,
    /// Take the terminal again, and let the job go on.
    GoOn,
    /// Take the terminal again; the job stays paused.
    Stay {
        /// It would go on if it did not burn.
        dark: bool,
    },
    /// It is ending by itself: there is nothing to pause any more, and this program ends with it.
    Ends,
}

/// How far a suspension has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    #[default]
    Not,
    /// The job is on its way to its pause.
    Pausing,
    /// The program has been stopped.
    Stopped,
}

/// The suspension of a job.
#[derive(Debug)]
pub(super) struct Suspension {
    phase: Phase,
    burns: bool,
    /// Whether a person wants the job to be paused, whatever becomes of this program.
    held: bool,
    /// Whether it was continued before it was stopped.
    cancelled: bool,
    /// Whether it is to be suspended again as soon as it is continued.
    again: bool,
}

impl Suspension {
    pub(super) const fn new(burns: bool) -> Self {
        Self {
            phase: Phase::Not,
            burns,
            held: false,
            cancelled: false,
            again: false,
        }
    }

    /// A person pauses the job, or wants it to go on.
    pub(super) const fn holds(&mut self, held: bool) {
        self.held = held;
    }

    /// Something of job control has come; `paused` is whether the job is paused, or on its way to that.
    pub(super) fn hears(&mut self, control: Control, paused: bool) -> Act {
        match (self.phase, control) {
            (Phase::Not, Control::Continue) => Act::Nothing,
            (Phase::Not, Control::Suspend) => {
                self.phase = Phase::Pausing;
                self.held |= paused;
                (self.cancelled, self.again) = (false, false);
                Act::Pause
            }
            (Phase::Pausing, control) => {
                self.cancelled = control == Control::Continue;
                Act::Nothing
            }
            (Phase::Stopped, Control::Suspend) => {
                self.again = true;
                Act::Nothing
            }
            (Phase::Stopped, Control::Continue) if self.again => {
                self.again = false;
                Act::Stop
            }
            (Phase::Stopped, Control::Continue) => self.goes_on(),
        }
    }

    /// The job is paused, or is not.
    pub(super) fn paused(&mut self, paused: Result<(), PauseError>) -> Act {
        match paused {
            Err(_) => {
                self.phase = Phase::Not;
                Act::Ends
            }
            Ok(()) if self.cancelled => self.goes_on(),
            Ok(()) => {
                self.phase = Phase::Stopped;
                Act::Stop
            }
        }
    }

    const fn goes_on(&mut self) -> Act {
        self.phase = Phase::Not;
        if self.held {
            Act::Stay { dark: false }
        } else if self.burns {
            self.held = true;
            Act::Stay { dark: true }
        } else {
            Act::GoOn
        }
    }
}

#[cfg(test)]
mod tests {
    use Control::{Continue, Suspend};

    use super::*;

    #[test]
    fn a_job_pauses_before_its_program_stops_and_goes_on_with_it() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.paused(Ok(())), Act::Stop);
        assert_eq!(suspension.hears(Continue, true), Act::GoOn);
        assert_eq!(suspension.hears(Continue, false), Act::Nothing);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
    }

    #[test]
    fn what_burns_or_was_paused_before_stays_paused() {
        let mut suspension = Suspension::new(true);
        for dark in [true, false] {
            assert_eq!(suspension.hears(Suspend, !dark), Act::Pause);
            assert_eq!(suspension.paused(Ok(())), Act::Stop);
            assert_eq!(suspension.hears(Continue, true), Act::Stay { dark });
        }
        // Once a person has let it go on it is as at first.
        suspension.holds(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.paused(Ok(())), Act::Stop);
        assert_eq!(suspension.hears(Continue, true), Act::Stay { dark: true });

        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        // A line of JSON, on the way.
        suspension.holds(true);
        assert_eq!(suspension.paused(Ok(())), Act::Stop);
        assert_eq!(suspension.hears(Continue, true), Act::Stay { dark: false });
    }

    #[test]
    fn a_second_wish_on_the_way_changes_nothing_and_a_going_on_takes_it_back() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.hears(Suspend, true), Act::Nothing);
        assert_eq!(suspension.hears(Continue, true), Act::Nothing);
        assert_eq!(suspension.hears(Suspend, true), Act::Nothing);
        assert_eq!(suspension.paused(Ok(())), Act::Stop);
        assert_eq!(suspension.hears(Continue, true), Act::GoOn);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.hears(Continue, true), Act::Nothing);
        assert_eq!(suspension.paused(Ok(())), Act::GoOn);
    }

    #[test]
    fn a_wish_that_comes_with_the_going_on_is_followed_after_it() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.paused(Ok(())), Act::Stop);
        assert_eq!(suspension.hears(Suspend, true), Act::Nothing);
        assert_eq!(suspension.hears(Continue, true), Act::Stop);
        assert_eq!(suspension.hears(Continue, true), Act::GoOn);
    }

    #[test]
    fn a_job_that_ends_on_the_way_is_not_waited_for_twice() {
        let mut suspension = Suspension::new(false);
        assert_eq!(suspension.hears(Suspend, false), Act::Pause);
        assert_eq!(suspension.paused(Err(PauseError::Ending)), Act::Ends);
    }
}
