//! Jogs that end by themselves, for a line that nothing outside of this program watches: a jog of the arm's own (JOGCmd) goes on to the
//! end of its range when this program dies.
//!
//! Such a jog is pieces in the arm's queue: along x, y and z segments of a path, which the arm runs through, else moves by so many
//! degrees or mm, at whose ends it rests. The next piece goes out when what the arm may still have to do, and that piece, are done
//! within the time that the jog may go on without being kept, and [`AFTER`]. So whatever becomes of this program the arm stands by then.
//! How far it is tells its pose, which is read before each piece: an answer that is late makes the jog slower, never longer.

mod pace;
mod pieces;

use std::sync::Arc;
use std::time::Duration;

use magician_protocol::Set;
use magician_protocol::commands::{JogCmd, Pose, PoseL};
use tokio::sync::oneshot;
use tokio::time::{Instant, sleep, sleep_until, timeout_at};

use super::fenced_jog::jog_of;
use super::flow;
use super::halt::APART;
use super::jog::{Life, Phase, Stands};
use super::shared::held;
use super::{Arm, Jog, JogOptions};
use crate::build::{Axis, JogDirection};
use crate::gate::JogEnd;
use crate::preflight::{Guards, state_at};
use crate::{Error, ErrorCode, ErrorKind, Result};
use pieces::{Pieces, piece};

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

/// The task of a jog: whatever ends it tells its guard.
struct Ends(Arc<Life>);

impl Drop for Ends {
    fn drop(&mut self) {
        self.0.over(JogEnd::Closed, Stands::Unknown);
    }
}

impl Arm {
    /// Whether jogs of this arm are pieces that end by themselves: [`Options::bounded_jogs`](super::Options::bounded_jogs).
    #[must_use]
    pub fn bounds_jogs(&self) -> bool {
        self.inner.options.bounded_jogs
    }

    /// Waits until the last of the jogs that end by themselves is over: the arm stands, and has its settings again.
    pub async fn jog_over(&self) {
        let last = held(&self.inner.shared.bounded_jog).clone();
        if let Some(life) = last {
            let mut phase = life.phase.subscribe();
            let _ = phase
                .wait_for(|phase| matches!(phase, Phase::Over(..)))
                .await;
        }
    }

