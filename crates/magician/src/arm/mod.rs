mod driver;
mod exposure;
mod flow;
mod halt;
mod watch;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use magician_protocol::commands::{
    AlarmsState, ClearAlarmsState, DeviceVersion, QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
    QueuedCmdStartExec,
};
use magician_protocol::{
    Alarm, AlarmSet, Ctrl, FrameBuf, Layout, NoArgs, Queueable, QueuedCmdIndex, Readable, Set,
    Writable,
};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::{MutexGuard, mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout_at};

use crate::connection::{Connection, Request, Settings, Stats};
use crate::transport::{self, Line, Stream};
use crate::{Error, ErrorKind, QueueIndex, Result, Target};
use driver::{Driver, Message, command_name};
use exposure::Exposure;
use flow::Flow;
pub use flow::{Ran, RunOptions};
pub use watch::Progress;

/// Longer than anybody waits, and short enough to be added to any instant.
const FOREVER: Duration = Duration::from_secs(30 * 365 * 24 * 3600);

/// How a connection behaves.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Options {
    /// Every single call to the arm ends after this time at the latest. Waiting for a motion has
    /// deadlines of its own.
    pub timeout: Duration,
    /// Most requests in flight, 1 to 8. More than 1 is for arms of which it is known that they take
    /// requests back to back; `magician doctor` can measure it.
    pub window: usize,
    /// Whether to make sure at the start that an arm answers.
    pub probe: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            timeout: Duration::from_secs(3),
            window: 1,
            probe: true,
        }
    }
}

impl Options {
    /// Sets [`timeout`](Self::timeout).
    #[must_use]
    pub fn timeout(mut self, timeout: Duration) -> Self {
        self.timeout = timeout;
        self
    }

    /// Sets [`window`](Self::window).
    #[must_use]
    pub fn window(mut self, window: usize) -> Self {
        self.window = window;
        self
    }

    /// Sets [`probe`](Self::probe).
    #[must_use]
    pub fn probe(mut self, probe: bool) -> Self {
        self.probe = probe;
        self
    }
}

/// What a handle and its task both know.
#[derive(Debug, Default)]
struct Shared {
    detached: AtomicBool,
    /// Stops so far. What was begun before the last one is over.
    stops: AtomicU64,
    exposure: Mutex<Exposure>,
    /// What nobody has been told yet.
    mishap: Mutex<Option<Mishap>>,
}

/// What befell the queue without a word from this handle.
#[derive(Clone, Copy, Debug)]
enum Mishap {
    /// The arm was reset; these indices had not finished.
    Reset(Option<(u64, u64)>),
    /// The arm gave these indices to commands that this handle did not send, or sent once.
    Unaccounted { from: u64, to: u64 },
}

impl Shared {
    /// Ends what is going on as a stop does; the next wait or run tells why.
    fn mishap(&self, mishap: Mishap) {
        *self.mishap.lock().unwrap_or_else(PoisonError::into_inner) = Some(mishap);
        self.stops.fetch_add(1, Ordering::SeqCst);
    }
}

/// An arm, for async programs on tokio. [`blocking::Arm`](crate::blocking::Arm) is the same for
/// programs without.
///
/// The three verbs are [`get`](Self::get), [`set`](Self::set) and [`enqueue`](Self::enqueue). They
/// send what they are given. [`words`](crate::words) makes commands from intentions, and
/// [`run`](Self::run) and [`perform`](Self::perform) keep any number of them flowing.
///
/// Every call ends: by its answer, or with an error by its deadline. All methods take `&self`;
/// a [`stop`](Self::stop) from another task overtakes whatever is going on.
///
/// When the handle is dropped, the arm stops what this handle set going and has not seen finished,
/// and the laser goes out if this handle switched it on. [`detach`](Self::detach) lets it go on.
///
/// ```
/// use magician::commands::{Pose, PtpCommonParams};
/// use magician::{Arm, words};
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> magician::Result<()> {
/// let arm = Arm::connect(&"sim".parse()?).await?;
/// arm.set(&PtpCommonParams { velocity_ratio: 80.0, acceleration_ratio: 80.0 }).await?;
/// arm.perform(&[words::move_to(200.0, 50.0, 20.0, 0.0)]).await?;
/// let pose: Pose = arm.get().await?;
/// assert_eq!((pose.x, pose.y, pose.z), (200.0, 50.0, 20.0));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Arm {
    /// `None` only while the handle is being closed.
    messages: Option<mpsc::Sender<Message>>,
    task: Option<JoinHandle<()>>,
    shared: Arc<Shared>,
    flow: tokio::sync::Mutex<Flow>,
    own: Mutex<watch::Own>,
    options: Options,
    name: String,
    /// The warning that the arm may not be homed was given.
    warned: AtomicBool,
}

