//! Durations: the estimate of the check compared with the virtual arm.

use std::time::Duration;

use magician::build;
use magician::commands::CpParams;
use magician::preflight::Preflight;
use magician::protocol::Flag;
use magician::sim::Profile;
use magician::{JointAngles, Set, ToolBias};

use crate::bench::{Dice, LoneArm};

const PROGRAMS: usize = 150;
const PATHS: usize = 60;
/// Motion that may wait in a queue while a program is streamed, us.
const HORIZON: u64 = 2_000_000;

/// Error of positions reported in 32 bits, us.
const ROUNDING: f64 = 10.0;

/// Returns part of a drawing, relative to its start: lines, curves, corners, dots.
fn drawing(dice: &mut Dice, segments: usize) -> Vec<[f32; 2]> {
    let step = [0.2, 0.5, 1.0, 3.0, 10.0][dice.roll(5) as usize];
    let mut heading = dice.between(0.0, std::f64::consts::TAU);
    let mut bend = 0.0;
    let mut at = [0.0f64; 2];
    let mut points = Vec::with_capacity(segments);
    for _ in 0..segments {
        match dice.roll(40) {
            0 => heading = dice.between(0.0, std::f64::consts::TAU),
            1 => bend = dice.between(-0.2, 0.2),
            2 => bend = 0.0,
            _ => heading += bend,
        }
        // Back towards the middle of the sheet.
        if at[0].hypot(at[1]) > 40.0 {
            heading = (-at[1]).atan2(-at[0]);
        }
        at[0] += step * heading.cos();
        at[1] += step * heading.sin();
        points.push(at.map(|value| value as f32));
    }
    points
}

fn path(dice: &mut Dice, segments: usize) -> Vec<Set> {
    let points = drawing(dice, segments);
    (points.iter())
        .map(|[x, y]| build::path_to(200.0 + x, *y, 20.0))
        .collect()
}

fn path_params(dice: &mut Dice) -> Set {
    let [velocity, acceleration] = dice.numbers([(10.0, 300.0), (20.0, 400.0)]);
    match dice.roll(3) {
        // The host clocks the path, one segment per interval.
        0 => CpParams {
            plan_acc: acceleration,
            junction_vel: velocity,
            acc_or_period: dice.number(5.0, 50.0),
            real_time_track: Flag::ON,
        }
        .into(),
        _ => build::path_speed(velocity, acceleration),
    }
}

fn mix(dice: &mut Dice) -> Vec<Set> {
    let mut program = vec![build::move_to(200.0, 0.0, 20.0, 0.0)];
    for _ in 0..6 {
        let [x, y, z] = dice.numbers([(180.0, 230.0), (-60.0, 60.0), (-10.0, 50.0)]);
        match dice.roll(8) {
            0 => program.push(build::move_to(x, y, z, 0.0)),
            1 => program.push(build::line_to(x, y, z, 10.0)),
            2 => program.push(build::jump_to(x, y, z, -10.0)),
            3 => program.push(build::wait(Duration::from_millis(dice.roll(900)))),
            4 => program.push(build::speed(
                dice.number(10.0, 100.0),
                dice.number(10.0, 100.0),
            )),
            5 => program.push(path_params(dice)),
            6 => {
                program.push(build::move_to(200.0, 0.0, 20.0, 0.0));
                program.push(build::arc_to([210.0, 20.0, 20.0, 0.0], [x, 40.0, z, 0.0]));
            }
            _ => {
                program.push(build::move_to(200.0, 0.0, 20.0, 0.0));
                let segments = 1 + dice.roll(120) as usize;
                program.extend(path(dice, segments));
                program.push(build::suction(dice.roll(2) == 0));
            }
        }
    }
    program
}

#[test]
fn a_program_takes_as_long_as_was_estimated() {
    let mut dice = Dice::new(3);
    let (mut worst, mut longest, mut programs) = (0.0f64, 0, 0);
    for _ in 0..PROGRAMS {
        let program = mix(&mut dice);
        let mut bench = LoneArm::new();
        let check = Preflight::new(&bench.readings());
        let Ok(estimate) = check.estimate(&program) else {
            continue;
        };
        let steps: Duration = {
            let mut check = check.clone();
            let step = |command| check.check(command).unwrap().time;
            program.iter().map(step).sum()
        };
        let took = bench.run_all(&program);
        assert!(!bench.alarmed());
        for told in [estimate, steps] {
            worst = worst.max((told.as_micros() as f64 - took as f64).abs());
        }
        (longest, programs) = (longest.max(took), programs + 1);
    }
    println!("{programs} programs: estimates at most {worst} us off");
    assert!(longest > 10_000_000 && 2 * programs > PROGRAMS, "{longest}");
    assert!(worst <= ROUNDING, "an estimate is {worst} us off");
}

