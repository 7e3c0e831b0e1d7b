//! What is known of the arm without asking it: its settings, where it stands, that no alarm holds it.

use std::time::Duration;

use magician_host::{ArmOutputs, ArmPicture, HomingTracker};
use magician_protocol::commands::{
    AlarmsState, EndEffectorGripper, EndEffectorParams, EndEffectorSuctionCup, HomeCmd, Pose,
    PtpCommonParams, QueuedCmdCurrentIndex, QueuedCmdLeftSpace, QueuedCmdStartExec,
};
use magician_protocol::{
    Alarm, AlarmSet, Effect, Frame, NoArgs, QueuedCmdIndex, Readable, Row, Set, Writable,
};
use tokio::time::{Instant, sleep};

use super::Arm;
use super::driver::micros;
use super::laser::answered;
use super::lights_out::Darkness;
use crate::connection::{Failure, Micros};
use crate::preflight::state_at;
use crate::stream::ArmPace;
use crate::{RestDetector, Result};

/// How long the pose of an arm at rest, and the absence of alarms, stay valid: a hand may have moved it since.
const LATELY: Micros = 1_000_000;
/// How long the steps of one call share a look at the queue.
const SHARED: Duration = Duration::from_millis(100);

/// A motion of this time tells how fast an arm is.
const TELLING: Duration = Duration::from_millis(100);
/// An arm this near to where it was left has not been moved, mm and degrees.
const NEAR: f64 = 0.05;

/// What the task has seen pass, for all handles of a connection.
#[derive(Debug)]
pub(super) struct Known {
    /// Settings, tools and laser.
    pub(super) picture: ArmPicture,
    /// Others may use the line too, and set what they like.
    shared: bool,
    standing: Option<Standing>,
    alarms: Option<(AlarmSet, Micros)>,
    pub(super) homing: HomingTracker,
    /// The last look at the queue, if nothing but reads went out since.
    look: Option<QueueLook>,
    /// Frames so far that were no reads.
    orders: u64,
    /// Nothing was done to the queue since it was started, and no alarm was seen to hold it.
    runs: bool,
    /// How fast the arm is beside the check's times.
    pub(super) pace: ArmPace,
    /// The highest index of which this connection knows what became of it.
    accounted: u64,
    /// Since this connection put the laser out, until a command is queued.
    pub(super) darkness: Option<Darkness>,
}

/// An arm that has finished all that it had.
#[derive(Clone, Copy, Debug)]
struct Standing {
    pose: Pose,
    /// The command it had finished last.
    index: u64,
    /// When that was certain.
    at: Option<Micros>,
}

/// The queue, as it was read.
#[derive(Clone, Copy, Debug)]
pub(super) struct QueueLook {
    /// Free places.
    pub(super) left: u32,
    /// The index of the command that was finished last.
    pub(super) current: u64,
    /// Places in all.
    places: u32,
    at: Instant,
}

impl QueueLook {
    /// Whether it was read just now.
    pub(super) fn is_fresh(&self) -> bool {
        self.at.elapsed() <= SHARED
    }

    /// How many places are taken.
    pub(super) fn waiting(&self) -> u32 {
        self.places.saturating_sub(self.left)
    }
}

impl Known {
    pub(super) fn new(shared: bool) -> Self {
        Self {
            picture: ArmPicture::default(),
            shared,
            standing: None,
            alarms: None,
            homing: HomingTracker::default(),
            look: None,
            orders: 0,
            runs: false,
            pace: ArmPace::Unknown,
            accounted: 0,
            darkness: None,
        }
    }

    /// A request goes out.
    pub(super) fn sends(&mut self, now: Micros, request: &Frame<'_>) {
        self.darkness = Darkness::after(self.darkness, now, request);
        self.picture.sent(request);
        self.homing.sends(request);
        let ctrl = request.ctrl();
        if ctrl.write() || ctrl.queued() {
            self.look = None;
            self.orders += 1;
        }
        if !ctrl.write() {
            return;
        }
        match Row::with_id(request.id()).map(|row| row.effect) {
            // Clearing the alarms is among them; the others do not move an arm whose queue is empty.
            Some(Effect::Queue) => {
                self.alarms = None;
                self.runs = request.id() == QueuedCmdStartExec::ROW.id;
            }
            // What is queued shows in the index.
            _ if ctrl.queued() => {}
            // The tip may be elsewhere with another tool: a look tells.
            Some(Effect::Setting | Effect::Laser) => {
                if let Some(standing) = &mut self.standing {
                    standing.at = None;
                }
            }
            _ => self.standing = None,
        }
    }

