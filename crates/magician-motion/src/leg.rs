//! One stretch of a motion from rest to rest, or from speed to rest: geometry and speed law together.

use crate::boundary::{Section, spatial_cuts};
use crate::profile::{Braking, Profile};
use crate::roots::{Moments, quadratic};
use crate::{ArmState, Bound, Geometry, JointAngles, Limits, MotionError, Pose, Range, wrist};

/// What a leg is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Leg {
    /// Every joint by a law of its own.
    Joints(JointLeg),
    /// The tool along a straight line, r alongside.
    Line(LineLeg),
}

/// Every joint by a law of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointLeg {
    pub(crate) from: ArmState,
    pub(crate) to: ArmState,
    pub(crate) axes: [Axis; 4],
}

/// The law of one joint: how far it has gone from where it started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Axis {
    /// From rest to rest, forwards (1) or backwards (-1).
    Travelling(f64, Profile),
    /// From speed to rest.
    Braking(Braking),
}

impl Axis {
    fn offset(&self, t: f64) -> f64 {
        match self {
            Self::Travelling(sign, profile) => sign * profile.position(t),
            Self::Braking(braking) => braking.position(t),
        }
    }

    fn velocity(&self, t: f64) -> f64 {
        match self {
            Self::Travelling(sign, profile) => sign * profile.velocity(t),
            Self::Braking(braking) => braking.velocity(t),
        }
    }

    fn acceleration(&self, t: f64) -> f64 {
        match self {
            Self::Travelling(sign, profile) => sign * profile.acceleration(t),
            Self::Braking(braking) => braking.acceleration(t),
        }
    }

    fn duration(&self) -> f64 {
        match self {
            Self::Travelling(_, profile) => profile.duration(),
            Self::Braking(braking) => braking.duration(),
        }
    }

    fn corners(&self) -> [f64; 3] {
        match self {
            Self::Travelling(_, profile) => {
                let [first, second] = profile.corners();
                [first, second, profile.duration()]
            }
            Self::Braking(braking) => [braking.duration(); 3],
        }
    }
}

impl JointLeg {
    /// The leg on which every joint comes to rest by its own law, wherever that is.
    pub(crate) fn braking(geometry: &Geometry, from: &ArmState, axes: [Axis; 4]) -> Self {
        let mut leg = Self {
            from: *from,
            to: *from,
            axes,
        };
        leg.to = ArmState::at_joints(geometry, &leg.joints_at(leg.duration()));
        leg
    }

    fn joints_at(&self, t: f64) -> JointAngles {
        let mut joints = self.from.joints.to_array();
        for (angle, axis) in joints.iter_mut().zip(&self.axes) {
            *angle += axis.offset(t);
        }
        joints.into()
    }

    fn duration(&self) -> f64 {
        self.axes.iter().map(Axis::duration).fold(0.0, f64::max)
    }

    fn first_crossing(&self, limits: &Limits) -> Option<(f64, MotionError)> {
        if self.stays_within(limits) {
            return None;
        }
        let mut moments = Moments::new();
        let wide = limits.widened_to(&self.from.joints);
        for bound in Bound::ALL {
            self.passings(bound, limits.at(bound), &mut moments);
            if wide.at(bound) != limits.at(bound) {
                self.passings(bound, wide.at(bound), &mut moments);
            }
        }
        let found = first_violation(limits, &self.from.joints, moments, self.duration(), |t| {
            Ok(self.joints_at(t))
        });
        // People want to hear where the target would be, not where the arm stood just after.
        found.map(|(t, error)| match error {
            MotionError::Limit { bound, .. } if limits.is_violated(bound, &self.to.joints) => {
                (t, limits.violation(bound, bound.value(&self.to.joints)))
            }
            error => (t, error),
        })
    }

    /// Whether both ends, and with them everything between, are within limits. The joints move each by its own law, so
    /// the coupled bound is safe only if no pairing of J2 and J3 on the way violates it.
    fn stays_within(&self, limits: &Limits) -> bool {
        let (from, to) = (self.from.joints, self.to.joints);
        let pairing = |j2, j3| JointAngles { j2, j3, ..to };
        [from, to, pairing(from.j2, to.j3), pairing(to.j2, from.j3)]
            .iter()
            .all(|joints| limits.violations(joints).next().is_none())
    }

    /// The moments at which the bound's angle is `angle`: between corners of the laws it is a quadratic of time.
    fn passings(&self, bound: Bound, angle: f64, moments: &mut Moments) {
        let [j1, j2, j3, j4] = &self.axes;
        let (axis, other) = match bound {
            Bound::J1Min | Bound::J1Max => (j1, None),
            Bound::J2Min | Bound::J2Max => (j2, None),
            Bound::J3Min | Bound::J3Max => (j3, None),
            Bound::J4Min | Bound::J4Max => (j4, None),
            Bound::J23Min | Bound::J23Max => (j2, Some(j3)),
        };
        let less = |of: &dyn Fn(&Axis) -> f64| of(axis) - other.map_or(0.0, of);
        let mut corners = [f64::NAN; 6];
        let others = other.map_or([f64::NAN; 3], Axis::corners);
        for (slot, corner) in corners
            .iter_mut()
            .zip(axis.corners().into_iter().chain(others))
        {
            *slot = corner;
        }
        corners.sort_unstable_by(f64::total_cmp);
        let start = bound.value(&self.from.joints) - angle;
        let mut from = 0.0;
        for to in corners.into_iter().filter(|t| !t.is_nan()) {
            if to > from {
                let acceleration = less(&|axis| axis.acceleration(0.5 * (from + to)));
                let velocity = less(&|axis| axis.velocity(from));
                let offset = start + less(&|axis| axis.offset(from));
                for root in quadratic(0.5 * acceleration, velocity, offset) {
                    if root >= 0.0 && from + root <= to {
                        moments.add(from + root);
                    }
                }
                from = to;
            }
        }
    }

