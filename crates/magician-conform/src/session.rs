//! The steps of a case, done on an arm.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::commands::{AlarmsState, DeviceTime, Pose, QueuedCmdCurrentIndex};
use magician_protocol::{
    AlarmSet, Ctrl, Deframer, Direction, Event, Frame, FrameBuf, NoArgs, Readable, Row,
};

use crate::bench::Bench;
use crate::report::{Mismatch, hex, in_words};
use crate::step::{Action, Alarms, Answer, Finished, Step, reply_layout};

/// How long the arm must be quiet to be silent.
pub(crate) const QUIET: Duration = Duration::from_millis(200);
/// What reading the time over a line, and looking only now and then, may cost.
const SLACK: Duration = Duration::from_millis(100);
/// Longest that anything may take: homing, and a jog through the whole range.
const LONGEST: Duration = Duration::from_secs(120);
/// Longest stretch of time that passes unseen.
const STRETCH: Duration = Duration::from_secs(1);
/// How long the arm must keep its pose to be at rest.
const STILL: Duration = Duration::from_millis(100);

/// Why a step ended a case.
#[derive(Debug)]
pub(crate) enum Stopped {
    /// The arm did something else.
    Otherwise(Box<Mismatch>),
    /// The line is gone.
    Line(magician::Error),
}

impl From<magician::Error> for Stopped {
    fn from(error: magician::Error) -> Self {
        Self::Line(error)
    }
}

/// What went wrong in a step, before it is known which.
struct Wrong {
    expected: String,
    got: String,
    received: Vec<u8>,
}

enum Trouble {
    Wrong(Wrong),
    Line(magician::Error),
}

impl From<magician::Error> for Trouble {
    fn from(error: magician::Error) -> Self {
        Self::Line(error)
    }
}

type Done = Result<(), Trouble>;

fn wrong<T>(
    expected: impl Into<String>,
    got: impl Into<String>,
    received: &[u8],
) -> Result<T, Trouble> {
    Err(Trouble::Wrong(Wrong {
        expected: expected.into(),
        got: got.into(),
        received: received.to_vec(),
    }))
}

/// A conversation with an arm, and what is known from it.
pub(crate) struct Session<B> {
    pub(crate) bench: B,
    /// How long an answer may take.
    patience: Duration,
    deframer: Deframer,
    inbox: VecDeque<FrameBuf>,
    sent: Vec<u8>,
    /// Index that had finished when the case began.
    before: u64,
    /// Index of the command queued last.
    last: Option<u64>,
    /// When the last order was given, by the arm's clock; not read over a line when no step needs it.
    ordered: u64,
    timed: bool,
}

impl<B: Bench> Session<B> {
    pub(crate) fn new(bench: B, patience: Duration) -> Self {
        Self {
            bench,
            patience,
            deframer: Deframer::new(),
            inbox: VecDeque::new(),
            sent: Vec::new(),
            before: 0,
            last: None,
            ordered: 0,
            timed: false,
        }
    }

    /// Forgets what was before, bytes on their way included.
    pub(crate) async fn begin(&mut self) -> magician::Result<()> {
        while !self.bench.receive(Duration::ZERO).await?.is_empty() {}
        self.deframer = Deframer::new();
        self.inbox.clear();
        self.sent.clear();
        self.last = None;
        Ok(())
    }

    /// Does the steps of a case.
    pub(crate) async fn perform(&mut self, steps: &[Step]) -> Result<(), Stopped> {
        let clocked = |step: &Step| matches!(step.action, Action::At(_) | Action::Done(Some(_)));
        self.timed = self.bench.stepped().is_some() || steps.iter().any(clocked);
        let started = self.start().await;
        self.told(started, 0, "the case begins")?;
        for step in steps {
            for _ in 0..step.times {
                let done = self.step(&step.action).await;
                self.told(done, step.line, &step.text)?;
            }
        }
        let quiet = self.nothing(Duration::from_millis(60)).await;
        self.told(quiet, 0, "the case ends")
    }

    /// Does steps that lead to where a case begins.
    pub(crate) async fn prepare(&mut self, steps: &[Step]) -> Result<(), Stopped> {
        self.timed = false;
        for step in steps {
            let done = self.step(&step.action).await;
            self.told(done, 0, &format!("before the case: {}", step.text))?;
        }
        Ok(())
    }

    fn told(&self, done: Done, line: usize, step: &str) -> Result<(), Stopped> {
        done.map_err(|trouble| match trouble {
            Trouble::Line(error) => Stopped::Line(error),
            Trouble::Wrong(Wrong {
                expected,
                got,
                received,
            }) => Stopped::Otherwise(Box::new(Mismatch {
                line,
                step: step.to_owned(),
                sent: self.sent.clone(),
                expected,
                got,
                received,
            })),
        })
    }

