use std::future::Future;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::time::Duration;

use magician_protocol::commands::{DeviceVersion, QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::{broadcast, mpsc, oneshot};
use tokio::time::timeout_at;

use super::driver::{Driver, Message, Opener, micros};
use super::events::KEPT;
use super::{Arm, Inner, Link, Options, Shared};
use crate::connection::{Settings, Stats};
use crate::transport::{self, Line, Stream};
use crate::{Error, ErrorCode, ErrorKind, IntoTarget, Result, Target};

/// Connecting and leaving.
impl Arm {
    /// As [`connect`](Self::connect), with other options.
    ///
    /// # Errors
    /// As [`connect`](Self::connect); [`ErrorKind::InvalidInput`] for faults that cannot be done to this target.
    pub async fn connect_with(target: impl IntoTarget, options: Options) -> Result<Self> {
        let target = target.into_target()?;
        // The line to an arm in this process does not break by itself.
        let breaks = !matches!(target, Target::Sim(_)) || options.unplugs();
        Self::go(transport::Route::to(&target), breaks, options).await
    }

    /// Goes a way, with the faults and the trace of the options on it, and again when a line that may break broke.
    async fn go(way: transport::Route, breaks: bool, options: Options) -> Result<Self> {
        let way = Arc::new(way.fitted(&options)?);
        let line = way.open().await?;
        let to_open = Arc::clone(&way);
        let again: Opener = Box::new(move || {
            let way = Arc::clone(&to_open);
            Box::pin(async move { way.open().await })
        });
        let greeted = Self::greet(line, breaks.then_some(again), options).await;
        greeted.map_err(|error| way.named(error))
    }

    /// Talks to an arm over any stream of bytes that keeps their order. When it breaks, it is gone;
    /// [`over_with`](Self::over_with) opens it again.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub async fn over<T>(stream: T, options: Options) -> Result<Self>
    where
        T: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        options.without_faults()?;
        Self::greet(Line::over(stream).traced(&options), None, options).await
    }

    /// As [`over`](Self::over), with what opens the stream: now, and again whenever it broke.
    ///
    /// ```
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> magician::Result<()> {
    /// # let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    /// # let address = listener.local_addr().unwrap();
    /// use magician::{Arm, Options};
    /// use tokio::net::TcpStream;
    ///
    /// let bridge = move || TcpStream::connect(address);
    /// let arm = Arm::over_with(bridge, Options::default().probe(false)).await?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`connect`](Self::connect); [`ErrorKind::Port`] when it cannot be opened now.
    pub async fn over_with<F, O, T>(mut opener: F, options: Options) -> Result<Self>
    where
        F: FnMut() -> O + Send + 'static,
        O: Future<Output = io::Result<T>> + Send + 'static,
        T: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        options.without_faults()?;
        let fitted = options.clone();
        let mut again: Opener = Box::new(move || {
            let (opening, options) = (opener(), fitted.clone());
            Box::pin(async move {
                let stream = opening.await.map_err(|error| {
                    let message = format!("the stream cannot be opened: {error}");
                    Error::port(message, error)
                })?;
                Ok(Line::over(stream).traced(&options))
            })
        });
        let line = again().await?;
        Self::greet(line, Some(again), options).await
    }

    /// Talks to a virtual arm of the caller's making: a [`VirtualArm`](crate::VirtualArm), or what becomes one. Commands are
    /// checked by that arm's own numbers.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    #[cfg(feature = "sim")]
    pub async fn simulated(arm: impl Into<crate::VirtualArm>, options: Options) -> Result<Self> {
        let arm = arm.into();
        let model = arm.with(|controller| *controller.arm_model());
        let breaks = options.unplugs() || arm.lock().breaks();
        Self::go(
            transport::Route::to_virtual(arm),
            breaks,
            options.model(model),
        )
        .await
    }

    /// The virtual arm of this process that this is a connection to, to look at it and its world from outside; `None` for one
    /// that is elsewhere, and for a real arm.
    ///
    /// ```
    /// use magician::Arm;
    ///
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> magician::Result<()> {
    /// let arm = Arm::connect("sim").await?;
    /// let outside = arm.virtual_arm().expect("it is one");
    /// outside.with(|arm| arm.unlock(true));
    /// assert!(outside.state().unlocked);
    /// # Ok(())
    /// # }
    /// ```
    #[cfg(feature = "sim")]
    #[must_use]
    pub fn virtual_arm(&self) -> Option<&crate::VirtualArm> {
        self.inner.virtual_arm.as_ref()
    }

    pub(crate) async fn greet(
        mut line: Line,
        again: Option<Opener>,
        options: Options,
    ) -> Result<Self> {
        if options.window > 1 && !line.settings.ordered {
            let message = format!(
                "a window of {} needs a line that keeps frames in order, and {} does not: leave \
                    it at 1",
                options.window, line.name
            );
            return Err(Error::invalid(message));
        }
        if !line.settings.ordered {
            line.settings.echo = micros(options.echo);
        }
        let (messages, inbox) = mpsc::channel(64);
        let (events, _) = broadcast::channel(KEPT);
        let shared = Arc::new(Shared::new(
            &line,
            &events,
            options.homings.clone(),
            options.laser_pins,
        ));
        let (tried, in_process) = (line.tried, line.in_process);
        #[cfg(feature = "sim")]
        let virtual_arm = line.arm.clone();
        let driver = Driver::new(
            line,
            options.window,
            again.filter(|_| options.reconnect),
            options.probe,
            inbox,
            (Arc::clone(&shared), events),
        );
        tokio::spawn(driver.run());
        let probes = options.probe;
        let inner = Inner {
            messages,
            shared,
            flow: tokio::sync::Mutex::default(),
            timeout: AtomicU64::new(micros(options.timeout)),
            in_process,
            #[cfg(feature = "sim")]
            virtual_arm,
            held: super::fence::Held::new(options.fence),
            options,
            reset_asked: AtomicU8::new(0),
        };
        let arm = Self {
            allows_laser: inner.options.allow_laser,
            passes_jogs: inner.options.raw_jogs,
            leads: false,
            allows_unhomed: false,
            inner: Arc::new(inner),
            patience: Duration::ZERO,
        };
        if probes {
            probe(&arm, tried).await?;
        }
        Ok(arm)
    }

    /// Lets what was set going over this connection go on when it ends, however it ends and whichever clone says so.
    pub fn detach(&self) {
        self.inner.shared.detached.store(true, Ordering::SeqCst);
    }

    /// Ends the connection for all its clones, and returns when that is done: what it set going is stopped as when the
    /// last clone is dropped, unless it was [detached](Self::detach), and every call of another clone fails with
    /// [`ErrorKind::Closed`], those under way too.
    pub async fn close(self) {
        // A task that takes no message has ended.
        let _ = self.inner.messages.send(Message::Close).await;
        self.ended().await;
    }

    /// Ends when the connection has; it does not keep it.
    pub(crate) fn ended(&self) -> impl Future<Output = ()> + Send + 'static {
        let mut link = self.inner.shared.link.subscribe();
        async move {
            let _ = link.wait_for(|link| *link == Link::Closed).await;
        }
    }

    /// How long every single call to the arm may take.
    #[must_use]
    pub fn timeout(&self) -> Duration {
        Duration::from_micros(self.inner.timeout.load(Ordering::SeqCst))
    }

    /// Changes [`Options::timeout`], for calls of all clones that begin after this.
    pub fn set_timeout(&self, timeout: Duration) {
        self.inner.timeout.store(micros(timeout), Ordering::SeqCst);
    }

    /// What the connection is called in messages: the target as it was given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.inner.shared.name
    }

    /// What went over the line so far, and how many commands the arm's queue holds.
    ///
    /// # Errors
    /// [`ErrorKind::Closed`].
    pub async fn stats(&self) -> Result<(Stats, u32)> {
        let (reply, mut answer) = oneshot::channel();
        let asked = async {
            let sent = self.inner.messages.send(Message::Stats(reply)).await;
            sent.map_err(|_| Error::closed())?;
            self.heard(&mut answer).await.ok_or_else(Error::closed)
        };
        let answer = timeout_at(self.deadline(), asked).await;
        answer.unwrap_or_else(|_| Err(Error::stuck()))
    }
}

