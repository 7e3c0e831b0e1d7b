//! Table of notifications. The station sends no others, because [`Notice`] has no other.
//! Documentation, schema, types and tests are derived from it.

use super::IdKind::{Job, Jog, Lease, Session, Subscription};
use super::shape::{Member, Shape, is};
use super::{IdPlace, notification};
use crate::control::JogEnd;
use serde_json::Value;

/// Notification of a station.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Notification {
    /// Name.
    pub name: &'static str,
    /// Member that names the arm. `None` if the notification is not about an arm, or a subscription
    /// identifies it.
    pub arm: Option<&'static str>,
    /// Ids in its parameters.
    pub ids: &'static [IdPlace],
    /// Recipients.
    pub to: &'static str,
    /// Condition under which it is sent.
    pub when: &'static str,
    /// Which notification to use, if several carry the same fact. Empty if only this one does.
    pub channel: &'static str,
    /// Members of its parameters. Those of `arm.event` are an `Event` instead.
    pub params: &'static [Member],
}

macro_rules! notices {
    ($($(#[$about:meta])* $notice:ident = $name:literal {
        to: $to:literal, when: $when:literal, channel: $channel:literal, arm: $arm:expr, ids: $ids:expr, params: $params:expr,
    })*) => {
        /// Kind of notification.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Notice {
            $($(#[$about])* $notice,)*
        }

        /// All notifications, in documentation order.
        pub static NOTIFICATIONS: &[Notification] = &[$(Notification {
            name: $name, arm: $arm, ids: $ids, to: $to, when: $when, channel: $channel, params: $params,
        },)*];

        impl Notice {
            /// Returns the name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$notice => $name,)*
                }
            }
        }
    };
}

const ARM: Member = is("arm", Shape::Text, "name of the arm");
const EVERYBODY: &[IdPlace] = &[];
/// Reasons for the end of a jog.
const JOG_ENDS: &[&str] = &[
    JogEnd::Released.name(),
    JogEnd::NotKept.name(),
    JogEnd::Stopped.name(),
    JogEnd::Lease.name(),
    JogEnd::Link.name(),
    JogEnd::Replaced.name(),
    JogEnd::Limit.name(),
];
pub(super) const JOG_WHY: Member = is(
    "why",
    Shape::Choice(JOG_ENDS),
    "why it ended: its session stopped it or went away; it was not kept up; a stop of the arm came; the lease ended; the line broke; \
     the same session began another one; the arm came to a limit or to its fence",
);
const LEFT: Member = is("left_s", Shape::Number, "how long it is until then").in_unit("s");

