//! Connecting to an arm, and ending the connection.
//!
//! A connection is made in three steps: a [`Route`](transport::Route) or the caller's opener yields
//! a [`Line`], [`Arm::greet`] spawns the driver task on it, and a probe makes sure that an arm
//! answers. The route is kept so that the task can open the line again after it broke.

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
use crate::{Error, ErrorCode, ErrorKind, IntoTarget, Result, Target, message};

/// Connecting and disconnecting.
impl Arm {
    /// Connects as [`connect`](Self::connect) does, with other options.
    ///
    /// # Errors
    /// Same as [`connect`](Self::connect); [`ErrorKind::InvalidInput`] if the target does not
    /// support the requested faults.
    pub async fn connect_with(target: impl IntoTarget, options: Options) -> Result<Self> {
        let target = target.into_target()?;
        // A line to an arm in this process breaks only by an injected fault.
        let breaks = !matches!(target, Target::Sim(_)) || options.may_unplug();
        Self::go(transport::Route::to(&target), breaks, options).await
    }

    /// Opens a route with the faults and trace of the options, and reopens it after each break if
    /// `breaks`.
    async fn go(way: transport::Route, breaks: bool, options: Options) -> Result<Self> {
        let way = Arc::new(way.fitted(&options)?);
        // Opened here and not in the task, so that a wrong port is an error of this call.
        let line = way.open().await?;
        let to_open = Arc::clone(&way);
        let again: Opener = Box::new(move || {
            let way = Arc::clone(&to_open);
            Box::pin(async move { way.open().await })
        });
        let greeted = Self::greet(line, breaks.then_some(again), options).await;
        greeted.map_err(|error| way.named(error))
    }

    /// Connects over any byte stream that keeps the order of bytes. A broken stream ends the
    /// connection; [`over_with`](Self::over_with) reopens it.
    ///
    /// # Errors
    /// Same as [`connect`](Self::connect).
    pub async fn over<T>(stream: T, options: Options) -> Result<Self>
    where
        T: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        options.without_faults()?;
        Self::greet(Line::over(stream).traced(&options), None, options).await
    }

    /// Connects as [`over`](Self::over) does, with an opener: called now, and again after each
    /// break.
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
    /// Same as [`connect`](Self::connect); [`ErrorKind::Port`] if the first stream cannot be
    /// opened.
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
                    let message = message!(
                        "the stream cannot be opened: {cause}",
                        cause = error.to_string()
                    );
                    Error::port(message, error)
                })?;
                Ok(Line::over(stream).traced(&options))
            })
        });
        let line = again().await?;
        // Without a route there is no name to add to an error.
        Self::greet(line, Some(again), options).await
    }

    /// Connects to a virtual arm of the caller: a [`VirtualArm`](crate::VirtualArm), or a value
    /// that converts into one. Commands are checked against the model of that arm.
    ///
    /// # Errors
    /// Same as [`connect`](Self::connect).
    #[cfg(feature = "sim")]
    pub async fn simulated(arm: impl Into<crate::VirtualArm>, options: Options) -> Result<Self> {
        let arm = arm.into();
        let model = arm.with(|controller| *controller.arm_model());
        let breaks = options.may_unplug() || arm.lock().breaks();
        Self::go(
            transport::Route::to_virtual(arm),
            breaks,
            options.model(model),
        )
        .await
    }

    /// Returns the virtual arm at the other end if it is in this process, to observe it and its
    /// world from outside; `None` for a virtual arm elsewhere and for a real arm.
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
        // In a window a lost command can only be found by the order of the replies, and UDP keeps
        // no order.
        if options.window > 1 && !line.settings.ordered {
            let message = message!(
                "a window of {window} needs a line that keeps frames in order, and {name} does \
                    not: leave it at 1",
                window = options.window,
                name = line.name
            );
            return Err(Error::invalid(message));
        }
        if !line.settings.ordered {
            line.settings.echo = micros(options.echo);
        }
        // Room for a burst of all handles; a handle that finds it full waits for a place until its
        // deadline.
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
        // Not joined: the task ends by itself after the last handle, and `ended` reports it.
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
            held: super::fence::FenceState::new(options.fence),
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

    /// Lets motion that this connection started continue after it ends, however it ends and
    /// whichever clone calls this.
    pub fn detach(&self) {
        self.inner.shared.detached.store(true, Ordering::SeqCst);
    }

    /// Ends the connection for all its clones, and returns when it has ended.
    ///
    /// Motion that it started is stopped as when the last clone is dropped, unless it was
    /// [detached](Self::detach). Every call of another clone fails with [`ErrorKind::Closed`],
    /// including pending calls.
    pub async fn close(self) {
        // A send error means that the task has ended already.
        let _ = self.inner.messages.send(Message::Close).await;
        self.ended().await;
    }

    /// Resolves when the connection has ended. The future does not keep the connection open.
    pub(crate) fn ended(&self) -> impl Future<Output = ()> + Send + 'static {
        let mut link = self.inner.shared.link.subscribe();
        async move {
            let _ = link.wait_for(|link| *link == Link::Closed).await;
        }
    }

    /// Returns the timeout of every single call to the arm.
    #[must_use]
    pub fn timeout(&self) -> Duration {
        Duration::from_micros(self.inner.timeout.load(Ordering::SeqCst))
    }

    /// Changes [`Options::timeout`] for all clones, for calls that begin from now on.
    pub fn set_timeout(&self, timeout: Duration) {
        self.inner.timeout.store(micros(timeout), Ordering::SeqCst);
    }

    /// Returns the name of the connection in messages: the target as it was given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.inner.shared.name
    }

    /// Returns the current line statistics and the number of places in the arm's queue.
    ///
    /// # Errors
    /// [`ErrorKind::Closed`] if the connection has ended.
    pub async fn stats(&self) -> Result<(Stats, u32)> {
        let (reply, mut answer) = oneshot::channel();
        let asked = async {
            let sent = self.inner.messages.send(Message::Stats(reply)).await;
            sent.map_err(|_| Error::closed())?;
            self.answer_or_end(&mut answer)
                .await
                .ok_or_else(Error::closed)
        };
        let answer = timeout_at(self.deadline(), asked).await;
        answer.unwrap_or_else(|_| Err(Error::stuck()))
    }
}

