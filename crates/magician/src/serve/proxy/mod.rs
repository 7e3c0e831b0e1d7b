//! Sharing an arm: endpoints that lead through a [`Proxy`](crate::proxy::Proxy) to the line of an
//! arm.

mod service;
#[cfg(feature = "trace")]
mod trace;
mod wire;

use std::fmt;
use std::future::{Future, poll_fn};
use std::io;
use std::pin::{Pin, pin};
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::task::unconstrained;
use tokio::time::{Instant, Sleep, sleep, timeout};

use super::{BoundEndpoints, Endpoint, Endpoints, Notice, ServeError};
use crate::proxy::{Event, Settings};
use crate::{Error, RawLine};
use service::ProxyService;
use wire::Wire;

/// Rounds before the runtime polls other futures, such as the end. Choice.
const ROUNDS: u32 = 32;
/// Longest time to end a jog during shutdown. Choice.
const STAND_BY: Duration = Duration::from_secs(2);

/// Event of a [`ProxyServer`].
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum ProxyNotice<'a> {
    /// Traffic that passed or was refused.
    Traffic {
        /// Event of the proxy.
        event: &'a Event,
        /// Name of the client it concerns; `None` for the arm or the proxy itself.
        client: Option<&'a str>,
    },
    /// A client connected, left, was refused, or was closed for another.
    Client(&'a Notice),
    /// The line to the arm is lost and being reopened; clients get no replies until it is back.
    LineLost(&'a Error),
    /// The line to the arm is back.
    LineFound,
    /// The trace could not be written and ends; the proxy continues.
    TraceEnded(&'a io::Error),
    /// The proxy has ended, but the arm did not confirm the end of a jog that one of its clients
    /// started.
    JogNotConfirmed,
}

/// Observer of a [`ProxyServer`]; closures implement it. It should be quick, because all clients
/// wait for it.
pub trait ProxyObserver: Send {
    /// Called for each event.
    fn notice(&mut self, notice: ProxyNotice<'_>);

    /// Called after all events of a round, when buffered output may be written.
    fn flush(&mut self) {}
}

impl<F: FnMut(ProxyNotice<'_>) + Send> ProxyObserver for F {
    fn notice(&mut self, notice: ProxyNotice<'_>) {
        self(notice);
    }
}

/// Server that shares one arm among programs: each program sees its own arm at its endpoint.
/// [`proxy`](crate::proxy) describes how their requests are combined.
///
/// It needs a tokio runtime with I/O and time enabled, and is one future.
///
/// ```no_run
/// # async fn share() -> Result<(), Box<dyn std::error::Error>> {
/// use magician::proxy::Settings;
/// use magician::serve::{Endpoints, ProxyServer};
/// use magician::{RawLine, Target};
///
/// let line = RawLine::open(&"/dev/ttyUSB0".parse::<Target>()?).await?;
/// let endpoints = Endpoints::new().tcp("127.0.0.1:9000");
/// let proxy = ProxyServer::open(line, &endpoints, Settings::default())?;
/// println!("{:?}", proxy.endpoints());
/// proxy.serve_until(std::future::pending::<()>()).await?;
/// # Ok(())
/// # }
/// ```
pub struct ProxyServer {
    /// Dropped first, so that no endpoint accepts clients for an arm that is gone.
    endpoints: Option<BoundEndpoints>,
    service: ProxyService,
    wire: Wire,
    timer: Pin<Box<Sleep>>,
}

impl fmt::Debug for ProxyServer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ProxyServer")
            .field("endpoints", &self.endpoints)
            .finish_non_exhaustive()
    }
}

impl ProxyServer {
    /// Opens the endpoints in front of this line. `settings.line` is replaced by the properties of
    /// the line.
    ///
    /// # Errors
    /// [`ServeError`] if an endpoint cannot be opened; none then stays open.
    pub fn open(
        line: RawLine,
        endpoints: &Endpoints,
        settings: Settings,
    ) -> Result<Self, ServeError> {
        let settings = Settings {
            line: line.settings(),
            ..settings
        };
        let mut service = ProxyService::new(settings, line.name());
        Ok(Self {
            endpoints: Some(endpoints.open(&mut service)?),
            service,
            wire: Wire::new(line),
            timer: Box::pin(sleep(Duration::ZERO)),
        })
    }

    /// Returns the endpoints in the order of the request.
    #[must_use]
    pub fn endpoints(&self) -> Vec<Endpoint> {
        let endpoints = self.endpoints.as_ref();
        endpoints.map_or_else(Vec::new, BoundEndpoints::endpoints)
    }

    /// Sets the observer, replacing the previous one.
    #[must_use]
    pub fn observed(mut self, observer: impl ProxyObserver + 'static) -> Self {
        self.service.observe(Box::new(observer));
        self
    }

    /// Writes all traffic to a trace file ([`trace`](magician_record::trace)): a link for each
    /// client, and one for the arm, whose name begins with `arm `.
    ///
    /// # Errors
    /// Errors of the writer at the start of the file.
    #[cfg(feature = "trace")]
    pub fn traced(mut self, writer: impl io::Write + Send + 'static) -> io::Result<Self> {
        self.service.trace(trace::ProxyTrace::new(writer)?);
        Ok(self)
    }

    /// Serves until `end` is ready, and returns its output.
    ///
    /// Then, and after a failed endpoint, the endpoints are closed and jogs started through them
    /// are ended, which takes at most two seconds. Dropping the future earlier ends no jog.
    ///
    /// # Errors
    /// [`ServeError`] if an endpoint fails. A lost line to the arm is reopened.
    pub async fn serve_until<T>(mut self, end: impl Future<Output = T>) -> Result<T, ServeError> {
        let mut end = pin!(end);
        let ended = unconstrained(poll_fn(|cx| {
            if let Poll::Ready(ended) = end.as_mut().poll(cx) {
                return Poll::Ready(Ok(ended));
            }
            match self.turn(cx) {
                Ok(()) => Poll::Pending,
                Err(error) => Poll::Ready(Err(error)),
            }
        }))
        .await;
        self.end().await;
        ended
    }

    /// Closes the endpoints and ends the jogs started through them.
    async fn end(mut self) {
        self.endpoints = None;
        self.service.close_all();
        let stands = poll_fn(|cx| match self.turn(cx) {
            Ok(()) if self.service.proxy.is_letting_go() => Poll::Pending,
            // Without jogs, and after a failed endpoint, there is nothing to wait for.
            _ => Poll::Ready(()),
        });
        if timeout(STAND_BY, stands).await.is_err() {
            self.service.tell(ProxyNotice::JogNotConfirmed);
        }
    }

    /// Does everything that is possible now, and registers to be woken for the rest.
    fn turn(&mut self, cx: &mut Context<'_>) -> Result<(), ServeError> {
        let turned = self.rounds(cx);
        self.service.show();
        turned
    }

    fn rounds(&mut self, cx: &mut Context<'_>) -> Result<(), ServeError> {
        for _ in 0..ROUNDS {
            // Received bytes come first: they may answer a request that is about to time out.
            let came = self.wire.read(cx, &mut self.service);
            if let Some(endpoints) = &mut self.endpoints {
                endpoints.poll(cx, &mut self.service)?;
            }
            self.service.tick();
            let went = self.wire.write(cx, &mut self.service);
            let idle = !came && !went && !self.service.proxy.is_answering();
            if idle && self.sleeps(cx) {
                return Ok(());
            }
        }
        // Still busy after all rounds: yield, and continue at the next poll.
        cx.waker().wake_by_ref();
        Ok(())
    }

    /// True if nothing is due; the task is then woken for the next deadline.
    fn sleeps(&mut self, cx: &mut Context<'_>) -> bool {
        let Some(at) = self.service.proxy.poll_timeout() else {
            return true;
        };
        let now = self.service.now();
        if at <= now {
            return false;
        }
        // Rounded up: a timer that fires before the deadline would have to be set again.
        let at = Instant::now() + Duration::from_micros(at - now) + Duration::from_micros(1);
        self.timer.as_mut().reset(at);
        self.timer.as_mut().poll(cx).is_pending()
    }
}
