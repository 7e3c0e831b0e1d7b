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

/// Bytes to an arm and back as they are, for programs that look at the bytes themselves: tests of
/// an arm, bridges. Nothing is matched, sent again or waited for; [`Arm`](crate::Arm) does that.
pub struct RawLine {
    /// There is none back to a stream of the caller's.
    way: Option<Route>,
    /// `None` when it was lost.
    transport: Option<Box<dyn Transport>>,
    name: String,
    settings: Settings,
}

/// What is put between a [`RawLine`] and its port.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct LineOptions {
    /// What is done to what passes.
    #[cfg(feature = "faults")]
    pub faults: Faults,
    /// Where what passes is written to.
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
    /// Opens the line to a target. Nothing is sent, so it is not known yet whether an arm is there;
    /// only `arm:SERIAL` asks for the serial number.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) when the port is not there, not allowed or in
    /// use, [`ErrorKind::Unsupported`](crate::ErrorKind::Unsupported) for Bluetooth in a build without the feature `ble`.
    pub async fn open(target: &Target) -> Result<Self> {
        Self::open_with(target, LineOptions::default()).await
    }

    /// As [`open`](Self::open), with faults or a trace between.
    ///
    /// # Errors
    /// As [`open`](Self::open); [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for faults
    /// that cannot be done to this target.
    pub async fn open_with(target: &Target, options: LineOptions) -> Result<Self> {
        Self::go(Route::to(target), options).await
    }

    /// The line to a virtual arm of the caller's making.
    ///
    /// # Errors
    /// As [`open_with`](Self::open_with).
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

    /// Opens the line again, after it was lost. A serial port is looked for by its USB adapter: it is
    /// the same one, whatever its name is now, or there is an error.
    ///
    /// # Errors
    /// As [`open`](Self::open); then it may be tried once more.
    pub async fn reopen(&mut self) -> Result<()> {
        // Gives the port back before it is asked for.
        self.transport = None;
        let Some(way) = &self.way else {
            return Err(self.gone());
        };
        self.transport = Some(way.open().await?.transport);
        Ok(())
    }

    /// Opens a serial port at another speed than the arm's, to hear whether something else is there.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    #[cfg(feature = "lines")]
    pub async fn open_at(path: &str, baud: u32) -> Result<Self> {
        Ok(Self {
            way: None,
            transport: Some(serial_at(path, baud)?),
            name: path.to_owned(),
            settings: Settings::ORDERED,
        })
    }

    /// A line over any stream of bytes that keeps their order, called `name` in messages.
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

    /// What the line is called in messages: the target as it was given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How such a line is to be treated: whether it keeps its order, and how long an answer may take.
    #[must_use]
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Sends bytes; over UDP they are one datagram.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) when the line is gone.
    pub async fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let mut rest = bytes;
        while !rest.is_empty() {
            let count = poll_fn(|cx| self.poll_send(cx, rest)).await?;
            rest = rest.get(count..).unwrap_or_default();
        }
        Ok(())
    }

    /// Takes bytes from the front of what is to be sent; how many.
    ///
    /// # Errors
    /// As [`send`](Self::send).
    pub fn poll_send(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<Result<usize>> {
        let Some(transport) = &mut self.transport else {
            return Poll::Ready(Err(self.gone()));
        };
        let sent = ready!(transport.poll_write(cx, bytes));
        Poll::Ready(self.passed(sent))
    }

    /// Waits for bytes and puts them into `bytes`; how many. Dropping the wait loses none.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) when the line is gone.
    pub async fn receive(&mut self, bytes: &mut [u8]) -> Result<usize> {
        poll_fn(|cx| self.poll_receive(cx, bytes)).await
    }

    /// Puts bytes that have come into `bytes`; how many.
    ///
    /// # Errors
    /// As [`receive`](Self::receive).
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
            Ok(0) => Err(self.gone()),
            Ok(count) => Ok(count),
            Err(error) => Err(Error::gone(&self.name, error)),
        }
    }

    fn gone(&self) -> Error {
        Error::gone(&self.name, io::ErrorKind::UnexpectedEof.into())
    }
}
