//! Jogs with a hold time: they end unless they are renewed.
//!
//! The arm has no such watchdog: a JOGCmd runs to the end of its range unless a stop arrives. So
//! [`Jog`] is a guard whose deadline is kept by the [`Gate`](crate::gate::Gate) in the driver task.
//! The task sends the stop when the deadline passes, when the guard is dropped and when the line
//! fails, and repeats it until the arm is at rest.

use std::time::Duration;

use magician_protocol::commands::JogCommonParams;
use magician_protocol::{Ctrl, FrameBuf, Layout, NoArgs};
use tokio::sync::{oneshot, watch};
use tokio::time::timeout_at;

use super::bounded_jog::BoundedJog;
use super::driver::{JogStart, Message, OwnJog, micros};
use super::fenced_jog::FencedJog;
use super::{Arm, Shared};
use crate::build::JogDirection;
use crate::connection::{Micros, Request};
use crate::gate::{Holder, JogEnd, JogId, JogKind, JogRequest};
use crate::message;
use crate::{Error, ErrorCode, Result};

/// Holder of all guards of a connection. Sharing one lets each guard reverse the jog of another on
/// the same axis.
const GUARDS: Holder = Holder(0);

/// Options of a [`Jog`].
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct JogOptions {
    /// Hold time: the jog ends if [`Jog::keep`] is not called for this long. 20 ms to 2 s; 300 ms
    /// by default.
    pub keep: Duration,
    /// Percentage of the configured jog speed, 1 to 100. It is set before the jog begins, and stays
    /// set. `None` keeps the current one.
    pub ratio: Option<f32>,
}

impl Default for JogOptions {
    fn default() -> Self {
        Self {
            // Choice: several key repeats fit into it, and the arm stops soon after the last.
            keep: Duration::from_millis(300),
            ratio: None,
        }
    }
}

impl JogOptions {
    /// Sets [`keep`](Self::keep).
    #[must_use]
    pub fn keep(mut self, keep: Duration) -> Self {
        self.keep = keep;
        self
    }

    /// Sets [`ratio`](Self::ratio).
    #[must_use]
    pub fn ratio(mut self, percent: f32) -> Self {
        self.ratio = Some(percent);
        self
    }

    fn check(&self) -> Result<()> {
        // Choice: below 20 ms a scheduler cannot renew a jog reliably; beyond 2 s the guard
        // protects little.
        let longest = Duration::from_secs(2);
        if self.keep < Duration::from_millis(20) || self.keep > longest {
            let message = message!(
                "the jog's hold time is {keep}, it must be 20 ms to 2 s",
                keep = format!("{:?}", self.keep)
            );
            return Err(Error::invalid(message));
        }
        match self.ratio {
            Some(ratio) if !(1.0..=100.0).contains(&ratio) => Err(Error::invalid(message!(
                "the jog's speed is {ratio} %, it must be 1 to 100 %",
                ratio
            ))),
            _ => Ok(()),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    Running,
    Ending(JogEnd),
    /// The arm is at rest, or the driver cannot do more about it.
    Over(JogEnd, Standstill),
}

/// Confirmation that the arm is at rest after a jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standstill {
    Seen,
    Unknown,
}

/// Jog in progress: a dead man's control.
///
/// It continues only while [`keep`](Self::keep) is called often enough. The driver stops it when
/// that ends, when this guard is dropped, when the line fails, and when anything stops the arm. The
/// stop is sent immediately, bypassing the queue, and repeated until two equal poses show that the
/// arm is at rest. The task that owns the line does this, so it does not depend on the calling
/// program.
///
/// The arm itself has no such watchdog: if the computer dies or the cable breaks, a jog continues
/// to the end of its range, except with [`Options::bounded_jogs`](super::Options::bounded_jogs).
/// This is a convenience, not a safety function.
///
/// ```no_run
/// use magician::{blocking::Arm, build::Axis};
///
/// # fn main() -> magician::Result<()> {
/// # let button_is_pressed = || true;
/// let arm = Arm::connect("/dev/ttyUSB0")?;
/// let mut state = arm.state(20.0)?;
/// let jog = arm.jog(Axis::J1.plus())?;
/// while button_is_pressed() {
///     jog.keep()?;
///     println!("J1 {:.1}", state.changed()?.pose.joint_angle[0]); // waits for the next of 20 readings a second
/// }
/// jog.stop()?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Jog {
    arm: Arm,
    id: JogId,
    keep: Duration,
    phase: watch::Receiver<Phase>,
}

