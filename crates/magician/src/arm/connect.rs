use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use magician_protocol::commands::{DeviceVersion, QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::{mpsc, oneshot};

use super::driver::{Driver, Message};
use super::{Arm, Options, Shared};
use crate::connection::{Connection, Settings, Stats};
use crate::transport::{self, Line, Stream};
use crate::{Error, ErrorKind, Result, Target};

/// Connecting and leaving.
impl Arm {
    /// Connects to an arm and makes sure that it answers.
    ///
    /// # Errors
    /// [`ErrorKind::Port`] when the port is not there, not allowed or in use, [`ErrorKind::Timeout`]
    /// when nothing answers, [`ErrorKind::Unexpected`] when something else does,
    /// [`ErrorKind::Unsupported`] for Bluetooth.
    pub async fn connect(target: &Target) -> Result<Self> {
        Self::connect_with(target, Options::default()).await
    }

    /// As [`connect`](Self::connect), with other options.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub async fn connect_with(target: &Target, options: Options) -> Result<Self> {
        let line = transport::Way::to(target).open().await?;
        Self::greet(line, options).await
    }

    /// Talks to an arm over any stream of bytes that keeps their order.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub async fn over<T>(stream: T, options: Options) -> Result<Self>
    where
        T: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        let line = Line {
            transport: Box::new(Stream(stream)),
            settings: Settings::ORDERED,
            name: "the stream".to_owned(),
            tried: "a stream",
        };
        Self::greet(line, options).await
    }

    /// Talks to a virtual arm of the caller's making: a [`VirtualArm`](crate::VirtualArm), or what becomes one.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    #[cfg(feature = "sim")]
    pub async fn simulated(arm: impl Into<crate::VirtualArm>, options: Options) -> Result<Self> {
        let line = Line {
            transport: Box::new(transport::Sim::new(arm.into())),
            settings: Settings::ORDERED,
            name: "sim".to_owned(),
            tried: "a virtual arm",
        };
        Self::greet(line, options).await
    }

    pub(crate) async fn greet(line: Line, options: Options) -> Result<Self> {
        let settings = Settings {
            window: options.window,
            ..line.settings
        };
        let (messages, inbox) = mpsc::channel(64);
        let shared = Arc::new(Shared::default());
        let driver = Driver::new(
            Connection::new(settings),
            line.transport,
            inbox,
            Arc::clone(&shared),
            line.name.clone(),
        );
        let probe = options.probe;
        let arm = Self {
            messages: Some(messages),
            task: Some(tokio::spawn(driver.run())),
            shared,
            flow: tokio::sync::Mutex::default(),
            own: Mutex::default(),
            options,
            name: line.name,
            warned: AtomicBool::new(false),
        };
        if probe {
            arm.probe(line.tried).await?;
        }
        Ok(arm)
    }

    /// Asks for the version, and reads the queue once: where the indices stand, whether it is empty.
    async fn probe(&self, tried: &str) -> Result<()> {
        match self.get::<DeviceVersion>().await {
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::Timeout => {
                return Err(self.silent(tried).await);
            }
            Err(error) => return Err(error),
        }
        self.get::<QueuedCmdCurrentIndex>().await?;
        self.get::<QueuedCmdLeftSpace>().await?;
        Ok(())
    }

    /// The port is there and nothing answers: what was tried, what was seen.
    async fn silent(&self, tried: &str) -> Error {
        let (stats, _) = self.stats().await.unwrap_or_default();
        let heard = match (stats.bytes, stats.frames) {
            (0, _) => "nothing came back; is the arm switched on?".to_owned(),
            (bytes, 0) => format!(
                "{bytes} bytes came back that are not this arm's; is another device on the port?"
            ),
            (bytes, frames) => {
                format!("{bytes} bytes came back in {frames} frames, none of them the answer")
            }
        };
        let name = &self.name;
        // A datagram that nobody takes looks like one that somebody does not answer.
        let silent = match tried {
            "UDP" => format!("no arm answers at {name}"),
            _ => format!("{name} is there but no arm answers"),
        };
        let message = format!(
            "{silent}: {tried}, {} requests for GetDeviceVersion in {:.1} s, {heard}",
            stats.sent,
            self.options.timeout.as_secs_f64(),
        );
        Error::new(ErrorKind::Timeout, message)
    }

    /// Lets what this handle set going go on when the handle is dropped.
    pub fn detach(&self) {
        self.shared.detached.store(true, Ordering::SeqCst);
    }

    /// Ends the connection as dropping it does, and returns when that is done.
    pub async fn close(mut self) {
        self.messages = None;
        if let Some(task) = self.task.take() {
            let _ = task.await;
        }
    }

    /// What the connection is called in messages: the target as it was given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What went over the line so far, and how many commands the arm's queue holds.
    ///
    /// # Errors
    /// [`ErrorKind::Closed`].
    pub async fn stats(&self) -> Result<(Stats, u32)> {
        let (reply, answer) = oneshot::channel();
        let messages = self.messages.as_ref().ok_or_else(Error::closed)?;
        let sent = messages.send(Message::Stats(reply)).await;
        sent.map_err(|_| Error::closed())?;
        answer.await.map_err(|_| Error::closed())
    }
}
