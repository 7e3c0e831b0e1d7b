//! Where an arm was left, and the last look at its queue: valid until something is sent that changes them.

use magician_protocol::commands::{Pose, QueuedCmdStartExec};
use magician_protocol::{AlarmSet, Effect, Frame, Row, Writable};

use crate::connection::Micros;
use crate::preflight::state_at;

/// How long the pose of an arm at rest, and the absence of alarms, stay valid, us: a hand may have moved it since.
pub(super) const VALIDITY: Micros = 1_000_000;
/// How long the steps of one call share a look at the queue, us.
const LOOK_VALIDITY: Micros = 100_000;
/// Distance within which an arm has not been moved, mm and degrees.
const NEAR: f64 = 0.05;

/// The queue, as it was read.
#[derive(Clone, Copy, Debug)]
pub struct QueueLook {
    /// Free places.
    pub left: u32,
    /// Index of the command that finished last.
    pub current: u64,
    /// Places in all.
    pub places: u32,
    /// When it was read, us.
    pub at: Micros,
}

impl QueueLook {
    /// True if it was read a moment ago.
    #[must_use]
    pub const fn is_fresh(&self, now: Micros) -> bool {
        now.saturating_sub(self.at) <= LOOK_VALIDITY
    }

    /// Number of places that are taken.
    #[must_use]
    pub const fn waiting(&self) -> u32 {
        self.places.saturating_sub(self.left)
    }
}

/// Where an arm was left that has finished all that it had.
#[derive(Clone, Copy, Debug)]
struct LeftAt {
    pose: Pose,
    /// Index of the command that it had finished last.
    index: u64,
    /// When that was certain; `None` if a look has to confirm it.
    at: Option<Micros>,
}

/// Where an arm was left, and the last look at its queue.
#[derive(Clone, Debug, Default)]
pub struct Standing {
    left: Option<LeftAt>,
    look: Option<QueueLook>,
    /// Number of frames so far that were no reads.
    orders: u64,
    /// Nothing was done to the queue since it was started, and no alarm was seen to hold it.
    runs: bool,
    /// Highest index of which this connection knows what became of it.
    accounted: u64,
}

impl Standing {
    /// A request goes out; true if the alarms may be others after it.
    pub(super) fn sent(&mut self, request: &Frame<'_>) -> bool {
        let ctrl = request.ctrl();
        if ctrl.write() || ctrl.queued() {
            self.look = None;
            self.orders += 1;
        }
        if !ctrl.write() {
            return false;
        }
        match Row::with_id(request.id()).map(|row| row.effect) {
            // Clearing the alarms is among them; the others do not move an arm whose queue is empty.
            Some(Effect::Queue) => {
                self.runs = request.id() == QueuedCmdStartExec::ROW.id;
                return true;
            }
            // What is queued shows in the index.
            _ if ctrl.queued() => {}
            // The tip may be elsewhere with another tool: a look tells.
            Some(Effect::Setting | Effect::Laser) => {
                if let Some(left) = &mut self.left {
                    left.at = None;
                }
            }
            _ => self.left = None,
        }
        false
    }

    /// The arm has taken a command of this connection under this index.
    pub(super) fn accepted(&mut self, index: u64) {
        self.accounted = self.accounted.max(index);
    }

    pub(super) fn read_alarms(&mut self, alarms: AlarmSet) {
        self.runs &= !alarms.blocking();
    }

    /// The line was lost, or others have used the arm.
    pub(super) fn forget(&mut self) {
        (self.left, self.look) = (None, None);
    }

    pub(super) fn reset(&mut self) {
        *self = Self {
            orders: self.orders,
            ..Self::default()
        };
    }

    /// The current index was read; true if a command has finished that this connection did not put into the queue.
    pub(super) fn account(&mut self, current: u64) -> bool {
        let foreign = current > self.accounted;
        self.accounted = self.accounted.max(current);
        foreign
    }

    /// Notes a look, unless something else than a read was sent since [`orders`](Self::orders) were `before`.
    pub(super) fn note_look(&mut self, look: QueueLook, before: u64) {
        self.look = (self.orders == before).then_some(look);
    }

    pub(super) fn note_left_at(&mut self, now: Micros, index: u64, pose: Pose) {
        let at = Some(now);
        self.left = Some(LeftAt { pose, index, at });
    }

    /// Number of frames so far that were no reads.
    #[must_use]
    pub const fn orders(&self) -> u64 {
        self.orders
    }

    pub(super) const fn runs_queue(&self) -> bool {
        self.runs
    }

    /// False for an arm that has done nothing yet: it does not show that it was switched off and on.
    pub(super) const fn shows_resets(&self) -> bool {
        self.accounted > 0
    }

    /// The last look at the queue, if it is fresh and nothing but reads was sent since.
    #[must_use]
    pub fn fresh_look(&self, now: Micros) -> Option<QueueLook> {
        self.look.filter(|look| look.is_fresh(now))
    }

    /// Pose of the arm by its last motion, if this look at its queue fits and nothing has moved it since.
    #[must_use]
    pub fn pose(&self, now: Micros, look: &QueueLook) -> Option<Pose> {
        let since = now.saturating_sub(VALIDITY);
        let left = self.left?;
        let fits = look.waiting() == 0 && look.current == left.index && left.at >= Some(since);
        fits.then_some(left.pose)
    }

    /// True if an arm at this pose is where its last motion over this connection has left it.
    #[must_use]
    pub fn was_left_at(&self, there: &Pose, look: &QueueLook) -> bool {
        self.left
            .filter(|left| left.index == look.current)
            .is_some_and(|left| is_near(place(&left.pose), place(there)))
    }
}

/// x, y, z and r that an arm reports.
#[must_use]
pub fn place(pose: &Pose) -> [f64; 4] {
    state_at(pose).pose.to_array()
}

/// True if two places are the same but for rounding: 0.05 mm and degrees.
#[must_use]
pub fn is_near(one: [f64; 4], other: [f64; 4]) -> bool {
    let mut pairs = one.into_iter().zip(other);
    pairs.all(|(one, other)| (one - other).abs() <= NEAR)
}
