use magician_protocol::Deframer;

use super::doubt::Doubt;
use super::job::{Job, Policy, Purpose};
use super::{Connection, Failure};

/// The controller's clock is asked for so often on a line that was found again; one that does not answer has none.
const CLOCK_TRIES: u32 = 3;

/// The line, from the connection's point of view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    /// It is there.
    Up,
    /// It is gone; nothing goes out.
    Down,
    /// It is there again, and what stands at its end is being looked at; nothing of the stream goes out.
    Found(Seen),
}

/// What was read since the line was found again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Seen {
    clock: bool,
    clock_tries: u32,
    current: bool,
    left: bool,
}

/// A line that is lost and found.
impl Connection {
    /// The line is gone. Nothing that was submitted goes out any more, on no line: what went out and may have been taken
    /// ends as [`Failure::Uncertain`], everything else as [`Failure::Lost`]. One exception is the command in doubt that
    /// stood alone: it waits for [`restored`](Self::restored), at most until its deadline, when what the controller then
    /// says settles it. There is no exception, and all indices are forgotten, if the controller's clock was never read: then
    /// nothing would tell whether the controller was reset meanwhile.
    ///
    /// Until then nothing is sent. What is submitted waits.
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
        while let Some(job) = self.flight.pop() {
            match job.policy {
                _ if job.purpose != Purpose::Caller => {}
                Policy::Once | Policy::Doubt if !job.due => self.uncertain(job),
                _ => self.done(job.ticket, Err(Failure::Lost)),
            }
        }
        if let Some(mut job) = kept {
            (job.over, job.cut) = (true, true);
            self.enter_doubt(job);
        }
        if !clocked {
            if self.settings.ordered {
                self.tracker.begin_anew();
            } else {
                self.tracker.forget();
            }
            self.witness.resume(None);
        }
        self.link = Link::Down;
    }

    /// The line to the same arm is there again. Before anything of the stream goes out the controller's clock, its current
    /// index and its left space are read; a controller that was reset meanwhile makes an [`Event::Reset`](super::Event).
    /// A command that was in doubt when the line broke ends with its answer when it was taken, as [`Failure::Lost`] when
    /// it was not, as [`Failure::Uncertain`] when that is unknown; it is not sent again.
    pub fn restored(&mut self) {
        self.deframer = Deframer::new();
        self.pace.begin_anew();
        if let Some(doubt) = &mut self.doubt {
            doubt.begin_anew();
        }
        self.link = Link::Found(Seen::default());
    }

    /// The queue was cleared by another connection on the line that is there again, before this one went on.
    pub fn was_cleared(&mut self) {
        self.note_clear();
    }

    /// The one queued command that is not accounted for.
    fn take_single(&mut self) -> Option<Job> {
        if let Some(Doubt { job, .. }) = self.doubt.take() {
            return Some(job);
        }
        let single = self.queued_unanswered() == 1 && self.tracker.is_confirmed();
        let at = (self.flight.iter()).position(|job| job.queued() && !job.due)?;
        (single && !self.witness.is_broken()).then(|| self.flight.remove(at))
    }

    /// What is to be read on a line that was found again, doubts aside.
    pub(super) fn next_look(&self) -> Option<Purpose> {
        match self.link {
            Link::Found(Seen { clock: false, .. }) => Some(Purpose::Clock),
            Link::Found(_) if self.doubt.is_some() => None,
            Link::Found(Seen { current: false, .. }) => Some(Purpose::Current),
            Link::Found(Seen { left: false, .. }) => Some(Purpose::Left),
            _ => None,
        }
    }

    /// Something was read.
    pub(super) fn seen(&mut self, purpose: Purpose) {
        let Link::Found(seen) = &mut self.link else {
            return;
        };
        match purpose {
            Purpose::Clock => seen.clock = true,
            Purpose::Current => seen.current = true,
            Purpose::Left => seen.left = true,
            _ => {}
        }
        if seen.clock && seen.current && seen.left {
            self.link = Link::Up;
        }
    }

    /// The clock did not answer.
    pub(super) fn missed_clock(&mut self) {
        if let Link::Found(seen) = &mut self.link {
            seen.clock_tries += 1;
            if seen.clock_tries >= CLOCK_TRIES {
                self.seen(Purpose::Clock);
            }
        }
    }
}
