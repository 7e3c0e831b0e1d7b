//! Jobs of an arm: checking the program, running it through `magician-job`, and
//! reporting.
//!
//! A job occupies the slot of its arm from the order that starts it until it ends. Its program is
//! read in the background and not on the engine's task, because reading may take seconds. Meanwhile
//! pauses are stored, and a stop cancels the reading. A running job ends, pauses and resumes
//! through its [`JobHandle`].

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use magician::commands::Pose;
use magician::message;
use magician::{Arm, ErrorKind};
use magician_job::background::run_in_background;
use magician_job::report;
use magician_job::{
    Job, JobEvent, JobHandle, JobSpec, JobState, Journal, PauseReason, ResumeError, Start,
};
use magician_program::PreparedProgram;
use serde_json::{Value, json};
use tokio::sync::Notify;

use super::ending::switch_unattended_off;
use super::outcome::{end_of, notes_of, over};
use super::program::{ReadProgram, changed_program_error, read, report_value, with_check_report};
use super::world;
use super::{EngineTask, TaskResult, WaitingOrder};
use crate::api::RpcError;
use crate::control::{JobId, RequestId};
use crate::job::{self, Reader, Source};
use crate::order::{ArmAct, ArmReport, JobStart, JobUpdate, Outcome};
use crate::reading;
use crate::surface::ArmSurface;

/// Largest difference between the pose at the pause and the pose at a resume without approach, mm
/// and degrees. A choice: more than the arm's repeatability, less than a visible offset in a
/// drawing.
const MAX_POSE_DIFFERENCE: f32 = 0.5;

/// Resources of jobs besides the arm.
pub(super) struct JobContext {
    pub(super) reader: Arc<dyn Reader>,
    pub(super) surface: ArmSurface,
    pub(super) journal: Box<dyn Fn() -> Box<dyn Journal> + Send + Sync>,
}

/// Job of an arm, from its order to its end.
pub(super) struct JobSlot {
    id: JobId,
    /// Order that is carried out when the program has been read.
    start: Option<Box<JobStart>>,
    handle: Option<JobHandle>,
    /// Pauses requested before the job started.
    pauses: Vec<(Option<RequestId>, PauseReason)>,
    /// True if the job was stopped before it started.
    stopped: bool,
    /// Notified by that stop, so that the engine does not wait for a file that is read elsewhere.
    cancel: Arc<Notify>,
    /// Pose at the pause. `None` if it could not be read.
    pause_pose: Arc<std::sync::Mutex<Option<Pose>>>,
    /// True if no session holds the arm. Then motors that the job leaves running, and the laser,
    /// are switched off when it pauses or ends.
    ends_unattended: Arc<AtomicBool>,
}

/// The running job, shared with the shutdown of the station.
#[derive(Debug, Default)]
pub(super) struct RunningJob {
    handle: Option<JobHandle>,
    /// True once the station shuts down: no job starts any more.
    closed: bool,
}

impl RunningJob {
    /// Starts a job. `None` if the station is shutting down.
    fn start(running: &Mutex<Self>, start: impl FnOnce() -> JobHandle) -> Option<JobHandle> {
        let mut running = lock(running);
        if running.closed {
            return None;
        }
        Some(running.handle.insert(start()).clone())
    }

    /// Prevents further jobs. Returns the running one.
    pub(super) fn close(running: &Mutex<Self>) -> Option<JobHandle> {
        let mut running = lock(running);
        running.closed = true;
        running.handle.clone()
    }
}

impl JobSlot {
    pub(super) fn new(id: JobId) -> Self {
        Self {
            id,
            start: None,
            handle: None,
            pauses: Vec::new(),
            stopped: false,
            cancel: Arc::default(),
            pause_pose: Arc::default(),
            ends_unattended: Arc::default(),
        }
    }
}

