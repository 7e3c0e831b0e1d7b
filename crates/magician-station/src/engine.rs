//! An arm of the driver at the orders of a station.

mod acts;
mod guided;
mod io;
mod jobs;
mod model;
mod reads;
mod world;

use std::collections::VecDeque;
use std::future::Future;
use std::pin::Pin;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::{
    Arm, ArmOutputs, ArmSnapshot, ErrorCode, Event, Jog, JogOptions, Link, StateOptions, StateWatch,
};
use magician_job::{Access, Journal, SavedSettings, Settled};
use magician_protocol::visible;
use serde_json::{Value, json};
use tokio::sync::{mpsc, oneshot};
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::sleep;

use self::guided::Guided;
pub(crate) use self::jobs::beside;
use self::jobs::{JobContext, RunningJob, Slot};
use self::reads::Known;
use crate::api::{ArmEvent, RpcError};
use crate::control::{JobId, JogId, RequestId};
use crate::job::Reader;
use crate::order::{ArmAct, ArmOrder, ArmReport, JobStart, Outcome, jog_end};
use crate::surface::ArmSurface;

/// How often an arm is looked at whose line was lost under a job, until its queue is empty: two seconds of motion are in it, or one
/// long command.
const LOOKS_AFTER_JOB: u32 = 30;
const LOOK_AFTER_JOB: Duration = Duration::from_secs(1);

/// Number of stops of an arm at the end of a station. Commands of another host may come after the first.
const LAST_STOPS: u32 = 3;

/// A message to the engine.
enum Message {
    Order(ArmOrder),
    /// The last one: see [`ArmEngine::end`].
    End {
        is_reader: bool,
        reply: oneshot::Sender<magician::Result<()>>,
    },
}

/// An action on its way: what it comes to, with what was read behind it.
type Doing = Pin<Box<dyn Future<Output = Done> + Send>>;

/// What an action comes to.
struct Done {
    outcome: Result<Outcome, RpcError>,
    /// Where it was read anew.
    known: Option<Known>,
    /// The state behind it, where that is its outcome.
    reading: Option<crate::ArmReading>,
    /// It may have changed what is not read each time.
    stale: bool,
}

/// An arm that carries out the orders of a station: reads side by side, what moves or sets it one after the other, and
/// stops at once, before everything else.
///
/// When it is dropped a jog ends, and what it does is stopped by the rules of the driver.
#[derive(Debug)]
pub struct ArmEngine {
    messages: mpsc::UnboundedSender<Message>,
    load: Arc<AtomicUsize>,
    running: Arc<Mutex<RunningJob>>,
    task: AbortHandle,
}

