//! Lost lines, and the checks before a restored line is used.
//!
//! A line may break with a command in doubt. The controller at its end afterwards may be the same
//! one, a restarted one, or one whose queue another connection cleared. So after
//! [`Connection::restored`] the controller's clock, current index and left space are read before
//! anything of the stream is sent.

use magician_protocol::Deframer;

use super::doubt::Doubt;
use super::job::{Job, Policy, Purpose};
use super::{Connection, Failure};

/// Attempts to read the controller's clock on a restored line. A controller without a clock does
/// not answer, and must not block the line for ever. The number is a choice.
const CLOCK_TRIES: u32 = 3;

/// State of the line, from the connection's point of view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    /// The line works.
    Up,
    /// The line is lost; nothing is sent.
    Down,
    /// The line is restored and its controller is being checked; nothing of the stream is sent.
    Restored(RestoredReadings),
}

/// Readings taken since the line was restored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct RestoredReadings {
    clock: bool,
    clock_tries: u32,
    current: bool,
    left: bool,
}

/// Lost and restored lines.
impl Connection {
    /// Reports that the line is lost. Until [`restored`](Self::restored) nothing is sent, and new
    /// requests wait.
    ///
    /// Requests submitted before are not sent any more, on any line: commands that may have been
    /// taken end as [`Failure::Uncertain`], all others as [`Failure::Lost`]. The exception is a
    /// queued command that was in doubt or in flight alone: it waits, at most until its deadline,
    /// and the readings on the restored line settle it. If the controller's clock was never read
    /// there is no exception and all indices are forgotten, because a reset in between would go
    /// unnoticed.
    pub fn interrupt(&mut self) {
        self.deframer = Deframer::new();
        self.pace.begin_anew();
        while let Some(job) = self
            .lanes
            .iter_mut()
            .find_map(std::collections::VecDeque::pop_front)
        {
            self.done(job.ticket, Err(Failure::Lost));
        }
        let clocked = self.uptime.is_known();
        let mut kept = self.take_single();
        if let Some(job) = kept.take_if(|_| !clocked) {
            self.uncertain(job);
        }
        // A late reply on the restored line answers no job, so each job ends now.
        while let Some(job) = self.flight.pop() {
            match job.policy {
                // The connection's own readings have no caller.
                _ if job.purpose != Purpose::Caller => {}
                Policy::AtMostOnce | Policy::Doubt if !job.needs_retransmit => self.uncertain(job),
                _ => self.done(job.ticket, Err(Failure::Lost)),
            }
        }
        if let Some(mut job) = kept {
            (job.no_retransmit, job.line_broke) = (true, true);
            self.enter_doubt(job);
        }
        if !clocked {
            // A new ordered line carries no reply of the old one, not even the last index
            // again.
            if self.settings.ordered {
                self.tracker.begin_anew();
            } else {
                self.tracker.forget();
            }
            self.law_monitor.resume(None);
        }
        self.link = Link::Down;
    }

    /// Reports that the line to the same arm works again.
    ///
    /// Before anything of the stream is sent, the controller's clock, current index and left space
    /// are read; a reset in between causes an [`Event::Reset`](super::Event). A command in doubt
    /// when the line broke ends with its reply if it was taken, as [`Failure::Lost`] if it was not,
    /// and as [`Failure::Uncertain`] if neither can be shown. It is not retransmitted.
    pub fn restored(&mut self) {
        self.deframer = Deframer::new();
        self.pace.begin_anew();
        if let Some(doubt) = &mut self.doubt {
            doubt.reset_readings();
        }
        self.link = Link::Restored(RestoredReadings::default());
    }

    /// Reports that another connection cleared the queue on the restored line before this one
    /// continued.
    pub fn was_cleared(&mut self) {
        self.note_clear();
    }

    /// Removes the single queued command that is unaccounted for. `None` if there is none, or
    /// several.
    fn take_single(&mut self) -> Option<Job> {
        if let Some(Doubt { job, .. }) = self.doubt.take() {
            return Some(job);
        }
        let single = self.queued_unanswered() == 1 && self.tracker.is_confirmed();
        let at = (self.flight.iter()).position(|job| job.queued() && !job.needs_retransmit)?;
        (single && !self.law_monitor.is_broken()).then(|| self.flight.remove(at))
    }

    /// Next reading on a restored line, apart from those of a doubt.
    pub(super) fn next_restore_reading(&self) -> Option<Purpose> {
        match self.link {
            Link::Restored(RestoredReadings { clock: false, .. }) => Some(Purpose::Clock),
            // The doubt reads current index and left space itself.
            Link::Restored(_) if self.doubt.is_some() => None,
            Link::Restored(RestoredReadings { current: false, .. }) => Some(Purpose::Current),
            Link::Restored(RestoredReadings { left: false, .. }) => Some(Purpose::Left),
            _ => None,
        }
    }

    /// Notes that a reading arrived.
    pub(super) fn note_restore_reading(&mut self, purpose: Purpose) {
        let Link::Restored(seen) = &mut self.link else {
            return;
        };
        match purpose {
            Purpose::Clock => seen.clock = true,
            Purpose::Current => seen.current = true,
            Purpose::Left => seen.left = true,
            // Only the three readings above are noted.
            _ => {}
        }
        if seen.clock && seen.current && seen.left {
            self.link = Link::Up;
        }
    }

    /// Notes that a read of the clock was not answered.
    pub(super) fn note_clock_timeout(&mut self) {
        if let Link::Restored(seen) = &mut self.link {
            seen.clock_tries += 1;
            if seen.clock_tries >= CLOCK_TRIES {
                self.note_restore_reading(Purpose::Clock);
            }
        }
    }
}
