//! One stretch of a motion: geometry and speed law together.

use crate::arc_leg::ArcLeg;
use crate::joint_leg::{Axis, JointLeg};
use crate::line_leg::LineLeg;
use crate::segment_leg::SegmentLeg;
use crate::tool_path::ToolPath;
use crate::{ArmState, Geometry, Limits, MotionError, Pose, apex};

/// What a leg is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Leg {
    /// Every joint by a law of its own.
    Joints(JointLeg),
    /// The tool along a straight line, r alongside.
    Line(LineLeg),
    /// The tool along a circular arc, r alongside.
    Arc(ArcLeg),
    /// The tool along a segment of a continuous path, joint 4 at rest.
    Segment(SegmentLeg),
}

impl Leg {
    pub(crate) fn duration(&self) -> f64 {
        match self {
            Self::Joints(leg) => leg.duration(),
            Self::Line(leg) => leg.along.duration(),
            Self::Arc(leg) => leg.along.duration(),
            Self::Segment(leg) => leg.along.duration(),
        }
    }

    pub(crate) fn end(&self) -> ArmState {
        match self {
            Self::Joints(leg) => leg.to,
            Self::Line(leg) => leg.to,
            Self::Arc(leg) => leg.to,
            Self::Segment(leg) => leg.to,
        }
    }

    /// The state after `t` seconds: exactly the start's and the end's at either end.
    pub(crate) fn state_at(&self, geometry: &Geometry, t: f64) -> ArmState {
        if t >= self.duration() {
            return self.end();
        }
        match self {
            Self::Joints(leg) if t <= 0.0 => leg.from,
            Self::Line(leg) if t <= 0.0 => leg.from,
            Self::Arc(leg) if t <= 0.0 => leg.from,
            Self::Joints(leg) => ArmState::at_joints(geometry, &leg.joints_at(t)),
            Self::Line(leg) => leg.state_at(geometry, t),
            Self::Arc(leg) => leg.state_at(geometry, t),
            // It may begin in the middle of its segment, and knows where.
            Self::Segment(leg) => leg.state_at(geometry, t),
        }
    }

    /// The state in which a motion stops that the limits end after `t` seconds.
    pub(crate) fn state_stopped_by(
        &self,
        geometry: &Geometry,
        t: f64,
        stopped_by: &MotionError,
    ) -> ArmState {
        match self {
            Self::Joints(leg) => leg.state_stopped_by(geometry, t, stopped_by),
            Self::Line(_) | Self::Arc(_) | Self::Segment(_) => self.state_at(geometry, t),
        }
    }

    /// The joints' velocities after `t` seconds, deg/s.
    pub(crate) fn joint_velocities(&self, geometry: &Geometry, t: f64) -> [f64; 4] {
        if t < 0.0 || t >= self.duration() {
            return [0.0; 4];
        }
        match self {
            Self::Joints(leg) => leg.axes.map(|axis| axis.velocity(t)),
            Self::Line(leg) => {
                let state = leg.state_at(geometry, t);
                geometry.joint_velocities(&state.joints, &state.pose, &leg.tool_rate_at(t))
            }
            Self::Arc(leg) => {
                let state = leg.state_at(geometry, t);
                geometry.joint_velocities(&state.joints, &state.pose, &leg.tool_rate_at(t))
            }
            Self::Segment(leg) => leg.joint_velocities(geometry, t),
        }
    }

    /// The tool's velocity after `t` seconds, mm/s, and r's, deg/s.
    pub(crate) fn tool_rate(&self, geometry: &Geometry, t: f64) -> Pose {
        if t < 0.0 || t >= self.duration() {
            return Pose::default();
        }
        match self {
            Self::Joints(leg) => {
                let velocities = leg.axes.map(|axis| axis.velocity(t));
                geometry.tool_rate(&leg.joints_at(t), velocities)
            }
            Self::Line(leg) => leg.tool_rate_at(t),
            Self::Arc(leg) => leg.tool_rate_at(t),
            Self::Segment(leg) => leg.tool_rate_at(geometry, t),
        }
    }

