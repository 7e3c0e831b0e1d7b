//! Continuous paths: one segment after the other without a stop between (model section 8).

use magician_motion::{CpSegment, CpSpeeds, JointAngles, LookAhead, Planner, Pose};
use magician_protocol::commands::{CpCmd, CpLeCmd};
use magician_protocol::{CpMode, Flag, Set};

use super::plan::alarm_on_a_path;
use super::{Outputs, Purpose};
use crate::convert::from_wire;
use crate::device::Device;
use crate::device::dispatch::{Step, Turn};
use crate::device::queue::Order;

/// Where a segment leads, and how it gets there from the end of the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Way {
    to: [f64; 3],
    segment: CpSegment,
    /// Whether its end can be reached: the arm comes to rest before one that cannot.
    reachable: bool,
}

/// A segment under way: what it needs to be planned anew when more becomes known of what follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    way: Way,
    look_ahead: LookAhead,
    /// It came through the queue, and the queue's next segments follow it without a stop.
    queued: bool,
}

/// The mode and the numbers of a segment; `None` for any other command.
fn numbers(order: &Order) -> Option<(CpMode, [f32; 3])> {
    match order {
        Order::Set(
            Set::CpCmd(CpCmd {
                cp_mode, x, y, z, ..
            })
            | Set::CpLeCmd(CpLeCmd {
                cp_mode, x, y, z, ..
            }),
        ) => Some((*cp_mode, [*x, *y, *z])),
        _ => None,
    }
}

impl Way {
    /// The way of a segment that begins at a point.
    fn from(planner: &Planner, start: [f64; 3], mode: CpMode, numbers: [f32; 3]) -> Self {
        let mut to = from_wire(numbers);
        if mode == CpMode::Relative {
            for (to, start) in to.iter_mut().zip(start) {
                *to += start;
            }
        }
        let [x, y, z] = to;
        let joints = planner.geometry.inverse(&Pose::new(x, y, z, 0.0));
        Self {
            to,
            segment: CpSegment::between(start, to),
            // J4 stands still, so its limits have no part in it.
            reachable: joints.is_ok_and(|joints| {
                let j4 = planner.limits.j4.min;
                planner.limits.check(&JointAngles { j4, ..joints }).is_ok()
            }),
        }
    }
}

impl Device {
    /// Begins a segment. What follows it in the queue by now decides how fast it may end.
    pub(crate) fn begin_segment(
        &mut self,
        id: u8,
        (mode, numbers): (CpMode, [f32; 3]),
        power: f32,
        turn: Turn,
    ) -> Step {
        let look_ahead = match LookAhead::new(&self.cp_speeds(), &self.model.ceilings) {
            Ok(look_ahead) => look_ahead,
            Err(error) => return self.unplannable(id, &error),
        };
        let queued = turn == Turn::Queued;
        let entry = if queued { self.motion.carried } else { 0.0 };
        let from = self.arm();
        let planner = self.planner_told_rates();
        let start = [from.pose.x, from.pose.y, from.pose.z];
        let way = Way::from(&planner, start, mode, numbers);
        if way.segment.is_empty() {
            // In the queue the speed of the segment before it goes on into the one after it.
            self.halt();
            return Step::Done;
        }
        let segment = Segment {
            way,
            look_ahead,
            queued,
        };
        if entry == 0.0 {
            // Whatever was known was known of a path that has ended.
            self.forget_ways();
        }
        if queued {
            self.resolve_ways(&planner, way.to);
        }
        let (exit, rates) = (self.exit_speed(&segment), look_ahead.rates(&way.segment));
        match planner.segment(&from, way.to, entry, exit, rates) {
            Ok(plan) => {
                self.halt();
                self.motion.carried = 0.0;
                self.actuators.burn(f64::from(power));
                self.feel_grip();
                let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
                let purpose = Purpose::Segment(segment);
                self.begin(purpose, plan.trajectory, alarm, Outputs::default())
            }
            Err(error) => self.unplannable(id, &error),
        }
    }

