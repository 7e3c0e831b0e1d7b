//! Line to an arm through a station.
//!
//! A driver writes frames to a stream; a bridge task translates each into a request of the API and
//! the answer back into a frame. So every program written for the driver works over a station,
//! under its leases. Jogs become jogs of the station, so that they end if this program hangs. If a
//! request fails as an arm would (no answer), no frame is returned; any other refusal ends the
//! line.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;

use magician::build::JogDirection;
use magician_protocol::{Deframer, Direction, Event, FrameBuf, JogCommand, Row, Set, describe};
use serde_json::{Map, Value, json};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, DuplexStream, ReadBuf};
use tokio::sync;
use tokio::task::JoinHandle;
use tokio::time::{MissedTickBehavior, interval};

use super::{ClientError, StationClient};
use crate::api::encode;
use crate::reading::to_value;

/// Size of the buffers between driver and bridge, bytes.
const BUFFER_SIZE: usize = 4096;
/// Interval of keeping a jog alive: about a quarter of the station's default keep-alive period of
/// 250 ms.
const KEEP_INTERVAL: Duration = Duration::from_millis(60);

/// Line to an arm of a station, for [`Arm::over`](magician::Arm::over).
///
/// Reading needs no lease. The first command that sets or moves acquires it, and it is kept until
/// the line ends. Jogs run at the station, so they end if this program hangs.
#[derive(Debug)]
pub struct StationLine {
    stream: DuplexStream,
    broken: LineEnd,
    lease: LineLease,
}

/// Lease of a line. Acquired by the first command that sets or moves, or earlier by
/// [`take`](Self::take), and given back at the end of the line.
#[derive(Clone, Debug)]
pub struct LineLease {
    client: StationClient,
    arm: Option<String>,
    held: Arc<sync::Mutex<Option<String>>>,
}

impl LineLease {
    /// Acquires the lease before anything is sent that a refusal would leave half done. Waits at
    /// most `wait` until it is free.
    ///
    /// # Errors
    /// The refusal of the station. [`ClientError::free_soon`] is true if it will be free soon.
    pub async fn take(&self, wait: Duration) -> Result<(), ClientError> {
        // Locked across the call, so that two tasks do not acquire it twice.
        let mut held = self.held.lock().await;
        if held.is_none() {
            let mut params = json!({});
            if let Some(arm) = &self.arm {
                params["arm"] = json!(arm);
            }
            if !wait.is_zero() {
                params["wait_s"] = json!(wait.as_secs_f64());
            }
            let granted = self.client.lease("lease.acquire", params).await?;
            *held = granted["lease"].as_str().map(str::to_owned);
        }
        Ok(())
    }

    async fn is_held(&self) -> bool {
        self.held.lock().await.is_some()
    }
}

/// Reason why a line broke: a refusal of the station, or the end of the connection. Outlives the
/// line.
#[derive(Clone, Debug, Default)]
pub struct LineEnd(Arc<Mutex<Option<ClientError>>>);

impl LineEnd {
    /// Returns the reason. `None` while the line is intact.
    #[must_use]
    pub fn why(&self) -> Option<ClientError> {
        self.why_mut().clone()
    }

    fn why_mut(&self) -> MutexGuard<'_, Option<ClientError>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl StationLine {
    /// Opens a line to this arm, or to the only one.
    ///
    /// The returned task ends after the lease was given back. With `yes`, commands that are
    /// dangerous or may burn are sent as confirmed. Pass [`StationClient::end_notice`] to the
    /// options of the driver.
    #[must_use]
    pub fn open(client: &StationClient, arm: Option<&str>, yes: bool) -> (Self, JoinHandle<()>) {
        let (stream, far) = tokio::io::duplex(BUFFER_SIZE);
        let broken = LineEnd::default();
        let lease = LineLease {
            client: client.clone(),
            arm: arm.map(str::to_owned),
            held: Arc::default(),
        };
        let bridge = Bridge {
            client: client.clone(),
            arm: arm.map(str::to_owned),
            yes,
            lease: lease.clone(),
            jog: None,
            stopped: false,
        };
        let end = broken.clone();
        let task = tokio::spawn(async move {
            bridge.carry(far, &end).await;
        });
        let line = Self {
            stream,
            broken,
            lease,
        };
        (line, task)
    }

    /// Returns a handle to the reason of the line's end.
    #[must_use]
    pub fn end(&self) -> LineEnd {
        self.broken.clone()
    }

