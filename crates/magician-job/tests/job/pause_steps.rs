//! Steps that wait for a person, and parts: the progress counts steps without commands, and nothing
//! moves until a person resumes.

use std::time::Duration;

use magician::commands::Pose;
use magician::{Arm, VirtualArm};
use magician_job::{
    FileJournal, Job, JobError, JobHandle, JobSpec, JobState, NoJournal, PauseReason, Start,
};
use magician_picture::compare::{compare, lines_of};
use magician_program::{Action, Ending, Origin, Part, Pause, PauseCause, Plan, Program};
use tokio::time::sleep;

use super::fixtures::{Kind, PAPER, bench, ink, plan};

fn pause(cause: PauseCause) -> Action {
    let text = "mount the pen".to_owned();
    Action::Pause(Box::new(Pause { text, cause }))
}

fn part(n: u64) -> Action {
    Action::Part(Box::new(Part {
        n,
        ..Part::default()
    }))
}

/// The lines and the arcs, as two parts with a pause between them.
fn two_parts() -> Plan {
    let mut both = plan(Kind::Lines);
    let mut steps = vec![part(1)];
    steps.extend(both.steps.drain(..).map(|step| step.action));
    steps.extend([pause(PauseCause::Part), part(2)]);
    steps.extend(plan(Kind::Arcs).steps.into_iter().map(|step| step.action));
    for step in steps {
        both.push(step, Origin::NONE);
    }
    both
}

fn start(arm: &Arm, program: &Program) -> JobHandle {
    Job::start(arm, JobSpec::new(program.clone()), NoJournal)
}

async fn wait_for_pause(job: &JobHandle) -> (PauseReason, Option<u64>) {
    for _ in 0..3000 {
        if let JobState::Paused { reason, part } = job.state() {
            return (reason, part);
        }
        assert_ne!(job.state(), JobState::Ended, "it does not pause");
        sleep(Duration::from_millis(100)).await;
    }
    panic!("it does not pause");
}

/// Asserts that nothing waits in the arm, the pen is up, and nothing moves for a minute.
async fn assert_stands_still(cell: &VirtualArm, arm: &Arm) {
    let (_, places) = arm.stats().await.expect("read");
    assert_eq!(arm.queue().left_space().await.expect("read"), places);
    let before = arm.get::<Pose>().await.expect("a pose");
    assert!(f64::from(before.z) > PAPER + 5.0, "{before:?}");
    sleep(Duration::from_secs(60)).await;
    assert!(!cell.with(|arm| arm.state().moving));
    assert_eq!(arm.get::<Pose>().await.expect("a pose"), before);
}

/// Drawing by the plan without its pauses, and the length of the lines, mm.
async fn run_uninterrupted(plan: &Plan) -> (magician::sim::world::Drawing, f64) {
    let mut plan = plan.clone();
    plan.without_pauses();
    let program = Program::new(plan, Some(1));
    let (cell, arm) = bench(&program).await;
    start(&arm, &program).outcome().await.expect("within reach");
    ink(&cell)
}

