//! Publication to all handles: events, state, and the state of the line.

use magician_host::picture::PictureEvent;

use super::Driver;
use crate::arm::events::Event;
use crate::arm::link::Link;

impl Driver {
    /// Sends the listeners the events from the last answer.
    pub(super) fn tell_events(&self) {
        loop {
            let event = self.shared.picture().poll_event();
            let Some(event) = event else {
                return;
            };
            self.happens(match event {
                PictureEvent::AlarmRaised(code) => Event::AlarmRaised { code },
                PictureEvent::AlarmCleared(code) => Event::AlarmCleared { code },
                PictureEvent::Finished { first, last } => Event::CommandFinished { first, last },
            });
        }
    }

    /// Sends an event to the listeners, if any.
    pub(super) fn happens(&self, event: Event) {
        // An error means that there are no listeners.
        let _ = self.events.send(event);
    }

    /// Publishes the state to the watches, once every field has been read.
    pub(super) fn publish_status(&self) {
        if let Some(status) = self.shared.status_now() {
            self.shared.status.send_replace(Some(status));
        }
    }

    /// Publishes a lost or reconnected line, which watches see at once.
    pub(super) fn publish_link(&self, link: Link) {
        self.shared.link.send_replace(link.clone());
        self.shared.status.send_if_modified(|status| match status {
            Some(status) => {
                status.link = link;
                true
            }
            None => false,
        });
    }
}
