//! A plan started at one of its steps ends like the whole plan, with the same settings.

use magician::build;
use magician::preflight::{Guards, Preflight, Readings};
use magician::protocol::{PtpMode, RailVersion};
use magician::{JointAngles, Set, ToolBias, commands};
use magician_program::{Action, Continuation, Plan, Tool, Travel, check};
use proptest::prelude::*;

use super::bench::LoneArm;
use super::programs::{accepted, cases, plan};
use super::{line, plan_of};

fn at_home() -> Preflight {
    Preflight::at(JointAngles::HOME, ToolBias::NONE)
}

fn targets(rest: &Continuation) -> Vec<[f32; 3]> {
    rest.plan
        .steps
        .iter()
        .filter_map(|step| step.action.target())
        .collect()
}

proptest! {
    #![proptest_config(cases(250))]

    #[test]
    fn remainder_ends_at_the_same_pose_with_the_same_settings(plan in plan(), step in any::<prop::sample::Index>()) {
        let mut whole = LoneArm::new();
        let start = Preflight::new(&whole.readings());
        let plan = accepted(plan, &start);
        let step = step.index(plan.steps.len());
        let rest = match Continuation::from_step(&plan, step, &start) {
            Ok(rest) => rest,
            Err(diagnostic) => {
                // Homing, an unknown rail position, or a step that no detour reaches.
                let known = ["is unknown when step", "the arm cannot reach the begin of"];
                prop_assert!(known.iter().any(|part| diagnostic.message.contains(part)), "{diagnostic}");
                return Ok(());
            }
        };
        prop_assert_eq!(rest.steps.len(), rest.plan.steps.len());
        let added = rest.plan.steps.len() - (plan.steps.len() - step);
        prop_assert_eq!(&rest.plan.steps[added..], &plan.steps[step..]);
        prop_assert!(rest.steps[..added].iter().all(|of| *of == step));
        prop_assert!(rest.steps[added..].iter().copied().eq(step..plan.steps.len()));

        // Paths round their start to 32 bits: what was just within a limit may then be outside.
        let report = check(&rest.plan, &start);
        prop_assert!(report.is_good(), "{:?}\n{:?}", report.refused_steps, rest);
        let mut part = LoneArm::new();
        prop_assert_eq!(whole.run_plan(&plan).alarm, None);
        prop_assert_eq!(part.run_plan(&rest.plan).alarm, None);
        let (mut whole_says, mut part_says) = (whole.readings(), part.readings());
        let poses = [whole_says.pose.take().unwrap(), part_says.pose.take().unwrap()];
        let [one, other] = poses.map(|pose| pose.joint_angle);
        let off = one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f32::max);
        prop_assert!(off < 1e-2, "{:?} {:?}", one, other);
        prop_assert_eq!(whole_says, part_says);
        prop_assert_eq!(whole.tools(), part.tools());
    }
}

#[test]
fn lead_in_goes_up_across_and_down_and_paths_begin_at_their_segment() {
    let plan = plan_of([
        line([220.0, 0.0, 20.0]),
        line([220.0, 0.0, -10.0]),
        Action::Path {
            to: [220.0, 10.0, -10.0],
        },
        Action::Path {
            to: [230.0, 10.0, -10.0],
        },
        line([230.0, 10.0, 20.0]),
    ]);
    let mut arm = at_home();
    arm.check(&build::line_to(200.0, -30.0, -20.0, 0.0))
        .unwrap();
    let rest = Continuation::from_step(&plan, 3, &arm).unwrap();
    let expected = [
        [200.0, -30.0, 20.0],
        [220.0, 10.0, 20.0],
        [220.0, 10.0, -10.0],
        [230.0, 10.0, -10.0],
        [230.0, 10.0, 20.0],
    ];
    assert_eq!(targets(&rest), expected);
    assert_eq!(rest.steps, [3, 3, 3, 3, 4]);
    assert!(check(&rest.plan, &arm).is_good());
    // At its own start no approach is needed.
    for command in plan.commands().take(3) {
        arm.check(&command).unwrap();
    }
    assert_eq!(
        Continuation::from_step(&plan, 3, &arm).unwrap().plan.steps,
        plan.steps[3..]
    );
    assert_eq!(Continuation::from_step(&plan, 0, &arm).unwrap().plan, plan);
}