/// Connecting and leaving.
impl Arm {
    /// Connects to an arm and makes sure that it answers.
    ///
    /// # Errors
    /// [`ErrorKind::Port`] when the port is not there, not allowed or in use, [`ErrorKind::Timeout`]
    /// when nothing answers, [`ErrorKind::Unexpected`] when something else does,
    /// [`ErrorKind::Unsupported`] for Bluetooth.
    pub async fn connect(target: &Target) -> Result<Self> {
        Self::connect_with(target, Options::default()).await
    }

    /// As [`connect`](Self::connect), with other options.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub async fn connect_with(target: &Target, options: Options) -> Result<Self> {
        let line = transport::open(target).await?;
        Self::greet(line, options).await
    }

    /// Talks to an arm over any stream of bytes that keeps their order.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub async fn over<T>(stream: T, options: Options) -> Result<Self>
    where
        T: AsyncRead + AsyncWrite + Send + Unpin + 'static,
    {
        let line = Line {
            transport: Box::new(Stream(stream)),
            settings: Settings::ORDERED,
            name: "the stream".to_owned(),
            tried: "a stream",
        };
        Self::greet(line, options).await
    }

    /// Talks to a virtual arm of the caller's making.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    #[cfg(feature = "sim")]
    pub async fn simulated(runner: magician_sim::Runner, options: Options) -> Result<Self> {
        let line = Line {
            transport: Box::new(transport::Sim::new(runner)),
            settings: Settings::ORDERED,
            name: "sim".to_owned(),
            tried: "a virtual arm",
        };
        Self::greet(line, options).await
    }

    async fn greet(line: Line, options: Options) -> Result<Self> {
        let settings = Settings {
            window: options.window,
            ..line.settings
        };
        let (messages, inbox) = mpsc::channel(64);
        let shared = Arc::new(Shared::default());
        let driver = Driver::new(
            Connection::new(settings),
            line.transport,
            inbox,
            Arc::clone(&shared),
            line.name.clone(),
        );
        let probe = options.probe;
        let arm = Self {
            messages: Some(messages),
            task: Some(tokio::spawn(driver.run())),
            shared,
            flow: tokio::sync::Mutex::default(),
            own: Mutex::default(),
            options,
            name: line.name,
            warned: AtomicBool::new(false),
        };
        if probe {
            arm.probe(line.tried).await?;
        }
        Ok(arm)
    }

    /// Asks for the version, and reads the queue once: where the indices stand, whether it is empty.
    async fn probe(&self, tried: &str) -> Result<()> {
        match self.get::<DeviceVersion>().await {
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::Timeout => {
                return Err(self.silent(tried).await);
            }
            Err(error) => return Err(error),
        }
        self.get::<QueuedCmdCurrentIndex>().await?;
        self.get::<QueuedCmdLeftSpace>().await?;
        Ok(())
    }

    /// The port is there and nothing answers: what was tried, what was seen.
    async fn silent(&self, tried: &str) -> Error {
        let (stats, _) = self.stats().await.unwrap_or_default();
        let heard = match (stats.bytes, stats.frames) {
            (0, _) => "nothing came back; is the arm switched on?".to_owned(),
            (bytes, 0) => format!(
                "{bytes} bytes came back that are not this arm's; is another device on the port?"
            ),
            (bytes, frames) => {
                format!("{bytes} bytes came back in {frames} frames, none of them the answer")
            }
        };
        let name = &self.name;
        // A datagram that nobody takes looks like one that somebody does not answer.
        let silent = match tried {
            "UDP" => format!("no arm answers at {name}"),
            _ => format!("{name} is there but no arm answers"),
        };
        let message = format!(
            "{silent}: {tried}, {} requests for GetDeviceVersion in {:.1} s, {heard}",
            stats.sent,
            self.options.timeout.as_secs_f64(),
        );
        Error::new(ErrorKind::Timeout, message)
    }

    /// Lets what this handle set going go on when the handle is dropped.
    pub fn detach(&self) {
        self.shared.detached.store(true, Ordering::SeqCst);
    }

    /// Ends the connection as dropping it does, and returns when that is done.
    pub async fn close(mut self) {
        self.messages = None;
        if let Some(task) = self.task.take() {
            let _ = task.await;
        }
    }

    /// What the connection is called in messages: the target as it was given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What went over the line so far, and how many commands the arm's queue holds.
    ///
    /// # Errors
    /// [`ErrorKind::Closed`].
    pub async fn stats(&self) -> Result<(Stats, u32)> {
        let (reply, answer) = oneshot::channel();
        let messages = self.messages.as_ref().ok_or_else(Error::closed)?;
        let sent = messages.send(Message::Stats(reply)).await;
        sent.map_err(|_| Error::closed())?;
        answer.await.map_err(|_| Error::closed())
    }
}

