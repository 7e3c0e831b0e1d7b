//! What the virtual arm does, in lines on stderr or in the picture.

use std::io::{self, Write};
use std::sync::Arc;

use magician_protocol::{Alarm, Row};
use magician_sim::fidelity::Confidence;
use magician_sim::serve::{Endpoint, Notice};
use magician_sim::world::{Press, Rest, Thing, What};
use magician_sim::{Event, Identity, Refusal, Scenario, Speed};

use super::tui::Feed;

/// What kind of arm is served.
pub(super) fn title(identity: &Identity, speed: Speed) -> String {
    let [major, minor, revision] = identity.version;
    let speed = match speed {
        Speed::Max => "max".to_owned(),
        Speed::Times(times) => format!("{times}x"),
    };
    let name = &identity.name;
    format!("virtual arm \"{name}\", firmware {major}.{minor}.{revision}, speed {speed}")
}

/// Writes the log; how much is the user's choice.
#[derive(Clone)]
pub(super) struct Log {
    verbose: u8,
    /// The names of the objects in the arm's world.
    objects: Arc<[String]>,
    /// What a line begins with, where several arms write lines.
    arm: String,
    /// Where lines go if stderr shows a picture.
    feed: Option<Feed>,
}

impl Log {
    pub(super) fn new(verbose: u8, scenario: &Scenario) -> Self {
        let objects = scenario.objects().iter();
        Self {
            verbose,
            objects: objects.map(|object| object.name.clone()).collect(),
            arm: String::new(),
            feed: None,
        }
    }

    /// The same for one arm of several.
    pub(super) fn numbered(self, number: u32) -> Self {
        let arm = format!("arm {number}: ");
        Self { arm, ..self }
    }

    /// The same for a picture, which has room for more than stderr.
    pub(super) fn pictured(self, feed: Feed) -> Self {
        Self {
            verbose: self.verbose.saturating_add(1),
            feed: Some(feed),
            ..self
        }
    }

    /// Says what is served where.
    pub(super) fn doors(&self, title: &str, endpoints: &[Endpoint]) {
        if let Some(feed) = &self.feed {
            feed.doors(endpoints.iter().map(Endpoint::to_string).collect());
        }
        self.say(title);
        for endpoint in endpoints {
            self.say(&match endpoint {
                #[cfg(unix)]
                Endpoint::Pty { path, device } => {
                    format!("serving {} ({})", path.display(), device.display())
                }
                endpoint => format!("serving {endpoint}"),
            });
        }
    }

    pub(super) fn notice(&self, notice: Notice) {
        if let Some(feed) = &self.feed {
            feed.follow(&notice);
        }
        let line = match notice {
            Notice::Arm(event) => self.event(event),
            // A command line opens and closes the port for every verb.
            Notice::Connected(_) | Notice::Left(_) if self.verbose < 1 => None,
            Notice::Connected(who) => Some(format!("{who} connected")),
            Notice::Left(who) => Some(format!("{who} left")),
            Notice::Refused(who) => Some(format!("{who} refused: too many connections")),
            Notice::Undiscoverable { address, error } => Some(format!(
                "note: programs that look for an arm will not find this one: {address}: {error}; \
                 perhaps another arm answers there (--discovery off says it need not be found)"
            )),
            Notice::Unplugged => Some("the cable was pulled".to_owned()),
            Notice::Plugged(endpoints) => {
                self.doors("the cable is back", &endpoints);
                None
            }
            Notice::FlashNotKept(error) => Some(format!("the flash is not kept: {error}")),
            Notice::TraceEnded(error) => Some(format!("the trace ends here: {error}")),
        };
        if let Some(line) = line {
            self.say(&line);
        }
    }

    /// A stderr that cannot be written to is no reason to stop serving.
    fn say(&self, line: &str) {
        match &self.feed {
            Some(feed) => feed.say(line.to_owned()),
            None => drop(writeln!(io::stderr().lock(), "{}{line}", self.arm)),
        }
    }

