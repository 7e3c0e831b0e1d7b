//! Changes of a job's speed while it runs.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::commands::{CpParams, DeviceTime, Pose, PtpCommonParams};
use magician::{Arm, build};
use magician_job::{
    Job, JobEvent, JobHandle, JobSpec, JobState, Journal, JournalError, JournalKey, NoJournal,
    PauseReason, SpeedError,
};
use magician_program::resume::{Checkpoint, ObservedProgress, ResumePoint};
use magician_program::{Action, Origin, Plan, Program, Tool, Travel};
use tokio::time::{Instant, sleep};

use super::fixtures::{self, Kind, bench};

const STEPS: u32 = 60;
const STEP: f32 = 4.0;
const START_X: f32 = -120.0;
/// Interval between two polls.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Short lines in a row, each of which ends at rest.
fn plan() -> Plan {
    let mut plan = Plan::new("in a row");
    plan.tool = Some(Tool::None);
    let line = |nth: u32| Action::Move {
        to: [220.0, START_X + STEP * nth as f32, 40.0, 0.0],
        by: Travel::Line,
    };
    plan.push(Action::from(build::line_speed(16.0, 2000.0)), Origin::NONE);
    plan.push(Action::from(build::speed(100.0, 100.0)), Origin::NONE);
    (0..=STEPS).for_each(|nth| plan.push(line(nth), Origin::NONE));
    plan
}

/// Steps before the row: two speeds and the travel to its start.
const STEPS_BEFORE_LINES: u64 = 3;

/// Number of lines that the arm has finished.
async fn lines_done(arm: &Arm) -> f32 {
    let pose = arm.get::<Pose>().await.expect("a pose");
    (pose.y - START_X) / STEP
}

async fn ratio(arm: &Arm) -> f32 {
    let set = arm.get::<PtpCommonParams>().await.expect("read");
    set.velocity_ratio
}

/// At each poll until the job ends: the number of finished lines, the time since `from`, s, and the
/// reported time left.
async fn record_progress(
    arm: &Arm,
    job: &JobHandle,
    from: Instant,
) -> Vec<(f32, f64, Option<Duration>)> {
    let mut seen = Vec::new();
    while job.state() != JobState::Ended {
        let left = job.progress().remaining;
        seen.push((lines_done(arm).await, from.elapsed().as_secs_f64(), left));
        sleep(POLL_INTERVAL).await;
    }
    seen
}

/// Lines per second over three lines, beginning with this one.
fn rate(seen: &[(f32, f64, Option<Duration>)], line: f32) -> f64 {
    let at = |line: f32| {
        let after = seen.iter().find(|(done, ..)| *done >= line);
        after.expect("it comes there").1
    };
    3.0 / (at(line + 3.0) - at(line))
}