    /// The segment under way is planned anew if what is known now lets it end faster, or makes it end slower.
    pub(crate) fn replan_segment(&mut self) {
        let Some(motion) = self.motion.under_way() else {
            return;
        };
        let Purpose::Segment(segment) = motion.purpose else {
            return;
        };
        // With a speed of 0 the next one would not begin.
        let exit = match LookAhead::new(&self.cp_speeds(), &self.model.ceilings) {
            Ok(_) => self.exit_speed(&segment),
            Err(_) => 0.0,
        };
        if motion.alarm.is_some() || exit == motion.trajectory.exit_speed() {
            return;
        }
        let rates = segment.look_ahead.rates(&segment.way.segment);
        let planner = self.planner_told_rates();
        let elapsed = motion.elapsed(self.now);
        let plan = planner.segment_rest(&motion.trajectory, elapsed, exit, rates);
        if let Ok(Some(plan)) = plan {
            let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
            self.rest_here();
            let purpose = Purpose::Segment(segment);
            self.begin(purpose, plan.trajectory, alarm, Outputs::default());
        }
    }

    /// The speed at which a segment may end: none if the queue will not take the next one at once.
    fn exit_speed(&self, segment: &Segment) -> f64 {
        if !segment.queued || !self.goes_on() {
            return 0.0;
        }
        let known = self.queue.entries().map_while(|entry| entry.way.as_ref());
        let next = known.take_while(|way| way.reachable);
        let Segment {
            way, look_ahead, ..
        } = segment;
        look_ahead.exit_speed(&way.segment, next.map(|way| &way.segment))
    }

    /// Finds out where the segments at the head of the queue lead, the first of them from a point.
    fn resolve_ways(&mut self, planner: &Planner, mut from: [f64; 3]) {
        for entry in self.queue.entries_mut() {
            let Some((mode, numbers)) = numbers(&entry.order) else {
                return;
            };
            if entry.way.is_some() {
                return;
            }
            let way = Way::from(planner, from, mode, numbers);
            from = way.to;
            entry.way = Some(way);
        }
    }

    /// The tool has another bias: where the path leads will be found out when the arm stands.
    pub(crate) fn tool_changes(&mut self) {
        self.forget_ways();
        self.replan_segment();
    }

    fn forget_ways(&mut self) {
        for entry in self.queue.entries_mut() {
            entry.way = None;
        }
    }

    /// A command has been queued: if it is a segment on the heels of another, its way is known at once.
    pub(crate) fn path_grows(&mut self) {
        let before = self.queue.entries().rev().nth(1);
        let from = match (before, self.motion.under_way().map(|motion| motion.purpose)) {
            (Some(entry), _) => entry.way.map(|way| way.to),
            (None, Some(Purpose::Segment(segment)))
                if segment.queued && self.motion.measured == self.geometry() =>
            {
                Some(segment.way.to)
            }
            _ => None,
        };
        let Some(from) = from else {
            return;
        };
        let planner = self.planner_told_rates();
        let Some(entry) = self.queue.entries_mut().next_back() else {
            return;
        };
        if let Some((mode, numbers)) = numbers(&entry.order) {
            entry.way = Some(Way::from(&planner, from, mode, numbers));
            self.replan_segment();
        }
    }

    /// The segment has come to its end: its speed is the next one's to begin with. At rest the laser is off.
    pub(super) fn segment_ended(&mut self, speed: f64) {
        self.motion.carried = speed;
        if speed == 0.0 {
            self.actuators.burn(0.0);
        }
    }

    /// No segment has followed at once: whatever speed was left is lost, and the laser is off.
    pub(crate) fn come_to_rest(&mut self) {
        if self.motion.carried != 0.0 {
            self.motion.carried = 0.0;
            if !self.motion.is_moving() {
                self.actuators.burn(0.0);
                self.feel_grip();
            }
        }
    }

    /// The speeds of continuous paths that are set now.
    fn cp_speeds(&self) -> CpSpeeds {
        let cp = &self.settings.cp;
        let real_time = cp.real_time_track != Flag::OFF;
        let own = &self.model.power_up.path;
        CpSpeeds {
            plan_acceleration: cp.plan_acc.into(),
            junction_velocity: cp.junction_vel.into(),
            period_s: if real_time {
                f64::from(cp.acc_or_period) / 1000.0
            } else {
                own.period_s
            },
            real_time,
            whole_periods: own.whole_periods,
        }
    }
}
