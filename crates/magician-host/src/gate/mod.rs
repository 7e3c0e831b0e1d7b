//! The motion gate: decides when motion that does not end by itself may begin, and makes sure that
//! it ends.
//!
//! A jog ([`JogCmd`](magician_protocol::commands::JogCmd)) continues to the end of its axis, a
//! conveyor or stepper for ever, and the arm has no watchdog. So every such motion passes through a
//! [`Gate`], which knows its holder and, for a jog, its deadline. Its rules:
//!
//! * **Rest between jogs.** A real arm carries the signed speed of a jog over to the axis of the
//!   next one and first moves that axis the wrong way, by v^2/2a: 7.5 to 30 mm. A jog of another
//!   axis, frame or holder starts only when the arm was seen at rest after the stop. The same
//!   holder may reverse on the same axis: there the arm ramps through zero.
//! * **A holder.** A motion ends with its holder: when it releases the motion, stops keeping it up,
//!   or goes away.
//! * **One deadline.** A jog ends at the earliest of the end of its hold time, the arm's fence and
//!   the end of its axis, and reports that reason. [`Gate::poll_timeout`] is that instant, and the
//!   caller needs no other timer. Keeping a jog up too late does not revive it, and a later bound
//!   does not extend it.
//! * **A stop is final.** Nothing that was started before a stop runs after it, whoever started it.
//! * **A release is final.** A jog released while it waits for the arm to come to rest does not
//!   start.
//!
//! There are two kinds of jogs ([`JogKind`]), and measurements on the virtual arm
//! (docs/evidence/MEASUREMENTS.md, "Jogs") show that neither can replace the other. The arm has no
//! path in joint space, so a joint rests between pieces: J1 falls to 10 % of full speed there.
//! Pieces also start 5 to 16 times later, and in a Cartesian jog they take 12 to 25 times as many
//! requests. But the arm's own jog continues when the program dies. A fence is not a third kind,
//! but a bound on the arm's own jog.
//!
//! The laser has a separate mechanism with the same purpose: burning needs a permission, and
//! every end switches the laser off (see [`burns`](fn@crate::burns) and
//! [`ArmPicture::may_be_lit`](crate::ArmPicture::may_be_lit)). It does not pass through the gate,
//! because a burning path is queued together with its end.
//!
//! The gate has no clock and does no I/O: the caller supplies the time and carries out the
//! [`GateEffect`]s in order. The whole state is plain values, so that tests can explore every
//! interleaving (`tests/gate`).

mod deadline;
mod motors;

use std::collections::VecDeque;

use magician_protocol::Frame;

use crate::build::JogDirection;
use crate::connection::Micros;
use crate::message;
use crate::{Action, Error, ErrorCode, Result};

use self::deadline::Deadline;
pub(crate) use self::motors::switches_off;
pub use self::motors::{Motors, OUTPUTS, turns_motor};

/// Identifier of a jog, unique for each request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct JogId(pub u64);

/// Owner of a jog: a program with its guards, another program whose frames are passed on, or a
/// session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Holder(pub u64);

/// Behaviour of a jog on the arm if nothing more is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JogKind {
    /// The arm's own jog: continues to the end of its axis. If the line breaks, its stop is sent
    /// over the next line.
    Own,
    /// Pieces in the arm's queue: they end by themselves, and their sender stops them and waits for
    /// the arm to rest.
    Pieces,
}

/// Request for a jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct JogRequest {
    /// Identifier of the jog.
    pub id: JogId,
    /// Owner of the jog.
    pub holder: Holder,
    /// Axis and direction; the axis implies the frame.
    pub direction: JogDirection,
    /// Hold time: how long the jog continues after it was last kept up, us.
    pub keep: Micros,
    /// Kind of the jog.
    pub kind: JogKind,
}

