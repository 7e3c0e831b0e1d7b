//! Bounded jogs: jogs that end by themselves, for a line that nothing outside this process watches.
//!
//! The arm's own jog (JOGCmd) runs to the end of its range if this process dies. The head of
//! [`gate`](crate::gate) says why bounded jogs do not replace it.
//!
//! A bounded jog is a sequence of short pieces in the arm's queue. Along x, y and z they are path
//! segments, which the arm passes without resting; for joints, r and the rail they are relative
//! moves, with a rest at each end. The next piece is sent only if everything the arm has, with that
//! piece, is done within the hold time plus [`REST_MARGIN`]. So whatever happens to this process,
//! the arm is at rest by then. The pose, read before each piece, shows how much is left: a late
//! answer slows the jog down and never lengthens it.
//!
//! The [`Gate`](crate::gate::Gate) has the deadline, as for any jog: the jog's task asks it before
//! the first piece, and learns when to end. The task then stops the arm, waits for rest, and
//! restores the settings that the pieces needed. Until then other calls that change or read
//! settings, or start motion, wait ([`Arm::waits_for_jog`]).

mod pace;
mod pieces;
mod settings;

use std::sync::Arc;
use std::time::Duration;

use magician_protocol::Set;
use magician_protocol::commands::{Pose, PoseL};
use tokio::sync::{oneshot, watch};
use tokio::time::{Instant, sleep, timeout_at};

use super::driver::{JogStart, Message};
use super::fenced_jog::jog_of;
use super::flow;
use super::halt::REST_POLL_INTERVAL;
use super::jog::{Jog, Phase, Standstill};
use super::{Arm, Shared};
use crate::build::{Axis, JogDirection};
use crate::gate::{JogEnd, JogKind, JogRequest};
use crate::message;
use crate::preflight::{Guards, state_at};
use crate::{Error, ErrorCode, ErrorKind, Result};
use pieces::{Pieces, piece};
pub(super) use settings::BoundedJogs;
use settings::JogControl;

/// Longest time from the end of the hold time to rest. Choice, documented at
/// [`Options::bounded_jogs`](super::Options::bounded_jogs).
const REST_MARGIN: Duration = Duration::from_millis(50);
/// Part of it reserved for the arm, which looks at new commands only now and then. Choice.
const ARM_RESERVE: Duration = Duration::from_millis(10);
/// Shortest interval of position reads. Choice, against a busy loop on a fast line.
const MIN_READ_INTERVAL: Duration = Duration::from_millis(4);
/// Time without motion after which an arm with a piece is blocked. Choice.
const BLOCKED_AFTER: Duration = Duration::from_millis(400);
/// Longest time for an answer to a stop before it is repeated, and longest time of all repetitions.
/// Choices, as for the arm's own jogs.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(300);
const MAX_BRAKING_TIME: Duration = Duration::from_secs(5);
/// Tolerance of a position, mm or degrees: the resolution of a pose in binary32.
const POSITION_TOLERANCE: f64 = 0.002;

/// Bounded jog, run by its own task.
pub(super) struct BoundedJog {
    /// Handle whose commands do not wait for the end of this jog.
    arm: Arm,
    asks: JogRequest,
    stops: u64,
    deadline: Instant,
    /// Sender for the guard's phase; `None` once the gate was asked, which then has it.
    tells: Option<watch::Sender<Phase>>,
    phase: watch::Receiver<Phase>,
    /// Reply to the caller; closed if it gives up before the start.
    begun: Option<oneshot::Sender<Result<()>>>,
    /// True if a piece may have been sent.
    has_sent: bool,
}

