use super::spec::{self, Listeners};
use super::{Notice, ServeError, Service};

/// The cable of a virtual arm as its endpoints know it.
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
    /// Whether the cable was pulled since the endpoints followed it.
    pub(super) fn is_behind(&self, pulls: u64) -> bool {
        pulls != self.pulls
    }

    /// Has the endpoints vanish and come back as the cable is pulled and put back: it was pulled so often, and is in or not.
    pub(super) fn follow(
        &mut self,
        pulls: u64,
        plugged: bool,
        listeners: &mut Listeners,
        service: &mut dyn Service,
    ) -> Result<(), ServeError> {
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
