//! A job from start to end: its states, pauses and stops at any time, and the journal that outlives
//! it.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::commands::{EndEffectorLaser, Pose};
use magician::{Alarm, Arm, ErrorKind, Options, VirtualArm};
use magician_job::{
    Fault, FileJournal, Job, JobError, JobEvent, JobHandle, JobSpec, JobState, Journal,
    JournalError, JournalKey, NoJournal, PauseError, PauseReason, PenLift, ResumeError,
    ResumePlace, Start,
};
use magician_program::resume::{Checkpoint, RunEnd};
use magician_program::{Action, Origin, Plan, Program, Travel};
use tokio::time::sleep;

use super::fixtures::{Kind, PAPER, bench, ink, program};

const PERSON: PauseReason = PauseReason::Person;

fn start(arm: &Arm, program: &Program) -> JobHandle {
    Job::start(arm, JobSpec::new(program.clone()), NoJournal)
}

fn secs(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

async fn height(arm: &Arm) -> f64 {
    arm.get::<Pose>().await.expect("a pose").z.into()
}

fn is_paused(job: &JobHandle) -> bool {
    matches!(job.state(), JobState::Paused { .. })
}

/// A journal in memory.
#[derive(Clone, Default)]
pub(super) struct MemoryJournal(Arc<Mutex<Vec<Option<Checkpoint>>>>);

impl MemoryJournal {
    pub(super) fn last(&self) -> Option<Checkpoint> {
        self.0.lock().unwrap().last().cloned().flatten()
    }
}

impl Journal for MemoryJournal {
    fn open(&mut self, key: &JournalKey) {
        assert_eq!(key.arm, "virtual");
    }

    fn load(&self) -> Result<Checkpoint, JournalError> {
        self.last().ok_or(JournalError::NotFound)
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> std::io::Result<()> {
        self.0.lock().unwrap().push(Some(checkpoint.clone()));
        Ok(())
    }

    fn remove(&mut self) {
        self.0.lock().unwrap().push(None);
    }
}

#[tokio::test(start_paused = true)]
async fn job_reports_its_states_and_progress() {
    let program = program(Kind::Arcs, 2);
    let (_cell, arm) = bench(&program).await;
    let job = start(&arm, &program);
    let mut events = job.events();
    let (mut states, mut last, mut event_count) = (Vec::new(), 0, 0_u64);
    while let Some(event) = events.next().await {
        match event {
            JobEvent::State(state) => states.push(state),
            JobEvent::Progress(progress) => {
                assert!(progress.step >= last && progress.steps == program.steps());
                assert!((1..=2).contains(&progress.iteration));
                (last, event_count) = (progress.step, event_count + 1);
            }
            _ => {}
        }
    }
    use JobState::{Ended, Ending, Running};
    assert_eq!(states, [Running, Ending, Ended]);
    assert_eq!(Some(last), program.steps());
    let done = job.outcome().await.expect("done");
    assert!(
        event_count > 3 && event_count as f64 <= 10.0 * done.seconds + 2.0,
        "{event_count}"
    );
    assert!(done.end.is_some_and(|end| end.pen_is_up == Some(true)));
    assert!(job.clone().outcome().await.is_ok(), "every clone may wait");
    assert_eq!(job.events().next().await, None, "it is over");
}

/// A resume and a pause that is requested right after it take effect in this order.
#[tokio::test(start_paused = true)]
async fn pause_requested_during_resume_is_not_lost() {
    let program = program(Kind::Lines, 1);
    for during_check in [true, false] {
        let (cell, arm) = bench(&program).await;
        let job = start(&arm, &program);
        if !during_check {
            sleep(secs(4.0)).await;
        }
        job.pause(PERSON).await.expect("it runs");
        let drawn = ink(&cell).1;
        let (resumed, paused_again) = (job.resume(), job.pause(PERSON));
        resumed.await.expect("it goes on");
        paused_again.await.expect("it is paused");
        assert!(is_paused(&job));
        sleep(secs(5.0)).await;
        assert_eq!(ink(&cell).1, drawn);
        job.resume().await.expect("it goes on");
        let done = job.outcome().await.expect("done");
        assert_eq!(Some(done.steps), program.steps());
    }
}

#[tokio::test(start_paused = true)]
async fn pause_and_stop_are_defined_at_any_instant() {
    let program = program(Kind::Lines, 1);
    // A pause during the check: nothing is sent before the resume.
    let (cell, arm) = bench(&program).await;
    let job = start(&arm, &program);
    assert_eq!(job.state(), JobState::Checking);
    assert!(matches!(job.resume().await, Err(ResumeError::NotPaused)));
    job.pause(PERSON).await.expect("it checks, or runs");
    assert!(is_paused(&job));
    sleep(secs(5.0)).await;
    if job.progress().step == 0 {
        assert_eq!(ink(&cell).1, 0.0);
    }
    // Two pauses at once.
    let (one, two) = (job.pause(PERSON), job.pause(PauseReason::Lease));
    assert_eq!((one.await, two.await), (Ok(()), Ok(())));
    job.resume().await.expect("it begins");
    assert!(matches!(job.resume().await, Err(ResumeError::NotPaused)));
    sleep(secs(4.0)).await;
    let (one, two) = (job.pause(PERSON), job.pause(PauseReason::Lease));
    assert_eq!((one.await, two.await), (Ok(()), Ok(())));
    let reason = PERSON;
    assert_eq!(job.state(), JobState::Paused { reason, part: None });
    // A stop during the pause: nothing moves.
    let pause_height = height(&arm).await;
    assert!(pause_height > PAPER + 5.0);
    job.stop();
    let error = job.outcome().await.expect_err("stopped");
    assert!(error.is_stop() && matches!(error.resume_place, Some(ResumePlace::Known { .. })));
    assert_eq!(height(&arm).await, pause_height);
    assert_eq!(job.pause(PERSON).await, Err(PauseError::Ended));
    assert!(matches!(job.resume().await, Err(ResumeError::NotPaused)));
    job.stop();
}

#[tokio::test(start_paused = true)]
async fn pause_after_the_last_step_is_refused_as_ending() {
    let program = program(Kind::Jumps, 1);
    let (_cell, arm) = bench(&program).await;
    let job = start(&arm, &program);
    let mut events = job.events();
    while let Some(event) = events.next().await {
        if event == JobEvent::State(JobState::Ending) {
            let late = job.pause(PERSON).await;
            assert!(late.is_err(), "{late:?}");
        }
    }
    job.outcome().await.expect("done all the same");
}

/// Journal on a disk that is full for the writes with these numbers (from 1).
struct FullDiskJournal {
    written: MemoryJournal,
    writes: usize,
    full: std::ops::Range<usize>,
}

impl Journal for FullDiskJournal {
    fn open(&mut self, _: &JournalKey) {}

    fn load(&self) -> Result<Checkpoint, JournalError> {
        self.written.load()
    }

    fn write(&mut self, checkpoint: &Checkpoint) -> std::io::Result<()> {
        self.writes += 1;
        if self.full.contains(&self.writes) {
            Err(std::io::ErrorKind::StorageFull.into())
        } else {
            self.written.write(checkpoint)
        }
    }

    fn remove(&mut self) {}
}

#[tokio::test(start_paused = true)]
async fn full_disk_is_reported_once_and_in_the_outcome() {
    let program = program(Kind::Lines, 1);
    for (full, report_count, is_stored) in [
        (1..usize::MAX, 1, false),
        (3..usize::MAX, 1, false),
        (1..4, 1, true),
        (0..0, 0, true),
    ] {
        let (_cell, arm) = bench(&program).await;
        let journal = FullDiskJournal {
            written: MemoryJournal::default(),
            writes: 0,
            full: full.clone(),
        };
        let spec = JobSpec::new(program.clone()).outlives_process(true);
        let job = Job::start(&arm, spec, journal);
        let mut events = job.events();
        let (stopping, mut causes) = (job.clone(), Vec::new());
        tokio::spawn(async move {
            sleep(secs(4.0)).await;
            stopping.stop();
        });
        while let Some(event) = events.next().await {
            if let JobEvent::NotStored(cause) = event {
                causes.push(cause);
            }
        }
        assert_eq!(causes.len(), report_count, "{full:?}: {causes:?}");
        let error = job.outcome().await.expect_err("stopped");
        assert!(error.is_stop() && error.resume_place.is_some(), "{error:?}");
        assert_eq!(
            error.storage_error.is_none(),
            is_stored,
            "{full:?}: {error:?}"
        );
    }
}

/// After a reset the arm knows nothing of the earlier run: the run is reported, but not as
/// resumable.
#[tokio::test(start_paused = true)]
async fn interrupted_run_is_resumable_unless_the_arm_was_reset() {
    let program = program(Kind::Lines, 1);
    for reset in [false, true] {
        let (_cell, arm) = bench(&program).await;
        let mut checkpoint = Checkpoint::new("", program.steps(), false);
        (checkpoint.finished, checkpoint.handed) = (2, 4);
        (checkpoint.rest, checkpoint.clock) = (Some(0), if reset { u32::MAX } else { 0 });
        let mut written = MemoryJournal::default();
        written.write(&checkpoint).expect("kept");
        let journal = FullDiskJournal {
            written,
            writes: 0,
            full: 0..0,
        };
        let spec = JobSpec::new(program.clone()).outlives_process(true);
        let job = Job::start(&arm, spec, journal);
        let (mut events, mut reported) = (job.events(), None);
        while let Some(event) = events.next().await {
            if let JobEvent::Unfinished {
                finished,
                resumable,
            } = event
            {
                reported = Some((finished, resumable));
            }
        }
        assert_eq!(reported, Some((2, !reset)));
    }
}

#[tokio::test(start_paused = true)]
async fn stop_writes_the_checkpoint_before_lifting_the_pen() {
    let program = program(Kind::Paths, 1);
    let (cell, arm) = bench(&program).await;
    let journal = MemoryJournal::default();
    let job = Job::start(&arm, JobSpec::new(program.clone()), journal.clone());
    sleep(secs(4.0)).await;
    job.stop();
    let error = job.outcome().await.expect_err("stopped");
    let JobError {
        stopped_at,
        pose,
        lift,
        ..
    } = &*error;
    let (stopped_at, pose) = (stopped_at.expect("it stands"), pose.expect("told"));
    assert!(f64::from(stopped_at.pose.z) < PAPER + 0.5, "{stopped_at:?}");
    assert!(f64::from(pose.z) > PAPER + 5.0 && matches!(lift, PenLift::Lifted(_)));
    let checkpoint = journal.last().expect("kept");
    assert!(checkpoint.ended.is_some() && checkpoint.ended != Some(RunEnd::Doubt));
    // Another job resumes, and completes the drawing.
    let spec = JobSpec::new(program.clone()).start(Start::Resume);
    let job = Job::start(&arm, spec.clone(), journal.clone());
    let done = job.outcome().await.expect("it goes on");
    assert!(done.from > 0);
    let (_, all) = ink(&cell);
    let (other, arm_of_other) = bench(&program).await;
    start(&arm_of_other, &program)
        .outcome()
        .await
        .expect("done");
    assert!((ink(&other).1 - all).abs() < 0.2);
    assert_eq!(journal.last(), None, "removed");
    let second_resume = Job::start(&arm, spec, journal).outcome().await;
    let second_resume = second_resume.expect_err("nothing is left");
    assert!(matches!(
        second_resume.fault,
        Fault::Journal(JournalError::NotFound)
    ));
}

#[tokio::test(start_paused = true)]
async fn second_stop_moves_nothing() {
    let program = program(Kind::Paths, 1);
    let (_cell, arm) = bench(&program).await;
    let spec = JobSpec::new(program.clone());
    let ending = magician_program::Ending {
        lift: 60.0,
        ..spec.ending
    };
    let job = Job::start(&arm, spec.ending(ending), NoJournal);
    sleep(secs(4.0)).await;
    job.stop();
    while height(&arm).await < PAPER + 1.0 {
        sleep(secs(0.01)).await;
    }
    job.stop();
    let error = job.outcome().await.expect_err("stopped");
    assert!(matches!(error.fault, Fault::Stopped { twice: true }));
    assert!(height(&arm).await < PAPER + 55.0);
    assert!(matches!(
        error.resume_place,
        Some(ResumePlace::Known { .. })
    ));
}

#[tokio::test(start_paused = true)]
async fn dropping_the_last_handle_stops_the_job_unless_detached() {
    for detached in [false, true] {
        let program = program(Kind::Lines, 1);
        let (cell, arm) = bench(&program).await;
        let job = start(&arm, &program);
        let clone = job.clone();
        drop(job);
        sleep(secs(4.0)).await;
        assert_eq!(clone.state(), JobState::Running);
        if detached {
            clone.detach();
        }
        let drawn = ink(&cell).1;
        drop(clone);
        sleep(secs(60.0)).await;
        let more = ink(&cell).1 - drawn;
        assert_eq!(more > 20.0, detached, "{more}");
        assert!(height(&arm).await > PAPER + 5.0, "the pen is up");
    }
}

#[tokio::test(start_paused = true)]
async fn resume_after_a_reset_requires_homing() {
    let program = program(Kind::Lines, 1);
    let (cell, arm) = bench(&program).await;
    let job = start(&arm, &program);
    sleep(secs(4.0)).await;
    job.pause(PERSON).await.expect("it runs");
    cell.with(|arm| arm.inject(magician::sim::ExternalEvent::Alarm(Alarm::ResetOccurred)));
    let error = job.resume().await.expect_err("it has lost its place");
    assert!(error.wants_homing(), "{error}");
    assert!(is_paused(&job), "it stays so");
    arm.clear_alarms().await.expect("cleared");
    job.resume().await.expect("it goes on");
    job.outcome().await.expect("done");
}

/// The laser is off during every pause of a job, and burns again only after a resume.
#[tokio::test(start_paused = true)]
async fn laser_is_off_while_paused() {
    let mut plan = Plan::new("a burn");
    plan.tool = Some(magician_program::Tool::Laser);
    let line = |to: [f32; 4]| Action::Move {
        to,
        by: Travel::Line,
    };
    plan.push(line([210.0, -30.0, 0.0, 0.0]), Origin::NONE);
    for (y, power) in [(30.0, 60.0), (-30.0, 40.0)] {
        let to = [210.0, y, 0.0];
        plan.push(Action::Burn { to, power }, Origin::NONE);
    }
    plan.push(Action::Laser(false), Origin::NONE);
    plan.push(line([210.0, -30.0, 10.0, 0.0]), Origin::NONE);
    let program = Program::new(plan, Some(1));
    let (reference, arm) = bench(&program).await;
    start(&arm, &program).outcome().await.expect("done");
    let whole = ink(&reference).1;
    assert!(whole > 100.0, "{whole}");
    for seconds in [0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.6] {
        let (cell, arm) = bench(&program).await;
        let job = start(&arm, &program);
        sleep(secs(seconds)).await;
        job.pause(PERSON).await.expect("it runs");
        let laser = arm.get::<EndEffectorLaser>().await.expect("read");
        assert!(!laser.is_on.is_on());
        let burnt = ink(&cell).1;
        sleep(secs(60.0)).await;
        assert_eq!(ink(&cell).1, burnt, "nothing burns");
        job.resume().await.expect("it goes on");
        job.outcome().await.expect("done");
        let more = ink(&cell).1 - whole;
        // After a pause the job resumes where the arm stood. The laser went out up to one period
        // later, at 60 mm/s.
        assert!(
            (-0.2..0.02 * 60.0 + 0.2).contains(&more),
            "{seconds}: {more}"
        );
    }
}

/// A stop by another client ends the job, which knows where it resumes. Waiting commands of another
/// client make a new job refuse to start.
#[tokio::test(start_paused = true)]
async fn foreign_stop_ends_the_job_and_foreign_commands_prevent_its_start() {
    let program = program(Kind::Lines, 1);
    let (_cell, arm) = bench(&program).await;
    let job = start(&arm, &program);
    sleep(secs(4.0)).await;
    arm.stop().await.expect("it stops");
    let error = job.outcome().await.expect_err("stopped by another");
    let Fault::Arm(fault) = &error.fault else {
        panic!("{error}");
    };
    assert_eq!(fault.kind(), ErrorKind::Closed);
    assert!(matches!(error.lift, PenLift::None), "that is not the job's");
    assert!(error.resume_place.is_some());

    let (cell, arm) = bench(&program).await;
    let other = Arm::simulated(cell.clone(), Options::default())
        .await
        .expect("a second line");
    let wait = magician::commands::WaitCmd { timeout: 5000 };
    other.enqueue(&wait).await.expect("taken");
    let error = start(&arm, &program).outcome().await.expect_err("refused");
    let Fault::Arm(fault) = &error.fault else {
        panic!("{error}");
    };
    assert_eq!(fault.kind(), ErrorKind::InvalidInput);
    assert!(error.resume_place.is_none());
}

#[tokio::test(start_paused = true)]
async fn unreachable_program_sends_nothing() {
    let mut plan = Plan::new("too far");
    let to = [600.0, 0.0, 0.0, 0.0];
    let by = Travel::Line;
    plan.push(Action::Move { to, by }, Origin::NONE);
    let program = Program::new(plan, Some(1));
    let arm = VirtualArm::default();
    let before = arm.state().pose;
    let line = Arm::simulated(arm.clone(), Options::default())
        .await
        .expect("a line");
    let error = start(&line, &program).outcome().await.expect_err("refused");
    let Fault::Refused { report, .. } = &error.fault else {
        panic!("{error}");
    };
    assert_eq!((report.refused, arm.state().pose), (1, before));
}

/// The journal of one engine can be read by another: place and format of the file are stable.
#[tokio::test(start_paused = true)]
async fn journal_file_is_readable_by_another_process() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = program(Kind::Lines, 1);
    let (_cell, arm) = bench(&program).await;
    let journal = || FileJournal::at(folder.path());
    let spec = JobSpec::new(program.clone());
    let job = Job::start(&arm, spec.clone(), journal());
    sleep(secs(4.0)).await;
    job.stop();
    job.outcome().await.expect_err("stopped");
    let path = folder
        .path()
        .join(format!("{}-virtual.json", program.key()));
    let text = std::fs::read_to_string(&path).expect("kept");
    let checkpoint: Checkpoint = serde_json::from_str(&text).expect("a mark");
    assert_eq!(checkpoint.steps, program.steps());
    std::fs::write(&path, "{}").expect("written");
    let resume = || Job::start(&arm, spec.clone().start(Start::Resume), journal());
    let error = resume().outcome().await.expect_err("damaged");
    assert!(matches!(
        error.fault,
        Fault::Journal(JournalError::Unreadable { .. })
    ));
    std::fs::write(&path, text).expect("written");
    resume().outcome().await.expect("it goes on");
    assert!(!path.exists());
}

/// Several virtual arms of one process report the same serial number, run the same program and keep
/// their journals in the same folder.
#[tokio::test(start_paused = true)]
async fn virtual_arm_resumes_only_its_own_journal() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = program(Kind::Lines, 1);
    let spec = JobSpec::new(program.clone());
    let journal = || FileJournal::at(folder.path());
    let whole = {
        let (cell, arm) = bench(&program).await;
        let job = Job::start(&arm, spec.clone(), NoJournal);
        job.outcome().await.expect("done");
        ink(&cell).1
    };
    let mut cells = Vec::new();
    let mut stopped = Vec::new();
    for seconds in [2.0, 3.0, 4.0] {
        let (cell, arm) = bench(&program).await;
        let job = Job::start(&arm, spec.clone(), journal());
        sleep(secs(seconds)).await;
        job.stop();
        job.outcome().await.expect_err("stopped");
        stopped.push(arm);
        cells.push(cell);
    }
    // A job that ends well leaves the journals of the others alone.
    let (_cell, arm) = bench(&program).await;
    let resume = |arm: &Arm| Job::start(arm, spec.clone().start(Start::Resume), journal());
    let error = resume(&arm)
        .outcome()
        .await
        .expect_err("nothing is its own");
    assert!(
        matches!(error.fault, Fault::Journal(JournalError::NotFound)),
        "{error}"
    );
    let job = Job::start(&arm, spec.clone(), journal());
    job.outcome().await.expect("done");
    for (arm, cell) in stopped.iter().zip(&cells) {
        let before = ink(cell).1;
        assert!(before < whole);
        resume(arm).outcome().await.expect("it goes on");
        let drawn = ink(cell).1;
        assert!((drawn - whole).abs() < 0.3, "{drawn} mm of {whole}");
    }
    let left = std::fs::read_dir(folder.path()).expect("read").count();
    assert_eq!(left, 0);
}

