//! Programs on a virtual arm that are stopped while they run.

use std::time::Duration;

use magician::commands::Pose;
use magician::{Arm, Options, SimSpeed, VirtualArm};
use magician_program::rehearse::{RehearseOptions, stage};
use magician_program::resume::{ResumePoint, StepCounter, resume_point_at};
use magician_program::{Program, RemainingProgram};
use tokio::time::sleep;

/// Arm at real speed on the test's clock.
pub(crate) async fn place(program: &Program) -> (VirtualArm, Arm) {
    let arm = stage(program.plan(), &RehearseOptions::default()).expect("a stage");
    let cell = VirtualArm::new(arm, SimSpeed::Times(1.0));
    let arm = Arm::simulated(cell.clone(), Options::default()).await;
    (cell, arm.expect("a virtual arm"))
}

/// Runs a program from a step, or a place within it, to its end or a stop. Returns the rest it ran,
/// how it ended, and the pose.
pub(crate) async fn run_until(
    arm: &Arm,
    program: &Program,
    (from, at): (u64, Option<[f64; 3]>),
    stop: Option<Duration>,
) -> Option<(RemainingProgram, ResumePoint, Pose)> {
    let start = arm.preflight_for(&program.kinds()).await.expect("read");
    let rest = program
        .remaining_within(from, at, start)
        .expect("within reach");
    assert!(rest.check().is_good());
    let mut counter = StepCounter::new(rest.lead(), false);
    let run = arm.start(rest.commands());
    let mut run = run.along(rest.start().clone());
    let all = run.wait(|progress| counter.note(progress.sent, progress.last.0));
    tokio::select! {
        ran = all => {
            ran.expect("it runs");
            return None;
        }
        () = async { match stop { Some(stop) => sleep(stop).await, None => std::future::pending().await } } => {}
    }
    arm.stop().await.expect("it stands");
    let pose: Pose = arm.get().await.expect("a pose");
    let index = arm.queue().current_index().await.expect("an index").0;
    let span = counter.finished(index);
    assert_eq!(span.least, span.most);
    let resume_point = resume_point_at(from + span.least, |steps| {
        rest.stands_after(steps, &pose, true)
    });
    // `run` borrows the rest.
    drop(run);
    Some((rest, resume_point, pose))
}
