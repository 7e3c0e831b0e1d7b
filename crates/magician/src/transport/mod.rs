//! Ways to an arm: each moves bytes and knows nothing of what they mean.

mod serial;
#[cfg(feature = "sim")]
mod sim;
mod stream;
mod udp;

use std::io;
use std::task::{Context, Poll};

use crate::connection::Settings;
use crate::{Error, ErrorKind, Result, Target};

#[cfg(feature = "sim")]
pub(crate) use sim::Sim;
pub(crate) use stream::Stream;

/// A line to the arm. Both methods are polled from one task; what one leaves pending must wake it.
pub(crate) trait Transport: Send {
    /// Bytes that have come; 0: the other end is gone.
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>>;

    /// Takes bytes from the front of one frame.
    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>>;
}

/// An open line and how to treat it.
pub(crate) struct Line {
    pub(crate) transport: Box<dyn Transport>,
    pub(crate) settings: Settings,
    /// What to call it in messages.
    pub(crate) name: String,
    /// What was tried, for the message that nothing answers.
    pub(crate) tried: &'static str,
}

/// The way to an arm, to be gone again when its line was lost.
pub(crate) struct Way {
    target: Target,
}

impl Way {
    pub(crate) fn to(target: &Target) -> Self {
        Self {
            target: target.clone(),
        }
    }

    /// Opens a line, for the first time or again.
    pub(crate) async fn open(&self) -> Result<Line> {
        open(&self.target).await
    }
}

/// Opens the line to a target.
async fn open(target: &Target) -> Result<Line> {
    let name = target.to_string();
    let line = |transport, settings, tried| Line {
        transport,
        settings,
        name: name.clone(),
        tried,
    };
    match target {
        #[cfg(feature = "sim")]
        Target::Sim(speed) => {
            let sim = Box::new(Sim::new(crate::VirtualArm::powered_up(*speed)));
            Ok(line(sim, Settings::ORDERED, "a virtual arm"))
        }
        #[cfg(not(feature = "sim"))]
        Target::Sim(_) => Err(Error::new(
            ErrorKind::Unsupported,
            "this build has no virtual arm: it was made without the feature `sim`",
        )),
        Target::Serial(path) => {
            let port = Box::new(serial::open(path)?);
            Ok(line(port, Settings::ORDERED, "115200 baud"))
        }
        Target::Udp { host, port } => {
            let socket = udp::open(host, *port).await?;
            Ok(line(Box::new(socket), Settings::DATAGRAMS, "UDP"))
        }
        Target::Tcp { host, port } => {
            let stream = stream::connect(host, *port).await?;
            Ok(line(Box::new(stream), Settings::ORDERED, "TCP"))
        }
        Target::Ble(name) => Err(Error::new(
            ErrorKind::Unsupported,
            format!("ble:{name}: this build does not speak Bluetooth; use USB or Wi-Fi"),
        )),
    }
}

/// Opens a serial port at another speed than the arm's.
pub(crate) fn serial_at(path: &str, baud: u32) -> Result<Box<dyn Transport>> {
    Ok(Box::new(serial::open_at(path, baud)?))
}

/// The name of a host that cannot be reached.
fn unreachable_host(host: &str, port: u16, error: io::Error) -> Error {
    let message = format!("{host} port {port} cannot be reached: {error}");
    Error::new(ErrorKind::Port, message).with_source(error)
}
