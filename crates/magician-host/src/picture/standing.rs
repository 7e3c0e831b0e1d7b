//! Pose where the arm was left and the last reading of its queue: valid until something is sent
//! that changes them.
//!
//! They save reading the pose before each move of a sequence of calls.

use magician_protocol::commands::{Pose, QueuedCmdStartExec};
use magician_protocol::{AlarmSet, Effect, Frame, Row, Writable};

use crate::connection::Micros;
use crate::preflight::state_at;

/// Validity of the pose of an arm at rest, and of the absence of alarms, us. It is short because
/// the arm may have been moved by hand since.
pub(super) const STATE_VALIDITY: Micros = 1_000_000;
/// Time for which the steps of one call share a reading of the queue, us.
const QUEUE_VALIDITY: Micros = 100_000;
/// Largest deviation of an arm that was not moved, mm and degrees.
// Above the rounding of the reported pose and below any motion by hand.
const REST_TOLERANCE: f64 = 0.05;

/// A reading of the queue.
#[derive(Clone, Copy, Debug)]
pub struct QueueLook {
    /// Free places.
    pub left: u32,
    /// Index of the command that finished last.
    pub current: u64,
    /// All places.
    pub places: u32,
    /// Instant of the reading, us.
    pub at: Micros,
}

impl QueueLook {
    /// True if it was read just now.
    #[must_use]
    pub const fn is_fresh(&self, now: Micros) -> bool {
        now.saturating_sub(self.at) <= QUEUE_VALIDITY
    }

    /// Number of occupied places.
    #[must_use]
    pub const fn waiting(&self) -> u32 {
        self.places.saturating_sub(self.left)
    }
}

/// Pose of an arm that has finished everything.
#[derive(Clone, Copy, Debug)]
struct RestPose {
    pose: Pose,
    /// Index of the command finished last.
    index: u64,
    /// Instant at which the pose was certain. `None` if a reading must confirm it.
    at: Option<Micros>,
}

/// Pose where the arm was left, and the last reading of its queue.
#[derive(Clone, Debug, Default)]
pub struct RestState {
    left: Option<RestPose>,
    look: Option<QueueLook>,
    /// Number of frames sent that were not reads.
    orders: u64,
    /// True if nothing was done to the queue since it was started, and no alarm was seen to hold
    /// it.
    runs: bool,
    /// Highest index whose command this connection can account for.
    accounted: u64,
}

impl RestState {
    /// Processes a sent request. True if it may change the alarms.
    pub(super) fn sent(&mut self, request: &Frame<'_>) -> bool {
        let ctrl = request.ctrl();
        if ctrl.write() || ctrl.queued() {
            self.look = None;
            // Readings that began before this frame may be outdated by it.
            self.orders += 1;
        }
        if !ctrl.write() {
            return false;
        }
        match Row::with_id(request.id()).map(|row| row.effect) {
            // This includes clearing the alarms; the others do not move an arm whose queue is
            // empty.
            Some(Effect::Queue) => {
                self.runs = request.id() == QueuedCmdStartExec::ROW.id;
                return true;
            }
            // Queued commands are noticed by their index.
            _ if ctrl.queued() => {}
            // With another tool the tip may be elsewhere: a reading must confirm the pose.
            Some(Effect::Setting | Effect::Laser) => {
                if let Some(left) = &mut self.left {
                    left.at = None;
                }
            }
            // Motion, external motors, unknown ids: the arm may have moved.
            _ => self.left = None,
        }
        false
    }

    /// Notes that the arm accepted a command of this connection with this index.
    pub(super) fn accepted(&mut self, index: u64) {
        self.accounted = self.accounted.max(index);
    }

    pub(super) fn read_alarms(&mut self, alarms: AlarmSet) {
        self.runs &= !alarms.blocking();
    }

    /// Discards pose and reading: the line was lost, or others have used the arm.
    pub(super) fn forget(&mut self) {
        (self.left, self.look) = (None, None);
    }

    pub(super) fn reset(&mut self) {
        *self = Self {
            // Kept, so that a reading from before the reset is recognised as old.
            orders: self.orders,
            ..Self::default()
        };
    }

    /// Processes a reading of the current index. True if a command has finished that this
    /// connection did not queue.
    pub(super) fn account(&mut self, current: u64) -> bool {
        let foreign = current > self.accounted;
        self.accounted = self.accounted.max(current);
        foreign
    }

    /// Stores a reading that began when [`writes_sent`](Self::writes_sent) was `before`, unless
    /// anything but reads was sent since.
    pub(super) fn note_look(&mut self, look: QueueLook, before: u64) {
        self.look = (self.orders == before).then_some(look);
    }

    pub(super) fn note_left_at(&mut self, now: Micros, index: u64, pose: Pose) {
        let at = Some(now);
        self.left = Some(RestPose { pose, index, at });
    }

    /// Number of frames sent that were not reads.
    #[must_use]
    pub const fn writes_sent(&self) -> u64 {
        self.orders
    }

    pub(super) const fn runs_queue(&self) -> bool {
        self.runs
    }

    /// True if a reset would show in the indices: false for an arm that has executed nothing yet,
    /// whose index is 0 anyway.
    pub(super) const fn shows_resets(&self) -> bool {
        self.accounted > 0
    }

    /// Last reading of the queue. `None` unless it is fresh and nothing but reads was sent since.
    #[must_use]
    pub fn fresh_look(&self, now: Micros) -> Option<QueueLook> {
        self.look.filter(|look| look.is_fresh(now))
    }

    /// Pose of the arm after its last motion. `None` unless this reading of the queue fits and
    /// nothing has moved the arm since.
    #[must_use]
    pub fn pose(&self, now: Micros, look: &QueueLook) -> Option<Pose> {
        let since = now.saturating_sub(STATE_VALIDITY);
        let left = self.left?;
        let fits = look.waiting() == 0 && look.current == left.index && left.at >= Some(since);
        fits.then_some(left.pose)
    }

    /// True if an arm at this pose is where its last motion over this connection left it.
    #[must_use]
    pub fn was_left_at(&self, there: &Pose, look: &QueueLook) -> bool {
        self.left
            .filter(|left| left.index == look.current)
            .is_some_and(|left| is_near(place(&left.pose), place(there)))
    }
}

/// x, y, z in mm and r in degrees as the arm reports them.
#[must_use]
pub fn place(pose: &Pose) -> [f64; 4] {
    state_at(pose).pose.to_array()
}

/// True if two poses are equal except for rounding: within 0.05 mm and degrees.
#[must_use]
pub fn is_near(one: [f64; 4], other: [f64; 4]) -> bool {
    let mut pairs = one.into_iter().zip(other);
    pairs.all(|(one, other)| (one - other).abs() <= REST_TOLERANCE)
}