impl Jog {
    /// Creates the guard of a jog that is still to be requested, and the sender of its phase.
    /// Dropping the guard ends the jog.
    pub(super) fn new(arm: &Arm, keep: Duration) -> (Self, watch::Sender<Phase>) {
        let (tells, phase) = watch::channel(Phase::Running);
        let jog = Self {
            arm: arm.clone(),
            id: arm.inner.shared.next_jog(),
            keep,
            phase,
        };
        (jog, tells)
    }

    /// Builds the request to the gate.
    pub(super) fn request(&self, direction: JogDirection, kind: JogKind) -> JogRequest {
        JogRequest {
            id: self.id,
            holder: GUARDS,
            direction,
            keep: micros(self.keep),
            kind,
        }
    }

    /// Renews the hold time. Sends nothing.
    ///
    /// # Errors
    /// The jog has ended or is about to: [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) if this
    /// was called too late, [`ErrorKind::Port`](crate::ErrorKind::Port) if the line broke,
    /// [`ErrorKind::Closed`](crate::ErrorKind::Closed) after a stop or another jog,
    /// [`ErrorKind::Unreachable`](crate::ErrorKind::Unreachable) at the end of the axis and before
    /// the arm's fence.
    pub fn keep(&self) -> Result<()> {
        let shared = &self.arm.inner.shared;
        let kept = shared.gate().keep(self.id, shared.now());
        match (kept, *self.phase.borrow()) {
            (Ok(()), _) => Ok(()),
            (_, Phase::Ending(why) | Phase::Over(why, _)) | (Err(Some(why)), Phase::Running) => {
                Err(self.ended(why))
            }
            // The gate has ended the jog and named no cause yet; the task is about to publish
            // the cause.
            (Err(None), Phase::Running) => Ok(()),
        }
    }

    /// Ends the jog, and returns when the arm is at rest (two equal poses). The connection's task
    /// continues to stop the arm even if this returns an error.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) if rest is not confirmed in time,
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) if the line broke.
    pub async fn stop(self) -> Result<()> {
        let deadline = self.arm.deadline();
        self.release();
        let mut phase = self.phase.clone();
        let over = phase.wait_for(|phase| matches!(phase, Phase::Over(..)));
        let over = match timeout_at(deadline, over).await {
            Ok(Ok(phase)) => Some(*phase),
            Ok(Err(_)) => Some(Phase::Over(JogEnd::Closed, Standstill::Unknown)),
            Err(_) => None,
        };
        match over {
            // A jog that replaced this one has moved the arm on, so rest is its concern.
            Some(Phase::Over(_, Standstill::Seen) | Phase::Over(JogEnd::Replaced, _)) => Ok(()),
            Some(Phase::Over(why @ (JogEnd::LinkLost | JogEnd::Closed), _)) => Err(self.ended(why)),
            // Timed out, or ended without being seen at rest.
            _ => {
                let message = message!(
                    "the jog's end is not confirmed: the arm does not answer, or still moves"
                );
                Err(Error::new(ErrorCode::StopUnconfirmed, message))
            }
        }
    }

    fn release(&self) {
        let shared = &self.arm.inner.shared;
        shared.gate().release(self.id);
        shared.led_ends(self.id);
        // With a full inbox the task is awake anyway, and asks the gate.
        let _ = self.arm.inner.messages.try_send(Message::Wake);
    }

    fn ended(&self, why: JogEnd) -> Error {
        let keep = self.keep;
        let (code, message) = match why {
            JogEnd::NotKept => (
                ErrorCode::NotKept,
                message!(
                    "the jog was ended: it was not renewed for {keep}",
                    keep = format!("{keep:?}")
                ),
            ),
            JogEnd::LinkLost => (
                ErrorCode::LineLost,
                message!("the line broke during a jog: a stop is sent as soon as it is back"),
            ),
            JogEnd::Fence => (
                ErrorCode::Fenced,
                message!("the jog was ended before it reached the arm's fence"),
            ),
            JogEnd::Limit => (
                ErrorCode::OutOfReach,
                message!("the jog came to the end of its way"),
            ),
            JogEnd::Doubt => (
                ErrorCode::NoAnswer,
                message!("the jog was ended: the arm did not answer"),
            ),
            JogEnd::Replaced => (ErrorCode::RunOver, message!("another jog replaced it")),
            JogEnd::Stopped => (ErrorCode::Stopped, message!("a stop ended the jog")),
            JogEnd::Released => (ErrorCode::RunOver, message!("the jog was ended")),
            JogEnd::Failed => (ErrorCode::NoAnswer, message!("the jog did not begin")),
            JogEnd::Closed => return Error::closed(),
        };
        Error::new(code, message)
    }
}

