//! The motion gate: what moves an arm without an end of its own, who holds it, and what has to come before the next.
//!
//! A jog ([`JogCmd`](magician_protocol::commands::JogCmd)) goes on to the end of its axis, a belt or stepper for ever, and the arm
//! has no watchdog. So whatever starts one passes through a [`Gate`], which knows its holder and, for a jog, its deadline. Its laws:
//!
//! * **Rest between jogs.** A real arm carries the signed speed of a jog over to the axis of the next one and first moves that the
//!   wrong way, by v^2/2a: 7.5 to 30 mm. A jog of another axis or frame, or of another holder, starts only when the arm was seen
//!   at rest after the stop. The same holder may reverse on the same axis: the arm ramps through zero there.
//! * **A holder.** What moves ends with its holder: released, not kept up, gone.
//! * **One deadline.** A jog ends at the earliest of the instant until which it was kept up, the arm's fence and the end of its axis,
//!   for that reason. [`Gate::poll_timeout`] is that instant, and the caller needs no other timer. Keeping it up too late does not
//!   revive a jog, and a later bound does not extend it.
//! * **A stop stops it.** Nothing that was started before a stop runs after it, whoever started it.
//! * **Released is released.** A jog that was let go of while the arm still came to rest starts nothing.
//!
//! Two kinds of jogs pass through it ([`JogKind`]). Measured on the virtual arm (docs/evidence/MEASUREMENTS.md, "Jogs"), neither can be the
//! only one. The arm has no path of joints, so a joint rests between pieces: J1 falls to 10 % of full speed there. Pieces also start
//! 5 to 16 times later, and along a line load it 12 to 25 times as much. The arm's own jog goes on when the program dies.
//! A fence is no third kind but a bound of the own jog.
//!
//! The laser has a machinery of its own for the same purpose: what may burn needs a permission, and every end switches it off
//! (see [`burns`](fn@crate::burns) and [`ArmPicture::may_be_lit`](crate::ArmPicture::may_be_lit)). It does not pass through here, because a burning path is queued
//! together with its end.
//!
//! Without clock and I/O: time is what the caller says, and what follows from a decision comes out as [`GateEffect`]s, in their order.
//! The whole state is values, so that every interleaving can be tried (`tests/gate`).

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

/// Number of a jog; each that is asked for has another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct JogId(pub u64);

/// Owner of a jog: a program with its guards, another program whose frames are passed on, a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Holder(pub u64);

/// What the arm does of a jog that nothing more is sent of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JogKind {
    /// The arm's own jog: it goes on to the end of its axis. Its stop is owed over the next line when the line breaks.
    Own,
    /// Pieces in the arm's queue: they end by themselves, and whoever sends them stops them and sees the arm at rest.
    Pieces,
}

/// A jog that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct JogRequest {
    /// Number of the jog.
    pub id: JogId,
    /// Owner of the jog.
    pub holder: Holder,
    /// Axis and direction; the axis says the frame.
    pub direction: JogDirection,
    /// Hold time: how long the jog goes on after it was kept up, us.
    pub keep: Micros,
    /// Its end on an arm that hears nothing more.
    pub kind: JogKind,
}

/// Why a jog ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JogEnd {
    /// Guard dropped or told to stop.
    Released,
    /// Not kept up in time.
    NotKept,
    /// The arm did not confirm that it began.
    Failed,
    /// An answer was lost: what the arm was sent is not known.
    Doubt,
    /// End of the axis reached.
    Limit,
    /// A stop came.
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

/// Consequence of a decision. The caller carries them out in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GateEffect {
    /// The command of this jog goes out now. [`Gate::hold`] says how long it may go on.
    Begin(JogId),
    /// The stop of a jog goes out, again and again until the arm stands; then [`Gate::rested`].
    End(Option<JogId>, JogEnd),
    /// A jog is over. True if the arm was seen at rest.
    Over(JogId, JogEnd, bool),
    /// A jog that waited for the arm to come to rest does not begin.
    Refused(JogId, JogEnd),
}

/// A jog under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Running {
    request: JogRequest,
    /// True if it reverses the jog before: without its command the arm goes on in that one's direction.
    reverses: bool,
}

/// State of the arm outside of its queue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
enum Motion {
    /// The arm stands, as far as is known.
    #[default]
    Rest,
    /// A jog, and when it ends.
    Jog(Running, Deadline),
    /// Something that nothing here holds: a jog that was passed on as it came, another motion, or an arm that was not seen to come
    /// to rest.
    Unheld,
    /// A stop is on its way, or the arm brakes.
    Ending(Option<JogRequest>, JogEnd),
}

