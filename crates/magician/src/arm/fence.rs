//! The fence of an arm, below all doors: whatever is sent over a connection that has one is checked first, from where the arm
//! will be by then.
//!
//! One check at a time, and nothing that moves the arm is sent between a check and what it has passed. What the arm will do is
//! followed from command to command while its queue holds what this connection has put there; whenever that has ended, or may
//! have gone another way (a stop, an alarm, a motion outside of the queue, an answer that was lost), the arm is read again
//! while it stands.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{PoisonError, RwLock};

use magician_host::picture::{is_near, place};
use magician_motion::Fence;
use magician_protocol::commands::{
    ClearAlarmsState, ClearAllAlarmsState, Pose, QueuedCmdClear, QueuedCmdForceStopExec,
    QueuedCmdStartDownload, QueuedCmdStartExec,
};
use magician_protocol::{Effect, Frame, FrameBuf, JogCommand, QueuedCmdIndex, Row, Set, Writable};
use tokio::sync::{Mutex, MutexGuard};
use tokio::time::{Instant, sleep, timeout_at};

use super::Arm;
use super::halt::APART;
use crate::preflight::{Guards, Needs, Preflight, Readings, governs_motion};
use crate::{Action, Error, ErrorCode, Result};

/// The fence of a connection, if it has one, and what it has let pass.
#[derive(Debug)]
pub(super) struct Held {
    fence: RwLock<Option<Fence>>,
    prediction: Mutex<QueuePrediction>,
    /// How often what was followed came to an end that it was not to.
    breaks: AtomicU64,
}

/// Where the arm will be when what it has was carried out.
#[derive(Debug, Default)]
pub(super) struct QueuePrediction {
    end: Option<Preflight>,
    /// [`Held::breaks`] of then.
    breaks: u64,
    /// The last index that was seen.
    last: u64,
    /// Where each command leads that waits, if that is known, and where the first begins.
    stations: VecDeque<(u64, Option<[f64; 4]>)>,
}

/// The right to send what was checked. Nothing else is checked meanwhile.
pub(super) struct Turn<'a> {
    held: &'a Held,
    prediction: MutexGuard<'a, QueuePrediction>,
    /// What is known after it, if it goes into the queue.
    then: Option<Preflight>,
    /// The queue is empty: its next index may be any.
    first: bool,
    breaks: u64,
}

impl QueuePrediction {
    /// How many commands wait, or run, that were followed.
    fn waiting(&self, current: u64) -> u64 {
        let stations = self.stations.iter();
        stations.filter(|(index, _)| *index > current).count() as u64
    }
}

/// What a frame is to a fence.
enum Sort {
    /// It moves nothing, and changes nothing that a motion depends on.
    Free,
    /// It ends motions, or what waits.
    Ends,
    /// It lets a queue run.
    Releases,
    /// A motion, or what one depends on.
    Governs(Box<Set>),
    /// Unknown.
    Unknown(&'static str),
}

impl Sort {
    fn of(frame: &Frame<'_>) -> Self {
        let ctrl = frame.ctrl();
        if !ctrl.write() && !ctrl.queued() {
            return Self::Free;
        }
        let Some(row) = Row::with_id(frame.id()) else {
            return Self::Unknown("the effect of this command is unknown");
        };
        match row.id {
            id if id == QueuedCmdForceStopExec::ROW.id || id == QueuedCmdClear::ROW.id => {
                return Self::Ends;
            }
            id if id == QueuedCmdStartExec::ROW.id
                || id == ClearAlarmsState::ROW.id
                || id == ClearAllAlarmsState::ROW.id =>
            {
                return Self::Releases;
            }
            id if id == QueuedCmdStartDownload::ROW.id => {
                return Self::Unknown("programs stored in the arm cannot be checked");
            }
            _ => {}
        }
        match Set::decode(row.id, frame.params()) {
            Ok(Set::JogCmd(jog)) if jog.cmd == JogCommand::Stop && !ctrl.queued() => Self::Ends,
            Ok(command) if row.effect.moves_arm() || governs_motion(&command) => {
                Self::Governs(Box::new(command))
            }
            Ok(_) => Self::Free,
            Err(_) if matches!(row.effect, Effect::Look | Effect::Consume | Effect::Queue) => {
                Self::Free
            }
            Err(_) => Self::Unknown("its parameters cannot be read"),
        }
    }
}

impl Held {
    pub(super) fn new(fence: Option<Fence>) -> Self {
        Self {
            fence: RwLock::new(fence.filter(|fence| !fence.is_empty())),
            prediction: Mutex::default(),
            breaks: AtomicU64::new(0),
        }
    }