impl BoundedJog {
    /// Starts a bounded jog; returns its guard once the arm has the first piece.
    pub(super) async fn start(
        arm: &Arm,
        direction: JogDirection,
        keep: Duration,
        stops: u64,
        deadline: Instant,
    ) -> Result<Jog> {
        // From here on a dropped call ends the jog, because it drops the guard.
        let (jog, tells) = Jog::new(arm, keep);
        let asks = jog.request(direction, JogKind::Pieces);
        let (begun, begins) = oneshot::channel();
        arm.inner.shared.asks_bounded(asks.id);
        let task = Self {
            arm: Arm {
                leads: true,
                ..arm.clone()
            },
            asks,
            stops,
            deadline,
            phase: tells.subscribe(),
            tells: Some(tells),
            begun: Some(begun),
            has_sent: false,
        };
        // A task, so that the jog ends in order even if the caller's future is dropped.
        tokio::spawn(task.lead());
        match timeout_at(deadline, begins).await {
            Ok(begins) => begins.map_err(|_| Error::closed())??,
            // The guard is dropped here, which also ends a jog that begins after all.
            Err(_) => {
                return Err(Error::new(
                    ErrorCode::NoAnswer,
                    message!("the jog did not begin"),
                ));
            }
        }
        Ok(jog)
    }

    fn shared(&self) -> &Arc<Shared> {
        &self.arm.inner.shared
    }

    fn axis(&self) -> Axis {
        self.asks.direction.axis
    }

    /// Runs the jog from start to restored settings.
    async fn lead(mut self) {
        let arm = self.arm.clone();
        let Ok(mut flow) = arm.queue().take_turn(self.deadline, "a jog").await else {
            let message = message!("a program runs, or another task is filling the queue");
            return self.refuse(Err(Error::new(ErrorCode::Busy, message)));
        };
        // The pieces are not counted, so the next call reads the space again.
        flow.room = 0;
        let leads = JogControl::new(self.shared(), self.asks.id);
        let ended = self.pieces().await;
        let why = match &ended {
            Ok(why) => *why,
            Err(error) => why_of(error),
        };
        self.shared().led_ends(self.asks.id);
        self.ends(why);
        // If nothing was sent the arm was at rest before, and still is.
        let stands = if self.has_sent {
            self.rest().await
        } else {
            Standstill::Seen
        };
        let restored = arm.restore_settings().await;
        self.is_over(stands);
        drop(flow);
        self.refuse(ended.map(drop));
        drop(self);
        leads.settle(arm, restored).await;
    }

    /// Reports to a caller that still waits why the jog did not begin.
    fn refuse(&mut self, ended: Result<()>) {
        if let Some(begun) = self.begun.take() {
            let over = || {
                Error::new(
                    ErrorCode::Stopped,
                    message!("the jog was ended before it began"),
                )
            };
            // The caller may have given up, and then needs no reason.
            let _ = begun.send(Err(ended.err().unwrap_or_else(over)));
        }
    }

    /// Ends the jog at the gate, unless it has ended.
    fn ends(&self, why: JogEnd) {
        self.shared().gate().end_one(self.asks.id, why);
        // With a full inbox the task is awake anyway, and asks the gate.
        let _ = self.arm.inner.messages.try_send(Message::Wake);
    }

    /// Reports to the gate that the arm is at rest and has its settings back.
    fn is_over(&self, stands: Standstill) {
        {
            let mut gate = self.shared().gate();
            if gate.is_ending_jog(self.asks.id) {
                gate.finish_stop(stands == Standstill::Seen);
            }
        }
        let _ = self.arm.inner.messages.try_send(Message::Wake);
    }

    /// Prepares the arm, then sends pieces until something ends the jog.
    async fn pieces(&mut self) -> Result<JogEnd> {
        let (arm, direction) = (self.arm.clone(), self.asks.direction);
        arm.restore_settings().await?;
        let sample = piece(direction, 1.0);
        arm.front_end()
            .check_ready(&[sample], Guards::default())
            .await?;
        arm.come_to_rest().await?;
        let look = arm.known().read_queue().await?;
        arm.queue().refuse_foreign(&look)?;
        if look.waiting() > 0 {
            let message = message!("commands wait in the arm's queue");
            return Err(Error::new(ErrorCode::Busy, message));
        }
        let mut course = arm.preflight_for(&[sample]).await?;
        let Some(stands) = course.arm() else {
            return Err(Error::new(ErrorCode::Busy, message!("the arm moves")));
        };
        let from = match jog_of(direction) {
            Some(jog) => jog.axis.value(stands),
            None => self.place().await?,
        };
        // The queue is empty, so starting it moves nothing.
        arm.queue().start_standing().await?;
        let keep = Duration::from_micros(self.asks.keep);
        let within = (keep + REST_MARGIN - ARM_RESERVE).as_secs_f64();
        let (pace, settings) = settings::set_pace(&arm, direction, within).await?;
        for setting in &settings {
            course.check(setting)?;
        }
        // From here on only this task checks against the fence.
        let mut turn = arm.fence_check().hold_run(true).await?;
        // The check of the run starts from `course` itself; only the exclusive right is needed.
        let _ = turn.as_mut().map(super::fence::SendPermit::start);
        self.ask_gate().await?;
        let mut pieces = Pieces::new(direction, pace, course, from);
        self.go_on(&mut pieces).await
    }

