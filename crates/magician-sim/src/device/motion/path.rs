//! Continuous paths: one segment after the other without a stop between (model section 8).

use magician_motion::{ArmState, CpSegment, JointAngles, LookAhead, MotionError, Planner, Pose};
use magician_protocol::CpMode;

use super::plan::{NoPlan, alarm_on_a_path};
use super::{ArmView, Motion, MotionKind, Start};
use crate::convert::from_wire;

/// Where a segment leads, as its command says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathPoint {
    pub(crate) mode: CpMode,
    pub(crate) numbers: [f32; 3],
}

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

impl Way {
    /// The way of a segment that begins at a point.
    pub(crate) fn from(planner: &Planner, start: [f64; 3], point: PathPoint) -> Self {
        let mut to = from_wire(point.numbers);
        if point.mode == CpMode::Relative {
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

    /// Where it ends.
    pub(crate) fn to(&self) -> [f64; 3] {
        self.to
    }

    /// Whether it leads nowhere.
    pub(crate) fn is_empty(&self) -> bool {
        self.segment.is_empty()
    }
}

impl Segment {
    pub(crate) fn new(way: Way, look_ahead: LookAhead, queued: bool) -> Self {
        Self {
            way,
            look_ahead,
            queued,
        }
    }

    pub(crate) fn is_queued(&self) -> bool {
        self.queued
    }

    /// The speed at which it may end before what follows it at once.
    pub(crate) fn exit_speed<'a>(&self, next: impl Iterator<Item = &'a Way>) -> f64 {
        let next = next.take_while(|way| way.reachable);
        let next = next.map(|way| &way.segment);
        self.look_ahead.exit_speed(&self.way.segment, next)
    }
}

impl Motion {
    /// Where the segment of the queue that is under way leads, if it was planned with the arm's present measures.
    pub(crate) fn queued_segment_end(
        &self,
        geometry: &magician_motion::Geometry,
    ) -> Option<[f64; 3]> {
        match self.kind() {
            Some(MotionKind::Segment(segment)) if segment.queued && self.measured == *geometry => {
                Some(segment.way.to)
            }
            _ => None,
        }
    }

    /// The segment under way.
    pub(crate) fn segment(&self) -> Option<Segment> {
        match self.kind() {
            Some(MotionKind::Segment(segment)) => Some(segment),
            _ => None,
        }
    }
}

impl ArmView<'_> {
    /// The law of segments at the speeds that are set now.
    pub(crate) fn look_ahead(&self) -> Result<LookAhead, MotionError> {
        let model = &self.firmware.model;
        LookAhead::new(&self.settings.cp_speeds(model), &model.ceilings)
    }

    /// A segment from where the arm is.
    pub(crate) fn plan_segment(
        &self,
        planner: &Planner,
        from: &ArmState,
        segment: Segment,
        [entry, exit]: [f64; 2],
    ) -> Result<Start, NoPlan> {
        let rates = segment.look_ahead.rates(&segment.way.segment);
        let plan = planner.segment(from, segment.way.to, entry, exit, rates)?;
        let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
        let kind = MotionKind::Segment(segment);
        Ok(Start::of_arm(self, kind, plan.trajectory, alarm))
    }

    /// The rest of the segment under way with another speed at its end; `None` where that changes nothing or cannot be.
    pub(crate) fn replan_segment(&self, exit: f64) -> Option<Start> {
        let motion = self.motion.under_way.as_ref()?;
        let segment = self.motion.segment()?;
        if motion.alarm.is_some() || exit == motion.trajectory.exit_speed() {
            return None;
        }
        let rates = segment.look_ahead.rates(&segment.way.segment);
        let elapsed = motion.elapsed(self.now);
        let planner = self.planner_given_rates();
        let plan = planner.segment_rest(&motion.trajectory, elapsed, exit, rates);
        let plan = plan.ok()??;
        let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
        let kind = MotionKind::Segment(segment);
        Some(Start::of_arm(self, kind, plan.trajectory, alarm))
    }
}