#[tokio::test(start_paused = true)]
async fn speed_change_affects_only_unsent_commands() {
    let program = Program::new(plan(), Some(1));
    let (_cell, arm) = bench(&program).await;
    let before = arm.get::<CpParams>().await.expect("read");
    let job = Job::start(&arm, JobSpec::new(program.clone()), NoJournal);
    let mut events = job.events();
    while lines_done(&arm).await < 2.0 || job.progress().step < STEPS_BEFORE_LINES {
        sleep(POLL_INTERVAL).await;
    }
    assert_eq!(job.speed(), 100);
    let (_, capacity) = arm.stats().await.expect("read");
    let waiting = capacity - arm.queue().left_space().await.expect("read");
    let changed = lines_done(&arm).await;
    let sent = changed + waiting as f32;
    assert!(waiting > 4 && sent < 20.0, "{waiting}");
    let began = Instant::now();
    assert_eq!(job.set_speed(50), Ok(()));
    assert_eq!(job.speed(), 50);
    while events.next().await != Some(JobEvent::Speed(50)) {}
    let seen = record_progress(&arm, &job, began).await;
    let done = job.outcome().await.expect("done");
    assert_eq!(Some(done.steps), program.steps());
    // Each line begins and ends at rest.
    let (as_before, slow) = (rate(&seen, changed.ceil()), rate(&seen, 35.0));
    assert!((as_before - 3.5).abs() < 0.3, "{as_before}");
    assert!(
        (slow - as_before / 2.0).abs() < 0.1,
        "{slow} of {as_before}"
    );
    // The old speed holds up to the last line that was sent, and not much longer.
    let last_sent = rate(&seen, sent.floor() - 4.0);
    assert!((last_sent - 3.5).abs() < 0.3, "{last_sent}");
    let later = rate(&seen, sent.ceil() + 12.0);
    assert!((later - as_before / 2.0).abs() < 0.1, "{later}");
    // Once the settings have been sent, the reported time left is right.
    let end = seen.last().expect("it ran").1;
    for (line, at, left) in seen.iter().filter(|(_, at, _)| *at > 1.0) {
        let left = left.expect("known").as_secs_f64();
        assert!(
            (left - (end - at)).abs() < 1.0,
            "{line}: {left} at {at} of {end}"
        );
    }
    assert_eq!(ratio(&arm).await, 50.0, "settings are restored");
    assert_eq!(arm.get::<CpParams>().await.expect("read"), before);
    assert_eq!(job.set_speed(60), Err(SpeedError::Ended));
}

#[tokio::test(start_paused = true)]
async fn speed_survives_a_pause_during_which_jogs_run_at_full_speed() {
    let program = Program::new(plan(), Some(1));
    let (_cell, arm) = bench(&program).await;
    let job = Job::start(&arm, JobSpec::new(program.clone()), NoJournal);
    // A change during the check applies from the first step on.
    assert_eq!(job.set_speed(20), Ok(()));
    let began = Instant::now();
    while lines_done(&arm).await < 4.0 || job.progress().step < STEPS_BEFORE_LINES {
        sleep(POLL_INTERVAL).await;
    }
    assert_eq!(ratio(&arm).await, 20.0);
    job.pause(PauseReason::Person).await.expect("it runs");
    assert_eq!(ratio(&arm).await, 100.0, "as the program has it");
    for speed in [9, 101, 0, 255] {
        assert_eq!(job.set_speed(speed), Err(SpeedError::Range));
    }
    assert_eq!(job.set_speed(50), Ok(()));
    job.resume().await.expect("it goes on");
    let seen = record_progress(&arm, &job, began).await;
    let done = job.outcome().await.expect("done");
    assert_eq!(Some(done.steps), program.steps());
    let slow = rate(&seen, 20.0);
    assert!((slow - 1.75).abs() < 0.15, "{slow}");
    assert_eq!(ratio(&arm).await, 50.0, "settings are restored");
}