    /// Waits until the gate lets the jog begin.
    async fn ask_gate(&mut self) -> Result<()> {
        let stopped = || {
            Error::new(
                ErrorCode::Stopped,
                message!("the jog was ended before it began"),
            )
        };
        let (Some(phase), None) = (self.tells.take(), self.over()) else {
            return Err(stopped());
        };
        // The arm was just seen at rest, which settles any earlier doubt.
        self.shared().gate().note_rest();
        let (reply, answer) = oneshot::channel();
        let start = JogStart {
            asks: self.asks,
            own: None,
            deadline: self.deadline,
            stops: self.stops,
            phase,
            reply,
        };
        let sent = self
            .arm
            .inner
            .messages
            .send(Message::Jog(Box::new(start)))
            .await;
        sent.map_err(|_| Error::closed())?;
        match timeout_at(self.deadline, answer).await {
            Ok(begins) => begins.map_err(|_| Error::closed())?,
            Err(_) => Err(stopped()),
        }
    }

    async fn go_on(&mut self, pieces: &mut Pieces) -> Result<JogEnd> {
        let (mut moved, mut covered_before) = (Instant::now(), 0.0);
        // True once the last piece ends at a limit.
        let mut at_limit = false;
        loop {
            let look = async {
                if self.begun.is_some() {
                    // At rest, where the check started.
                    Ok(pieces.from)
                } else {
                    self.place().await
                }
            };
            let place = match self.unless_over(look).await {
                Ok(place) => place?,
                Err(why) => return Ok(why),
            };
            let covered = pieces.update_position(place);
            let left = pieces.sent - covered;
            if covered > covered_before + POSITION_TOLERANCE || left <= POSITION_TOLERANCE {
                (moved, covered_before) = (Instant::now(), covered);
            } else if moved.elapsed() > BLOCKED_AFTER {
                let alarms = self.arm.alarms().await?;
                return if alarms.blocking() {
                    Err(self.arm.stopped_by(alarms).await)
                } else {
                    Err(Error::new(ErrorCode::Stopped, message!("the arm stands")))
                };
            }
            // The last piece is done, up to the resolution of a pose.
            if at_limit && left <= POSITION_TOLERANCE {
                return Ok(JogEnd::Limit);
            }
            let pause = match pieces.next() {
                Ok(length) if !at_limit => match pieces.piece_within_limits(length) {
                    Ok((command, course, by)) => {
                        self.has_sent = true;
                        match self.unless_over(self.send(&command)).await {
                            Ok(sent) => sent?,
                            Err(why) => return Ok(why),
                        }
                        pieces.note(course, by);
                        if let Some(begun) = self.begun.take() {
                            let shared = self.shared();
                            // From here on the caller can renew the jog. If it has gone, its guard
                            // has been dropped as well.
                            let _ = shared.gate().keep(self.asks.id, shared.now());
                            let _ = begun.send(Ok(()));
                            moved = Instant::now();
                        }
                        continue;
                    }
                    // Not a single piece is possible: the jog fails instead of ending at once.
                    Err(error) if self.begun.is_some() => return Err(error),
                    Err(_) => {
                        at_limit = true;
                        MIN_READ_INTERVAL
                    }
                },
                Ok(_) => MIN_READ_INTERVAL,
                Err(pause) => Duration::from_secs_f64(pause).max(MIN_READ_INTERVAL),
            };
            if let Err(why) = self.unless_over(sleep(pause)).await {
                return Ok(why);
            }
        }
    }

