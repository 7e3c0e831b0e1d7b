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
const NO_IDS: &[IdPlace] = &[];
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
    "reason of the end: stopped by its session, or the session ended; hold time expired; the arm was stopped; the lease ended; the line broke; \
     replaced by another jog of the session; a limit or the fence was reached",
);
const LEFT: Member = is("left_s", Shape::Number, "time left").in_unit("s");

notices! {
    /// The list of sessions has changed.
    SessionChanged = "session.changed" {
        to: "every session",
        when: "A session began or ended, or acquired or lost a lease. At most five times per second, with the latest list.",
        channel: "`session.list` returns the same list.",
        arm: None,
        ids: &[("sessions[].session", Session)],
        params: &[is("sessions", Shape::List(&Shape::Type("Session")), "all sessions")],
    }
    /// The holder of a lease has changed.
    LeaseChanged = "lease.changed" {
        to: "every session",
        when: "The lease of an arm was granted, given back, taken or lost.",
        channel: "Use this one to know who may move the arm. `holder` of State is the same, for clients that show states; the event `lease` is for logs.",
        arm: Some("arm"),
        ids: &[("holder.session", Session)],
        params: &[ARM, is("holder", Shape::Type("Holder"), "current holder").null("the arm is free")],
    }
    /// A session asks for a lease.
    LeaseAsked = "lease.asked" {
        to: "the holder of the lease",
        when: "Another session called `lease.ask`. Reply with `lease.answer`; without a reply the lease passes after 20 s. Repeated questions of one session are sent once, and one reply answers all of them.",
        channel: "`waiting` of `arm.list` shows the asking sessions to all.",
        arm: Some("arm"),
        ids: &[("session", Session)],
        params: &[
            ARM,
            is("session", Shape::Id(Session), "session that asks, for `lease.answer`"),
            is("name", Shape::Text, "name of the session"),
            is("message", Shape::Text, "message of the session").null("no message"),
        ],
    }
    /// A session's position in the queue for a lease.
    LeaseQueue = "lease.queue" {
        to: "the session that waits",
        when: "The session waits for a lease by `lease.acquire` with `wait_s`: sent at once and whenever the queue moves, even if its place is unchanged.",
        channel: "",
        arm: Some("arm"),
        ids: NO_IDS,
        params: &[ARM, is("place", Shape::Count, "place in the queue, from 1")],
    }
    /// A job has changed.
    JobChanged = "job.changed" {
        to: "every session",
        when: "The state of a job changed (sent at once), its progress (at most ten times per second), or its place in the queue (at most five times per second). Carries the latest values.",
        channel: "Use this one to follow a job. The event `job` is for logs; `job` of State is the job that has the arm.",
        arm: Some("job.arm"),
        ids: &[
            ("job.job", Job),
            ("job.holder.session", Session),
            ("job.error.holder.session", Session),
            ("job.error.by", Session),
        ],
        params: &[is("job", Shape::Type("Job"), "the whole job, as from `job.get`")],
    }
    /// A jog is over.
    JogEnded = "jog.ended" {
        to: "every session",
        when: "A jog ended. The stop was sent to the arm, which may still be decelerating.",
        channel: "Use this one for the end of a jog and its reason. `jog` of State is null from then on; the event `jog` is for logs.",
        arm: Some("arm"),
        ids: &[("jog", Jog)],
        params: &[ARM, is("jog", Shape::Id(Jog), "id of the jog"), JOG_WHY],
    }
    /// The measured work surface has changed.
    SurfaceChanged = "surface.changed" {
        to: "every session",
        when: "The work surface of an arm was measured or forgotten, or a corner of a sheet was measured. A measurement by another program is noticed at the next `surface.get`.",
        channel: "`surface.get` returns the same.",
        arm: Some("arm"),
        ids: NO_IDS,
        params: &[ARM, is("surface", Shape::Type("MeasuredSurface"), "measured surface, as from `surface.get`")],
    }
    /// The state of an arm.
    ArmState = "arm.state" {
        to: "the socket that subscribed",
        when: "At the rate of `arm.subscribe`, with the latest state if several are due; immediately when job, jog or holder change; once when the line is lost.",
        channel: "Use this one to show the arm. Base decisions on `lease.changed`, `job.changed` and `jog.ended`.",
        arm: None,
        ids: &[
            ("subscription", Subscription),
            ("state.job", Job),
            ("state.jog", Jog),
            ("state.holder.session", Session),
        ],
        params: &[
            is("subscription", Shape::Id(Subscription), "id of the subscription of this socket"),
            is("state", Shape::Type("StateChange"), "changes to merge into the last state"),
        ],
    }
    /// The station is ending.
    ServerEnding = "server.ending" {
        to: "every session",
        when: "The station begins to end; also sent to sessions that begin afterwards. Holders should stop their arm within 1 s (`arm.stop`), lift the pen and give the lease back.",
        channel: "New work is refused with -32007, \"the station ends\".",
        arm: None,
        ids: NO_IDS,
        params: &[LEFT],
    }
    /// Turns have changed.
    TurnChanged = "turn.changed" {
        to: "every session",
        when: "A turn began or ended, a person joined or left the queue, an arm was frozen or freed, or a class was set.",
        channel: "`turn.list` returns the same, and the arms meant by the caller's `turn.join`.",
        arm: None,
        ids: super::ids::TURNS,
        params: super::types::TURNS,
    }
    /// A turn is about to end.
    TurnEnding = "turn.ending" {
        to: "every session",
        when: "60 s and 10 s before the end of a turn.",
        channel: "",
        arm: Some("arm"),
        ids: NO_IDS,
        params: &[ARM, is("person", Shape::Text, "person whose turn it is"), LEFT],
    }
    /// A turn has begun.
    TurnGranted = "turn.granted" {
        to: "the session of the person who got the turn",
        when: "A turn begins, or continues after a teacher had the arm. The session holds the lease from now on.",
        channel: "`lease.changed` informs all sessions; this one carries the id of the lease.",
        arm: Some("arm"),
        ids: &[("lease", Lease)],
        params: &[
            ARM,
            is("lease", Shape::Id(Lease), "id of the lease, for `lease.release`"),
            is("ttl_s", Shape::Number, "lease timeout: the lease ends if the holder sends nothing for this long").in_unit("s"),
            is("left_s", Shape::Number, "time left in the turn").in_unit("s").null("the turn is unlimited"),
        ],
    }
    /// Event of an arm.
    ArmEvent = "arm.event" {
        to: "subscribers of the arm",
        when: "An event occurred; see the table of events.",
        channel: "Log of an arm: numbered, and available later by `events.since`. Lease, jobs and jogs have separate notifications.",
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
        "sequence number at this arm, from 1, for `events.since`",
    ),
    is("t", Shape::Number, "time, by the station's clock").in_unit("Unix seconds"),
    is(
        "event",
        Shape::Choice(super::events::NAMES),
        "kind of the event",
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
    fn notification_ids_match_its_members() {
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
