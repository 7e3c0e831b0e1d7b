//! Continuous paths: segments planned as they arrive, compared with model section 8.

use std::collections::VecDeque;

use super::support::*;
use magician_motion::{
    ArmModel, ArmState, CpSegment, CpSpeeds, Geometry, JointAngles, KinematicLimits, LookAhead,
    MotionError, MotionLaw, Planner, Pose, ToolBias, Trajectory, Unreachable,
};
use proptest::prelude::*;

fn settings() -> impl Strategy<Value = CpSpeeds> {
    (10.0..400.0f64, 10.0..300.0f64, 0.005..0.1f64, any::<bool>()).prop_map(
        |(plan_acceleration, junction_velocity, period_s, real_time)| CpSpeeds {
            plan_acceleration,
            junction_velocity,
            period_s,
            real_time,
        },
    )
}

/// A path through the middle of the workspace, in steps of some mm, mostly straight on.
fn points() -> impl Strategy<Value = Vec<[f64; 3]>> {
    let step = (
        prop_oneof![0.01..0.3f64, 0.3..5.0f64, 5.0..30.0f64],
        prop_oneof![Just(0.0), -0.2..0.2f64, -3.1..3.1f64],
        -0.3..0.3f64,
    );
    proptest::collection::vec(step, 1..40).prop_map(|steps| {
        let (mut heading, mut at) = (0.0f64, START);
        let steps = steps.into_iter().map(|(length, turn, climb)| {
            heading += turn;
            let [x, y, z] = at;
            let next = [
                x + length * heading.cos(),
                y + length * heading.sin(),
                z + length * climb,
            ];
            // Before it leaves the middle of the workspace it turns back.
            let inside =
                (200.0..250.0).contains(&next[0]) && next[1].abs() < 50.0 && next[2].abs() < 40.0;
            at = if inside { next } else { half_way_back(at) };
            at
        });
        steps.collect()
    })
}

const START: [f64; 3] = [225.0, 0.0, 0.0];
/// A point nearly half way back to the middle.
fn half_way_back([x, y, z]: [f64; 3]) -> [f64; 3] {
    [0.5 * (x + 225.3), 0.5 * y + 0.2, 0.5 * z]
}

fn place(state: &ArmState) -> [f64; 3] {
    let Pose { x, y, z, .. } = state.pose;
    [x, y, z]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    CpSegment::between(a, b).length()
}

/// Distance of a point from the segment between two others.
fn distance_from_line(point: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let whole = distance(from, to);
    let share: f64 = (0..3)
        .map(|axis| (point[axis] - from[axis]) * (to[axis] - from[axis]) / (whole * whole))
        .sum();
    let foot = [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]));
    distance(point, foot)
}

/// The arm's side: the running segment and those waiting behind it.
struct Run {
    planner: Planner,
    look_ahead: LookAhead,
    acceleration: f64,
    /// True if it may have to brake harder than the limit.
    forced: bool,
    state: ArmState,
    speed: f64,
    running: Option<Running>,
    queue: VecDeque<(CpSegment, [f64; 3])>,
    newest: [f64; 3],
    /// Speed at the end of each segment, and its duration in microseconds.
    ends: Vec<(f64, u64)>,
    /// Highest speed seen.
    fastest: f64,
}

struct Running {
    segment: CpSegment,
    from: [f64; 3],
    to: [f64; 3],
    motion: Trajectory,
    /// Elapsed part of the motion, and that of the motions before it.
    at_us: u64,
    before_us: u64,
}

impl Run {
    fn new(tool: ToolBias, settings: &CpSpeeds) -> Self {
        let planner = Planner {
            geometry: Geometry::magician(tool),
            ..continuous()
        };
        let pose = Pose::new(START[0], START[1], START[2], 20.0);
        Self {
            planner,
            look_ahead: LookAhead::new(
                settings,
                &ArmModel::MAGICIAN.ceilings,
                MotionLaw::CONTINUOUS,
            )
            .expect("speeds"),
            acceleration: settings.plan_acceleration,
            forced: false,
            state: ArmState::at_pose(&planner.geometry, &pose, &planner.limits).expect("in reach"),
            speed: 0.0,
            running: None,
            queue: VecDeque::new(),
            newest: START,
            ends: Vec::new(),
            fastest: 0.0,
        }
    }

