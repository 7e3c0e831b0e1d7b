//! The tool of a motion on a straight line, r alongside.

use crate::boundary::{Section, spatial_crossing};
use crate::law::Law;
use crate::profile::Profile;
use crate::{ArmState, Bound, Geometry, Limits, MotionError, Pose, Range, wrist};

/// The tool along a straight line, r alongside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineLeg {
    pub(crate) from: ArmState,
    pub(crate) to: ArmState,
    pub(crate) along: Law,
    pub(crate) turning: Profile,
}

impl LineLeg {
    /// The share of the way covered after `t` seconds.
    pub(crate) fn share(&self, t: f64) -> f64 {
        if self.along.length() > 0.0 {
            self.along.position(t) / self.along.length()
        } else {
            0.0
        }
    }

    /// The share covered a second at `t`.
    pub(crate) fn share_rate(&self, t: f64) -> f64 {
        if self.along.length() > 0.0 {
            self.along.velocity(t) / self.along.length()
        } else {
            0.0
        }
    }

    fn turn_sign(&self) -> f64 {
        libm::copysign(1.0, self.to.pose.r - self.from.pose.r)
    }

    /// The rate of r at `t`, deg/s.
    pub(crate) fn turn_rate(&self, t: f64) -> f64 {
        self.turn_sign() * self.turning.velocity(t)
    }

    fn pose_at(&self, t: f64) -> Pose {
        let (from, to) = (self.from.pose, self.to.pose);
        let share = self.share(t);
        Pose {
            x: from.x + (to.x - from.x) * share,
            y: from.y + (to.y - from.y) * share,
            z: from.z + (to.z - from.z) * share,
            r: from.r + self.turn_sign() * self.turning.position(t),
        }
    }

    pub(crate) fn tool_rate_at(&self, t: f64) -> Pose {
        let (from, to) = (self.from.pose, self.to.pose);
        let rate = self.share_rate(t);
        Pose {
            x: (to.x - from.x) * rate,
            y: (to.y - from.y) * rate,
            z: (to.z - from.z) * rate,
            r: self.turn_rate(t),
        }
    }

    /// The state at `t`. On the line all of which is known to be in reach the joints follow from the pose.
    pub(crate) fn state_at(&self, geometry: &Geometry, t: f64) -> ArmState {
        let pose = self.pose_at(t);
        let joints = geometry.inverse_at_edge(&pose);
        ArmState {
            pose,
            joints: joints.unwrap_or(self.from.joints),
        }
    }

    pub(crate) fn section(&self, geometry: &Geometry) -> Section {
        Section::new(geometry, &self.from.pose, &self.to.pose)
    }

    /// The times at which something of the leg ceases to be monotone, given the share nearest to the base axis.
    pub(crate) fn corners(&self, nearest: f64) -> [f64; 5] {
        let [a, b] = self.along.corners();
        let [c, d] = self.turning.corners();
        [
            a,
            b,
            c,
            d,
            self.along.time_at(nearest * self.along.length()),
        ]
    }

    /// Numbers that J4 stays below and above: known at once without a sideways tool, as J1 then turns one way
    /// only.
    pub(crate) fn j4_extremes(&self, geometry: &Geometry) -> (Option<f64>, Option<f64>) {
        if geometry.tool.y != 0.0 {
            return (None, None);
        }
        let (from, to) = (self.from, self.to);
        let above = from.pose.r.max(to.pose.r) - from.joints.j1.min(to.joints.j1);
        let below = from.pose.r.min(to.pose.r) - from.joints.j1.max(to.joints.j1);
        (Some(above), Some(below))
    }

    pub(crate) fn first_crossing(
        &self,
        geometry: &Geometry,
        limits: &Limits,
    ) -> Option<(f64, MotionError)> {
        let spatial = Limits {
            j4: Range::new(f64::NEG_INFINITY, f64::INFINITY),
            ..*limits
        };
        let duration = self.along.duration();
        let found = spatial_crossing(
            geometry,
            &spatial,
            [&self.from.pose, &self.to.pose],
            duration,
            |share| self.along.time_at(share * self.along.length()),
            |t| self.pose_at(t),
        );
        let end = found.map_or(duration, |(t, _)| t);
        let whole = found.is_none();
        wrist::first_crossing(self, geometry, limits, end, whole)
            .map(|t| (t, self.j4_violation(geometry, limits, t)))
            .or(found)
    }

    fn j4_violation(&self, geometry: &Geometry, limits: &Limits, t: f64) -> MotionError {
        let value = self.state_at(geometry, t).joints.j4;
        if value - limits.j4.min < limits.j4.max - value {
            limits.violation(Bound::J4Min, value)
        } else {
            limits.violation(Bound::J4Max, value)
        }
    }
}
