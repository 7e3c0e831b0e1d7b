//! Notifications that tell how something is now, and change as often as clients like: the list of sessions, the progress of
//! a job and its place in the queue. They go out at once, and then no more often than their interval; what a client is sent is
//! made when it takes it.

use std::collections::BTreeMap;
use std::time::Duration;

use magician_protocol::HostInstant;
use serde_json::json;

use super::Station;
use crate::api::Notice;
use crate::control::JobId;

/// Least time from one list to the next for a client, as people cannot read it faster. A queue of jobs is a list.
pub const LIST_INTERVAL: Duration = Duration::from_millis(200);
/// Least time from one progress of a job to the next: a bar that grows by the eye.
pub(super) const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);

/// What a client has the newest of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Newest {
    /// The list of sessions.
    Sessions,
    /// Turns, where the jobs that wait for arms are others.
    #[cfg(feature = "class")]
    Turns,
    /// A job.
    Job(JobId),
    /// The state of an arm, for the subscription of this number.
    State(u16),
}

/// What was told of late, and what is to be told.
#[derive(Debug, Default)]
pub(super) struct Telling {
    told: BTreeMap<Newest, HostInstant>,
    due: BTreeMap<Newest, HostInstant>,
}

impl Telling {
    /// Has it told, once this interval has passed since it was told last.
    pub(super) fn changed(&mut self, what: Newest, interval: Duration) {
        let told = self.told.get(&what);
        let due = told.map_or(HostInstant::ZERO, |told| *told + interval);
        let waiting = self.due.entry(what).or_insert(due);
        *waiting = due.min(*waiting);
    }

    /// Notes that it is told, in whatever way.
    pub(super) fn is_told(&mut self, now: HostInstant, what: Newest) {
        self.due.remove(&what);
        self.told.insert(what, now);
    }

    /// When something is to be told. `None` if nothing has changed.
    pub(super) fn due(&self) -> Option<HostInstant> {
        self.due.values().min().copied()
    }

    /// Takes what is to be told now.
    fn take_due(&mut self, now: HostInstant) -> Vec<Newest> {
        // After the longest interval it makes no difference any more.
        self.told.retain(|_, told| *told + LIST_INTERVAL > now);
        let is_due = |(_, due): &(&Newest, &HostInstant)| **due <= now;
        let due: Vec<_> = self
            .due
            .iter()
            .filter(is_due)
            .map(|(what, _)| *what)
            .collect();
        for what in &due {
            self.is_told(now, *what);
        }
        due
    }
}

impl Station {
    /// Tells all sessions what has changed and is due. It is made when it is sent: of a client that reads slowly one of each
    /// waits, which is the newest.
    pub(super) fn tell_newest(&mut self, now: HostInstant) {
        for what in self.telling.take_due(now) {
            #[cfg(feature = "class")]
            if what == Newest::Turns {
                self.class.turns_changed = true;
                self.tell_turns(now);
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

    /// Tells all sessions a job as it is now: each state is told. What waited of it is older.
    pub(super) fn tell_job(&mut self, now: HostInstant, job: JobId) {
        let Some(text) = self.job_notice(job) else {
            return;
        };
        self.telling.is_told(now, Newest::Job(job));
        let sockets: Vec<_> = { self.sessions.values() }
            .filter_map(|session| session.socket)
            .collect();
        for socket in sockets {
            if let Some(open) = self.sockets.get_mut(&socket) {
                open.outbox.state_is_void(Newest::Job(job));
            }
            self.notify_socket(socket, text.clone());
        }
    }

    /// A job as a notification. `None` if it is deleted by now.
    pub(super) fn job_notice(&mut self, job: JobId) -> Option<String> {
        let shown = self.records.numbered(job)?.shown();
        Some(Notice::JobChanged.message(&json!({"job": shown})))
    }
}
