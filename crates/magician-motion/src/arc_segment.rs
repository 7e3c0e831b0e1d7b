//! Segment of a motion: the tool moves on a circular arc while r turns.

use crate::angle::atan2;
use crate::arc::Arc;
use crate::arc_reach::{Outline, spatial_cuts};
use crate::tool_path::{MAX_CORNERS, ToolPath, moments};
use crate::velocity_profile::VelocityProfile;
use crate::wrist::{Interval, speeds};
use crate::{ArmState, Geometry, Limits, Pose};

/// The tool on a circular arc, possibly several times round, while r turns by its own profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ArcSegment {
    pub(crate) from: ArmState,
    pub(crate) to: ArmState,
    pub(crate) arc: Arc,
    pub(crate) along: VelocityProfile,
    pub(crate) turning: VelocityProfile,
}

impl ArcSegment {
    fn turn_sign(&self) -> f64 {
        libm::copysign(1.0, self.to.pose.r - self.from.pose.r)
    }

    /// Rate of r at `t`, deg/s.
    fn turn_rate(&self, t: f64) -> f64 {
        self.turn_sign() * self.turning.velocity(t)
    }

    /// Velocity of the tool at `t`, mm/s and deg/s.
    pub(crate) fn tool_rate_at(&self, t: f64) -> Pose {
        let velocity = self.along.velocity(t);
        let [x, y, z] = self.arc.point_at(self.along.position(t)).along;
        Pose {
            x: x * velocity,
            y: y * velocity,
            z: z * velocity,
            r: self.turn_rate(t),
        }
    }

    /// Length until the end, or until the path repeats itself, mm.
    fn lap(&self) -> f64 {
        self.along.length().min(self.arc.circumference())
    }

    /// Bounds of J1 on the whole path; `None` if the tool may touch the base axis.
    ///
    /// The tool stays in a ball around the middle of the path. Seen from the base axis, this ball
    /// subtends a known angle.
    fn j1_bounds(&self, geometry: &Geometry) -> Option<Interval> {
        let half_lap = 0.5 * self.lap();
        let [x, y, _] = self.arc.point_at(half_lap).at;
        let (ball, distance) = (self.arc.max_chord(half_lap), libm::sqrt(x * x + y * y));
        let across = geometry.tool.y;
        let near = distance - ball;
        if near <= libm::fabs(across) {
            return None;
        }
        // Angle at the base axis of a right triangle, given the opposite side and the hypotenuse.
        let angle = |opposite: f64, longest: f64| {
            atan2(
                opposite,
                libm::sqrt(longest * longest - opposite * opposite),
            )
        };
        let cone = angle(ball, distance);
        let bias = Interval::over(angle(across, near), angle(across, distance + ball));
        let heading = atan2(y, x);
        let j1 = Interval(heading - cone - bias.1, heading + cone - bias.0);
        // Beyond half a turn `atan2` may jump by 360 degrees.
        (libm::fabs(heading) + cone < 180.0).then_some(j1)
    }
}

impl ToolPath for ArcSegment {
    fn start(&self) -> &ArmState {
        &self.from
    }

    fn pose_at(&self, t: f64) -> Pose {
        let [x, y, z] = self.arc.point_at(self.along.position(t)).at;
        let r = self.from.pose.r + self.turn_sign() * self.turning.position(t);
        Pose { x, y, z, r }
    }

    /// Time at the end of the first lap. Only a circle repeats itself, and on a circle r is
    /// constant.
    fn horizon(&self) -> f64 {
        self.along.time_at(self.lap())
    }

    fn spatial_cuts(
        &self,
        geometry: &Geometry,
        strict: &Limits,
        wide: &Limits,
        report: &mut impl FnMut(f64),
    ) {
        let lap = self.lap();
        spatial_cuts(&self.arc, lap, geometry, (strict, wide), &mut |distance| {
            if distance > 0.0 && distance < lap {
                report(self.along.time_at(distance));
            }
        });
    }

    fn j4_extremes(&self, geometry: &Geometry) -> (Option<f64>, Option<f64>) {
        let Some(j1) = self.j1_bounds(geometry) else {
            return (None, None);
        };
        let (from, to) = (self.from.pose.r, self.to.pose.r);
        (Some(from.max(to) - j1.0), Some(from.min(to) - j1.1))
    }

    fn corners(&self, _: &Geometry) -> [f64; MAX_CORNERS] {
        moments(&self.along, &self.turning, f64::NAN)
    }

    fn j4_rates(&self, geometry: &Geometry, a: f64, b: f64) -> (f64, f64) {
        let (from, to) = (self.along.position(a), self.along.position(b));
        let middle = 0.5 * (from + to);
        let place = self.arc.point_at(middle);
        let outline = Outline::new(&self.arc, geometry, &place, 0.5 * (to - from));
        let Some(turning) = outline.turning(&place, geometry.tool.y) else {
            return (f64::NEG_INFINITY, f64::INFINITY);
        };
        let speed = speeds(&self.along, a, b);
        let r =
            speeds(&self.turning, a, b).times(&Interval::over(self.turn_sign(), self.turn_sign()));
        Interval::j4(&r, &turning.times(&speed))
    }
}