/// Switches off motor outputs and the laser that a job left on, if no session holds the arm.
async fn end_unattended_outputs(arm: &Arm, ends_unattended: &AtomicBool) {
    if ends_unattended.load(Ordering::SeqCst)
        && let Err(error) = switch_unattended_off(arm).await
    {
        tracing::warn!(%error, "a motor or the laser may stay on after the job");
    }
}

impl EngineTask {
    /// Reads a program and checks it from the arm's current state.
    pub(super) fn check_job(&mut self, request: RequestId, source: Source, preview: bool) {
        let (arm, reader) = (self.arm.clone(), Arc::clone(&self.job_context.reader));
        let surface = self.job_context.surface.clone();
        self.side.spawn(async move {
            let found = async {
                let never = Notify::new();
                let read = read(&arm, None, reader, &surface, source, None, &never);
                let (program, digest) = read.await?;
                let kinds = program.program.kinds();
                let start = arm.preflight_for(&kinds).await?;
                let program = Arc::new(program);
                let (shown, preview_start) = (Arc::clone(&program), start.clone());
                let shown = async {
                    if preview {
                        Some(
                            run_in_background(
                                async move { job::preview(&shown, &preview_start).await },
                            )
                            .await,
                        )
                    } else {
                        None
                    }
                };
                let checked = run_in_background(async move {
                    report_value(&job::check(&program, start).await?, &digest)
                });
                // Preview and check use a thread each, where there are threads.
                let (shown, report) = tokio::join!(shown, checked);
                let mut report = report??;
                if let Some(shown) = shown.transpose()? {
                    report["preview"] = shown;
                }
                Ok(report)
            };
            let outcome = found.await.map(Outcome::Value);
            TaskResult::Report(ArmReport::Done { request, outcome })
        });
    }

    /// Reads the program of a job whose turn has come.
    pub(super) fn read_job(&mut self, start: JobStart) {
        let job = start.job;
        let (arm, reader) = (self.arm.clone(), Arc::clone(&self.job_context.reader));
        let surface = self.job_context.surface.clone();
        let (source, begun) = (start.order.source.clone(), start.order.start);
        let (unhomed, checked) = (start.order.unhomed, start.order.digest.clone());
        // Stays unused if the slot belongs to another job by now.
        let mut cancel = Arc::default();
        if let Some(slot) = self.job.as_mut().filter(|slot| slot.id == job) {
            slot.start = Some(Box::new(start));
            cancel = Arc::clone(&slot.cancel);
        }
        let runs_on = if unhomed {
            arm.allowing_unhomed()
        } else {
            arm.clone()
        };
        self.side.spawn(async move {
            let program = read(
                &arm,
                Some(&runs_on),
                reader,
                &surface,
                source,
                begun,
                &cancel,
            )
            .await;
            let program = match program {
                Ok((_, digest)) if checked.is_some_and(|checked| checked != digest) => {
                    Err(changed_program_error(&digest))
                }
                Ok((program, digest)) => with_check_report(&runs_on, program, digest).await,
                Err(error) => Err(error),
            };
            TaskResult::Program(job, program.map(Box::new))
        });
    }