/// Asks for the version, and reads the queue once: where the indices stand, whether it is empty.
async fn probe(arm: &Arm, tried: &str) -> Result<()> {
    match arm.get::<DeviceVersion>().await {
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::Timeout => {
            return Err(silent(arm, tried).await);
        }
        Err(error) => return Err(error),
    }
    // In this order they show an arm at rest as such.
    arm.get::<QueuedCmdLeftSpace>().await?;
    arm.get::<QueuedCmdCurrentIndex>().await?;
    Ok(())
}

/// The port is there and nothing answers: what was tried, what was seen.
async fn silent(arm: &Arm, tried: &str) -> Error {
    let (stats, _) = arm.stats().await.unwrap_or_default();
    let heard = match (stats.bytes, stats.frames) {
        (0, _) => "no reply; is the arm switched on?".to_owned(),
        (bytes, 0) => format!(
            "{bytes} bytes came back that are not from this arm; is another device on the port?"
        ),
        (bytes, frames) => {
            format!("{bytes} bytes came back in {frames} frames, none of them the reply")
        }
    };
    let name = arm.name();
    // A datagram without a receiver looks like one without a reply.
    let silent = match tried {
        "UDP" => format!("no arm answers at {name}"),
        _ => format!("{name} is there but no arm answers"),
    };
    let message = format!(
        "{silent}: {tried}, {} requests for GetDeviceVersion in {:.1} s, {heard}",
        stats.sent,
        arm.timeout().as_secs_f64(),
    );
    Error::new(ErrorCode::NoAnswer, message)
}

impl Line {
    fn over<T>(stream: T) -> Self
    where
        T: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        Self {
            transport: Box::new(Stream(stream)),
            settings: Settings::ORDERED,
            name: "the stream".to_owned(),
            tried: "a stream",
            in_process: false,
            #[cfg(feature = "sim")]
            arm: None,
            is_shared: true,
        }
    }
    /// With the trace that the options ask for.
    #[cfg_attr(not(feature = "trace"), allow(unused_variables))]
    fn traced(self, options: &Options) -> Self {
        #[cfg(feature = "trace")]
        if let Some(tracer) = &options.trace {
            return self.with_trace(tracer.clone());
        }
        self
    }
}