    /// When the leg first leaves the limits or the reach of the arm, seconds, and how.
    pub(crate) fn first_crossing(
        &self,
        geometry: &Geometry,
        limits: &Limits,
    ) -> Option<(f64, MotionError)> {
        match self {
            Self::Joints(leg) => leg.first_crossing(limits),
            Self::Line(leg) => leg.first_crossing(geometry, limits),
            Self::Arc(leg) => leg.first_crossing(geometry, limits),
            Self::Segment(leg) => leg.first_crossing(geometry, limits),
        }
    }

    /// How far the tool rises above `ceiling` on the way, mm; both ends are taken to be below it.
    pub(crate) fn excess(&self, geometry: &Geometry, ceiling: f64) -> Option<f64> {
        match self {
            Self::Joints(leg) => apex::above(leg, geometry, ceiling).map(|top| top - ceiling),
            Self::Line(_) | Self::Arc(_) | Self::Segment(_) => None,
        }
    }

    /// How much the leg counts in a motion of several, mm: the way between its ends, round the arc; degrees if there
    /// is none.
    pub(crate) fn weight(&self) -> f64 {
        match self {
            Self::Joints(leg) => {
                let way = leg.from.pose.distance_to(&leg.to.pose);
                if way >= SHORTEST_MOVE {
                    way
                } else {
                    leg.governing().1
                }
            }
            Self::Line(leg) if leg.along.length() >= SHORTEST_MOVE => leg.along.length(),
            Self::Line(leg) => leg.turning.length(),
            Self::Arc(leg) => leg.along.length(),
            Self::Segment(leg) => leg.along.length(),
        }
    }

    fn governing(&self) -> Axis {
        match self {
            Self::Joints(leg) => leg.governing().0,
            Self::Line(leg) if leg.along.length() >= SHORTEST_MOVE => Axis::Running(1.0, leg.along),
            Self::Line(leg) => Axis::Travelling(1.0, leg.turning),
            Self::Arc(leg) => Axis::Travelling(1.0, leg.along),
            Self::Segment(leg) => Axis::Running(1.0, leg.along),
        }
    }

    /// The same leg in a longer time. What begins or ends with speed is not slowed.
    pub(crate) fn lasting(mut self, duration: f64) -> Self {
        match &mut self {
            Self::Joints(JointLeg { axes, .. }) => {
                for axis in axes {
                    if let Axis::Travelling(_, profile) = axis {
                        *profile = profile.stretched(duration);
                    }
                }
            }
            Self::Line(LineLeg { along, turning, .. }) => {
                *along = along.stretched(duration);
                *turning = turning.stretched(duration);
            }
            Self::Arc(ArcLeg { along, turning, .. }) => {
                *along = along.stretched(duration);
                *turning = turning.stretched(duration);
            }
            Self::Segment(SegmentLeg { along, .. }) => *along = along.stretched(duration),
        }
        self
    }

    /// The share of the leg done after `t` seconds.
    pub(crate) fn progress(&self, t: f64) -> f64 {
        let axis = self.governing();
        let whole = axis.offset(axis.duration());
        if whole == 0.0 || t >= self.duration() {
            1.0
        } else {
            axis.offset(t) / whole
        }
    }

    /// When a share of the leg is done, seconds.
    pub(crate) fn time_at(&self, progress: f64) -> f64 {
        match self.governing() {
            Axis::Travelling(_, profile) => profile.time_at(progress * profile.length()),
            Axis::Running(_, law) => law.time_at(progress * law.length()),
            Axis::Braking(braking) => {
                braking.duration() * (1.0 - libm::sqrt((1.0 - progress).max(0.0)))
            }
        }
    }
}

/// A motion shorter than this takes no time, mm or degrees (model section 7).
pub(crate) const SHORTEST_MOVE: f64 = 1e-4;
