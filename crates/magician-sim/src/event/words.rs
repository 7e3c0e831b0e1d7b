//! Events as text for logs.

use std::fmt;

use magician_protocol::{Alarm, Row};

use super::{Event, Refusal};
use crate::Scenario;
use crate::fidelity::Confidence;
use crate::world::{Body, Press, Support, WorldEventKind};

impl Event {
    /// True for an event that any program causes all the time: commands accepted, started and
    /// finished, and assumptions.
    #[must_use]
    pub fn is_routine(&self) -> bool {
        matches!(
            self,
            Self::Accepted { .. }
                | Self::Started { .. }
                | Self::Finished { .. }
                | Self::Assumes { .. }
        )
    }

    /// Formats the event, with object names from `scenario`.
    pub fn in_words<'a>(&self, scenario: Option<&'a Scenario>) -> impl fmt::Display + use<'a> {
        InWords {
            event: *self,
            objects: Objects(scenario),
        }
    }
}

struct InWords<'a> {
    event: Event,
    objects: Objects<'a>,
}

impl fmt::Display for InWords<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.event {
            Event::Accepted { index, id } => write!(f, "{index} {} accepted", Name(id)),
            Event::Started { index, id } => write!(f, "{index} {} started", Name(id)),
            Event::Finished { index, id } => write!(f, "{index} {} finished", Name(id)),
            Event::Dropped { count } => write!(f, "{count} waiting commands dropped"),
            Event::QueueFull { id } => write!(f, "{} not taken: the queue is full", Name(id)),
            Event::Stored { index, id } => {
                write!(f, "{index} {} stored as a line of the program", Name(id))
            }
            Event::Downloaded { stored, announced } => write!(
                f,
                "a program of {stored} commands is in the flash, {announced} were announced"
            ),
            Event::Program { runs: true } => f.write_str("the program in the flash begins"),
            Event::Program { runs: false } => f.write_str("the program in the flash ends"),
            Event::Refused { id, reason } => write!(f, "{} not carried out: {reason}", Name(id)),
            Event::Assumes { assumption } => {
                let kind = match assumption.confidence() {
                    Confidence::Choice => "a choice",
                    // Every other confidence has a source: measured, the vendor's, a third party's.
                    _ => "a fact",
                };
                let (authority, says) = (assumption.authority(), assumption.says());
                write!(f, "relies on {kind} ({authority}): {says}")
            }
            Event::AlarmRaised { code } => write!(f, "alarm {} raised", Code(code)),
            Event::ToolUnknown { code } => write!(f, "{}: {}", Code(code), Alarm::TOOL_UNKNOWN),
            Event::HomeOutOfReach => f.write_str(
                "the home point is out of reach: homing ends at its usual joints, without an alarm",
            ),
            Event::AlarmCleared { code } => write!(f, "alarm {} cleared", Code(code)),
            Event::World(event) => self.objects.event(f, event.kind),
            Event::Slipped { joint, degrees } => write!(f, "J{joint} slips by {degrees} deg"),
            Event::Reset => f.write_str("the controller resets: queue and settings are lost"),
            Event::Cable { plugged: true } => f.write_str("the cable is back"),
            Event::Cable { plugged: false } => f.write_str("the cable was pulled"),
            Event::Key { press } => f.write_str(match press {
                Press::Short => "the base key is pressed",
                Press::Long => "the base key is held",
            }),
            Event::Unlocked { held: true } => f.write_str("the unlock key is held"),
            Event::Unlocked { held: false } => f.write_str("the unlock key is released"),
            Event::NotSimulated { row } => write!(
                f,
                "{} is answered, but the virtual arm does not act on it yet",
                row.name
            ),
            Event::BadFrame { .. } => f.write_str("a damaged frame was ignored"),
            Event::UnknownId { id, .. } => write!(f, "unknown command id {id}: no answer"),
            Event::Overrun { .. } => f.write_str("a request was dropped: its replies are not read"),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OnlyAChoice(assumption) => {
                let (authority, says) = (assumption.authority(), assumption.says());
                return write!(f, "it relies on a choice ({authority}): {says}");
            }
            Self::Parameters => "its parameter count fits no accepted form",
            Self::Unplannable => "its motion cannot be planned",
            Self::UnknownMode => "its mode is invalid",
            Self::Pin => "no such pin, or not with this function",
            Self::Trigger => "no such input, or not comparable like that",
            Self::Busy => "the arm is moved by hand, or its program runs",
            Self::Pose => "the pose cannot be set now, or not to these values",
        })
    }
}

/// Names of the objects around the arm.
struct Objects<'a>(Option<&'a Scenario>);

impl Objects<'_> {
    fn object(&self, number: u16) -> &str {
        let object = self.0.map(Scenario::objects).unwrap_or_default();
        let object = object.get(usize::from(number));
        object.map_or("an object", |object| &object.name)
    }

    fn body(&self, body: Body) -> &str {
        match body {
            Body::Table => "the table",
            Body::Belt => "the belt",
            Body::Object(number) => self.object(number),
        }
    }

    fn resting_place(&self, support: Support) -> (&str, &str) {
        match support {
            Support::Table => ("on", "the table"),
            Support::Belt => ("on", "the belt"),
            Support::Object(number) => ("on", self.object(number)),
            Support::Floor => ("on", "the floor"),
            // An object that is released cannot end up on its shelf or in the tool, so no better
            // words are needed.
            Support::Shelf | Support::Tool => ("where", "it was"),
        }
    }

    fn event(&self, f: &mut fmt::Formatter<'_>, kind: WorldEventKind) -> fmt::Result {
        let lies = |f: &mut fmt::Formatter<'_>, support| {
            let (on, what) = self.resting_place(support);
            write!(f, " and lies {on} {what}")
        };
        match kind {
            WorldEventKind::Picked(number) => write!(f, "the tool takes {}", self.object(number)),
            WorldEventKind::Released(number, support) => {
                write!(f, "{} is let go", self.object(number))?;
                lies(f, support)
            }
            WorldEventKind::FellOffBelt(number, support) => {
                write!(f, "{} falls off the belt", self.object(number))?;
                lies(f, support)
            }
            WorldEventKind::Touched(what) => write!(f, "the tool touches {}", self.body(what)),
            WorldEventKind::Knocked(number) => {
                write!(f, "the tool knocks against {}", self.object(number))
            }
            WorldEventKind::Pressed(what) => write!(
                f,
                "the tool presses on {}: J2 and J3 lose steps",
                self.body(what)
            ),
        }
    }
}

/// Formats a command id as its name.
struct Name(u8);

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match Row::with_id(self.0) {
            Some(row) => f.write_str(row.name),
            None => self.0.fmt(f),
        }
    }
}

/// Formats an alarm code with its name.
struct Code(u8);

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#04x}", self.0)?;
        match Alarm::with_code(self.0) {
            Some(alarm) => write!(f, " {}", alarm.name),
            None => Ok(()),
        }
    }
}
