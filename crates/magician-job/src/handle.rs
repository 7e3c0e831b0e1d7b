//! Handle of a running job: state, events, and requests to the engine.
//!
//! Requests go to the job through a channel; state, progress and outcome come back through watches,
//! so any number of clones can wait. Events are a bounded broadcast.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{broadcast, mpsc, oneshot, watch};

use crate::error::{JobOutcome, PauseError, ResumeError, SpeedError};
use crate::event::{JobEvent, JobEvents, JobProgress, JobState, PauseReason};

/// Events buffered for a slow reader; older ones are dropped. A choice: 25 seconds of progress
/// events at ten a second.
const EVENT_CAPACITY: usize = 256;

/// Full speed, as the program sets it, percent.
pub(crate) const FULL_SPEED: u8 = 100;
/// Lowest speed that a job accepts, percent.
const MIN_SPEED: u8 = 10;

/// A request to a job.
#[derive(Debug)]
pub(crate) enum Request {
    Pause(PauseReason, oneshot::Sender<Result<(), PauseError>>),
    Resume(oneshot::Sender<Result<(), ResumeError>>),
    Stop,
}

/// Properties of a job that never change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaserUse {
    /// True if the job may switch a laser on.
    pub(crate) burns: bool,
    /// True if something it burns has a power that is right for one speed only.
    pub(crate) needs_speed: bool,
}

/// State that the engine and all handles share.
#[derive(Debug)]
pub(crate) struct Shared {
    state: watch::Sender<JobState>,
    progress: watch::Sender<JobProgress>,
    outcome: watch::Sender<Option<JobOutcome>>,
    /// Speed requested for commands not sent yet, percent.
    pub(crate) pace: watch::Sender<u8>,
    laser_use: LaserUse,
    events: broadcast::Sender<JobEvent>,
    /// Receiver with all events from the start, until the first caller of `events` takes it.
    first: Mutex<Option<broadcast::Receiver<JobEvent>>>,
    finished: Arc<AtomicU64>,
    /// Text for the person that the job waits for.
    pause_text: Mutex<Option<Arc<str>>>,
    /// True if nothing may move after the stop.
    pub(crate) halted: AtomicBool,
    name: String,
    origin: String,
}

impl Shared {
    pub(crate) fn emit(&self, event: JobEvent) {
        // Fails if there is no listener, which is fine.
        let _ = self.events.send(event);
    }

    pub(crate) fn enter(&self, state: JobState) {
        self.state.send_replace(state);
        self.emit(JobEvent::State(state));
    }

    /// Enters a pause, with the text for the person it waits for.
    pub(crate) fn enter_pause(&self, state: JobState, text: Option<Arc<str>>) {
        *self.pause_text() = text;
        self.enter(state);
    }

    fn pause_text(&self) -> MutexGuard<'_, Option<Arc<str>>> {
        let text = self.pause_text.lock();
        text.unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn state(&self) -> JobState {
        *self.state.borrow()
    }

    pub(crate) fn progress(&self) -> JobProgress {
        *self.progress.borrow()
    }

    /// Publishes the progress to all observers.
    pub(crate) fn publish_progress(&self, progress: JobProgress) {
        self.finished.store(progress.step, Ordering::Relaxed);
        self.progress.send_replace(progress);
    }

    pub(crate) fn end(&self, outcome: JobOutcome) {
        self.outcome.send_replace(Some(outcome));
        self.enter(JobState::Ended);
    }
}

/// State of a handle, shared by all clones.
#[derive(Debug)]
struct Owner {
    shared: Arc<Shared>,
    requests: mpsc::UnboundedSender<Request>,
    detached: AtomicBool,
}

impl Drop for Owner {
    fn drop(&mut self) {
        if !self.detached.load(Ordering::SeqCst) {
            // Fails if the job is over: its task is gone.
            let _ = self.requests.send(Request::Stop);
        }
    }
}

/// Handle of a job. Clones are cheap and may be used from any task and thread; a server keeps one
/// for as long as the job shall run.
///
/// Dropping the *last* clone stops the job as [`stop`](Self::stop) does. This is the rule of the
/// driver, which stops an arm when its last handle goes. After [`detach`](Self::detach) the job
/// continues without a handle. If the runtime ends the job ends with it: the driver stops the arm
/// and switches the laser off, and the journal says what was handed over, as after a crash.
#[derive(Clone, Debug)]
pub struct JobHandle(Arc<Owner>);

impl JobHandle {
    pub(crate) fn new(
        name: String,
        origin: String,
        laser_use: LaserUse,
    ) -> (Self, Arc<Shared>, mpsc::UnboundedReceiver<Request>) {
        let (requests, inbox) = mpsc::unbounded_channel();
        let (events, first) = broadcast::channel(EVENT_CAPACITY);
        let shared = Arc::new(Shared {
            state: watch::Sender::new(JobState::Checking),
            progress: watch::Sender::new(JobProgress::default()),
            outcome: watch::Sender::new(None),
            pace: watch::Sender::new(FULL_SPEED),
            laser_use,
            events,
            first: Mutex::new(Some(first)),
            finished: Arc::default(),
            pause_text: Mutex::default(),
            halted: AtomicBool::new(false),
            name,
            origin,
        });
        let owner = Owner {
            shared: Arc::clone(&shared),
            requests,
            detached: AtomicBool::new(false),
        };
        (Self(Arc::new(owner)), shared, inbox)
    }

