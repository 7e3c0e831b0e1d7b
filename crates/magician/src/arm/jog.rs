//! Jogging that ends by itself unless it is renewed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use magician_protocol::commands::{JogCmd, JogCommonParams};
use magician_protocol::{Ctrl, FrameBuf, Layout, NoArgs};
use tokio::sync::futures::Notified;
use tokio::sync::{Notify, oneshot, watch};
use tokio::time::{Instant, timeout_at};

use super::driver::{JogStart, Message, micros};
use super::fenced_jog::FencedJog;
use super::{Arm, Shared};
use crate::build::JogDirection;
use crate::connection::{Micros, Request};
use crate::gate::{JogEnd, JogId};
use crate::{Error, ErrorCode, Result};

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
            let message = format!(
                "the jog's hold time is {:?}, it must be 20 ms to 2 s",
                self.keep
            );
            return Err(Error::invalid(message));
        }
        match self.ratio {
            Some(ratio) if !(1.0..=100.0).contains(&ratio) => Err(Error::invalid(format!(
                "the jog's speed is {ratio} %, it must be 1 to 100 %"
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

/// What a jog's guard and the connection's task both know.
#[derive(Debug)]
pub(super) struct Life {
    /// Its number at the gate; jogs in pieces do not pass it.
    pub(super) id: JogId,
    pub(super) phase: watch::Sender<Phase>,
    /// It goes on for so long after it was kept up.
    pub(super) keep: Micros,
    /// When it was kept up last, since the connection's beginning.
    kept: AtomicU64,
    released: AtomicBool,
    /// Another one takes its place.
    replaced: AtomicBool,
    /// A piece of it may have gone out.
    sent: AtomicBool,
    /// One of these has changed: for a jog in pieces.
    woken: Notify,
    /// How it is kept from crossing the arm's fence.
    pub(super) fence: Option<FencedJog>,
}

impl Life {
    pub(super) fn new(id: JogId, keep: Duration, now: Micros, fence: Option<FencedJog>) -> Self {
        Self {
            id,
            phase: watch::Sender::new(Phase::Running),
            keep: micros(keep),
            kept: AtomicU64::new(now),
            released: AtomicBool::new(false),
            replaced: AtomicBool::new(false),
            sent: AtomicBool::new(false),
            woken: Notify::new(),
            fence,
        }
    }

    /// When it ends unless it is kept up.
    pub(super) fn ends(&self) -> Micros {
        let kept = self.kept.load(Ordering::SeqCst);
        kept.saturating_add(self.keep)
    }

    pub(super) fn kept(&self, now: Micros) {
        self.kept.store(now, Ordering::SeqCst);
    }

    pub(super) fn released(&self) -> bool {
        self.released.load(Ordering::SeqCst)
    }

    pub(super) fn replaced(&self) {
        self.replaced.store(true, Ordering::SeqCst);
        self.woken.notify_one();
    }

    /// Why it is to end, if it is.
    pub(super) fn is_to_end(&self, now: Micros) -> Option<JogEnd> {
        if self.released() {
            Some(JogEnd::Released)
        } else if self.replaced.load(Ordering::SeqCst) {
            Some(JogEnd::Replaced)
        } else {
            (self.ends() <= now).then_some(JogEnd::NotKept)
        }
    }

    /// Waits until it was released or replaced.
    pub(super) fn woken(&self) -> Notified<'_> {
        self.woken.notified()
    }

    /// A piece goes out.
    pub(super) fn sends(&self) {
        self.sent.store(true, Ordering::SeqCst);
    }

    pub(super) fn has_sent(&self) -> bool {
        self.sent.load(Ordering::SeqCst)
    }

    pub(super) fn ending(&self, why: JogEnd) {
        self.phase.send_replace(Phase::Ending(why));
    }

    /// It is over, unless it was before.
    pub(super) fn over(&self, why: JogEnd, stands: Stands) {
        self.phase.send_if_modified(|phase| {
            let goes_on = !matches!(phase, Phase::Over(..));
            if goes_on {
                *phase = Phase::Over(why, stands);
            }
            goes_on
        });
    }
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
    life: Arc<Life>,
}

impl Jog {
    pub(super) fn new(arm: Arm, life: Arc<Life>) -> Self {
        Self { arm, life }
    }

    /// Lets it go on. Costs nothing: nothing is sent.
    ///
    /// # Errors
    /// It has ended or is about to: [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) when this was called too late, [`ErrorKind::Port`](crate::ErrorKind::Port) when the
    /// line broke, [`ErrorKind::Closed`](crate::ErrorKind::Closed) when a stop or another jog came,
    /// [`ErrorKind::Unreachable`](crate::ErrorKind::Unreachable) at the end of its axis and before the arm's fence.
    pub fn keep(&self) -> Result<()> {
        let now = self.arm.inner.shared.now();
        let phase = *self.life.phase.borrow();
        match phase {
            // Too late, also when the task has not come to notice it.
            Phase::Running if self.life.ends() <= now => Err(self.ended(JogEnd::NotKept)),
            Phase::Running => {
                self.life.kept(now);
                Ok(())
            }
            Phase::Ending(why) | Phase::Over(why, _) => Err(self.ended(why)),
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
        let mut phase = self.life.phase.subscribe();
        let over = phase.wait_for(|phase| matches!(phase, Phase::Over(..)));
        let over = timeout_at(deadline, over).await;
        let over = over.ok().and_then(Result::ok).map(|phase| *phase);
        match over {
            Some(Phase::Over(_, Stands::Seen) | Phase::Over(JogEnd::Replaced, _)) => Ok(()),
            Some(Phase::Over(why @ (JogEnd::LinkLost | JogEnd::Closed), _)) => Err(self.ended(why)),
            _ => {
                let message =
                    "the jog's end is not confirmed: the arm does not answer, or still moves";
                Err(Error::new(ErrorCode::StopUnconfirmed, message))
            }
        }
    }

    fn release(&self) {
        self.life.released.store(true, Ordering::SeqCst);
        self.life.woken.notify_one();
        // A task with so many messages before it is awake, and looks.
        let _ = self.arm.inner.messages.try_send(Message::Wake);
    }

    fn ended(&self, why: JogEnd) -> Error {
        let keep = Duration::from_micros(self.life.keep);
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
        let command = JogCmd::from(direction);
        options.check()?;
        if self.fences_jogs() && !self.bounds_jogs() && self.moving() {
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
        if self.bounds_jogs() {
            return self
                .jog_in_pieces(direction, options, stops, deadline)
                .await;
        }
        let turn = self.fence_jog(&command, deadline).await?;
        let (_turn, fence) = turn.unzip();
        let fence = fence.flatten();
        self.begin_jog(direction, options, fence, stops, deadline)
            .await
    }

    async fn begin_jog(
        &self,
        direction: JogDirection,
        options: JogOptions,
        fence: Option<FencedJog>,
        stops: u64,
        deadline: Instant,
    ) -> Result<Jog> {
        let frame = FrameBuf::set(&direction.into(), Ctrl::SET)?;
        let (id, now) = (self.inner.shared.next_jog(), self.inner.shared.now());
        let life = Arc::new(Life::new(id, options.keep, now, fence));
        // From here on giving up ends it: the guard is dropped.
        let jog = Jog::new(self.clone(), Arc::clone(&life));
        let (reply, answer) = oneshot::channel();
        let start = JogStart {
            request: Request::of(frame),
            direction,
            deadline,
            stops,
            life,
            reply,
        };
        let sent = self.inner.messages.send(Message::Jog(start));
        let sent = timeout_at(deadline, sent).await;
        match sent {
            Ok(Ok(())) => {}
            Ok(Err(_)) => return Err(Error::closed()),
            Err(_) => return Err(Error::stuck()),
        }
        // Its life ends with this call, so what has not begun never does.
        let silent = Error::new(ErrorCode::NoAnswer, "no answer");
        self.answer_or(silent, answer, &frame, deadline).await?;
        Ok(jog)
    }
}
