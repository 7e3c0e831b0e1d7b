//! Crossings of arcs with limits and the edge of reach: the enclosures against dense sampling.

use super::support::*;
use magician_motion::{
    ArmModel, ArmState, Bound, JointAngles, Limits, MotionError, Planner, Pose, Range,
};
use proptest::prelude::*;

/// True if the points make no proper arc; such points are tested elsewhere.
fn is_refused(planner: &Planner, from: &ArmState, via: &Pose, to: &Pose) -> bool {
    matches!(
        planner.arc(from, via, to),
        Err(MotionError::Coincident | MotionError::Collinear)
    )
}

/// Three poses close to each other, so that the arc is small and often within limits.
fn neighbours() -> impl Strategy<Value = [JointAngles; 3]> {
    let near = || (-0.15..0.15f64, -0.15..0.15f64, -0.15..0.15f64, -0.5..0.5f64);
    (reachable(), near(), near())
        .prop_map(|(from, a, b)| {
            let moved = |by: (f64, f64, f64, f64)| {
                JointAngles::new(
                    from.j1 + 100.0 * by.0,
                    from.j2 + 100.0 * by.1,
                    from.j3 + 100.0 * by.2,
                    from.j4 + 100.0 * by.3,
                )
            };
            [from, moved(a), moved(b)]
        })
        .prop_filter("within limits", |places| {
            places
                .iter()
                .all(|joints| ArmModel::MAGICIAN.limits.check(joints).is_ok())
        })
}

proptest! {
    // Cases that prove nothing are drawn again: two thousand cases are really compared with
    // samples.
    #![proptest_config(ProptestConfig { max_global_rejects: 20_000, ..cases(2_000) })]

    #[test]
    fn on_arcs(places in prop_oneof![neighbours(), [reachable(), reachable(), reachable()]], planner in planner()) {
        let [from, via, to] = places.map(|joints| ArmState::at_joints(&planner.geometry, &joints));
        prop_assume!(!is_refused(&planner, &from, &via.pose, &to.pose));
        agrees_with_sampling(&planner, true, |planner| planner.arc(&from, &via.pose, &to.pose))?;
    }

    #[test]
    fn on_arcs_that_graze(places in neighbours(), planner in planner(), closer in 0.5..1.0f64) {
        let planner = Planner { limits: drawn_in(&planner.limits, &places, closer), ..planner };
        let [from, via, to] = places.map(|joints| ArmState::at_joints(&planner.geometry, &joints));
        prop_assume!(!is_refused(&planner, &from, &via.pose, &to.pose));
        agrees_with_sampling(&planner, true, |planner| planner.arc(&from, &via.pose, &to.pose))?;
    }

    #[test]
    fn on_circles(places in neighbours(), planner in planner(), closer in 0.0..1.0f64, count in 1..4u32) {
        let planner = Planner { limits: drawn_in(&planner.limits, &places, closer), ..planner };
        let [from, via, to] = places.map(|joints| ArmState::at_joints(&planner.geometry, &joints));
        prop_assume!(!is_refused(&planner, &from, &via.pose, &to.pose));
        agrees_with_sampling(&planner, true, |planner| planner.circle(&from, &via.pose, &to.pose, count))?;
    }

    #[test]
    fn of_joint_four_alone(places in neighbours(), planner in planner(), share in 0.0..1.0f64) {
        let [from, via, to] = places.map(|joints| ArmState::at_joints(&planner.geometry, &joints));
        let (low, high) = (from.joints.j4.min(to.joints.j4), from.joints.j4.max(to.joints.j4));
        let j4 = Range::new(low - 10.0 * share, high + 10.0 * share);
        let planner = Planner { limits: Limits { j4, ..WITHOUT_LIMITS }, ..planner };
        prop_assume!(!is_refused(&planner, &from, &via.pose, &to.pose));
        // The cut of `atan2` behind the base is beyond any limit of J1.
        let free = Planner { limits: WITHOUT_LIMITS, ..planner };
        let path = free.arc(&from, &via.pose, &to.pose).expect("planned").trajectory;
        prop_assume!((0..=1000).all(|part| path.sample(path.duration_us() * part / 1000).pose.x > 1.0));
        agrees_with_sampling(&planner, true, |planner| planner.arc(&from, &via.pose, &to.pose))?;
    }

    #[test]
    fn from_outside_inwards_only(places in neighbours(), planner in planner(), shrink in 0.3..1.0f64) {
        let tight = Limits {
            j1: Range::new(-135.0 * shrink, 135.0 * shrink),
            j2: Range::new(-5.0, 90.0 * shrink),
            ..ArmModel::MAGICIAN.limits
        };
        let planner = Planner { limits: tight, ..planner };
        let [from, via, to] = places.map(|joints| ArmState::at_joints(&planner.geometry, &joints));
        let plan = planner.arc(&from, &via.pose, &to.pose);
        prop_assume!(plan.is_ok());
        let plan = plan.expect("it was just seen");
        let outside: Vec<Bound> = tight.violations(&from.joints).collect();
        let motion = plan.trajectory;
        for step in 0..=500u64 {
            let joints = motion.sample(motion.duration_us() * step / 500).joints;
            for bound in tight.violations(&joints) {
                let side = if bound.is_upper() { 1.0 } else { -1.0 };
                let further = side * (bound.value(&joints) - bound.value(&from.joints));
                // The time of a crossing is exact to a microsecond.
                prop_assert!(outside.contains(&bound) && further < 1e-3
                    || side * (bound.value(&joints) - tight.at(bound)) < 1e-3, "{bound:?} {joints:?}");
            }
        }
    }
}

