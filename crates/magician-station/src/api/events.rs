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
    "of the alarm; `arm.alarms` explains those that stand",
)];
const INDEX: Shape = Shape::Count;
const FILE: Member = is(
    "name",
    Shape::Text,
    "the file, for GET /api/v1/recordings/{name}",
);

events! {
    AlarmRaised = "alarm-raised", "An alarm stands.", "`alarms` of State are those that stand", ALARM;
    AlarmCleared = "alarm-cleared", "An alarm does not stand any more.", "`alarms` of State", ALARM;
    CommandFinished = "command-finished", "The arm has finished commands of its queue.", "`current_index` of State",
        &[is("index", INDEX, "the last one")];
    Unaccounted = "unaccounted", "The arm's queue went on by commands that this station did not send.", "",
        &[is("index", INDEX, "the last one")];
    LinkLost = "link-lost", "The line to the arm broke.", "`link` of State", &[];
    LinkFound = "link-found", "The arm answers again.", "`link` of State", &[];
    Reset = "reset", "The arm was reset or switched on: its queue is empty, and its settings are those of power-up.", "", &[];
    Missed = "missed", "The station could not follow: so many events were dropped.", "",
        &[is("count", Shape::Count, "how many")];
    HandTrigger = "hand-trigger", "The unlock key was released while `teach.guide` is on.", "",
        &[is("step", Shape::Type("PlanStep"), "a step that leads to where the arm was put")];
    Stop = "stop", "The arm was stopped. Stops within 50 ms of one that was told are not.", "",
        &[is("by", Shape::Id(Session), "whose stop").null("the end of a lease")];
    Lease = "lease", "The lease has another holder.", "`lease.changed`",
        &[is("holder", Shape::Type("Holder"), "who has it now").null("nobody has it")];
    Job = "job", "A job has another state.", "`job.changed`",
        &[
            is("job", Shape::Id(Job), "which one"),
            is("state", Shape::Choice(super::types::JOB_STATES), "its state"),
        ];
    Jog = "jog", "A jog began (`axis`) or is over (`why`).", "`jog.ended`",
        &[
            is("jog", Shape::Id(Jog), "which one"),
            is("axis", Shape::Choice(super::methods::JOGS), "where it goes, at its beginning").optional(),
            Member { optional: true, ..JOG_WHY },
        ];
    RecordingSaved = "recording-saved", "An alarm had the last minutes written into a file.", "",
        &[FILE, is("bytes", Shape::Count, "its length")];
    RecordingLost = "recording-lost", "A recording ended because its file could not be written.", "",
        &[FILE, is("message", Shape::Text, "why")];
}

impl EventRow {
    /// Returns the event with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        EVENTS.iter().find(|one| one.name == name)
    }
}
