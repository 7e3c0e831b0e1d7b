//! Table of the events sent by `arm.event`. Clients get no others.

use super::IdKind::{Job, Jog, Session};
use super::notifications::JOG_WHY;
use super::shape::{Member, Shape, is};

/// Kind of event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventRow {
    /// Name.
    pub name: &'static str,
    /// Condition under which it is sent.
    pub when: &'static str,
    /// Notification that a client should use instead. Empty if there is no better one.
    pub instead: &'static str,
    /// Members besides `arm`, `seq`, `t` and `event`.
    pub members: &'static [Member],
}

macro_rules! events {
    ($($event:ident = $name:literal, $when:literal, $instead:literal, $members:expr;)*) => {
        /// Kind of an event of an arm.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        pub enum ArmEvent {
            $(#[doc = $when] $event,)*
        }

        /// All events, in documentation order.
        pub static EVENTS: &[EventRow] = &[$(EventRow {
            name: $name, when: $when, instead: $instead, members: $members,
        },)*];

        /// Names of all events.
        pub(super) const NAMES: &[&str] = &[$($name,)*];

        impl ArmEvent {
            /// Returns the name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$event => $name,)*
                }
            }
        }
    };
}

const ALARM: &[Member] = &[is(
    "code",
    Shape::Count,
    "code of the alarm; `arm.alarms` explains active alarms",
)];
const INDEX: Shape = Shape::Count;
const FILE: Member = is(
    "name",
    Shape::Text,
    "file name, for GET /api/v1/recordings/{name}",
);

events! {
    AlarmRaised = "alarm-raised", "An alarm became active.", "`alarms` of State are the active alarms", ALARM;
    AlarmCleared = "alarm-cleared", "An alarm was cleared.", "`alarms` of State", ALARM;
    CommandFinished = "command-finished", "The arm finished commands of its queue.", "`current_index` of State",
        &[is("index", INDEX, "queue index of the last one")];
    Unaccounted = "unaccounted", "The arm finished commands that this station did not send.", "",
        &[is("index", INDEX, "queue index of the last one")];
    LinkLost = "link-lost", "The line to the arm broke.", "`link` of State", &[];
    LinkFound = "link-found", "The arm answers again.", "`link` of State", &[];
    Reset = "reset", "The arm was reset or switched on: its queue is empty, and its settings have power-up values.", "", &[];
    Missed = "missed", "The station could not keep up and dropped events.", "",
        &[is("count", Shape::Count, "number of dropped events")];
    HandTrigger = "hand-trigger", "The unlock key was released while `teach.guide` is on.", "",
        &[is("step", Shape::Type("PlanStep"), "step to the position of the arm")];
    Stop = "stop", "The arm was stopped. Further stops within 50 ms are not reported.", "",
        &[is("by", Shape::Id(Session), "session that stopped it").null("stopped by the end of a lease")];
    Lease = "lease", "The holder of the lease changed.", "`lease.changed`",
        &[is("holder", Shape::Type("Holder"), "current holder").null("the arm is free")];
    Job = "job", "The state of a job changed.", "`job.changed`",
        &[
            is("job", Shape::Id(Job), "id of the job"),
            is("state", Shape::Choice(super::types::JOB_STATES), "state of the job"),
        ];
    Jog = "jog", "A jog began (`axis`) or ended (`why`).", "`jog.ended`",
        &[
            is("jog", Shape::Id(Jog), "id of the jog"),
            is("axis", Shape::Choice(super::methods::JOGS), "axis and direction, at the beginning").optional(),
            Member { optional: true, ..JOG_WHY },
        ];
    RecordingSaved = "recording-saved", "The last minutes were saved to a file because of an alarm.", "",
        &[FILE, is("bytes", Shape::Count, "size of the file")];
    RecordingLost = "recording-lost", "A recording ended because its file could not be written.", "",
        &[FILE, is("message", Shape::Text, "cause")];
}

impl EventRow {
    /// Returns the event with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        EVENTS.iter().find(|one| one.name == name)
    }
}
