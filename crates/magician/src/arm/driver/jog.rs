//! The watchdog of a jog, and its end.
//!
//! An end is said until it is certain: the stop past the queue, again when it is not answered, then poses, the stop again
//! while they differ, until two are equal. A line that is lost meanwhile is no end of that.

use std::sync::Arc;

use magician_protocol::commands::{JogCmd, Pose};
use magician_protocol::{Flag, FrameBuf, JogCommand, Layout, NoArgs};
use tokio::sync::oneshot;
use tokio::time::Instant;

use super::explain::explain;
use super::{Driver, To};
use crate::arm::jog::{Life, Phase, Stands, Why};
use crate::connection::{Failure, Micros, Priority, Request};
use crate::{Error, ErrorCode, Result};

/// How long an answer to the stop, or to a look at the pose, may take before it is said again.
const PATIENCE: Micros = 300_000;
/// Poses so far apart that are equal are those of an arm that stands.
const APART: Micros = 30_000;
/// How often one under a fence is looked at.
const LOOK: Micros = 40_000;
/// Pause after something that failed at once.
const PAUSE: Micros = 50_000;
/// A stop that was answered and has no effect for so long is said again.
const AGAIN: Micros = 500_000;
/// An arm that still moves so long after it answered the stop is moved by something else.
const BRAKING: Micros = 5_000_000;

/// A jog to begin.
pub(in crate::arm) struct JogStart {
    pub(in crate::arm) request: Request,
    pub(in crate::arm) deadline: Instant,
    /// Stops before this was begun.
    pub(in crate::arm) stops: u64,
    pub(in crate::arm) life: Arc<Life>,
    pub(in crate::arm) reply: oneshot::Sender<Result<FrameBuf>>,
}

/// The jog under way or being ended, and the one that waits for that end.
#[derive(Default)]
pub(super) struct Jogging {
    now: Option<Active>,
    next: Option<JogStart>,
}

struct Active {
    /// When it has to be stopped for the arm's fence, and when to look next where it is.
    until: Option<Micros>,
    look: Option<Micros>,
    /// `None`: a foreign jog that is to be ended.
    life: Option<Arc<Life>>,
    ending: Option<Ending>,
}

/// How far an end has come.
#[derive(Default)]
struct Ending {
    why: Option<Why>,
    /// A stop or a look is out.
    under_way: bool,
    /// The stop was not answered. A read comes before the next one: its answer proves that none to the lost stop can
    /// come, so that the next answer is known for what it is.
    unheard: bool,
    /// When to do the next thing.
    at: Micros,
    /// When the stop was answered last, and for the first time.
    said: Option<Micros>,
    first: Option<Micros>,
    pose: Option<Pose>,
}

impl Ending {
    /// Forgets what was said: it has to be said again.
    fn unsay(&mut self) {
        *self = Self {
            why: self.why,
            first: self.first,
            ..Self::default()
        };
    }
}

impl Active {
    fn tell(&self, phase: Phase) {
        if let Some(life) = &self.life {
            life.phase.send_replace(phase);
        }
    }

    fn over(&self, why: Why, stands: Stands) {
        self.tell(Phase::Over(why, stands));
    }
}

impl Jogging {
    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        let active = self.now.as_ref()?;
        match &active.ending {
            None => {
                let ends = active.life.as_ref().map(|life| life.ends());
                [ends, active.until, active.look]
                    .into_iter()
                    .flatten()
                    .min()
            }
            Some(ending) if ending.under_way => None,
            Some(ending) => Some(ending.at),
        }
    }

    /// Whether a jog is kept up.
    pub(super) fn runs(&self) -> bool {
        self.now.as_ref().is_some_and(|now| now.ending.is_none())
    }

    /// Whether a jog is being ended.
    pub(super) fn ends(&self) -> bool {
        self.now.is_some() && !self.runs()
    }

    /// The connection ends, and so do its jogs.
    pub(super) fn close(&mut self) {
        if let Some(active) = self.now.take() {
            active.over(Why::Closed, Stands::Unknown);
        }
        self.next = None;
    }
}

