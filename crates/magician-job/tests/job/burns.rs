//! Burns that end before their end and are resumed: no gap is left, and what is burnt twice is said.

use std::time::Duration;

use magician::{Alarm, Arm, VirtualArm, words};
use magician_job::{Job, JobEvent, JobSpec, Start};
use magician_program::{Action, Origin, Plan, Program, Tool, Travel};
use tokio::time::sleep;

use super::life::Memory;
use super::place::{ink, place};

/// No gap in a burn is longer, mm.
const GAP: f64 = 0.2;
/// The corners of the burn.
const CORNERS: [[f64; 2]; 4] = [[205.0, -40.0], [205.0, 40.0], [240.0, 40.0], [240.0, -40.0]];

fn length(from: [f64; 2], to: [f64; 2]) -> f64 {
    (to[0] - from[0]).hypot(to[1] - from[1])
}

fn whole() -> f64 {
    CORNERS
        .windows(2)
        .map(|side| length(side[0], side[1]))
        .sum()
}

/// The place so far along the burn.
fn at(mut along: f64) -> [f64; 2] {
    for side in CORNERS.windows(2) {
        let (from, to) = (side[0], side[1]);
        let all = length(from, to);
        if along <= all {
            let share = along / all;
            return [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        }
        along -= all;
    }
    CORNERS[CORNERS.len() - 1]
}

/// How far along the burn a place on it is.
fn along(place: [f64; 2]) -> f64 {
    let (mut before, mut best) = (0.0, (f64::MAX, 0.0));
    for side in CORNERS.windows(2) {
        let (from, to) = (side[0], side[1]);
        let all = length(from, to);
        let way = [0, 1].map(|axis| (to[axis] - from[axis]) / all);
        let share = (0..2)
            .map(|axis| way[axis] * (place[axis] - from[axis]))
            .sum::<f64>();
        let share = share.clamp(0.0, all);
        let off = length([0, 1].map(|axis| from[axis] + share * way[axis]), place);
        if off < best.0 {
            best = (off, before + share);
        }
        before += all;
    }
    assert!(
        best.0 < 0.1,
        "{place:?} is burnt, {} mm beside the path",
        best.0
    );
    best.1
}

/// A burn at this speed, in pieces of many lengths.
fn burn(speed: f32) -> Program {
    let mut plan = Plan::new("a burn");
    plan.tool = Some(Tool::Laser);
    plan.push(words::path_speed(speed, 100.0), Origin::NONE);
    let [x, y] = CORNERS[0].map(|number| number as f32);
    let by = Travel::Line;
    plan.push(
        Action::Move {
            to: [x, y, 0.0, 0.0],
            by,
        },
        Origin::NONE,
    );
    let mut ends: Vec<f64> = CORNERS
        .windows(2)
        .scan(0.0, |sum, side| {
            *sum += length(side[0], side[1]);
            Some(*sum)
        })
        .collect();
    let mut end = 0.0;
    for nth in 0.. {
        end += [9.0, 0.7, 3.1, 17.0, 1.3][nth % 5];
        if end >= whole() {
            break;
        }
        ends.push(end);
    }
    ends.sort_by(f64::total_cmp);
    for end in ends {
        let [x, y] = at(end).map(|number| number as f32);
        plan.push(
            Action::Burn {
                to: [x, y, 0.0],
                power: 60.0,
            },
            Origin::NONE,
        );
    }
    plan.push(Action::Laser(false), Origin::NONE);
    Program::new(plan, Some(1))
}

/// What was burnt: the longest part of the path that was left out, and how much was burnt more than once, mm.
fn burnt(cell: &VirtualArm) -> (f64, f64) {
    let mut parts: Vec<[f64; 2]> = Vec::new();
    for stroke in ink(cell).0.strokes() {
        for pair in stroke.points.windows(2) {
            let (one, other) = (along(pair[0]), along(pair[1]));
            parts.push([one.min(other), one.max(other)]);
        }
    }
    parts.sort_by(|one, other| one[0].total_cmp(&other[0]));
    let (mut until, mut gap, mut twice) = (0.0_f64, 0.0_f64, 0.0);
    for [from, to] in parts {
        gap = gap.max(from - until);
        twice += (until.min(to) - from).max(0.0);
        until = until.max(to);
    }
    (gap.max(whole() - until), twice)
}

/// Resumes a burn, with this overlap; what it says is burnt twice, mm.
async fn resume(arm: &Arm, program: &Program, journal: &Memory, overlap: f64) -> f64 {
    let spec = JobSpec::new(program.clone())
        .overlap(overlap)
        .lasting(false);
    let job = Job::start(arm, spec.start(Start::Resume), journal.clone());
    let mut events = job.events();
    let mut twice = None;
    while let Some(event) = events.next().await {
        if let JobEvent::Starts(starts) = event {
            twice = Some(starts.burnt_twice);
        }
    }
    job.outcome().await.expect("it goes on");
    twice.expect("it tells where it starts")
}

/// What ends a burn before its end.
#[derive(Clone, Copy, Debug)]
enum Cause {
    /// The job is stopped.
    Stop,
    /// The arm is stopped by another handle.
    Arm,
    /// The arm is stopped from outside of any task.
    Stopper,
    /// An alarm holds the arm.
    Alarm,
}

const CAUSES: [Cause; 4] = [Cause::Stop, Cause::Arm, Cause::Stopper, Cause::Alarm];

/// A burn that this ends after so long.
async fn ended(cause: Cause, program: &Program, after: Duration) -> (VirtualArm, Arm, Memory) {
    let (cell, arm) = place(program).await;
    let journal = Memory::default();
    let job = Job::start(&arm, JobSpec::new(program.clone()), journal.clone());
    sleep(after).await;
    match cause {
        Cause::Stop => job.stop(),
        Cause::Arm => arm.stop().await.expect("it stops"),
        Cause::Stopper => arm.stopper().request_stop().expect("it stops"),
        Cause::Alarm => cell.with(|arm| {
            arm.inject(magician::sim::ExternalEvent::Alarm(Alarm::MoveInvLimit));
        }),
    }
    job.outcome().await.expect_err("it is ended");
    (cell, arm, journal)
}

/// Instants that differ from run to run of nothing: a small generator with a fixed seed.
fn instants(seed: u64, until: f64) -> impl Iterator<Item = f64> {
    let mut state = seed;
    std::iter::from_fn(move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        Some((state >> 11) as f64 / (1_u64 << 53) as f64 * until)
    })
}

