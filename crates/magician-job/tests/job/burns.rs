//! Burns that end early and are resumed: no gap is left, and the reported double burn is correct.

use std::time::Duration;

use magician::sim::ExternalEvent;
use magician::{Alarm, Arm, Options, SimSpeed, VirtualArm, build};
use magician_job::{Fault, Job, JobEvent, JobSpec, Journal, JournalError, ResumePlace, Start};
use magician_program::{Action, Origin, Plan, Program, Tool, Travel};
use tokio::time::sleep;

use super::fixtures::{bench, ink};
use super::killed::{SnapshotJournal, killed};
use super::lifecycle::MemoryJournal;

/// Longest gap allowed in a burn, mm.
const MAX_GAP: f64 = 0.2;
/// Period of the controller, s: it reports one pose while the arm moves on to the next. The laser
/// may have gone out anywhere between the two poses.
const PERIOD: f64 = 0.02;
/// Longest piece of a burn, mm.
const MAX_PIECE: f64 = 17.0;
/// Corners of the burn.
const CORNERS: [[f64; 2]; 4] = [[205.0, -40.0], [205.0, 40.0], [240.0, 40.0], [240.0, -40.0]];

fn length(from: [f64; 2], to: [f64; 2]) -> f64 {
    (to[0] - from[0]).hypot(to[1] - from[1])
}

fn total_length() -> f64 {
    CORNERS
        .windows(2)
        .map(|side| length(side[0], side[1]))
        .sum()
}

