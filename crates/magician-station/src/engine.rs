//! Engine: carries out the orders of a station on one arm of the driver.
//!
//! The engine is one task per arm. It receives [`ArmOrder`]s, runs them over [`Arm`] and reports
//! with [`ArmReport`]s. Three kinds of orders differ in how they run:
//!
//! * Reads and checks run side by side as spawned tasks.
//! * Actions (moves, settings, homing) run one after the other, because they change the arm.
//! * Stops run at once. A stop drops the action in progress and everything that waits, and nothing
//!   new starts before it is confirmed.
//!
//! Jobs run through `magician-job` and own the arm while they run. The engine decides nothing about
//! rights: an order that arrives is permitted.

mod acts;
mod ending;
mod events;
mod guided;
mod io;
mod jobs;
mod model;
mod outcome;
mod program;
mod reads;
mod world;

use std::collections::VecDeque;
use std::future::Future;
use std::pin::Pin;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use magician::{Arm, ArmOutputs, ArmSnapshot, Jog, JogOptions, StateOptions, StateWatch};
use magician_job::Journal;
use serde_json::{Value, json};
use tokio::sync::{mpsc, oneshot};
use tokio::task::{AbortHandle, JoinSet};

use self::guided::Guided;
use self::jobs::{JobContext, JobSlot, RunningJob};
use self::program::ReadProgram;
pub(crate) use self::program::run_blocking;
use self::reads::Known;
use crate::api::RpcError;
use crate::control::{JobId, JogId, RequestId};
use crate::job::Reader;
use crate::order::{ArmAct, ArmOrder, ArmReport, JobStart, Outcome, jog_end};
use crate::surface::ArmSurface;

/// Message to the engine's task.
enum Message {
    Order(ArmOrder),
    /// The last order: see [`ArmEngine::end`].
    End {
        is_read_only: bool,
        reply: oneshot::Sender<magician::Result<()>>,
    },
}

/// Action in progress. Its result includes what was read after it.
type ActionFuture = Pin<Box<dyn Future<Output = ActionResult> + Send>>;

/// Result of an action.
struct ActionResult {
    outcome: Result<Outcome, RpcError>,
    /// Values that were read again, if any.
    known: Option<Known>,
    /// State after the action, if that is its outcome.
    reading: Option<crate::ArmReading>,
    /// True if the action may have changed values that the driver's status lacks, such as the rail.
    stale: bool,
}

/// Handle to an arm that carries out the orders of a station. Reads run side by side, orders that
/// move or set run one after the other, stops run at once.
///
/// Dropping the handle ends a jog and stops motion by the rules of the driver.
#[derive(Debug)]
pub struct ArmEngine {
    messages: mpsc::UnboundedSender<Message>,
    load: Arc<AtomicUsize>,
    running: Arc<Mutex<RunningJob>>,
    task: AbortHandle,
}

impl ArmEngine {
    /// Starts an engine on the current tokio runtime. `report` is called with each report of the
    /// arm. `reader` reads programs and places them on `surface`; `journal` creates journals of
    /// jobs.
    ///
    /// # Panics
    /// If called outside of a tokio runtime.
    pub fn start(
        arm: &Arm,
        reader: Arc<dyn Reader>,
        mut surface: ArmSurface,
        journal: impl Fn() -> Box<dyn Journal> + Send + Sync + 'static,
        report: impl Fn(ArmReport) + Send + Sync + 'static,
    ) -> Self {
        let report: Arc<dyn Fn(ArmReport) + Send + Sync> = Arc::new(report);
        let tell = Arc::clone(&report);
        surface.on_change(move |surface| tell(ArmReport::Surface(surface)));
        let (messages, inbox) = mpsc::unbounded_channel();
        let load = Arc::new(AtomicUsize::new(0));
        let running = Arc::default();
        let work = EngineTask {
            arm: arm.clone(),
            report,
            job_context: JobContext {
                reader,
                surface,
                journal: Box::new(journal),
            },
            job: None,
            running: Arc::clone(&running),
            inbox,
            load: Arc::clone(&load),
            watch: None,
            known: Known::default(),
            reported_outputs: None,
            lapses: 0,
            waiting: VecDeque::new(),
            action: None,
            stops: 0,
            ended: false,
            // A set, so that dropping the engine aborts its background tasks.
            side: JoinSet::new(),
            jog: None,
            starting_jog: None,
            guided: Guided::default(),
        };
        let task = tokio::spawn(work.run()).abort_handle();
        Self {
            messages,
            load,
            running,
            task,
        }
    }