/// Reason for the end of a jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JogEnd {
    /// The holder released it, or its guard was dropped.
    Released,
    /// The holder did not keep it up in time.
    NotKept,
    /// The arm did not confirm the beginning.
    Failed,
    /// The arm's state is unknown: a reply was lost, or the arm was not seen at rest.
    Doubt,
    /// The end of the axis was reached.
    Limit,
    /// A stop was sent.
    Stopped,
    /// The arm's fence is near.
    Fence,
    /// Another jog takes its place.
    Replaced,
    /// The line broke.
    LinkLost,
    /// The connection ended.
    Closed,
}

/// Action that follows from a decision. The caller carries them out in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GateEffect {
    /// Send the command of this jog now, then set its hold time by [`Gate::hold`].
    Begin(JogId),
    /// Send the stop of a jog, repeatedly until the arm is at rest; then call
    /// [`Gate::finish_stop`].
    End(Option<JogId>, JogEnd),
    /// A jog is over. True if the arm was seen at rest.
    Over(JogId, JogEnd, bool),
    /// A jog that waited for the arm to come to rest does not begin.
    Refused(JogId, JogEnd),
}

/// A jog in motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Running {
    request: JogRequest,
    /// True if it reverses the previous jog: if its command is lost, the arm continues in that
    /// direction.
    reverses: bool,
}

/// State of the arm outside its queue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
enum Motion {
    /// At rest, as far as is known.
    #[default]
    Rest,
    /// A jog, with its deadline.
    Jog(Running, Deadline),
    /// A motion without a holder here: a jog passed on for another program, another motion, or an
    /// arm that was not seen to come to rest.
    Unheld,
    /// A stop is on its way, or the arm brakes.
    Ending(Option<JogRequest>, JogEnd),
}

/// State machine of motions without an end of their own; see the [module](self).
///
/// ```
/// use magician_host::gate::{Gate, GateEffect, Holder, JogEnd, JogId, JogKind, JogRequest};
/// use magician_host::build::Axis;
///
/// let mut gate = Gate::new();
/// let jog = |id, direction| JogRequest {
///     id: JogId(id),
///     holder: Holder(0),
///     direction,
///     keep: 300_000,
///     kind: JogKind::Own,
/// };
/// gate.request(jog(1, Axis::X.plus()));
/// assert_eq!(gate.poll_effect(), Some(GateEffect::Begin(JogId(1))));
/// gate.hold(JogId(1), 600_000);
/// // The holder keeps it up, but the fence is reached first.
/// assert_eq!(gate.keep(JogId(1), 500_000), Ok(()));
/// gate.bound(JogId(1), 700_000, JogEnd::Fence);
/// assert_eq!(gate.poll_timeout(), Some((700_000, JogEnd::Fence)));
/// // Another axis must wait for the arm to come to rest.
/// gate.request(jog(2, Axis::Z.plus()));
/// assert!(matches!(gate.poll_effect(), Some(GateEffect::End(..))));
/// assert_eq!(gate.poll_effect(), None);
/// gate.finish_stop(true);
/// assert!(matches!(gate.poll_effect(), Some(GateEffect::Over(JogId(1), _, true))));
/// assert_eq!(gate.poll_effect(), Some(GateEffect::Begin(JogId(2))));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Gate {
    motion: Motion,
    /// Jog that begins when the arm has come to rest.
    waiting: Option<JogRequest>,
    effects: VecDeque<GateEffect>,
}

/// Jogs.
impl Gate {
    /// Creates the gate of an arm at rest.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the next effect, oldest first. `None` if all were returned.
    pub fn poll_effect(&mut self) -> Option<GateEffect> {
        self.effects.pop_front()
    }

    /// Requests a jog. It begins at once if the arm is at rest or if it reverses a jog of the same
    /// holder, otherwise when the arm has come to rest.
    pub fn request(&mut self, request: JogRequest) {
        match self.motion {
            Motion::Rest => self.begin(request, false),
            // The arm ramps through zero by itself, without a stop in between.
            Motion::Jog(running, _) if is_reversal(&running.request, &request) => {
                let over = GateEffect::Over(running.request.id, JogEnd::Replaced, false);
                self.effects.push_back(over);
                self.begin(request, true);
            }
            Motion::Jog(..) | Motion::Unheld => {
                self.end(JogEnd::Replaced);
                self.waiting = Some(request);
            }
            Motion::Ending(..) => {
                // Only the latest request waits: the user has changed direction again meanwhile.
                self.refuse_waiting(JogEnd::Replaced);
                self.waiting = Some(request);
            }
        }
    }