#[tokio::test(start_paused = true)]
async fn job_pauses_between_parts_with_pen_up_and_empty_queue() {
    let whole = run_uninterrupted(&two_parts()).await;
    for iterations in [1, 2] {
        let program = Program::new(two_parts(), Some(iterations));
        let (cell, arm) = bench(&program).await;
        let job = start(&arm, &program);
        for nth in 1..=iterations {
            assert_eq!(wait_for_pause(&job).await, (PauseReason::Part, Some(2)));
            assert_eq!(job.pause_text().as_deref(), Some("mount the pen"));
            assert_stands_still(&cell, &arm).await;
            let (at, _) = program.plan().pauses().next().expect("one");
            let each = program.plan().steps.len() as u64;
            assert_eq!(job.progress().step, (nth - 1) * each + at as u64);
            job.resume().await.expect("it goes on");
            assert_eq!(job.pause_text(), None);
        }
        let done = job.outcome().await.expect("done");
        assert_eq!(Some(done.steps), program.steps());
        assert_eq!(Some(job.progress().step), program.steps());
        let (drawing, length) = ink(&cell);
        assert!(
            (length - iterations as f64 * whole.1).abs() < 1e-3,
            "{length} {}",
            whole.1
        );
        let close = compare(&lines_of(&whole.0), &lines_of(&drawing), 0.2).matched;
        assert!(close.is_good(), "{close:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn pause_may_be_the_first_and_the_last_step() {
    let mut plan = plan(Kind::Lines);
    let first = magician_program::Step::new(pause(PauseCause::Program), Origin::NONE);
    plan.steps.insert(0, first.clone());
    plan.steps.insert(0, first);
    plan.push(part(1), Origin::NONE);
    plan.push(pause(PauseCause::Program), Origin::NONE);
    let whole = run_uninterrupted(&plan).await.1;
    let program = Program::new(plan, Some(1));
    let (cell, arm) = bench(&program).await;
    let before = arm.get::<Pose>().await.expect("a pose");
    let job = start(&arm, &program);
    for _ in 0..2 {
        assert_eq!(wait_for_pause(&job).await, (PauseReason::Program, None));
        sleep(Duration::from_secs(9)).await;
        assert_eq!(arm.get::<Pose>().await.expect("a pose"), before);
        job.resume().await.expect("it goes on");
    }
    assert_eq!(wait_for_pause(&job).await, (PauseReason::Program, None));
    assert_stands_still(&cell, &arm).await;
    job.resume().await.expect("it goes on");
    let done = job.outcome().await.expect("done");
    assert_eq!(Some(done.steps), program.steps());
    assert!((ink(&cell).1 - whole).abs() < 1e-3);
}

#[tokio::test(start_paused = true)]
async fn pause_with_pen_down_resumes_on_the_same_line() {
    let mut plan = plan(Kind::Lines);
    let middle = plan.steps.len() / 2;
    let at = magician_program::Step::new(pause(PauseCause::Program), Origin::NONE);
    plan.steps.insert(middle, at);
    let whole = run_uninterrupted(&plan).await.1;
    let program = Program::new(plan, Some(1));
    let (cell, arm) = bench(&program).await;
    let job = start(&arm, &program);
    wait_for_pause(&job).await;
    assert_stands_still(&cell, &arm).await;
    job.resume().await.expect("it goes on");
    job.outcome().await.expect("done");
    assert!((ink(&cell).1 - whole).abs() < 0.2);
}

#[tokio::test(start_paused = true)]
async fn job_parks_its_tool_between_parts() {
    let park = [200.0, 80.0, 60.0];
    let program = Program::new(two_parts(), Some(1));
    let (_cell, arm) = bench(&program).await;
    let ending = Ending {
        park: Some(park),
        ..Ending::default()
    };
    let job = Job::start(&arm, JobSpec::new(program).ending(ending), NoJournal);
    wait_for_pause(&job).await;
    let pose = arm.get::<Pose>().await.expect("a pose");
    let off = [pose.x, pose.y, pose.z].map(f64::from);
    assert!(
        (0..3).all(|axis| (off[axis] - park[axis]).abs() < 0.1),
        "{pose:?}"
    );
    job.resume().await.expect("it goes on");
    job.outcome().await.expect("done");
}

/// A job stopped at the pause, or within either part, is resumed by another job, which pauses where
/// the first one did.
#[tokio::test(start_paused = true)]
async fn stopped_job_with_parts_resumes_in_a_new_job() {
    let whole = run_uninterrupted(&two_parts()).await.1;
    let program = Program::new(two_parts(), Some(1));
    let home = std::env::temp_dir().join(format!("magician-waits-{}", std::process::id()));
    for (nth, (pauses, wait)) in [(0, 3.0), (0, 5.0), (1, 0.0), (1, 2.0), (1, 4.0)]
        .into_iter()
        .enumerate()
    {
        let (cell, arm) = bench(&program).await;
        let journal = || FileJournal::at(home.join(nth.to_string()));
        let spec = || JobSpec::new(program.clone());
        let job = Job::start(&arm, spec(), journal());
        if pauses == 1 {
            wait_for_pause(&job).await;
            if wait > 0.0 {
                job.resume().await.expect("it goes on");
            }
        }
        sleep(Duration::from_secs_f64(wait)).await;
        job.stop();
        let error: std::sync::Arc<JobError> = job.outcome().await.expect_err("it was stopped");
        assert!(error.is_stop(), "{error}");
        let job = Job::start(&arm, spec().start(Start::Resume), journal());
        if wait == 0.0 || pauses == 0 {
            assert_eq!(wait_for_pause(&job).await, (PauseReason::Part, Some(2)));
            job.resume().await.expect("it goes on");
        }
        job.outcome()
            .await
            .unwrap_or_else(|error| panic!("{nth}: {error}"));
        let all = ink(&cell).1;
        assert!((all - whole).abs() < 0.4, "{nth}: {all} instead of {whole}");
    }
    let _ = std::fs::remove_dir_all(home);
}
