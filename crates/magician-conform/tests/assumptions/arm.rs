//! Virtual arm that violates one assumption: its input or output is altered between the runner and
//! the controller.

use std::time::Duration;

use magician::Result;
use magician_conform::{Observable, SimTarget, Target};
use magician_protocol::commands::{Set, WaitCmd};
use magician_protocol::{Ctrl, Deframer, Event, Frame, FrameBuf, NoArgs, Readable, Request, Row};
use magician_sim::{ArmInstant, Controller, ExternalEvent, LinkId, Profile, World};

/// Link for commands of the tests that the runner does not see.
const SIDE_LINK: LinkId = LinkId(99);
/// Step of time between two side effects of `Violation::Time`. Longer in waits of more than 10 s.
const TIME_STEP: Duration = Duration::from_millis(5);

/// Kind of violation of an assumption.
// Each hook type is used only here.
#[allow(clippy::type_complexity)]
pub(crate) enum Violation {
    /// Another firmware.
    Profile(fn(&mut Profile)),
    /// Altered bytes of requests.
    Bytes(Box<dyn FnMut(&[u8]) -> Vec<u8>>),
    /// Altered request.
    Request(Box<dyn FnMut(&mut Controller, &FrameBuf) -> Fate>),
    /// Side effect after a request.
    After(Box<dyn FnMut(&mut Controller, &Request)>),
    /// Altered answer.
    Reply(Box<dyn FnMut(&mut Controller, FrameBuf) -> FrameBuf>),
    /// Altered external event; true if it is injected.
    Event(Box<dyn FnMut(&mut Controller, ExternalEvent) -> bool>),
    /// Side effect, repeated after each short step of time.
    Time(Box<dyn FnMut(&mut Controller)>),
    /// All hosts are treated as one.
    OneLink,
}

/// Fate of a request.
pub(crate) enum Fate {
    /// Executed.
    Taken,
    /// Answered, without effect.
    Ignored,
    /// Not answered, without effect.
    Unanswered,
    /// Replaced by this request; the reply gets the id and Ctrl of the original.
    Replaced(FrameBuf),
    /// Answered by this, without effect.
    Answered(FrameBuf),
}

/// Virtual arm that violates an assumption.
pub(crate) struct ViolatingArm {
    begin: Box<dyn Fn() -> Violation>,
    violation: Violation,
    sim: SimTarget,
    replies: Vec<u8>,
}

impl ViolatingArm {
    /// Creates an arm. `begin` creates a fresh violation for each case.
    pub(crate) fn new(begin: impl Fn() -> Violation + 'static) -> Self {
        let violation = begin();
        let mut profile = Profile::default();
        if let Violation::Profile(change) = violation {
            change(&mut profile);
        }
        Self {
            begin: Box::new(begin),
            violation,
            sim: SimTarget::new(profile),
            replies: Vec::new(),
        }
    }

    /// Collects the answers of the arm.
    async fn collect(&mut self) -> Result<()> {
        let bytes = self.sim.receive(Duration::ZERO).await?;
        self.store_replies(&bytes, |reply| reply);
        Ok(())
    }

    fn store_replies(&mut self, bytes: &[u8], mut alter: impl FnMut(FrameBuf) -> FrameBuf) {
        let (mut deframer, mut input) = (Deframer::new(), bytes);
        while let Some(event) = deframer.next(&mut input) {
            let Event::Frame { frame, .. } = event else {
                continue;
            };
            let mut reply = alter(FrameBuf::from(frame));
            if let Violation::Reply(change) = &mut self.violation {
                reply = change(self.sim.arm(), reply);
            }
            self.replies.extend_from_slice(reply.bytes());
        }
    }

    /// Executes another request in place of the original.
    async fn replace(&mut self, request: &FrameBuf, by: &FrameBuf) -> Result<()> {
        self.sim.send(by.bytes()).await?;
        let bytes = self.sim.receive(Duration::ZERO).await?;
        let (id, ctrl) = (request.frame().id(), request.frame().ctrl());
        self.store_replies(&bytes, |reply| {
            let reply = reply.frame();
            let ctrl = if reply.ctrl().error() {
                ctrl.with_error()
            } else {
                ctrl
            };
            FrameBuf::new(id, ctrl, reply.params()).expect("as long as before")
        });
        Ok(())
    }