    /// Returns the number of unfinished orders and background reads, as of the task's last round.
    pub(crate) fn load(&self) -> usize {
        self.load.load(Ordering::Relaxed)
    }

    /// Stops the job in progress for the end of the program and lets no other job start. The pen
    /// goes up and settings are restored. The future resolves when the job is over.
    pub(crate) fn end_job(&self) -> impl Future<Output = ()> + Send + use<> {
        let handle = RunningJob::close(&self.running);
        async move {
            if let Some(handle) = handle {
                handle.stop();
                // The outcome is reported by the job's own task.
                let _ = handle.outcome().await;
            }
        }
    }

    /// Sends an order to the engine.
    pub fn order(&self, order: ArmOrder) {
        // Fails only if the task has ended, which it does with this handle.
        let _ = self.messages.send(Message::Order(order));
    }

    /// Ends everything in progress, refuses all further orders that move or set, and stops the arm
    /// until its queue is empty, laser and motors are off, and it stands. With `is_read_only` the
    /// station never moved the arm, so commands in its queue belong to another program and stay.
    pub(crate) fn end(
        &self,
        is_read_only: bool,
    ) -> impl Future<Output = magician::Result<()>> + Send + use<> {
        let (reply, ended) = oneshot::channel();
        // If the task is gone, `reply` is dropped and the future below resolves to an error.
        let _ = self.messages.send(Message::End {
            is_read_only,
            reply,
        });
        async move {
            let gone = |_| Err(magician::Error::closed());
            ended.await.unwrap_or_else(gone)
        }
    }
}

impl Drop for ArmEngine {
    fn drop(&mut self) {
        self.task.abort();
    }
}

/// Result of a background task.
enum TaskResult {
    Report(ArmReport),
    /// The arm was read, on request or for values that only some readings contain.
    Read(
        RequestId,
        Result<Outcome, RpcError>,
        Box<Known>,
        Option<Box<crate::ArmReading>>,
    ),
    /// Position on the rail. `None` without a rail.
    Known(Option<f32>),
    Jog(RequestId, JogId, Result<Jog, magician::Error>),
    Stopped(Option<RequestId>, Result<Value, RpcError>),
    /// The program of a job was read.
    Program(JobId, Result<Box<ReadProgram>, RpcError>),
    /// A job is over and its end was reported.
    JobOver(JobId),
    /// No effect.
    Nothing,
}

/// Order that waits for its turn.
enum WaitingOrder {
    Act {
        request: RequestId,
        act: Box<ArmAct>,
        laser: bool,
    },
    Job(Box<JobStart>),
    /// Ends what the actions before it may have left on: see [`ArmOrder::EndUnattended`].
    EndUnattended,
}

struct EngineTask {
    arm: Arm,
    report: Arc<dyn Fn(ArmReport) + Send + Sync>,
    inbox: mpsc::UnboundedReceiver<Message>,
    load: Arc<AtomicUsize>,
    job_context: JobContext,
    job: Option<JobSlot>,
    /// The part of the job that the end of the program needs.
    running: Arc<Mutex<RunningJob>>,
    watch: Option<StateWatch>,
    known: Known,
    /// Tools and speed as reported last.
    reported_outputs: Option<ArmOutputs>,
    /// Value of the driver's `lapses` counter at the last read.
    lapses: u64,
    waiting: VecDeque<WaitingOrder>,
    action: Option<(RequestId, ActionFuture)>,
    /// Stops in progress. No action starts while this is above 0.
    stops: usize,
    /// True after [`ArmEngine::end`]: only reads and stops are obeyed.
    ended: bool,
    side: JoinSet<TaskResult>,
    jog: Option<(JogId, Jog)>,
    /// Jog that is starting.
    starting_jog: Option<(JogId, AbortHandle)>,
    /// Reports poses when the unlock key is released, while switched on.
    guided: Guided,
}