    fn receive(&mut self, to: [f64; 3]) -> Result<(), TestCaseError> {
        let segment = CpSegment::between(self.newest, to);
        self.newest = to;
        self.queue.push_back((segment, to));
        self.replan()
    }

    fn exit(&self, running: &CpSegment) -> f64 {
        let queued = self.queue.iter().map(|(segment, _)| segment);
        self.look_ahead.exit_speed(running, queued)
    }

    fn replan(&mut self) -> Result<(), TestCaseError> {
        let Some(running) = &self.running else {
            return Ok(());
        };
        let exit = self.exit(&running.segment);
        let rates = self.look_ahead.rates(&running.segment);
        let (before, at_us) = (running.motion, running.at_us);
        let plan = self.planner.segment_rest(&before, at_us, exit, rates);
        let Some(plan) = plan.expect("speeds") else {
            prop_assert_eq!(at_us, before.duration_us());
            return Ok(());
        };
        prop_assert_eq!(plan.crossing, None);
        let motion = plan.trajectory;
        prop_assert_eq!(motion.sample(0), before.sample(at_us));
        prop_assert!((motion.path_speed(0) - before.path_speed(at_us)).abs() < 1e-12);
        if let Some(running) = &mut self.running {
            running.before_us += running.at_us;
            running.at_us = 0;
            running.motion = motion;
        }
        Ok(())
    }

    /// Advances by this much, or until nothing is left to do.
    fn advance(&mut self, mut by_us: u64) -> Result<(), TestCaseError> {
        loop {
            if self.running.is_none() && !self.start_next()? {
                return Ok(());
            }
            let Some(mut running) = self.running.take() else {
                return Ok(());
            };
            let left = running.motion.duration_us() - running.at_us;
            let until = running.at_us + left.min(by_us);
            self.look(&running, until)?;
            running.at_us = until;
            if by_us < left {
                self.running = Some(running);
                return Ok(());
            }
            by_us -= left;
            let end = running.motion.sample(until);
            prop_assert_eq!(place(&end), running.to);
            prop_assert_eq!(end.joints.j4, self.state.joints.j4);
            self.speed = running.motion.exit_speed();
            self.state = end;
            self.ends.push((self.speed, running.before_us + until));
        }
    }

    fn start_next(&mut self) -> Result<bool, TestCaseError> {
        let Some((segment, to)) = self.queue.pop_front() else {
            prop_assert!(self.forced || self.speed == 0.0);
            return Ok(false);
        };
        let from = place(&self.state);
        let exit = self.exit(&segment);
        let rates = self.look_ahead.rates(&segment);
        let plan = self
            .planner
            .segment(&self.state, to, self.speed, exit, rates)
            .expect("in reach");
        prop_assert_eq!(plan.crossing, None);
        prop_assert!((plan.trajectory.path_speed(0) - self.speed).abs() < 1e-12);
        self.running = Some(Running {
            segment,
            from,
            to,
            motion: plan.trajectory,
            at_us: 0,
            before_us: 0,
        });
        Ok(true)
    }