#[tokio::test(start_paused = true)]
async fn slower_paths_and_arcs_draw_the_same() {
    for kind in [Kind::Paths, Kind::Arcs, Kind::Jumps] {
        let program = fixtures::program(kind, 2);
        let mut times = Vec::new();
        let mut lengths = Vec::new();
        for speed in [100, 50] {
            let (cell, arm) = bench(&program).await;
            let job = Job::start(&arm, JobSpec::new(program.clone()), NoJournal);
            assert_eq!(job.set_speed(speed), Ok(()));
            let mut events = job.events();
            while events.next().await != Some(JobEvent::State(JobState::Running)) {}
            let left = job.progress().remaining.expect("known").as_secs_f64();
            let done = job.outcome().await.expect("done");
            let error = left - done.seconds;
            assert!(
                error.abs() < 0.5,
                "{kind:?} at {speed}: {left} of {}",
                done.seconds
            );
            assert_eq!(Some(done.steps), program.steps());
            times.push(done.seconds);
            lengths.push(fixtures::ink(&cell).1);
        }
        // The bend of a path has 60 pieces of 0.42 mm. Each takes one period of 20 ms at either
        // speed, 40 and 20 mm/s.
        let bends = match kind {
            Kind::Paths => 2.0 * 60.0 * 0.02,
            _ => 0.0,
        };
        assert!(
            times[1] - bends > 1.7 * (times[0] - bends),
            "{kind:?}: {times:?}"
        );
        assert!(
            (lengths[0] - lengths[1]).abs() < 0.1,
            "{kind:?}: {lengths:?}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn burning_job_refuses_a_speed_change() {
    let mut plan = Plan::new("a burn");
    plan.tool = Some(Tool::Laser);
    for (x, power) in [(210.0, 0.0), (230.0, 20.0), (210.0, 20.0), (200.0, 0.0)] {
        let to = [x, 0.0, 40.0];
        plan.push(Action::Burn { to, power }, Origin::NONE);
    }
    let program = Program::new(plan, Some(1));
    let (_cell, arm) = bench(&program).await;
    let arm = arm.allowing_laser();
    let job = Job::start(&arm, JobSpec::new(program), NoJournal);
    assert!(job.burns());
    assert_eq!(job.set_speed(50), Err(SpeedError::Burns));
    assert_eq!(job.speed(), 100);
    job.outcome().await.expect("done");
}

#[derive(Clone, Default)]
struct MemoryJournal(Arc<Mutex<Option<Checkpoint>>>);

impl Journal for MemoryJournal {
    fn open(&mut self, _: &JournalKey) {}

    fn load(&self) -> Result<Checkpoint, JournalError> {
        self.0.lock().unwrap().clone().ok_or(JournalError::NotFound)
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> std::io::Result<()> {
        *self.0.lock().unwrap() = Some(checkpoint.clone());
        Ok(())
    }

    fn remove(&mut self) {
        *self.0.lock().unwrap() = None;
    }
}

/// A process killed at any moment leaves a journal that does not count settings as steps.
#[tokio::test(start_paused = true)]
async fn inserted_settings_do_not_count_as_steps() {
    let program = Program::new(plan(), Some(1));
    let (_cell, arm) = bench(&program).await;
    let journal = MemoryJournal::default();
    let spec = JobSpec::new(program.clone()).outlives_process(true);
    let job = Job::start(&arm, spec, journal.clone());
    while lines_done(&arm).await < 1.0 || job.progress().step < STEPS_BEFORE_LINES {
        sleep(POLL_INTERVAL).await;
    }
    let (mut certain, mut doubtful, mut nth) = (0, 0, 0);
    while lines_done(&arm).await < STEPS as f32 - 3.0 {
        nth += 1;
        if nth % 400 == 1 {
            job.set_speed(if nth % 800 == 1 { 60 } else { 100 })
                .expect("it runs");
        }
        let Ok(checkpoint) = journal.load() else {
            break;
        };
        let seen = ObservedProgress {
            current: arm.queue().current_index().await.expect("an index").0,
            clock: arm.get::<DeviceTime>().await.expect("a time").g_systick,
        };
        let truth = STEPS_BEFORE_LINES as f32 + lines_done(&arm).await;
        match checkpoint.resume_point(Some(seen), program.numbering(), |_| None) {
            ResumePoint::After(steps) => {
                certain += 1;
                assert!((truth - steps as f32 - 0.5).abs() < 1.0, "{steps} {truth}");
            }
            ResumePoint::Again(steps) => assert!((truth - steps as f32).abs() < 2.0),
            ResumePoint::Doubt(span) => {
                doubtful += 1;
                assert!(span.least as f32 <= truth && truth <= span.most as f32 + 1.0);
            }
        }
        sleep(POLL_INTERVAL).await;
    }
    assert!(certain > 50 && doubtful > 5, "{certain} {doubtful}");
    job.stop();
    let _ = job.outcome().await;
}

/// Lines burnt with power in proportion to speed, and between them travel lines with the laser off.
fn proportional() -> Plan {
    let mut plan = Plan::new("M4");
    plan.tool = Some(Tool::Laser);
    plan.push(Action::from(build::path_speed(20.0, 100.0)), Origin::NONE);
    let to = [200.0, -60.0, 40.0, 0.0];
    let by = Travel::Line;
    plan.push(Action::Move { to, by }, Origin::NONE);
    for nth in 0..6_u8 {
        let y = f32::from(nth) * 15.0 - 60.0;
        let x = if nth.is_multiple_of(2) { 250.0 } else { 200.0 };
        for (to, power) in [([x, y, 40.0], 60.0), ([x, y + 15.0, 40.0], 0.0)] {
            plan.push(Action::Burn { to, power }, Origin::NONE);
            plan.steps.last_mut().expect("a step").feed = Some(20.0);
        }
    }
    plan.powered_by_speed().content
}

/// Dose burnt into each mm of each line, percent times seconds, and the duration.
async fn dose(
    change: impl Fn(&JobHandle, f64),
) -> (std::collections::BTreeMap<(i64, i64), f64>, f64) {
    const TICK: Duration = Duration::from_millis(2);
    const PARTS: u32 = 20;
    let program = Program::new(proportional(), Some(1));
    let (cell, arm) = bench(&program).await;
    let job = Job::start(&arm.allowing_laser(), JobSpec::new(program), NoJournal);
    let mut dose = std::collections::BTreeMap::new();
    let began = cell.state().now;
    // The arm reports one pose for a period, and burns on its way to the next.
    let (mut from, mut held) = ([200.0, -60.0], 0.0);
    while job.state() != JobState::Ended {
        let state = cell.state();
        change(&job, (state.now - began).as_secs_f64());
        let to = [state.pose.x, state.pose.y];
        if to != from {
            for nth in 0..PARTS {
                let share = (f64::from(nth) + 0.5) / f64::from(PARTS);
                let [x, y] = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
                let place = ((y / 15.0).round() as i64, x.round() as i64);
                *dose.entry(place).or_insert(0.0) += held / f64::from(PARTS);
            }
            (from, held) = (to, 0.0);
        }
        held += state.laser_power * TICK.as_secs_f64();
        sleep(TICK).await;
    }
    let done = job.outcome().await.expect("done");
    (dose, done.seconds)
}

/// No point is burnt deeper, neither where the speed changes nor at corners and ends.
#[tokio::test(start_paused = true)]
async fn proportional_burn_scales_power_with_speed() {
    let (full, full_speed_seconds) = dose(|_, _| {}).await;
    let set_speed = |job: &JobHandle, speed| {
        if job.state() == JobState::Running && job.speed() != speed {
            job.set_speed(speed).expect("its power follows");
        }
    };
    for (from, speed) in [(0.0, 50), (0.0, 20), (6.0, 50), (9.0, 10)] {
        let (slower, seconds) = dose(|job, at| {
            if at >= from {
                set_speed(job, speed);
            }
        })
        .await;
        assert!(
            seconds > 1.3 * full_speed_seconds,
            "{speed}: {seconds} {full_speed_seconds}"
        );
        let (mut weak, mut deep, mut all) = (0, 0, 0);
        for (place, dose) in &full {
            let burnt = slower.get(place).copied().unwrap_or(0.0);
            all += 1;
            weak += u32::from(burnt < 0.8 * dose);
            deep += u32::from(burnt > 1.05 * dose + 0.15);
            // If the next piece has not arrived yet, the arm plans a stop at the end of the current
            // one and replans a period later. Such a piece takes up to 7 periods instead of 4, with
            // the power for 4.
            assert!(
                burnt <= 7.0 / 4.0 * dose + 0.15,
                "{from} {speed} {place:?}: {burnt} {dose}"
            );
        }
        assert!(weak * 5 < all, "{from} {speed}: {weak} of {all} are weak");
        assert!(
            deep * 100 < all,
            "{from} {speed}: {deep} of {all} are deeper"
        );
        assert!(slower.keys().all(|place| full.contains_key(place)));
    }
}