    pub(super) fn fence(&self) -> Option<Fence> {
        *self.fence.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Another fence takes its place: the one that was there before.
    fn replace(&self, fence: Option<Fence>) -> Option<Fence> {
        let fence = fence.filter(|fence| !fence.is_empty());
        let mut held = self.fence.write().unwrap_or_else(PoisonError::into_inner);
        std::mem::replace(&mut held, fence)
    }

    /// What was followed ends here: the arm has to be read again.
    pub(super) fn forget(&self) {
        self.breaks.fetch_add(1, Ordering::SeqCst);
    }

    fn bounds_motion(&self) -> bool {
        self.fence().is_some_and(|fence| fence.bounds_motion())
    }
}

impl Turn<'_> {
    /// What was sent has been answered, or not.
    pub(super) fn ends(mut self, answer: &Result<FrameBuf>) {
        let Some(then) = self.then.take() else {
            return;
        };
        let index = answer.as_ref().ok().map(|answer| answer.frame());
        let index = index.filter(|answer| answer.ctrl().queued());
        let index = index.and_then(|answer| answer.read::<QueuedCmdIndex>().ok());
        match index {
            Some(QueuedCmdIndex(index)) => self.accepted(index, then),
            None => self.held.forget(),
        }
    }

    fn accepted(&mut self, index: u64, then: Preflight) {
        let next = self.prediction.last.saturating_add(1);
        if !(index == next || self.first && index > next) {
            // Another program has queued a command in between.
            return self.held.forget();
        }
        let end = then.arm().map(|end| end.pose.to_array());
        self.prediction.stations.push_back((index, end));
        // More than a queue holds.
        if self.prediction.stations.len() > 64 {
            self.prediction.stations.pop_front();
        }
        self.prediction.end = Some(then);
        self.prediction.last = index;
        self.prediction.breaks = self.breaks;
    }

    /// Where a run begins.
    pub(super) fn start(&mut self) -> Option<Preflight> {
        // A run that was dropped leaves an unknown position.
        self.prediction.end = None;
        self.then.take()
    }
}

impl Arm {
    /// The fence that everything over this connection keeps to: [`Options::fence`](super::Options::fence), or what
    /// [`set_fence`](Self::set_fence) has put in its place.
    #[must_use]
    pub fn fence(&self) -> Option<Fence> {
        self.inner.held.fence()
    }

    /// Gives the connection another fence, for all its handles; `None` removes it. It holds as soon as this returns. What was
    /// under way then was checked against the earlier one: the future stops the arm, unless the fence bounds nothing new.
    ///
    /// ```
    /// use magician::{Arm, Fence, build};
    ///
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let arm = Arm::connect("sim").await?;
    /// arm.set_fence(Some(Fence::default().with_floor(-20.0)?)).await?;
    /// assert!(arm.run(&[build::line_to(220.0, 0.0, -30.0, 0.0)]).await.is_err());
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`stop`](Self::stop). The fence holds all the same.
    pub fn set_fence(
        &self,
        fence: Option<Fence>,
    ) -> impl Future<Output = Result<()>> + Send + use<> {
        let held = &self.inner.held;
        let before = held.replace(fence);
        let now = held.fence();
        held.forget();
        let arm = self.clone();
        async move {
            if now.is_none() || now == before {
                return Ok(());
            }
            arm.stop().await?;
            // What was checked before and handed over behind the stop.
            if arm.moving() {
                arm.stop().await?;
            }
            Ok(())
        }
    }

    /// The numbers by which its motions are planned: [`Options::model`](super::Options::model), or a virtual arm's own.
    #[must_use]
    pub fn model(&self) -> &magician_motion::ArmModel {
        &self.inner.options.model
    }