/// Jobs of two arms with the same serial number have a file each. A resume takes the newest file
/// that no job holds.
#[test]
fn claimed_journal_is_not_taken_over() {
    let folder = tempfile::tempdir().expect("a folder");
    let key = |virtual_arm| {
        let mut key = JournalKey::new("program", "A1");
        key.virtual_arm = virtual_arm;
        key
    };
    let opened = |number| {
        let mut journal = FileJournal::at(folder.path());
        journal.open(&key(number));
        journal
    };
    let checkpoint = |finished| Checkpoint {
        finished,
        ..Checkpoint::new("a drawing", Some(9), false)
    };
    let finished = |journal: &FileJournal| journal.load().map(|left| left.finished);
    let (mut one, mut two) = (opened(None), opened(None));
    one.write(&checkpoint(1)).expect("kept");
    two.write(&checkpoint(2)).expect("kept");
    one.write(&checkpoint(3)).expect("kept");
    assert_eq!((finished(&one), finished(&two)), (Ok(3), Ok(2)));
    assert_eq!(finished(&opened(None)), Err(JournalError::NotFound));
    drop(one);
    let mut one = opened(None);
    assert_eq!(finished(&one), Ok(3));
    two.remove();
    assert_eq!(finished(&one), Ok(3));
    one.remove();
    // Between two jobs the file of a virtual arm stays reserved for this arm.
    let mut of_virtual = opened(Some(u64::MAX));
    of_virtual.write(&checkpoint(4)).expect("kept");
    drop(of_virtual);
    assert_eq!(
        finished(&opened(Some(u64::MAX - 1))),
        Err(JournalError::NotFound)
    );
    assert_eq!(finished(&opened(Some(u64::MAX))), Ok(4));
}