    /// A request was answered.
    pub(super) fn answered(&mut self, now: Micros, request: &Frame<'_>, reply: &Frame<'_>) {
        self.picture.answered(now, request, reply);
        let ctrl = request.ctrl();
        if ctrl.queued() {
            if let Ok(QueuedCmdIndex(index)) = reply.read() {
                self.accounted = self.accounted.max(index);
                if request.id() == HomeCmd::ROW.id {
                    self.homing.accepted(index);
                }
            }
        } else if ctrl.write() {
            // A write has been answered: only readings tell more.
        } else if request.id() == <QueuedCmdCurrentIndex as Readable>::ROW.id {
            if let Ok(read) = reply.read::<QueuedCmdCurrentIndex>() {
                self.homing.read_current(read.queued_cmd_current_index);
            }
        } else if request.id() == <Pose as Readable>::ROW.id {
            if let Ok(pose) = reply.read::<Pose>() {
                self.homing.read_pose(&pose);
                if let Some(darkness) = &mut self.darkness {
                    darkness.sees(now, pose);
                }
            }
        } else if request.id() == <AlarmsState as Readable>::ROW.id
            && let Ok(read) = reply.read::<AlarmsState>()
        {
            self.alarms = Some((read.alarms_state, now));
            self.runs &= !read.alarms_state.blocking();
            self.homing.read_alarms(read.alarms_state);
        }
    }

    /// A request was not answered.
    pub(super) fn failed(&mut self, request: &Frame<'_>, failure: &Failure) {
        self.picture.failed(request, failure);
    }

    /// A program's command was taken.
    pub(super) fn accepted(&mut self, index: u64, command: &Set) {
        self.accounted = self.accounted.max(index);
        self.picture.accepted(index, command);
        if matches!(command, Set::HomeCmd(_)) {
            self.homing.accepted(index);
        }
    }

    /// The line was lost: an arm that comes back may be another one, or have been switched off. A record tells.
    pub(super) fn lost(&mut self) {
        // Whether the frame has reached the arm is not known.
        self.darkness = self.darkness.filter(|darkness| darkness.seen().is_some());
        self.forget();
        self.homing.forget();
    }

    /// True if the arm was seen to be homed since power-up, false while it says that it was not, under these alarms.
    pub(super) fn homed_under(&self, alarms: &AlarmSet) -> Option<bool> {
        if self.homing.is_homed() {
            Some(true)
        } else {
            alarms.contains(Alarm::ResetOccurred).then_some(false)
        }
    }

    /// The line was lost, or others have used the arm.
    pub(super) fn forget(&mut self) {
        self.picture.forget();
        (self.standing, self.alarms, self.look) = (None, None, None);
    }

    /// The arm was reset.
    pub(super) fn reset(&mut self) {
        let (orders, mut picture) = (self.orders, std::mem::take(&mut self.picture));
        picture.reset();
        *self = Self {
            orders,
            picture,
            ..Self::new(self.shared)
        };
    }

    /// A command has finished that this connection did not put into the queue.
    fn account(&mut self, current: u64) {
        if current > self.accounted {
            self.accounted = current;
            self.forget();
        }
    }

    /// Settings from before that instant are not believed.
    fn since(&self, now: Micros) -> Micros {
        if self.accounted == 0 {
            // An arm that has done nothing yet does not show that it was switched off and on.
            Micros::MAX
        } else if self.shared {
            now.saturating_sub(LATELY)
        } else {
            0
        }
    }
}

impl Arm {
    pub(super) fn clock(&self) -> Micros {
        micros(self.inner.shared.begun.elapsed())
    }

    /// Whether the queue runs for certain: this connection has started it, nothing has held it since, and no other
    /// program can have
    /// stopped it.
    pub(super) fn runs_queue(&self) -> bool {
        let started = self.in_flight().started() == Some(true);
        let known = self.inner.shared.known();
        started && known.runs && !known.shared
    }

    /// Returns tool, laser, suction cup, gripper and speed, as they follow from the commands that were sent over this
    /// connection and from what the arm has answered; each is `None` if not known. No frame is sent.
    ///
    /// A queued command counts when the arm has finished it, which shows in the current index. The laser counts as lit as
    /// soon as a command that may burn goes out, and until one that puts it out was answered or has finished. Outputs that
    /// another program has switched are seen when they are read: [`read_outputs`](Self::read_outputs).
    #[must_use]
    pub fn outputs(&self) -> ArmOutputs {
        let laser_pins = self.inner.options.laser_pins;
        self.inner.shared.known().picture.outputs(laser_pins)
    }

    /// Reads [`outputs`](Self::outputs) and returns them; each is `None` if the arm does not answer.
    ///
    /// # Errors
    /// As [`get`](Self::get), but for answers that some arms do not give.
    pub async fn read_outputs(&self) -> Result<ArmOutputs> {
        // Commands of other programs that have finished void what was read before they were seen.
        self.look_at_queue().await?;
        answered(self.get::<EndEffectorSuctionCup>().await)?;
        answered(self.get::<EndEffectorGripper>().await)?;
        answered(self.get::<EndEffectorParams>().await)?;
        answered(self.get::<PtpCommonParams>().await)?;
        self.laser().is_on().await?;
        self.laser().learn_pins().await?;
        Ok(self.outputs())
    }

    /// Number of times that [`outputs`](Self::outputs) became unknown: a line was lost, the arm was reset, another program
    /// has used it, or an answer did not come.
    #[doc(hidden)]
    #[must_use]
    pub fn output_lapses(&self) -> u64 {
        self.inner.shared.known().picture.lapses()
    }