    /// What a frame does to the fence: refused, or with the right to send it now.
    pub(super) async fn hold_fence<'a>(
        &self,
        held: &'a Held,
        frame: &Frame<'_>,
        deadline: Instant,
    ) -> Result<Option<Turn<'a>>> {
        let turn = match Sort::of(frame) {
            Sort::Free => self.check_power(held, frame).map(|()| None),
            Sort::Ends => {
                held.forget();
                Ok(None)
            }
            Sort::Unknown(_) | Sort::Releases if !held.bounds_motion() => Ok(None),
            Sort::Unknown(why) => Err(refused(why)),
            Sort::Releases => self.hold_release(held, frame, deadline).await.map(Some),
            Sort::Governs(command) => {
                self.check_power(held, frame)?;
                if held.bounds_motion() {
                    let queued = frame.ctrl().queued();
                    let turn = self.hold_command(held, &command, queued, deadline).await;
                    turn.map(Some)
                } else {
                    Ok(None)
                }
            }
        };
        turn.map_err(|error| match error.command() {
            Some(_) => error,
            None => error.with_command(super::driver::command_name(frame)),
        })
    }

    /// How strong the laser would burn: that depends on nothing else.
    fn check_power(&self, held: &Held, frame: &Frame<'_>) -> Result<()> {
        let ctrl = frame.ctrl();
        let burns = held.fence().and_then(|fence| fence.strongest_laser());
        if burns.is_none() || !(ctrl.write() || ctrl.queued()) {
            return Ok(());
        }
        let may = Row::with_id(frame.id()).is_some_and(|row| row.may_burn);
        match Set::decode(frame.id(), frame.params()) {
            Ok(command) => self
                .fenced(Preflight::new(&Readings::default()))
                .check_power(&command),
            Err(_) if may => Err(refused("its parameters cannot be read")),
            Err(_) => Ok(()),
        }
    }

    /// The same check, with the fence of this connection.
    pub(super) fn fenced(&self, check: Preflight) -> Preflight {
        let check = check.laser_pins(self.inner.options.laser_pins);
        match self.fence() {
            Some(fence) => check.fence(fence),
            None => check,
        }
    }

    /// How often what was followed may have gone another way: by what was sent, by stops, resets, commands of others, lost
    /// answers and lines that were found again.
    fn breaks(&self, held: &Held) -> u64 {
        let shared = &self.inner.shared;
        let doubts = shared.doubts.load(Ordering::SeqCst);
        let sent = held.breaks.load(Ordering::SeqCst);
        // Each of them only grows.
        [shared.stops(), shared.clears(), doubts]
            .into_iter()
            .fold(sent, u64::wrapping_add)
    }

    async fn take_fence<'a>(&self, held: &'a Held, deadline: Instant) -> Result<Turn<'a>> {
        let prediction = timeout_at(deadline, held.prediction.lock()).await;
        let prediction = prediction.map_err(|_| {
            let message =
                "a run is under way, or another call is being checked against the arm's fence";
            Error::new(ErrorCode::NotSent, message)
        })?;
        Ok(Turn {
            held,
            prediction,
            then: None,
            first: false,
            breaks: self.breaks(held),
        })
    }

    /// A motion, or what one depends on.
    async fn hold_command<'a>(
        &self,
        held: &'a Held,
        command: &Set,
        queued: bool,
        deadline: Instant,
    ) -> Result<Turn<'a>> {
        let mut turn = self.take_fence(held, deadline).await?;
        let mut check = if queued {
            self.course_end(&mut turn).await?
        } else {
            self.read_standing(&mut turn).await?
        };
        check.check(command)?;
        if queued {
            turn.then = Some(check);
        } else {
            // It is not seen to end.
            held.forget();
        }
        Ok(turn)
    }

    /// Where the arm is when all that waits was done.
    async fn course_end(&self, turn: &mut Turn<'_>) -> Result<Preflight> {
        if turn.prediction.breaks == turn.breaks
            && let Some(end) = turn.prediction.end.clone()
            && self.waits_in_order(turn).await?
        {
            return Ok(end);
        }
        self.read_standing(turn).await
    }

    /// Whether what was followed still waits, or runs, and nothing else does.
    async fn waits_in_order(&self, turn: &mut Turn<'_>) -> Result<bool> {
        let waiting = u64::from(self.waiting().await?);
        let ours = turn.prediction.waiting(self.current_index().await?.0);
        // The command under way may count as waiting or not.
        Ok(ours > 0 && waiting <= ours)
    }

    /// All that a motion depends on, of an arm that stands with an empty queue.
    async fn read_standing(&self, turn: &mut Turn<'_>) -> Result<Preflight> {
        self.come_to_rest().await?;
        let look = self.read_queue().await?;
        if look.waiting() > 0 {
            return Err(refused(
                "its queue has unchecked commands, waiting or running; wait until they have \
                    finished",
            )
            .remedy(Action::Stop, DROPS));
        }
        if self.moving() {
            self.wait_still().await?;
        }
        let on_rail = (self
            .setting::<magician_protocol::commands::DeviceWithL>()
            .await)
            .is_ok_and(|rail| rail.with_l.is_on());
        let check = self.read(Needs::all(on_rail), on_rail, &look).await?;
        let Some(start) = check.arm().map(|start| start.pose.to_array()) else {
            return Err(refused("it moves; wait until it has stopped"));
        };
        turn.first = true;
        turn.prediction.end = None;
        turn.prediction.last = look.current;
        turn.prediction.stations.clear();
        turn.prediction
            .stations
            .push_back((look.current, Some(start)));
        Ok(check.guards(Guards::NONE.reach(true).unknown_start(true)))
    }

    /// What lets a queue run: only what was checked from where the arm stands may wait there.
    async fn hold_release<'a>(
        &self,
        held: &'a Held,
        frame: &Frame<'_>,
        deadline: Instant,
    ) -> Result<Turn<'a>> {
        let turn = self.take_fence(held, deadline).await?;
        let waiting = self.waiting().await?;
        if waiting == 0 {
            if frame.id() != QueuedCmdStartExec::ROW.id {
                held.forget();
            }
            return Ok(turn);
        }
        let current = self.current_index().await?.0;
        let known = turn.prediction.breaks == turn.breaks && turn.prediction.end.is_some();
        let ours = turn.prediction.waiting(current);
        if !known || u64::from(waiting) > ours {
            let (commands, were) = match waiting {
                1 => ("1 command waits", "was"),
                _ => ("commands wait", "were"),
            };
            return Err(refused(&format!(
                "{commands} in its queue that {were} not checked from its position"
            ))
            .remedy(Action::Stop, DROPS));
        }
        if frame.id() == QueuedCmdStartExec::ROW.id {
            if self.picture().motion().stopped() {
                self.stands_at_station(&turn, current).await?;
            }
            return Ok(turn);
        }
        // What an alarm has ended counts as finished, wherever the arm was.
        if self.alarms().await?.blocking() {
            return Err(refused(
                "an alarm holds commands in its queue that were planned from another position",
            )
            .remedy(Action::Stop, DROPS));
        }
        let before: Pose = self.get().await?;
        sleep(2 * APART).await;
        if self.get::<Pose>().await? == before {
            self.stands_at_station(&turn, current).await?;
        }
        Ok(turn)
    }

    /// A queue at rest: the arm was not moved meanwhile.
    async fn stands_at_station(&self, turn: &Turn<'_>, current: u64) -> Result<()> {
        let mut stations = turn.prediction.stations.iter().rev();
        let station = stations.find(|(index, _)| *index <= current);
        let station = station.and_then(|(_, pose)| *pose);
        let stands = place(&self.get().await?);
        let is_there = station.is_some_and(|station| is_near(station, stands));
        if is_there {
            Ok(())
        } else {
            let why = "it is not where its last command left it";
            Err(refused(why).remedy(Action::Stop, DROPS))
        }
    }

    /// The right to jog, and where from.
    pub(super) async fn hold_jog(
        &self,
        deadline: Instant,
    ) -> Result<Option<(Turn<'_>, Preflight)>> {
        let held = &self.inner.held;
        if !held.bounds_motion() {
            return Ok(None);
        }
        let mut turn = self.take_fence(held, deadline).await?;
        let check = self.read_standing(&mut turn).await?;
        held.forget();
        Ok(Some((turn, check)))
    }

    /// The right to run a program, with where it begins.
    pub(super) async fn hold_run(&self, begins: bool) -> Result<Option<Turn<'_>>> {
        let held = &self.inner.held;
        if !held.bounds_motion() {
            return Ok(None);
        }
        let mut turn = self.take_fence(held, self.call_deadline()).await?;
        if begins {
            turn.then = Some(self.course_end(&mut turn).await?);
        }
        Ok(Some(turn))
    }
}

/// What a stop does to the queue.
const DROPS: &str = "drops the waiting commands";

/// What a fence cannot be held against.
fn refused(why: &str) -> Error {
    Error::guarded(
        "fence",
        format!("this arm has a fence, and {why}; nothing was sent"),
    )
}
