use super::way::end_limit;
use super::*;
use crate::{
    ArmState, Geometry, JointAngles, JumpHeights, Move, MoveKind, Planner, Target, ToolBias,
    Trajectory, Transfer,
};

/// Random numbers from a seed.
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn pose(&mut self) -> Pose {
        let (turn, far) = (self.within(-1.6, 1.6), self.within(170.0, 310.0));
        let [x, y] = [libm::cos(turn), libm::sin(turn)].map(|part| far * part);
        Pose::new(x, y, self.within(-80.0, 100.0), 0.0)
    }

    fn fence(&mut self) -> Fence {
        let mut fence = Fence::default();
        if self.unit() < 0.5 {
            fence = fence.with_floor(self.within(-70.0, -20.0)).unwrap();
        }
        if self.unit() < 0.4 {
            let min = [self.within(-50.0, 150.0), self.within(-200.0, -50.0), -90.0];
            let max = [280.0, self.within(50.0, 200.0), self.within(20.0, 120.0)];
            fence = fence.with_box(Cuboid { min, max }).unwrap();
        }
        for _ in 0..2 {
            let at = self.pose();
            let size = self.within(4.0, 60.0);
            let [x, y, z] = [at.x, at.y, at.z];
            let keep_out = Cuboid {
                min: [x, y, z],
                max: [x + size, y + size, z + size],
            };
            fence = fence.with_keep_out(keep_out).unwrap();
        }
        fence
    }

    fn motion(&mut self, planner: &Planner, from: &ArmState) -> Option<Trajectory> {
        let to = self.pose();
        let heights = JumpHeights {
            start: 20.0,
            end: 10.0,
            z_limit: 120.0,
        };
        let kind = match (self.unit() * 5.0) as u32 {
            0 => MoveKind::Joint,
            1 => MoveKind::Line,
            2 => MoveKind::Jump(heights, Transfer::Joint),
            3 => MoveKind::Jump(heights, Transfer::Line),
            _ => {
                let via = self.pose();
                let plan = planner.arc(from, &via, &to).ok()?;
                return Some(plan.trajectory);
            }
        };
        let target = Target::Pose(to);
        Some(planner.plan(from, &Move { target, kind }).ok()?.trajectory)
    }
}

fn planner(tool: ToolBias) -> Planner {
    Planner {
        geometry: Geometry::magician(tool),
        ..Planner::default()
    }
}

/// Greatest depth of a path beyond each part, by dense sampling.
fn looked_at(fence: &Fence, motion: &Trajectory) -> Vec<(f64, f64, f64)> {
    let depths = |at_us: u64| {
        let pose = motion.curve(at_us).pose;
        let tip = [pose.x, pose.y, pose.z];
        fence
            .parts()
            .map(|part| fence.depth(part, tip))
            .collect::<Vec<_>>()
    };
    let (first, last) = (depths(0), depths(motion.duration_us()));
    let mut deepest = first.clone();
    for nth in 0..=1000 {
        for (deepest, depth) in deepest
            .iter_mut()
            .zip(depths(motion.duration_us() * nth / 1000))
        {
            *deepest = deepest.max(depth);
        }
    }
    let ends = first.into_iter().zip(last);
    ends.zip(deepest)
        .map(|((first, last), deepest)| (first, last, deepest))
        .collect()
}

/// A path that passes is within all bounds at every sample; a refused one is beyond a bound, or
/// nearly so.
#[test]
fn a_way_passes_if_no_place_of_it_is_beyond() {
    let mut dice = Dice(0x5eed);
    let (mut passed, mut refused, mut outside) = (0, 0, 0);
    for nth in 0..2000 {
        let planner = planner([ToolBias::NONE, ToolBias::PEN][nth % 2]);
        let start = dice.pose();
        let Ok(from) = ArmState::at_pose(&planner.geometry, &start, &planner.limits) else {
            continue;
        };
        let Some(motion) = dice.motion(&planner, &from) else {
            continue;
        };
        let fence = dice.fence();
        let verdict = fence.check_motion(&motion);
        let looked = looked_at(&fence, &motion);
        outside += u32::from(looked.iter().any(|(first, ..)| *first > TOLERANCE));
        let allowed = |first: f64| first.max(0.0) + TOLERANCE;
        match verdict {
            Ok(()) => {
                passed += 1;
                for (first, last, deepest) in &looked {
                    assert!(*deepest <= allowed(*first), "{fence:?} {motion:?}");
                    assert!(*last <= end_limit(*first), "{fence:?} {motion:?}");
                }
            }
            Err(breach) => {
                refused += 1;
                let strict = |first: f64| first.max(0.0) - TOLERANCE;
                let any = looked.iter().any(|(first, last, deepest)| {
                    *deepest > strict(*first) && (*deepest > 0.0 || *last > end_limit(*first))
                });
                assert!(any, "{breach} {looked:?}");
            }
        }
    }
    assert!(
        passed > 200 && refused > 300 && outside > 100,
        "{passed} {refused} {outside}"
    );
}

