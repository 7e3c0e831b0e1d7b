//! When a limit alarm drops because its joint has come back inside (model section 4).

use magician_motion::{Bound, Trajectory};

use super::limits::{alarm_of, is_at};
use crate::Micros;
use crate::device::Device;
use crate::event::Event;
use crate::fidelity::Assumption;

impl Device {
    /// Whether the joints stand at the limit that an alarm is about: its cause stands.
    pub(crate) fn limit_stands(&self, code: u8) -> bool {
        let limits = self.model.limits;
        let joints = self.arm().joints;
        Bound::ALL
            .into_iter()
            .any(|bound| alarm_of(bound) == code && is_at(bound, &limits, &joints))
    }

    /// Drops the limit alarms of joints that are inside again; the hold on the queue stays (model section 4).
    pub(super) fn drop_limit_alarms(&mut self) {
        if !self.alarms.held() {
            return;
        }
        for bound in Bound::ALL {
            let code = alarm_of(bound);
            if self.alarms.standing().contains(code) && !self.limit_stands(code) {
                self.alarms.drop_alarm(code);
                self.log.push(Event::AlarmCleared { code });
                self.assume(Assumption::LimitDrops);
                self.assume(Assumption::LatchedHold);
            }
        }
    }

    /// Finds out when the motion takes a joint back inside whose limit alarm stands.
    pub(super) fn watch_limits(&mut self) {
        let Some(motion) = &mut self.motion.under_way else {
            return;
        };
        motion.leaves_limit = None;
        // A limit alarm that stands holds the queue.
        if !self.alarms.held() {
            return;
        }
        let (standing, now) = (self.alarms.standing(), self.now);
        let limits = self.model.limits;
        let from = motion.elapsed(now);
        let leaving = |trajectory: &Trajectory| {
            let leaves = |bound: Bound| {
                let outside = |t| is_at(bound, &limits, &trajectory.sample(t).joints);
                first_inside(from, trajectory.duration_us(), outside)
            };
            Bound::ALL
                .into_iter()
                .filter(|bound| standing.contains(alarm_of(*bound)))
                .filter_map(leaves)
                .min()
        };
        motion.leaves_limit = leaving(&motion.trajectory).map(|t| motion.started.saturating_add(t));
    }
}

/// Looks at a motion for where it comes inside, one that goes out and back included.
const LOOKS: Micros = 64;

/// The first microsecond after `from` that is inside, if a motion gets there; one that is inside for less than a
/// [`LOOKS`]th of its time may be taken for one that does not.
fn first_inside(from: Micros, to: Micros, outside: impl Fn(Micros) -> bool) -> Option<Micros> {
    let span = to.saturating_sub(from);
    let look = |step: Micros| from + span / LOOKS * step + span % LOOKS * step / LOOKS;
    let first = (1..=LOOKS).find(|step| !outside(look(*step)))?;
    let (mut out, mut inside) = (look(first - 1), look(first));
    while inside - out > 1 {
        let middle = out + (inside - out) / 2;
        if outside(middle) {
            out = middle;
        } else {
            inside = middle;
        }
    }
    Some(inside)
}