    async fn ignore(&mut self, request: &FrameBuf) -> Result<()> {
        let (id, ctrl) = (request.frame().id(), request.frame().ctrl());
        let queued = ctrl.queued() && Row::with_id(id).is_some_and(|row| !row.steers_queue());
        if queued {
            let nothing = Set::WaitCmd(WaitCmd { timeout: 0 });
            let nothing = FrameBuf::set(&nothing, Ctrl::QUEUED).expect("fits");
            return self.replace(request, &nothing).await;
        }
        let empty = FrameBuf::new(id, ctrl, &[]).expect("fits");
        self.replies.extend_from_slice(empty.bytes());
        Ok(())
    }
}

impl Target for ViolatingArm {
    async fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let frame = Frame::new(bytes).map(FrameBuf::from);
        let fate = match (&mut self.violation, &frame) {
            (Violation::Bytes(change), _) => {
                let bytes = change(bytes);
                self.sim.send(&bytes).await?;
                return self.collect().await;
            }
            (Violation::Request(decide), Some(frame)) => decide(self.sim.arm(), frame),
            _ => Fate::Taken,
        };
        match (fate, &frame) {
            (Fate::Ignored, Some(frame)) => self.ignore(frame).await?,
            (Fate::Replaced(by), Some(frame)) => self.replace(frame, &by).await?,
            (Fate::Answered(reply), _) => self.replies.extend_from_slice(reply.bytes()),
            (Fate::Unanswered, _) => {}
            _ => self.sim.send(bytes).await?,
        }
        self.collect().await?;
        let request = frame.and_then(|frame| Request::decode(&frame.frame()).ok());
        if let (Violation::After(act), Some(request)) = (&mut self.violation, &request) {
            act(self.sim.arm(), request);
        }
        Ok(())
    }

    async fn receive(&mut self, within: Duration) -> Result<Vec<u8>> {
        if self.replies.is_empty() {
            let bytes = self.sim.receive(within).await?;
            self.store_replies(&bytes, |reply| reply);
        }
        Ok(std::mem::take(&mut self.replies))
    }

    async fn pass(&mut self, span: Duration) -> Result<()> {
        let Violation::Time(act) = &mut self.violation else {
            return self.sim.pass(span).await;
        };
        let step = TIME_STEP.max(span / 2000).min(span);
        let mut left = span;
        while !left.is_zero() {
            let step = step.min(left);
            self.sim.pass(step).await?;
            act(self.sim.arm());
            left -= step;
        }
        Ok(())
    }

    async fn go_on(&mut self, at_most: Duration) -> Result<()> {
        match &mut self.violation {
            Violation::Time(act) => {
                self.sim.go_on(at_most.min(TIME_STEP)).await?;
                act(self.sim.arm());
                Ok(())
            }
            _ => self.sim.go_on(at_most).await,
        }
    }

    fn stepped(&self) -> Option<ArmInstant> {
        self.sim.stepped()
    }

    fn power_up(&mut self, world: World) -> bool {
        // A fresh violation, because the old one has state of the previous case.
        self.violation = (self.begin)();
        self.replies.clear();
        self.sim.power_up(world)
    }

    fn happens(&mut self, event: ExternalEvent) -> bool {
        if let Violation::Event(act) = &mut self.violation
            && !act(self.sim.arm(), event)
        {
            return true;
        }
        self.sim.happens(event)
    }

    fn sees(&mut self, observable: Observable) -> Option<f64> {
        self.sim.sees(observable)
    }

    fn select(&mut self, link: u8) -> bool {
        matches!(self.violation, Violation::OneLink) || self.sim.select(link)
    }
}

/// Sends a setting to the arm without the runner.
pub(crate) fn tell(arm: &mut Controller, set: &Set) {
    let frame = FrameBuf::set(set, Ctrl::SET).expect("fits");
    arm.exchange(SIDE_LINK, frame.bytes());
}

/// Reads a value of the arm without the runner.
pub(crate) fn ask<L: Readable<Query = NoArgs>>(arm: &mut Controller) -> L {
    ask_with(arm, &NoArgs)
}

pub(crate) fn ask_with<L: Readable>(arm: &mut Controller, query: &L::Query) -> L {
    let frame = FrameBuf::get(query, L::ROW).expect("fits");
    let replies = arm.exchange(SIDE_LINK, frame.bytes());
    replies[0].frame().read().expect("its form")
}
