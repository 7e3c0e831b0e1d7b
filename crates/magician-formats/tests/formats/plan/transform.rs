//! Plans that are moved, scaled or turned do the same elsewhere, as shown by following their
//! commands in the preflight check.

use magician::build::{self, Output};
use magician::commands::{CircleCmd, CpCmd, CpLeCmd, HomeParams, JogCmd, PtpCmd};
use magician::preflight::{Guards, Preflight};
use magician::protocol::{CpMode, Flag, JogCommand, PtpMode};
use magician::{JointAngles, ToolBias};
use magician_formats::{Action, Origin, Pallet, Plan, Surface, Travel};
use proptest::prelude::*;

use super::strategies::cases;

fn near() -> impl Strategy<Value = [f32; 4]> {
    (
        190.0f32..230.0,
        -20.0f32..20.0,
        0.0f32..40.0,
        -20.0f32..20.0,
    )
        .prop_map(|(x, y, z, r)| [x, y, z, r])
}

fn short() -> impl Strategy<Value = [f32; 3]> {
    prop::array::uniform3(-4.0f32..4.0)
}

fn step() -> impl Strategy<Value = Action> {
    let travel = prop_oneof![Just(Travel::Joints), Just(Travel::Line), Just(Travel::Jump)];
    prop_oneof![
        (near(), travel).prop_map(|(to, by)| Action::Move { to, by }),
        (short(), any::<bool>()).prop_map(|([x, y, z], line)| Action::Shift {
            by: [x, y, z, 1.0],
            line
        }),
        (near(), near()).prop_map(|(via, to)| Action::Arc { via, to }),
        near().prop_map(|[x, y, z, _]| Action::Path { to: [x, y, z] }),
        near().prop_map(|[x, y, z, _]| Action::Burn {
            to: [x, y, z],
            power: 50.0
        }),
        short()
            .prop_map(|[x, y, z]| CpCmd {
                cp_mode: CpMode::Relative,
                x,
                y,
                z,
                velocity_or_power: 0.0
            })
            .prop_map(command),
        short()
            .prop_map(|[x, y, z]| CpLeCmd {
                cp_mode: CpMode::Relative,
                x,
                y,
                z,
                velocity_or_power: 9.0
            })
            .prop_map(command),
        (near(), near()).prop_map(|(cir_point, to_point)| command(CircleCmd {
            cir_point,
            to_point,
            count: 1
        })),
        near().prop_map(|[x, y, z, r]| command(PtpCmd {
            ptp_mode: PtpMode::JumpMovlXyz,
            x,
            y,
            z,
            r
        })),
        near().prop_map(|[x, y, z, r]| {
            let output = Output {
                percent: 10,
                address: 17,
                high: true,
            };
            Action::from(build::with_outputs(build::line_to(x, y, z, r), &[output]).unwrap())
        }),
        short().prop_map(|[x, y, z]| Action::from(
            build::with_rail(build::line_by(x, y, z, 0.0), 100.0).unwrap()
        )),
        Just(Action::Wait(10)),
        Just(Action::from(build::jump_height(10.0, 90.0))),
    ]
}

fn command(set: impl Into<magician::Set>) -> Action {
    Action::from(set.into())
}

fn program() -> impl Strategy<Value = Plan> {
    (near(), prop::collection::vec(step(), 1..10)).prop_map(|(to, steps)| {
        let mut plan = Plan::new("any");
        plan.surface = Some(Surface {
            height: -50.0,
            slope: [0.02, -0.01],
        });
        plan.push(
            Action::Move {
                to,
                by: Travel::Joints,
            },
            Origin::NONE,
        );
        for action in steps {
            plan.push(action, Origin::NONE);
        }
        plan
    })
}

/// Returns the end of each step; `None` for a step that the check refuses.
fn ends(plan: &Plan) -> Vec<Option<[f64; 4]>> {
    let guards = Guards::default().laser(false);
    let mut arm = Preflight::at(JointAngles::HOME, ToolBias::NONE).guards(guards);
    let end = |command| {
        let done = arm.check(&command).ok()?;
        done.end.map(|end| end.pose.to_array())
    };
    plan.commands().map(end).collect()
}

