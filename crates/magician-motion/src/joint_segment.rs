//! Segment of a motion: each joint follows its own velocity profile.

use crate::axis_motion::AxisMotion;
use crate::crossing::{CrossingTimes, first_violation};
use crate::roots::quadratic;
use crate::velocity_profile::CORNERS;
use crate::{ArmState, Bound, Geometry, JointAngles, Limits, MotionError};

/// A motion in which each joint follows its own profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointSegment {
    pub(crate) from: ArmState,
    pub(crate) to: ArmState,
    pub(crate) axes: [AxisMotion; 4],
}

impl JointSegment {
    /// Creates the segment in which each joint follows its own profile, wherever that leads.
    pub(crate) fn following(geometry: &Geometry, from: &ArmState, axes: [AxisMotion; 4]) -> Self {
        let mut segment = Self {
            from: *from,
            to: *from,
            axes,
        };
        segment.to = ArmState::at_joints(geometry, &segment.joints_at(segment.duration()));
        segment
    }

    pub(crate) fn joints_at(&self, t: f64) -> JointAngles {
        let mut joints = self.from.joints.to_array();
        for (angle, axis) in joints.iter_mut().zip(&self.axes) {
            *angle += axis.offset(t);
        }
        joints.into()
    }

    pub(crate) fn duration(&self) -> f64 {
        self.axes
            .iter()
            .map(AxisMotion::duration)
            .fold(0.0, f64::max)
    }

    pub(crate) fn first_crossing(&self, limits: &Limits) -> Option<(f64, MotionError)> {
        if self.stays_within(limits) {
            return None;
        }
        let mut times = CrossingTimes::new();
        let wide = limits.widened_to(&self.from.joints);
        for bound in Bound::ALL {
            self.add_crossing_times(bound, limits.at(bound), &mut times);
            if wide.at(bound) != limits.at(bound) {
                self.add_crossing_times(bound, wide.at(bound), &mut times);
            }
        }
        let found = first_violation(limits, &self.from.joints, times, self.duration(), |t| {
            Ok(self.joints_at(t))
        });
        // An error should name the target that was requested, not the angle just past the bound.
        found.map(|(t, error)| match error {
            MotionError::Limit { bound, .. } if limits.is_violated(bound, &self.to.joints) => {
                (t, limits.violation(bound, bound.value(&self.to.joints)))
            }
            error => (t, error),
        })
    }

    /// True if the whole segment is within the limits. Each joint moves monotonically between its
    /// ends, but at its own pace, so the coupled bound is safe only if no pairing of J2 and J3
    /// violates it.
    fn stays_within(&self, limits: &Limits) -> bool {
        let (from, to) = (self.from.joints, self.to.joints);
        let pairing = |j2, j3| JointAngles { j2, j3, ..to };
        [from, to, pairing(from.j2, to.j3), pairing(to.j2, from.j3)]
            .iter()
            .all(|joints| limits.violations(joints).next().is_none())
    }

    /// Adds the times at which the angle of `bound` equals `angle`. Between the corners of the
    /// profiles the angle of `bound` is a quadratic of time.
    fn add_crossing_times(&self, bound: Bound, angle: f64, times: &mut CrossingTimes) {
        let [j1, j2, j3, j4] = &self.axes;
        let (axis, other) = match bound {
            Bound::J1Min | Bound::J1Max => (j1, None),
            Bound::J2Min | Bound::J2Max => (j2, None),
            Bound::J3Min | Bound::J3Max => (j3, None),
            Bound::J4Min | Bound::J4Max => (j4, None),
            Bound::J23Min | Bound::J23Max => (j2, Some(j3)),
        };
        let start = bound.value(&self.from.joints) - angle;
        let mut from = 0.0;
        for to in corners([axis, other.unwrap_or(axis)]) {
            if to > from {
                let around = 0.5 * (from + to);
                let [offset, velocity, acceleration] = [0, 1, 2].map(|nth| {
                    let of = |axis: &AxisMotion| {
                        axis.curve(around, from).get(nth).copied().unwrap_or(0.0)
                    };
                    of(axis) - other.map_or(0.0, of)
                });
                for root in quadratic(0.5 * acceleration, velocity, start + offset) {
                    if root >= 0.0 && from + root <= to {
                        times.add(from + root);
                    }
                }
                from = to;
            }
        }
    }

    /// Times between which every joint follows one piece of its curve.
    pub(crate) fn corners(&self) -> impl Iterator<Item = f64> {
        let [j1, j2, j3, j4] = &self.axes;
        corners([j1, j2, j3, j4])
    }

    /// Returns the state at `t`. A joint named by `stopped_by` is exactly at its bound.
    pub(crate) fn state_stopped_by(
        &self,
        geometry: &Geometry,
        t: f64,
        stopped_by: &MotionError,
    ) -> ArmState {
        let mut joints = self.joints_at(t);
        if let MotionError::Limit { bound, limit, .. } = *stopped_by {
            match bound {
                // The bound was not passed: the start was beyond it already, and the joint stays
                // there.
                _ if t <= 0.0 => {}
                Bound::J1Min | Bound::J1Max => joints.j1 = limit,
                Bound::J2Min | Bound::J2Max => joints.j2 = limit,
                Bound::J3Min | Bound::J3Max => joints.j3 = limit,
                Bound::J4Min | Bound::J4Max => joints.j4 = limit,
                Bound::J23Min | Bound::J23Max => joints.j3 = joints.j2 - limit,
            }
        }
        ArmState::at_joints(geometry, &joints)
    }
}

/// Corners and ends of these axes, in order.
fn corners<const N: usize>(axes: [&AxisMotion; N]) -> impl Iterator<Item = f64> {
    let mut corners = [f64::NAN; 4 * (CORNERS + 1)];
    let all = axes.into_iter().flat_map(AxisMotion::corners);
    for (slot, corner) in corners.iter_mut().zip(all) {
        *slot = corner;
    }
    corners.sort_unstable_by(f64::total_cmp);
    corners.into_iter().filter(|t| !t.is_nan())
}

impl JointSegment {
    /// Returns the joint that turns furthest, and its angle.
    pub(crate) fn dominant_axis(&self) -> (AxisMotion, f64) {
        let [first, ..] = self.axes;
        let sweep = |axis: &AxisMotion| libm::fabs(axis.offset(axis.duration()));
        self.axes
            .iter()
            .map(|axis| (*axis, sweep(axis)))
            .fold(
                (first, 0.0),
                |best, next| if next.1 > best.1 { next } else { best },
            )
    }
}
