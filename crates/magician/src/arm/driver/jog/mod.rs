//! Jogs as decided by the gate: start, deadline, end, and notification of their guards.
//!
//! The [`Gate`](crate::gate::Gate) decides which jog may begin and when it ends, and why. The
//! driver has one timer for its deadline, reads where the arm's own jog is (`looks.rs`), and
//! repeats its stop until rest is confirmed (`ending.rs`). A bounded jog is sent and brought to
//! rest by its own task (`arm/bounded_jog`); the gate ends it like any other.

mod ending;
mod looks;

use tokio::sync::{oneshot, watch};
use tokio::time::Instant;

use self::ending::Ending;
use self::looks::Looks;
use super::explain::explain;
use super::{Driver, ReplyTarget};
use crate::arm::fenced_jog::FencedJog;
use crate::arm::jog::{Phase, Standstill};
use crate::build::Axis;
use crate::connection::{Failure, Micros, Request};
use crate::gate::{GateEffect, JogEnd, JogId, JogKind, JogRequest};
use crate::message;
use crate::{Error, ErrorCode, Result};

/// Longest time for an answer to the stop, or to a position read, before the driver repeats it.
/// Choice: three repetitions a second, as for [`Arm::stop_jog`](crate::Arm::stop_jog).
const ANSWER_TIMEOUT: Micros = 300_000;
/// Minimum hold time until the arm has answered the start of a jog, because its holder cannot renew
/// it before. Choice: two retransmissions fit.
const BEGIN_TIME: Micros = 600_000;

/// Request for a jog, and its first command.
pub(in crate::arm) struct JogStart {
    pub(in crate::arm) asks: JogRequest,
    /// `None` for a bounded jog: its task sends the pieces once this is answered.
    pub(in crate::arm) own: Option<OwnJog>,
    pub(in crate::arm) deadline: Instant,
    /// Stops before the request.
    pub(in crate::arm) stops: u64,
    pub(in crate::arm) phase: watch::Sender<Phase>,
    /// Closed if the caller gives up.
    pub(in crate::arm) reply: oneshot::Sender<Result<()>>,
}

/// Jog command of the arm.
pub(in crate::arm) struct OwnJog {
    pub(in crate::arm) request: Request,
    /// Bound by the fence; `None` if the jog does not reach it.
    pub(in crate::arm) fence: Option<FencedJog>,
}

impl JogStart {
    /// Returns the error for a request that a stop overtook.
    fn stopped(&self) -> Error {
        match &self.own {
            Some(own) => explain(&own.request.frame().frame(), Failure::Stopped),
            None => Error::new(
                ErrorCode::Stopped,
                message!("the jog was ended before it began"),
            ),
        }
    }
}

/// Jogs that the gate knows, and the driver's work on them.
#[derive(Default)]
pub(super) struct Jogging {
    known: Vec<TrackedJog>,
    looks: Option<Looks>,
    ending: Option<Ending>,
}

/// Jog that has not been reported as over.
struct TrackedJog {
    asks: JogRequest,
    phase: watch::Sender<Phase>,
    /// Pending start; `None` once the command was sent.
    start: Option<Box<JogStart>>,
}

impl TrackedJog {
    fn is_own(&self) -> bool {
        self.asks.kind == JogKind::Own
    }
}

impl Jogging {
    fn known(&mut self, jog: JogId) -> Option<&mut TrackedJog> {
        self.known.iter_mut().find(|known| known.asks.id == jog)
    }

    fn forget(&mut self, jog: JogId) -> Option<TrackedJog> {
        let at = self.known.iter().position(|known| known.asks.id == jog)?;
        Some(self.known.swap_remove(at))
    }
}

impl Driver {
    /// Returns the time at which a jog needs attention.
    pub(super) fn jog_timeout(&self) -> Option<Micros> {
        if let Some(ending) = &self.jogging.ending {
            return ending.poll_timeout();
        }
        let deadline = self.shared.gate().poll_timeout().map(|(at, _)| at);
        let looks = self.jogging.looks.as_ref();
        let looks = looks.and_then(Looks::poll_timeout);
        deadline.into_iter().chain(looks).min()
    }

    /// True while a jog is being renewed.
    pub(super) fn jog_runs(&self) -> bool {
        self.shared.gate().running().is_some()
    }

    /// True while the arm comes to rest after a jog.
    pub(super) fn jog_ends(&self) -> bool {
        self.shared.gate().is_ending()
    }

    pub(super) fn start_jog(&mut self, start: Box<JogStart>) {
        if start.reply.is_closed() {
            return;
        }
        if let Some(error) = self.refuse_jog(&start) {
            return drop(start.reply.send(Err(error)));
        }
        // An arm carries the speed of its current motion over to the axis of its own jog, so the
        // gate waits for rest. The pieces of a bounded jog are planned from rest anyway.
        let moves = start.own.is_some() && {
            let picture = self.shared.picture();
            picture.motion().is_moving() || picture.motion().is_braking()
        };
        let asks = start.asks;
        self.jogging.known.push(TrackedJog {
            asks,
            phase: start.phase.clone(),
            start: Some(start),
        });
        if moves {
            self.shared.gate().note_motion();
        }
        self.shared.gate().request(asks);
        self.carry_out_gate();
    }

    /// Returns the reason why a jog cannot begin, if any.
    fn refuse_jog(&mut self, start: &JogStart) -> Option<Error> {
        if start.stops != self.shared.stops() {
            return Some(start.stopped());
        }
        if !self.link_is_up() {
            return Some(self.gone());
        }
        let runs = self.runs_program();
        runs.then(|| {
            Error::new(
                ErrorCode::Busy,
                message!("a program runs: stop it before a jog"),
            )
        })
    }