    /// A setting: as it is known, or read.
    pub(super) async fn setting<T: Readable<Query = NoArgs>>(&self) -> Result<T> {
        self.setting_with(&NoArgs).await
    }

    /// As [`setting`](Self::setting), of what depends on something.
    pub(super) async fn setting_with<T: Readable>(&self, query: &T::Query) -> Result<T> {
        let now = self.clock();
        let known = {
            let known = self.inner.shared.known();
            known.picture.get_with(query, known.since(now))
        };
        match known {
            Some(value) => Ok(value),
            None => self.get_with(query).await,
        }
    }

    /// A command that should take so long has taken so long: a short one says nothing.
    pub(super) fn note_pace(&self, should: Duration, took: Duration) {
        if should >= TELLING {
            self.inner.shared.known().pace = if took >= should.mul_f64(0.9) {
                ArmPace::OnTime
            } else {
                ArmPace::Faster
            };
        }
    }

    /// The alarms, as they were read lately, or are read now.
    pub(super) async fn known_alarms(&self) -> Result<AlarmSet> {
        let since = self.clock().saturating_sub(LATELY);
        let known = self.inner.shared.known().alarms;
        match known.filter(|(alarms, at)| *at >= since && !alarms.blocking()) {
            Some((alarms, _)) => Ok(alarms),
            None => self.alarms().await,
        }
    }

    /// A look at the queue, left space before index. The steps of one call share it as long as nothing goes out but reads.
    pub(super) async fn look_at_queue(&self) -> Result<QueueLook> {
        let known = self.inner.shared.known().look;
        match known.filter(QueueLook::is_fresh) {
            Some(look) => Ok(look),
            None => self.read_queue().await,
        }
    }

    pub(super) async fn read_queue(&self) -> Result<QueueLook> {
        let orders = self.inner.shared.known().orders;
        let left = self.get::<QueuedCmdLeftSpace>().await?.left_space;
        let read = self.get::<QueuedCmdCurrentIndex>().await?;
        let current = read.queued_cmd_current_index;
        let (_, places) = self.stats().await?;
        let look = QueueLook {
            left,
            current,
            places,
            at: Instant::now(),
        };
        let mut known = self.inner.shared.known();
        known.account(current);
        known.look = (known.orders == orders).then_some(look);
        Ok(look)
    }

    /// Where the arm stands by its last motion, if that is known, the look at its queue fits, and nothing has moved it since.
    pub(super) fn standing(&self, look: &QueueLook) -> Option<Pose> {
        let since = self.clock().saturating_sub(LATELY);
        let standing = self.inner.shared.known().standing?;
        let is_it =
            look.waiting() == 0 && look.current == standing.index && standing.at >= Some(since);
        is_it.then_some(standing.pose)
    }

    /// True if the arm stands where its last motion over this connection has left it.
    pub(super) fn was_left_at(&self, there: &Pose, look: &QueueLook) -> bool {
        let left_there = self.inner.shared.known().standing;
        left_there
            .filter(|standing| standing.index == look.current)
            .is_some_and(|standing| is_near(place(&standing.pose), place(there)))
    }

    /// Where the arm stands that was seen at `there`, by this look at its queue: unknown while commands wait in it, or while it
    /// moves. `rest` has seen that pose.
    pub(super) async fn stands_at(
        &self,
        there: Pose,
        rest: RestDetector,
        look: &QueueLook,
    ) -> Result<Option<Pose>> {
        if look.waiting() > 0 {
            return Ok(None);
        }
        if !self.was_left_at(&there, look) && !self.is_still_at(there, rest).await? {
            return Ok(None);
        }
        self.note_standing(look.current, there);
        Ok(Some(there))
    }

    /// True if the arm is at rest at `there`, where `rest` has seen it. What was read since then took some time, and no line says
    /// how much: the clock does.
    async fn is_still_at(&self, there: Pose, mut rest: RestDetector) -> Result<bool> {
        #[cfg(feature = "sim")]
        if let Some(arm) = self.virtual_arm().filter(|arm| arm.passes_time_itself()) {
            // No wait of this clock is one of its own.
            return Ok(self.get::<Pose>().await? == there && !arm.state().moving);
        }
        while !rest.is_at_rest() {
            let now = self.clock();
            let next = rest.next_read().unwrap_or(now);
            sleep(Duration::from_micros(next.saturating_sub(now))).await;
            let pose = self.get::<Pose>().await?;
            if pose != there {
                return Ok(false);
            }
            rest.see(self.clock(), pose);
        }
        Ok(true)
    }

    /// All that it had is finished, the last of it under this index, and it stands there.
    pub(super) fn note_standing(&self, index: u64, pose: Pose) {
        let at = Some(self.clock());
        self.inner.shared.known().standing = Some(Standing { pose, index, at });
    }
}

/// x, y, z and r that an arm reports.
pub(super) fn place(pose: &Pose) -> [f64; 4] {
    state_at(pose).pose.to_array()
}

/// Whether two places are the same but for rounding.
pub(super) fn is_near(one: [f64; 4], other: [f64; 4]) -> bool {
    let mut pairs = one.into_iter().zip(other);
    pairs.all(|(one, other)| (one - other).abs() <= NEAR)
}