    async fn start(&mut self) -> Done {
        self.last = None;
        self.before = self.current().await?;
        self.order().await
    }

    async fn step(&mut self, action: &Action) -> Done {
        match action {
            Action::Send(bytes) => {
                self.send(bytes).await?;
                if self.bench.stepped().is_some() {
                    self.order().await?;
                }
                Ok(())
            }
            Action::Ask(frame, answer) => {
                self.send(frame.bytes()).await?;
                self.answered(answer).await
            }
            Action::Answered(answer) => self.answered(answer).await,
            Action::Reply(bytes) => self.reply(bytes).await,
            Action::Silence => self.nothing(QUIET).await,
            Action::Wait(span) => Ok(self.bench.pass(*span).await?),
            Action::At(span) => self.at(*span).await,
            Action::Done(when) => self.done(*when).await,
            Action::Rest => self.rest().await,
            Action::Finished(finished) => self.finished(*finished).await,
            Action::Alarms(alarms) => self.alarms(alarms).await,
            Action::Happens(happening) => match self.bench.happens(*happening) {
                true => self.order().await,
                false => wrong(
                    "that this can be made to happen",
                    "only a virtual arm inside this program can",
                    &[],
                ),
            },
        }
    }
}

/// Bytes and frames.
impl<B: Bench> Session<B> {
    async fn send(&mut self, bytes: &[u8]) -> Done {
        self.sent = bytes.to_vec();
        Ok(self.bench.send(bytes).await?)
    }

    /// The next frame from the arm, `None` if none comes.
    async fn next(&mut self, within: Duration) -> Result<Option<FrameBuf>, Trouble> {
        let mut pieces = 0;
        while self.inbox.is_empty() {
            let bytes = self.bench.receive(within).await?;
            // A line that never falls silent has no frames for us either.
            pieces += 1;
            if bytes.is_empty() || pieces > 1000 {
                return Ok(None);
            }
            let mut input = bytes.as_slice();
            while let Some(event) = self.deframer.next(&mut input) {
                if let Event::Frame { frame, .. } = event {
                    self.inbox.push_back(FrameBuf::from(frame));
                }
            }
        }
        Ok(self.inbox.pop_front())
    }

    async fn nothing(&mut self, within: Duration) -> Done {
        match self.next(within).await? {
            None => Ok(()),
            Some(frame) => wrong(
                "nothing from the arm",
                in_words(&frame, Direction::Reply),
                frame.bytes(),
            ),
        }
    }

    async fn reply(&mut self, bytes: &[Option<u8>]) -> Done {
        let expected: Vec<String> = bytes
            .iter()
            .map(|byte| byte.map_or("..".to_owned(), |byte| hex(&[byte])))
            .collect();
        let expected = expected.join(" ");
        let Some(frame) = self.next(self.patience).await? else {
            return wrong(expected, "nothing", &[]);
        };
        let found = frame.bytes();
        let same = found.len() == bytes.len()
            && found
                .iter()
                .zip(bytes)
                .all(|(found, byte)| byte.is_none_or(|byte| byte == *found));
        match same {
            true => self.note_index(&frame).await,
            false => wrong(expected, in_words(&frame, Direction::Reply), found),
        }
    }

    /// The answer to the frame sent last: id and Ctrl as they were, the parameters of its form and no more.
    async fn answered(&mut self, answer: &Answer) -> Done {
        let Some(request) = Frame::new(&self.sent).map(FrameBuf::from) else {
            return wrong(
                "a frame that can be answered",
                "damaged bytes were sent",
                &[],
            );
        };
        let (id, ctrl) = (request.frame().id(), request.frame().ctrl());
        let Some(row) = Row::with_id(id) else {
            return wrong(
                "a command that can be answered",
                format!("id {id} was sent"),
                &[],
            );
        };
        let ctrl = if answer.full { ctrl.with_error() } else { ctrl };
        let layout = reply_layout(row, ctrl);
        let expected = || expectation(row, ctrl, answer);
        let Some(frame) = self.next(self.patience).await? else {
            return wrong(expected(), "nothing", &[]);
        };
        let view = frame.frame();
        let fits = layout
            .normalise(view.params().len())
            .is_ok_and(|fit| fit.note.is_none());
        let right = view.id() == id
            && view.ctrl() == ctrl
            && fits
            && answer
                .checks
                .iter()
                .all(|check| check.holds(layout, view.params()))
            && self.indexed(row, ctrl, &frame, answer.full);
        match right {
            true => self.note_index(&frame).await,
            false => wrong(
                expected(),
                in_words(&frame, Direction::Reply),
                frame.bytes(),
            ),
        }
    }

