//! The jog under way, its watchdog and its end, as the gate decides.
//!
//! The driver repeats the stop of a jog until it is certain: past the queue, again when it is not answered, then poses, the stop
//! again while they differ, until they are those of an arm at rest. A line that is lost meanwhile does not end that.

use std::sync::Arc;

use magician_protocol::commands::{JogCmd, Pose, PoseL};
use magician_protocol::{Flag, FrameBuf, JogCommand, Layout, NoArgs};
use tokio::sync::oneshot;
use tokio::time::Instant;

use super::explain::explain;
use super::{Driver, To};
use crate::arm::jog::{Life, Phase, Stands};
use crate::build::{Axis, JogDirection};
use crate::connection::{Failure, Micros, Priority, Request};
use crate::gate::{GateEffect, Holder, JogEnd, JogId, JogRequest};
use crate::{Error, ErrorCode, REST_READ_INTERVAL, RestDetector, Result};

/// How long an answer to the stop, or to a look at the pose, may take before it is said again.
const PATIENCE: Micros = 300_000;
/// Interval of position reads during a jog under a fence.
const FENCED_LOOK_INTERVAL: Micros = 40_000;
/// Interval of position reads during any other jog: a read costs 10 ms of a serial line, and three show an arm that stands at
/// the end of its axis.
const LOOK_INTERVAL: Micros = 200_000;
/// Shortest time between two reads that are compared. The controller moves in periods of 20 ms, and the slowest jog (1 % of 1 mm/s)
/// by more than binary32 resolves.
const STUCK_TIME: Micros = 180_000;
/// Reads in succession that are equal to the one before when a jog does not move. One is not enough: a jog that turns round
/// passes each place twice, at equal times before and after its turning point.
const STUCK_READS: u32 = 2;
/// A jog that was not answered is kept up for so long at least: its holder cannot keep up what it does not have yet.
const BEGIN_TIME: Micros = 600_000;
/// Pause after something that failed at once.
const PAUSE: Micros = 50_000;
/// A stop that was answered and has no effect for so long is said again.
const AGAIN: Micros = 500_000;
/// An arm that still moves so long after it answered the stop is moved by something else.
const BRAKING: Micros = 5_000_000;

/// The holder of all guards of a connection: each of them may turn round on its axis what another one began.
const GUARDS: Holder = Holder(0);

/// A jog to begin.
pub(in crate::arm) struct JogStart {
    pub(in crate::arm) request: Request,
    pub(in crate::arm) direction: JogDirection,
    pub(in crate::arm) deadline: Instant,
    /// Stops before this was begun.
    pub(in crate::arm) stops: u64,
    pub(in crate::arm) life: Arc<Life>,
    pub(in crate::arm) reply: oneshot::Sender<Result<FrameBuf>>,
}

/// The jogs that the gate knows, and what the driver does about them.
#[derive(Default)]
pub(super) struct Jogging {
    known: Vec<Known>,
    looks: Option<Looks>,
    ending: Option<Ending>,
}

/// A jog that the gate has not said to be over.
struct Known {
    life: Arc<Life>,
    /// `None` once its command went out.
    start: Option<JogStart>,
}

/// Looks at where a jog under way is.
struct Looks {
    jog: JogId,
    /// True if it moves the rail, which the pose does not show.
    rail: bool,
    /// When it has to be stopped for the arm's fence.
    until: Option<Micros>,
    /// When to look next; `None` while a look is out.
    at: Option<Micros>,
    interval: Micros,
    /// Last position that was compared, and when it was read.
    seen: Option<(Place, Micros)>,
    /// How many reads in succession were equal to the one before.
    equal: u32,
}

/// Position during a jog: the pose, or the position on the rail.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Arm(Pose),
    Rail(f32),
}

/// How far an end has come.
#[derive(Default)]
struct Ending {
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
    rest: RestDetector,
}

impl Ending {
    /// Forgets what was said: it has to be said again.
    fn unsay(&mut self) {
        *self = Self {
            first: self.first,
            ..Self::default()
        };
    }
}

impl Jogging {
    fn known(&self, jog: JogId) -> Option<&Known> {
        self.known.iter().find(|known| known.life.id == jog)
    }

    fn forget(&mut self, jog: JogId) -> Option<Known> {
        let at = self.known.iter().position(|known| known.life.id == jog)?;
        Some(self.known.swap_remove(at))
    }
}

impl Driver {
    /// When a jog has to be looked after.
    pub(super) fn jog_timeout(&self) -> Option<Micros> {
        if let Some(ending) = &self.jogging.ending {
            return (!ending.under_way).then_some(ending.at);
        }
        let running = self.shared.gate().running()?;
        let ends = self.jogging.known(running).map(|known| known.life.ends());
        let looks = self.jogging.looks.as_ref();
        let looks = looks.map_or([None, None], |looks| [looks.until, looks.at]);
        ends.into_iter().chain(looks.into_iter().flatten()).min()
    }

    /// True while a jog is kept up.
    pub(super) fn jog_runs(&self) -> bool {
        self.shared.gate().running().is_some()
    }

