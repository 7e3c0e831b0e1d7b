//! A request on its way from submission to its end, and the policy for a lost reply.

use magician_protocol::{Effect, Frame, FrameBuf, Row};

use super::outstanding::Key;
use super::{Micros, Priority, Request, Ticket};
use crate::gate::switches_off;

/// Purpose of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Submitted by the caller.
    Caller,
    /// Fence: its reply proves that older replies can no longer arrive.
    Fence,
    /// Reads the current index: for a command in doubt, a restored line or the duplicate check.
    Current,
    /// Reads the left space, for the same purposes.
    Left,
    /// Reads the controller's clock on a restored line.
    Clock,
    /// Reads the left space after a Clear.
    Drain,
}

/// Policy for a reply that does not arrive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Policy {
    /// Retransmit.
    Resend,
    /// Find out from the indices whether the command is in the queue.
    Doubt,
    /// Report the outcome as uncertain: nothing shows whether it was done.
    AtMostOnce,
}

/// A request from submission to its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Job {
    pub(super) ticket: Ticket,
    pub(super) purpose: Purpose,
    pub(super) policy: Policy,
    pub(super) priority: Priority,
    pub(super) frame: FrameBuf,
    pub(super) key: Key,
    pub(super) deadline: Micros,
    /// True if it may share a window above 1.
    pub(super) repeatable: bool,
    /// Number of queued commands sent up to and including this request.
    pub(super) order: u64,
    /// Highest current index read when it was sent.
    pub(super) highest: u64,
    /// Number of transmissions.
    pub(super) sent: u32,
    /// Instant of the last transmission.
    pub(super) since: Micros,
    /// Instant at which its reply counts as lost.
    pub(super) timer: Micros,
    /// True if it is to be retransmitted as soon as possible.
    pub(super) needs_retransmit: bool,
    /// True if its reply counts as lost but is still accepted. Holds no place in the window.
    pub(super) timed_out: bool,
    /// Number of Clears sent up to its transmission.
    pub(super) clears: u32,
    /// True after a stop or when its caller has gone: it is not retransmitted.
    pub(super) no_retransmit: bool,
    /// True if the line broke while it was in flight.
    pub(super) line_broke: bool,
    /// True if, at window 1, it was in flight together with another request.
    pub(super) paired: bool,
}

impl Job {
    pub(super) fn new(ticket: Ticket, purpose: Purpose, request: &Request) -> Self {
        let frame = request.frame.frame();
        Self {
            ticket,
            purpose,
            policy: policy(&frame),
            priority: request.priority,
            frame: request.frame,
            key: Key::of(&frame),
            deadline: request.deadline,
            repeatable: request.repeatable,
            order: 0,
            highest: 0,
            sent: 0,
            since: 0,
            timer: Micros::MAX,
            needs_retransmit: false,
            timed_out: false,
            clears: 0,
            no_retransmit: false,
            line_broke: false,
            paired: false,
        }
    }

    pub(super) fn queued(&self) -> bool {
        self.policy == Policy::Doubt
    }

    /// True if it sets something immediately and neither moves the arm nor can burn.
    pub(super) fn only_sets(&self) -> bool {
        let row = Row::with_id(self.frame.frame().id());
        let sets = row.is_some_and(|row| row.effect == Effect::Setting && !row.may_burn);
        sets && self.policy == Policy::Resend && !self.frame.frame().ctrl().queued()
    }

    /// True if it is a queued command that may be in flight beside others.
    pub(super) fn may_share_window(&self) -> bool {
        self.queued() && self.repeatable
    }

    pub(super) fn in_window(&self) -> bool {
        self.priority != Priority::Stop && !self.timed_out
    }
}

/// True if a request without a reply may have been executed, and must not be executed twice.
#[must_use]
pub fn must_not_repeat(request: &Frame<'_>) -> bool {
    policy(request) != Policy::Resend
}

/// Chooses the policy of a frame. Gets may always be retransmitted, immediate sets if their row
/// says so, and a queued command only after a doubt. Sets with an id outside the table are sent
/// once.
fn policy(frame: &Frame<'_>) -> Policy {
    let (id, ctrl) = (frame.id(), frame.ctrl());
    match Row::with_id(id) {
        // Switching a motor off is idempotent, and a stop is repeated until it is answered,
        // although the row of a motor command forbids it in general.
        Some(_) if switches_off(frame) => Policy::Resend,
        Some(row) if ctrl.queued() && row.set.is_some() && !row.steers_queue() => Policy::Doubt,
        Some(row) if ctrl.write() && row.set.is_some() && !row.resendable => Policy::AtMostOnce,
        Some(_) => Policy::Resend,
        // Unknown id: a set may do anything.
        None if ctrl.write() || ctrl.queued() => Policy::AtMostOnce,
        None => Policy::Resend,
    }
}
