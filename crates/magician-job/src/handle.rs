//! The handle of a running job.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{broadcast, mpsc, oneshot, watch};

use crate::error::{JobOutcome, PauseError, ResumeError, SpeedError};
use crate::event::{JobEvent, JobEvents, JobProgress, JobState, PauseReason};

/// Events that are kept for a slow reader.
const EVENTS: usize = 256;

/// The speed of a job as its program says it, percent, and the least.
pub(crate) const FULL: u8 = 100;
const SLOWEST: u8 = 10;

/// A request to a job.
#[derive(Debug)]
pub(crate) enum Request {
    Pause(PauseReason, oneshot::Sender<Result<(), PauseError>>),
    Resume(oneshot::Sender<Result<(), ResumeError>>),
    Stop,
}

/// What is known of a job from its beginning.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fixed {
    /// Whether it may light a laser.
    pub(crate) burns: bool,
    /// Whether something that it burns has its power for one speed only.
    pub(crate) needs_speed: bool,
}

/// What the engine and all handles share.
#[derive(Debug)]
pub(crate) struct Shared {
    state: watch::Sender<JobState>,
    progress: watch::Sender<JobProgress>,
    outcome: watch::Sender<Option<JobOutcome>>,
    /// What is wanted of what is not sent yet, percent.
    pub(crate) pace: watch::Sender<u8>,
    fixed: Fixed,
    events: broadcast::Sender<JobEvent>,
    /// What has been told before anybody asked for it.
    first: Mutex<Option<broadcast::Receiver<JobEvent>>>,
    finished: Arc<AtomicU64>,
    /// What the person is told who is waited for.
    pause_text: Mutex<Option<Arc<str>>>,
    /// Whether nothing moves any more after a stop.
    pub(crate) halted: AtomicBool,
    name: String,
    origin: String,
}

impl Shared {
    pub(crate) fn tell(&self, event: JobEvent) {
        // Listening is optional.
        let _ = self.events.send(event);
    }

    pub(crate) fn enter(&self, state: JobState) {
        self.state.send_replace(state);
        self.tell(JobEvent::State(state));
    }

    /// It is paused, and the person is told this.
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

    /// What is finished, for all observers.
    pub(crate) fn reach(&self, progress: JobProgress) {
        self.finished.store(progress.step, Ordering::Relaxed);
        self.progress.send_replace(progress);
    }

    pub(crate) fn end(&self, outcome: JobOutcome) {
        self.outcome.send_replace(Some(outcome));
        self.enter(JobState::Ended);
    }
}

/// Everything that a handle is, once for all clones.
#[derive(Debug)]
struct Owner {
    shared: Arc<Shared>,
    requests: mpsc::UnboundedSender<Request>,
    detached: AtomicBool,
}

impl Drop for Owner {
    fn drop(&mut self) {
        if !self.detached.load(Ordering::SeqCst) {
            // Over already: the task is gone.
            let _ = self.requests.send(Request::Stop);
        }
    }
}

/// A job that was started. Clones are cheap, and may be used from any task and thread; a server keeps one for as long as it wants
/// the job to go on.
///
/// When the *last* clone is dropped the job is stopped as by [`stop`](Self::stop): the rule of the driver, which stops an arm whose
/// last handle goes. [`detach`](Self::detach) lets it go on. A runtime that ends takes the job with it; the driver then stops the
/// arm and switches the laser off, and the journal says what was handed over, as after a crash.
#[derive(Clone, Debug)]
pub struct JobHandle(Arc<Owner>);

