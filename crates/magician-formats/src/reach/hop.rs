//! Short moves between strokes: whether a joint move beats the straight line.
//!
//! A joint move is often quicker than a straight one over a short distance, but its tool path is
//! curved. It may replace the straight line only if it stays close enough to it.

use magician_host::ArmState;
use magician_motion::{
    ArmModel, Ceilings, Fence, Move, MoveKind, Planner, Pose, Speeds, Target, Trajectory,
};

use super::{Above, Reach};

/// Largest deviation from the straight line where the tool may touch something, mm. A choice well
/// below the width of a pen's line.
const MAX_DEVIATION: f64 = 0.1;
/// Largest deviation as a share of the height above the surface. A choice: a higher tool may
/// deviate further without touching the work.
const MAX_DEVIATION_SHARE: f64 = 0.25;
/// Tolerance of heights, mm. It absorbs rounding.
const HEIGHT_TOLERANCE: f64 = 1e-4;
/// Number of points at which a move is sampled. A choice: moves between strokes are short and bend
/// smoothly.
const MOVE_SAMPLES: u64 = 8;

/// Parameters of travel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Travelling {
    /// Speed of straight moves, mm/s, and of the joints, deg/s, before the speed ratio (50 % at
    /// power-up).
    pub(crate) speed: f64,
    /// True if the tool turns with the arm.
    pub(crate) turns: bool,
    /// Fence to respect.
    pub(crate) fence: Option<Fence>,
}

impl Reach {
    /// True if a joint move between two points is quicker than the straight line and as safe.
    ///
    /// Durations are those of the arm's own motion law. As safe means: it stays close to the line,
    /// never goes below the surface, respects the fence, and the tip is never faster than allowed
    /// on the line.
    pub(crate) fn is_quicker_by_joints(
        &self,
        from: Above,
        to: Above,
        travelling: &Travelling,
    ) -> bool {
        let (Some(start), Some(end)) = (
            self.state_at(from, travelling.turns),
            self.state_at(to, travelling.turns),
        ) else {
            return false;
        };
        let planner = Planner {
            geometry: self.geometry,
            limits: self.limits,
            ceilings: Ceilings::default(),
            law: ArmModel::MAGICIAN.law,
            speeds: travelling.speeds(),
        };
        let plan = |kind| {
            let target = Target::Pose(end.pose);
            let plan = planner.plan(&start, &Move { target, kind }).ok()?;
            plan.crossing.is_none().then_some(plan.trajectory)
        };
        let (Some(joints), Some(line)) = (plan(MoveKind::Joint), plan(MoveKind::Line)) else {
            return false;
        };
        let lower = from.1.min(to.1);
        let (most, least) = (
            MAX_DEVIATION.max(MAX_DEVIATION_SHARE * lower),
            (1.0 - MAX_DEVIATION_SHARE) * lower - HEIGHT_TOLERANCE,
        );
        let is_close = |at: Pose| {
            let above = at.z - self.surface.at([at.x, at.y]);
            above >= least && deviation([start.pose, end.pose], at) <= most
        };
        joints.duration_us() < line.duration_us()
            && travelling.allows(&joints)
            && sampled_poses(&joints).all(is_close)
    }

    fn state_at(&self, (point, above): Above, turns: bool) -> Option<ArmState> {
        let mut pose = self.pose(point, above);
        if turns {
            pose.r = self.joints(point, above)?.j1;
        }
        ArmState::at_pose(&self.geometry, &pose, &self.limits).ok()
    }
}

impl Travelling {
    fn speeds(&self) -> Speeds {
        let speed = self.speed;
        Speeds {
            joint_velocity: [speed; 4],
            joint_acceleration: [speed; 4],
            linear_velocity: speed,
            linear_acceleration: speed,
            rotation_velocity: speed / 2.0,
            rotation_acceleration: speed / 2.0,
            ..ArmModel::MAGICIAN.power_up.speeds()
        }
    }

    fn allows(&self, trajectory: &Trajectory) -> bool {
        // Twice the mean speed is the peak of a triangular profile, and an upper bound for all
        // others.
        let seconds = trajectory.duration_us() as f64 / 1e6;
        let peak = 2.0 * trajectory.start().pose.distance_to(&trajectory.end().pose) / seconds;
        let share = ArmModel::MAGICIAN.power_up.speeds().velocity_ratio / 100.0;
        let keeps = |fence: Fence| {
            let fence = fence.in_space();
            fence.check_motion(trajectory).is_ok()
        };
        peak <= share * self.speed && self.fence.is_none_or(keeps)
    }
}

fn sampled_poses(trajectory: &Trajectory) -> impl Iterator<Item = Pose> + '_ {
    (1..MOVE_SAMPLES).map(|nth| {
        trajectory
            .curve(trajectory.duration_us() * nth / MOVE_SAMPLES)
            .pose
    })
}

/// Distance of a point from a straight line.
fn deviation([from, to]: [Pose; 2], at: Pose) -> f64 {
    let chord = [to.x - from.x, to.y - from.y, to.z - from.z];
    let off = [at.x - from.x, at.y - from.y, at.z - from.z];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let share = (dot(off, chord) / dot(chord, chord).max(1e-12)).clamp(0.0, 1.0);
    let rest = [0, 1, 2].map(|axis: usize| off[axis] - share * chord[axis]);
    dot(rest, rest).sqrt()
}