#[test]
fn lead_in_clears_the_jump_height() {
    let jump = |x: f32, y: f32| Action::Move {
        to: [x, y, -20.0, 0.0],
        by: Travel::Jump,
    };
    let plan = plan_of([
        Action::from(build::jump_height(60.0, 30.0)),
        jump(220.0, 0.0),
        jump(220.0, 50.0),
        jump(220.0, 0.0),
    ]);
    let rest = Continuation::from_step(&plan, 3, &at_home()).unwrap();
    assert_eq!(
        targets(&rest)[1],
        [220.0, 50.0, 30.0],
        "as high as the limit of the jumps"
    );
}

#[test]
fn laser_is_off_on_the_lead_in_and_on_again_at_its_end() {
    let plan = plan_of([
        line([220.0, 0.0, 0.0]),
        Action::Laser(true),
        line([240.0, 0.0, 0.0]),
        line([240.0, 20.0, 0.0]),
        Action::Laser(false),
    ]);
    let rest = Continuation::from_step(&plan, 3, &at_home()).unwrap();
    let kinds: Vec<_> = rest
        .plan
        .steps
        .iter()
        .map(|step| step.action.clone())
        .collect();
    assert_eq!(kinds[0], Action::Laser(false));
    assert_eq!(
        kinds[kinds.len() - 3..],
        [
            Action::Laser(true),
            line([240.0, 20.0, 0.0]),
            Action::Laser(false)
        ]
    );
    assert!(check(&rest.plan, &at_home()).is_good());
    let engraved = plan_of([
        line([220.0, 0.0, 0.0]),
        Action::Burn {
            to: [230.0, 0.0, 0.0],
            power: 50.0,
        },
        Action::Burn {
            to: [240.0, 0.0, 0.0],
            power: 60.0,
        },
        Action::Laser(false),
    ]);
    let rest = Continuation::from_step(&engraved, 2, &at_home()).unwrap();
    assert_eq!(rest.plan.steps[0].action, Action::Laser(false));
    assert!(check(&rest.plan, &at_home()).is_good());
}

#[test]
fn only_the_last_value_of_each_setting_is_resent() {
    let output = build::Output {
        percent: 90,
        address: 17,
        high: true,
    };
    let early = build::Output {
        percent: 10,
        address: 17,
        high: false,
    };
    let switching =
        build::with_outputs(build::line_to(220.0, 0.0, 0.0, 0.0), &[output, early]).unwrap();
    let stepper = magician::protocol::Stepper::Stepper1;
    let other = magician::protocol::Stepper::Stepper2;
    let mut plan = plan_of([
        Action::from(build::speed(10.0, 10.0)),
        Action::from(build::output(3, true)),
        Action::from(build::output(4, true)),
        Action::from(build::speed(50.0, 50.0)),
        Action::Suction(true),
        Action::from(build::output(3, false)),
        Action::from(switching),
        Action::Wait(1000),
        Action::from(build::conveyor(stepper, 20.0)),
        Action::from(build::conveyor_by(other, 20.0, 10.0)),
        line([230.0, 0.0, 0.0]),
    ]);
    plan.tool = Some(Tool::Suction);
    let rest = Continuation::from_step(&plan, 10, &at_home()).unwrap();
    let told: Vec<Set> = rest
        .plan
        .steps
        .iter()
        .filter_map(|step| step.action.command())
        .collect();
    let expected = [
        build::output(4, true),
        build::speed(50.0, 50.0),
        build::suction(true),
        build::output(3, false),
        build::output(17, true),
        build::conveyor(stepper, 20.0),
    ];
    assert_eq!(told[..6], expected);
    assert_eq!(rest.plan.tool, plan.tool);
}

