//! Raw lines: bytes to an arm and back, without the protocol engine.

use std::future::poll_fn;
use std::io;
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, AsyncWrite};

use crate::connection::Settings;
#[cfg(feature = "faults")]
use crate::faults::Faults;
#[cfg(feature = "trace")]
use crate::transport::Tracer;
#[cfg(feature = "lines")]
use crate::transport::serial_at;
use crate::transport::{Line, Route, Stream, Transport};
use crate::{Error, Result, Target};

/// Raw byte line to an arm, for programs that examine the bytes themselves: conformance tests,
/// bridges. Nothing is matched, retransmitted or awaited; [`Arm`](crate::Arm) does that.
pub struct RawLine {
    /// `None` for a stream of the caller, which cannot be reopened.
    way: Option<Route>,
    /// `None` if it was lost.
    transport: Option<Box<dyn Transport>>,
    name: String,
    settings: Settings,
}

/// Options of a [`RawLine`].
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct LineOptions {
    /// Faults injected into the bytes.
    #[cfg(feature = "faults")]
    pub faults: Faults,
    /// Tracer that records the bytes.
    #[cfg(feature = "trace")]
    pub trace: Option<Tracer>,
}

impl LineOptions {
    /// Sets [`faults`](Self::faults).
    #[cfg(feature = "faults")]
    #[must_use]
    pub fn faults(mut self, faults: Faults) -> Self {
        self.faults = faults;
        self
    }

    /// Sets [`trace`](Self::trace).
    #[cfg(feature = "trace")]
    #[must_use]
    pub fn trace(mut self, trace: Tracer) -> Self {
        self.trace = Some(trace);
        self
    }
}

impl RawLine {
    /// Opens the line to a target. Nothing is sent, so it is unknown if an arm is there; only
    /// `arm:SERIAL` queries serial numbers.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) if the port is missing, not permitted or in use,
    /// [`ErrorKind::Unsupported`](crate::ErrorKind::Unsupported) for Bluetooth in a build without
    /// the feature `ble`.
    pub async fn open(target: &Target) -> Result<Self> {
        Self::open_with(target, LineOptions::default()).await
    }

    /// Opens as [`open`](Self::open) does, with faults or a trace.
    ///
    /// # Errors
    /// Same as [`open`](Self::open); [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) if
    /// the target does not support these faults.
    pub async fn open_with(target: &Target, options: LineOptions) -> Result<Self> {
        Self::go(Route::to(target), options).await
    }

    /// Opens the line to a virtual arm of the caller.
    ///
    /// # Errors
    /// Same as [`open_with`](Self::open_with).
    #[cfg(feature = "sim")]
    pub async fn simulated(
        arm: impl Into<crate::VirtualArm>,
        options: LineOptions,
    ) -> Result<Self> {
        Self::go(Route::to_virtual(arm.into()), options).await
    }

    #[cfg_attr(
        not(any(feature = "faults", feature = "trace")),
        allow(unused_variables)
    )]
    async fn go(way: Route, options: LineOptions) -> Result<Self> {
        #[cfg(feature = "faults")]
        let way = way.with_faults(options.faults)?;
        #[cfg(feature = "trace")]
        let way = match options.trace {
            Some(tracer) => way.with_trace(tracer),
            None => way,
        };
        let Line {
            transport,
            name,
            settings,
            ..
        } = way.open().await?;
        Ok(Self {
            way: Some(way),
            transport: Some(transport),
            name,
            settings,
        })
    }

    /// Reopens the line after it was lost. A serial port is found by its USB adapter: the same
    /// adapter under any name, or an error.
    ///
    /// # Errors
    /// Same as [`open`](Self::open); it may be tried again then.
    pub async fn reopen(&mut self) -> Result<()> {
        // Releases the port before it is opened again.
        self.transport = None;
        let Some(way) = &self.way else {
            return Err(self.gone());
        };
        self.transport = Some(way.open().await?.transport);
        Ok(())
    }

    /// Opens a serial port at another baud rate, to find out if another device is there.
    ///
    /// # Errors
    /// Same as [`open`](Self::open).
    #[cfg(feature = "lines")]
    pub async fn open_at(path: &str, baud: u32) -> Result<Self> {
        Ok(Self {
            way: None,
            transport: Some(serial_at(path, baud)?),
            // No route: another baud rate is a test, which is not worth a reconnect.
            name: path.to_owned(),
            settings: Settings::ORDERED,
        })
    }

    /// Creates a line over any byte stream that keeps the order of bytes, called `name` in
    /// messages.
    pub fn over<T>(stream: T, name: &str) -> Self
    where
        T: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        Self {
            way: None,
            transport: Some(Box::new(Stream(stream))),
            name: name.to_owned(),
            settings: Settings::ORDERED,
        }
    }

    /// Returns the name of the line in messages: the target as it was given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the properties of the line: its ordering and timeouts.
    #[must_use]
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Sends bytes; over UDP as one datagram.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) if the line is gone.
    pub async fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let mut rest = bytes;
        while !rest.is_empty() {
            let count = poll_fn(|cx| self.poll_send(cx, rest)).await?;
            // A short write is normal on a serial line with a full buffer.
            rest = rest.get(count..).unwrap_or_default();
        }
        Ok(())
    }

    /// Sends bytes from the front of `bytes`; returns their number.
    ///
    /// # Errors
    /// Same as [`send`](Self::send).
    pub fn poll_send(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<Result<usize>> {
        let Some(transport) = &mut self.transport else {
            return Poll::Ready(Err(self.gone()));
        };
        let sent = ready!(transport.poll_write(cx, bytes));
        Poll::Ready(self.passed(sent))
    }

    /// Waits for bytes, writes them to `bytes`, and returns their number. Cancelling the wait loses
    /// none.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) if the line is gone.
    pub async fn receive(&mut self, bytes: &mut [u8]) -> Result<usize> {
        poll_fn(|cx| self.poll_receive(cx, bytes)).await
    }

    /// Writes arrived bytes to `bytes`; returns their number.
    ///
    /// # Errors
    /// Same as [`receive`](Self::receive).
    pub(crate) fn poll_receive(
        &mut self,
        cx: &mut Context<'_>,
        bytes: &mut [u8],
    ) -> Poll<Result<usize>> {
        let Some(transport) = &mut self.transport else {
            return Poll::Ready(Err(self.gone()));
        };
        let came = ready!(transport.poll_read(cx, bytes));
        Poll::Ready(self.passed(came))
    }

    fn passed(&self, count: io::Result<usize>) -> Result<usize> {
        match count {
            // End of stream, for reads and writes alike.
            Ok(0) => Err(self.gone()),
            Ok(count) => Ok(count),
            Err(error) => Err(Error::gone(&self.name, error)),
        }
    }

    fn gone(&self) -> Error {
        Error::gone(&self.name, io::ErrorKind::UnexpectedEof.into())
    }
}