impl Driver {
    pub(super) fn start_jog(&mut self, start: JogStart) {
        let frame = start.request.frame().frame();
        if start.stops != self.shared.stops() {
            let error = explain(&frame, Failure::Stopped);
            return drop(start.reply.send(Err(error)));
        }
        if !self.link_is_up() {
            return drop(start.reply.send(Err(self.gone())));
        }
        // Its caller has given up meanwhile.
        if start.life.released() {
            return;
        }
        if self.runs_program() {
            let error = Error::new(ErrorCode::Busy, "a program runs: stop it before a jog");
            return drop(start.reply.send(Err(error)));
        }
        if self.jogging.now.is_some() && !self.jogging.runs() {
            if let Some(earlier) = self.jogging.next.replace(start) {
                let error = explain(&earlier.request.frame().frame(), Failure::Stopped);
                let _ = earlier.reply.send(Err(error));
            }
            return;
        }
        start.life.kept(self.now());
        let now = self.now();
        let fence = start.life.fence.as_ref();
        let active = Active {
            until: fence.map(|fence| fence.latest(now)),
            look: fence.map(|_| now.saturating_add(LOOK)),
            life: Some(Arc::clone(&start.life)),
            ending: None,
        };
        if let Some(before) = self.jogging.now.replace(active) {
            before.over(Why::Replaced, Stands::Unknown);
        }
        self.submit(
            start.request,
            start.deadline,
            To::Jog(start.reply, start.life),
        );
    }

    /// The arm has answered to the beginning of a jog, or not.
    pub(super) fn jog_began(
        &mut self,
        answer: Result<FrameBuf>,
        to: oneshot::Sender<Result<FrameBuf>>,
        life: &Arc<Life>,
    ) {
        let failed = answer.is_err();
        let unheard = to.send(answer).is_err();
        let active = self.jogging.now.as_ref();
        let runs = active.and_then(|active| active.life.as_ref());
        // Another jog may have taken its place.
        if (failed || unheard) && runs.is_some_and(|runs| Arc::ptr_eq(runs, life)) {
            self.end_jog(Why::Failed);
        }
    }

    /// Ends the jog that runs, if one does.
    pub(super) fn end_jog(&mut self, why: Why) {
        if let Some(active) = &mut self.jogging.now
            && active.ending.is_none()
        {
            active.ending = Some(Ending {
                why: Some(why),
                ..Ending::default()
            });
            active.tell(Phase::Ending(why));
        }
    }

    /// Ends whatever jog the arm may be in, of whomever.
    pub(super) fn end_any_jog(&mut self) {
        self.jogging.now.get_or_insert_with(|| Active {
            until: None,
            look: None,
            life: None,
            ending: Some(Ending::default()),
        });
        self.end_jog(Why::Stopped);
    }

    /// The line broke: a jog that ran has to be ended over the next.
    pub(super) fn interrupt_jog(&mut self) {
        self.end_jog(Why::LinkLost);
        if let Some(active) = &mut self.jogging.now {
            // Its guard waits for no line.
            if let Some(life) = active.life.take() {
                let why = active.ending.as_ref().and_then(|ending| ending.why);
                let why = why
                    .filter(|why| *why != Why::Released)
                    .unwrap_or(Why::LinkLost);
                let phase = Phase::Over(why, Stands::Unknown);
                life.phase.send_replace(phase);
            }
            active.ending.get_or_insert_default().unsay();
        }
        if let Some(next) = self.jogging.next.take() {
            let _ = next.reply.send(Err(self.gone()));
        }
    }

    /// Looks whether the jog is kept up, and goes on with ending it.
    pub(super) fn mind_jog(&mut self, now: Micros) {
        let Some(active) = &mut self.jogging.now else {
            return;
        };
        match (&active.life, &mut active.ending) {
            (Some(life), None) if life.released() => self.end_jog(Why::Released),
            (Some(life), None) if life.ends() <= now => {
                tracing::warn!(
                    "{}: the jog was not renewed; it is stopped",
                    self.shared.name
                );
                self.end_jog(Why::NotKept);
            }
            (Some(_), None) if active.until.is_some_and(|until| until <= now) => {
                self.end_jog(Why::Fence);
            }
            (Some(_), None) if active.look.is_some_and(|at| at <= now) => self.look_at_jog(now),
            _ => {}
        }
        self.go_on_ending(now);
    }