    /// Sets the end of the hold time for a jog that begins, because its holder cannot keep it up
    /// before the arm has replied.
    pub fn hold(&mut self, jog: JogId, until: Micros) {
        if let Some(deadline) = self.deadline_of(jog) {
            deadline.keep_until(until);
        }
    }

    /// Keeps a jog up for its hold time from `now`.
    ///
    /// # Errors
    /// Reason why the jog ends or is ending; `None` if it is not in motion.
    pub fn keep(&mut self, jog: JogId, now: Micros) -> Result<(), Option<JogEnd>> {
        match &mut self.motion {
            Motion::Jog(Running { request, .. }, deadline) if request.id == jog => {
                // Also if the caller has not called `handle_timeout` yet.
                if let Some(why) = deadline.passed(now) {
                    return Err(Some(why));
                }
                deadline.keep_until(now.saturating_add(request.keep));
                Ok(())
            }
            Motion::Ending(Some(request), why) if request.id == jog => Err(Some(*why)),
            // Unknown here: over long ago, or still waiting.
            _ => Err(None),
        }
    }

    /// Bounds a jog: it ends at `at` at the latest, for the given reason.
    pub fn bound(&mut self, jog: JogId, at: Micros, why: JogEnd) {
        if let Some(deadline) = self.deadline_of(jog) {
            deadline.bound(at, why);
        }
    }

    fn deadline_of(&mut self, jog: JogId) -> Option<&mut Deadline> {
        match &mut self.motion {
            Motion::Jog(running, deadline) if running.request.id == jog => Some(deadline),
            _ => None,
        }
    }

    /// Releases a jog: if it waits it does not begin, and if it moves it ends.
    pub fn release(&mut self, jog: JogId) {
        if self.waiting.is_some_and(|waiting| waiting.id == jog) {
            self.refuse_waiting(JogEnd::Released);
        }
        self.end_one(jog, JogEnd::Released);
    }

    /// Ends this jog, if it is the one in motion.
    pub fn end_one(&mut self, jog: JogId, why: JogEnd) {
        if self.running() == Some(jog) {
            self.end(why);
        }
    }

    /// Notes that the command of a jog was not sent after [`GateEffect::Begin`]: the arm does what
    /// it did before.
    pub fn not_begun(&mut self, jog: JogId) {
        let Motion::Jog(running, _) = self.motion else {
            return;
        };
        if running.request.id == jog {
            let refused = GateEffect::Refused(jog, JogEnd::Stopped);
            self.effects.push_back(refused);
            // The arm is still in the reversed jog, which has no holder any more: stop it.
            if running.reverses {
                self.ends(None, JogEnd::Stopped);
            } else {
                self.motion = Motion::Rest;
            }
        }
    }

    /// Ends the jog whose deadline has passed at `now`.
    pub fn handle_timeout(&mut self, now: Micros) {
        if let Motion::Jog(_, deadline) = self.motion
            && let Some(why) = deadline.passed(now)
        {
            self.end(why);
        }
    }

