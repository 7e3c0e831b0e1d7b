//! Random programs of all kinds of motion, with the settings that affect them: a program that
//! passes raises no alarm, takes the estimated time and ends at the estimated position; a refused
//! one would have raised an alarm.

use magician::build::{self, Output};
use magician::commands::{ArcCmd, CircleCmd, CpCmd, CpLeCmd, PtpCmd};
use magician::preflight::{Guards, Preflight, Readings};
use magician::protocol::{CpMode, PtpMode, RailVersion};
use magician::sim::Profile;
use magician::{Geometry, JointAngles, Set, ToolBias};
use magician_motion::ArmModel;

use crate::bench::{Dice, LoneArm};

const PROGRAMS: usize = 2_000;
const LENGTH: usize = 12;
const SEED: u64 = 20_260_801;

/// Returns joints anywhere within the limits, ignoring the coupled one.
fn joints(dice: &mut Dice) -> [f32; 4] {
    dice.numbers([
        (-135.0, 135.0),
        (-5.0, 90.0),
        (-15.0, 90.0),
        (-150.0, 150.0),
    ])
}

/// Returns joints that the arm can reach, including the coupled limit.
fn posture(dice: &mut Dice) -> [f32; 4] {
    loop {
        let joints = joints(dice);
        let angles = JointAngles::from(joints.map(f64::from));
        if ArmModel::MAGICIAN.limits.check(&angles).is_ok() {
            return joints;
        }
    }
}

/// Returns a reachable pose in most cases, and now and then any pose near one.
fn pose(dice: &mut Dice, geometry: &Geometry) -> [f32; 4] {
    if dice.roll(4) == 0 {
        return dice.numbers([
            (-340.0, 340.0),
            (-340.0, 340.0),
            (-160.0, 180.0),
            (-180.0, 180.0),
        ]);
    }
    let angles = JointAngles::from(posture(dice).map(f64::from));
    geometry
        .forward(&angles)
        .to_array()
        .map(|value| value as f32)
}

fn near(dice: &mut Dice, [x, y, z, r]: [f32; 4], by: f32) -> [f32; 4] {
    let [dx, dy, dz, dr] = dice.numbers([(-by, by); 4]);
    [x + dx, y + dy, z + dz, r + dr]
}

/// Returns a random setting of a kind that programs change.
fn setting(dice: &mut Dice) -> Set {
    let ratio = |dice: &mut Dice| dice.number(1.0, 120.0);
    let speed = |dice: &mut Dice| dice.number(5.0, 600.0);
    match dice.roll(9) {
        0 => build::speed(ratio(dice), ratio(dice)),
        1 => build::line_speed(speed(dice), speed(dice)),
        2 => build::joint_speed([0; 4].map(|_| speed(dice)), [0; 4].map(|_| speed(dice))),
        3 => build::jump_height(dice.number(0.0, 60.0), dice.number(-50.0, 170.0)),
        4 => build::jump_heights(
            dice.number(0.0, 60.0),
            dice.number(0.0, 60.0),
            dice.number(-50.0, 170.0),
        ),
        5 => build::arc_speed(speed(dice), speed(dice)),
        6 => build::path_speed(speed(dice), speed(dice)),
        7 => build::rail_speed(speed(dice), speed(dice)),
        // Invalid speeds, which are refused.
        _ => build::speed(0.0, dice.number(-5.0, 1.0)),
    }
}

/// Returns a random command, from the current position.
fn command(dice: &mut Dice, from: [f32; 4], geometry: &Geometry) -> Set {
    match dice.roll(20) {
        0 => setting(dice),
        1 => build::wait(std::time::Duration::from_millis(dice.roll(2000))),
        2 if dice.roll(4) == 0 => build::home(),
        2 => build::home_at(200.0, dice.number(-50.0, 50.0), dice.number(0.0, 60.0), 0.0),
        3 => {
            let x = [0.0, 59.7, 70.0, dice.between(-20.0, 80.0)][dice.roll(4) as usize];
            let (y, z) = (dice.between(-30.0, 30.0), dice.between(-40.0, 60.0));
            build::tool(match dice.roll(2) {
                0 => ToolBias::new(x, 0.0, 0.0),
                _ => ToolBias::new(x, y, z),
            })
        }
        4 => build::rail(dice.roll(3) > 0, RailVersion::V1),
        5 => match dice.roll(2) {
            0 => build::rail_by(dice.number(-300.0, 300.0)),
            _ => build::conveyor_by(
                magician::protocol::Stepper::Stepper1,
                dice.number(-200.0, 200.0),
                dice.number(1.0, 100.0),
            ),
        },
        6 | 7 => {
            let by = [3.0, 30.0, 120.0][dice.roll(3) as usize];
            let (via, to) = (near(dice, from, by), near(dice, from, by));
            arc(dice, via, to)
        }
        8..=11 => {
            let by = [1.0, 10.0, 100.0][dice.roll(3) as usize];
            let absolute = near(dice, from, by);
            let [x, y, z, _] = match dice.roll(2) {
                0 => absolute,
                _ => dice.numbers([(-by, by); 4]),
            };
            let cp_mode = if absolute == [x, y, z, absolute[3]] {
                CpMode::Absolute
            } else {
                CpMode::Relative
            };
            segment(dice, cp_mode, [x, y, z])
        }
        _ => travel(dice, from, geometry),
    }
}

