//! A drawing paused at any instant resumes where the pen stood: neither gap nor double stroke.

use std::time::Duration;

use magician::commands::{Pose, PtpCommonParams};
use magician::{Arm, VirtualArm, build};
use magician_job::{Job, JobHandle, JobSpec, JobState, NoJournal, PauseReason};
use magician_picture::compare::{compare, lines_of};
use magician_program::Program;
use tokio::time::sleep;

use super::fixtures::{KINDS, Kind, PAPER, bench, ink, program};

/// Longest gap or double stroke allowed, mm.
const MAX_DEVIATION: f64 = 0.2;
/// Number of instants at which each drawing is paused.
const INSTANTS: u32 = 13;

fn start(arm: &Arm, program: &Program) -> JobHandle {
    Job::start(arm, JobSpec::new(program.clone()), NoJournal)
}

/// Asserts that nothing of the job is in the arm, and that its pen is up.
async fn is_at_rest(cell: &VirtualArm, arm: &Arm, drawn: bool) {
    let (_, places) = arm.stats().await.expect("read");
    assert_eq!(arm.queue().left_space().await.expect("read"), places);
    assert!(!cell.with(|arm| arm.state().moving));
    let pose = arm.get::<Pose>().await.expect("a pose");
    assert!(!drawn || f64::from(pose.z) > PAPER + 5.0, "{pose:?}");
}

/// Moves the arm away as another program.
async fn jog_away(arm: &Arm, nth: u32) {
    let y = if nth.is_multiple_of(2) { 12.0 } else { -12.0 };
    let away = [build::line_by(8.0, y, 6.0, 0.0)];
    arm.run(&away).await.expect("it moves");
}

#[tokio::test(start_paused = true)]
async fn drawing_paused_at_any_instant_has_no_gap_and_no_double_stroke() {
    for (kind, iterations) in KINDS
        .map(|kind| (kind, 1))
        .into_iter()
        .chain([(Kind::Arcs, 2), (Kind::Lines, 2)])
    {
        let program = program(kind, iterations);
        let (cell, arm) = bench(&program).await;
        let began = cell.state().now;
        let done = start(&arm, &program).outcome().await.expect("within reach");
        assert_eq!(Some(done.steps), program.steps());
        let whole = cell.state().now - began;
        let (drawing, length) = ink(&cell);
        let lines = lines_of(&drawing);
        for nth in 1..INSTANTS {
            let (cell, arm) = bench(&program).await;
            let job = start(&arm, &program);
            let mut pauses = 0;
            let mut wait = whole.mul_f64(f64::from(nth) / f64::from(INSTANTS));
            // A resumed job can be paused again.
            for again in 0..2 {
                sleep(wait).await;
                if job.pause(PauseReason::Person).await.is_err() {
                    break;
                }
                pauses += 1;
                let reason = PauseReason::Person;
                assert_eq!(job.state(), JobState::Paused { reason, part: None });
                is_at_rest(&cell, &arm, ink(&cell).1 > 0.0).await;
                if (nth + again).is_multiple_of(3) {
                    jog_away(&arm, nth).await;
                }
                job.resume().await.expect("it goes on");
                wait = whole.mul_f64(0.2);
                if !nth.is_multiple_of(4) {
                    break;
                }
            }
            let done = job.outcome().await;
            let done = done.unwrap_or_else(|error| panic!("{kind:?} {nth}: {error}"));
            assert_eq!(Some(done.steps), program.steps(), "{kind:?} {nth}");
            let (drawn, all) = ink(&cell);
            let more = all - length;
            let most = MAX_DEVIATION * f64::from(pauses);
            assert!(more.abs() <= most + 1e-6, "{kind:?} {nth}: {more} mm");
            let close = compare(&lines, &lines_of(&drawn), MAX_DEVIATION).matched;
            assert!(close.is_good(), "{kind:?} {nth}: {close:?}");
            let ratio = arm.get::<PtpCommonParams>().await.expect("read");
            assert_eq!(ratio.velocity_ratio, 50.0, "settings are restored");
        }
    }
}

/// The part after the pause gets the speeds that the steps before have set.
#[tokio::test(start_paused = true)]
async fn speeds_survive_a_pause() {
    let program = program(Kind::Lines, 1);
    let (cell, arm) = bench(&program).await;
    let job = start(&arm, &program);
    sleep(Duration::from_secs(4)).await;
    job.pause(PauseReason::Person).await.expect("it runs");
    assert!(ink(&cell).1 > 0.0);
    // A jog pad sets its own speeds.
    let other = PtpCommonParams {
        velocity_ratio: 90.0,
        acceleration_ratio: 90.0,
    };
    arm.set(&other).await.expect("taken");
    job.resume().await.expect("it goes on");
    sleep(Duration::from_secs(2)).await;
    let set = arm.get::<PtpCommonParams>().await.expect("read");
    assert_eq!((set.velocity_ratio, set.acceleration_ratio), (35.0, 60.0));
    job.outcome().await.expect("done");
    let set = arm.get::<PtpCommonParams>().await.expect("read");
    assert_eq!(set.velocity_ratio, 50.0);
}

#[tokio::test(start_paused = true)]
async fn arm_stop_before_a_paused_job_starts_does_not_end_it() {
    let program = program(Kind::Lines, 1);
    let (_cell, arm) = bench(&program).await;
    let job = start(&arm, &program);
    job.pause(PauseReason::Person).await.expect("it pauses");
    arm.stop().await.expect("it stops");
    job.resume().await.expect("it goes on");
    let done = job.outcome().await.expect("it comes to its end");
    assert_eq!(Some(done.steps), program.steps());
}