    /// Returns the lease of the line.
    #[must_use]
    pub fn lease(&self) -> LineLease {
        self.lease.clone()
    }

    fn failure(&self) -> Option<io::Error> {
        let why = self.broken.why()?;
        let kind = match why {
            // The kind that the driver reports as a refusal instead of a broken line.
            ClientError::Refused { .. } => io::ErrorKind::PermissionDenied,
            // The messages of these errors already say what became of the line.
            ClientError::Lost | ClientError::Ended => io::ErrorKind::ConnectionAborted,
            _ => io::ErrorKind::Other,
        };
        Some(io::Error::new(kind, why))
    }
}

impl AsyncRead for StationLine {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(cx, buffer);
        match (read, self.failure()) {
            // The reason of the end instead of a bare end of file.
            (Poll::Ready(Ok(())), Some(why)) if buffer.filled().len() == before => {
                Poll::Ready(Err(why))
            }
            (read, _) => read,
        }
    }
}

impl AsyncWrite for StationLine {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        match (
            Pin::new(&mut self.stream).poll_write(cx, bytes),
            self.failure(),
        ) {
            (Poll::Ready(Err(_)), Some(why)) => Poll::Ready(Err(why)),
            (written, _) => written,
        }
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}

struct Bridge {
    client: StationClient,
    arm: Option<String>,
    yes: bool,
    lease: LineLease,
    /// Current jog of the station.
    jog: Option<String>,
    /// True if the bridge has stopped the arm and set nothing since.
    stopped: bool,
}

impl Bridge {
    async fn carry(mut self, mut far: DuplexStream, end: &LineEnd) {
        if let Err(error) = self.exchange(&mut far).await {
            // An ending station refuses calls with several errors. They all mean that it ends.
            let ends = self.client.end_notice().is_given();
            *end.why_mut() = Some(if ends { ClientError::Ended } else { error });
        }
        // Stored before the stream ends, so that the driver finds the reason at once.
        drop(far);
        // Given back explicitly: then motion that the driver left running continues, which it would
        // not after a lost lease.
        let lease = self.lease.held.lock().await.take();
        if let Some(lease) = lease
            && let Err(error) = self.client.release(&lease).await
        {
            end.why_mut().get_or_insert(error);
        }
    }

