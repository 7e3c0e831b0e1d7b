//! Segment of a motion: the tool on a straight line, r along with it.

use crate::boundary::{Section, spatial_cuts};
use crate::tool_path::{MAX_CORNERS, ToolPath, moments};
use crate::velocity_profile::VelocityProfile;
use crate::wrist::{Interval, speeds};
use crate::{ArmState, Geometry, Limits, Pose};

/// The tool on a straight line, while r turns by its own profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineSegment {
    pub(crate) from: ArmState,
    pub(crate) to: ArmState,
    pub(crate) along: VelocityProfile,
    pub(crate) turning: VelocityProfile,
}

impl LineSegment {
    /// Share of the length covered after `t` seconds.
    pub(crate) fn share(&self, t: f64) -> f64 {
        if self.along.length() > 0.0 {
            self.along.position(t) / self.along.length()
        } else {
            0.0
        }
    }

    /// Share of the length covered per second at `t`.
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

    /// Rate of r at `t`, deg/s.
    pub(crate) fn turn_rate(&self, t: f64) -> f64 {
        self.turn_sign() * self.turning.velocity(t)
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

    fn section(&self, geometry: &Geometry) -> Section {
        Section::new(geometry, &self.from.pose, &self.to.pose)
    }
}

impl ToolPath for LineSegment {
    fn start(&self) -> &ArmState {
        &self.from
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

    fn horizon(&self) -> f64 {
        self.along.duration()
    }

    fn spatial_cuts(
        &self,
        geometry: &Geometry,
        strict: &Limits,
        wide: &Limits,
        report: &mut impl FnMut(f64),
    ) {
        spatial_cuts(&self.section(geometry), strict, wide, &mut |share| {
            if share > 0.0 && share < 1.0 {
                report(self.along.time_at(share * self.along.length()));
            }
        });
    }

    /// Without a sideways bias J1 turns one way only, so its extremes are at the ends.
    fn j4_extremes(&self, geometry: &Geometry) -> (Option<f64>, Option<f64>) {
        if geometry.tool.y != 0.0 {
            return (None, None);
        }
        let (from, to) = (self.from, self.to);
        let above = from.pose.r.max(to.pose.r) - from.joints.j1.min(to.joints.j1);
        let below = from.pose.r.min(to.pose.r) - from.joints.j1.max(to.joints.j1);
        (Some(above), Some(below))
    }

    /// Adds the point closest to the base axis: up to it, and from it on, everything is monotone.
    fn corners(&self, geometry: &Geometry) -> [f64; MAX_CORNERS] {
        let nearest = self.section(geometry).nearest() * self.along.length();
        moments(&self.along, &self.turning, self.along.time_at(nearest))
    }

    /// The squared radius and its slope are monotone as well, so their values at both ends enclose
    /// them.
    fn j4_rates(&self, geometry: &Geometry, a: f64, b: f64) -> (f64, f64) {
        let section = self.section(geometry);
        let ends = |function: &dyn Fn(f64) -> f64| Interval::over(function(a), function(b));
        let square = ends(&|t| section.square(self.share(t)).0.max(0.0));
        let slope = ends(&|t| section.square(self.share(t)).1);
        let across = geometry.tool.y;
        let turning = if across == 0.0 {
            Interval::over(section.swept(), section.swept())
        } else {
            slope
                .times(&Interval::over(0.5 * across, 0.5 * across))
                .over_positive(&Interval(libm::sqrt(square.0), libm::sqrt(square.1)))
                .plus(section.swept())
        };
        let way = self.along.length();
        let share_rate = if way > 0.0 {
            speeds(&self.along, a, b).times(&Interval::over(1.0 / way, 1.0 / way))
        } else {
            Interval(0.0, 0.0)
        };
        let j1 = turning
            .over_positive(&square.plus(across * across))
            .times(&share_rate);
        let sign = self.turn_sign();
        Interval::j4(
            &speeds(&self.turning, a, b).times(&Interval::over(sign, sign)),
            &j1,
        )
    }
}
