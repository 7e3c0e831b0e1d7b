//! What the task publishes for all handles: events, the state, and how the line is.

use magician_host::picture::PictureEvent;

use super::Driver;
use crate::arm::events::Event;
use crate::arm::link::Link;

impl Driver {
    /// Notifies the listeners of what the last answer has shown.
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

    /// Notifies the listeners, if any.
    pub(super) fn happens(&self, event: Event) {
        let _ = self.events.send(event);
    }

    /// Shows the state to the watches, once all of it was read.
    pub(super) fn publish_status(&self) {
        if let Some(status) = self.shared.status_now() {
            self.shared.status.send_replace(Some(status));
        }
    }

    /// The line was lost or found: watches see it at once.
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