    /// The state at `t`; a joint that `stopped_by` names is exactly at that bound.
    fn state_stopped_by(&self, geometry: &Geometry, t: f64, stopped_by: &MotionError) -> ArmState {
        let mut joints = self.joints_at(t);
        if let MotionError::Limit { bound, limit, .. } = *stopped_by {
            match bound {
                // Without a passing of the bound the start was beyond it: there it stays.
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

/// The tool along a straight line, r alongside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineLeg {
    pub(crate) from: ArmState,
    pub(crate) to: ArmState,
    pub(crate) along: Profile,
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

    fn tool_rate_at(&self, t: f64) -> Pose {
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

    fn first_crossing(&self, geometry: &Geometry, limits: &Limits) -> Option<(f64, MotionError)> {
        let start = match geometry.inverse(&self.from.pose) {
            Ok(joints) => joints,
            Err(error) => return Some((0.0, error)),
        };
        let spatial = Limits {
            j4: Range::new(f64::NEG_INFINITY, f64::INFINITY),
            ..*limits
        };
        let mut moments = Moments::new();
        let wide = spatial.widened_to(&start);
        spatial_cuts(&self.section(geometry), &spatial, &wide, &mut |share| {
            if share > 0.0 && share < 1.0 {
                moments.add(self.along.time_at(share * self.along.length()));
            }
        });
        let duration = self.along.duration();
        let found = first_violation(&spatial, &start, moments, duration, |t| {
            geometry.inverse(&self.pose_at(t))
        });
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

impl Leg {
    pub(crate) fn duration(&self) -> f64 {
        match self {
            Self::Joints(leg) => leg.duration(),
            Self::Line(leg) => leg.along.duration(),
        }
    }

    pub(crate) fn end(&self) -> ArmState {
        match self {
            Self::Joints(leg) => leg.to,
            Self::Line(leg) => leg.to,
        }
    }

    /// The state after `t` seconds: exactly the start's and the end's at either end.
    pub(crate) fn state_at(&self, geometry: &Geometry, t: f64) -> ArmState {
        let (from, to) = match self {
            Self::Joints(leg) => (leg.from, leg.to),
            Self::Line(leg) => (leg.from, leg.to),
        };
        if t >= self.duration() {
            to
        } else if t <= 0.0 {
            from
        } else {
            match self {
                Self::Joints(leg) => ArmState::at_joints(geometry, &leg.joints_at(t)),
                Self::Line(leg) => leg.state_at(geometry, t),
            }
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
            Self::Line(_) => self.state_at(geometry, t),
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
        }
    }

    /// How much the leg counts in a motion of several, mm: the way between its ends; degrees if there is none.
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
        }
    }

    fn governing(&self) -> Axis {
        match self {
            Self::Joints(leg) => leg.governing().0,
            Self::Line(leg) if leg.along.length() >= SHORTEST_MOVE => {
                Axis::Travelling(1.0, leg.along)
            }
            Self::Line(leg) => Axis::Travelling(1.0, leg.turning),
        }
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
            Axis::Braking(braking) => {
                braking.duration() * (1.0 - libm::sqrt((1.0 - progress).max(0.0)))
            }
        }
    }
}

impl JointLeg {
    /// The joint that goes furthest, and how far.
    fn governing(&self) -> (Axis, f64) {
        let [first, ..] = self.axes;
        let sweep = |axis: &Axis| libm::fabs(axis.offset(axis.duration()));
        self.axes
            .iter()
            .map(|axis| (*axis, sweep(axis)))
            .fold(
                (first, 0.0),
                |best, next| if next.1 > best.1 { next } else { best },
            )
    }
}

/// A motion shorter than this takes no time, mm or degrees (model section 7).
pub(crate) const SHORTEST_MOVE: f64 = 1e-4;

/// The first of the spans between `moments` in which the limits are violated: when it begins, and how.
///
/// The moments hold every passing of a bound, so a span is inside or outside as a whole and its middle speaks for it.
/// A bound that the start violates is let out to where the start is until the motion has come back within.
fn first_violation(
    limits: &Limits,
    start: &JointAngles,
    mut moments: Moments,
    duration: f64,
    joints_at: impl Fn(f64) -> Result<JointAngles, MotionError>,
) -> Option<(f64, MotionError)> {
    let mut in_force = limits.widened_to(start);
    let mut from = 0.0;
    let inner = moments.sorted().iter().copied().filter(|t| *t < duration);
    for to in inner.chain([duration]) {
        if to > from {
            let joints = match joints_at(0.5 * (from + to)) {
                Ok(joints) => joints,
                Err(error) => return Some((from, error)),
            };
            if let Err(error) = in_force.check(&joints) {
                return Some((from, as_set(limits, error)));
            }
            in_force = in_force.narrowed_at(limits, &joints);
            from = to;
        }
    }
    None
}

/// A violation of a bound let out, told with the bound as it is set.
fn as_set(limits: &Limits, error: MotionError) -> MotionError {
    match error {
        MotionError::Limit { bound, value, .. } => limits.violation(bound, value),
        error => error,
    }
}
