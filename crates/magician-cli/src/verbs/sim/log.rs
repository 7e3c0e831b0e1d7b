//! Log of a virtual arm, as lines on stderr or in the picture.

use std::mem::{Discriminant, discriminant};
use std::sync::Arc;
use std::time::Instant;

use magician::serve::{Endpoint, Notice};
use magician_protocol::visible;
use magician_sim::{Event, Identity, Scenario, Speed};

use super::tui::Feed;
use crate::paint::print_stderr;
use crate::serving::serving;
use crate::throttle::Throttle;

/// Describes the kind of arm that is served.
pub(super) fn title(identity: &Identity, speed: Speed) -> String {
    let [major, minor, revision] = identity.version;
    let speed = match speed {
        Speed::Max => "max".to_owned(),
        Speed::Times(times) => format!("{times}x"),
    };
    let name = &identity.name;
    format!("virtual arm \"{name}\", firmware {major}.{minor}.{revision}, speed {speed}")
}

/// Log writer with the user's verbosity.
#[derive(Clone)]
pub(super) struct Log {
    verbose: u8,
    /// World of the arm, for the names of objects.
    scenario: Arc<Scenario>,
    to: LogTarget,
    limits: RateLimits,
}

/// Destination of the lines.
#[derive(Clone, Default)]
struct LogTarget {
    /// Prefix of each line if there are several arms.
    arm: String,
    /// Receives the lines if stderr shows a picture.
    feed: Option<Feed>,
}

/// Kind of a line, for the rate limit.
type LineKind = (Discriminant<Notice>, Option<Discriminant<Event>>);

/// Rate limit for lines that clients can cause in any number.
#[derive(Clone)]
struct RateLimits {
    throttle: Throttle<LineKind>,
    begun: Instant,
    to: LogTarget,
}

impl RateLimits {
    fn new(to: LogTarget) -> Self {
        Self {
            throttle: Throttle::default(),
            begun: Instant::now(),
            to,
        }
    }

    fn say(&mut self, about: LineKind, line: &str) {
        let now = self.begun.elapsed();
        for held in self.throttle.take_ended(now) {
            self.to.say(&held.to_string());
        }
        if self.throttle.allows(now, about, line) {
            self.to.say(line);
        }
    }
}

impl Drop for RateLimits {
    fn drop(&mut self) {
        for held in self.throttle.take_all(self.begun.elapsed()) {
            self.to.say(&held.to_string());
        }
    }
}

impl LogTarget {
    /// Writes a line. An unwritable stderr must not end the service.
    fn say(&self, line: &str) {
        match &self.feed {
            Some(feed) => feed.say(visible(line).to_string()),
            None => print_stderr(format_args!("{}{line}", self.arm)),
        }
    }
}

impl Log {
    pub(super) fn new(verbose: u8, scenario: &Scenario) -> Self {
        Self {
            verbose,
            scenario: Arc::new(scenario.clone()),
            to: LogTarget::default(),
            limits: RateLimits::new(LogTarget::default()),
        }
    }

    /// Returns the log of one arm of several.
    pub(super) fn numbered(self, number: u32) -> Self {
        let arm = format!("arm {number}: ");
        let to = LogTarget { arm, ..self.to };
        Self {
            limits: RateLimits::new(to.clone()),
            to,
            ..self
        }
    }

    /// Returns a log for a picture, which has room for more lines than stderr.
    pub(super) fn pictured(self, feed: Feed) -> Self {
        let feed = Some(feed);
        let to = LogTarget { feed, ..self.to };
        Self {
            verbose: self.verbose.saturating_add(1),
            limits: RateLimits::new(to.clone()),
            to,
            ..self
        }
    }

    /// Reports the endpoints.
    pub(super) fn endpoints(&self, title: &str, endpoints: &[Endpoint]) {
        if let Some(feed) = &self.to.feed {
            feed.endpoints(endpoints.iter().map(Endpoint::to_string).collect());
        }
        self.to.say(title);
        for endpoint in endpoints {
            self.to.say(&serving(endpoint));
        }
        for endpoint in endpoints.iter().filter(|endpoint| endpoint.is_exposed()) {
            self.to.say(&format!(
                "note: every computer that reaches {endpoint} can use this virtual arm"
            ));
        }
    }

    pub(super) fn notice(&mut self, notice: Notice) {
        if let Some(feed) = &self.to.feed {
            feed.follow(&notice);
        }
        let event = match &notice {
            Notice::Arm(event) => Some(event),
            _ => None,
        };
        // Events of every command appear only if asked for, and then without a rate limit.
        let daily = event.is_some_and(Event::is_routine);
        let about = (discriminant(&notice), event.map(discriminant));
        let line = match notice {
            Notice::Arm(event) => self.event(event),
            // Every verb of a command line opens and closes the port, so this would be noise; the
            // picture lists the clients anyway.
            Notice::Connected(_) | Notice::Left(_)
                if self.verbose < 1 + u8::from(self.to.feed.is_some()) =>
            {
                None
            }
            Notice::Connected(who) => Some(format!("{who} connected")),
            Notice::Left(who) => Some(format!("{who} disconnected")),
            Notice::Refused(who) => Some(format!("{who} refused: too many connections")),
            Notice::MadeRoom(who) => Some(format!(
                "{who} closed: it was idle, and a new connection needed its place"
            )),
            Notice::Undiscoverable { address, error } => Some(format!(
                "note: programs cannot discover this arm: {address}: {error}; \
                 perhaps another arm answers there (--discovery off disables discovery)"
            )),
            Notice::Unplugged => Some("the cable was pulled".to_owned()),
            Notice::Plugged(endpoints) => {
                self.endpoints("the cable is back", &endpoints);
                None
            }
            Notice::FlashNotKept(error) => Some(format!("the flash cannot be saved: {error}")),
            Notice::TraceEnded(error) => Some(format!("the trace ends here: {error}")),
            Notice::RecordingEnded(error) => Some(format!("the recording ends here: {error}")),
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        match line {
            Some(line) if daily => self.to.say(&line),
            Some(line) => self.limits.say(about, &line),
            None => {}
        }
    }

    /// Describes an event; `None` if it does not matter at this verbosity.
    fn event(&self, event: Event) -> Option<String> {
        let quiet = match event {
            Event::Accepted { .. } | Event::Started { .. } | Event::Assumes { .. } => {
                self.verbose < 2
            }
            Event::Finished { .. } => self.verbose < 1,
            // Reported once the endpoints have followed.
            Event::Cable { .. } => true,
            _ => false,
        };
        (!quiet).then(|| event.in_words(Some(&self.scenario)).to_string())
    }
}