/// Reads the firmware version to check that an arm answers, then the queue once, to learn its index
/// and free places.
async fn probe(arm: &Arm, tried: &'static str) -> Result<()> {
    match arm.get::<DeviceVersion>().await {
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::Timeout => {
            return Err(silent(arm, tried).await);
        }
        Err(error) => return Err(error),
    }
    // Left space before index, as the picture expects it: only in this order do they prove that the
    // arm is at rest.
    arm.get::<QueuedCmdLeftSpace>().await?;
    arm.get::<QueuedCmdCurrentIndex>().await?;
    Ok(())
}

/// Builds the error for an open port without an answer: the attempts made and the bytes seen.
async fn silent(arm: &Arm, tried: &'static str) -> Error {
    let (stats, _) = arm.stats().await.unwrap_or_default();
    let heard = match (stats.bytes, stats.frames) {
        (0, _) => message!("no reply; is the arm switched on?"),
        (bytes, 0) => message!(
            "{bytes} bytes came back that are not from this arm; is another device on the port?",
            bytes
        ),
        (bytes, frames) => message!(
            "{bytes} bytes came back in {frames} frames, none of them the reply",
            bytes,
            frames
        ),
    };
    let name = arm.name();
    // UDP has no connection: a missing receiver looks like a missing reply.
    let silent = match tried {
        "UDP" => message!("no arm answers at {name}", name),
        _ => message!("{name} is there but no arm answers", name),
    };
    let message = message!(
        "{silent}: {line}, {count} requests for GetDeviceVersion in {seconds:.1} s, {heard}",
        silent,
        line = magician_host::Message::word(tried),
        count = stats.sent,
        seconds = arm.timeout().as_secs_f64(),
        heard
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
    /// Wraps the line in the tracer of the options, if any.
    #[cfg_attr(not(feature = "trace"), allow(unused_variables))]
    fn traced(self, options: &Options) -> Self {
        #[cfg(feature = "trace")]
        if let Some(tracer) = &options.trace {
            return self.with_trace(tracer.clone());
        }
        self
    }
}
