//! Jogs that end by themselves, for a line that nothing outside of this program watches: a jog of the arm's own (JOGCmd) goes on
//! to the end of its range when this program dies. Why it is not the only jog stands at the head of [`gate`](crate::gate).
//!
//! Such a jog is pieces in the arm's queue: along x, y and z segments of a path, which the arm runs through, else moves by so many
//! degrees or mm, at whose ends it rests. The next piece goes out when what the arm may still have to do, and that piece, are done
//! within the time that the jog may go on without being kept, and [`AFTER`]. So whatever becomes of this program the arm stands by then.
//! How far it is tells its pose, which is read before each piece: an answer that is late makes the jog slower, never longer.
//!
//! The [`Gate`](crate::gate::Gate) has its deadline, as that of any jog: its task asks the gate before the first piece, and is
//! told when it is to end. The task then stops the arm, sees it at rest, and gives back the settings that the pieces needed.
//! What others set, start, or read of settings meanwhile waits for that ([`Arm::waits_for_jog`]).

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
use super::halt::APART;
use super::jog::{Jog, Phase, Stands};
use super::{Arm, Shared};
use crate::build::{Axis, JogDirection};
use crate::gate::{JogEnd, JogKind, JogRequest};
use crate::message;
use crate::preflight::{Guards, state_at};
use crate::{Error, ErrorCode, ErrorKind, Result};
use pieces::{Pieces, piece};
pub(super) use settings::BoundedJogs;
use settings::Leads;

/// The arm stands so long after the time for which a jog has to be kept, at the latest.
const AFTER: Duration = Duration::from_millis(50);
/// What of that is kept for the arm itself, which looks at what came now and then.
const SPARE: Duration = Duration::from_millis(10);
/// Looks are so far apart at least.
const PAUSE: Duration = Duration::from_millis(4);
/// An arm that has a piece and goes nowhere for so long does not do it.
const STUCK: Duration = Duration::from_millis(400);
/// How long an answer to a stop may take before it is said again, and how long all of it may take.
const PATIENCE: Duration = Duration::from_millis(300);
const BRAKING: Duration = Duration::from_secs(5);
/// What the pose is read to, mm or degrees.
const READ: f64 = 0.002;

/// A jog in pieces, led by a task of its own.
pub(super) struct BoundedJog {
    /// A handle whose commands do not wait for the end of this jog.
    arm: Arm,
    asks: JogRequest,
    stops: u64,
    deadline: Instant,
    /// What tells its guard; with the driver once the gate was asked.
    tells: Option<watch::Sender<Phase>>,
    phase: watch::Receiver<Phase>,
    /// Closed by a caller that gives up before it has begun.
    begun: Option<oneshot::Sender<Result<()>>>,
    /// A piece of it may have gone out.
    has_sent: bool,
}

