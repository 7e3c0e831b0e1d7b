//! Rest-to-rest times compared with Ruckig without a jerk limit, an independent implementation.

use super::support::*;
use magician_motion::{
    ArmModel, ArmState, KinematicLimits, Planner, Speeds, Target, VelocityProfile,
};
use proptest::prelude::*;
use rsruckig::prelude::*;

/// Ruckig's time for axes that start and arrive together from rest to rest, seconds.
fn ruckig<const N: usize>(lengths: [f64; N], velocity: [f64; N], acceleration: [f64; N]) -> f64 {
    let mut otg = Ruckig::<N, ThrowErrorHandler>::new(None, 0.001);
    let mut input = InputParameter::<N>::new(None);
    for axis in 0..N {
        input.target_position[axis] = lengths[axis];
        input.max_velocity[axis] = velocity[axis];
        input.max_acceleration[axis] = acceleration[axis];
    }
    let mut trajectory = rsruckig::prelude::Trajectory::<N>::new(None);
    otg.calculate(&input, &mut trajectory).expect("valid input");
    trajectory.get_duration()
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn one_axis(length in 1e-3..500.0f64, velocity in 0.5..480.0f64, acceleration in 0.5..400.0f64) {
        let ours = VelocityProfile::trapezoid(length, &KinematicLimits { velocity, acceleration }).duration();
        let theirs = ruckig([length], [velocity], [acceleration]);
        prop_assert!((ours - theirs).abs() <= 1e-6, "{ours} {theirs}");
    }

    #[test]
    fn four_joints(from in reachable(), to in reachable(), speeds in speeds()) {
        let planner = Planner { limits: WITHOUT_LIMITS, speeds, ..continuous() };
        prop_assert!(ArmModel::MAGICIAN.limits.check(&to).is_ok());
        let start = ArmState::at_joints(&planner.geometry, &from);
        let plan = planner.plan(&start, &joint_move(Target::Joints(to))).expect("planned");
        let ours = plan.trajectory.duration_us() as f64 / 1e6;
        let Speeds { velocity_ratio, acceleration_ratio, .. } = speeds;
        let (v, a) = (velocity_ratio.min(100.0) / 100.0, acceleration_ratio.min(100.0) / 100.0);
        let ceilings = [320.0, 320.0, 320.0, 480.0];
        let (from, to) = (from.to_array(), to.to_array());
        let theirs = ruckig(
            [0, 1, 2, 3].map(|joint| to[joint] - from[joint]),
            [0, 1, 2, 3].map(|joint| speeds.joint_velocity[joint].min(ceilings[joint]) * v),
            [0, 1, 2, 3].map(|joint| speeds.joint_acceleration[joint].min(300.0) * a),
        );
        // Ours is rounded up to a whole microsecond.
        prop_assert!((-1e-8..=1.01e-6).contains(&(ours - theirs)), "{ours} {theirs}");
    }
}