impl EngineTask {
    async fn run(mut self) {
        let mut events = self.arm.events();
        self.refresh_known();
        loop {
            // At the top of each round, because any event may have removed what an action waited
            // for.
            self.begin_next();
            self.report_outputs();
            let waiting = self.inbox.len() + self.waiting.len() + self.side.len();
            let load = waiting + usize::from(self.action.is_some());
            self.load.store(load, Ordering::Relaxed);
            tokio::select! {
                // In this order on purpose: orders come first, so a stop is never behind a flood of
                // readings.
                biased;
                message = self.inbox.recv() => match message {
                    Some(Message::Order(order)) => self.handle_order(order),
                    Some(Message::End { is_read_only, reply }) => self.end(is_read_only, reply),
                    // Never while the handle exists: dropping it aborts the task.
                    None => return,
                },
                // Events before readings: a line that was found must be known to be up when it is
                // read.
                event = events.next() => match event {
                    Some(event) => self.report_event(event),
                    None => return,
                },
                Some(side) = self.side.join_next() => {
                    if let Ok(side) = side {
                        self.handle_task_result(side);
                    }
                }
                (request, done) = next_result(&mut self.action) => {
                    self.action = None;
                    self.finish(request, done);
                }
                news = self.guided.next() => self.handle_guide_event(news),
                status = next_status(&mut self.watch) => match status {
                    Some(status) => self.handle_status(&status),
                    None => self.watch = None,
                },
            }
        }
    }

