//! Programs on arms of random firmware: the check and the virtual arm share a model, and agree on
//! the result.

use magician::build;
use magician::commands::{ArcCmd, CpParams};
use magician::preflight::{Guards, Preflight};
use magician::protocol::{Flag, RailVersion};
use magician::sim::Profile;
use magician::{Set, ToolBias};
use magician_motion::{ArmModel, Range};

use crate::bench::{Dice, LoneArm};

const PROFILES: usize = 600;
const LENGTH: u64 = 14;
const SEED: u64 = 20_261_129;

/// Returns a firmware that differs in everything motions depend on.
fn firmware(dice: &mut Dice) -> Profile {
    let mut profile = Profile::default();
    let mut times = |value: &mut f64| *value *= dice.between(0.3, 2.0);
    let ceilings = &mut profile.ceilings;
    ceilings.joint_velocity.iter_mut().for_each(&mut times);
    for ceiling in [
        &mut ceilings.joint_acceleration,
        &mut ceilings.linear_velocity,
        &mut ceilings.linear_acceleration,
        &mut ceilings.rotation_velocity,
        &mut ceilings.rotation_acceleration,
    ] {
        times(ceiling);
    }
    times(&mut profile.path.period);
    profile.motion.period = [0.0, 0.02, 0.008, 0.05][dice.roll(4) as usize];
    profile.rail.length = dice.between(100.0, 1000.0);
    let limits = &mut profile.limits.controller;
    for Range { min, max } in [
        &mut limits.j1,
        &mut limits.j2,
        &mut limits.j3,
        &mut limits.j4,
        &mut limits.j2_minus_j3,
    ] {
        *min *= dice.between(0.4, 1.1);
        *max *= dice.between(0.6, 1.1);
    }
    let speed = |dice: &mut Dice| dice.number(20.0, 500.0);
    let ptp = &mut profile.defaults.ptp;
    ptp.joint_velocity = [0; 4].map(|_| speed(dice));
    ptp.joint_acceleration = [0; 4].map(|_| speed(dice));
    ptp.linear_velocity = speed(dice);
    ptp.linear_acceleration = speed(dice);
    ptp.rotation_velocity = speed(dice);
    ptp.rotation_acceleration = speed(dice);
    ptp.velocity_ratio = dice.number(10.0, 120.0);
    ptp.acceleration_ratio = dice.number(10.0, 120.0);
    ptp.jump_height = dice.number(0.0, 40.0);
    ptp.z_limit = dice.number(0.0, 150.0);
    ptp.rail_velocity = speed(dice);
    ptp.rail_acceleration = speed(dice);
    let cp = &mut profile.defaults.cp;
    cp.plan_acceleration = speed(dice);
    cp.junction_velocity = speed(dice);
    cp.acceleration = dice.number(5.0, 50.0);
    cp.real_time_track = dice.roll(4) == 0;
    profile.power_up.tool = [
        ToolBias::NONE,
        ToolBias::PEN,
        ToolBias::new(dice.between(0.0, 80.0), dice.between(-20.0, 20.0), 13.3),
    ][dice.roll(3) as usize];
    profile.power_up.joints = [
        dice.between(-30.0, 30.0),
        dice.between(20.0, 40.0),
        dice.between(20.0, 40.0),
        dice.between(-30.0, 30.0),
    ];
    profile
}

/// Returns a pose near another.
fn near(dice: &mut Dice, [x, y, z, r]: [f64; 4], by: f32) -> [f32; 4] {
    let [dx, dy, dz, dr] = dice.numbers([(-by, by); 4]);
    [x as f32 + dx, y as f32 + dy, z as f32 + dz, r as f32 + dr]
}

fn setting(dice: &mut Dice) -> Set {
    let speed = |dice: &mut Dice| dice.number(20.0, 500.0);
    match dice.roll(7) {
        0 => build::speed(dice.number(10.0, 100.0), dice.number(10.0, 100.0)),
        1 => build::line_speed(speed(dice), speed(dice)),
        2 => build::joint_speed([0; 4].map(|_| speed(dice)), [0; 4].map(|_| speed(dice))),
        3 => build::jump_height(dice.number(0.0, 60.0), dice.number(0.0, 150.0)),
        4 => build::jump_heights(
            dice.number(0.0, 60.0),
            dice.number(0.0, 60.0),
            dice.number(0.0, 150.0),
        ),
        5 => build::rail_speed(speed(dice), speed(dice)),
        _ => CpParams {
            plan_acc: speed(dice),
            junction_vel: speed(dice),
            acc_or_period: dice.number(5.0, 50.0),
            real_time_track: Flag::from(dice.roll(3) == 0),
        }
        .into(),
    }
}