    /// Starts a job whose program has been read.
    pub(super) fn begin_job(&mut self, job: JobId, program: Result<Box<ReadProgram>, RpcError>) {
        let Some(slot) = self.job.as_mut().filter(|slot| slot.id == job) else {
            return;
        };
        let Some(start) = slot.start.take() else {
            return;
        };
        // A stop during the reading counts, even if the reading failed meanwhile.
        if slot.stopped {
            return self.report_not_started(job, "stopped", None);
        }
        let ReadProgram {
            program,
            digest,
            report,
        } = match program {
            Ok(program) => *program,
            Err(error) => return self.report_not_started(job, "failed", Some(error)),
        };
        (self.report)(ArmReport::Job {
            job,
            update: JobUpdate::Read {
                title: program.program.plan().title.clone(),
                steps: program.program.plan().steps.len() as u64,
                start: program.start,
                digest: digest.clone(),
            },
        });
        let spec = match self.spec(&start, &program, report) {
            Ok(spec) => spec,
            Err(error) => return self.report_not_started(job, "failed", Some(error)),
        };
        // The driver enforces the permission for every frame of the job.
        let arm = match start.laser {
            Ok(()) => self.arm.allowing_laser(),
            Err(_) => self.arm.clone(),
        };
        let arm = if start.order.unhomed {
            arm.allowing_unhomed()
        } else {
            arm
        };
        let journal = &self.job_context.journal;
        let started = RunningJob::start(&self.running, || Job::start(&arm, spec, journal()));
        let Some(handle) = started else {
            return self.report_not_started(job, "stopped", None);
        };
        let Some(slot) = &mut self.job else {
            return;
        };
        // Stored before the first report, so that a pause sent in reply to that report finds the
        // job.
        slot.handle = Some(handle.clone());
        if handle.burns() {
            let update = JobUpdate::Burns;
            (self.report)(ArmReport::Job { job, update });
        }
        let pause_pose = Arc::clone(&slot.pause_pose);
        let ends_unattended = Arc::clone(&slot.ends_unattended);
        // Pauses that were requested while the program was read.
        let pauses = std::mem::take(&mut slot.pauses);
        for (request, reason) in pauses {
            self.pause_job(request, job, reason);
        }
        let report = Arc::clone(&self.report);
        let arm = self.arm.clone();
        let grips = world::grip_count(&arm);
        self.side.spawn(async move {
            let mut events = handle.events();
            while let Some(event) = events.next().await {
                let update = match event {
                    // The end is reported below, with its details.
                    JobEvent::State(JobState::Ended) => break,
                    JobEvent::State(state) => {
                        // The pose is needed to see at a resume whether the arm was moved.
                        if matches!(state, JobState::Paused { .. }) {
                            let pose = arm.get::<Pose>().await.ok();
                            *lock(&pause_pose) = pose;
                            end_unattended_outputs(&arm, &ends_unattended).await;
                        }
                        let text = handle.pause_text();
                        JobUpdate::State(state, text.map(|text| text.to_string()))
                    }
                    JobEvent::Progress(progress) => JobUpdate::Progress(progress),
                    JobEvent::Start(starts) => JobUpdate::Starts(starts.steps),
                    // The job goes on without a journal entry: stopping a drawing half way would be
                    // worse.
                    JobEvent::NotStored(cause) => {
                        tracing::warn!("{}", report::not_stored_note(&cause).message);
                        continue;
                    }
                    // The API does not report the other events.
                    _ => continue,
                };
                report(ArmReport::Job { job, update });
            }
            let mut end = Box::new(end_of(&handle.outcome().await, &program, &digest));
            end_unattended_outputs(&arm, &ends_unattended).await;
            // A stopped job may have ended before its pick, so grips are counted only for a
            // completed job.
            let before = (end.state == "done").then_some(grips);
            end.notes = notes_of(&arm, before);
            let update = JobUpdate::Over(end);
            report(ArmReport::Job { job, update });
            TaskResult::JobOver(job)
        });
    }

