use magician_protocol::{Effect, Frame, FrameBuf, Row};

use super::outstanding::Key;
use super::{Micros, Priority, Request, Ticket};
use crate::gate::switches_off;

/// What a request is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// The caller submitted it.
    Caller,
    /// Its reply proves that older replies will not come any more.
    Fence,
    /// Reads the current index for a command in doubt.
    Current,
    /// Reads the left space for a command in doubt.
    Left,
    /// Reads the controller's clock on a line that was lost and found.
    Clock,
    /// Reads the left space after a Clear.
    Drain,
}

/// What may be done when an answer does not come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Policy {
    /// Send it again.
    Resend,
    /// It stands in the queue or not: find out.
    Doubt,
    /// It was done or not, and nothing tells.
    Once,
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
    /// It may share a window above 1.
    pub(super) repeatable: bool,
    /// How many queued commands had gone out when it did, itself among them.
    pub(super) order: u64,
    /// The highest current index read by then.
    pub(super) highest: u64,
    /// How often it went out.
    pub(super) sent: u32,
    /// When it went out last.
    pub(super) since: Micros,
    /// When its answer counts as lost.
    pub(super) timer: Micros,
    /// It is to go out again as soon as possible.
    pub(super) due: bool,
    /// Its answer counts as lost but would still be taken; it holds no place in the window.
    pub(super) lingers: bool,
    /// Clears that had gone out when it did.
    pub(super) clears: u32,
    /// A stop came, or its caller has gone: it does not go out again.
    pub(super) over: bool,
    /// The line broke under it.
    pub(super) cut: bool,
    /// At window 1: it was in flight together with another one.
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
            due: false,
            lingers: false,
            clears: 0,
            over: false,
            cut: false,
            paired: false,
        }
    }

    pub(super) fn queued(&self) -> bool {
        self.policy == Policy::Doubt
    }

    /// Whether it sets something at once, and neither moves the arm nor may burn.
    pub(super) fn only_sets(&self) -> bool {
        let row = Row::with_id(self.frame.frame().id());
        let sets = row.is_some_and(|row| row.effect == Effect::Setting && !row.may_burn);
        sets && self.policy == Policy::Resend && !self.frame.frame().ctrl().queued()
    }

    /// Whether it is a queued command that may travel beside others.
    pub(super) fn shares(&self) -> bool {
        self.queued() && self.repeatable
    }

    pub(super) fn in_window(&self) -> bool {
        self.priority != Priority::Stop && !self.lingers
    }
}

/// Whether a request that was not answered may have been done, and must not be done again.
#[must_use]
pub fn is_once(request: &Frame<'_>) -> bool {
    policy(request) != Policy::Resend
}

/// Gets may always be sent again; for immediate sets the row says so; a queued command is
/// answered with an index. What the table does not know is sent once.
fn policy(frame: &Frame<'_>) -> Policy {
    let (id, ctrl) = (frame.id(), frame.ctrl());
    match Row::with_id(id) {
        // A motor that is off is off, however often that is said; a stop says it until it is answered.
        Some(_) if switches_off(frame) => Policy::Resend,
        Some(row) if ctrl.queued() && row.set.is_some() && !row.steers_queue() => Policy::Doubt,
        Some(row) if ctrl.write() && row.set.is_some() && !row.resendable => Policy::Once,
        Some(_) => Policy::Resend,
        None if ctrl.write() || ctrl.queued() => Policy::Once,
        None => Policy::Resend,
    }
}
