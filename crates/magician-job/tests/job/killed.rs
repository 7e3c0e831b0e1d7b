//! Jobs whose process is killed at each write of the journal, and at many instants in between:
//! another job resumes where the arm ended. No stroke is lost and none is drawn twice.

use std::mem::take;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::sim::Controller;
use magician::{Arm, Options, SimSpeed, VirtualArm, build};
use magician_job::{
    Fault, Job, JobError, JobEvent, JobSpec, JobState, Journal, JournalError, JournalKey, Start,
};
use magician_program::Program;
use magician_program::resume::{Checkpoint, DoubtReason, RunEnd};
use tokio::time::sleep;

use super::fixtures::{KINDS, Kind, bench, ink, program};

/// Arm and journal as a killed process leaves them.
pub(super) struct Killed {
    pub(super) arm: Controller,
    pub(super) journal: Option<Checkpoint>,
}

/// Journal that records, just before and just after each write, the state that a kill would leave.
#[derive(Clone, Default)]
pub(super) struct SnapshotJournal(Arc<Mutex<Inner>>);

#[derive(Default)]
struct Inner {
    cell: Option<VirtualArm>,
    now: Option<Checkpoint>,
    killed: Vec<Killed>,
}

impl SnapshotJournal {
    /// Journal left by a killed process.
    pub(super) fn left_by(killed: &Killed) -> Self {
        let watched = Self::default();
        watched.0.lock().unwrap().now = killed.journal.clone();
        watched
    }

    fn of(cell: &VirtualArm, before: Option<Checkpoint>) -> Self {
        let watched = Self::default();
        {
            let mut inner = watched.0.lock().unwrap();
            (inner.cell, inner.now) = (Some(cell.clone()), before);
        }
        watched
    }

    /// Records the state at a possible kill.
    fn record(&self) {
        let mut inner = self.0.lock().unwrap();
        let arm = inner.cell.as_ref().map(|cell| cell.with(|arm| arm.clone()));
        if let Some(arm) = arm {
            let journal = inner.now.clone();
            inner.killed.push(Killed { arm, journal });
        }
    }

    fn store(&self, now: Option<Checkpoint>) {
        self.record();
        self.0.lock().unwrap().now = now;
        self.record();
    }
}

impl Journal for SnapshotJournal {
    fn open(&mut self, _: &JournalKey) {}