    /// Name of the work.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.0.shared.name
    }

    /// Origin of the program, for people: a file, for example.
    #[must_use]
    pub fn origin(&self) -> &str {
        &self.0.shared.origin
    }

    /// Current state.
    #[must_use]
    pub fn state(&self) -> JobState {
        self.0.shared.state()
    }

    /// Text for the person that the job waits for. `None` if a pause was requested, and while the
    /// job is not paused.
    #[must_use]
    pub fn pause_text(&self) -> Option<Arc<str>> {
        let shared = &self.0.shared;
        let text = shared.pause_text().clone();
        text.filter(|_| matches!(shared.state(), JobState::Paused { .. }))
    }

    /// Current progress.
    #[must_use]
    pub fn progress(&self) -> JobProgress {
        self.0.shared.progress()
    }

    /// Counter of finished steps that is updated as the job runs, for a recorder.
    #[must_use]
    pub fn finished(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.0.shared.finished)
    }

    /// Subscribes to events from now on. The first caller gets all events from the start.
    #[must_use]
    pub fn events(&self) -> JobEvents {
        let shared = &self.0.shared;
        let first = shared.first.lock();
        let first = first.unwrap_or_else(PoisonError::into_inner).take();
        match first {
            Some(first) => JobEvents::new(first, false),
            None => {
                let events = shared.events.subscribe();
                JobEvents::new(events, shared.state() == JobState::Ended)
            }
        }
    }

    /// Pauses the job: the command in progress ends, the arm's queue is emptied, the laser goes
    /// off, the pen goes up.
    ///
    /// The call itself makes the request. The future resolves when the job is paused, and may be
    /// dropped. A job that is still checking is paused before it sends anything. If the job is
    /// paused already, nothing changes, not even the reason.
    ///
    /// # Errors
    /// [`PauseError`] if the job is ending or over; also if it ends or fails on the way to the
    /// pause.
    pub fn pause(
        &self,
        reason: PauseReason,
    ) -> impl Future<Output = Result<(), PauseError>> + Send + use<> {
        let (reply, answer) = oneshot::channel();
        let sent = self.0.requests.send(Request::Pause(reason, reply));
        async move {
            if sent.is_err() {
                return Err(PauseError::Ended);
            }
            answer.await.unwrap_or(Err(PauseError::Ended))
        }
    }

    /// Resumes a paused job: the tool goes above the place where it stopped, down, and on. The call
    /// itself makes the request; the future resolves when the job runs, or is known to stay paused.
    ///
    /// # Errors
    /// [`ResumeError`]; the job stays paused.
    pub fn resume(&self) -> impl Future<Output = Result<(), ResumeError>> + Send + use<> {
        let (reply, answer) = oneshot::channel();
        let sent = self.0.requests.send(Request::Resume(reply));
        async move {
            if sent.is_err() {
                return Err(ResumeError::NotPaused);
            }
            answer.await.unwrap_or(Err(ResumeError::NotPaused))
        }
    }

    /// True if the job may switch a laser on. Only a person may ask to resume such a job, never a
    /// program on its own.
    #[must_use]
    pub fn burns(&self) -> bool {
        self.0.shared.laser_use.burns
    }

    /// Speed of commands not sent yet, in percent of the program's; 100 at first.
    #[must_use]
    pub fn speed(&self) -> u8 {
        *self.0.shared.pace.borrow()
    }

    /// Sets the speed of commands not sent yet, 10 to 100 percent of the program's.
    ///
    /// Commands that the arm has already keep their speed. The setting lasts across pauses, but a
    /// job resumed in another process runs at 100 percent.
    ///
    /// A job that burns accepts another speed only if all its laser powers are proportional to
    /// speed ([`Step::follows_speed`](magician_program::Step::follows_speed)). Its power is then
    /// scaled too, so that it burns nowhere deeper than at full speed. The change waits for a
    /// travel line that is long enough to slow down and speed up.
    ///
    /// # Errors
    /// [`SpeedError`]; nothing changes.
    pub fn set_speed(&self, percent: u8) -> Result<(), SpeedError> {
        let shared = &self.0.shared;
        if !(MIN_SPEED..=FULL_SPEED).contains(&percent) {
            return Err(SpeedError::Range);
        }
        match shared.state() {
            JobState::Ended => return Err(SpeedError::Ended),
            JobState::Ending | JobState::Stopping => return Err(SpeedError::Ending),
            _ if shared.laser_use.needs_speed => return Err(SpeedError::Burns),
            _ => {}
        }
        if shared.pace.send_replace(percent) != percent {
            shared.emit(JobEvent::Speed(percent));
        }
        Ok(())
    }

    /// Stops the job: the arm stops at once, the laser goes off, the checkpoint is written, the pen
    /// goes up and the settings are restored.
    ///
    /// A second stop cuts this short: the arm stops again, nothing moves after it, and the settings
    /// are restored. The call returns at once; [`outcome`](Self::outcome) waits for the end.
    /// [`StopRule`](crate::StopRule) says which signals count as a second stop.
    pub fn stop(&self) {
        // Fails if the job is over, which is as good as stopped.
        let _ = self.0.requests.send(Request::Stop);
    }

    /// Like [`stop`](Self::stop), but the pen stays where it is: for a stop of the arm, after which
    /// nothing may move. The settings are restored.
    pub fn halt(&self) {
        self.0.shared.halted.store(true, Ordering::SeqCst);
        self.stop();
    }

    /// Lets the job continue when the last handle is dropped.
    pub fn detach(&self) {
        self.0.detached.store(true, Ordering::SeqCst);
    }

    /// Waits for the end of the job. Every clone may call this.
    ///
    /// # Errors
    /// [`JobError`](crate::JobError) with the cause and the state at the end.
    pub async fn outcome(&self) -> JobOutcome {
        let mut outcome = self.0.shared.outcome.subscribe();
        loop {
            if let Some(outcome) = &*outcome.borrow_and_update() {
                return outcome.clone();
            }
            // Cannot fail: this handle keeps the sender alive.
            let _ = outcome.changed().await;
        }
    }
}