    async fn exchange(&mut self, far: &mut DuplexStream) -> Result<(), ClientError> {
        let mut deframer = Deframer::new();
        let mut bytes = [0; BUFFER_SIZE];
        let mut keeps = interval(KEEP_INTERVAL);
        // After a pause one keep suffices; a burst would not help.
        keeps.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let count = tokio::select! {
                // An error means that the driver dropped the line, like the end of the stream.
                count = far.read(&mut bytes) => count.unwrap_or(0),
                _ = keeps.tick(), if self.jog.is_some() => {
                    self.client.notify("jog.keep", json!({"jog": self.jog}));
                    continue;
                }
            };
            if count == 0 {
                return Ok(());
            }
            let mut input = bytes.get(..count).unwrap_or_default();
            let mut frames = Vec::new();
            while let Some(event) = deframer.next(&mut input) {
                if let Event::Frame { frame, .. } = event {
                    // Copied, because the frame borrows the deframer's buffer.
                    frames.extend(FrameBuf::new(frame.id(), frame.ctrl(), frame.params()));
                }
            }
            for frame in frames {
                if let Some(reply) = self.send_frame(&frame).await?
                    && far.write_all(reply.bytes()).await.is_err()
                {
                    return Ok(());
                }
            }
        }
    }

    /// Sends a frame to the station as a request. `None` if an arm would not answer it either.
    async fn send_frame(&mut self, frame: &FrameBuf) -> Result<Option<FrameBuf>, ClientError> {
        let frame = frame.frame();
        // Unknown frames get no answer, as from an arm.
        let Some(row) = Row::with_id(frame.id()) else {
            return Ok(None);
        };
        let Ok(described) = describe(&frame, Direction::Request) else {
            return Ok(None);
        };
        let Ok(Value::Object(fields)) = to_value(&described) else {
            return Ok(None);
        };
        let (ctrl, id) = (frame.ctrl(), frame.id());
        let reply = |params: &[u8]| Ok(FrameBuf::new(id, ctrl, params).ok());
        if !row.sets(ctrl) {
            let mut params = json!({"command": row.get_name});
            if !fields.is_empty() {
                params["query"] = Value::Object(fields);
            }
            return match self.call("arm.get", params).await {
                Ok(value) => {
                    let value = value.as_object().cloned().unwrap_or_default();
                    let layout = row.value.map(|layout| encode(layout, &value));
                    reply(&layout.and_then(Result::ok).unwrap_or_default())
                }
                Err(error) => no_reply_or(error),
            };
        }
        // The station encodes the command from its fields, so it must be valid here.
        let Ok(command) = Set::decode(id, frame.params()) else {
            return Ok(None);
        };
        // Commands that start, stop or clear the queue act at once even if they are sent as queued.
        if ctrl.queued() && !row.steers_queue() {
            let mut params = json!({"command": row.set_name, "fields": fields});
            self.add_arm(&mut params);
            self.lease().await?;
            return match self.call("arm.enqueue", params).await {
                Ok(value) => reply(&value["index"].as_u64().unwrap_or_default().to_le_bytes()),
                Err(error) => no_reply_or(error),
            };
        }
        match self.act(row, &command, fields).await {
            Ok(()) => reply(&[]),
            Err(error) => no_reply_or(error),
        }
    }

    /// Carries out a command with immediate effect.
    async fn act(
        &mut self,
        row: &Row,
        command: &Set,
        fields: Map<String, Value>,
    ) -> Result<(), ClientError> {
        let is_held = self.lease.is_held().await;
        match command {
            // Any session may stop, and a stop overtakes everything that waits at the station.
            Set::QueuedCmdForceStopExec(_) => {
                self.jog = None;
                self.stopped = true;
                return self.call("arm.stop", json!({})).await.map(drop);
            }
            Set::JogCmd(jog) if jog.cmd == JogCommand::Stop => {
                if let Some(jog) = self.jog.take() {
                    return self.call("jog.stop", json!({"jog": jog})).await.map(drop);
                }
                // Stopping a jog that this line did not start needs the lease; without one there is
                // nothing to stop.
                if !is_held {
                    return Ok(());
                }
            }
            Set::JogCmd(_) => {
                self.lease().await?;
                // Anything else goes to the station as it is.
                if let Ok(direction) = JogDirection::try_from(command) {
                    let params = json!({"axis": direction.to_string()});
                    let started = self.call("jog.start", params).await?;
                    self.jog = started["jog"].as_str().map(str::to_owned);
                    return Ok(());
                }
            }
            // After a stop without the lease: the station has already cleared the queue.
            Set::QueuedCmdClear(_) if !is_held && self.stopped => return Ok(()),
            Set::EMotor(motor) if !is_held && self.stopped && !motor.is_enabled.is_on() => {
                return Ok(());
            }
            Set::SetEndEffectorLaser(laser) if !is_held && !laser.on.is_on() => {
                if self.stopped {
                    return Ok(());
                }
                // Another session has the arm. A stop may follow, which also switches the laser off
                // and needs no lease.
                match self.lease().await {
                    Err(error) if is_held_by_other(&error) => return Ok(()),
                    leased => leased?,
                }
            }
            _ => {}
        }
        let mut params = json!({"command": row.set_name, "fields": fields});
        self.add_arm(&mut params);
        self.lease().await?;
        self.call("arm.set", params).await.map(drop)
    }

    fn add_arm(&self, params: &mut Value) {
        if self.yes {
            params["yes"] = json!(true);
        }
    }

    async fn lease(&mut self) -> Result<(), ClientError> {
        self.lease.take(Duration::ZERO).await?;
        // The command that needs the lease sets something after the stop.
        self.stopped = false;
        Ok(())
    }

    async fn call(&self, method: &str, mut params: Value) -> Result<Value, ClientError> {
        // `jog.stop` identifies the arm by the jog.
        let takes = !["jog.stop"].contains(&method);
        if let (Some(arm), true) = (&self.arm, takes) {
            params["arm"] = json!(arm);
        }
        self.client.call(method, params).await
    }
}

/// True if another session has the arm.
fn is_held_by_other(error: &ClientError) -> bool {
    matches!(error.kind(), Some("lease" | "forbidden" | "busy"))
}

/// Returns no reply for errors for which an arm would not reply either. All others end the line.
fn no_reply_or(error: ClientError) -> Result<Option<FrameBuf>, ClientError> {
    match error.kind() {
        Some("timeout" | "unexpected" | "unsupported") => Ok(None),
        // Refusals by the station. An arm has no such answer.
        _ => Err(error),
    }
}
