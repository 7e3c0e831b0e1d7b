//! Handling of a request: executes it at once, queues it or refuses it, and returns its reply.
//!
//! Every request with a known id gets exactly one reply (errata, hosts 1), even if its parameters
//! cannot be read or nothing is done. Silence is reserved for unknown ids (E09) and for the
//! overflow of a strict controller.

use magician_protocol::{
    Alarm, Ctrl, DecodeError, EncodeError, Frame, FrameBuf, QueuedCmdIndex, Request, Row, Set,
};

use super::Device;
use super::effect::{Completion, ExecMode};
use super::handlers;
use super::queue::program::QueueResult;
use super::queue::{QueuedCommand, moves};
use crate::LinkId;
use crate::event::{Event, Refusal};
use crate::fidelity::{Assumption, AssumptionSet};

impl Device {
    /// Carries out a frame and returns its reply. `None` for an unknown id (errata E09).
    pub(crate) fn answer(&mut self, link: LinkId, frame: &Frame<'_>) -> Option<FrameBuf> {
        if Row::with_id(frame.id()).is_none() {
            self.unknown_id(link, frame.id());
            return None;
        }
        if !self.allows_full_queue(frame) {
            return None;
        }
        let reply = self.reply(frame);
        // Only a reply beyond 250 bytes cannot be encoded, and the controller stores nothing of
        // that size.
        let nothing = |_| FrameBuf::new(frame.id(), frame.ctrl(), &[]);
        reply.or_else(nothing).ok()
    }

    fn reply(&mut self, frame: &Frame<'_>) -> Result<FrameBuf, EncodeError> {
        let (id, ctrl) = (frame.id(), frame.ctrl());
        let nothing = || FrameBuf::new(id, ctrl, &[]);
        let request = Request::decode(frame);
        let accepted = (request.as_ref()).is_ok_and(|request| self.accepts(id, ctrl, request));
        match request {
            Ok(Request::Get(get)) if accepted => handlers::report(&mut self.lend(), &get, ctrl),
            Ok(Request::Set(set)) if accepted => {
                self.act_at_once(&set);
                nothing()
            }
            Ok(Request::Queue(set)) if accepted => self.enqueue(id, ctrl, QueuedCommand::Set(set)),
            // A refused queued frame still takes an index, so that the host's numbering stays
            // right.
            Ok(Request::Queue(_)) => self.enqueue(id, ctrl, QueuedCommand::Nothing),
            Ok(Request::Get(_) | Request::Set(_) | Request::Nothing) => nothing(),
            Err(error) => {
                // The parameter count matches no known form: the arm answers, but does nothing
                // (E11).
                self.record.assume(Assumption::WrongCount);
                self.record.refuse(id, Refusal::Parameters);
                if is_queued(ctrl, id, error) {
                    self.enqueue(id, ctrl, QueuedCommand::Nothing)
                } else {
                    nothing()
                }
            }
        }
    }

    fn act_at_once(&mut self, set: &Set) {
        if !self.allows(set, ExecMode::Immediate) {
            return;
        }
        if self.teaching.held() && (moves(set) || matches!(set, Set::JogCmd(_))) {
            // While the unlock key is held the motors are released, so no motion can start.
            self.record.refuse(set.row().id, Refusal::Busy);
            return;
        }
        // An immediate command is finished when it is answered. Nothing waits for the end of its
        // motion.
        let _: Completion = self.carry_out(set, ExecMode::Immediate);
        // The pins that it set may satisfy a TRIG, and a start lets the queue run.
        self.update_tools();
        self.run_until_idle();
    }

    fn enqueue(
        &mut self,
        id: u8,
        ctrl: Ctrl,
        command: QueuedCommand,
    ) -> Result<FrameBuf, EncodeError> {
        self.record.assume(Assumption::Indices);
        if self.queues.hosts().is_unused() {
            self.record.assume(Assumption::FirstIndex);
        }
        let index = match self.queues.place(id, command) {
            QueueResult::Full => {
                self.record.event(Event::QueueFull { id });
                // Index 0 is never given, and bit 2 of Ctrl marks the error (E38, a choice).
                return FrameBuf::encode(id, ctrl.with_error(), &QueuedCmdIndex(0));
            }
            QueueResult::Stored(index) => {
                self.record.event(Event::Stored { index, id });
                self.record.assume(Assumption::StoredLineIndex);
                index
            }
            QueueResult::Queued(index) => {
                self.record.event(Event::Accepted { index, id });
                // A path under way may now look further ahead.
                if !self.queues.program_runs() {
                    self.path_grows();
                }
                self.run_until_idle();
                index
            }
        };
        FrameBuf::encode(id, ctrl, &QueuedCmdIndex(index))
    }

    /// Counts the assumptions of a frame and returns true if it may be carried out.
    fn accepts(&mut self, id: u8, ctrl: Ctrl, request: &Request) -> bool {
        // Frames for an extension controller or a slave are answered as the arm's own (E05).
        let elsewhere = ctrl.destination() != 0 || ctrl.slave() != 0;
        let set = AssumptionSet::default().and_if(elsewhere, Assumption::DestinationBits);
        let set = match request {
            Request::Get(_) => set.and_if(ctrl.write(), Assumption::GetOnlyWritten),
            Request::Set(_) => set.and_if(ctrl.queued(), Assumption::SteeringQueued),
            Request::Queue(_) => set.and_if(!ctrl.write(), Assumption::QueuedBitAlone),
            Request::Nothing => set.and(Assumption::SetOnlyRead),
        };
        self.record.allows_all(id, set)
    }

    /// True unless the frame finds the queue full and a strict controller refuses that case.
    fn allows_full_queue(&mut self, frame: &Frame<'_>) -> bool {
        let id = frame.id();
        !(frame.ctrl().queued() && queues(id) && self.queues.is_full())
            || self.record.allows(id, Assumption::FullQueue)
    }

    fn unknown_id(&mut self, link: LinkId, id: u8) {
        self.record.event(Event::UnknownId { link, id });
        // The missing reply follows the vendor's simulator; the alarm follows its own definition
        // (E09).
        if self.record.allows(id, Assumption::UnknownId) {
            self.raise(Alarm::UndefinedInstruction);
        }
    }
}

/// True if a frame that could not be decoded would have been queued.
fn is_queued(ctrl: Ctrl, id: u8, error: DecodeError) -> bool {
    ctrl.queued() && queues(id) && !matches!(error, DecodeError::UnknownId(_))
}

/// True if a command may be queued: it can be set, and does not itself steer the queue (E47).
fn queues(id: u8) -> bool {
    Row::with_id(id).is_some_and(|row| row.set.is_some() && !row.steers_queue())
}
