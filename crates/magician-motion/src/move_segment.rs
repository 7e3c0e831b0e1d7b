//! One stretch of a motion: geometry and velocity profile together.

use crate::arc_segment::ArcSegment;
use crate::joint_segment::JointSegment;
use crate::line_segment::LineSegment;
use crate::path_segment::PathSegment;
use crate::tool_path::ToolPath;
use crate::trajectory::microseconds;
use crate::velocity_profile::VelocityProfile;
use crate::{ArmState, Geometry, Limits, MotionError, Pose, apex};

/// What a segment is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MoveSegment {
    /// Every joint by a profile of its own.
    Joints(JointSegment),
    /// The tool along a straight line, r alongside.
    Line(LineSegment),
    /// The tool along a circular arc, r alongside.
    Arc(ArcSegment),
    /// The tool along a segment of a continuous path, joint 4 at rest.
    Segment(PathSegment),
}

impl MoveSegment {
    pub(crate) fn duration(&self) -> f64 {
        match self {
            Self::Joints(segment) => segment.duration(),
            Self::Line(segment) => segment.along.duration(),
            Self::Arc(segment) => segment.along.duration(),
            Self::Segment(segment) => segment.along.duration(),
        }
    }

    /// The moments between start and end, in turn, at which the curve is not smooth, microseconds. A straight way is one
    /// whatever its speed.
    pub(crate) fn corners_us(&self) -> impl Iterator<Item = u64> {
        let joints = match self {
            Self::Joints(segment) => Some(segment.corners()),
            Self::Line(_) | Self::Arc(_) | Self::Segment(_) => None,
        };
        let arc = match self {
            Self::Arc(segment) => Some(segment.along.corners()),
            Self::Joints(_) | Self::Line(_) | Self::Segment(_) => None,
        };
        let corners = joints
            .into_iter()
            .flatten()
            .chain(arc.into_iter().flatten());
        corners.filter(|t| !t.is_nan()).map(microseconds)
    }

    pub(crate) fn end(&self) -> ArmState {
        match self {
            Self::Joints(segment) => segment.to,
            Self::Line(segment) => segment.to,
            Self::Arc(segment) => segment.to,
            Self::Segment(segment) => segment.to,
        }
    }

    /// The state after `t` seconds: exactly the start's and the end's at either end.
    pub(crate) fn state_at(&self, geometry: &Geometry, t: f64) -> ArmState {
        if t >= self.duration() {
            return self.end();
        }
        match self {
            Self::Joints(segment) if t <= 0.0 => segment.from,
            Self::Line(segment) if t <= 0.0 => segment.from,
            Self::Arc(segment) if t <= 0.0 => segment.from,
            Self::Joints(segment) => ArmState::at_joints(geometry, &segment.joints_at(t)),
            Self::Line(segment) => segment.state_at(geometry, t),
            Self::Arc(segment) => segment.state_at(geometry, t),
            // It may begin in the middle of its segment, and knows where.
            Self::Segment(segment) => segment.state_at(geometry, t),
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
            Self::Joints(segment) => segment.state_stopped_by(geometry, t, stopped_by),
            Self::Line(_) | Self::Arc(_) | Self::Segment(_) => self.state_at(geometry, t),
        }
    }

    /// The joints' velocities after `t` seconds, deg/s.
    pub(crate) fn joint_velocities(&self, geometry: &Geometry, t: f64) -> [f64; 4] {
        if t < 0.0 || t >= self.duration() {
            return [0.0; 4];
        }
        match self {
            Self::Joints(segment) => segment.axes.map(|axis| axis.velocity(t)),
            Self::Line(segment) => {
                let state = segment.state_at(geometry, t);
                geometry.joint_velocities(&state.joints, &state.pose, &segment.tool_rate_at(t))
            }
            Self::Arc(segment) => {
                let state = segment.state_at(geometry, t);
                geometry.joint_velocities(&state.joints, &state.pose, &segment.tool_rate_at(t))
            }
            Self::Segment(segment) => segment.joint_velocities(geometry, t),
        }
    }

