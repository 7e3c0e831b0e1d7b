//! What the virtual arm does, in lines on stderr or in the picture.

use std::sync::Arc;

use magician_protocol::visible;
use magician_sim::serve::{Endpoint, Notice};
use magician_sim::{Event, Identity, Scenario, Speed};

use super::tui::Feed;
use crate::output::tell;
use crate::serving::serving;

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
    /// The arm's world, where objects have names.
    scenario: Arc<Scenario>,
    /// What a line begins with, where several arms write lines.
    arm: String,
    /// Where lines go if stderr shows a picture.
    feed: Option<Feed>,
}

impl Log {
    pub(super) fn new(verbose: u8, scenario: &Scenario) -> Self {
        Self {
            verbose,
            scenario: Arc::new(scenario.clone()),
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
            self.say(&serving(endpoint));
        }
    }

    pub(super) fn notice(&self, notice: Notice) {
        if let Some(feed) = &self.feed {
            feed.follow(&notice);
        }
        let line = match notice {
            Notice::Arm(event) => self.event(event),
            // A command line opens and closes the port for every verb, and the picture shows who is there.
            Notice::Connected(_) | Notice::Left(_)
                if self.verbose < 1 + u8::from(self.feed.is_some()) =>
            {
                None
            }
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
            Notice::RecordingEnded(error) => Some(format!("the recording ends here: {error}")),
        };
        if let Some(line) = line {
            self.say(&line);
        }
    }

    /// A stderr that cannot be written to is no reason to stop serving.
    fn say(&self, line: &str) {
        match &self.feed {
            Some(feed) => feed.say(visible(line).to_string()),
            None => tell(format_args!("{}{line}", self.arm)),
        }
    }

    /// An event in words, if it is worth a line.
    fn event(&self, event: Event) -> Option<String> {
        let quiet = match event {
            Event::Accepted { .. } | Event::Started { .. } | Event::RestsOn { .. } => {
                self.verbose < 2
            }
            Event::Finished { .. } => self.verbose < 1,
            // Told when the endpoints have followed.
            Event::Cable { .. } => true,
            _ => false,
        };
        (!quiet).then(|| event.in_words(Some(&self.scenario)).to_string())
    }
}