/// Asserts that the ends of two plans agree within the rounding of 32-bit numbers. Paths keep J4
/// instead of r, so r is not compared between a path and the next move.
fn is_same(
    plan: &Plan,
    changed: &Plan,
    map: impl Fn([f64; 4]) -> [f64; 4],
) -> Result<(), TestCaseError> {
    let (mut still, mut compared) = (true, 0);
    for (step, (one, other)) in plan
        .steps
        .iter()
        .zip(ends(plan).into_iter().zip(ends(changed)))
    {
        let is_path = matches!(
            step.action.command(),
            Some(magician::Set::CpCmd(_) | magician::Set::CpLeCmd(_))
        );
        let (Some(one), Some(other)) = (one, other) else {
            // A step of one plan is beyond a limit: from there the plans continue from different
            // positions.
            return Ok(());
        };
        still &= !is_path;
        let expected = map(one);
        for axis in 0..if still { 4 } else { 3 } {
            let off = (expected[axis] - other[axis]).abs();
            prop_assert!(off < 2e-3, "{:?}: {:?} {:?}", step.action, expected, other);
        }
        still |= matches!(step.action, Action::Move { .. });
        compared += 1;
    }
    prop_assert!(compared > 0);
    Ok(())
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn moved_plan_ends_at_the_offset(plan in program(), by in prop::array::uniform3(-15.0f64..15.0)) {
        let moved = plan.moved(by).unwrap();
        is_same(&plan, &moved, |[x, y, z, r]| [x + by[0], y + by[1], z + by[2], r])?;
        let surface = moved.surface.unwrap();
        let before = plan.surface.unwrap().at([200.0, 10.0]);
        prop_assert!((surface.at([200.0 + by[0], 10.0 + by[1]]) - before - by[2]).abs() < 1e-9);
    }

    #[test]
    fn rotated_plan_ends_rotated(plan in program(), degrees in -60.0f64..60.0, centre in (-5.0f64..5.0, -5.0f64..5.0)) {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let turned = plan.rotated(degrees, [centre.0, centre.1]).unwrap();
        is_same(&plan, &turned, |[x, y, z, r]| {
            let (x, y) = (x - centre.0, y - centre.1);
            [x * cos - y * sin + centre.0, x * sin + y * cos + centre.1, z, r + degrees]
        })?;
    }

    #[test]
    fn scaled_plan_ends_in_proportion(plan in program(), factor in 0.5f64..1.2) {
        let about = [210.0, 0.0, 20.0];
        let scaled = plan.scaled(factor, about).unwrap();
        is_same(&plan, &scaled, |[x, y, z, r]| {
            let at = |value: f64, about: f64| factor * (value - about) + about;
            [at(x, about[0]), at(y, about[1]), at(z, about[2]), r]
        })?;
    }

    #[test]
    fn plan_scaled_on_its_surface_keeps_its_heights(plan in program(), factor in 0.5f64..1.2) {
        let about = [210.0, 0.0];
        let scaled = plan.scaled_xy(factor, about).unwrap();
        is_same(&plan, &scaled, |[x, y, z, r]| {
            let at = |value: f64, about: f64| factor * (value - about) + about;
            [at(x, about[0]), at(y, about[1]), z, r]
        })?;
    }

    #[test]
    fn mirrored_plan_ends_on_the_other_side(plan in program()) {
        let mirrored = plan.mirrored(215.0).unwrap();
        is_same(&plan, &mirrored, |[x, y, z, r]| [430.0 - x, y, z, -r])?;
        prop_assert_eq!(mirrored.mirrored(215.0).unwrap(), plan);
    }

    #[test]
    fn four_quarter_turns_and_doubling_and_halving_change_nothing(plan in program()) {
        let mut turned = plan.clone();
        for _ in 0..4 {
            turned = turned.rotated(90.0, [0.0, 0.0]).unwrap();
        }
        for (step, back) in plan.steps.iter().zip(&turned.steps) {
            prop_assert_eq!(step.action.target(), back.action.target());
        }
        let back = plan.scaled(2.0, [0.0; 3]).unwrap().scaled(0.5, [0.0; 3]).unwrap();
        prop_assert_eq!(back, plan);
    }
}

#[test]
fn step_without_a_position_is_refused_by_number() {
    let refused = |action: Action, part: &str| {
        let mut plan = Plan::new("p");
        let name = plan.name("corner");
        plan.push(Action::Wait(1), Origin::NONE);
        plan.push(
            action,
            Origin {
                line: 7,
                column: 2,
                ..Origin::NONE
            }
            .named(name),
        );
        for changed in [
            plan.moved([1.0, 0.0, 0.0]),
            plan.placed_on(&Pallet::grid(2, 2, [1.0, 1.0])),
        ] {
            let diagnostic = changed.expect_err(part);
            let text = diagnostic.to_string();
            assert!(
                text.starts_with("line 7, column 2 (corner): step 2 cannot be moved: it "),
                "{text}"
            );
            assert!(text.contains(part), "{text}");
        }
    };
    refused(
        Action::Joints {
            to: [0.0; 4],
            by: Travel::Joints,
        },
        "joint angles",
    );
    refused(
        Action::from(build::move_joints_by(1.0, 0.0, 0.0, 0.0)),
        "joint angles",
    );
    refused(
        command(HomeParams {
            x: 200.0,
            y: 0.0,
            z: 0.0,
            r: 0.0,
        }),
        "where homing ends",
    );
    refused(
        command(JogCmd {
            is_joint: Flag::OFF,
            cmd: JogCommand::Stop,
        }),
        "is a jog",
    );
    refused(
        Action::Shift {
            by: [1.0; 4],
            line: true,
        },
        "starts at the arm's position",
    );
    refused(
        Action::Arc {
            via: [1.0; 4],
            to: [2.0; 4],
        },
        "starts at the arm's position",
    );
    let ptp_mode = PtpMode::Unknown(77);
    refused(
        command(PtpCmd {
            ptp_mode,
            x: 0.0,
            y: 0.0,
            z: 0.0,
            r: 0.0,
        }),
        "does not exist",
    );

    let mut after_home = Plan::new("p");
    after_home.push(
        Action::Move {
            to: [200.0, 0.0, 0.0, 0.0],
            by: Travel::Line,
        },
        Origin::NONE,
    );
    after_home.push(
        Action::Shift {
            by: [1.0; 4],
            line: true,
        },
        Origin::NONE,
    );
    assert!(after_home.moved([1.0, 0.0, 0.0]).is_ok());
    after_home.push(Action::Home, Origin::NONE);
    assert!(after_home.moved([1.0, 0.0, 0.0]).is_ok());
    after_home.push(
        Action::Shift {
            by: [1.0; 4],
            line: true,
        },
        Origin::NONE,
    );
    assert!(after_home.moved([1.0, 0.0, 0.0]).is_err());

    let plan = Plan::new("p");
    assert!(plan.moved([f64::NAN, 0.0, 0.0]).is_err());
    assert!(plan.scaled(0.0, [0.0; 3]).is_err() && plan.scaled(-1.0, [0.0; 3]).is_err());
    assert!(plan.rotated(f64::INFINITY, [0.0; 2]).is_err());
}