/// Returns the end time of each command of a program.
fn ends(bench: &mut LoneArm, program: &[Set]) -> Vec<u64> {
    let mut ends = vec![0; program.len()];
    let (begun, mut rest, mut done) = (bench.now, program.iter(), 0);
    while done < program.len() {
        let queue = bench.arm.state().queue;
        let taken = queue.waiting + usize::from(queue.running.is_some());
        for command in rest.by_ref().take(queue.capacity - taken) {
            bench.enqueue(command);
        }
        // A start in the middle of a motion would cut it off.
        if !queue.started {
            bench.start();
        }
        // The first index is 2.
        let finished = bench.arm.state().queue.current_index.max(1) as usize - 1;
        ends[done..finished].fill(bench.now.micros_since(begun));
        done = finished;
        if done < program.len() {
            assert!(bench.pass(), "it stands still");
        }
    }
    ends
}

#[test]
fn the_times_of_segments_add_up_to_what_a_queue_holds() {
    let mut dice = Dice::new(5);
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    let mut ahead = f64::INFINITY;
    for _ in 0..PATHS {
        let mut program = vec![
            build::path_speed(dice.number(10.0, 150.0), dice.number(50.0, 300.0)),
            build::move_to(200.0, 0.0, 20.0, 0.0),
        ];
        program.extend(path(&mut dice, 400));
        let mut bench = LoneArm::new();
        let mut check = Preflight::new(&bench.readings());
        let mut sums = vec![0];
        for command in &program {
            let time = check.check(command).unwrap().time.as_micros() as u64;
            sums.push(sums.last().unwrap() + time);
        }
        let mut took = vec![0];
        took.extend(ends(&mut bench, &program));
        // The estimated time up to a command is never less than the arm takes up to there.
        for (told, took) in sums.iter().zip(&took) {
            ahead = ahead.min(*told as f64 - *took as f64);
        }
        // Any part of the program that the horizon lets into the queue.
        for from in 0..program.len() {
            let to = sums[from..].partition_point(|sum| sum - sums[from] < HORIZON) + from;
            let to = to.min(program.len());
            if sums[to] - sums[from] < HORIZON {
                break;
            }
            let ratio = (sums[to] - sums[from]) as f64 / (took[to] - took[from]) as f64;
            (least, most) = (least.min(ratio), most.max(ratio));
        }
    }
    println!("2 s of segments are {least:.2} to {most:.2} of what they take; ahead {ahead} us");
    assert!(ahead >= -ROUNDING, "told {ahead} us too little");
    assert!(least >= 0.5 && most <= 2.0, "{least} to {most}");
}

#[test]
fn the_closed_forms() {
    let check = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    let continuous = check.clone().model(Profile::continuous().arm_model());
    // Whole periods of 20 ms, and the times that they contain.
    for (check, times) in [
        (&check, [2000, 1420, 1900]),
        (&continuous, [2000, 1414, 1897]),
    ] {
        let line = check
            .estimate(&[build::line_by(0.0, 100.0, 0.0, 0.0)])
            .unwrap();
        let full = [
            build::speed(100.0, 100.0),
            build::line_by(0.0, 100.0, 0.0, 0.0),
        ];
        let full = check.estimate(&full).unwrap();
        let turn = check
            .estimate(&[build::move_joints_by(90.0, 0.0, 0.0, 0.0)])
            .unwrap();
        assert_eq!([line, full, turn].map(|time| time.as_millis()), times);
    }
    for endless in [build::home(), build::wait_for_level(19, true)] {
        assert_eq!(check.estimate(&[endless]).unwrap(), Duration::MAX);
    }
}

/// Speeds so low that the duration exceeds any clock are still valid.
#[test]
fn the_slowest_paths_take_for_ever_and_no_sum_overflows() {
    let slow = CpParams {
        plan_acc: 1e-37,
        junction_vel: 1e-37,
        acc_or_period: 1.0,
        real_time_track: Flag::OFF,
    };
    let mut program = vec![build::move_to(200.0, 0.0, 20.0, 0.0), slow.into()];
    for step in 0..100u8 {
        program.push(build::path_to(200.0 + f32::from(step) / 10.0, 1.0, 20.0));
    }
    let check = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    assert_eq!(check.estimate(&program).unwrap(), Duration::MAX);
    let mut one_by_one = check;
    for command in &program {
        one_by_one.check(command).unwrap();
    }
}

#[test]
fn what_is_told_in_sum_is_told_in_parts() {
    let mut dice = Dice::new(9);
    let mut program = vec![build::move_to(200.0, 0.0, 20.0, 0.0)];
    program.extend(path(&mut dice, 200));
    program.push(build::wait(Duration::from_millis(30)));
    program.extend(path(&mut dice, 20));
    let check = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    let sum = |mut check: Preflight| {
        let mut steps = program.iter().map(|command| check.check(command).unwrap());
        let told: Duration = steps.by_ref().map(|step| step.time).sum();
        drop(steps);
        told + check.rest()
    };
    let whole = check.estimate(&program).unwrap();
    assert_eq!(sum(check.clone()), whole);
    assert_eq!(sum(check.summing()), whole);
}
