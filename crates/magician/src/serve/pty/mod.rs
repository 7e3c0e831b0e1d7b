//! Pseudo-terminal that behaves like the arm's serial port, whatever its clients do.

use std::io;
use std::path::{Path, PathBuf};
use std::task::Context;

use super::{Endpoint, Listener, ServeError, Service};

mod claim;
mod connection;
mod symlink;
mod terminal;
#[cfg(target_os = "linux")]
#[path = "watch_linux.rs"]
mod watch;
#[cfg(not(target_os = "linux"))]
#[path = "watch_portable.rs"]
mod watch;

use claim::Claim;
use connection::PtyConnection;
use symlink::LinkPath;
pub(super) use symlink::check;

/// Path that leads to the arm; it disappears while the arm is unplugged.
pub(super) struct Pty {
    way: LinkPath,
    /// Current terminal, or the last one.
    device: PathBuf,
    /// `None` while the arm is unplugged.
    jack: Option<PtyConnection>,
    /// Claim of the path, held also while the arm is unplugged.
    _claim: Claim,
}

impl Pty {
    pub(super) fn open(path: &Path, service: &mut dyn Service) -> Result<Self, ServeError> {
        let way = LinkPath::new(path)?;
        way.check()?;
        // Before the terminal is made: an occupied path should cost nothing.
        let claim = way.claim()?;
        let jack = PtyConnection::open(&way, service)?;
        Ok(Self {
            _claim: claim,
            device: jack.device().to_owned(),
            jack: Some(jack),
            way,
        })
    }
}

impl Listener for Pty {
    fn endpoint(&self) -> Endpoint {
        Endpoint::Pty {
            path: self.way.given().to_owned(),
            device: self.device.clone(),
        }
    }

    fn poll(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()> {
        match &mut self.jack {
            Some(jack) => jack.poll(cx, service),
            None => Ok(()),
        }
    }

    fn unplug(&mut self, service: &mut dyn Service) {
        if let Some(jack) = self.jack.take() {
            jack.close(service);
        }
    }

    fn plug(&mut self, service: &mut dyn Service) -> Result<(), ServeError> {
        let jack = PtyConnection::open(&self.way, service)?;
        jack.device().clone_into(&mut self.device);
        self.jack = Some(jack);
        Ok(())
    }
}