#[test]
fn samples_are_found_to_cross_often_enough_to_prove_something() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let planner = continuous();
    let mut outcomes = [0; 2];
    for _ in 0..500 {
        let places = neighbours().new_tree(&mut runner).expect("a value");
        let [from, via, to] = places
            .current()
            .map(|joints| ArmState::at_joints(&planner.geometry, &joints));
        if let Ok(plan) = planner.arc(&from, &via.pose, &to.pose) {
            outcomes[usize::from(plan.crossing.is_some())] += 1;
        }
    }
    assert!(outcomes.iter().all(|count| *count > 50), "{outcomes:?}");
}

/// An arc around the base exactly at a bound counts as inside, although rounding hides on which
/// side of the bound it is. A ten-millionth of a degree tighter, it is not.
#[test]
fn arcs_round_the_base_that_hug_a_bound() {
    let planner = continuous();
    let places = [-60.0, 10.0, 70.0].map(|j1| state(&planner, [j1, 90.0, 60.0, 0.0]));
    let [from, via, to] = places;
    let plan = planner.arc(&from, &via.pose, &to.pose).expect("planned");
    assert_eq!(plan.crossing, None);
    // The same arc with its middle slightly lifted also rises in J2.
    let lifted = Pose {
        z: via.pose.z - 1e-4,
        ..via.pose
    };
    let error = planner.arc(&from, &lifted, &to.pose).expect_err("beyond");
    assert!(matches!(
        error,
        MotionError::Limit {
            bound: Bound::J2Max,
            ..
        }
    ));
    let eased = Planner {
        limits: Limits {
            j2: Range::new(-5.0, 90.0 + 1e-7),
            ..ArmModel::MAGICIAN.limits
        },
        ..planner
    };
    let plan = eased.arc(&from, &via.pose, &to.pose).expect("planned");
    assert_eq!(plan.crossing, None);
}

#[test]
fn an_arc_ends_exactly_where_it_meets_a_bound() {
    let planner = continuous();
    // A level circle of 30 mm around a centre at 130 degrees, from its near side over the outer to
    // the far one. All three points are within, and at 135 degrees the base is at its limit.
    let (distance, radius, z) = (200.0, 30.0, -8.0);
    let (sin, cos) = 130.0f64.to_radians().sin_cos();
    let on_circle = |outwards: f64, aside: f64| {
        Pose::new(
            (distance + outwards) * cos - aside * sin,
            (distance + outwards) * sin + aside * cos,
            z,
            0.0,
        )
    };
    let start = on_circle(0.0, -radius);
    let from = ArmState::at_pose(&planner.geometry, &start, &planner.limits).expect("within");
    let (via, to) = (on_circle(radius, 0.0), on_circle(-radius, 0.0));
    let plan = planner.arc(&from, &via, &to).expect("planned");
    let crossing = plan.crossing.expect("beyond J1");
    let MotionError::Limit { bound, limit, .. } = crossing.cause else {
        panic!("{crossing:?}")
    };
    assert_eq!((bound, limit), (Bound::J1Max, 135.0));
    // The ray at 5 degrees from the centre first meets the circle on its far side.
    let (sin, cos) = 5.0f64.to_radians().sin_cos();
    let along = distance * cos + (radius * radius - (distance * sin).powi(2)).sqrt();
    let (outwards, aside) = (along * cos - distance, along * sin);
    let angle = 90.0 + aside.atan2(outwards).to_degrees();
    assert!((crossing.progress - angle / 270.0).abs() < 1e-5);
    let stopped = plan.trajectory.end();
    assert!((stopped.joints.j1 - 135.0).abs() < 1e-9);
    assert_eq!(plan.trajectory.sample(crossing.at_us), *stopped);
    assert!((plan.trajectory.progress(crossing.at_us) - crossing.progress).abs() < 1e-12);
}