/// The verbs.
impl Arm {
    /// Asks for a value.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`], [`ErrorKind::Unexpected`] when the answer cannot be read,
    /// [`ErrorKind::Port`] when the line broke.
    pub async fn get<T: Readable<Query = NoArgs>>(&self) -> Result<T> {
        self.get_with(&NoArgs).await
    }

    /// Asks for a value that depends on something, the level of a pin for one.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn get_with<T: Readable>(&self, query: &T::Query) -> Result<T> {
        let request = Request::get::<T>(query)?;
        let reply = self.ask(request).await?;
        let value = T::decode(reply.frame().params()).map_err(Error::from);
        value.map_err(|error| error.with_command(T::ROW.get_name))
    }

    /// Sets a value or orders an action, at once.
    ///
    /// # Errors
    /// As [`get`](Self::get); [`ErrorKind::Uncertain`] when an action that must not be repeated was
    /// not answered.
    pub async fn set<T: Writable>(&self, value: &T) -> Result<()> {
        self.ask(Request::set(value)?).await.map(drop)
    }

    /// Puts a command into the arm's queue and tells its index. It does not start the queue.
    ///
    /// # Errors
    /// [`ErrorKind::QueueFull`] when there is no room, [`ErrorKind::Uncertain`] when it cannot be
    /// told whether the arm took it, else as [`get`](Self::get).
    pub async fn enqueue<T>(&self, value: &T) -> Result<QueueIndex>
    where
        T: Queueable + Copy + Into<Set>,
    {
        self.enqueue_set(&(*value).into()).await
    }

    /// As [`enqueue`](Self::enqueue), for a command chosen at run time.
    ///
    /// # Errors
    /// As [`enqueue`](Self::enqueue); [`ErrorKind::InvalidInput`] for a command that cannot be queued.
    pub async fn enqueue_set(&self, command: &Set) -> Result<QueueIndex> {
        let request = flow::queued(command)?;
        let deadline = self.deadline();
        let mut flow = self.take_turn(deadline, command.row().set_name).await?;
        if flow.room == 0 {
            let request = Request::get::<QueuedCmdLeftSpace>(&NoArgs)?;
            let reply = self.ask_until(request, deadline).await?;
            let read = QueuedCmdLeftSpace::decode(reply.frame().params())?;
            flow.room = read.left_space;
            self.note_room(flow.room).await?;
        }
        if flow.room == 0 {
            let error = Error::new(ErrorKind::QueueFull, "the arm's queue is full");
            return Err(error.with_command(command.row().set_name));
        }
        // A caller that goes away meanwhile leaves behind what has to be counted anew.
        let mut room = std::mem::take(&mut flow.room);
        let reply = self.ask_until(request, deadline).await;
        let index = self.accepted(&mut room, command, reply)?;
        flow.room = room;
        Ok(index)
    }

    /// An empty queue is noted: what is put into it next runs next.
    async fn note_room(&self, room: u32) -> Result<()> {
        let (_, capacity) = self.stats().await?;
        if room >= capacity {
            self.own().nothing_before();
        }
        Ok(())
    }

    /// The queue is filled by one at a time.
    async fn take_turn(&self, deadline: Instant, name: &str) -> Result<MutexGuard<'_, Flow>> {
        let turn = timeout_at(deadline, self.flow.lock()).await;
        turn.map_err(|_| {
            let message = "another task fills the queue at present";
            Error::new(ErrorKind::Timeout, message).with_command(name)
        })
    }

    /// Accounts for the answer to a queued command.
    fn accepted(
        &self,
        room: &mut u32,
        command: &Set,
        reply: Result<FrameBuf>,
    ) -> Result<QueueIndex> {
        let reply = reply.inspect_err(|_| *room = 0)?;
        let index = QueuedCmdIndex::decode(reply.frame().params())?;
        *room = room.saturating_sub(1);
        self.own().accepted(index, command);
        Ok(index)
    }

    /// Sends any frame and returns the frame that answers it. With Ctrl bit 1 set it is a queued
    /// command like any other, but for the room in the queue, which is not looked at.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`] when the parameters do not fit a frame, else as
    /// [`get`](Self::get) and [`enqueue`](Self::enqueue).
    pub async fn raw(&self, id: u8, ctrl: Ctrl, params: &[u8]) -> Result<FrameBuf> {
        let request = Request::raw(id, ctrl, params)?;
        if !ctrl.queued() {
            return self.ask(request).await;
        }
        let deadline = self.deadline();
        let mut flow = self.take_turn(deadline, "a raw command").await?;
        flow.room = 0;
        let reply = self.ask_until(request, deadline).await?;
        let index = QueuedCmdIndex::decode(reply.frame().params());
        if let (Ok(index), Ok(command)) = (index, Set::decode(id, params)) {
            self.own().accepted(index, &command);
        }
        Ok(reply)
    }

    /// Lets the queue run (document 1.19.1).
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn start_queue(&self) -> Result<()> {
        self.set(&QueuedCmdStartExec {}).await
    }

    /// Free places in the arm's queue.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn left_space(&self) -> Result<u32> {
        let read = self.get::<QueuedCmdLeftSpace>().await?;
        Ok(read.left_space)
    }

    /// Index of the queued command that was finished last, 0 before the first.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn current_index(&self) -> Result<QueueIndex> {
        let read = self.get::<QueuedCmdCurrentIndex>().await?;
        Ok(QueuedCmdIndex(read.queued_cmd_current_index))
    }

    /// The alarms that stand. That some stand is no error.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn alarms(&self) -> Result<AlarmSet> {
        let read = self.get::<AlarmsState>().await?;
        Ok(read.alarms_state)
    }

    /// Clears the alarms, and with them the hold on the queue if no cause stands any more.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn clear_alarms(&self) -> Result<()> {
        self.set(&ClearAlarmsState {}).await
    }
}

