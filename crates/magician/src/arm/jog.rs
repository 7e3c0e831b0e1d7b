//! Jogging that ends by itself unless it is renewed.

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

/// The holder of all guards of a connection: each of them may turn round on its axis what another one began.
const GUARDS: Holder = Holder(0);

/// How a [`Jog`] behaves.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct JogOptions {
    /// The jog ends when [`Jog::keep`] has not been called for so long; 300 ms unless set, 20 ms to 2 s.
    pub keep: Duration,
    /// Share of the set jog speed, 1 to 100 %. It is set before the jog begins, and stays. `None`: as it is.
    pub ratio: Option<f32>,
}

impl Default for JogOptions {
    fn default() -> Self {
        Self {
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
    /// The arm stands, or there is nothing more that can be done about it.
    Over(JogEnd, Stands),
}

/// Whether the arm was seen to stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stands {
    Seen,
    Unknown,
}

/// A jog under way: a dead man's control. It goes on only while [`keep`](Self::keep) is called often enough; when that
/// ends, when this is dropped, when the line fails, when anything stops the arm, the stop is sent, at once and past the
/// queue, and sent again until two equal poses show that the arm stands. That happens in the task that owns the line, so it
/// does not depend on the program that called.
///
/// The arm itself has no such watchdog: when the computer dies or the cable breaks, a jog goes on to the end of its range, but
/// one in pieces ([`Options::bounded_jogs`](super::Options::bounded_jogs)). This is a convenience, not a safety function.
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
    /// A guard of a jog that is still to be asked for, and what tells it how far that is. Dropped, it ends the jog.
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

    /// What the gate is asked for.
    pub(super) fn request(&self, direction: JogDirection, kind: JogKind) -> JogRequest {
        JogRequest {
            id: self.id,
            holder: GUARDS,
            direction,
            keep: micros(self.keep),
            kind,
        }
    }

    /// Lets it go on. Costs nothing: nothing is sent.
    ///
    /// # Errors
    /// It has ended or is about to: [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) when this was called too late, [`ErrorKind::Port`](crate::ErrorKind::Port) when the
    /// line broke, [`ErrorKind::Closed`](crate::ErrorKind::Closed) when a stop or another jog came,
    /// [`ErrorKind::Unreachable`](crate::ErrorKind::Unreachable) at the end of its axis and before the arm's fence.
    pub fn keep(&self) -> Result<()> {
        let shared = &self.arm.inner.shared;
        let kept = shared.gate().keep(self.id, shared.now());
        match (kept, *self.phase.borrow()) {
            (Ok(()), _) => Ok(()),
            (_, Phase::Ending(why) | Phase::Over(why, _)) | (Err(Some(why)), Phase::Running) => {
                Err(self.ended(why))
            }
            // The task is about to tell its end.
            (Err(None), Phase::Running) => Ok(()),
        }
    }

    /// Ends it, and returns when the arm stands: two equal poses. The connection's task goes on with stopping even when
    /// this returns an error.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) when that cannot be made sure of in time, [`ErrorKind::Port`](crate::ErrorKind::Port) when the line broke.
    pub async fn stop(self) -> Result<()> {
        let deadline = self.arm.deadline();
        self.release();
        let mut phase = self.phase.clone();
        let over = phase.wait_for(|phase| matches!(phase, Phase::Over(..)));
        let over = match timeout_at(deadline, over).await {
            Ok(Ok(phase)) => Some(*phase),
            Ok(Err(_)) => Some(Phase::Over(JogEnd::Closed, Stands::Unknown)),
            Err(_) => None,
        };
        match over {
            Some(Phase::Over(_, Stands::Seen) | Phase::Over(JogEnd::Replaced, _)) => Ok(()),
            Some(Phase::Over(why @ (JogEnd::LinkLost | JogEnd::Closed), _)) => Err(self.ended(why)),
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
        // A task with so many messages before it is awake, and looks.
        let _ = self.arm.inner.messages.try_send(Message::Wake);
    }

    fn ended(&self, why: JogEnd) -> Error {
        let keep = self.keep;
        let (code, message) = match why {
            JogEnd::NotKept => (
                ErrorCode::NotKept,
                format!("the jog was ended: it was not renewed for {keep:?}"),
            ),
            JogEnd::LinkLost => (
                ErrorCode::LineLost,
                "the line broke during a jog: a stop is sent as soon as it is back".to_owned(),
            ),
            JogEnd::Fence => (
                ErrorCode::Fenced,
                "the jog was ended before it reached the arm's fence".to_owned(),
            ),
            JogEnd::Limit => (
                ErrorCode::OutOfReach,
                "the jog came to the end of its way".to_owned(),
            ),
            JogEnd::Doubt => (
                ErrorCode::NoAnswer,
                "the jog was ended: the arm did not answer".to_owned(),
            ),
            JogEnd::Replaced => (ErrorCode::RunOver, "another jog replaced it".to_owned()),
            JogEnd::Stopped => (ErrorCode::Stopped, "a stop ended the jog".to_owned()),
            JogEnd::Released => (ErrorCode::RunOver, "the jog was ended".to_owned()),
            JogEnd::Failed => (ErrorCode::NoAnswer, "the jog did not begin".to_owned()),
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
    /// Microseconds since the connection's beginning.
    pub(super) fn now(&self) -> Micros {
        micros(self.begun.elapsed())
    }
}

impl Arm {
    /// Jogs, one axis or joint in one direction, for as long as the guard that this returns is
    /// [kept up](Jog::keep), every 300 ms at least.
    /// It acts at once, past the queue. One jog at a time: a new one ends the one under way and begins when the arm was seen
    /// at rest, because an arm carries the speed of a jog over to the axis of the next one. Only the opposite direction
    /// of the same axis begins at once. Under a [fence](super::Options::fence) it stops before that.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) while a program runs, [`ErrorKind::Unreachable`](crate::ErrorKind::Unreachable) where the
    /// arm's fence ([`Options::fence`](super::Options::fence)) leaves no room for it, else as [`set`](Self::set). When it is not certain that
    /// the jog did not begin, its stop is sent all the same.
    pub async fn jog(&self, direction: JogDirection) -> Result<Jog> {
        self.jog_with(direction, JogOptions::default()).await
    }

    /// As [`jog`](Self::jog), with options.
    ///
    /// # Errors
    /// As [`jog`](Self::jog); [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for options out of range.
    pub async fn jog_with(&self, direction: JogDirection, options: JogOptions) -> Result<Jog> {
        let stops = self.stops();
        let deadline = self.deadline();
        options.check()?;
        let in_pieces = self.inner.options.bounded_jogs;
        let fenced = self.fence().is_some_and(|fence| fence.bounds_motion());
        if fenced && !in_pieces && self.moving() {
            // What follows needs an arm that stands.
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
        let (_turn, fence) = turn.unzip();
        // From here on giving up ends it: the guard is dropped.
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
            Err(_) => return Err(Error::stuck()),
        }
        // Its life ends with this call, so what has not begun never does.
        let silent = Error::new(ErrorCode::NoAnswer, message!("no answer"));
        self.answer_or(silent, answer, &frame, deadline).await?;
        Ok(jog)
    }
}
