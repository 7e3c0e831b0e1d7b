//! Notifications that carry a current value: the list of sessions, progress of a job, its position
//! in the queue.
//!
//! Clients can make these values change as often as they like. So each is sent at once and then at
//! most once per interval, and its text is made when the client takes it: a slow client gets the
//! newest value instead of a backlog.

use std::collections::BTreeMap;
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::json;

use super::Station;
use crate::api::Notice;
use crate::control::JobId;

/// Shortest interval between two lists for a client. People cannot read faster. The queue of jobs
/// is such a list.
pub const LIST_INTERVAL: Duration = Duration::from_millis(200);
/// Shortest interval between two notifications of a job's progress: fast enough for a smooth
/// progress bar.
pub(super) const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);

/// Value of which a client gets only the newest version.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Newest {
    /// List of sessions.
    Sessions,
    /// Turns, when the jobs that wait for arms have changed.
    #[cfg(feature = "class")]
    Turns,
    /// Job.
    Job(JobId),
    /// State of an arm, by subscription.
    State(u16),
}

/// Values that were sent recently, and values that are due.
#[derive(Debug, Default)]
pub(super) struct NoticeRates {
    sent: BTreeMap<Newest, HostInstant>,
    due: BTreeMap<Newest, HostInstant>,
}

impl NoticeRates {
    /// Marks a value as changed. It is sent when `interval` has passed since it was sent last.
    pub(super) fn changed(&mut self, what: Newest, interval: Duration) {
        let sent = self.sent.get(&what);
        let due = sent.map_or(HostInstant::ZERO, |sent| *sent + interval);
        let waiting = self.due.entry(what).or_insert(due);
        // The earlier of two intervals wins.
        *waiting = due.min(*waiting);
    }

    /// Records that a value has been sent.
    pub(super) fn mark_sent(&mut self, now: HostInstant, what: Newest) {
        self.due.remove(&what);
        self.sent.insert(what, now);
    }

    /// Returns the next deadline. `None` if nothing has changed.
    pub(super) fn due(&self) -> Option<HostInstant> {
        self.due.values().min().copied()
    }

    /// Removes and returns the values that are due.
    fn take_due(&mut self, now: HostInstant) -> Vec<Newest> {
        // Older entries no longer delay anything.
        self.sent.retain(|_, sent| *sent + LIST_INTERVAL > now);
        let is_due = |(_, due): &(&Newest, &HostInstant)| **due <= now;
        let due: Vec<_> = self
            .due
            .iter()
            .filter(is_due)
            .map(|(what, _)| *what)
            .collect();
        for what in &due {
            self.mark_sent(now, *what);
        }
        due
    }
}

impl Station {
    /// Queues the values that are due for all sessions. The text is made when it is sent, so at
    /// most one of each value waits for a slow client.
    pub(super) fn queue_due(&mut self, now: HostInstant) {
        for what in self.notice_rates.take_due(now) {
            #[cfg(feature = "class")]
            if what == Newest::Turns {
                self.class.turns_changed = true;
                self.notify_turns(now);
                continue;
            }
            for socket in self.sessions.values().filter_map(|session| session.socket) {
                if let Some(open) = self.sockets.get_mut(&socket)
                    && open.outbox.state_due(what)
                {
                    self.awake.insert(socket);
                }
            }
        }
    }

    /// Sends a job to all sessions in its current state. Every change of state is sent; a waiting
    /// progress of the same job is dropped as outdated.
    pub(super) fn notify_job(&mut self, now: HostInstant, job: JobId) {
        let Some(text) = self.job_notice(job) else {
            return;
        };
        self.notice_rates.mark_sent(now, Newest::Job(job));
        let sockets: Vec<_> = { self.sessions.values() }
            .filter_map(|session| session.socket)
            .collect();
        for socket in sockets {
            if let Some(open) = self.sockets.get_mut(&socket) {
                open.outbox.drop_state(Newest::Job(job));
            }
            self.notify_socket(socket, text.clone());
        }
    }

    /// Returns the notification of a job. `None` if the job was deleted.
    pub(super) fn job_notice(&mut self, job: JobId) -> Option<String> {
        let shown = self.records.numbered(job)?.shown();
        Some(Notice::JobChanged.message(&json!({"job": shown})))
    }
}