    /// An event in words, if it is worth a line.
    fn event(&self, event: Event) -> Option<String> {
        let quiet = match event {
            Event::Accepted { .. } | Event::Started { .. } => self.verbose < 2,
            Event::Finished { .. } | Event::RestsOn { .. } => self.verbose < 1,
            _ => false,
        };
        let line = match event {
            _ if quiet => return None,
            Event::Accepted { index, id } => format!("{index} {} accepted", name(id)),
            Event::Started { index, id } => format!("{index} {} started", name(id)),
            Event::Finished { index, id } => format!("{index} {} finished", name(id)),
            Event::Dropped { count } => format!("{count} waiting commands dropped"),
            Event::QueueFull { id } => format!("{} not taken: the queue is full", name(id)),
            Event::Refused { id, reason } => {
                format!("{} not carried out: {}", name(id), refusal(reason))
            }
            Event::RestsOn { basis } => {
                let kind = match basis.confidence() {
                    Confidence::Choice => "a choice",
                    _ => "a fact",
                };
                format!("rests on {kind} ({}): {}", basis.section(), basis.says())
            }
            Event::AlarmRaised { code } => format!("alarm {} raised", alarm(code)),
            Event::AlarmCleared { code } => format!("alarm {} cleared", alarm(code)),
            Event::NotSimulated { row } => {
                format!(
                    "{} is answered, but the virtual arm does not act on it yet",
                    row.name
                )
            }
            Event::BadFrame { .. } => "a damaged frame was ignored".to_owned(),
            Event::UnknownId { id, .. } => format!("unknown command id {id}: no answer"),
            Event::Overrun { .. } => "a request was dropped: its replies are not read".to_owned(),
            Event::World(incident) => self.incident(incident.what),
            Event::Slipped { joint, degrees } => format!("J{joint} slips by {degrees} deg"),
            Event::Reset => "the controller resets: what was queued and set is gone".to_owned(),
            // Told when the endpoints have followed.
            Event::Cable { .. } => return None,
            Event::Key {
                press: Press::Short,
            } => "the base key is pressed".to_owned(),
            Event::Key { press: Press::Long } => "the base key is held".to_owned(),
            Event::Unlocked { held: true } => "the unlock key is held".to_owned(),
            Event::Unlocked { held: false } => "the unlock key is released".to_owned(),
            other => format!("{other:?}"),
        };
        Some(line)
    }

    /// What has happened in the world, in words.
    fn incident(&self, what: What) -> String {
        let object = |number: u16| -> &str {
            let name = self.objects.get(usize::from(number));
            name.map_or("an object", String::as_str)
        };
        let thing = |thing| match thing {
            Thing::Table => "the table",
            Thing::Belt => "the belt",
            Thing::Object(number) => object(number),
            _ => "something",
        };
        let rest = |rest| match rest {
            Rest::Table => "on the table".to_owned(),
            Rest::Belt => "on the belt".to_owned(),
            Rest::Object(number) => format!("on {}", object(number)),
            Rest::Floor => "on the floor".to_owned(),
            _ => "where it was".to_owned(),
        };
        match what {
            What::Picked(number) => format!("the tool takes {}", object(number)),
            What::Released(number, on) => {
                format!("{} is let go and lies {}", object(number), rest(on))
            }
            What::FellOffBelt(number, on) => {
                format!(
                    "{} falls off the belt and lies {}",
                    object(number),
                    rest(on)
                )
            }
            What::Touched(what) => format!("the tool touches {}", thing(what)),
            What::Knocked(number) => format!("the tool knocks against {}", object(number)),
            What::Pressed(what) => {
                format!("the tool presses on {}: J2 and J3 lose steps", thing(what))
            }
            other => format!("{other:?}"),
        }
    }
}

fn name(id: u8) -> String {
    Row::with_id(id).map_or_else(|| id.to_string(), |row| row.name.to_owned())
}

fn alarm(code: u8) -> String {
    match Alarm::with_code(code) {
        Some(alarm) => format!("{code:#04x} {}", alarm.name),
        None => format!("{code:#04x}"),
    }
}

fn refusal(reason: Refusal) -> String {
    let known = match reason {
        Refusal::OnlyAChoice(basis) => {
            let (section, says) = (basis.section(), basis.says());
            return format!("it rests on a choice ({section}): {says}");
        }
        Refusal::Parameters => "its parameter count fits no accepted form",
        Refusal::Unplannable => "its motion cannot be planned",
        Refusal::UnknownMode => "its mode has no meaning",
        Refusal::Pin => "there is no such pin, or it does not do that",
        Refusal::Busy => "a hand moves the arm, or its program runs",
        Refusal::Pose => "the pose cannot be set now, or not to this",
        _ => "the arm does not do that",
    };
    known.to_owned()
}