fn arc(dice: &mut Dice, cir_point: [f32; 4], to_point: [f32; 4]) -> Set {
    match dice.roll(3) {
        0 => CircleCmd {
            cir_point,
            to_point,
            count: dice.roll(4) as u32,
        }
        .into(),
        // Points that do not define an arc.
        1 if dice.roll(10) == 0 => ArcCmd {
            cir_point: to_point,
            to_point,
        }
        .into(),
        _ => ArcCmd {
            cir_point,
            to_point,
        }
        .into(),
    }
}

fn segment(dice: &mut Dice, cp_mode: CpMode, [x, y, z]: [f32; 3]) -> Set {
    let power = dice.number(0.0, 100.0);
    match dice.roll(2) {
        0 => CpCmd {
            cp_mode,
            x,
            y,
            z,
            velocity_or_power: 0.0,
        }
        .into(),
        _ => CpLeCmd {
            cp_mode,
            x,
            y,
            z,
            velocity_or_power: power,
        }
        .into(),
    }
}

/// Returns a point-to-point move in any mode, sometimes with outputs and rail.
fn travel(dice: &mut Dice, from: [f32; 4], geometry: &Geometry) -> Set {
    let mode = dice.roll(10) as u8;
    let [x, y, z, r] = match mode {
        0..3 | 9 if dice.roll(3) == 0 => near(dice, from, 60.0),
        0..3 | 9 => pose(dice, geometry),
        3..6 if dice.roll(8) == 0 => dice.numbers([(-160.0, 160.0); 4]),
        3..6 => posture(dice),
        _ => dice.numbers([(-50.0, 50.0); 4]),
    };
    let ptp_mode = PtpMode::from(mode);
    let mut command = PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    }
    .into();
    if dice.roll(4) == 0 {
        let output = Output {
            percent: dice.roll(101) as u8,
            address: 17,
            high: dice.roll(2) == 0,
        };
        command = build::with_outputs(command, &[output]).unwrap();
    }
    if dice.roll(3) == 0 {
        let l = match mode {
            6..9 => dice.number(-200.0, 200.0),
            _ => dice.number(0.0, 1000.0),
        };
        command = build::with_rail(command, l).unwrap();
    }
    command
}

#[derive(Default)]
struct Tally {
    commands: u64,
    /// Passed the check and raised an alarm: must stay empty.
    through: Vec<String>,
    /// Reachable, but refused.
    refused: Vec<String>,
    reachable: u64,
    /// Refused with reason.
    far: u64,
    /// Took another time, or ended elsewhere, than estimated.
    wrong: Vec<String>,
}

impl Tally {
    fn check(&mut self, bench: &mut LoneArm, check: &mut Preflight, command: Set) -> bool {
        self.commands += 1;
        let tell = |arm: &LoneArm| format!("{command:?} from {:?}", arm.arm.state().joints);
        let step = match check.check(&command) {
            Ok(step) => step,
            Err(error) => {
                let mut other = bench.clone();
                other.run(&command);
                if matches!(command, Set::HomeParams(_)) {
                    // Stored without a check; homing finds out.
                    other.run(&build::home());
                }
                // The rail stops at its end without an alarm, and an invalid speed is stored.
                let silently = matches!(
                    command,
                    Set::PtpCommonParams(_) | Set::CircleCmd(CircleCmd { count: 0, .. })
                ) || error.to_string().contains("the rail would be");
                if other.alarmed() || silently {
                    self.far += 1;
                } else {
                    self.reachable += 1;
                    self.refused.push(format!("{}: {error}", tell(bench)));
                }
                return true;
            }
        };
        let told = tell(bench);
        let took = bench.run(&command);
        if bench.alarmed() {
            let alarms = bench.arm.state().alarms;
            self.through.push(format!("{told}: {alarms}"));
            return false;
        }
        self.reachable += 1;
        // Homing to a point that is unknown, because the tool has changed.
        let Some(end) = step.end.map(|end| end.joints.to_array()) else {
            return false;
        };
        let is = bench.arm.state().joints.to_array();
        let off = is.iter().zip(end).map(|(is, end)| (is - end).abs());
        let off = off.fold(0.0, f64::max);
        // Single segments of a path only match a path of one segment if each begins at rest.
        let timed = !matches!(command, Set::CpCmd(_) | Set::CpLeCmd(_));
        let late = match step.time.as_micros() {
            time if timed && time < u128::from(u64::MAX) => time.abs_diff(took.into()),
            _ => 0,
        };
        // The first motion begins at the pose that the arm reports, rounded to 32 bits; for three
        // points almost on a straight line the circle depends on them. The check does not know the
        // phase of the period at which the command arrived.
        if off > 1e-3 || late > 20_000 + u128::from(took) / 1000 {
            let time = step.time;
            self.wrong
                .push(format!("{told}: {off} deg off, {time:?} and not {took} us"));
        }
        true
    }
}