    /// Builds the specification of the job. Fails if the job needs a permission that its order
    /// lacks, or cannot run as ordered.
    fn spec(
        &self,
        start: &JobStart,
        program: &PreparedProgram,
        report: Option<Value>,
    ) -> Result<JobSpec, RpcError> {
        let order = &start.order;
        let whole = program.program.clone().repeated(order.loops);
        whole
            .check_step(order.from)
            .map_err(|problem| RpcError::param("from", problem.sentence()))?;
        // Checked on the program itself and not on its format: a plan can hold any command.
        if let Err(refused) = &start.danger
            && { whole.plan().commands() }.any(|command| command.row().dangerous)
        {
            return Err((**refused).clone());
        }
        if let Err(refused) = &start.laser
            && { whole.plan().commands() }.any(|command| self.arm.laser().burns(&command))
        {
            return Err((**refused).clone());
        }
        if program.has_lost_start(order.from, start.resumes) {
            let why = message!(
                "the program depends on where the tool was when it began, and the tool has \
                moved since: give `setup.start`"
            );
            return Err(refused(why));
        }
        if let Some(misfit) = &program.misfit {
            let problem = RpcError::from(magician::Error::from(misfit.clone()));
            let failed = RpcError::new(RpcError::CHECK_FAILED, problem.message);
            let failed = failed.with_sentence(&misfit.sentence());
            let failed = failed.with("report", report.unwrap_or_default());
            let remedies = problem.data.get("remedies").cloned();
            return Err(match remedies {
                Some(remedies) => failed.with("remedies", remedies),
                None => failed,
            });
        }
        Ok(JobSpec::new(whole)
            .ending(program.ending)
            .start(if start.resumes {
                Start::Resume
            } else {
                Start::Step(order.from)
            })
            .overlap(start.overlap)
            .keep(order.keep)
            .require_homed(order.require_homed))
    }

    fn report_not_started(&mut self, job: JobId, state: &'static str, error: Option<RpcError>) {
        let waiting = self.job.take().map(|slot| slot.pauses);
        for (request, _) in waiting.into_iter().flatten() {
            self.answer_job_over(request);
        }
        let end = Box::new(over(state, error));
        let update = JobUpdate::Over(end);
        (self.report)(ArmReport::Job { job, update });
    }

    /// Answers a request about a job that is over.
    fn answer_job_over(&self, request: Option<RequestId>) {
        if let Some(request) = request {
            let outcome = Err(refused(message!("the job is over")));
            (self.report)(ArmReport::Done { request, outcome });
        }
    }

    pub(super) fn pause_job(
        &mut self,
        request: Option<RequestId>,
        job: JobId,
        reason: PauseReason,
    ) {
        let Some(slot) = self.job.as_mut().filter(|slot| slot.id == job) else {
            return self.answer_job_over(request);
        };
        let Some(handle) = &slot.handle else {
            // The program is still being read: the pause applies as soon as the job starts.
            slot.pauses.push((request, reason));
            return;
        };
        let paused = handle.pause(reason);
        self.side.spawn(async move {
            let paused = paused.await;
            let Some(request) = request else {
                return TaskResult::Nothing;
            };
            let outcome = paused.map_err(|error| refused(error.sentence()));
            let outcome = outcome.map(|()| Outcome::Value(Value::Null));
            TaskResult::Report(ArmReport::Done { request, outcome })
        });
    }

    pub(super) fn resume_job(
        &mut self,
        request: RequestId,
        job: JobId,
        approach: bool,
        laser: Result<(), Box<RpcError>>,
    ) {
        let slot = self.job.as_ref().filter(|slot| slot.id == job);
        let Some((slot, handle)) = slot.and_then(|slot| Some((slot, slot.handle.clone()?))) else {
            return self.answer_job_over(Some(request));
        };
        let (arm, pause_pose) = (self.arm.clone(), *lock(&slot.pause_pose));
        // The session that resumes the job holds the arm.
        slot.ends_unattended.store(false, Ordering::SeqCst);
        self.side.spawn(async move {
            let resumed = async {
                if let Err(refused) = laser
                    && handle.burns()
                {
                    return Err(*refused);
                }
                if !approach {
                    // Without an approach the first move would start from a wrong place and draw a
                    // line.
                    check_pause_pose(&arm, pause_pose).await?;
                }
                handle.resume().await.map_err(|error| match error {
                    ResumeError::Arm(error) | ResumeError::Refused(error) => {
                        RpcError::from(&*error)
                    }
                    other if other.wants_homing() => {
                        RpcError::arm(ErrorKind::Unexpected, other.sentence())
                    }
                    other => {
                        // The text escapes control characters of the program's file.
                        refused(other.to_string()).with_sentence(&other.sentence())
                    }
                })
            };
            let outcome = resumed.await.map(|()| Outcome::Value(Value::Null));
            TaskResult::Report(ArmReport::Done { request, outcome })
        });
    }