#[test]
fn rail_is_restored_or_refused_if_unknown() {
    let on_rail =
        |l: f32| Action::from(build::with_rail(build::line_to(220.0, 0.0, 20.0, 0.0), l).unwrap());
    let plan = plan_of([
        Action::from(build::rail(true, RailVersion::V1)),
        on_rail(300.0),
        Action::from(build::rail_by(50.0)),
        line([230.0, 0.0, 0.0]),
    ]);
    let mut readings = LoneArm::new().readings();
    readings.rail = Some(0.0);
    let arm = Preflight::new(&readings);
    let rest = Continuation::from_step(&plan, 3, &arm).unwrap();
    let carried: Vec<f32> = rest
        .plan
        .commands()
        .filter_map(|command| match command {
            Set::PtpWithLCmd(ptp) => Some(ptp.l),
            _ => None,
        })
        .collect();
    assert_eq!(carried, [350.0]);
    let lost = plan_of([
        Action::from(build::rail(true, RailVersion::V1)),
        Action::from(build::rail_by(50.0)),
        line([230.0, 0.0, 0.0]),
    ]);
    let diagnostic = Continuation::from_step(&lost, 2, &arm).unwrap_err();
    assert!(
        diagnostic.message.contains("position on the rail"),
        "{diagnostic}"
    );
}

#[test]
fn unknown_state_is_refused_with_advice() {
    let plan = plan_of([
        Action::Home,
        Action::Shift {
            by: [10.0, 0.0, 0.0, 0.0],
            line: true,
        },
        Action::Move {
            to: [220.0, 0.0, 0.0, 0.0],
            by: Travel::Joints,
        },
        line([230.0, 0.0, 0.0]),
        line([240.0, 0.0, 0.0]),
    ]);
    let arm = at_home().guards(Guards::NONE);
    let diagnostic = Continuation::from_step(&plan, 1, &arm).unwrap_err();
    assert_eq!(
        diagnostic.to_string(),
        "line 2, column 1: the position of the arm is unknown when step 2 begins"
    );
    let help = diagnostic.help.unwrap();
    assert!(help.contains("begin with step 4"), "{help}");
    assert!(Continuation::from_step(&plan, 3, &arm).is_ok());
    let guarded = Continuation::from_step(&plan, 3, &at_home()).unwrap_err();
    assert!(
        guarded
            .to_string()
            .starts_with("line 2, column 1: the earlier step 2 cannot be done: "),
        "{guarded}"
    );
    let beyond = Continuation::from_step(&plan, 5, &arm).unwrap_err();
    assert_eq!(beyond.to_string(), "there is no step 6: the plan has 5");
    assert!(Continuation::from_step(&Plan::default(), 0, &arm).is_ok());
}

#[test]
fn unknown_start_is_approached_from_above() {
    let plan = plan_of([
        Action::Move {
            to: [220.0, 0.0, 30.0, 0.0],
            by: Travel::Joints,
        },
        line([230.0, 0.0, 0.0]),
        line([240.0, 0.0, 0.0]),
    ]);
    let rest = Continuation::from_step(&plan, 2, &Preflight::new(&Readings::default())).unwrap();
    assert_eq!(
        targets(&rest),
        [[230.0, 0.0, 30.0], [230.0, 0.0, 0.0], [240.0, 0.0, 0.0]]
    );
    let by = match rest.plan.steps[0].action.command().expect("it has one") {
        Set::PtpCmd(commands::PtpCmd { ptp_mode, .. }) => ptp_mode,
        other => panic!("{other:?}"),
    };
    assert_eq!(by, PtpMode::MovjXyz);
}

/// An impossible arm: an endless tool, and jumps to match.
#[test]
fn lead_in_search_is_bounded() {
    let plan = plan_of([
        Action::from(build::jump_height(1e30, 1e30)),
        Action::from(build::tool(ToolBias::new(1e34, 0.0, 1e33))),
        Action::Shift {
            by: [1.0, 0.0, 0.0, 0.0],
            line: true,
        },
        Action::Wait(1),
    ]);
    let arm = at_home().guards(Guards::NONE);
    for step in 0..4 {
        let _ = Continuation::from_step(&plan, step, &arm);
    }
}
