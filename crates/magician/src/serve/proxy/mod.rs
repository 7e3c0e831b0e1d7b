//! Several programs at one arm: endpoints that lead through a [`Proxy`](crate::proxy::Proxy) to the line of an arm.

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

/// Rounds in one turn before the runtime looks at what else there is, such as the end.
const ROUNDS: u32 = 32;
/// How long the end of a jog may take when the proxy ends.
const STAND_BY: Duration = Duration::from_secs(2);

/// What a [`ProxyServer`] has to tell.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum ProxyNotice<'a> {
    /// What passed, or did not.
    Traffic {
        /// What.
        event: &'a Event,
        /// What the client is called that it is about; `None`: the arm, or the proxy itself.
        client: Option<&'a str>,
    },
    /// A client connected, left, was refused or made room.
    Client(&'a Notice),
    /// The line to the arm is lost, and looked for; clients get no replies until it is back.
    LineLost(&'a Error),
    /// The line to the arm is back.
    LineFound,
    /// The trace cannot be written and ends here; the proxy goes on.
    TraceEnded(&'a io::Error),
    /// The proxy ends, and the arm did not confirm the end of a jog that one of its clients began.
    JogNotConfirmed,
}

/// Who hears what a [`ProxyServer`] has to tell. It should be quick: all clients wait for it. Closures hear, too.
pub trait ProxyObserver: Send {
    /// One thing.
    fn notice(&mut self, notice: ProxyNotice<'_>);

    /// All that happened in this turn has been told: what belongs together may be written.
    fn flush(&mut self) {}
}

impl<F: FnMut(ProxyNotice<'_>) + Send> ProxyObserver for F {
    fn notice(&mut self, notice: ProxyNotice<'_>) {
        self(notice);
    }
}

/// Shares one arm between programs: each sees an arm of its own at its endpoint. How requests of several become those of one
/// says [`proxy`](crate::proxy).
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
    /// Dropped before the rest: what leads to the arm is gone before the arm.
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
    /// Opens the endpoints in front of this line. In the settings the line is replaced by this one's.
    ///
    /// # Errors
    /// [`ServeError`] when an endpoint cannot be opened; then none stays open.
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

    /// What programs connect to, in the order in which it was asked for.
    #[must_use]
    pub fn endpoints(&self) -> Vec<Endpoint> {
        let endpoints = self.endpoints.as_ref();
        endpoints.map_or_else(Vec::new, BoundEndpoints::endpoints)
    }

    /// Has this hear what happens, in the place of the one before.
    #[must_use]
    pub fn observed(mut self, observer: impl ProxyObserver + 'static) -> Self {
        self.service.observe(Box::new(observer));
        self
    }

    /// Writes all that passes to a trace file ([`trace`](magician_record::trace)): a link for each client, and one for the
    /// arm, whose name begins with `arm `.
    ///
    /// # Errors
    /// The beginning of the file cannot be written.
    #[cfg(feature = "trace")]
    pub fn traced(mut self, writer: impl io::Write + Send + 'static) -> io::Result<Self> {
        self.service.trace(trace::ProxyTrace::new(writer)?);
        Ok(self)
    }

    /// Serves until `end` is ready, and gives what that comes to. Then, as when an endpoint breaks down, the endpoints are
    /// closed and jogs that were begun through them are ended, which takes two seconds at most. A future that is dropped before
    /// ends no jog.
    ///
    /// # Errors
    /// [`ServeError`] when an endpoint breaks down. A line to the arm that is lost is looked for.
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

    /// Closes the endpoints and ends the jogs that were begun through them.
    async fn end(mut self) {
        self.endpoints = None;
        self.service.close_all();
        let stands = poll_fn(|cx| match self.turn(cx) {
            Ok(()) if self.service.proxy.is_letting_go() => Poll::Pending,
            _ => Poll::Ready(()),
        });
        if timeout(STAND_BY, stands).await.is_err() {
            self.service.tell(ProxyNotice::JogNotConfirmed);
        }
    }

    /// Does all that can be done now and sees to being woken for the rest.
    fn turn(&mut self, cx: &mut Context<'_>) -> Result<(), ServeError> {
        let turned = self.rounds(cx);
        self.service.show();
        turned
    }

    fn rounds(&mut self, cx: &mut Context<'_>) -> Result<(), ServeError> {
        for _ in 0..ROUNDS {
            // What has come comes first: it may be what a timeout is about to give up.
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
        cx.waker().wake_by_ref();
        Ok(())
    }

    /// Whether nothing is due; then the task is woken when something will be.
    fn sleeps(&mut self, cx: &mut Context<'_>) -> bool {
        let Some(at) = self.service.proxy.poll_timeout() else {
            return true;
        };
        let now = self.service.now();
        if at <= now {
            return false;
        }
        // Rounded up: an instant that has not quite come would be waited for in vain.
        let at = Instant::now() + Duration::from_micros(at - now) + Duration::from_micros(1);
        self.timer.as_mut().reset(at);
        self.timer.as_mut().poll(cx).is_pending()
    }
}