    /// Gives the arm back what a jog has changed of its settings and could not give back, because the line broke.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub async fn restore_after_jog(&self) -> Result<()> {
        let mut owed = std::mem::take(&mut *held(&self.inner.shared.owed));
        let mut again = owed.clone();
        let restored = owed.restore(self).await;
        if restored.is_err() {
            let mut owed = held(&self.inner.shared.owed);
            again.append(std::mem::take(&mut *owed));
            *owed = again;
        }
        restored
    }

    /// A jog in pieces.
    pub(super) async fn jog_in_pieces(
        &self,
        direction: JogDirection,
        options: JogOptions,
        stops: u64,
        deadline: Instant,
    ) -> Result<Jog> {
        let (id, now) = (self.inner.shared.next_jog(), self.inner.shared.now());
        let life = Arc::new(Life::new(id, options.keep, now, None));
        let before = held(&self.inner.shared.bounded_jog).replace(Arc::clone(&life));
        // From here on giving up ends it: the guard is dropped.
        let jog = Jog::new(self.clone(), Arc::clone(&life));
        let (begun, begins) = oneshot::channel();
        let (arm, ends) = (self.clone(), Ends(life));
        tokio::spawn(async move {
            if let Some(before) = before {
                before.replaced();
                let mut phase = before.phase.subscribe();
                let over = phase.wait_for(|phase| matches!(phase, Phase::Over(..)));
                let _ = timeout_at(deadline, over).await;
            }
            let asked = (direction, stops, deadline);
            arm.lead(&ends.0, asked, begun).await;
        });
        match timeout_at(deadline, begins).await {
            Ok(begins) => begins.map_err(|_| Error::closed())??,
            Err(_) => return Err(Error::new(ErrorCode::NoAnswer, "the jog did not begin")),
        }
        Ok(jog)
    }

    /// The whole of a jog, whatever becomes of it.
    async fn lead(
        &self,
        life: &Life,
        (direction, stops, deadline): (JogDirection, u64, Instant),
        begun: oneshot::Sender<Result<()>>,
    ) {
        let Ok(mut flow) = self.queue().take_turn(deadline, "a jog").await else {
            let message = "a program runs, or another task is filling the queue";
            let _ = begun.send(Err(Error::new(ErrorCode::Busy, message)));
            return life.over(JogEnd::Failed, Stands::Unknown);
        };
        // What it leaves there is counted anew.
        flow.room = 0;
        let mut begun = Some(begun);
        let ended = self.pieces(life, direction, stops, &mut begun).await;
        let why = match &ended {
            Ok(why) => *why,
            Err(error) => why_of(error),
        };
        life.ending(why);
        let stands = if life.has_sent() {
            self.rest_after_jog(direction.axis, stops).await
        } else {
            Stands::Unknown
        };
        let _ = self.restore_after_jog().await;
        drop(flow);
        if let Some(begun) = begun {
            let over = || Error::new(ErrorCode::Stopped, "the jog was ended before it began");
            let _ = begun.send(Err(ended.err().unwrap_or_else(over)));
        }
        life.over(why, stands);
    }

    /// Gets ready, and sends piece after piece until something ends that.
    async fn pieces(
        &self,
        life: &Life,
        direction: JogDirection,
        stops: u64,
        begun: &mut Option<oneshot::Sender<Result<()>>>,
    ) -> Result<JogEnd> {
        self.restore_after_jog().await?;
        let sample = piece(direction, 1.0);
        self.front_end()
            .check_ready(&[sample], Guards::default())
            .await?;
        self.come_to_rest().await?;
        let look = self.known().read_queue().await?;
        self.refuse_foreign_commands(&look)?;
        if look.waiting() > 0 {
            let message = "commands wait in the arm's queue";
            return Err(Error::new(ErrorCode::Busy, message));
        }
        let mut course = self.preflight_for(&[sample]).await?;
        let Some(stands) = course.arm() else {
            return Err(Error::new(ErrorCode::Busy, "the arm moves"));
        };
        let from = match jog_of(&JogCmd::from(direction)) {
            Some(jog) => jog.axis.value(stands),
            None => self.place_on(direction.axis).await?,
        };
        // It is empty.
        self.queue().start_standing().await?;
        let within = (Duration::from_micros(life.keep) + AFTER - SPARE).as_secs_f64();
        let (pace, settings) = self.pace(direction, within).await?;
        for setting in &settings {
            course.check(setting)?;
        }
        // From here on what is sent is checked against the fence by this task alone.
        let mut turn = self.fence_check().hold_run(true).await?;
        let _ = turn.as_mut().map(super::fence::Turn::start);
        let mut pieces = Pieces::new(direction, pace, course, from);
        life.kept(self.inner.shared.now());
        self.go_on(life, &mut pieces, stops, begun).await
    }

    async fn go_on(
        &self,
        life: &Life,
        pieces: &mut Pieces,
        stops: u64,
        begun: &mut Option<oneshot::Sender<Result<()>>>,
    ) -> Result<JogEnd> {
        let axis = pieces.direction.axis;
        let (mut moved, mut gone_before) = (Instant::now(), 0.0);
        // The last piece leads to a limit.
        let mut at_limit = false;
        loop {
            let look = async {
                if begun.is_some() {
                    // It stands where the check has it.
                    Ok(pieces.from)
                } else {
                    self.place_on(axis).await
                }
            };
            let place = match self.unless_over(life, stops, look).await {
                Ok(place) => place?,
                Err(why) => return Ok(why),
            };
            let gone = pieces.saw(place);
            let left = pieces.sent - gone;
            if gone > gone_before + READ || left <= READ {
                (moved, gone_before) = (Instant::now(), gone);
            } else if moved.elapsed() > STUCK {
                let alarms = self.alarms().await?;
                return if alarms.blocking() {
                    Err(self.stopped_by(alarms).await)
                } else {
                    Err(Error::new(ErrorCode::Stopped, "the arm stands"))
                };
            }
            if at_limit && left <= READ {
                return Ok(JogEnd::Limit);
            }
            let pause = match pieces.next() {
                Ok(length) if !at_limit => match pieces.cut(length) {
                    Ok((command, course, by)) => {
                        let sends = self.send_piece(life, &command, stops);
                        match self.unless_over(life, stops, sends).await {
                            Ok(sent) => sent?,
                            Err(why) => return Ok(why),
                        }
                        pieces.note(course, by);
                        if let Some(begun) = begun.take() {
                            // Without a caller its guard is gone as well.
                            let _ = begun.send(Ok(()));
                            moved = Instant::now();
                        }
                        continue;
                    }
                    Err(error) if begun.is_some() => return Err(error),
                    Err(_) => {
                        at_limit = true;
                        PAUSE
                    }
                },
                Ok(_) => PAUSE,
                Err(pause) => Duration::from_secs_f64(pause).max(PAUSE),
            };
            if let Err(why) = self.unless_over(life, stops, sleep(pause)).await {
                return Ok(why);
            }
        }
    }

    /// What comes of something, unless the jog is to end before.
    async fn unless_over<T>(
        &self,
        life: &Life,
        stops: u64,
        what: impl Future<Output = T>,
    ) -> std::result::Result<T, JogEnd> {
        let shared = &self.inner.shared;
        tokio::pin!(what);
        loop {
            let woken = life.woken();
            tokio::pin!(woken);
            woken.as_mut().enable();
            if stops != self.stops() {
                return Err(JogEnd::Stopped);
            }
            if let Some(why) = life.is_to_end(shared.now()) {
                return Err(why);
            }
            let ends = shared.begun + Duration::from_micros(life.ends());
            tokio::select! {
                biased;
                () = &mut woken => {}
                () = sleep_until(ends) => {}
                done = &mut what => return Ok(done),
            }
        }
    }

    /// Queues a piece. It goes out once: without its answer the jog ends.
    async fn send_piece(&self, life: &Life, command: &Set, stops: u64) -> Result<()> {
        let request = flow::queued(command)?;
        let (frame, deadline) = (*request.frame(), self.call_deadline());
        life.sends();
        let answer = self.submit(request, deadline, stops).await?;
        let reply = self.answer(answer, &frame, deadline).await;
        self.queue().accepted(&mut 0, reply).map(drop)
    }

    /// Waits for two equal poses, and for a rail that stands.
    async fn stands_on(&self, axis: Axis, until: Instant) -> Result<()> {
        self.wait_still().await?;
        let mut before = self.place_on(axis).await?;
        while axis == Axis::L && Instant::now() < until {
            sleep(2 * APART).await;
            let place = self.place_on(axis).await?;
            if place == before {
                break;
            }
            before = place;
        }
        Ok(())
    }

    /// Where the arm is on an axis.
    async fn place_on(&self, axis: Axis) -> Result<f64> {
        match jog_of(&JogCmd::from(axis.plus())) {
            Some(jog) => Ok(jog.axis.value(&state_at(&self.get::<Pose>().await?))),
            None => Ok(self.get::<PoseL>().await?.pose_l.into()),
        }
    }

    /// Stops what of the pieces is under way, and makes sure that the arm stands; it does so by itself as well.
    async fn rest_after_jog(&self, axis: Axis, stops: u64) -> Stands {
        let until = Instant::now() + BRAKING;
        loop {
            // One that others have asked for is the same.
            let deadline = Instant::now() + PATIENCE;
            let stopped = match self.halted(deadline, stops).await {
                Ok(()) => self.stands_on(axis, until).await,
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