#[test]
fn relative_programs_rotate_and_scale_in_place() {
    let mut plan = Plan::new("p");
    plan.push(
        Action::Shift {
            by: [10.0, 0.0, 5.0, 3.0],
            line: true,
        },
        Origin::NONE,
    );
    let turned = plan.rotated(90.0, [0.0; 2]).unwrap();
    assert_eq!(
        turned.steps[0].action,
        Action::Shift {
            by: [0.0, 10.0, 5.0, 3.0],
            line: true
        }
    );
    let grown = plan.scaled(2.0, [0.0; 3]).unwrap();
    assert_eq!(
        grown.steps[0].action,
        Action::Shift {
            by: [20.0, 0.0, 10.0, 3.0],
            line: true
        }
    );
}

#[test]
fn jump_heights_are_transformed() {
    let mut plan = Plan::new("p");
    plan.push(build::jump_height(20.0, 80.0), Origin::NONE);
    plan.push(build::jump_heights(20.0, 10.0, 80.0), Origin::NONE);
    let up = plan.moved([0.0, 0.0, 15.0]).unwrap();
    let commands: Vec<_> = up.commands().collect();
    assert_eq!(
        commands,
        [
            build::jump_height(20.0, 95.0),
            build::jump_heights(20.0, 10.0, 95.0)
        ]
    );
    let half = plan.scaled(0.5, [0.0; 3]).unwrap();
    let commands: Vec<_> = half.commands().collect();
    assert_eq!(
        commands,
        [
            build::jump_height(10.0, 40.0),
            build::jump_heights(10.0, 5.0, 40.0)
        ]
    );
}

#[test]
fn a_pallet_fills_row_by_row_from_three_corners() {
    let mut plan = Plan::new("drop");
    plan.push(
        Action::Move {
            to: [200.0, 0.0, 0.0, 0.0],
            by: Travel::Jump,
        },
        Origin::NONE,
    );
    let corners = [[200.0, 0.0, 0.0], [220.0, 0.0, 4.0], [200.0, 30.0, 0.0]];
    let places = |plan: &Plan| {
        plan.steps
            .iter()
            .filter_map(|step| step.action.target())
            .collect::<Vec<_>>()
    };
    let placed = plan.placed_on(&Pallet::corners(2, 3, corners)).unwrap();
    let expected = [
        [200.0, 0.0, 0.0],
        [210.0, 0.0, 2.0],
        [220.0, 0.0, 4.0],
        [200.0, 30.0, 0.0],
        [210.0, 30.0, 2.0],
        [220.0, 30.0, 4.0],
    ];
    assert_eq!(places(&placed), expected);
    let single = plan.placed_on(&Pallet::corners(1, 1, corners)).unwrap();
    assert_eq!(places(&single), expected[..1]);
    for (rows, columns) in [(0, 3), (3, 0), (usize::MAX, 3), (1 << 20, 1 << 20)] {
        assert!(
            plan.placed_on(&Pallet::grid(rows, columns, [1.0, 1.0]))
                .is_err()
        );
    }
    assert!(
        plan.placed_on(&Pallet::grid(2, 2, [f64::NAN, 1.0]))
            .is_err()
    );
}

#[test]
fn repeated_plan_repeats_its_steps() {
    let mut plan = Plan::new("p");
    plan.push(Action::Home, Origin::NONE);
    plan.push(Action::Wait(5), Origin::NONE);
    let three = plan.repeated(3).unwrap();
    assert_eq!(three.steps.len(), 6);
    assert_eq!(three.steps[4..], plan.steps[..]);
    assert!(plan.repeated(0).unwrap().steps.is_empty());
    assert!(plan.repeated(usize::MAX).is_err());
    assert!(Plan::new("empty").repeated(usize::MAX).is_err());
}