    fn load(&self) -> Result<Checkpoint, JournalError> {
        let left = self.0.lock().unwrap().now.clone();
        left.ok_or(JournalError::NotFound)
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> std::io::Result<()> {
        self.store(Some(checkpoint.clone()));
        Ok(())
    }

    fn remove(&mut self) {
        self.store(None);
    }
}

/// An arm that has done something before, and its index at rest.
async fn arm_with_history(program: &Program) -> (VirtualArm, Arm, u64) {
    let (cell, arm) = bench(program).await;
    let waits = [build::wait(Duration::from_millis(5)); 13];
    arm.run(&waits).await.expect("it waits");
    let rest = arm.queue().current_index().await.expect("an index").0;
    (cell, arm, rest)
}

/// Runs a program to its end. Returns the arms and journals that a kill would have left on the way,
/// the length of the drawing (mm), and the arm's index before the job.
pub(super) async fn killed(
    program: &Program,
    speed: u8,
    before: Option<Checkpoint>,
) -> (Vec<Killed>, f64, u64) {
    killed_with(program, speed, before, |spec| spec).await
}

/// Like `killed`, for a job started in a given way.
async fn killed_with(
    program: &Program,
    speed: u8,
    before: Option<Checkpoint>,
    with: impl FnOnce(JobSpec) -> JobSpec,
) -> (Vec<Killed>, f64, u64) {
    let (cell, arm, rest) = arm_with_history(program).await;
    let journal = SnapshotJournal::of(&cell, before);
    let job = Job::start(
        &arm,
        with(JobSpec::new(program.clone()).outlives_process(true)),
        journal.clone(),
    );
    if speed != 100 {
        job.set_speed(speed).expect("it begins");
    }
    let mut nth = 0_u64;
    while job.state() != JobState::Ended {
        journal.record();
        nth += 1;
        sleep(Duration::from_millis(if nth < 60 { 10 } else { 400 })).await;
    }
    job.outcome().await.expect("done");
    let killed = take(&mut journal.0.lock().unwrap().killed);
    (killed, ink(&cell).1, rest)
}

/// Resumes a killed job as another process would. Returns the arm, the finished steps or the error,
/// and the step at which the job started.
async fn resume(
    program: &Program,
    killed: &Killed,
) -> (VirtualArm, Arm, Result<u64, Arc<JobError>>, Option<u64>) {
    let cell = VirtualArm::new(killed.arm.clone(), SimSpeed::Times(1.0));
    let arm = Arm::simulated(cell.clone(), Options::default()).await;
    let arm = arm.expect("a virtual arm");
    let journal = SnapshotJournal::left_by(killed);
    let spec = JobSpec::new(program.clone()).outlives_process(true);
    let job = Job::start(&arm, spec.start(Start::Resume), journal);
    let mut events = job.events();
    let mut starts = None;
    while let Some(event) = events.next().await {
        if let JobEvent::Start(at) = event {
            starts = Some(at.steps);
        }
    }
    let outcome = job.outcome().await.map(|done| done.steps);
    (cell, arm, outcome, starts)
}

/// Asserts that resuming a killed job draws every stroke once; returns the reason if it refuses.
async fn assert_complete(
    program: &Program,
    killed: &Killed,
    whole: f64,
    rest: u64,
) -> Option<DoubtReason> {
    let (cell, arm, outcome, starts) = resume(program, killed).await;
    let taken = arm.queue().current_index().await.expect("an index").0 > rest;
    let drawn = ink(&cell).1;
    let context = format!("{starts:?} of {:?}, {drawn} of {whole} mm", killed.journal);
    match outcome {
        Ok(_) => {}
        Err(error) => match &error.fault {
            Fault::AllDone => {}
            // Nothing was sent, or everything is done.
            Fault::Journal(JournalError::NotFound) => {
                assert!(!taken || (drawn - whole).abs() < 0.1, "{context}");
                return None;
            }
            Fault::Doubt { span, why } => {
                assert!(span.least <= span.most, "{context}");
                return Some(*why);
            }
            _ => panic!("{error}: {context}"),
        },
    }
    assert!((drawn - whole).abs() < 0.1, "{context}");
    None
}

#[tokio::test(start_paused = true)]
async fn job_killed_at_any_instant_resumes_without_lost_or_doubled_strokes() {
    for kind in KINDS {
        let iterations = if matches!(kind, Kind::Jumps) { 2 } else { 1 };
        let program = program(kind, iterations);
        let (all, whole, rest) = killed(&program, 100, None).await;
        assert!(all.len() > 80, "{}", all.len());
        for one in &all {
            let doubt = assert_complete(&program, one, whole, rest).await;
            assert_eq!(doubt, None, "{kind:?}: {:?}", one.journal);
        }
    }
}

/// Indices may also count commands outside the program. Then the pose decides, or the job says why
/// it cannot resume.
#[tokio::test(start_paused = true)]
async fn killed_job_with_skipped_indices_resumes_by_pose_or_reports_doubt() {
    for kind in [Kind::Lines, Kind::Jumps] {
        let program = program(kind, 1);
        let (all, whole, rest) =
            killed_with(&program, 100, None, |spec| spec.index_may_skip(true)).await;
        let mut doubtful = 0;
        for one in &all {
            match assert_complete(&program, one, whole, rest).await {
                None => {}
                Some(DoubtReason::Mixed) => doubtful += 1,
                Some(other) => panic!("{other:?}: {:?}", one.journal),
            }
        }
        assert!(
            doubtful * 10 < all.len(),
            "{kind:?}: {doubtful} of {}",
            all.len()
        );
    }
}

#[tokio::test(start_paused = true)]
async fn killed_job_at_another_speed_resumes_from_any_instant() {
    let program = program(Kind::Lines, 1);
    let (all, whole, rest) = killed(&program, 60, None).await;
    for one in &all {
        let doubt = assert_complete(&program, one, whole, rest).await;
        assert_eq!(doubt, None, "{:?}", one.journal);
    }
}

/// The journal of an earlier run stays valid until the arm has taken a command of this one.
#[tokio::test(start_paused = true)]
async fn earlier_journal_is_replaced_before_the_first_command() {
    let program = program(Kind::Lines, 1);
    let earlier = Checkpoint {
        finished: 40,
        handed: 40,
        ended: Some(RunEnd::Between),
        ..Checkpoint::new("a drawing", program.steps(), false)
    };
    let (all, ..) = killed(&program, 100, Some(earlier.clone())).await;
    let (mut of_earlier, mut of_this) = (0, 0);
    for one in &all {
        let state = one.arm.state();
        match &one.journal {
            Some(journal) if *journal == earlier => {
                assert_eq!(state.queue.waiting, 0);
                of_earlier += 1;
            }
            _ => of_this += 1,
        }
    }
    assert!(of_earlier > 0 && of_this > 100, "{of_earlier} {of_this}");
}

#[tokio::test(start_paused = true)]
async fn killed_job_reports_a_reset_or_foreign_use_of_the_arm() {
    let program = program(Kind::Lines, 1);
    let (all, _, rest) = killed(&program, 100, None).await;
    let early = all.into_iter().filter(|one| {
        one.journal
            .as_ref()
            .is_some_and(|journal| journal.finished < 3)
    });
    let mut early: Vec<Killed> = early.collect();
    let mut one = early.swap_remove(early.len() / 2);
    let journal = one.journal.clone().expect("it is written");
    assert_eq!(journal.rest, Some(rest));

    one.journal = Some(Checkpoint {
        clock: u32::MAX,
        ..journal.clone()
    });
    let (.., outcome, _) = resume(&program, &one).await;
    let error = outcome.unwrap_err();
    assert!(
        matches!(
            error.fault,
            Fault::Doubt {
                why: DoubtReason::Reset,
                ..
            }
        ),
        "{error}"
    );

    let cell = VirtualArm::new(one.arm.clone(), SimSpeed::Times(1.0));
    let arm = Arm::simulated(cell.clone(), Options::default())
        .await
        .expect("an arm");
    sleep(Duration::from_secs(60)).await;
    let waits = vec![build::wait(Duration::from_millis(1)); 200];
    arm.run(&waits).await.expect("another program");
    drop(arm);
    one.arm = cell.with(|arm| arm.clone());
    one.journal = Some(journal);
    let (.., outcome, _) = resume(&program, &one).await;
    let error = outcome.unwrap_err();
    assert!(
        matches!(
            error.fault,
            Fault::Doubt {
                why: DoubtReason::ForeignCommands,
                ..
            }
        ),
        "{error}"
    );
}