    fn handle_order(&mut self, order: ArmOrder) {
        // Reads, and everything that ends motion, stay possible to the last.
        let begins_nothing = matches!(
            order,
            ArmOrder::Read { .. }
                | ArmOrder::EndJog(_)
                | ArmOrder::StopJob(_)
                | ArmOrder::Stop { .. }
                | ArmOrder::EndUnattended
        );
        if self.ended && !begins_nothing {
            return;
        }
        match order {
            ArmOrder::Read { request, read } => {
                let (arm, known) = (self.arm.clone(), self.known.clone());
                let surface = self.job_context.surface.clone();
                self.side
                    .spawn(reads::answer(arm, known, surface, request, read));
            }
            ArmOrder::Act {
                request,
                act,
                laser,
            } => self.waiting.push_back(WaitingOrder::Act {
                request,
                act,
                laser,
            }),
            ArmOrder::StartJog {
                request,
                jog,
                direction,
                keep,
                percent,
            } => {
                let mut options = JogOptions::default().keep(keep);
                if let Some(percent) = percent {
                    options = options.ratio(percent);
                }
                let arm = self.arm.clone();
                let begins = async move {
                    TaskResult::Jog(request, jog, arm.jog_with(direction, options).await)
                };
                let begins = self.side.spawn(begins);
                self.starting_jog = Some((jog, begins));
            }
            ArmOrder::KeepJog(jog) => self.keep_jog(jog),
            ArmOrder::EndJog(jog) => {
                self.jog.take_if(|(id, _)| *id == jog);
                if let Some((_, begins)) = self.starting_jog.take_if(|(id, _)| *id == jog) {
                    // Dropping the start of a jog ends the jog, whether the arm has started it or
                    // not.
                    begins.abort();
                }
            }
            ArmOrder::Guide {
                request,
                on,
                unhomed,
            } => self.guide(request, on, unhomed),
            ArmOrder::World { request, act } => self.change_world(request, act),
            ArmOrder::CheckJob {
                request,
                source,
                preview,
            } => self.check_job(request, *source, preview),
            ArmOrder::StartJob(start) => {
                // The slot exists before the job's turn, so that a pause or stop already finds it.
                self.job = Some(JobSlot::new(start.job));
                self.waiting.push_back(WaitingOrder::Job(start));
            }
            ArmOrder::PauseJob {
                request,
                job,
                reason,
            } => self.pause_job(request, job, reason),
            ArmOrder::ResumeJob {
                request,
                job,
                approach,
                laser,
            } => self.resume_job(request, job, approach, laser),
            ArmOrder::StopJob(job) => self.stop_job(job),
            // A job in progress is paused or stopped by its own orders, not by the end of a lease.
            ArmOrder::Stop { request: None } if self.is_job_moving() => {
                self.end_unattended_with_job()
            }
            // An explicit stop ends the job as well; a stop because a lease ended leaves a paused
            // job.
            ArmOrder::Stop { request } => {
                if request.is_some() {
                    self.halt_job();
                }
                self.drop_actions();
                let arm = self.arm.clone();
                self.side.spawn(async move {
                    // The pose comes after the stop: it is where the arm came to rest.
                    let stood = async {
                        arm.stop().await?;
                        arm.get().await
                    };
                    let stood = stood.await.map(|pose| acts::standing_answer(&pose));
                    TaskResult::Stopped(request, stood.map_err(RpcError::from))
                });
            }
            ArmOrder::EndUnattended => {
                // Actions that came before the end of the lease may still switch something on.
                if self.action.is_some() || !self.waiting.is_empty() {
                    self.waiting.push_back(WaitingOrder::EndUnattended);
                }
                self.end_unattended();
            }
            ArmOrder::Fence {
                request,
                fence,
                stops,
            } => {
                // In force from here on, for every frame that follows.
                let holds = self.arm.set_fence(*fence);
                if stops {
                    self.drop_actions();
                } else {
                    // A fence that does not stop the arm still holds new actions back until it is
                    // in force.
                    self.stops += 1;
                }
                self.side.spawn(async move {
                    let fence = crate::fence::shown((*fence).as_ref());
                    let outcome = holds.await.map(|()| json!({"fence": fence}));
                    TaskResult::Stopped(Some(request), outcome.map_err(RpcError::from))
                });
            }
            ArmOrder::Watch { rate, pins } => {
                let options = rate.map(|rate| StateOptions::at(f64::from(rate)).pins(pins));
                // Valid: rates and pins were checked when the client asked for them.
                self.watch = options.and_then(|options| self.arm.state_with(options).ok());
                // The last reading may be old: comparing the next pose with it would show motion
                // that is over.
                self.known.reset_poses();
                if self.watch.is_some() {
                    self.refresh_known();
                }
            }
        }
    }

    /// Drops all actions in progress and waiting, except jobs, for a stop that follows.
    fn drop_actions(&mut self) {
        self.action = None;
        let is_job = |waiting: &WaitingOrder| matches!(waiting, WaitingOrder::Job(_));
        self.waiting.retain(is_job);
        self.jog = None;
        if let Some((_, begins)) = self.starting_jog.take() {
            begins.abort();
        }
        self.stops += 1;
    }

    /// Starts the next action, unless one is in progress or a stop is not confirmed.
    fn begin_next(&mut self) {
        if self.action.is_some() || self.stops > 0 {
            return;
        }
        match self.waiting.pop_front() {
            Some(WaitingOrder::Act {
                request,
                act,
                laser,
            }) => {
                if let Some(outcome) = self.apply_job_speed(&act) {
                    // A running job sets the speed through its own handle.
                    return (self.report)(ArmReport::Done { request, outcome });
                }
                let arm = if laser {
                    self.arm.allowing_laser()
                } else {
                    self.arm.clone()
                };
                self.action = Some((request, self.action_future(arm, *act)));
            }
            Some(WaitingOrder::Job(start)) => self.read_job(*start),
            Some(WaitingOrder::EndUnattended) => self.end_unattended(),
            None => {}
        }
    }