impl JobHandle {
    pub(crate) fn new(
        name: String,
        origin: String,
        fixed: Fixed,
    ) -> (Self, Arc<Shared>, mpsc::UnboundedReceiver<Request>) {
        let (requests, inbox) = mpsc::unbounded_channel();
        let (events, first) = broadcast::channel(EVENTS);
        let shared = Arc::new(Shared {
            state: watch::Sender::new(JobState::Checking),
            progress: watch::Sender::new(JobProgress::default()),
            outcome: watch::Sender::new(None),
            pace: watch::Sender::new(FULL),
            fixed,
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

    /// Where the program comes from.
    #[must_use]
    pub fn origin(&self) -> &str {
        &self.0.shared.origin
    }

    /// What it does at present.
    #[must_use]
    pub fn state(&self) -> JobState {
        self.0.shared.state()
    }

    /// What the person is told for whom it pauses; nothing at a pause that was asked for, and while it is not paused.
    #[must_use]
    pub fn pause_text(&self) -> Option<Arc<str>> {
        let shared = &self.0.shared;
        let text = shared.pause_text().clone();
        text.filter(|_| matches!(shared.state(), JobState::Paused { .. }))
    }

    /// How far it is at present.
    #[must_use]
    pub fn progress(&self) -> JobProgress {
        self.0.shared.progress()
    }

    /// The steps that are finished, as a number that goes along: for what is recorded meanwhile.
    #[must_use]
    pub fn finished(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.0.shared.finished)
    }

    /// Its events from now on; the first caller gets all from the start.
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

    /// Pauses it: the piece under way ends, what waits in the arm's queue is dropped, the laser goes off, the pen goes up. The
    /// request is made by the call; the future is over when the job is paused, and may be dropped.
    ///
    /// While the job checks it is paused before it sends anything. While it is paused already nothing changes, the reason
    /// either.
    ///
    /// # Errors
    /// [`PauseError`] while it ends and when it is over; also when it comes to its end, or fails, on the way to the pause.
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

    /// Goes on with a job that is paused: above the place where it ended, down, and on. The request is made by the call; the
    /// future is over when the job runs, or is known to stay paused.
    ///
    /// # Errors
    /// [`ResumeError`]; the job stays paused then.
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

    /// Whether it may light a laser. Such a job is resumed when a person asks for it, and never by a program of its own accord.
    #[must_use]
    pub fn burns(&self) -> bool {
        self.0.shared.fixed.burns
    }

    /// How fast it goes what is not sent yet, in percent of what the program says: 100 at first.
    #[must_use]
    pub fn speed(&self) -> u8 {
        *self.0.shared.pace.borrow()
    }

    /// Has it go faster or slower from here on: what is not sent yet, also behind a pause, has this share of its speed, 10 to 100
    /// percent. What the arm has already keeps the speed that it was sent with. A job that is resumed in another process goes at
    /// 100 percent.
    ///
    /// A job that burns goes at another speed only if all that it burns has its power in proportion to speed
    /// ([`Step::follows_speed`](magician_program::Step::follows_speed)): its power follows, so that it burns nowhere deeper than at full
    /// speed. The change comes on a way with the laser off that is long enough to slow down and speed up on.
    ///
    /// # Errors
    /// [`SpeedError`]; nothing changes then.
    pub fn set_speed(&self, percent: u8) -> Result<(), SpeedError> {
        let shared = &self.0.shared;
        if !(SLOWEST..=FULL).contains(&percent) {
            return Err(SpeedError::Range);
        }
        match shared.state() {
            JobState::Ended => return Err(SpeedError::Ended),
            JobState::Ending | JobState::Stopping => return Err(SpeedError::Ending),
            _ if shared.fixed.needs_speed => return Err(SpeedError::Burns),
            _ => {}
        }
        if shared.pace.send_replace(percent) != percent {
            shared.tell(JobEvent::Speed(percent));
        }
        Ok(())
    }

    /// Stops it: the arm stops at once, the laser is off, what is known is kept, the pen goes up and the settings are restored.
    /// A second stop ends that: the arm stops again, and nothing moves after it; the settings are restored all the same. The call
    /// returns at once; [`outcome`](Self::outcome) tells the end. [`StopRule`](crate::StopRule) says which signals are a second stop.
    pub fn stop(&self) {
        // What is over is stopped.
        let _ = self.0.requests.send(Request::Stop);
    }

    /// As [`stop`](Self::stop), and the pen stays where it is: for a stop of the arm, after which nothing is to move. Settings
    /// are restored all the same.
    pub fn halt(&self) {
        self.0.shared.halted.store(true, Ordering::SeqCst);
        self.stop();
    }

    /// Lets it go on when the last handle is dropped.
    pub fn detach(&self) {
        self.0.detached.store(true, Ordering::SeqCst);
    }

    /// Waits for its end. Every clone may.
    ///
    /// # Errors
    /// [`JobError`](crate::JobError): why it did not come to its end, and how it stands then.
    pub async fn outcome(&self) -> JobOutcome {
        let mut outcome = self.0.shared.outcome.subscribe();
        loop {
            if let Some(outcome) = &*outcome.borrow_and_update() {
                return outcome.clone();
            }
            // The handle itself keeps the sender.
            let _ = outcome.changed().await;
        }
    }
}