#[tokio::test(start_paused = true)]
async fn burn_stopped_at_any_instant_resumes_without_a_gap() {
    for speed in [20.0_f32, 60.0, 100.0] {
        let program = burn(speed);
        let (cell, arm) = place(&program).await;
        let job = Job::start(&arm, JobSpec::new(program.clone()), Memory::default());
        let done = job.outcome().await.expect("done");
        let (gap, twice) = burnt(&cell);
        assert!(gap < 0.01 && twice < 0.01, "{speed}: {gap} {twice}");
        for (nth, cause) in CAUSES.into_iter().enumerate() {
            for after in instants(nth as u64, done.seconds).take(12) {
                let told = format!("{speed} mm/s, {cause:?} after {after:.3} s");
                let (cell, arm, journal) =
                    ended(cause, &program, Duration::from_secs_f64(after)).await;
                if matches!(cause, Cause::Alarm) {
                    arm.clear_alarms().await.expect("cleared");
                }
                let said = resume(&arm, &program, &journal, 0.0).await;
                let (gap, twice) = burnt(&cell);
                assert!(gap <= GAP, "{told}: {gap:.2} mm are left out");
                assert!(
                    (twice - said).abs() <= GAP,
                    "{told}: {twice:.2} mm twice, {said:.2} said"
                );
                // What has stopped the arm by itself has put the light out somewhere on its braking way.
                let most = if matches!(cause, Cause::Alarm) {
                    f64::from(speed * speed) / 1000.0
                } else {
                    GAP
                };
                assert!(said <= most, "{told}: {said:.2} mm are burnt twice");
            }
        }
    }
}