/// Handles of a job work from every thread, on any runtime.
#[test]
fn handle_is_send_and_sync() {
    fn assert_send_sync<T: Clone + Send + Sync + 'static>() {}
    assert_send_sync::<JobHandle>();
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let job = runtime.block_on(async {
        let program = program(Kind::Lines, 200);
        let (_cell, arm) = bench(&program).await;
        start(&arm, &program)
    });
    let clone = job.clone();
    drop(job);
    let other = std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().build();
        runtime.expect("a runtime").block_on(async {
            clone.pause(PERSON).await.expect("it runs");
            assert!(is_paused(&clone));
            clone.resume().await.expect("it goes on");
            clone.stop();
            clone.outcome().await.expect_err("stopped").is_stop()
        })
    });
    assert!(other.join().expect("no panic"));
}

/// A burn of several lines, stopped at many instants and resumed with an overlap: the length burnt
/// twice is the overlap, and the start event reports it.
#[tokio::test(start_paused = true)]
async fn resumed_burn_overlaps_by_the_given_length() {
    let mut plan = Plan::new("a burn");
    plan.tool = Some(magician_program::Tool::Laser);
    let to = [210.0, -30.0, 0.0, 0.0];
    let by = Travel::Line;
    plan.push(Action::Move { to, by }, Origin::NONE);
    for nth in 0..20 {
        let to = [210.0 + (nth % 2) as f32, -27.0 + 3.0 * nth as f32, 0.0];
        plan.push(Action::Burn { to, power: 60.0 }, Origin::NONE);
    }
    plan.push(Action::Laser(false), Origin::NONE);
    let program = Program::new(plan, Some(1));
    let (reference, arm) = bench(&program).await;
    start(&arm, &program).outcome().await.expect("done");
    let whole = ink(&reference).1;
    for seconds in [1.7, 2.4, 3.3] {
        for overlap in [0.0, 0.5, 4.0, 500.0] {
            let (cell, arm) = bench(&program).await;
            let journal = MemoryJournal::default();
            let spec = || JobSpec::new(program.clone()).overlap(overlap);
            let job = Job::start(&arm, spec(), journal.clone());
            sleep(secs(seconds)).await;
            job.stop();
            job.outcome().await.expect_err("stopped");
            let burnt = ink(&cell).1;
            assert!(burnt > 0.0 && burnt < whole, "{seconds}: {burnt}");
            let job = Job::start(&arm, spec().start(Start::Resume), journal.clone());
            let mut events = job.events();
            let twice = loop {
                let event = events.next().await.expect("it tells where it starts");
                if let JobEvent::Start(starts) = event {
                    break starts.burnt_twice;
                }
            };
            job.outcome().await.expect("it goes on");
            let more = ink(&cell).1 - whole;
            // The arm follows these lines of 3 and 1 mm with right angles at up to (2 * 100 mm/s2 *
            // 1.5 mm)^0.5 = 17.4 mm/s, and the laser goes out within one period at that speed. If
            // the arm comes to rest within a period, the distance of half a period is added.
            let period = 0.02 * 17.4;
            assert!(
                (-1.5 * period - 0.3..0.3).contains(&(more - twice)),
                "{seconds} {overlap}: {more} {twice}"
            );
            assert!(
                (-0.3..1.5 * period + 0.3).contains(&(twice - overlap.min(burnt))),
                "{seconds} {overlap}: {twice} {burnt}"
            );
        }
    }
}

/// The same file with another flag is another program: the error names the interrupted program.
#[test]
fn nothing_to_resume_names_interrupted_jobs_of_the_same_arm() {
    let folder = tempfile::tempdir().expect("a folder");
    let opened = |program: &str, arm: &str| {
        let mut journal = FileJournal::at(folder.path());
        journal.open(&JournalKey::new(program, arm));
        journal
    };
    let checkpoint = Checkpoint {
        version: Checkpoint::VERSION,
        title: "logo".to_owned(),
        finished: 116,
        ..Checkpoint::default()
    };
    opened("a1", "DT 1").write(&checkpoint).expect("kept");
    opened("b2", "DT 12").write(&checkpoint).expect("kept");
    let others = |error: Result<Checkpoint, JournalError>| match error {
        Err(JournalError::OtherPrograms(others)) => others,
        other => panic!("{other:?}"),
    };
    let left = others(opened("c3", "DT 1").load());
    assert_eq!(left.len(), 1);
    assert_eq!((left[0].title.as_str(), left[0].finished), ("logo", 116));
    assert_eq!(opened("c3", "DT 3").load(), Err(JournalError::NotFound));
    assert_eq!(opened("a1", "DT 1").load(), Ok(checkpoint));
}