/// State machine of the motions that have no end of their own. See the [module](self).
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
/// gate.ask(jog(1, Axis::X.plus()));
/// assert_eq!(gate.poll_effect(), Some(GateEffect::Begin(JogId(1))));
/// gate.hold(JogId(1), 600_000);
/// // Its holder keeps it up, but the fence comes before.
/// assert_eq!(gate.keep(JogId(1), 500_000), Ok(()));
/// gate.bound(JogId(1), 700_000, JogEnd::Fence);
/// assert_eq!(gate.poll_timeout(), Some((700_000, JogEnd::Fence)));
/// // Another axis has to wait for the arm to come to rest.
/// gate.ask(jog(2, Axis::Z.plus()));
/// assert!(matches!(gate.poll_effect(), Some(GateEffect::End(..))));
/// assert_eq!(gate.poll_effect(), None);
/// gate.rested(true);
/// assert!(matches!(gate.poll_effect(), Some(GateEffect::Over(JogId(1), _, true))));
/// assert_eq!(gate.poll_effect(), Some(GateEffect::Begin(JogId(2))));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Gate {
    motion: Motion,
    /// The jog that begins when the arm has come to rest.
    waiting: Option<JogRequest>,
    effects: VecDeque<GateEffect>,
}

/// Jogs.
impl Gate {
    /// An arm at rest.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the next consequence, oldest first.
    pub fn poll_effect(&mut self) -> Option<GateEffect> {
        self.effects.pop_front()
    }