impl BoundedJog {
    /// Begins one: its guard, once the arm has its first piece.
    pub(super) async fn start(
        arm: &Arm,
        direction: JogDirection,
        keep: Duration,
        stops: u64,
        deadline: Instant,
    ) -> Result<Jog> {
        // From here on giving up ends it: the guard is dropped.
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
        tokio::spawn(task.lead());
        match timeout_at(deadline, begins).await {
            Ok(begins) => begins.map_err(|_| Error::closed())??,
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

    /// The whole of a jog, whatever becomes of it.
    async fn lead(mut self) {
        let arm = self.arm.clone();
        let Ok(mut flow) = arm.queue().take_turn(self.deadline, "a jog").await else {
            let message = message!("a program runs, or another task is filling the queue");
            return self.refuse(Err(Error::new(ErrorCode::Busy, message)));
        };
        // What it leaves there is counted anew.
        flow.room = 0;
        let leads = Leads::new(self.shared(), self.asks.id);
        let ended = self.pieces().await;
        let why = match &ended {
            Ok(why) => *why,
            Err(error) => why_of(error),
        };
        self.shared().led_ends(self.asks.id);
        self.ends(why);
        let stands = if self.has_sent {
            self.rest().await
        } else {
            Stands::Seen
        };
        let restored = arm.restore_settings().await;
        self.is_over(stands);
        drop(flow);
        self.refuse(ended.map(drop));
        drop(self);
        leads.settle(arm, restored).await;
    }

    /// Tells a caller that still waits for the beginning why there is none.
    fn refuse(&mut self, ended: Result<()>) {
        if let Some(begun) = self.begun.take() {
            let over = || {
                Error::new(
                    ErrorCode::Stopped,
                    message!("the jog was ended before it began"),
                )
            };
            let _ = begun.send(Err(ended.err().unwrap_or_else(over)));
        }
    }

    /// The gate ends it, unless it has.
    fn ends(&self, why: JogEnd) {
        self.shared().gate().end_one(self.asks.id, why);
        let _ = self.arm.inner.messages.try_send(Message::Wake);
    }

    /// The arm has come to rest, and has its settings.
    fn is_over(&self, stands: Stands) {
        {
            let mut gate = self.shared().gate();
            if gate.is_ending_jog(self.asks.id) {
                gate.rested(stands == Stands::Seen);
            }
        }
        let _ = self.arm.inner.messages.try_send(Message::Wake);
    }

    /// Gets ready, and sends piece after piece until something ends that.
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
        // It is empty.
        arm.queue().start_standing().await?;
        let keep = Duration::from_micros(self.asks.keep);
        let within = (keep + AFTER - SPARE).as_secs_f64();
        let (pace, settings) = settings::set_pace(&arm, direction, within).await?;
        for setting in &settings {
            course.check(setting)?;
        }
        // From here on what is sent is checked against the fence by this task alone.
        let mut turn = arm.fence_check().hold_run(true).await?;
        let _ = turn.as_mut().map(super::fence::Turn::start);
        self.ask_gate().await?;
        let mut pieces = Pieces::new(direction, pace, course, from);
        self.go_on(&mut pieces).await
    }

    /// Waits for the gate to let it begin.
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
        // The arm was seen at rest: what was lost before is over.
        self.shared().gate().stands_still();
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
        let (mut moved, mut gone_before) = (Instant::now(), 0.0);
        // The last piece leads to a limit.
        let mut at_limit = false;
        loop {
            let look = async {
                if self.begun.is_some() {
                    // It stands where the check has it.
                    Ok(pieces.from)
                } else {
                    self.place().await
                }
            };
            let place = match self.unless_over(look).await {
                Ok(place) => place?,
                Err(why) => return Ok(why),
            };
            let gone = pieces.saw(place);
            let left = pieces.sent - gone;
            if gone > gone_before + READ || left <= READ {
                (moved, gone_before) = (Instant::now(), gone);
            } else if moved.elapsed() > STUCK {
                let alarms = self.arm.alarms().await?;
                return if alarms.blocking() {
                    Err(self.arm.stopped_by(alarms).await)
                } else {
                    Err(Error::new(ErrorCode::Stopped, message!("the arm stands")))
                };
            }
            if at_limit && left <= READ {
                return Ok(JogEnd::Limit);
            }
            let pause = match pieces.next() {
                Ok(length) if !at_limit => match pieces.cut(length) {
                    Ok((command, course, by)) => {
                        self.has_sent = true;
                        match self.unless_over(self.send(&command)).await {
                            Ok(sent) => sent?,
                            Err(why) => return Ok(why),
                        }
                        pieces.note(course, by);
                        if let Some(begun) = self.begun.take() {
                            let shared = self.shared();
                            // From here on its holder can keep it up. Without a caller its guard is gone as well.
                            let _ = shared.gate().keep(self.asks.id, shared.now());
                            let _ = begun.send(Ok(()));
                            moved = Instant::now();
                        }
                        continue;
                    }
                    Err(error) if self.begun.is_some() => return Err(error),
                    Err(_) => {
                        at_limit = true;
                        PAUSE
                    }
                },
                Ok(_) => PAUSE,
                Err(pause) => Duration::from_secs_f64(pause).max(PAUSE),
            };
            if let Err(why) = self.unless_over(sleep(pause)).await {
                return Ok(why);
            }
        }
    }