/// Requests.
impl Arm {
    fn deadline(&self) -> Instant {
        Instant::now() + self.options.timeout.min(FOREVER)
    }

    /// Tells, once, what befell the queue.
    fn mishap(&self) -> Result<()> {
        let mut mishap = (self.shared.mishap.lock()).unwrap_or_else(PoisonError::into_inner);
        match mishap.take() {
            None => Ok(()),
            Some(Mishap::Reset(gone)) => {
                self.own().clear();
                Err(Error::reset(gone))
            }
            Some(Mishap::Unaccounted { from, to }) => Err(Error::unaccounted(from, to)),
        }
    }

    async fn ask(&self, request: Request) -> Result<FrameBuf> {
        self.ask_until(request, self.deadline()).await
    }

    async fn ask_until(&self, request: Request, deadline: Instant) -> Result<FrameBuf> {
        let frame = *request.frame();
        let answer = self.submit(request, deadline, self.stops()).await?;
        self.answer(answer, &frame, deadline).await
    }

    /// Stops so far.
    fn stops(&self) -> u64 {
        self.shared.stops.load(Ordering::SeqCst)
    }

    /// Hands a request to the task; its answer comes through what this returns. A queued command
    /// that belongs to a time before the last stop is not sent.
    async fn submit(
        &self,
        request: Request,
        deadline: Instant,
        stops: u64,
    ) -> Result<oneshot::Receiver<Result<FrameBuf>>> {
        let (reply, answer) = oneshot::channel();
        let messages = self.messages.as_ref().ok_or_else(Error::closed)?;
        let message = Message::Submit {
            request,
            deadline,
            stops,
            reply,
        };
        match timeout_at(deadline, messages.send(message)).await {
            Ok(Ok(())) => Ok(answer),
            Ok(Err(_)) => Err(Error::closed()),
            Err(_) => Err(Error::new(ErrorKind::Timeout, "the connection is stuck")),
        }
    }

    /// The answer, or an error even if the task should be kept from its work.
    async fn answer(
        &self,
        answer: oneshot::Receiver<Result<FrameBuf>>,
        request: &FrameBuf,
        deadline: Instant,
    ) -> Result<FrameBuf> {
        let late = deadline + Duration::from_millis(5);
        match timeout_at(late, answer).await {
            Ok(Ok(result)) => result,
            Ok(Err(_)) => Err(Error::closed()),
            Err(_) if request.frame().ctrl().queued() => Err(Error::uncertain(None, None)),
            Err(_) => Err(Error::new(ErrorKind::Timeout, "no answer")),
        }
        .map_err(|error| match error.command() {
            Some(_) => error,
            None => error.with_command(command_name(&request.frame())),
        })
    }

    /// Warns, once, that the arm was not homed since it was switched on, as far as can be told.
    async fn warn_if_not_homed(&self) -> Result<()> {
        if !self.warned.swap(true, Ordering::SeqCst)
            && self.alarms().await?.contains(Alarm::ResetOccurred)
        {
            tracing::warn!(
                "{}: the arm reports that it was reset and nobody has cleared that since; if it has not \
                 been homed, its positions are not true: `magician home`",
                self.name
            );
        }
        Ok(())
    }

    fn own(&self) -> std::sync::MutexGuard<'_, watch::Own> {
        self.own.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn exposure(&self) -> std::sync::MutexGuard<'_, Exposure> {
        self.shared
            .exposure
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}