    /// Checks the motion up to a time.
    fn look(&mut self, running: &Running, until: u64) -> Result<(), TestCaseError> {
        const LOOKS: u64 = 12;
        let motion = &running.motion;
        let cruise = self.look_ahead.rates(&running.segment).velocity;
        let mut before = (running.at_us, motion.path_speed(running.at_us));
        for look in 1..=LOOKS {
            let t = running.at_us + (until - running.at_us) * look / LOOKS;
            let now = motion.sample(t);
            prop_assert!(distance_from_line(place(&now), running.from, running.to) < 1e-9);
            let Pose { r, .. } = now.pose;
            prop_assert_eq!(now.joints.j4, self.state.joints.j4);
            prop_assert!((r - now.joints.j1 - now.joints.j4).abs() < 1e-12);
            let solved = self.planner.geometry.inverse(&now.pose).expect("in reach");
            prop_assert!((solved.j1 - now.joints.j1).abs() < 1e-9);
            let speed = motion.path_speed(t);
            prop_assert!(speed <= cruise * (1.0 + 1e-12), "{speed} {cruise}");
            let seconds = (t - before.0) as f64 / 1e6;
            let change = (speed - before.1).abs();
            prop_assert!(
                self.forced || change <= self.acceleration * seconds + 1e-6,
                "{change} in {seconds}"
            );
            let gone = distance(place(&now), place(&motion.sample(before.0)));
            prop_assert!(gone <= cruise * seconds + 1e-6);
            if t < motion.duration_us() {
                let rates = motion.joint_velocities(t);
                prop_assert_eq!(rates[3], 0.0);
                let tool = motion.tool_velocity(t);
                let norm = distance([tool.x, tool.y, tool.z], [0.0; 3]);
                prop_assert!((norm - speed).abs() < 1e-9);
                prop_assert!((tool.r - rates[0]).abs() < 1e-12);
            }
            self.fastest = self.fastest.max(speed);
            before = (t, speed);
        }
        Ok(())
    }
}