    /// A jog is asked for. It begins at once at an arm at rest and as the reversal of a jog of its holder, else when the arm has
    /// come to rest.
    pub fn ask(&mut self, request: JogRequest) {
        match self.motion {
            Motion::Rest => self.begin(request, false),
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
                self.refuse_waiting(JogEnd::Replaced);
                self.waiting = Some(request);
            }
        }
    }

    /// Lets a jog that begins go on until then: its holder cannot keep it up before the arm has answered.
    pub fn hold(&mut self, jog: JogId, until: Micros) {
        if let Some(deadline) = self.deadline_of(jog) {
            deadline.keep_until(until);
        }
    }

    /// Keeps a jog up: it may go on for its hold time from now.
    ///
    /// # Errors
    /// Why it ends or is about to; `None` if it is not under way.
    pub fn keep(&mut self, jog: JogId, now: Micros) -> Result<(), Option<JogEnd>> {
        match &mut self.motion {
            Motion::Jog(Running { request, .. }, deadline) if request.id == jog => {
                // Also before the caller has noticed that its time is over.
                if let Some(why) = deadline.passed(now) {
                    return Err(Some(why));
                }
                deadline.keep_until(now.saturating_add(request.keep));
                Ok(())
            }
            Motion::Ending(Some(request), why) if request.id == jog => Err(Some(*why)),
            _ => Err(None),
        }
    }

    /// Bounds a jog: whoever keeps it up, it ends then at the latest, for this reason.
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

    /// This jog is let go of: one that waits does not begin, one under way ends.
    pub fn release(&mut self, jog: JogId) {
        if self.waiting.is_some_and(|waiting| waiting.id == jog) {
            self.refuse_waiting(JogEnd::Released);
        }
        self.end_one(jog, JogEnd::Released);
    }

    /// This jog ends, if it is the one under way.
    pub fn end_one(&mut self, jog: JogId, why: JogEnd) {
        if self.running() == Some(jog) {
            self.end(why);
        }
    }

    /// The command of a jog did not go out after [`GateEffect::Begin`]: the arm does what it did before.
    pub fn not_begun(&mut self, jog: JogId) {
        let Motion::Jog(running, _) = self.motion else {
            return;
        };
        if running.request.id == jog {
            let refused = GateEffect::Refused(jog, JogEnd::Stopped);
            self.effects.push_back(refused);
            if running.reverses {
                self.ends(None, JogEnd::Stopped);
            } else {
                self.motion = Motion::Rest;
            }
        }
    }

    /// Time passes: a jog whose deadline has come ends.
    pub fn handle_timeout(&mut self, now: Micros) {
        if let Motion::Jog(_, deadline) = self.motion
            && let Some(why) = deadline.passed(now)
        {
            self.end(why);
        }
    }

    /// When [`handle_timeout`](Self::handle_timeout) is due, and why the jog ends then.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<(Micros, JogEnd)> {
        match self.motion {
            Motion::Jog(_, deadline) => Some(deadline.next()),
            _ => None,
        }
    }

    /// Returns the same state with its instants counted from `now`: states that go on alike are equal.
    #[must_use]
    pub fn rebased(&self, now: Micros) -> Self {
        let mut gate = self.clone();
        if let Motion::Jog(_, deadline) = &mut gate.motion {
            *deadline = deadline.rebased(now);
        }
        gate
    }

    /// A stop goes out: the jog ends, and none that was asked for before begins. [`OUTPUTS`] are switched off with it.
    pub fn stop(&mut self) {
        self.refuse_waiting(JogEnd::Stopped);
        self.end(JogEnd::Stopped);
    }

    /// Does the same as [`stop`](Self::stop) at an arm that may be in a jog that the gate does not know.
    pub fn stop_any(&mut self) {
        self.stop();
        if matches!(self.motion, Motion::Rest | Motion::Unheld) {
            self.ends(None, JogEnd::Stopped);
        }
    }

    /// The arm has come to rest after [`GateEffect::End`]. False if it was not seen to: nothing more can be done about it, and
    /// what waited for that does not begin. The next jog tries again.
    pub fn rested(&mut self, seen: bool) {
        let Motion::Ending(jog, why) = self.motion else {
            return;
        };
        self.motion = if seen { Motion::Rest } else { Motion::Unheld };
        if let Some(jog) = jog {
            self.effects.push_back(GateEffect::Over(jog.id, why, seen));
        }
        match self.waiting.take() {
            Some(waiting) if seen => self.begin(waiting, false),
            Some(waiting) => {
                let refused = GateEffect::Refused(waiting.id, JogEnd::Doubt);
                self.effects.push_back(refused);
            }
            None => {}
        }
    }

    /// The arm may move by something that is no jog, or brake after a stop: the next jog waits until it was seen at rest.
    pub fn moves(&mut self) {
        if self.motion == Motion::Rest {
            self.motion = Motion::Unheld;
        }
    }

    /// A caller has read two equal poses: a jog that was passed on, and stopped since, does not move the arm any more.
    pub fn stands_still(&mut self) {
        if self.motion == Motion::Unheld {
            self.motion = Motion::Rest;
        }
    }

    /// The line broke. The guard of a jog waits for no line. The stop of the arm's own jog goes out over the next one; pieces end
    /// by themselves, and the next jog waits until the arm was seen at rest.
    pub fn lose_line(&mut self) {
        self.refuse_waiting(JogEnd::LinkLost);
        let (jog, why) = match self.motion {
            Motion::Rest | Motion::Unheld => return,
            Motion::Jog(running, _) => (Some(running.request), JogEnd::LinkLost),
            // To a guard that waits for the arm to stand the line is what is wrong.
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

    /// The connection ends, and all that it holds.
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

    /// The jog under way that is not being ended.
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
        // The caller says how long it may go on before time passes.
        self.motion = Motion::Jog(running, Deadline::NONE);
        self.effects.push_back(GateEffect::Begin(request.id));
    }

    /// Ends the jog under way, if there is one.
    fn end(&mut self, why: JogEnd) {
        match self.motion {
            Motion::Jog(running, _) => self.ends(Some(running.request), why),
            // It is stopped by the program that passed it on, or to make room for a jog of our own.
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
    /// The command of a jog of another program is passed on as it came. What that means is the program's; here it ends with
    /// the connection, and a jog of our own waits for its end.
    pub fn passes(&mut self) {
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

/// True for a frame that starts a jog: it goes on to the end of its axis unless something stops it.
#[must_use]
pub fn frame_jogs(frame: &Frame<'_>) -> bool {
    use magician_protocol::{Writable, commands::JogCmd};
    let written = frame.ctrl().write() || frame.ctrl().queued();
    written && frame.id() == JogCmd::ROW.id && frame.params().get(1) != Some(&0)
}

/// Refuses a jog that nothing holds.
///
/// # Errors
/// [`ErrorCode::Guarded`], with what to use instead.
pub fn refuse_unheld(command: &magician_protocol::Set) -> Result<()> {
    if jogs(command) {
        Err(unheld_jog().with_command(command.row().set_name))
    } else {
        Ok(())
    }
}

/// The error for a jog that nothing holds.
#[must_use]
pub fn unheld_jog() -> Error {
    let message =
        message!("a jog that nothing holds goes on to the end of its axis; nothing was sent");
    Error::new(ErrorCode::Guarded, message).remedy(Action::Jog, "ends when it is let go of")
}

/// True for the command of such a frame.
#[must_use]
pub fn jogs(command: &magician_protocol::Set) -> bool {
    use magician_protocol::{JogCommand, Set};
    matches!(command, Set::JogCmd(jog) if jog.cmd != JogCommand::Stop)
}

/// The holder of the arm's own jog turns it round on its axis: the arm ramps through zero there.
fn is_reversal(running: &JogRequest, next: &JogRequest) -> bool {
    let own = running.kind == JogKind::Own && next.kind == JogKind::Own;
    own && running.holder == next.holder && running.direction.axis == next.direction.axis
}