    /// Instant at which [`handle_timeout`](Self::handle_timeout) is due, and the reason for the
    /// end. `None` without a jog.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<(Micros, JogEnd)> {
        match self.motion {
            Motion::Jog(_, deadline) => Some(deadline.next()),
            _ => None,
        }
    }

    /// Returns the same state with instants relative to `now`, so that states with the same future
    /// are equal.
    #[must_use]
    pub fn rebased(&self, now: Micros) -> Self {
        let mut gate = self.clone();
        if let Motion::Jog(_, deadline) = &mut gate.motion {
            *deadline = deadline.rebased(now);
        }
        gate
    }

    /// Notes that a stop is sent: the jog ends, and no earlier request begins. The caller switches
    /// off [`OUTPUTS`] too.
    pub fn stop(&mut self) {
        self.refuse_waiting(JogEnd::Stopped);
        self.end(JogEnd::Stopped);
    }

    /// Does the same as [`stop`](Self::stop) for an arm that may be in a jog unknown to the gate.
    pub fn stop_any(&mut self) {
        self.stop();
        if matches!(self.motion, Motion::Rest | Motion::Unheld) {
            self.ends(None, JogEnd::Stopped);
        }
    }

    /// Notes that the arm has come to rest after [`GateEffect::End`].
    ///
    /// `seen` is false if it was not seen to come to rest. A waiting jog then does not begin, and
    /// the next request tries again.
    pub fn finish_stop(&mut self, seen: bool) {
        // A late report of rest, after the state has moved on.
        let Motion::Ending(jog, why) = self.motion else {
            return;
        };
        self.motion = if seen { Motion::Rest } else { Motion::Unheld };
        if let Some(jog) = jog {
            self.effects.push_back(GateEffect::Over(jog.id, why, seen));
        }
        match self.waiting.take() {
            // Rest was seen, so the next jog cannot inherit the old speed.
            Some(waiting) if seen => self.begin(waiting, false),
            Some(waiting) => {
                let refused = GateEffect::Refused(waiting.id, JogEnd::Doubt);
                self.effects.push_back(refused);
            }
            None => {}
        }
    }

    /// Notes that the arm may move by something other than a jog, or brake after a stop: the next
    /// jog waits for rest.
    pub fn note_motion(&mut self) {
        // A jog or an ending already implies motion.
        if self.motion == Motion::Rest {
            self.motion = Motion::Unheld;
        }
    }

    /// Notes that a caller has seen the arm at rest: a jog that was passed on, and stopped since,
    /// is over.
    pub fn note_rest(&mut self) {
        if self.motion == Motion::Unheld {
            self.motion = Motion::Rest;
        }
    }

    /// Notes that the line broke. The guard of a jog is told at once, not on the next line.
    ///
    /// The stop of the arm's own jog is sent over the next line. Pieces end by themselves, and the
    /// next jog waits until the arm was seen at rest.
    pub fn lose_line(&mut self) {
        self.refuse_waiting(JogEnd::LinkLost);
        let (jog, why) = match self.motion {
            Motion::Rest | Motion::Unheld => return,
            Motion::Jog(running, _) => (Some(running.request), JogEnd::LinkLost),
            // A guard that waits for the arm to stop must learn that the line broke.
            Motion::Ending(jog, JogEnd::Released) => (jog, JogEnd::LinkLost),
            Motion::Ending(jog, why) => (jog, why),
        };
        if let Some(jog) = jog {
            self.effects.push_back(GateEffect::Over(jog.id, why, false));
        }
        if jog.is_some_and(|jog| jog.kind == JogKind::Pieces) {
            self.motion = Motion::Unheld;
        } else {
            self.ends(None, why);
        }
    }

    /// Notes that the connection ends, and with it everything that it holds.
    pub fn close(&mut self) {
        self.refuse_waiting(JogEnd::Closed);
        let jog = match self.motion {
            Motion::Jog(running, _) => Some(running.request),
            Motion::Ending(jog, _) => jog,
            Motion::Rest | Motion::Unheld => None,
        };
        if let Some(jog) = jog {
            let over = GateEffect::Over(jog.id, JogEnd::Closed, false);
            self.effects.push_back(over);
        }
        self.motion = Motion::Rest;
    }

    /// Jog in motion, unless it is ending. `None` without a jog.
    #[must_use]
    pub fn running(&self) -> Option<JogId> {
        match self.motion {
            Motion::Jog(running, _) => Some(running.request.id),
            _ => None,
        }
    }

    /// True while the arm comes to rest after a jog.
    #[must_use]
    pub fn is_ending(&self) -> bool {
        matches!(self.motion, Motion::Ending(..))
    }

    /// True while the arm comes to rest after this jog.
    #[must_use]
    pub fn is_ending_jog(&self, jog: JogId) -> bool {
        matches!(self.motion, Motion::Ending(Some(request), _) if request.id == jog)
    }

    fn begin(&mut self, request: JogRequest, reverses: bool) {
        let running = Running { request, reverses };
        // The caller sets the hold time before time passes.
        self.motion = Motion::Jog(running, Deadline::NONE);
        self.effects.push_back(GateEffect::Begin(request.id));
    }

    /// Ends the jog in motion, if there is one.
    fn end(&mut self, why: JogEnd) {
        match self.motion {
            Motion::Jog(running, _) => self.ends(Some(running.request), why),
            // Stopped here only to make room for a jog of our own; otherwise by its own program.
            Motion::Unheld if why == JogEnd::Replaced => self.ends(None, why),
            _ => {}
        }
    }

    fn ends(&mut self, jog: Option<JogRequest>, why: JogEnd) {
        self.motion = Motion::Ending(jog, why);
        let jog = jog.map(|jog| jog.id);
        self.effects.push_back(GateEffect::End(jog, why));
    }

    fn refuse_waiting(&mut self, why: JogEnd) {
        if let Some(waiting) = self.waiting.take() {
            let refused = GateEffect::Refused(waiting.id, why);
            self.effects.push_back(refused);
        }
    }
}

