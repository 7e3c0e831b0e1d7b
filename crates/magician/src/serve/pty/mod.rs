//! A pseudo-terminal that behaves as the arm's serial port does, whatever its clients do to it.

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

/// A path that leads to the arm, and is gone while the arm is unplugged.
pub(super) struct Pty {
    way: LinkPath,
    /// The terminal that is there, or was the last.
    device: PathBuf,
    /// `None` while the arm is unplugged.
    jack: Option<PtyConnection>,
    /// The path is this server's, also while the arm is unplugged.
    _claim: Claim,
}

impl Pty {
    pub(super) fn open(path: &Path, service: &mut dyn Service) -> Result<Self, ServeError> {
        let way = LinkPath::new(path)?;
        way.check()?;
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