    /// True while the arm comes to rest after a jog.
    pub(super) fn jog_ends(&self) -> bool {
        self.shared.gate().is_ending()
    }

    pub(super) fn start_jog(&mut self, start: JogStart) {
        // Its caller has given up meanwhile.
        if start.life.released() {
            return;
        }
        if let Some(error) = self.refuse_jog(&start) {
            return drop(start.reply.send(Err(error)));
        }
        let request = JogRequest {
            id: start.life.id,
            holder: GUARDS,
            direction: start.direction,
        };
        self.jogging.known.push(Known {
            life: Arc::clone(&start.life),
            start: Some(start),
        });
        // The speed of whatever moves the arm would go over to the axis of the jog.
        let moves = {
            let picture = self.shared.picture();
            picture.motion().is_moving() || picture.motion().is_braking()
        };
        if moves {
            self.shared.gate().moves();
        }
        self.shared.gate().ask(request);
        self.carry_out_gate();
    }

    /// Why a jog cannot begin, if it cannot.
    fn refuse_jog(&mut self, start: &JogStart) -> Option<Error> {
        if start.stops != self.shared.stops() {
            let frame = start.request.frame().frame();
            return Some(explain(&frame, Failure::Stopped));
        }
        if !self.link_is_up() {
            return Some(self.gone());
        }
        let runs = self.runs_program();
        runs.then(|| Error::new(ErrorCode::Busy, "a program runs: stop it before a jog"))
    }

