//! Segment of a continuous path, or the rest of one. Joint 4 does not move, so r changes with joint
//! 1 (model section 8).

use crate::angle::DEGREES_PER_RADIAN;
use crate::boundary::{Section, spatial_cuts};
use crate::tool_path::spatial_crossing;
use crate::velocity_profile::VelocityProfile;
use crate::{ArmState, Geometry, Limits, MotionError, Pose, Range};

/// The tool on a straight segment, from a position on it to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathSegment {
    /// Both ends of the whole segment, wherever on it this one starts.
    pub(crate) from: ArmState,
    pub(crate) to: ArmState,
    /// Length of the whole segment, mm.
    pub(crate) length: f64,
    /// Length done before, mm.
    pub(crate) done: f64,
    /// Profile of the remaining length.
    pub(crate) along: VelocityProfile,
}

impl PathSegment {
    /// Replans the rest of the segment from `t` on, with a new profile from the present speed.
    pub(crate) fn rest(&self, t: f64, profile: impl FnOnce(f64, f64) -> VelocityProfile) -> Self {
        let done = self.done + self.along.position(t);
        Self {
            done,
            along: profile(self.length - done, self.along.velocity(t)),
            ..*self
        }
    }

    /// Position of the tool at `t`; r is that of the start, the caller computes it from the joints.
    fn place_at(&self, t: f64) -> Pose {
        let (from, to) = (self.from.pose, self.to.pose);
        let share = (self.done + self.along.position(t)) / self.length;
        Pose {
            x: from.x + (to.x - from.x) * share,
            y: from.y + (to.y - from.y) * share,
            z: from.z + (to.z - from.z) * share,
            r: from.r,
        }
    }

    /// State at `t`. The segment is known to be in reach, so the joints follow from the position.
    pub(crate) fn state_at(&self, geometry: &Geometry, t: f64) -> ArmState {
        if t <= 0.0 && self.done <= 0.0 {
            return self.from;
        }
        let place = self.place_at(t);
        let mut joints = geometry.inverse_at_edge(&place).unwrap_or(self.from.joints);
        joints.j4 = self.from.joints.j4;
        let r = joints.j1 + joints.j4;
        ArmState {
            joints,
            pose: Pose { r, ..place },
        }
    }

    /// Velocity of the tool at `t`, without r.
    fn place_rate_at(&self, t: f64) -> Pose {
        let (from, to) = (self.from.pose, self.to.pose);
        let rate = self.along.velocity(t) / self.length;
        Pose {
            x: (to.x - from.x) * rate,
            y: (to.y - from.y) * rate,
            z: (to.z - from.z) * rate,
            r: 0.0,
        }
    }

    pub(crate) fn joint_velocities(&self, geometry: &Geometry, t: f64) -> [f64; 4] {
        let state = self.state_at(geometry, t);
        let rate = self.place_rate_at(t);
        let [j1, j2, j3, _] = geometry.joint_velocities(&state.joints, &state.pose, &rate);
        [j1, j2, j3, 0.0]
    }

    pub(crate) fn tool_rate_at(&self, geometry: &Geometry, t: f64) -> Pose {
        let [r, ..] = self.joint_velocities(geometry, t);
        Pose {
            r,
            ..self.place_rate_at(t)
        }
    }

    pub(crate) fn first_crossing(
        &self,
        geometry: &Geometry,
        limits: &Limits,
    ) -> Option<(f64, MotionError)> {
        if self.is_clearly_within(geometry, limits) {
            return None;
        }
        // Joint 4 does not move, so a start beyond its limit leads no further out.
        let spatial = limits.without_j4();
        let section = Section::new(geometry, &self.from.pose, &self.to.pose);
        spatial_crossing(
            geometry,
            &spatial,
            self.along.duration(),
            |t| self.place_at(t),
            |wide, report| {
                spatial_cuts(&section, &spatial, wide, &mut |share| {
                    if share > 0.0 && share < 1.0 {
                        report(self.along.time_at(share * self.length - self.done));
                    }
                });
            },
        )
    }

    /// True if the margins at both ends rule out that a point between them violates a limit.
    ///
    /// A link turns by at most the distance over its length times the cosine of J2 - J3, and no
    /// point is further than half the length from an end. While J2 - J3 is within its limits its
    /// cosine is above the chord, so the margins for it keep it there. J1 turns one way only. Most
    /// segments of a drawing pass this test and need no search.
    fn is_clearly_within(&self, geometry: &Geometry, limits: &Limits) -> bool {
        let coupling = limits.j2_minus_j3;
        let chord = 1.0 - coupling.max.max(-coupling.min) / 90.0;
        let Pose { x, y, .. } = self.from.pose;
        let turns_little = x * x + y * y > 4.0 * self.length * self.length;
        if geometry.tool.y != 0.0 || chord <= 0.0 || !turns_little {
            return false;
        }
        let turn = 0.5 * self.length * DEGREES_PER_RADIAN / chord;
        let (rear, fore) = (turn / geometry.rear_arm, turn / geometry.forearm);
        let within = |angle: f64, range: Range, margin: f64| {
            angle >= range.min + margin && angle <= range.max - margin
        };
        [self.from.joints, self.to.joints].iter().all(|joints| {
            within(joints.j1, limits.j1, 0.0)
                && within(joints.j2, limits.j2, rear)
                && within(joints.j3, limits.j3, fore)
                && within(joints.j2 - joints.j3, coupling, rear + fore)
        })
    }
}