impl Drop for Jog {
    fn drop(&mut self) {
        self.release();
    }
}

impl Shared {
    /// Returns the microseconds since the connection began.
    pub(super) fn now(&self) -> Micros {
        micros(self.begun.elapsed())
    }
}

impl Arm {
    /// Jogs one axis or joint in one direction, while the returned guard is [renewed](Jog::keep) at
    /// least every 300 ms.
    ///
    /// It takes effect immediately, bypassing the queue. Only one jog is active: a new one ends the
    /// current one and begins when the arm is at rest, because an arm carries the speed of a jog
    /// over to the axis of the next. Only the opposite direction of the same axis begins at once.
    /// Under a [fence](super::Options::fence) the jog stops before it.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) while a program runs, and while
    /// the laser is on ([`Laser::check_off`](super::Laser::check_off));
    /// [`ErrorKind::Unreachable`](crate::ErrorKind::Unreachable) if the arm's fence
    /// ([`Options::fence`](super::Options::fence)) leaves no room, else as [`set`](Self::set). If
    /// the jog may have begun all the same, its stop is sent.
    pub async fn jog(&self, direction: JogDirection) -> Result<Jog> {
        self.jog_with(direction, JogOptions::default()).await
    }

    /// Jogs as [`jog`](Self::jog) does, with options.
    ///
    /// # Errors
    /// Same as [`jog`](Self::jog); [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for
    /// options out of range.
    pub async fn jog_with(&self, direction: JogDirection, options: JogOptions) -> Result<Jog> {
        let stops = self.stops();
        let deadline = self.deadline();
        options.check()?;
        let silent = || Error::new(ErrorCode::NoAnswer, message!("no answer"));
        // Here, so that it holds for jogs of all kinds and front ends. Costs no frame while the
        // state of the laser is known.
        let dark = timeout_at(deadline, self.laser().check_off()).await;
        dark.unwrap_or_else(|_| Err(silent()))?;
        let in_pieces = self.inner.options.bounded_jogs;
        let fenced = self.fence().is_some_and(|fence| fence.bounds_motion());
        if fenced && !in_pieces && self.moving() {
            // The fence check needs a start position, so the arm has to be at rest.
            self.stop_jog().await?;
        }
        if let Some(ratio) = options.ratio {
            let read = Request::get::<JogCommonParams>(&NoArgs)?;
            let read = self.ask_until(read, deadline).await?;
            let slower = JogCommonParams {
                velocity_ratio: ratio,
                ..JogCommonParams::decode(read.frame().params())?
            };
            self.ask_until(Request::set(&slower)?, deadline).await?;
        }
        if in_pieces {
            return BoundedJog::start(self, direction, options.keep, stops, deadline).await;
        }
        let turn = Box::pin(FencedJog::hold(self, direction, deadline)).await?;
        // Held to the end of this call: no other motion may pass the fence's check before the jog
        // begins.
        let (_turn, fence) = turn.unzip();
        // From here on a dropped call ends the jog, because it drops the guard.
        let (jog, phase) = Jog::new(self, options.keep);
        let frame = FrameBuf::set(&direction.into(), Ctrl::SET)?;
        let own = OwnJog {
            request: Request::of(frame),
            fence: fence.flatten(),
        };
        let (reply, answer) = oneshot::channel();
        let start = JogStart {
            asks: jog.request(direction, JogKind::Own),
            own: Some(own),
            deadline,
            stops,
            phase,
            reply,
        };
        match timeout_at(
            deadline,
            self.inner.messages.send(Message::Jog(Box::new(start))),
        )
        .await
        {
            Ok(Ok(())) => {}
            Ok(Err(_)) => return Err(Error::closed()),
            // The inbox stayed full until the deadline, so the task is starved.
            Err(_) => return Err(Error::stuck()),
        }
        // The request expires with this call, so a jog that has not begun by then never does.
        self.answer_or(silent(), answer, &frame, deadline).await?;
        Ok(jog)
    }
}