/// Position at a distance along the burn.
fn position_at(mut along: f64) -> [f64; 2] {
    for side in CORNERS.windows(2) {
        let (from, to) = (side[0], side[1]);
        let side_length = length(from, to);
        if along <= side_length {
            let share = along / side_length;
            return [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        }
        along -= side_length;
    }
    CORNERS[CORNERS.len() - 1]
}

/// Distance from the beginning of the burn to a place on it, mm.
fn along(place: [f64; 2]) -> f64 {
    let (mut before, mut best) = (0.0, (f64::MAX, 0.0));
    for side in CORNERS.windows(2) {
        let (from, to) = (side[0], side[1]);
        let side_length = length(from, to);
        let direction = [0, 1].map(|axis| (to[axis] - from[axis]) / side_length);
        let share = (0..2)
            .map(|axis| direction[axis] * (place[axis] - from[axis]))
            .sum::<f64>();
        let share = share.clamp(0.0, side_length);
        let off = length(
            [0, 1].map(|axis| from[axis] + share * direction[axis]),
            place,
        );
        if off < best.0 {
            best = (off, before + share);
        }
        before += side_length;
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
    plan.push(build::path_speed(speed, 100.0), Origin::NONE);
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
        end += [9.0, 0.7, 3.1, MAX_PIECE, 1.3][nth % 5];
        if end >= total_length() {
            break;
        }
        ends.push(end);
    }
    ends.sort_by(f64::total_cmp);
    for end in ends {
        let [x, y] = position_at(end).map(|number| number as f32);
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

/// Longest part of the path that was not burnt, and the length that was burnt more than once, mm.
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
    (gap.max(total_length() - until), twice)
}

/// Resumes a burn. Returns the reported length of the double burn, mm.
async fn resume(arm: &Arm, spec: JobSpec, journal: impl Journal + 'static) -> f64 {
    try_resume(arm, spec, journal).await.expect("it goes on")
}

/// Like `resume`; `None` if the arm's indices leave the finished steps in doubt.
async fn try_resume(arm: &Arm, spec: JobSpec, journal: impl Journal + 'static) -> Option<f64> {
    let job = Job::start(arm, spec.start(Start::Resume), journal);
    let mut events = job.events();
    let mut twice = None;
    while let Some(event) = events.next().await {
        if let JobEvent::Start(starts) = event {
            twice = Some(starts.burnt_twice);
        }
    }
    match job.outcome().await {
        Ok(_) => {}
        Err(error) if matches!(error.fault, Fault::AllDone) => {}
        // Nothing was sent, or everything is done.
        Err(error) if matches!(error.fault, Fault::Journal(JournalError::NotFound)) => {
            return Some(0.0);
        }
        Err(error) if matches!(error.fault, Fault::Doubt { .. }) => return None,
        Err(error) => panic!("{error}"),
    }
    Some(twice.expect("it tells where it starts"))
}

/// Cause of an early end.
#[derive(Clone, Copy, Debug)]
enum Cause {
    /// The job is stopped.
    Stop,
    /// The arm is stopped by another handle.
    Arm,
    /// The arm is stopped outside of any task.
    Stopper,
    /// An alarm holds the arm.
    Alarm,
    /// The line breaks, and is found again while the arm still moves.
    Line,
}

const CAUSES: [Cause; 5] = [
    Cause::Stop,
    Cause::Arm,
    Cause::Stopper,
    Cause::Alarm,
    Cause::Line,
];

/// Runs a burn and ends it for this cause after a delay.
async fn run_until(
    cause: Cause,
    program: &Program,
    after: Duration,
) -> (VirtualArm, Arm, MemoryJournal) {
    let (cell, arm) = bench(program).await;
    let journal = MemoryJournal::default();
    let job = Job::start(&arm, JobSpec::new(program.clone()), journal.clone());
    sleep(after).await;
    match cause {
        Cause::Stop => job.stop(),
        Cause::Arm => arm.stop().await.expect("it stops"),
        Cause::Stopper => arm.stopper().request_stop().expect("it stops"),
        Cause::Alarm => cell.with(|arm| {
            arm.inject(ExternalEvent::Alarm(Alarm::MoveInvLimit));
        }),
        Cause::Line => {
            cell.with(|arm| arm.inject(ExternalEvent::Cable { plugged: false }));
            sleep(Duration::from_millis(30)).await;
            cell.with(|arm| arm.inject(ExternalEvent::Cable { plugged: true }));
        }
    }
    job.outcome().await.expect_err("it is ended");
    (cell, arm, journal)
}

/// Pseudo-random instants with a fixed seed, seconds.
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
        let (cell, arm) = bench(&program).await;
        let job = Job::start(
            &arm,
            JobSpec::new(program.clone()),
            MemoryJournal::default(),
        );
        let done = job.outcome().await.expect("done");
        let (gap, twice) = burnt(&cell);
        assert!(gap < 0.01 && twice < 0.01, "{speed}: {gap} {twice}");
        for (nth, cause) in CAUSES.into_iter().enumerate() {
            for after in instants(nth as u64, done.seconds).take(12) {
                let context = format!("{speed} mm/s, {cause:?} after {after:.3} s");
                let (cell, arm, journal) =
                    run_until(cause, &program, Duration::from_secs_f64(after)).await;
                if matches!(cause, Cause::Alarm) {
                    arm.clear_alarms().await.expect("cleared");
                }
                let reported = resume(&arm, JobSpec::new(program.clone()), journal).await;
                let (gap, twice) = burnt(&cell);
                assert!(gap <= MAX_GAP, "{context}: {gap:.2} mm are left out");
                // If the arm was stopped without the driver, the laser went out somewhere on the
                // braking distance. After a lost line the driver switches the laser off before it
                // stops the arm, but not every firmware does so while the arm moves.
                let braking = f64::from(speed * speed) / 1000.0;
                let period = PERIOD * f64::from(speed);
                let (most, least) = match cause {
                    Cause::Alarm => (braking + period, reported - period - MAX_GAP),
                    Cause::Line => (braking + period, reported - braking - period),
                    // An arm that comes to rest within one period T seems to stand already at the
                    // stop, although it braked after that with the laser off. Its deceleration a is
                    // at least v / T, so the braking distance is at most v^2 / 2a = v T / 2.
                    _ => (1.5 * period, reported - 1.5 * period - MAX_GAP),
                };
                assert!(
                    reported <= most + MAX_GAP,
                    "{context}: {reported:.2} mm are burnt twice"
                );
                assert!(
                    (least..reported + MAX_GAP).contains(&twice),
                    "{context}: {twice:.2} mm twice, {reported:.2} said"
                );
            }
        }
    }
}