notices! {
    /// The list of sessions has changed.
    SessionChanged = "session.changed" {
        to: "every session",
        when: "A session came, went, or got or lost a lease. Five times a second at most: the list is the newest one.",
        channel: "`session.list` answers the same list.",
        arm: None,
        ids: &[("sessions[].session", Session)],
        params: &[is("sessions", Shape::List(&Shape::Type("Session")), "all sessions")],
    }
    /// The holder of a lease has changed.
    LeaseChanged = "lease.changed" {
        to: "every session",
        when: "The lease of an arm was given, given back, taken or lost.",
        channel: "This one says who may move the arm. `holder` of State is the same for who shows states; the event `lease` is for logs.",
        arm: Some("arm"),
        ids: &[("holder.session", Session)],
        params: &[ARM, is("holder", Shape::Type("Holder"), "who has it now").null("nobody has it")],
    }
    /// A session asks for a lease.
    LeaseAsked = "lease.asked" {
        to: "the holder of the lease",
        when: "Another session asks for it by `lease.ask`. Answer by `lease.answer`; without an answer it passes after 20 s. A session that asks again meanwhile is told once, and one answer is for all that it asked.",
        channel: "`waiting` of `arm.list` has who asks, for everybody.",
        arm: Some("arm"),
        ids: &[("session", Session)],
        params: &[
            ARM,
            is("session", Shape::Id(Session), "who asks, for `lease.answer`"),
            is("name", Shape::Text, "what it calls itself"),
            is("message", Shape::Text, "its sentence").null("it says nothing"),
        ],
    }
    /// A session's position in the queue for a lease.
    LeaseQueue = "lease.queue" {
        to: "the session that waits",
        when: "It waits for a lease by `lease.acquire` with `wait_s`: at once, and whenever the queue has moved; its place may be the same as before.",
        channel: "",
        arm: Some("arm"),
        ids: EVERYBODY,
        params: &[ARM, is("place", Shape::Count, "its place, from 1")],
    }
    /// A job has changed.
    JobChanged = "job.changed" {
        to: "every session",
        when: "A job has another state, at once; its progress, ten times a second at most; its place in the queue, five times a second at most: it is the newest one.",
        channel: "This one follows a job. The event `job` is for logs, `job` of State says which job has the arm.",
        arm: Some("job.arm"),
        ids: &[
            ("job.job", Job),
            ("job.holder.session", Session),
            ("job.error.holder.session", Session),
            ("job.error.by", Session),
        ],
        params: &[is("job", Shape::Type("Job"), "all of it, as `job.get` answers it")],
    }
    /// A jog is over.
    JogEnded = "jog.ended" {
        to: "every session",
        when: "A jog is over. The stop has gone out to the arm; it may still come to rest.",
        channel: "This one says that a jog is over, and why. `jog` of State is null from then on; the event `jog` is for logs.",
        arm: Some("arm"),
        ids: &[("jog", Jog)],
        params: &[ARM, is("jog", Shape::Id(Jog), "which one"), JOG_WHY],
    }
    /// What is known of the work surface has changed.
    SurfaceChanged = "surface.changed" {
        to: "every session",
        when: "The work surface under an arm was touched or forgotten, a corner of a sheet was taken; or another program has measured it, which shows with the next `surface.get`.",
        channel: "`surface.get` answers the same.",
        arm: Some("arm"),
        ids: EVERYBODY,
        params: &[ARM, is("surface", Shape::Type("MeasuredSurface"), "all that is known, as `surface.get` answers it")],
    }
    /// The state of an arm.
    ArmState = "arm.state" {
        to: "the socket that subscribed",
        when: "As often as `arm.subscribe` asks for, the newest state when several are due; at once when job, jog or holder change, and once when the line is lost.",
        channel: "This one is for showing where an arm is. Decide by `lease.changed`, `job.changed` and `jog.ended`.",
        arm: None,
        ids: &[
            ("subscription", Subscription),
            ("state.job", Job),
            ("state.jog", Jog),
            ("state.holder.session", Session),
        ],
        params: &[
            is("subscription", Shape::Id(Subscription), "of which subscription of this socket"),
            is("state", Shape::Type("StateChange"), "what is to be merged into the last state"),
        ],
    }
    /// The station is ending.
    ServerEnding = "server.ending" {
        to: "every session",
        when: "The station begins to end, and to each session that says hello after that. Who holds an arm stops it within 1 s (`arm.stop`), lifts its pen and gives the lease back.",
        channel: "Nothing begins any more: -32007, \"the station ends\".",
        arm: None,
        ids: EVERYBODY,
        params: &[LEFT],
    }
    /// Turns have changed.
    TurnChanged = "turn.changed" {
        to: "every session",
        when: "A turn began or ended, somebody joined or left the queue, an arm was frozen or freed, a class was set.",
        channel: "`turn.list` answers the same, and which arms are meant by the asker's `turn.join`.",
        arm: None,
        ids: super::ids::TURNS,
        params: super::types::TURNS,
    }
    /// A turn is about to end.
    TurnEnding = "turn.ending" {
        to: "every session",
        when: "A turn ends in 60 s, and in 10 s.",
        channel: "",
        arm: Some("arm"),
        ids: EVERYBODY,
        params: &[ARM, is("person", Shape::Text, "whose turn it is"), LEFT],
    }
    /// A turn has begun.
    TurnGranted = "turn.granted" {
        to: "the session of the person whose turn it is",
        when: "Its turn begins, or goes on after a teacher had the arm: it has the lease from now on.",
        channel: "`lease.changed` tells everybody; this one has the id of the lease.",
        arm: Some("arm"),
        ids: &[("lease", Lease)],
        params: &[
            ARM,
            is("lease", Shape::Id(Lease), "the lease, for `lease.release`"),
            is("ttl_s", Shape::Number, "it ends when its holder says nothing for so long").in_unit("s"),
            is("left_s", Shape::Number, "what is left of the turn").in_unit("s").null("it has no end"),
        ],
    }
    /// Event of an arm.
    ArmEvent = "arm.event" {
        to: "subscribers of the arm",
        when: "Something happened: see the table of events.",
        channel: "This is the log of an arm: numbered, and read later by `events.since`. What lease, jobs and jogs do has notifications of its own.",
        arm: Some("arm"),
        ids: &[
            ("by", Session),
            ("holder.session", Session),
            ("job", Job),
            ("jog", Jog),
        ],
        params: EVENT,
    }
}

/// Members of every event.
pub(super) const EVENT: &[Member] = &[
    ARM,
    is(
        "seq",
        Shape::Count,
        "its number at this arm, from 1, for `events.since`",
    ),
    is(
        "t",
        Shape::Number,
        "when it happened, by the station's clock",
    )
    .in_unit("Unix seconds"),
    is(
        "event",
        Shape::Choice(super::events::NAMES),
        "what happened",
    ),
];

impl Notification {
    /// Returns the notification with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        NOTIFICATIONS.iter().find(|one| one.name == name)
    }
}

impl Notice {
    /// Returns the message.
    #[must_use]
    pub fn message(self, params: &Value) -> String {
        notification(self.name(), params)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ids among the top-level members must be declared in `ids` as well.
    #[test]
    fn ids_of_a_row_are_those_of_its_members() {
        for row in NOTIFICATIONS {
            let ids = row.params.iter().filter_map(|member| match member.shape {
                Shape::Id(kind) => Some((member.name, kind)),
                _ => None,
            });
            for id in ids {
                assert!(row.ids.contains(&id), "{}: {}", row.name, id.0);
            }
        }
    }
}
