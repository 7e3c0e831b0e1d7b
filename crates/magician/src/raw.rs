use std::future::poll_fn;

use tokio::io::{AsyncRead, AsyncWrite};

use crate::transport::{self, Stream, Transport};
use crate::{Error, Result, Target};

/// Bytes to an arm and back as they are, for programs that look at the bytes themselves: tests of
/// an arm, bridges. Nothing is matched, sent again or waited for; [`Arm`](crate::Arm) does that.
pub struct RawLine {
    transport: Box<dyn Transport>,
    name: String,
}

impl RawLine {
    /// Opens the line to a target. Nothing is sent, so it is not known yet whether an arm is there.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) when the port is not there, not allowed or in
    /// use, [`ErrorKind::Unsupported`](crate::ErrorKind::Unsupported) for Bluetooth.
    pub async fn open(target: &Target) -> Result<Self> {
        let transport::Line {
            transport, name, ..
        } = transport::Way::to(target).open().await?;
        Ok(Self { transport, name })
    }

    /// Opens a serial port at another speed than the arm's, to hear whether something else is there.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub async fn open_at(path: &str, baud: u32) -> Result<Self> {
        Ok(Self {
            transport: transport::serial_at(path, baud)?,
            name: path.to_owned(),
        })
    }

    /// A line over any stream of bytes that keeps their order, called `name` in messages.
    pub fn over<T>(stream: T, name: &str) -> Self
    where
        T: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        Self {
            transport: Box::new(Stream(stream)),
            name: name.to_owned(),
        }
    }

    /// What the line is called in messages: the target as it was given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Sends bytes; over UDP they are one datagram.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) when the line is gone.
    pub async fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let mut rest = bytes;
        while !rest.is_empty() {
            let sent = poll_fn(|cx| self.transport.poll_write(cx, rest)).await;
            let count = sent.map_err(|error| Error::gone(&self.name, error))?;
            if count == 0 {
                return Err(self.gone());
            }
            rest = rest.get(count..).unwrap_or_default();
        }
        Ok(())
    }

    /// Waits for bytes and puts them into `bytes`; how many. Dropping the wait loses none.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) when the line is gone.
    pub async fn receive(&mut self, bytes: &mut [u8]) -> Result<usize> {
        let came = poll_fn(|cx| self.transport.poll_read(cx, bytes)).await;
        match came {
            Ok(0) => Err(self.gone()),
            Ok(count) => Ok(count),
            Err(error) => Err(Error::gone(&self.name, error)),
        }
    }

    fn gone(&self) -> Error {
        Error::gone(&self.name, std::io::ErrorKind::UnexpectedEof.into())
    }
}