    /// Does what the gate has decided.
    pub(super) fn carry_out_gate(&mut self) {
        loop {
            let effect = self.shared.gate().poll_effect();
            let Some(effect) = effect else {
                break;
            };
            match effect {
                GateEffect::Begin(jog) => self.begin_jog(jog),
                GateEffect::End(jog, why) => {
                    self.jogging.looks = None;
                    self.jogging.ending = Some(Ending::default());
                    if let Some(known) = jog.and_then(|jog| self.jogging.known(jog)) {
                        known.life.phase.send_replace(Phase::Ending(why));
                    }
                }
                GateEffect::Over(jog, why, seen) => {
                    let stands = if seen { Stands::Seen } else { Stands::Unknown };
                    if let Some(known) = self.jogging.forget(jog) {
                        let phase = Phase::Over(why, stands);
                        known.life.phase.send_replace(phase);
                    }
                }
                GateEffect::Refused(jog, why) => {
                    let known = self.jogging.forget(jog);
                    if let Some(start) = known.and_then(|known| known.start) {
                        let error = self.why_refused(&start, why);
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

    fn why_refused(&self, start: &JogStart, why: JogEnd) -> Error {
        match why {
            JogEnd::Replaced => Error::new(ErrorCode::RunOver, "another jog replaced it"),
            JogEnd::LinkLost => self.gone(),
            JogEnd::Closed => Error::closed(),
            JogEnd::Doubt => {
                let message = "the arm still moves after the jog before was stopped";
                Error::new(ErrorCode::StopUnconfirmed, message)
            }
            _ => explain(&start.request.frame().frame(), Failure::Stopped),
        }
    }

    /// Sends the command of a jog whose turn has come, unless something came in between.
    fn begin_jog(&mut self, jog: JogId) {
        let mut known = self.jogging.known.iter_mut();
        let known = known.find(|known| known.life.id == jog);
        let Some(start) = known.and_then(|known| known.start.take()) else {
            return self.shared.gate().not_begun(jog);
        };
        let refused = if start.life.released() {
            Some(explain(&start.request.frame().frame(), Failure::Stopped))
        } else {
            self.refuse_jog(&start)
        };
        if let Some(error) = refused {
            let _ = start.reply.send(Err(error));
            return self.shared.gate().not_begun(jog);
        }
        let now = self.now();
        let life = &start.life;
        life.kept(now.saturating_add(BEGIN_TIME.saturating_sub(life.keep)));
        self.shared.gate().kept(jog, life.ends());
        let fence = life.fence.as_ref();
        let interval = match fence {
            Some(_) => FENCED_LOOK_INTERVAL,
            None => LOOK_INTERVAL,
        };
        self.jogging.looks = Some(Looks {
            jog,
            rail: start.direction.axis == Axis::L,
            until: fence.map(|fence| fence.latest(now)),
            at: Some(now.saturating_add(interval)),
            interval,
            seen: None,
            equal: 0,
        });
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
        if !failed {
            // From here on its holder can keep it up.
            life.kept(self.now());
        }
        if to.send(answer).is_err() || failed {
            self.end_jog(life.id, JogEnd::Failed);
        }
    }

    fn end_jog(&mut self, jog: JogId, why: JogEnd) {
        self.shared.gate().end_one(jog, why);
        self.carry_out_gate();
    }

    /// A stop goes out: no jog that was asked for before goes on or begins.
    pub(super) fn stop_jogs(&mut self) {
        self.shared.gate().stop();
        self.carry_out_gate();
    }

    /// Ends whatever jog the arm may be in, of whomever.
    pub(super) fn end_any_jog(&mut self) {
        self.shared.gate().stop_any();
        self.carry_out_gate();
    }

    /// The line broke: a jog that ran has to be ended over the next.
    pub(super) fn interrupt_jog(&mut self) {
        self.shared.gate().lose_line();
        self.carry_out_gate();
    }

    /// The connection ends, and so do its jogs.
    pub(super) fn close_jogs(&mut self) {
        self.shared.gate().close();
        self.carry_out_gate();
    }

    /// Looks whether the jog is kept up, and goes on with ending it.
    pub(super) fn mind_jog(&mut self, now: Micros) {
        if self.jogging.known.is_empty() && self.jogging.ending.is_none() {
            return;
        }
        {
            let mut gate = self.shared.gate();
            for Known { life, .. } in &self.jogging.known {
                if life.released() {
                    gate.release(life.id)
                } else {
                    gate.kept(life.id, life.ends())
                }
            }
            if gate.poll_timeout().is_some_and(|at| at <= now) {
                let name = &self.shared.name;
                tracing::warn!("{name}: the jog was not renewed; it is stopped");
            }
            gate.handle_timeout(now);
        }
        self.carry_out_gate();
        if let Some(looks) = &mut self.jogging.looks {
            let jog = looks.jog;
            if looks.until.is_some_and(|until| until <= now) {
                self.end_jog(jog, JogEnd::Fence);
            } else if looks.at.is_some_and(|at| at <= now) {
                looks.at = None;
                let rail = looks.rail;
                self.look_at_jog(now, jog, rail);
            }
        }
        self.go_on_ending(now);
    }

    /// Looks where a jog is: one that does not move any more has come to the end of its axis, and an arm under a fence that
    /// is faster than it says has to stop sooner.
    fn look_at_jog(&mut self, now: Micros, jog: JogId, rail: bool) {
        let deadline = self.at(now.saturating_add(PATIENCE));
        let request = if rail {
            Request::get::<PoseL>(&NoArgs)
        } else {
            Request::get::<Pose>(&NoArgs)
        };
        if let Ok(request) = request {
            self.submit(request, deadline, To::JogLook(jog, now));
        }
    }

    /// Its position, as of the request; without a reply it cannot be kept from the fence.
    pub(super) fn jog_seen(&mut self, answer: Result<FrameBuf>, jog: JogId, asked: Micros) {
        let now = self.now();
        let looks = self.jogging.looks.as_mut();
        let Some(looks) = looks.filter(|looks| looks.jog == jog) else {
            return;
        };
        let place = answer.ok().and_then(|reply| {
            let reply = reply.frame();
            if looks.rail {
                let at = PoseL::decode(reply.params()).ok();
                at.map(|at| Place::Rail(at.pose_l))
            } else {
                Pose::decode(reply.params()).ok().map(Place::Arm)
            }
        });
        looks.at = Some(now.saturating_add(looks.interval));
        match (place, looks.seen) {
            (Some(place), Some((before, at))) if now.saturating_sub(at) >= STUCK_TIME => {
                looks.equal = if place == before { looks.equal + 1 } else { 0 };
                looks.seen = Some((place, now));
            }
            (Some(place), None) => looks.seen = Some((place, now)),
            _ => {}
        }
        if looks.equal >= STUCK_READS {
            return self.end_jog(jog, JogEnd::Limit);
        }
        let fence = self.jogging.known.iter().find(|one| one.life.id == jog);
        let Some(fence) = fence.and_then(|known| known.life.fence.as_ref()) else {
            return;
        };
        match place {
            Some(Place::Arm(pose)) => {
                let latest = fence.latest_after(asked, &pose);
                looks.until = looks.until.map(|until| until.min(latest));
            }
            // A fence bounds no rail: what it bounds is where the arm is.
            Some(Place::Rail(_)) => {}
            None => self.end_jog(jog, JogEnd::Fence),
        }
    }

    fn go_on_ending(&mut self, now: Micros) {
        let ending = self.ending();
        let Some(ending) = ending.filter(|ending| !ending.under_way && ending.at <= now) else {
            return;
        };
        ending.under_way = true;
        let look = ending.said.is_some() || ending.unheard;
        let deadline = self.at(now.saturating_add(PATIENCE));
        let (request, to) = if look {
            (Request::get::<Pose>(&NoArgs), To::JogPose)
        } else {
            (stop(), To::JogStop)
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
        if ending.rest.see(now, pose) {
            return self.jog_is_over(true);
        }
        let since = |at: Option<Micros>| at.map_or(0, |at| now.saturating_sub(at));
        if since(ending.first) >= BRAKING {
            tracing::warn!(
                "{}: the arm still moves after a jog was stopped",
                self.shared.name
            );
            return self.jog_is_over(false);
        }
        if since(ending.said) >= AGAIN {
            ending.unsay();
        }
        ending.at = now.saturating_add(REST_READ_INTERVAL);
    }

    fn ending(&mut self) -> Option<&mut Ending> {
        self.jogging.ending.as_mut()
    }

    fn jog_is_over(&mut self, seen: bool) {
        if seen {
            let stops = self.shared.picture().motion().stops();
            self.shared.stood_after(stops);
        }
        self.shared.gate().rested(seen);
        self.carry_out_gate();
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