    /// Why it is to end, if it is.
    fn over(&self) -> Option<JogEnd> {
        let given_up = (self.begun.as_ref()).is_some_and(oneshot::Sender::is_closed);
        match *self.phase.borrow() {
            Phase::Ending(why) | Phase::Over(why, _) => Some(why),
            Phase::Running if given_up => Some(JogEnd::Released),
            Phase::Running if self.shared().is_replaced(self.asks.id) => Some(JogEnd::Replaced),
            Phase::Running => (self.stops != self.arm.stops()).then_some(JogEnd::Stopped),
        }
    }

    /// What comes of something, unless the jog is to end before.
    async fn unless_over<T>(&self, what: impl Future<Output = T>) -> Result<T, JogEnd> {
        let mut phase = self.phase.clone();
        let mut others = self.shared().bounded.subscribe();
        tokio::pin!(what);
        loop {
            if let Some(why) = self.over() {
                return Err(why);
            }
            tokio::select! {
                biased;
                changed = phase.changed() => changed.map_err(|_| JogEnd::Closed)?,
                _ = others.changed() => {}
                done = &mut what => return Ok(done),
            }
        }
    }

    /// Queues a piece. It goes out once: without its answer the jog ends.
    async fn send(&self, command: &Set) -> Result<()> {
        let request = flow::queued(command)?;
        let (frame, deadline) = (*request.frame(), self.arm.call_deadline());
        let answer = self.arm.submit(request, deadline, self.stops).await?;
        let reply = self.arm.answer(answer, &frame, deadline).await;
        self.arm.queue().accepted(&mut 0, reply).map(drop)
    }

    /// Where the arm is on the axis.
    async fn place(&self) -> Result<f64> {
        match jog_of(self.asks.direction) {
            Some(jog) => Ok(jog.axis.value(&state_at(&self.arm.get::<Pose>().await?))),
            None => Ok(self.arm.get::<PoseL>().await?.pose_l.into()),
        }
    }

    /// Waits for equal poses, and for a rail that stands.
    async fn stands(&self, until: Instant) -> Result<()> {
        self.arm.wait_still().await?;
        let mut before = self.place().await?;
        while self.axis() == Axis::L && Instant::now() < until {
            sleep(2 * APART).await;
            let place = self.place().await?;
            if place == before {
                break;
            }
            before = place;
        }
        Ok(())
    }

    /// Stops what of the pieces is under way, and makes sure that the arm stands; it does so by itself as well.
    async fn rest(&self) -> Stands {
        let until = Instant::now() + BRAKING;
        loop {
            // One that others have asked for is the same.
            let deadline = Instant::now() + PATIENCE;
            let stopped = match self.arm.halted(deadline, self.stops).await {
                Ok(()) => self.stands(until).await,
                Err(error) => Err(error),
            };
            match stopped {
                Ok(()) => return Stands::Seen,
                Err(error) if error.kind() == ErrorKind::Port => return Stands::Unknown,
                Err(_) if Instant::now() >= until => return Stands::Unknown,
                Err(_) => sleep(PAUSE).await,
            }
        }
    }
}

/// As what an error ends a jog.
fn why_of(error: &Error) -> JogEnd {
    match (error.code(), error.kind()) {
        (ErrorCode::Fenced | ErrorCode::FenceLimit | ErrorCode::OutOfReach, _) => JogEnd::Limit,
        (ErrorCode::LineLost, _) | (_, ErrorKind::Port) => JogEnd::LinkLost,
        (_, ErrorKind::Timeout | ErrorKind::Uncertain | ErrorKind::Unexpected) => JogEnd::Doubt,
        (_, ErrorKind::Closed | ErrorKind::Alarm) => JogEnd::Stopped,
        _ => JogEnd::Failed,
    }
}