    /// Whether the index in the answer to a queued command is one above the one before, or 0 if it was refused.
    fn indexed(&self, row: &Row, ctrl: Ctrl, frame: &FrameBuf, full: bool) -> bool {
        match index_of(row, ctrl, frame) {
            None => true,
            Some(index) if full => index == 0,
            Some(index) => index > 0 && self.last.is_none_or(|last| index == last + 1),
        }
    }

    async fn note_index(&mut self, frame: &FrameBuf) -> Done {
        let view = frame.frame();
        let Some(row) = Row::with_id(view.id()) else {
            return Ok(());
        };
        if let Some(index) = index_of(row, view.ctrl(), frame).filter(|index| *index > 0) {
            self.last = Some(index);
        }
        if row.sets(view.ctrl()) {
            self.order().await?;
        }
        Ok(())
    }

    /// Asks for a value in passing; the sent bytes of the case stay those that are told.
    async fn ask<T: Readable<Query = NoArgs>>(&mut self) -> Result<T, Trouble> {
        let told = std::mem::take(&mut self.sent);
        let frame = FrameBuf::get(&NoArgs, T::ROW).map_err(magician::Error::from)?;
        let name = T::ROW.get_name;
        self.send(frame.bytes()).await?;
        let Some(reply) = self.next(self.patience).await? else {
            return wrong(format!("an answer to {name}"), "nothing", &[]);
        };
        let view = reply.frame();
        let value = (view.id() == T::ROW.id)
            .then(|| view.read::<T>().ok())
            .flatten();
        let Some(value) = value else {
            let got = in_words(&reply, Direction::Reply);
            return wrong(format!("an answer to {name}"), got, reply.bytes());
        };
        self.sent = told;
        Ok(value)
    }
}

fn index_of(row: &Row, ctrl: Ctrl, frame: &FrameBuf) -> Option<u64> {
    let queued = row.sets(ctrl) && ctrl.queued() && !row.steers_queue();
    let params: [u8; 8] = frame.frame().params().try_into().ok()?;
    queued.then(|| u64::from_le_bytes(params))
}

fn expectation(row: &Row, ctrl: Ctrl, answer: &Answer) -> String {
    let mut text = format!("{} with Ctrl {:#04x}", row.form_name(ctrl), ctrl.0);
    if row.sets(ctrl) && ctrl.queued() && !row.steers_queue() {
        text += if answer.full {
            " and index 0"
        } else {
            " and the next index"
        };
    }
    for check in &answer.checks {
        text += &format!(" {check}");
    }
    text
}

/// Time, the queue and alarms.
impl<B: Bench> Session<B> {
    /// The arm's clock in microseconds: exact where it is stepped, read over the line otherwise.
    async fn clock(&mut self) -> Result<u64, Trouble> {
        match self.bench.stepped() {
            Some(now) => Ok(now),
            None => Ok(u64::from(self.ask::<DeviceTime>().await?.g_systick) * 1000),
        }
    }

    async fn order(&mut self) -> Done {
        if self.timed {
            self.ordered = self.clock().await?;
        }
        Ok(())
    }

    /// Time since the last order. The clock on a line wraps.
    async fn elapsed(&mut self) -> Result<Duration, Trouble> {
        let wrap = 1000 << 32;
        let (now, then) = (self.clock().await?, self.ordered);
        let span = if now < then {
            now + wrap - then
        } else {
            now - then
        };
        Ok(Duration::from_micros(span))
    }

    async fn at(&mut self, span: Duration) -> Done {
        // A clock on a line may run at another pace than the wall's.
        for _ in 0..100 {
            let left = span.saturating_sub(self.elapsed().await?);
            if left.is_zero() {
                return Ok(());
            }
            self.bench.pass(left).await?;
        }
        wrong("the arm's clock to run", "it stands", &[])
    }

    async fn current(&mut self) -> Result<u64, Trouble> {
        Ok(self
            .ask::<QueuedCmdCurrentIndex>()
            .await?
            .queued_cmd_current_index)
    }

    /// Lets a little time pass; at most that long.
    async fn go_on(&mut self, at_most: Duration) -> Done {
        let before = self.bench.stepped();
        self.bench.go_on(at_most.min(STRETCH)).await?;
        if before.is_some() && before == self.bench.stepped() {
            self.bench.pass(Duration::from_millis(1)).await?;
        }
        Ok(())
    }