    /// Looks where a jog under a fence is: an arm that is faster than it says has to stop sooner.
    fn look_at_jog(&mut self, now: Micros) {
        if let Some(active) = &mut self.jogging.now {
            active.look = None;
        }
        let deadline = self.at(now.saturating_add(PATIENCE));
        if let Ok(request) = Request::get::<Pose>(&NoArgs) {
            self.submit(request, deadline, To::JogLook(now));
        }
    }

    /// Its position, as of the request; without a reply it cannot be kept from the fence.
    pub(super) fn jog_seen(&mut self, answer: Result<FrameBuf>, asked: Micros) {
        let now = self.now();
        let Some(active) = &mut self.jogging.now else {
            return;
        };
        let Some(life) = active.life.as_ref().filter(|_| active.ending.is_none()) else {
            return;
        };
        let pose = answer.ok();
        let pose = pose.and_then(|reply| Pose::decode(reply.frame().params()).ok());
        match life.fence.as_ref().zip(pose) {
            Some((fence, pose)) => {
                let latest = fence.latest_after(asked, &pose);
                active.until = active.until.map(|until| until.min(latest));
                active.look = Some(now.saturating_add(LOOK));
            }
            None => self.end_jog(Why::Fence),
        }
    }

    fn go_on_ending(&mut self, now: Micros) {
        let ending = self
            .jogging
            .now
            .as_mut()
            .and_then(|active| active.ending.as_mut());
        let Some(ending) = ending.filter(|ending| !ending.under_way && ending.at <= now) else {
            return;
        };
        ending.under_way = true;
        let look = ending.said.is_some() || ending.unheard;
        let deadline = self.at(now.saturating_add(PATIENCE));
        let (request, to) = match look {
            false => (stop(), To::JogStop),
            true => (Request::get::<Pose>(&NoArgs), To::JogPose),
        };
        if let Ok(request) = request {
            self.submit(request, deadline, to);
        }
    }

    /// The stop of a jog was answered, or not.
    pub(super) fn jog_stopped(&mut self, answer: Result<FrameBuf>) {
        let now = self.now();
        let Some(ending) = self.ending() else {
            return;
        };
        ending.under_way = false;
        match answer {
            Ok(_) => {
                ending.said = Some(now);
                ending.first.get_or_insert(now);
                ending.at = now;
            }
            Err(_) => {
                ending.unheard = true;
                ending.at = now.saturating_add(PAUSE);
            }
        }
    }

    /// A look at where the arm is has ended.
    pub(super) fn jog_pose(&mut self, answer: Result<FrameBuf>) {
        let now = self.now();
        let Some(ending) = self.ending() else {
            return;
        };
        ending.under_way = false;
        let pose = answer
            .ok()
            .and_then(|reply| Pose::decode(reply.frame().params()).ok());
        let Some(pose) = pose else {
            // Perhaps the stop gets through.
            ending.unheard = false;
            ending.at = now.saturating_add(PAUSE);
            return;
        };
        if ending.said.is_none() {
            (ending.unheard, ending.at) = (false, now);
            return;
        }
        if ending.pose.replace(pose) == Some(pose) {
            return self.jog_is_over(Stands::Seen);
        }
        let since = |at: Option<Micros>| at.map_or(0, |at| now.saturating_sub(at));
        if since(ending.first) >= BRAKING {
            tracing::warn!(
                "{}: the arm still moves after a jog was stopped",
                self.shared.name
            );
            return self.jog_is_over(Stands::Unknown);
        }
        if since(ending.said) >= AGAIN {
            ending.unsay();
        }
        ending.at = now.saturating_add(APART);
    }

    fn ending(&mut self) -> Option<&mut Ending> {
        self.jogging.now.as_mut()?.ending.as_mut()
    }

    fn jog_is_over(&mut self, stands: Stands) {
        if stands == Stands::Seen {
            self.in_flight().stands_still();
        }
        if let Some(active) = self.jogging.now.take() {
            let why = active.ending.as_ref().and_then(|ending| ending.why);
            active.over(why.unwrap_or(Why::Stopped), stands);
        }
        if let Some(next) = self.jogging.next.take() {
            self.start_jog(next);
        }
    }
}

/// The end of a jog, past the queue: a queued one would sit behind an alarm while the arm moves on.
fn stop() -> Result<Request, magician_protocol::EncodeError> {
    let stop = JogCmd {
        is_joint: Flag::OFF,
        cmd: JogCommand::Stop,
    };
    Ok(Request::set(&stop)?.priority(Priority::Stop))
}