/// Speed limit of a corner, from the angle itself.
fn corner_limit(settings: &CpSpeeds, a: &[[f64; 3]; 3]) -> f64 {
    let [from, at, to] = *a;
    let step = |a: [f64; 3], b: [f64; 3]| [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let (u, v) = (step(from, at), step(at, to));
    let cross = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    let dot = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let turn = distance(cross, [0.0; 3])
        .atan2(dot)
        .min(std::f64::consts::FRAC_PI_2);
    0.5 * settings.plan_acceleration * settings.period_s / (0.5 * turn).sin()
}

proptest! {
    #![proptest_config(cases(600))]

    #[test]
    fn keeps_its_law_whenever_segments_arrive(
        points in points(), settings in settings(), tool in prop_oneof![Just(ToolBias::NONE), Just(ToolBias::SUCTION), Just(ToolBias::new(30.0, 20.0, 10.0))],
        ahead in 1usize..20, pauses in proptest::collection::vec(prop_oneof![Just(0u64), 1..5_000u64, 5_000..400_000u64], 40),
    ) {
        let mut run = Run::new(tool, &settings);
        for (index, point) in points.iter().enumerate() {
            run.receive(*point)?;
            // Collects this many before it starts.
            if index + 1 >= ahead {
                run.advance(pauses[index])?;
            }
        }
        run.advance(u64::MAX)?;
        prop_assert_eq!(run.ends.len(), points.len());
        prop_assert_eq!(place(&run.state), points[points.len() - 1]);
        prop_assert_eq!(run.ends[points.len() - 1].0, 0.0);
        let way: Vec<[f64; 3]> = [START].into_iter().chain(points).collect();
        for (corner, (speed, _)) in way.windows(3).zip(&run.ends) {
            let corner = [corner[0], corner[1], corner[2]];
            if !settings.real_time {
                let limit = corner_limit(&settings, &corner);
                prop_assert!(*speed <= limit * (1.0 + 1e-6), "{speed} {limit}");
            }
        }
    }

    #[test]
    fn the_estimate_is_the_time_it_takes(points in points(), settings in settings()) {
        let mut run = Run::new(ToolBias::NONE, &settings);
        for point in &points {
            run.receive(*point)?;
        }
        run.advance(u64::MAX)?;
        let way: Vec<[f64; 3]> = [START].into_iter().chain(points).collect();
        let segments: Vec<CpSegment> = way.windows(2).map(|ends| CpSegment::between(ends[0], ends[1])).collect();
        let mut room = vec![f64::NAN; segments.len()];
        let times: Vec<u64> = run.look_ahead.times(&segments, &mut room).collect();
        let (mut estimate, mut taken) = (0, 0);
        for (time, (_, really)) in times.iter().zip(&run.ends) {
            prop_assert!(time.abs_diff(*really) <= 1, "{time} {really}");
            estimate += time;
            taken += really;
        }
        prop_assert_eq!(times.len(), run.ends.len());
        prop_assert!(estimate.abs_diff(taken) <= 1 + taken / 1_000_000);
    }

    #[test]
    fn a_segment_planned_again_and_again_stays_on_its_line(
        to in ([205.0..250.0f64, -50.0..50.0, -30.0..30.0]), settings in settings(),
        again in proptest::collection::vec((1..60_000u64, 0.0..300.0f64), 1..60),
    ) {
        let mut run = Run::new(ToolBias::PEN, &settings);
        if distance(START, to) < 1.0 {
            return Ok(());
        }
        let start = run.state;
        run.forced = true;
        run.receive(to)?;
        run.advance(0)?;
        for (by_us, exit) in again {
            run.advance(by_us)?;
            let Some(running) = &mut run.running else { break };
            let rates = run.look_ahead.rates(&running.segment);
            let before = running.motion;
            let plan = run.planner.segment_rest(&before, running.at_us, exit, rates).expect("speeds");
            let plan = plan.expect("under way");
            prop_assert_eq!(plan.trajectory.sample(0), before.sample(running.at_us));
            prop_assert!((plan.trajectory.path_speed(0) - before.path_speed(running.at_us)).abs() < 1e-12);
            prop_assert_eq!(place(plan.trajectory.end()), to);
            let left = distance(place(plan.trajectory.start()), to);
            prop_assert!((plan.trajectory.progress(plan.trajectory.duration_us()) - 1.0).abs() < 1e-12 || left < 1e-9);
            // The exit speed is the requested one, unless the rates or the remaining length do not
            // allow that much.
            let gained = (before.path_speed(running.at_us).powi(2) + 2.0 * rates.acceleration * left).sqrt();
            prop_assert!((plan.trajectory.exit_speed() - exit.min(rates.velocity).min(gained)).abs() < 1e-6);
            for share in 0..=8u64 {
                let t = plan.trajectory.duration_us() * share / 8;
                let now = plan.trajectory.sample(t);
                prop_assert!(distance_from_line(place(&now), place(&start), to) < 1e-9);
                let done = plan.trajectory.progress(t);
                let at = plan.trajectory.time_at_progress(done).expect("reached");
                // At a crawl many instants have the same share.
                let there = plan.trajectory.progress(at);
                prop_assert!((there - done).abs() < 1e-5, "{done} {there}");
            }
            running.motion = plan.trajectory;
            running.at_us = 0;
        }
    }

    #[test]
    fn brakes_by_the_joints(to in ([205.0..250.0f64, -50.0..50.0, -30.0..30.0]), settings in settings(), share in 0.0..1.0f64) {
        let run = Run::new(ToolBias::PEN, &settings);
        if distance(START, to) < 1.0 {
            return Ok(());
        }
        let rates = KinematicLimits { velocity: settings.junction_velocity, acceleration: settings.plan_acceleration };
        let motion = run.planner.segment(&run.state, to, 10.0, 50.0, rates).expect("in reach").trajectory;
        let at_us = (motion.duration_us() as f64 * share) as u64;
        let braked = run.planner.brake(&motion, at_us, 2.0).trajectory;
        prop_assert_eq!(braked.sample(0), motion.sample(at_us));
        let (before, after) = (motion.joint_velocities(at_us), braked.joint_velocities(0));
        if at_us < motion.duration_us() {
            prop_assert!(braked.duration_us() > 0);
            for joint in 0..4 {
                prop_assert!((before[joint] - after[joint]).abs() < 1e-9);
            }
        }
        prop_assert_eq!(braked.end().joints.j4, run.state.joints.j4);
        prop_assert_eq!(braked.path_speed(braked.duration_us()), 0.0);
    }
}

proptest! {
    #![proptest_config(cases(1_500))]

    /// The boundary of the folded arm is hollow: a chord of it leaves the limits although both ends
    /// are within.
    #[test]
    fn a_short_excursion_is_not_overlooked(j2 in 3.0..19.0f64, beyond in 1e-4..0.02f64, length in 1.0..20.0f64) {
        let planner = continuous();
        let middle = state(&planner, [0.0, j2, j2 + 70.0 + beyond, 0.0]).pose;
        let end = |y| ArmState::at_pose(&planner.geometry, &Pose { y, ..middle }, &planner.limits);
        let (Ok(from), Ok(to)) = (end(-0.5 * length), end(0.5 * length)) else {
            return Ok(());
        };
        let rates = KinematicLimits { velocity: 100.0, acceleration: 200.0 };
        let plan = planner.segment(&from, place(&to), 20.0, 20.0, rates).expect("in reach");
        let stopped = plan.trajectory.end().joints;
        prop_assert!(plan.crossing.is_some());
        prop_assert!((stopped.j2 - stopped.j3 + 70.0).abs() < 1e-9);
    }

    /// The quick test for a segment within the limits and the exact one, against dense sampling.
    #[test]
    fn ends_where_it_leaves_the_limits(
        from in reachable(), tool in prop_oneof![Just(ToolBias::NONE), bias()], step in ([-1.0..1.0f64, -1.0..1.0, -1.0..1.0]),
        scale in prop_oneof![Just(1.0), Just(20.0), Just(100.0)], part in 0.0..1.0f64,
    ) {
        let planner = Planner { geometry: Geometry::magician(tool), ..continuous() };
        let from = ArmState::at_joints(&planner.geometry, &from);
        let solved = planner.geometry.inverse(&from.pose);
        if solved.is_err() || solved.is_ok_and(|joints| (joints.j1 - from.joints.j1).abs() > 1e-6) {
            return Ok(());
        }
        let [x, y, z] = place(&from);
        let to = [x + scale * step[0], y + scale * step[1], z + scale * step[2]];
        let rates = KinematicLimits { velocity: 100.0, acceleration: 200.0 };
        let plan = match planner.segment(&from, to, 100.0 * part, 100.0, rates) {
            Ok(plan) => plan,
            Err(MotionError::Limit { .. } | MotionError::Unreachable(_)) => return Ok(()),
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        };
        let motion = plan.trajectory;
        prop_assert_eq!(plan.crossing.is_none(), place(motion.end()) == to);
        for look in 0..=400u64 {
            let now = motion.sample(motion.duration_us() * look / 400);
            prop_assert!(planner.limits.check(&now.joints).is_ok() || near(&planner, &now), "{now:?}");
        }
        if let Some(crossing) = plan.crossing {
            prop_assert_eq!(motion.exit_speed(), 0.0);
            prop_assert_eq!(motion.path_speed(motion.duration_us()), 0.0);
            // Just after it, the line without limits is outside.
            let free = Planner { limits: WITHOUT_LIMITS, ..planner };
            let whole = free.segment(&from, to, 100.0 * part, 100.0, rates).expect("in reach").trajectory;
            let outside = (1..=400u64).map(|us| whole.sample(crossing.at_us + us * us / 4)).any(|now| planner.limits.check(&now.joints).is_err());
            prop_assert!(outside || whole.duration_us() < crossing.at_us + 40_000, "{crossing:?}");
        }
    }
}

/// True if the state is on a bound to the precision of a microsecond.
fn near(planner: &Planner, state: &ArmState) -> bool {
    match planner.limits.check(&state.joints) {
        Err(MotionError::Limit { value, limit, .. }) => (value - limit).abs() < 1e-6,
        _ => false,
    }
}

#[test]
fn a_straight_line_in_pieces_takes_the_time_of_the_whole() {
    let settings = ArmModel::MAGICIAN.cp_speeds();
    let mut run = Run::new(ToolBias::NONE, &settings);
    let pieces = 120u32;
    for piece in 1..=pieces {
        let y = 60.0 * f64::from(piece) / f64::from(pieces);
        run.receive([START[0], START[1] + y, START[2]])
            .expect("in order");
    }
    run.advance(u64::MAX).expect("in order");
    let taken: u64 = run.ends.iter().map(|(_, us)| us).sum();
    let rates = KinematicLimits {
        velocity: settings.junction_velocity,
        acceleration: settings.plan_acceleration,
    };
    let expected = rates.least_time(60.0) * 1e6;
    // Every segment ends on a whole microsecond.
    assert!(
        (taken as f64 - expected) <= f64::from(pieces) && taken as f64 >= expected - 1.0,
        "{taken} {expected}"
    );
    assert!(
        (run.fastest - 6000f64.sqrt()).abs() < 0.2,
        "{}",
        run.fastest
    );
}

#[test]
fn a_fed_queue_is_never_slower_than_its_look_ahead_allows() {
    // At most four segments of 2 mm are known: 8 mm to brake, sqrt(2 * 100 * 8) = 40 mm/s.
    let mut run = Run::new(ToolBias::NONE, &ArmModel::MAGICIAN.cp_speeds());
    let mut next = 0;
    let mut feed = |run: &mut Run| {
        while run.queue.len() < 4 && next < 40 {
            next += 1;
            run.receive([START[0], START[1] + 2.0 * f64::from(next), START[2]])
                .expect("in order");
        }
    };
    feed(&mut run);
    for _ in 0..100_000 {
        run.advance(1_000).expect("in order");
        feed(&mut run);
    }
    assert_eq!(run.ends.len(), 40);
    assert!((run.fastest - 40.0).abs() < 2.5, "{}", run.fastest);
}

#[test]
fn the_end_of_a_segment_is_checked() {
    let planner = continuous();
    let home = state(&planner, [0.0, 45.0, 45.0, 10.0]);
    let rates = KinematicLimits {
        velocity: 100.0,
        acceleration: 100.0,
    };
    let go = |to, entry, exit| planner.segment(&home, to, entry, exit, rates);
    assert!(matches!(
        go([400.0, 0.0, 0.0], 0.0, 0.0),
        Err(MotionError::Unreachable(Unreachable::TooFar { .. }))
    ));
    assert!(matches!(
        go([f64::NAN, 0.0, 0.0], 0.0, 0.0),
        Err(MotionError::Unreachable(Unreachable::NotFinite))
    ));
    let [x, y, z] = place(&home);
    let back = planner
        .geometry
        .forward(&JointAngles::new(0.0, -15.0, 30.0, 0.0));
    assert!(matches!(
        go([back.x, back.y, back.z], 0.0, 0.0),
        Err(MotionError::Limit { .. })
    ));
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            go([x, 5.0, z], bad, 0.0),
            Err(MotionError::Speed { .. })
        ));
        assert!(matches!(
            go([x, 5.0, z], 0.0, bad),
            Err(MotionError::Speed { .. })
        ));
    }
    // Too short to count: done at once, exactly.
    let near = go([x, y + 5e-5, z], 30.0, 30.0)
        .expect("in reach")
        .trajectory;
    assert_eq!(
        (near.duration_us(), place(near.end())),
        (0, [x, y + 5e-5, z])
    );
    // Too short to stop at the acceleration set; it still stops.
    let hard = go([x, y + 1.0, z], 50.0, 0.0).expect("in reach").trajectory;
    assert_eq!((hard.duration_us(), hard.exit_speed()), (40_000, 0.0));
    assert_eq!(place(hard.end()), [x, y + 1.0, z]);
    // Only a running segment has a rest.
    let rest = planner.segment_rest(&hard, 40_000, 0.0, rates);
    assert_eq!(rest, Ok(None));
    let jump = joint_move(magician_motion::Target::Joints(JointAngles::new(
        9.0, 45.0, 45.0, 0.0,
    )));
    let other = planner.plan(&home, &jump).expect("planned").trajectory;
    assert_eq!(planner.segment_rest(&other, 10, 0.0, rates), Ok(None));
}