fn motion(dice: &mut Dice, check: &Preflight, model: &ArmModel) -> Set {
    let pose = check.arm().expect("it is known").pose.to_array();
    let [x, y, z, r] = near(dice, pose, 40.0);
    let [dx, dy, dz, dr] = dice.numbers([(-15.0, 15.0); 4]);
    let place = dice.number(0.0, 1.05 * model.rail.length as f32);
    match dice.roll(16) {
        0 => build::move_to(x, y, z, r),
        1 => build::line_to(x, y, z, r),
        2 => build::jump_to(x, y, z, r),
        3 => build::jump_line_to(x, y, z, r),
        4 => build::move_by(dx, dy, dz, dr),
        5 => build::line_by(dx, dy, dz, dr),
        6 => build::move_joints_by(dx, dy, dz, dr),
        7 => {
            let ends = dice.numbers([(-90.0, 90.0), (0.0, 70.0), (0.0, 70.0), (-90.0, 90.0)]);
            let [j1, j2, j3, j4] = ends;
            build::move_joints(j1, j2, j3, j4)
        }
        8 => ArcCmd {
            cir_point: near(dice, pose, 10.0),
            to_point: [x, y, z, r],
        }
        .into(),
        9 => build::wait(std::time::Duration::from_millis(dice.roll(100))),
        10 | 11 => build::move_with_rail(x, y, z, r, place),
        12 => build::with_rail(build::line_by(dx, dy, dz, dr), 5.0 * dx).unwrap(),
        _ => build::path_by(dx, dy, dz),
    }
}

/// Counts of outcomes.
#[derive(Debug, Default)]
struct Tally {
    done: usize,
    refused: usize,
    at_rail_ends: usize,
}

/// Checks a program and runs it. Either both succeed, in the same time to the microsecond and with
/// the same joints, or neither does.
fn hold(profile: &Profile, program: &[Set], check: &Preflight, tally: &mut Tally) {
    let mut bench = LoneArm::with(profile.clone());
    let told = format!("{program:#?}\nof {:#?}", profile.arm_model());
    let error = match check.clone().program(program) {
        Ok(checked) => {
            let took = bench.run_all(program);
            let state = bench.arm.state();
            assert!(!bench.alarmed(), "{} by {told}", state.alarms);
            let end = checked.end().expect("it is known");
            assert_eq!(checked.time().as_micros(), u128::from(took), "{told}");
            assert_eq!(state.joints, end.joints, "{told}");
            tally.done += 1;
            return;
        }
        Err(error) => error,
    };
    bench.run_all(program);
    if error.message().contains("the rail would be") {
        // The carriage stops at the end of the rail, without an alarm.
        let mut to_there = LoneArm::with(profile.clone());
        to_there.run_all(&program[..=error.step().expect("its step")]);
        let ends = [0.0, profile.rail.length].map(Some);
        assert!(
            ends.contains(&to_there.arm.state().rail),
            "{error} by {told}"
        );
        tally.at_rail_ends += 1;
    } else {
        assert!(bench.alarmed(), "{error} by {told}");
        tally.refused += 1;
    }
}

#[test]
fn check_and_run_agree_on_arms_of_any_firmware() {
    let mut dice = Dice::new(SEED);
    let mut tally = Tally::default();
    for _ in 0..PROFILES {
        let profile = firmware(&mut dice);
        profile.check().expect("a profile that makes sense");
        let model = profile.arm_model();
        let start = Preflight::of_model(&model, model.power_up.joints, model.geometry.tool)
            .guards(Guards::default().laser(false));
        if model.limits.check(&model.power_up.joints).is_err() {
            continue;
        }
        let start = start.on_rail(0.0);
        let mut program = vec![build::rail(true, RailVersion::V1)];
        let mut course = start.clone();
        course.check(&program[0]).expect("a rail");
        for _ in 0..LENGTH {
            let next = match dice.roll(3) {
                0 => setting(&mut dice),
                _ => motion(&mut dice, &course, &model),
            };
            program.push(next);
            // The first refused command ends the program.
            if course.check(&next).is_err() {
                break;
            }
        }
        hold(&profile, &program, &start, &mut tally);
    }
    println!("{tally:?}");
    assert!(
        tally.done > 50 && tally.refused > 50 && tally.at_rail_ends > 10,
        "{tally:?}"
    );
}