    async fn done(&mut self, when: Option<(Duration, Duration)>) -> Done {
        let Some(last) = self.last else {
            return wrong("a queued command to wait for", "none was queued", &[]);
        };
        let slack = if self.bench.stepped().is_some() {
            Duration::ZERO
        } else {
            SLACK
        };
        let latest = when.map_or(LONGEST, |(at, tolerance)| at + tolerance.max(slack));
        let mut waited = Duration::ZERO;
        loop {
            let current = self.current().await?;
            let elapsed = match self.timed {
                true => self.elapsed().await?,
                false => waited,
            };
            if current >= last {
                let early = when.is_some_and(|(at, tolerance)| elapsed + tolerance.max(slack) < at);
                return match (early, elapsed > latest) {
                    (false, false) => Ok(()),
                    _ => wrong(
                        finish_by(last, when),
                        format!("it finished after {}", seconds(elapsed)),
                        &[],
                    ),
                };
            }
            if elapsed > latest {
                let got = format!("after {} it has finished {current}", seconds(elapsed));
                return wrong(finish_by(last, when), got, &[]);
            }
            let left = latest.saturating_sub(elapsed) + Duration::from_millis(1);
            self.go_on(left).await?;
            waited += left.min(Duration::from_millis(10));
        }
    }

    async fn rest(&mut self) -> Done {
        let mut waited = Duration::ZERO;
        let mut pose = self.ask::<Pose>().await?;
        while waited < LONGEST {
            self.bench.pass(STILL).await?;
            waited += STILL;
            let now = self.ask::<Pose>().await?;
            if now == pose {
                return Ok(());
            }
            pose = now;
        }
        wrong(
            "the arm to come to rest",
            format!("it still moves after {}", seconds(waited)),
            &[],
        )
    }

    async fn finished(&mut self, finished: Finished) -> Done {
        let wanted = match (finished, self.last) {
            (Finished::Nothing, _) => self.before,
            (Finished::Last(less), Some(last)) => last.saturating_sub(less),
            (Finished::Last(_), None) => {
                return wrong("a queued command to look for", "none was queued", &[]);
            }
        };
        let current = self.current().await?;
        match current == wanted {
            true => Ok(()),
            false => wrong(
                format!("index {wanted} finished last"),
                format!("index {current} finished last"),
                &[],
            ),
        }
    }

    async fn alarms(&mut self, wanted: &Alarms) -> Done {
        let standing = self.ask::<AlarmsState>().await?.alarms_state;
        let (right, expected) = match wanted {
            Alarms::Are(codes) => (
                standing.codes().eq(sorted(codes)),
                format!("alarms {}", named(codes)),
            ),
            Alarms::With(codes) => (
                codes.iter().all(|code| standing.contains(*code)),
                format!("alarms with {}", named(codes)),
            ),
            Alarms::Without(codes) => (
                !codes.iter().any(|code| standing.contains(*code)),
                format!("alarms without {}", named(codes)),
            ),
        };
        match right {
            true => Ok(()),
            false => wrong(expected, format!("alarms {standing}"), standing.as_bytes()),
        }
    }
}

fn sorted(codes: &[u8]) -> Vec<u8> {
    let mut codes = codes.to_vec();
    codes.sort_unstable();
    codes
}

fn named(codes: &[u8]) -> String {
    codes.iter().copied().collect::<AlarmSet>().to_string()
}

fn finish_by(last: u64, when: Option<(Duration, Duration)>) -> String {
    match when {
        Some((at, _)) => format!("index {last} to finish after {}", seconds(at)),
        None => format!("index {last} to finish within {}", seconds(LONGEST)),
    }
}

fn seconds(span: Duration) -> String {
    format!("{:.3} s", span.as_secs_f64())
}

/// Outside of cases.
impl<B: Bench> Session<B> {
    /// The parameters of the answer to a get without fields, `None` when none comes.
    pub(crate) async fn value(&mut self, id: u8) -> magician::Result<Option<Vec<u8>>> {
        let frame = FrameBuf::new(id, Ctrl::GET, &[])?;
        let reply = self.exchange(&frame).await?;
        Ok(reply.map(|reply| reply.frame().params().to_vec()))
    }

    /// Whether the arm answers a set.
    pub(crate) async fn acknowledged(&mut self, frame: &FrameBuf) -> magician::Result<bool> {
        Ok(self.exchange(frame).await?.is_some())
    }

    async fn exchange(&mut self, frame: &FrameBuf) -> magician::Result<Option<FrameBuf>> {
        self.bench.send(frame.bytes()).await?;
        let id = frame.frame().id();
        match self.next(self.patience).await {
            Ok(reply) => Ok(reply.filter(|reply| reply.frame().id() == id)),
            Err(Trouble::Line(error)) => Err(error),
            Err(Trouble::Wrong(_)) => Ok(None),
        }
    }
}