/// A second process resumes the burn of a killed process while the arm still executes its queue.
/// The second process switches the laser off first, but the virtual arm burns to the end of the
/// current piece, as real arms may.
#[tokio::test(start_paused = true)]
async fn burn_of_a_killed_process_resumes_without_a_gap() {
    let mut all_tried = (0, 0);
    for speed in [20.0, 60.0, 100.0] {
        let program = burn(speed);
        let (snapshots, ..) = killed(&program, 100, None).await;
        for snapshot in snapshots
            .iter()
            .filter(|snapshot| snapshot.journal.is_some())
            .step_by(5)
        {
            let context = format!("{speed} mm/s, {:?}", snapshot.journal);
            let cell = VirtualArm::new(snapshot.arm.clone(), SimSpeed::Times(1.0));
            let arm = Arm::simulated(cell.clone(), Options::default()).await;
            let arm = arm.expect("a virtual arm");
            let spec = JobSpec::new(program.clone()).outlives_process(true);
            all_tried.0 += 1;
            let Some(reported) = try_resume(&arm, spec, SnapshotJournal::left_by(snapshot)).await
            else {
                all_tried.1 += 1;
                continue;
            };
            let (gap, twice) = burnt(&cell);
            assert!(gap <= MAX_GAP, "{context}: {gap:.2} mm are left out");
            assert!(
                (twice - reported).abs() <= MAX_GAP,
                "{context}: {twice:.2} mm twice, {reported:.2} said"
            );
            assert!(
                reported <= MAX_PIECE + MAX_GAP,
                "{context}: {reported:.2} mm are burnt twice"
            );
        }
    }
    assert!(all_tried.1 * 10 < all_tried.0, "{all_tried:?}");
}

/// Another program stops an arm that executes the queue of a killed process. The laser goes out
/// somewhere on the braking distance.
#[tokio::test(start_paused = true)]
async fn burn_stopped_by_another_program_repeats_the_braking_distance() {
    let program = burn(60.0);
    let (snapshots, ..) = killed(&program, 100, None).await;
    let under_way = snapshots
        .iter()
        .filter(|snapshot| snapshot.journal.is_some() && snapshot.arm.busy());
    let mut longest = 0.0_f64;
    for snapshot in under_way.step_by(5) {
        let context = format!("{:?}", snapshot.journal);
        let cell = VirtualArm::new(snapshot.arm.clone(), SimSpeed::Times(1.0));
        let arm = Arm::simulated(cell.clone(), Options::default()).await;
        arm.expect("a virtual arm").stop().await.expect("it stops");
        let arm = Arm::simulated(cell.clone(), Options::default()).await;
        let spec = JobSpec::new(program.clone()).outlives_process(true);
        let arm = arm.expect("a virtual arm");
        let Some(reported) = try_resume(&arm, spec, SnapshotJournal::left_by(snapshot)).await
        else {
            continue;
        };
        let (gap, twice) = burnt(&cell);
        assert!(gap <= MAX_GAP, "{context}: {gap:.2} mm are left out");
        assert!(
            twice <= reported + MAX_GAP,
            "{context}: {twice:.2} mm twice, {reported:.2} said"
        );
        // The braking distance from 60 mm/s, and one period at that speed.
        assert!(
            reported <= 3.6 + 60.0 * PERIOD,
            "{context}: {reported:.2} mm are burnt twice"
        );
        longest = longest.max(reported);
    }
    assert!(longest > 1.0, "{longest}");
}