impl ArmEngine {
    /// Starts one on the present tokio runtime; `report` gets what the arm reports. Programs are read by `reader` and laid
    /// on `surface`, and `journal` gives the journals of jobs.
    ///
    /// # Panics
    /// Outside of a tokio runtime.
    pub fn start(
        arm: &Arm,
        reader: Arc<dyn Reader>,
        surface: ArmSurface,
        journal: impl Fn() -> Box<dyn Journal> + Send + Sync + 'static,
        report: impl Fn(ArmReport) + Send + Sync + 'static,
    ) -> Self {
        let (messages, inbox) = mpsc::unbounded_channel();
        let load = Arc::new(AtomicUsize::new(0));
        let running = Arc::default();
        let work = Work {
            arm: arm.clone(),
            report: Arc::new(report),
            jobs_with: JobContext {
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
            told: None,
            lapses: 0,
            waiting: VecDeque::new(),
            doing: None,
            stops: 0,
            ended: false,
            side: JoinSet::new(),
            jog: None,
            beginning: None,
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

    /// Orders that are not done, and what is read beside: when it looked last.
    pub(crate) fn load(&self) -> usize {
        self.load.load(Ordering::Relaxed)
    }

    /// Stops the job under way for the end of the program, and lets no other begin: the pen goes up, settings are restored. The
    /// future is over with the job.
    pub(crate) fn end_job(&self) -> impl Future<Output = ()> + Send + use<> {
        let handle = RunningJob::close(&self.running);
        async move {
            if let Some(handle) = handle {
                handle.stop();
                let _ = handle.outcome().await;
            }
        }
    }

    /// Gives it an order.
    pub fn order(&self, order: ArmOrder) {
        // Its task ends with it.
        let _ = self.messages.send(Message::Order(order));
    }

    /// Ends what is under way, takes no order that moves or sets any more, and stops the arm until its
    /// queue is empty, laser and motors are off and it stands. `is_reader`: the station never moved it,
    /// so what waits in the queue is another program's.
    pub(crate) fn end(
        &self,
        is_reader: bool,
    ) -> impl Future<Output = magician::Result<()>> + Send + use<> {
        let (reply, ended) = oneshot::channel();
        let _ = self.messages.send(Message::End { is_reader, reply });
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

/// What came of something that was done beside.
enum TaskResult {
    Report(ArmReport),
    /// The arm was read, on request or for what is not read each time.
    Read(
        RequestId,
        Result<Outcome, RpcError>,
        Box<Known>,
        Option<Box<crate::ArmReading>>,
    ),
    /// Where the arm is on its rail, if it has one.
    Known(Option<f32>),
    Jog(RequestId, JogId, Result<Jog, magician::Error>),
    Stopped(Option<RequestId>, Result<Value, RpcError>),
    /// The program of a job was read.
    Program(JobId, Result<Box<jobs::ReadProgram>, RpcError>),
    /// A job is over, and was reported.
    JobOver(JobId),
    /// Nothing follows.
    Nothing,
}

/// Something that waits for its turn.
enum Waiting {
    Act {
        request: RequestId,
        act: Box<ArmAct>,
        laser: bool,
    },
    Job(Box<JobStart>),
}

struct Work {
    arm: Arm,
    report: Arc<dyn Fn(ArmReport) + Send + Sync>,
    inbox: mpsc::UnboundedReceiver<Message>,
    load: Arc<AtomicUsize>,
    jobs_with: JobContext,
    job: Option<Slot>,
    /// What the end of the program needs of the job.
    running: Arc<Mutex<RunningJob>>,
    watch: Option<StateWatch>,
    known: Known,
    /// What was told of tools and speed last.
    told: Option<ArmOutputs>,
    /// Lapses of the driver's picture when it was read last.
    lapses: u64,
    waiting: VecDeque<Waiting>,
    doing: Option<(RequestId, Doing)>,
    /// Stops under way: nothing begins before they are over.
    stops: usize,
    /// True from the last stop on: only reads and stops are obeyed.
    ended: bool,
    side: JoinSet<TaskResult>,
    jog: Option<(JogId, Jog)>,
    /// A jog that begins.
    beginning: Option<(JogId, AbortHandle)>,
    /// Where the unlock key is released, as long as that is told.
    guided: Guided,
}

impl Work {
    async fn run(mut self) {
        let mut events = self.arm.events();
        self.learn();
        loop {
            self.begin_next();
            self.tell_outputs();
            let waiting = self.inbox.len() + self.waiting.len() + self.side.len();
            let load = waiting + usize::from(self.doing.is_some());
            self.load.store(load, Ordering::Relaxed);
            tokio::select! {
                biased;
                message = self.inbox.recv() => match message {
                    Some(Message::Order(order)) => self.obey(order),
                    Some(Message::End { is_reader, reply }) => self.end(is_reader, reply),
                    None => return,
                },
                // Before what was read, so that a line that was found is known to be up.
                event = events.next() => match event {
                    Some(event) => self.tell(event),
                    None => return,
                },
                Some(side) = self.side.join_next() => {
                    if let Ok(side) = side {
                        self.take(side);
                    }
                }
                (request, done) = done(&mut self.doing) => {
                    self.doing = None;
                    self.finish(request, done);
                }
                news = self.guided.next() => self.take_guided(news),
                status = changed(&mut self.watch) => match status {
                    Some(status) => self.read(&status),
                    None => self.watch = None,
                },
            }
        }
    }

    fn obey(&mut self, order: ArmOrder) {
        let begins_nothing = matches!(
            order,
            ArmOrder::Read { .. }
                | ArmOrder::EndJog(_)
                | ArmOrder::StopJob(_)
                | ArmOrder::Stop { .. }
                | ArmOrder::StopMotors
        );
        if self.ended && !begins_nothing {
            return;
        }
        match order {
            ArmOrder::Read { request, read } => {
                let (arm, known) = (self.arm.clone(), self.known.clone());
                let surface = self.jobs_with.surface.clone();
                self.side
                    .spawn(reads::answer(arm, known, surface, request, read));
            }
            ArmOrder::Act {
                request,
                act,
                laser,
            } => self.waiting.push_back(Waiting::Act {
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
                self.beginning = Some((jog, begins));
            }
            ArmOrder::KeepJog(jog) => self.keep(jog),
            ArmOrder::EndJog(jog) => {
                self.jog.take_if(|(id, _)| *id == jog);
                if let Some((_, begins)) = self.beginning.take_if(|(id, _)| *id == jog) {
                    // One that is given up on ends, whether it has begun or not.
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
                self.job = Some(Slot::new(start.job));
                self.waiting.push_back(Waiting::Job(start));
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
            // What a job does is paused or stopped by orders of its own.
            ArmOrder::Stop { request: None } if self.job_drives() => self.owe_motors(),
            ArmOrder::Stop { request } => {
                if request.is_some() {
                    self.halt_job();
                }
                self.give_up();
                let arm = self.arm.clone();
                self.side.spawn(async move {
                    let stood = async {
                        arm.stop().await?;
                        arm.get().await
                    };
                    let stood = stood.await.map(|pose| acts::stood(&pose));
                    TaskResult::Stopped(request, stood.map_err(RpcError::from))
                });
            }
            // What a job has running is its own until it pauses or ends.
            ArmOrder::StopMotors => {
                self.owe_motors();
                if !self.job_drives() {
                    self.stop_motors();
                }
            }
            ArmOrder::Fence {
                request,
                fence,
                stops,
            } => {
                // It holds from here on.
                let holds = self.arm.set_fence(*fence);
                if stops {
                    self.give_up();
                } else {
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
                // Rates and pins were checked when they were asked for.
                self.watch = options.and_then(|options| self.arm.state_with(options).ok());
                self.known.rests();
                if self.watch.is_some() {
                    self.learn();
                }
            }
        }
    }

    /// Ends what is under way, but a job, for a stop that follows.
    fn give_up(&mut self) {
        self.doing = None;
        let is_job = |waiting: &Waiting| matches!(waiting, Waiting::Job(_));
        self.waiting.retain(is_job);
        self.jog = None;
        if let Some((_, begins)) = self.beginning.take() {
            begins.abort();
        }
        self.stops += 1;
    }

    /// The last stop: nothing begins after it.
    fn end(&mut self, is_reader: bool, reply: oneshot::Sender<magician::Result<()>>) {
        self.ended = true;
        self.give_up();
        self.waiting.clear();
        let arm = self.arm.clone();
        self.side.spawn(async move {
            // The station may be gone already.
            let _ = reply.send(come_to_an_end(&arm, is_reader).await);
            TaskResult::Stopped(None, Ok(Value::Null))
        });
    }

    /// Switches off what runs on without a holder. A queue that is still to set a motor going is dropped with it.
    fn stop_motors(&mut self) {
        if self.arm.motors().running().is_empty() {
            return;
        }
        self.stops += 1;
        let arm = self.arm.clone();
        self.side.spawn(async move {
            let stopped = if arm.moving() {
                arm.stop().await
            } else {
                arm.motors().stop().await
            };
            if let Err(error) = stopped {
                tracing::warn!(%error, "a motor may run on after the lease");
            }
            TaskResult::Stopped(None, Ok(Value::Null))
        });
    }

    /// Begins the next action if nothing is in its way.
    fn begin_next(&mut self) {
        if self.doing.is_some() || self.stops > 0 {
            return;
        }
        match self.waiting.pop_front() {
            Some(Waiting::Act {
                request,
                act,
                laser,
            }) => {
                if let Some(outcome) = self.paced(&act) {
                    return (self.report)(ArmReport::Done { request, outcome });
                }
                let arm = if laser {
                    self.arm.allowing_laser()
                } else {
                    self.arm.clone()
                };
                self.doing = Some((request, self.doing_of(arm, *act)));
            }
            Some(Waiting::Job(start)) => self.read_job(*start),
            None => {}
        }
    }

    /// An action as it is carried out.
    fn doing_of(&self, arm: Arm, act: ArmAct) -> Doing {
        let surface = self.jobs_with.surface.clone();
        let draws = self.jobs_with.reader.usual_tool();
        let known = self.known.clone();
        Box::pin(acts::to_the_end(arm, act, known, surface, draws))
    }

    /// Tells of tools and speed where they have changed, and reads them where they are not known any more.
    fn tell_outputs(&mut self) {
        let ArmSnapshot {
            outputs, lapses, ..
        } = self.arm.snapshot();
        if self.told.replace(outputs) != Some(outputs) {
            let tool = reads::tool(&outputs);
            let speed = outputs.speed;
            (self.report)(ArmReport::Outputs { tool, speed });
        }
        if lapses != self.lapses {
            self.learn();
        }
    }

    fn finish(&mut self, request: RequestId, done: Done) {
        if let Some(known) = done.known {
            self.known = known;
        }
        if done.stale {
            self.learn();
        }
        if let Some(reading) = done.reading {
            (self.report)(ArmReport::Reading(Box::new(reading)));
        }
        self.tell_outputs();
        let outcome = done.outcome;
        (self.report)(ArmReport::Done { request, outcome });
    }

    fn keep(&mut self, jog: JogId) {
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

    fn take(&mut self, side: TaskResult) {
        // Before the answer of a stop that has changed them.
        self.tell_outputs();
        match side {
            TaskResult::Report(report) => (self.report)(report),
            TaskResult::Program(job, program) => self.begin_job(job, program),
            TaskResult::JobOver(job) => self.job_is_over(job),
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
                self.beginning.take_if(|(beginning, _)| *beginning == id);
                let outcome = match begun {
                    Ok(jog) => {
                        // The time to keep it up counts from the answer, which goes out now: on a busy machine the arm's
                        // own answer may be long ago. One that is over already is told by its end.
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

    /// Reads what is not read each time, beside.
    fn learn(&mut self) {
        self.lapses = self.arm.snapshot().lapses;
        let arm = self.arm.clone();
        let before = self.known.rail;
        self.side.spawn(async move {
            let known = Known::read(&arm).await;
            TaskResult::Known(known.map_or(before, |known| known.rail))
        });
    }

    fn read(&mut self, status: &magician::Status) {
        if status.link == Link::Up
            && let Some(reading) = self.known.reading(status, &self.arm)
        {
            (self.report)(ArmReport::Reading(Box::new(reading)));
        }
    }

    fn tell(&mut self, event: Event) {
        let tell = |event, fields| (self.report)(ArmReport::Event { event, fields });
        match event {
            Event::AlarmRaised { code } => tell(ArmEvent::AlarmRaised, vec![("code", json!(code))]),
            Event::AlarmCleared { code } => {
                tell(ArmEvent::AlarmCleared, vec![("code", json!(code))])
            }
            Event::CommandFinished { last, .. } => {
                tell(ArmEvent::CommandFinished, vec![("index", json!(last.0))]);
            }
            Event::Unaccounted { to, .. } => {
                tell(ArmEvent::Unaccounted, vec![("index", json!(to.0))])
            }
            Event::LinkLost { .. } => (self.report)(ArmReport::Link(false)),
            Event::LinkFound { .. } => {
                (self.report)(ArmReport::Link(true));
                self.side.spawn(restore_after_job(self.arm.clone()));
                self.learn();
            }
            Event::Reset { .. } => {
                tell(ArmEvent::Reset, Vec::new());
                self.learn();
            }
            Event::Missed { events } => tell(ArmEvent::Missed, vec![("count", json!(events))]),
            other => tracing::debug!(event = %visible(&format!("{other:?}")), "unknown event"),
        }
    }
}

/// Restores what a job has changed that the line was lost under, once the arm has done what it had of it.
async fn restore_after_job(arm: Arm) -> TaskResult {
    for _ in 0..LOOKS_AFTER_JOB {
        match SavedSettings::settle(&arm, Access::Sets).await {
            Settled::Later(_) => sleep(LOOK_AFTER_JOB).await,
            _ => break,
        }
    }
    TaskResult::Nothing
}

/// Stops an arm if anything of it moves, burns, runs or waits, and makes sure that nothing does.
async fn come_to_an_end(arm: &Arm, is_reader: bool) -> magician::Result<()> {
    let (_, places) = arm.stats().await?;
    for stops in 0.. {
        let is_lit = arm.outputs().laser == Some(true);
        let is_busy = is_lit || arm.moving() || !arm.motors().running().is_empty();
        // The driver knows of no commands that it did not send: the arm is asked.
        if !is_busy && (is_reader || arm.queue().left_space().await? >= places) {
            break;
        }
        if stops == LAST_STOPS {
            let message = "commands come to the arm's queue again after each stop";
            return Err(magician::Error::new(ErrorCode::StopUnconfirmed, message));
        }
        arm.stop().await?;
    }
    arm.laser().switch_off_after().await
}

/// What the action under way comes to; never without one.
async fn done(doing: &mut Option<(RequestId, Doing)>) -> (RequestId, Done) {
    match doing {
        Some((request, doing)) => (*request, doing.as_mut().await),
        None => std::future::pending().await,
    }
}

/// The next reading; `None` when the connection has ended.
async fn changed(watch: &mut Option<StateWatch>) -> Option<magician::Status> {
    match watch {
        Some(watch) => watch.changed().await.ok(),
        None => std::future::pending().await,
    }
}