    /// The tool's velocity after `t` seconds, mm/s, and r's, deg/s.
    pub(crate) fn tool_rate(&self, geometry: &Geometry, t: f64) -> Pose {
        if t < 0.0 || t >= self.duration() {
            return Pose::default();
        }
        match self {
            Self::Joints(segment) => {
                let velocities = segment.axes.map(|axis| axis.velocity(t));
                geometry.tool_rate(&segment.joints_at(t), velocities)
            }
            Self::Line(segment) => segment.tool_rate_at(t),
            Self::Arc(segment) => segment.tool_rate_at(t),
            Self::Segment(segment) => segment.tool_rate_at(geometry, t),
        }
    }

    /// When the segment first leaves the limits or the reach of the arm, seconds, and how.
    pub(crate) fn first_crossing(
        &self,
        geometry: &Geometry,
        limits: &Limits,
    ) -> Option<(f64, MotionError)> {
        match self {
            Self::Joints(segment) => segment.first_crossing(limits),
            Self::Line(segment) => segment.first_crossing(geometry, limits),
            Self::Arc(segment) => segment.first_crossing(geometry, limits),
            Self::Segment(segment) => segment.first_crossing(geometry, limits),
        }
    }

    /// How far the tool rises above `ceiling` on the way, mm; both ends are taken to be below it.
    pub(crate) fn overshoot(&self, geometry: &Geometry, ceiling: f64) -> Option<f64> {
        match self {
            Self::Joints(segment) => {
                apex::above(segment, geometry, ceiling).map(|top| top - ceiling)
            }
            Self::Line(_) | Self::Arc(_) | Self::Segment(_) => None,
        }
    }

    /// How much the segment counts in a motion of several, mm: the way between its ends, round the arc; degrees if there
    /// is none.
    pub(crate) fn arc_length(&self) -> f64 {
        match self {
            Self::Joints(segment) => {
                let way = segment.from.pose.distance_to(&segment.to.pose);
                if way >= SHORTEST_MOVE {
                    way
                } else {
                    segment.dominant_axis().1
                }
            }
            Self::Line(segment) if segment.along.length() >= SHORTEST_MOVE => {
                segment.along.length()
            }
            Self::Line(segment) => segment.turning.length(),
            Self::Arc(segment) => segment.along.length(),
            Self::Segment(segment) => segment.along.length(),
        }
    }

    /// The profile that the progress of the segment is measured by.
    fn dominant_profile(&self) -> VelocityProfile {
        match self {
            Self::Joints(segment) => *segment.dominant_axis().0.profile(),
            Self::Line(segment) if segment.along.length() >= SHORTEST_MOVE => segment.along,
            Self::Line(segment) => segment.turning,
            Self::Arc(segment) => segment.along,
            Self::Segment(segment) => segment.along,
        }
    }

    /// The same segment in a longer time. What begins or ends with speed is not slowed.
    pub(crate) fn lasting(mut self, duration: f64) -> Self {
        match &mut self {
            Self::Joints(JointSegment { axes, .. }) => {
                for axis in axes {
                    *axis = axis.stretched(duration);
                }
            }
            Self::Line(LineSegment { along, turning, .. }) => {
                *along = along.stretched(duration);
                *turning = turning.stretched(duration);
            }
            Self::Arc(ArcSegment { along, turning, .. }) => {
                *along = along.stretched(duration);
                *turning = turning.stretched(duration);
            }
            Self::Segment(PathSegment { along, .. }) => *along = along.stretched(duration),
        }
        self
    }

    /// The share of the segment done after `t` seconds.
    pub(crate) fn progress(&self, t: f64) -> f64 {
        let profile = self.dominant_profile();
        if profile.length() == 0.0 || t >= self.duration() {
            1.0
        } else {
            profile.position(t) / profile.length()
        }
    }

    /// When a share of the segment is done, seconds.
    pub(crate) fn time_at(&self, progress: f64) -> f64 {
        let profile = self.dominant_profile();
        profile.time_at(progress * profile.length())
    }
}

/// A motion shorter than this takes no time, mm or degrees (model section 7).
pub(crate) const SHORTEST_MOVE: f64 = 1e-4;