    /// Stops the job and lifts its pen.
    pub(super) fn stop_job(&mut self, job: JobId) {
        let Some(slot) = self.job.as_mut().filter(|slot| slot.id == job) else {
            return;
        };
        match &slot.handle {
            Some(handle) => handle.stop(),
            None => self.stop_unstarted(),
        }
    }

    /// Stops the arm at once. The job makes no further motion.
    pub(super) fn halt_job(&mut self) {
        match &self.job {
            Some(JobSlot {
                handle: Some(handle),
                ..
            }) => handle.halt(),
            Some(_) => self.stop_unstarted(),
            None => {}
        }
    }

    /// Stops a job that has not started.
    fn stop_unstarted(&mut self) {
        let Some(slot) = &mut self.job else {
            return;
        };
        slot.stopped = true;
        slot.cancel.notify_one();
        let job = slot.id;
        let count = self.waiting.len();
        self.waiting
            .retain(|waiting| !matches!(waiting, WaitingOrder::Job(_)));
        // If the program is still being read, `begin_job` reports the end after the reading.
        if self.waiting.len() < count {
            self.report_not_started(job, "stopped", None);
        }
    }

    pub(super) fn clear_job(&mut self, job: JobId) {
        self.job.take_if(|slot| slot.id == job);
        lock(&self.running).handle = None;
        // The job may have changed tools, speed and rail.
        self.refresh_known();
    }

    /// True if the motion of the arm is that of a running job.
    pub(super) fn is_job_moving(&self) -> bool {
        let handle = self.job.as_ref().and_then(|slot| slot.handle.as_ref());
        handle.is_some_and(|handle| {
            !matches!(handle.state(), JobState::Paused { .. } | JobState::Ended)
        })
    }

    /// Marks that no session holds the arm: motors and the laser go off with the end of the job.
    pub(super) fn end_unattended_with_job(&self) {
        if let Some(slot) = &self.job {
            slot.ends_unattended.store(true, Ordering::SeqCst);
        }
    }

    /// Sets the speed of a running job. `None` if no job runs or the action is another one: then
    /// the action is carried out as usual.
    pub(super) fn apply_job_speed(&self, act: &ArmAct) -> Option<Result<Outcome, RpcError>> {
        let ArmAct::Speed(percent) = act else {
            return None;
        };
        let handle = self.job.as_ref()?.handle.as_ref()?;
        if !self.is_job_moving() {
            return None;
        }
        // Jobs take whole percents.
        let set = handle.set_speed(percent.round() as u8);
        Some(match set {
            Ok(()) => Ok(Outcome::Value(Value::Null)),
            Err(error) => Err(refused(error.sentence())),
        })
    }
}

fn lock<T>(mutex: &std::sync::Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

pub(super) fn refused(why: impl Into<magician::Message>) -> RpcError {
    RpcError::arm(ErrorKind::InvalidInput, why)
}

/// Checks that the arm stands where the pause left it.
async fn check_pause_pose(arm: &Arm, expected: Option<Pose>) -> Result<(), RpcError> {
    let pose = arm.get::<Pose>().await?;
    let near = |one: f32, other: f32| (one - other).abs() <= MAX_POSE_DIFFERENCE;
    let stands = expected.is_some_and(|expected| {
        near(expected.x, pose.x)
            && near(expected.y, pose.y)
            && near(expected.z, pose.z)
            && near(expected.r, pose.r)
    });
    if stands {
        return Ok(());
    }
    let why = message!("the arm is not where the pause left it");
    let error = RpcError::arm(ErrorKind::Unexpected, why);
    let expected = expected.map(|expected| reading::pose(&expected));
    Err(error
        .with("expected", json!(expected))
        .with("pose", json!(reading::pose(&pose))))
}