    /// Carries out the decisions of the gate.
    pub(super) fn carry_out_gate(&mut self) {
        loop {
            let effect = self.shared.gate().poll_effect();
            let Some(effect) = effect else {
                break;
            };
            match effect {
                GateEffect::Begin(jog) => self.begin_jog(jog),
                GateEffect::End(jog, why) => self.end_motion(jog, why),
                GateEffect::Over(jog, why, seen) => {
                    let stands = if seen {
                        Standstill::Seen
                    } else {
                        Standstill::Unknown
                    };
                    if let Some(known) = self.jogging.forget(jog) {
                        known.phase.send_replace(Phase::Over(why, stands));
                    }
                }
                GateEffect::Refused(jog, why) => {
                    let known = self.jogging.forget(jog);
                    if let Some(start) = known.and_then(|known| known.start) {
                        let error = self.why_refused(&start, why);
                        // The caller may have given up.
                        let _ = start.reply.send(Err(error));
                    }
                }
            }
        }
        if !self.jog_ends() {
            self.jogging.ending = None;
        }
        if !self.jog_runs() {
            self.jogging.looks = None;
        }
    }

    fn end_motion(&mut self, jog: Option<JogId>, why: JogEnd) {
        self.jogging.looks = None;
        if why == JogEnd::NotKept {
            let name = &self.shared.name;
            tracing::warn!("{name}: the jog was not renewed; it is stopped");
        }
        let known = jog.and_then(|jog| self.jogging.known(jog));
        let mut ending = Some(Ending::default());
        if let Some(known) = known {
            known.phase.send_replace(Phase::Ending(why));
            // The task of a bounded jog stops it.
            ending = known
                .is_own()
                .then(|| Ending::of(known.asks.direction.axis));
        }
        self.jogging.ending = ending;
    }

    fn why_refused(&self, start: &JogStart, why: JogEnd) -> Error {
        match why {
            JogEnd::Replaced => Error::new(ErrorCode::RunOver, message!("another jog replaced it")),
            JogEnd::LinkLost => self.gone(),
            JogEnd::Closed => Error::closed(),
            JogEnd::Doubt => {
                let message = message!("the arm still moves after the jog before was stopped");
                Error::new(ErrorCode::StopUnconfirmed, message)
            }
            // Stopped, released or failed: for the caller all of them are an end before the
            // beginning.
            _ => start.stopped(),
        }
    }

    /// Begins a jog whose turn has come, unless something intervened.
    fn begin_jog(&mut self, jog: JogId) {
        let known = self.jogging.known(jog);
        let Some(start) = known.and_then(|known| known.start.take()) else {
            return self.shared.gate().not_begun(jog);
        };
        let refused = if start.reply.is_closed() {
            Some(start.stopped())
        } else {
            self.refuse_jog(&start)
        };
        if let Some(error) = refused {
            let _ = start.reply.send(Err(error));
            return self.shared.gate().not_begun(jog);
        }
        let JogStart {
            asks,
            own,
            deadline,
            reply,
            ..
        } = *start;
        let now = self.now();
        let until = now.saturating_add(asks.keep.max(BEGIN_TIME));
        self.shared.gate().hold(jog, until);
        let Some(OwnJog { request, fence }) = own else {
            return self.jog_began(Ok(()), reply, jog);
        };
        if let Some(fence) = &fence {
            let latest = fence.latest(now);
            self.shared.gate().bound(jog, latest, JogEnd::Fence);
        }
        let rail = asks.direction.axis == Axis::L;
        self.jogging.looks = Some(Looks::new(jog, rail, fence, now));
        self.submit(request, deadline, ReplyTarget::Jog(reply, jog));
    }

    /// Handles the answer to the start of a jog.
    pub(super) fn jog_began(
        &mut self,
        answer: Result<()>,
        to: oneshot::Sender<Result<()>>,
        jog: JogId,
    ) {
        let failed = answer.is_err();
        if !failed {
            // From here on its holder can renew it. An error means that it has ended meanwhile,
            // which stays so.
            let _ = self.shared.gate().keep(jog, self.now());
        }
        // A caller that has gone holds no guard, so nothing would renew the jog.
        if to.send(answer).is_err() || failed {
            self.shared.gate().end_one(jog, JogEnd::Failed);
            self.carry_out_gate();
        }
    }

    /// Ends all jogs requested so far, because a stop is sent.
    pub(super) fn stop_jogs(&mut self) {
        self.shared.gate().stop();
        self.carry_out_gate();
    }

    /// Ends any jog the arm may be in, whichever program started it.
    pub(super) fn end_any_jog(&mut self) {
        self.shared.gate().stop_any();
        self.carry_out_gate();
    }

    /// Marks the arm's own jog to be ended on the next line, because this one broke.
    pub(super) fn interrupt_jog(&mut self) {
        self.shared.gate().lose_line();
        self.carry_out_gate();
    }

    /// Ends all jogs with the connection.
    pub(super) fn close_jogs(&mut self) {
        self.shared.gate().close();
        self.carry_out_gate();
    }

    /// Ends a jog whose deadline has passed, reads its position, and continues ending it.
    pub(super) fn mind_jog(&mut self, now: Micros) {
        if self.jogging.known.is_empty() && self.jogging.ending.is_none() {
            return;
        }
        self.mind_deadline(now);
        self.look_at_jog(now);
        self.go_on_ending(now);
    }

    fn mind_deadline(&mut self, now: Micros) {
        self.shared.gate().handle_timeout(now);
        self.carry_out_gate();
    }
}