    /// Returns the future that carries out an action.
    fn action_future(&self, arm: Arm, act: ArmAct) -> ActionFuture {
        let surface = self.job_context.surface.clone();
        let draws = self.job_context.reader.default_tool();
        let known = self.known.clone();
        Box::pin(acts::run_action(arm, act, known, surface, draws))
    }

    /// Reports tools and speed if they changed, and reads them again if they are unknown.
    fn report_outputs(&mut self) {
        let ArmSnapshot {
            outputs, lapses, ..
        } = self.arm.snapshot();
        if self.reported_outputs.replace(outputs) != Some(outputs) {
            let tool = reads::tool(&outputs);
            let speed = outputs.speed;
            (self.report)(ArmReport::Outputs { tool, speed });
        }
        if lapses != self.lapses {
            self.refresh_known();
        }
    }

    fn finish(&mut self, request: RequestId, done: ActionResult) {
        if let Some(known) = done.known {
            self.known = known;
        }
        if done.stale {
            self.refresh_known();
        }
        if let Some(reading) = done.reading {
            (self.report)(ArmReport::Reading(Box::new(reading)));
        }
        self.report_outputs();
        let outcome = done.outcome;
        (self.report)(ArmReport::Done { request, outcome });
    }

    fn keep_jog(&mut self, jog: JogId) {
        let Some((id, under_way)) = &self.jog else {
            return;
        };
        if *id == jog
            && let Err(error) = under_way.keep()
        {
            self.jog = None;
            let why = jog_end(error.code().name());
            (self.report)(ArmReport::JogEnded { jog, why });
        }
    }

    fn handle_task_result(&mut self, side: TaskResult) {
        // Reported before the answer to a stop that changed them.
        self.report_outputs();
        match side {
            TaskResult::Report(report) => (self.report)(report),
            TaskResult::Program(job, program) => self.begin_job(job, program),
            TaskResult::JobOver(job) => self.clear_job(job),
            TaskResult::Nothing => {}
            TaskResult::Known(rail) => self.known.rail = rail,
            TaskResult::Read(request, outcome, known, reading) => {
                self.known = *known;
                if let Some(reading) = reading {
                    (self.report)(ArmReport::Reading(reading));
                }
                (self.report)(ArmReport::Done { request, outcome });
            }
            TaskResult::Jog(request, id, begun) => {
                self.starting_jog
                    .take_if(|(starting_jog, _)| *starting_jog == id);
                let outcome = match begun {
                    Ok(jog) => {
                        // The keep-alive period of the jog starts with the answer that goes out
                        // now: on a busy machine the arm's own answer may be old. If the jog is
                        // over already, its end is reported separately.
                        let _ = jog.keep();
                        self.jog = Some((id, jog));
                        Ok(Outcome::Value(Value::Null))
                    }
                    Err(error) => Err(RpcError::from(error)),
                };
                (self.report)(ArmReport::Done { request, outcome });
            }
            TaskResult::Stopped(request, outcome) => {
                self.stops -= 1;
                if let Some(request) = request {
                    let outcome = outcome.map(Outcome::Value);
                    (self.report)(ArmReport::Done { request, outcome });
                }
            }
        }
    }
}

/// Resolves when the action in progress is done. Pending for ever without one.
async fn next_result(action: &mut Option<(RequestId, ActionFuture)>) -> (RequestId, ActionResult) {
    match action {
        Some((request, action)) => (*request, action.as_mut().await),
        None => std::future::pending().await,
    }
}

/// Returns the next status. `None` if the connection has ended; pending for ever without a watch.
async fn next_status(watch: &mut Option<StateWatch>) -> Option<magician::Status> {
    match watch {
        Some(watch) => watch.changed().await.ok(),
        None => std::future::pending().await,
    }
}