/// Jogs of other programs.
impl Gate {
    /// Notes that another program's jog command is passed on unchanged. That program stops the jog.
    /// A later [`request`](Self::request) stops it first and waits for the arm to come to rest.
    pub fn note_foreign_jog(&mut self) {
        self.refuse_waiting(JogEnd::Replaced);
        if let Motion::Jog(running, _) = self.motion {
            let over = GateEffect::Over(running.request.id, JogEnd::Replaced, false);
            self.effects.push_back(over);
        }
        if let Motion::Ending(Some(jog), why) = self.motion {
            self.effects.push_back(GateEffect::Over(jog.id, why, false));
        }
        self.motion = Motion::Unheld;
    }
}

/// True for a frame that starts a jog, which continues to the end of its axis unless it is stopped.
#[must_use]
pub fn frame_jogs(frame: &Frame<'_>) -> bool {
    use magician_protocol::{Writable, commands::JogCmd};
    let written = frame.ctrl().write() || frame.ctrl().queued();
    // The second parameter is the direction; 0 stops the jog (document 1.9.4).
    written && frame.id() == JogCmd::ROW.id && frame.params().get(1) != Some(&0)
}

/// Refuses a jog without a holder.
///
/// # Errors
/// [`ErrorCode::Guarded`], with the alternative.
pub fn refuse_unheld(command: &magician_protocol::Set) -> Result<()> {
    if jogs(command) {
        Err(unheld_jog().with_command(command.row().set_name))
    } else {
        Ok(())
    }
}

/// Error for a jog without a holder.
#[must_use]
pub fn unheld_jog() -> Error {
    let message =
        message!("a jog that nothing holds goes on to the end of its axis; nothing was sent");
    Error::new(ErrorCode::Guarded, message).remedy(Action::Jog, "ends when it is let go of")
}

/// True for a command that starts a jog.
#[must_use]
pub fn jogs(command: &magician_protocol::Set) -> bool {
    use magician_protocol::{JogCommand, Set};
    matches!(command, Set::JogCmd(jog) if jog.cmd != JogCommand::Stop)
}

/// True if the holder of the arm's own jog reverses it on its axis: there the arm ramps through
/// zero.
fn is_reversal(running: &JogRequest, next: &JogRequest) -> bool {
    let own = running.kind == JogKind::Own && next.kind == JogKind::Own;
    own && running.holder == next.holder && running.direction.axis == next.direction.axis
}