/// The length reported at the stop agrees with the note of the resumed job.
#[tokio::test(start_paused = true)]
async fn stopped_burn_reports_an_upper_bound_of_the_overlap() {
    let program = burn(60.0);
    let mut longest = 0.0_f64;
    for seconds in [2.0, 2.6, 3.3, 4.1, 4.8] {
        let (cell, arm) = bench(&program).await;
        let journal = MemoryJournal::default();
        let job = Job::start(&arm, JobSpec::new(program.clone()), journal.clone());
        sleep(Duration::from_secs_f64(seconds)).await;
        // Another program stops the arm, as a station does. The arm already stands when the job
        // learns of the stop.
        let other = Arm::simulated(cell.clone(), Options::default()).await;
        other
            .expect("a virtual arm")
            .stop()
            .await
            .expect("it stops");
        job.stop();
        let error = job.outcome().await.expect_err("stopped");
        let Some(ResumePlace::Known { burnt_twice, .. }) = error.resume_place else {
            continue;
        };
        let Some(reported) = try_resume(&arm, JobSpec::new(program.clone()), journal).await else {
            continue;
        };
        assert!(
            (burnt_twice - reported).abs() < 0.01,
            "{seconds}: {burnt_twice:.2} mm promised, {reported:.2} mm at the start"
        );
        longest = longest.max(burnt_twice);
    }
    assert!(longest > 1.0, "{longest}");
}

/// A station stops the arm several times within the same piece. Each time the arm already stands
/// when the job learns of the stop.
#[tokio::test(start_paused = true)]
async fn burn_stopped_repeatedly_by_a_station_repeats_only_the_reported_length() {
    let mut plan = Plan::new("a line");
    plan.tool = Some(Tool::Laser);
    plan.push(build::path_speed(20.0, 100.0), Origin::NONE);
    let to = [205.0, -40.0, 0.0, 0.0];
    let by = Travel::Line;
    plan.push(Action::Move { to, by }, Origin::NONE);
    for corner in &CORNERS[1..] {
        let [x, y] = corner.map(|number| number as f32);
        let to = [x, y, 0.0];
        plan.push(Action::Burn { to, power: 60.0 }, Origin::NONE);
    }
    plan.push(Action::Laser(false), Origin::NONE);
    let program = Program::new(plan, Some(1));
    for pause in [0.2, 0.4, 0.7, 1.1] {
        let (cell, arm) = bench(&program).await;
        let journal = MemoryJournal::default();
        let mut reported = 0.0;
        for nth in 0..4 {
            let start = match nth {
                0 => Start::Step(0),
                _ => Start::Resume,
            };
            let spec = JobSpec::new(program.clone()).start(start);
            let job = Job::start(&arm, spec, journal.clone());
            sleep(Duration::from_secs_f64(3.0 + pause * f64::from(nth))).await;
            let other = Arm::simulated(cell.clone(), Options::default()).await;
            let other = other.expect("a virtual arm");
            other.stop().await.expect("it stops");
            job.stop();
            match job.outcome().await {
                Err(error) => {
                    if let Some(ResumePlace::Known { burnt_twice, .. }) = error.resume_place {
                        reported += burnt_twice;
                    }
                }
                Ok(_) => break,
            }
        }
        let _ = try_resume(&arm, JobSpec::new(program.clone()), journal).await;
        let (gap, twice) = burnt(&cell);
        assert!(gap <= MAX_GAP, "{pause}: {gap:.2} mm are left out");
        assert!(
            twice <= reported + MAX_GAP && reported < 60.0,
            "{pause}: {twice:.2} mm twice, {reported:.2} said"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn overlap_of_a_resumed_burn_counts_from_the_laser_off_position() {
    for (speed, after) in [(20.0, 4.6), (60.0, 2.3), (100.0, 2.9)] {
        for overlap in [0.5, 3.0] {
            let program = burn(speed as f32);
            let after = Duration::from_secs_f64(after);
            let (cell, arm, journal) = run_until(Cause::Stop, &program, after).await;
            let spec = JobSpec::new(program.clone()).overlap(overlap);
            let reported = resume(&arm, spec, journal).await;
            let (gap, twice) = burnt(&cell);
            let period = PERIOD * speed;
            assert!(
                gap <= 0.01 && (-MAX_GAP..=period + MAX_GAP).contains(&(reported - overlap)),
                "{speed}: {gap} {reported}"
            );
            assert!(
                (-MAX_GAP..=period + MAX_GAP).contains(&(twice - overlap)),
                "{speed}: {twice} of {overlap} mm"
            );
        }
    }
}
