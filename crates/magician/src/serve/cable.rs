//! Cable of a served virtual arm: endpoints disappear and return with it.

use super::spec::{self, Listeners};
use super::{Notice, ServeError, Service};

/// State of the cable that the endpoints have followed.
pub(super) struct Cable {
    plugged: bool,
    pulls: u64,
}

impl Default for Cable {
    fn default() -> Self {
        Self {
            plugged: true,
            pulls: 0,
        }
    }
}

impl Cable {
    /// True if the cable was pulled since the endpoints last followed it.
    pub(super) fn is_behind(&self, pulls: u64) -> bool {
        pulls != self.pulls
    }

    /// Makes the endpoints disappear and return with the cable. `pulls` is the number of pulls so
    /// far.
    pub(super) fn follow(
        &mut self,
        pulls: u64,
        plugged: bool,
        listeners: &mut Listeners,
        service: &mut dyn Service,
    ) -> Result<(), ServeError> {
        // A pull counts even if the cable is in again: clients of the old connection are gone.
        if self.is_behind(pulls) {
            (self.pulls, self.plugged) = (pulls, false);
            for listener in listeners.iter_mut() {
                listener.unplug(service);
            }
            service.notice(Notice::Unplugged);
        }
        if plugged && !self.plugged {
            self.plugged = true;
            for listener in listeners.iter_mut() {
                listener.plug(service)?;
            }
            service.notice(Notice::Plugged(spec::endpoints(listeners)));
        }
        Ok(())
    }
}