/// Returns a firmware with other ceilings, limits, homing and paths, including higher ones.
fn another_firmware(dice: &mut Dice) -> Profile {
    let mut profile = Profile::default();
    let mut times = |value: &mut f64| *value *= dice.between(0.5, 3.0);
    let ceilings = &mut profile.ceilings;
    ceilings.joint_velocity.iter_mut().for_each(&mut times);
    times(&mut ceilings.joint_acceleration);
    times(&mut ceilings.linear_velocity);
    times(&mut ceilings.linear_acceleration);
    times(&mut ceilings.rotation_velocity);
    times(&mut ceilings.rotation_acceleration);
    profile.home.velocity.iter_mut().for_each(&mut times);
    profile.home.acceleration.iter_mut().for_each(&mut times);
    times(&mut profile.path.period);
    if dice.roll(2) == 0 {
        profile.motion.period = 0.0;
    }
    profile.home.joints.j2 = dice.between(20.0, 60.0);
    let turn = &mut profile.limits.controller.j1;
    turn.min *= dice.between(0.7, 1.1);
    turn.max *= dice.between(0.7, 1.1);
    profile
}

#[test]
fn what_passes_raises_no_alarm_and_what_is_refused_would() {
    let mut tally = Tally::default();
    let mut dice = Dice::new(SEED);
    for nth in 0..PROGRAMS {
        let mut bench = match nth % 4 {
            3 => LoneArm::with(another_firmware(&mut dice)),
            _ => LoneArm::new(),
        };
        let model = *bench.arm.arm_model();
        bench.start();
        for _ in 0..3 {
            let set = setting(&mut dice);
            if Preflight::at(JointAngles::HOME, ToolBias::NONE)
                .check(&set)
                .is_ok()
            {
                bench.run(&set);
            }
        }
        let [a, b, c, d] = posture(&mut dice);
        bench.run(&build::move_joints(a, b, c, d));
        if bench.alarmed() {
            continue;
        }
        let guards = Guards::default().laser(false);
        let mut check = Preflight::new(&bench.readings())
            .guards(guards)
            .model(model);
        for _ in 0..LENGTH {
            let from = check.arm().expect("it is known").pose.to_array();
            let geometry = Geometry::magician(bench.arm.state().tool);
            let next = command(&mut dice, from.map(|value| value as f32), &geometry);
            if !tally.check(&mut bench, &mut check, next) {
                break;
            }
        }
    }
    let Tally {
        commands,
        through,
        refused,
        reachable,
        far,
        wrong,
    } = &tally;
    let per_mille = 1000.0 * refused.len() as f64 / *reachable as f64;
    let figures = format!(
        "{commands} commands: {} pass and raise an alarm, {} of {reachable} reachable ones are refused \
         ({per_mille:.3} per mille), {far} refused with reason, {} told wrong",
        through.len(),
        refused.len(),
        wrong.len(),
    );
    println!("{figures}");
    let first = |list: &[String]| list.iter().take(5).cloned().collect::<Vec<_>>().join("\n");
    assert!(through.is_empty(), "{figures}\n{}", first(through));
    assert!(per_mille <= 1.0, "{figures}\n{}", first(refused));
    assert!(wrong.is_empty(), "{figures}\n{}", first(wrong));
    assert!(*far > 1000 && *reachable > 5000, "{figures}");
}

/// Joints that move together from within their limits to within them stay there, whatever the
/// start, except for the coupled limit if their speeds differ greatly.
#[test]
fn what_passes_from_an_unknown_start_hardly_ever_raises_an_alarm() {
    let mut dice = Dice::new(SEED);
    let mut through = 0;
    let mut passed = 0;
    for _ in 0..4 * PROGRAMS {
        let mut bench = LoneArm::new();
        bench.start();
        let speeds = [0; 4].map(|_| dice.number(20.0, 320.0));
        bench.run(&build::joint_speed(
            speeds,
            [0; 4].map(|_| dice.number(20.0, 300.0)),
        ));
        let [a, b, c, d] = posture(&mut dice);
        bench.run(&build::move_joints(a, b, c, d));
        if bench.alarmed() {
            continue;
        }
        let [a, b, c, d] = posture(&mut dice);
        let command = build::move_joints(a, b, c, d);
        let mut check = Preflight::new(&Readings::default());
        if check.check(&command).is_ok() {
            passed += 1;
            bench.run(&command);
            through += u32::from(bench.alarmed());
        }
    }
    println!("{through} of {passed} moves from an unknown start raise an alarm");
    assert!(
        1000 * through <= passed && passed > 5000,
        "{through} of {passed}"
    );
}

#[test]
fn the_figures_are_those_of_the_virtual_arm() {
    let power_up = LoneArm::new().readings();
    let mut default = Readings::default();
    (default.pose, default.home, default.rail) = (power_up.pose, power_up.home, power_up.rail);
    assert_eq!(default, power_up);
    assert_eq!(
        build::CONVEYOR_PULSES_PER_MM,
        magician::sim::CONVEYOR_PULSES_PER_MM
    );
    assert_eq!(Profile::default().home.switch, -135.0);
}
