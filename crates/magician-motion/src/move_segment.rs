//! Segment of a motion: path and velocity profile together.

use crate::arc_segment::ArcSegment;
use crate::joint_segment::JointSegment;
use crate::line_segment::LineSegment;
use crate::path_segment::PathSegment;
use crate::tool_path::ToolPath;
use crate::trajectory::microseconds;
use crate::velocity_profile::VelocityProfile;
use crate::{ArmState, Geometry, Limits, MotionError, Pose, apex};

/// Kind of path of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MoveSegment {
    /// Each joint by its own profile.
    Joints(JointSegment),
    /// The tool on a straight line, r along with it.
    Line(LineSegment),
    /// The tool on a circular arc, r along with it.
    Arc(ArcSegment),
    /// The tool on a segment of a continuous path, joint 4 at rest.
    Path(PathSegment),
}

impl MoveSegment {
    pub(crate) fn duration(&self) -> f64 {
        match self {
            Self::Joints(segment) => segment.duration(),
            Self::Line(segment) => segment.along.duration(),
            Self::Arc(segment) => segment.along.duration(),
            Self::Path(segment) => segment.along.duration(),
        }
    }

    /// Times between start and end at which the curve is not smooth, in order, microseconds. A
    /// straight line is smooth at any speed.
    pub(crate) fn corners_us(&self) -> impl Iterator<Item = u64> {
        let joints = match self {
            Self::Joints(segment) => Some(segment.corners()),
            Self::Line(_) | Self::Arc(_) | Self::Path(_) => None,
        };
        let arc = match self {
            Self::Arc(segment) => Some(segment.along.corners()),
            Self::Joints(_) | Self::Line(_) | Self::Path(_) => None,
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
            Self::Path(segment) => segment.to,
        }
    }

    /// State after `t` seconds. Start and end are exact.
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
            // The rest of a segment starts in its middle, and computes its own start.
            Self::Path(segment) => segment.state_at(geometry, t),
        }
    }

    /// State in which a motion stops if the limits end it after `t` seconds.
    pub(crate) fn state_stopped_by(
        &self,
        geometry: &Geometry,
        t: f64,
        stopped_by: &MotionError,
    ) -> ArmState {
        match self {
            Self::Joints(segment) => segment.state_stopped_by(geometry, t, stopped_by),
            Self::Line(_) | Self::Arc(_) | Self::Path(_) => self.state_at(geometry, t),
        }
    }

    /// Velocities of the joints after `t` seconds, deg/s.
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
            Self::Path(segment) => segment.joint_velocities(geometry, t),
        }
    }

    /// Velocity of the tool after `t` seconds, mm/s, and of r, deg/s.
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
            Self::Path(segment) => segment.tool_rate_at(geometry, t),
        }
    }

    /// Returns the time at which the segment first leaves the limits or the reach, seconds, and the
    /// cause.
    pub(crate) fn first_crossing(
        &self,
        geometry: &Geometry,
        limits: &Limits,
    ) -> Option<(f64, MotionError)> {
        match self {
            Self::Joints(segment) => segment.first_crossing(limits),
            Self::Line(segment) => segment.first_crossing(geometry, limits),
            Self::Arc(segment) => segment.first_crossing(geometry, limits),
            Self::Path(segment) => segment.first_crossing(geometry, limits),
        }
    }

    /// Height of the tool above `ceiling` at the highest point, mm; `None` if it stays below. Both
    /// ends are assumed to be below.
    pub(crate) fn overshoot(&self, geometry: &Geometry, ceiling: f64) -> Option<f64> {
        match self {
            Self::Joints(segment) => {
                apex::above(segment, geometry, ceiling).map(|top| top - ceiling)
            }
            Self::Line(_) | Self::Arc(_) | Self::Path(_) => None,
        }
    }

    /// Weight of the segment in the progress of a motion: the distance between its ends or the
    /// length of the arc, mm; degrees if the tool does not move.
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
            Self::Path(segment) => segment.along.length(),
        }
    }

    /// Profile that measures the progress of the segment.
    fn dominant_profile(&self) -> VelocityProfile {
        match self {
            Self::Joints(segment) => *segment.dominant_axis().0.profile(),
            Self::Line(segment) if segment.along.length() >= SHORTEST_MOVE => segment.along,
            Self::Line(segment) => segment.turning,
            Self::Arc(segment) => segment.along,
            Self::Path(segment) => segment.along,
        }
    }

    /// Stretches the segment. A segment that begins or ends with speed is not slowed.
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
            Self::Path(PathSegment { along, .. }) => *along = along.stretched(duration),
        }
        self
    }

    /// Share of the segment done after `t` seconds.
    pub(crate) fn progress(&self, t: f64) -> f64 {
        let profile = self.dominant_profile();
        if profile.length() == 0.0 || t >= self.duration() {
            1.0
        } else {
            profile.position(t) / profile.length()
        }
    }

    /// Time at which a share of the segment is done, seconds.
    pub(crate) fn time_at(&self, progress: f64) -> f64 {
        let profile = self.dominant_profile();
        profile.time_at(progress * profile.length())
    }
}

/// Shortest motion, mm or degrees. A shorter one takes no time (model section 7).
pub(crate) const SHORTEST_MOVE: f64 = 1e-4;