    /// Returns the reason to end the jog, if any.
    fn over(&self) -> Option<JogEnd> {
        let given_up = (self.begun.as_ref()).is_some_and(oneshot::Sender::is_closed);
        match *self.phase.borrow() {
            Phase::Ending(why) | Phase::Over(why, _) => Some(why),
            Phase::Running if given_up => Some(JogEnd::Released),
            Phase::Running if self.shared().is_replaced(self.asks.id) => Some(JogEnd::Replaced),
            Phase::Running => (self.stops != self.arm.stops()).then_some(JogEnd::Stopped),
        }
    }

    /// Awaits a future unless the jog has to end first.
    async fn unless_over<T>(&self, what: impl Future<Output = T>) -> Result<T, JogEnd> {
        let mut phase = self.phase.clone();
        let mut others = self.shared().bounded.subscribe();
        tokio::pin!(what);
        loop {
            if let Some(why) = self.over() {
                return Err(why);
            }
            tokio::select! {
                // The end of the jog first: a piece must not be sent after it.
                biased;
                changed = phase.changed() => changed.map_err(|_| JogEnd::Closed)?,
                _ = others.changed() => {}
                done = &mut what => return Ok(done),
            }
        }
    }

    /// Queues a piece, once: without an answer the jog ends.
    async fn send(&self, command: &Set) -> Result<()> {
        let request = flow::queued(command)?;
        let (frame, deadline) = (*request.frame(), self.arm.call_deadline());
        let answer = self.arm.submit(request, deadline, self.stops).await?;
        let reply = self.arm.answer(answer, &frame, deadline).await;
        self.arm.queue().accepted(&mut 0, reply).map(drop)
    }

    /// Returns the position on the jog's axis.
    async fn place(&self) -> Result<f64> {
        match jog_of(self.asks.direction) {
            Some(jog) => Ok(jog.axis.value(&state_at(&self.arm.get::<Pose>().await?))),
            None => Ok(self.arm.get::<PoseL>().await?.pose_l.into()),
        }
    }

    /// Waits for equal poses, and for a rail at rest.
    async fn stands(&self, until: Instant) -> Result<()> {
        self.arm.wait_still().await?;
        let mut before = self.place().await?;
        while self.axis() == Axis::L && Instant::now() < until {
            sleep(2 * REST_POLL_INTERVAL).await;
            let place = self.place().await?;
            if place == before {
                break;
            }
            before = place;
        }
        Ok(())
    }

    /// Stops the pieces in progress and waits for rest. The arm would also come to rest by itself.
    async fn rest(&self) -> Standstill {
        let until = Instant::now() + MAX_BRAKING_TIME;
        loop {
            // The stop count is that of the start, so a stop by another caller is not taken for a
            // newer one.
            let deadline = Instant::now() + ANSWER_TIMEOUT;
            let stopped = match self.arm.halted(deadline, self.stops).await {
                Ok(()) => self.stands(until).await,
                Err(error) => Err(error),
            };
            match stopped {
                Ok(()) => return Standstill::Seen,
                Err(error) if error.kind() == ErrorKind::Port => return Standstill::Unknown,
                Err(_) if Instant::now() >= until => return Standstill::Unknown,
                // Lost frames are repeated until the deadline; a short pause avoids a busy loop.
                Err(_) => sleep(MIN_READ_INTERVAL).await,
            }
        }
    }
}

/// Maps an error to the end of a jog.
fn why_of(error: &Error) -> JogEnd {
    match (error.code(), error.kind()) {
        (ErrorCode::Fenced | ErrorCode::FenceLimit | ErrorCode::OutOfReach, _) => JogEnd::Limit,
        (ErrorCode::LineLost, _) | (_, ErrorKind::Port) => JogEnd::LinkLost,
        (_, ErrorKind::Timeout | ErrorKind::Uncertain | ErrorKind::Unexpected) => JogEnd::Doubt,
        (_, ErrorKind::Closed | ErrorKind::Alarm) => JogEnd::Stopped,
        // Invalid input, a busy arm: the jog did not work at all.
        _ => JogEnd::Failed,
    }
}