#[test]
fn a_line_on_the_floor_is_on_the_right_side_of_it() {
    let planner = planner(ToolBias::PEN);
    let at = |z: f64, y: f64| Pose::new(220.0, y, z, 0.0);
    let from = |z| ArmState::at_pose(&planner.geometry, &at(z, -60.0), &planner.limits).unwrap();
    let line = |z: f64, to: f64| {
        let request = Move {
            target: Target::Pose(at(to, 60.0)),
            kind: MoveKind::Line,
        };
        planner.plan(&from(z), &request).unwrap().trajectory
    };
    let fence = Fence::default().with_floor(-60.0).unwrap();
    assert_eq!(fence.check_motion(&line(-60.0, -60.0)), Ok(()));
    let breach = fence.check_motion(&line(-40.0, -71.2)).unwrap_err();
    assert_eq!((breach.part, breach.limit), (FencePart::Floor, -60.0));
    assert!((breach.value + 71.2).abs() < 1e-9, "{breach}");
    // Back in, but never further out.
    assert_eq!(fence.check_motion(&line(-70.0, -50.0)), Ok(()));
    assert_eq!(fence.check_motion(&line(-70.0, -70.0)), Ok(()));
    assert!(fence.check_motion(&line(-70.0, -70.1)).is_err());
}

#[test]
fn a_way_through_a_keep_out_is_refused_though_both_ends_are_clear() {
    let planner = planner(ToolBias::PEN);
    let at = |y| Pose::new(220.0, y, 0.0, 0.0);
    let from = ArmState::at_pose(&planner.geometry, &at(-100.0), &planner.limits).unwrap();
    let thin = Cuboid {
        min: [200.0, -0.5, -10.0],
        max: [300.0, 0.5, 10.0],
    };
    let fence = Fence::default().with_keep_out(thin).unwrap();
    for kind in [MoveKind::Joint, MoveKind::Line] {
        let target = Target::Pose(at(100.0));
        let motion = planner.plan(&from, &Move { target, kind }).unwrap();
        let breach = fence.check_motion(&motion.trajectory).unwrap_err();
        assert_eq!(breach.part, FencePart::KeepOut(0));
    }
}

#[test]
fn a_motion_is_as_fast_as_its_fastest_moment() {
    let mut dice = Dice(0x5beed);
    let planner = planner(ToolBias::PEN);
    let mut told = [0_u32; 2];
    for _ in 0..300 {
        let start = dice.pose();
        let Ok(from) = ArmState::at_pose(&planner.geometry, &start, &planner.limits) else {
            continue;
        };
        let Some(motion) = dice.motion(&planner, &from) else {
            continue;
        };
        if motion.uncut_us() != motion.duration_us() {
            continue;
        }
        let speeds = (0..2000).map(|nth| {
            let speed = motion.tool_velocity(motion.duration_us() / 2000 * nth);
            speed.x.hypot(speed.y).hypot(speed.z)
        });
        let fastest = speeds.fold(0.0, f64::max);
        let top = dice.within(0.5, 1.5) * fastest.max(1.0);
        let fence = Fence::default().with_top_speed(top).unwrap();
        match fence.check_speed_of(&motion) {
            Ok(()) => assert!(fastest <= top * 1.001, "{fastest} {top}"),
            Err(breach) => assert!(breach.value <= 1.01 * fastest + 0.1, "{breach} {fastest}"),
        }
        told[usize::from(fastest > top)] += 1;
    }
    assert!(told.iter().all(|count| *count > 50), "{told:?}");
}

#[test]
fn what_is_no_fence_is_refused() {
    let none = Fence::default();
    let upside_down = Cuboid {
        min: [0.0, 0.0, 10.0],
        max: [10.0, 10.0, 0.0],
    };
    assert!(none.is_empty() && !none.bounds_space());
    assert!(none.with_floor(f64::NAN).is_err());
    let error = none.with_box(upside_down).unwrap_err();
    assert_eq!(
        error.to_string(),
        "box: the first corner must be below the second, and is not on z"
    );
    assert!(none.with_top_speed(0.0).is_err() && none.with_top_speed(f64::INFINITY).is_err());
    assert!(none.with_strongest_laser(101.0).is_err() && none.with_strongest_laser(0.0).is_ok());
    let mut fence = none;
    let keep_out = Cuboid {
        min: [0.0; 3],
        max: [1.0; 3],
    };
    for _ in 0..Fence::MOST_KEEP_OUTS {
        fence = fence.with_keep_out(keep_out).unwrap();
    }
    assert_eq!(fence.with_keep_out(keep_out), Err(FenceError::TooMany));
}

#[test]
fn another_tool_may_not_put_the_tip_beyond() {
    let fence = Fence::default().with_floor(-60.0).unwrap();
    let arm = Geometry::magician(ToolBias::NONE);
    let longer = Geometry::magician(ToolBias::new(59.7, 0.0, 80.0));
    let [short, long] =
        [arm, longer].map(|arm| arm.forward(&JointAngles::new(0.0, 45.0, 60.0, 0.0)));
    assert!(fence.check_tool_change(&short, &long).is_err());
    assert!(fence.check_tool_change(&long, &short).is_ok());
}
