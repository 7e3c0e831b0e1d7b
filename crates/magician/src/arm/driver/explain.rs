//! Classification of requests (stops, holds, motion), and error messages for their failures.

use magician_protocol::commands::{
    JogCmd, QueuedCmdClear, QueuedCmdForceStopExec, QueuedCmdStartExec, QueuedCmdStopExec,
};
use magician_protocol::{Frame, Row, Writable};

use crate::connection::Failure;
use crate::message;
use crate::{Error, ErrorCode};

/// Returns the vendor's name of a request, or its id if unknown.
pub(in crate::arm) fn command_name(request: &Frame<'_>) -> String {
    match Row::with_id(request.id()) {
        Some(row) => row.form_name(request.ctrl()).to_owned(),
        None => format!("command {}", request.id()),
    }
}

/// True if a request ends a motion immediately.
pub(super) fn halts(request: &Frame<'_>) -> bool {
    // The second parameter of JOGCmd is the direction; 0 stops.
    let ends_jog = request.id() == JogCmd::ROW.id && request.params().get(1) == Some(&0);
    ends_jog || request.id() == QueuedCmdForceStopExec::ROW.id
}

/// True if a request ends the queue and every motion immediately.
pub(super) fn stops_at_once(request: &Frame<'_>) -> bool {
    request.ctrl().write() && request.id() == QueuedCmdForceStopExec::ROW.id
}

/// True if a request pauses or clears the queue.
pub(super) fn holds(request: &Frame<'_>) -> bool {
    let rows = [
        QueuedCmdStopExec::ROW,
        QueuedCmdForceStopExec::ROW,
        QueuedCmdClear::ROW,
    ];
    request.ctrl().write() && rows.iter().any(|row| row.id == request.id())
}

/// True if a request is a motion, or starts the queue.
pub(in crate::arm) fn sets_going(request: &Frame<'_>) -> bool {
    let moves = Row::with_id(request.id()).is_some_and(|row| row.effect.moves_arm());
    let immediate = moves && request.ctrl().write() && !halts(request);
    request.ctrl().queued() || immediate || request.id() == QueuedCmdStartExec::ROW.id
}

/// Returns the error for a failed request, with its name.
pub(super) fn explain(request: &Frame<'_>, failure: Failure) -> Error {
    failed(failure).with_command(command_name(request))
}

/// Returns the error for a failure.
pub(super) fn failed(failure: Failure) -> Error {
    match failure {
        // Never sent: requests before it used up the deadline. The caller may repeat it safely.
        Failure::Timeout { sent: 0 } => Error::new(
            ErrorCode::NotSent,
            message!("it could not be sent in time: the arm did not answer the requests before it"),
        ),
        Failure::Timeout { sent } => Error::new(
            ErrorCode::NoAnswer,
            if sent == 1 {
                message!("no answer; it was sent once")
            } else {
                message!("no answer; it was sent again and again")
            },
        ),
        Failure::Uncertain { from, to } => Error::uncertain(from, to),
        Failure::QueueFull => Error::new(
            ErrorCode::QueueFull,
            message!("the arm's queue is full; nothing was stored"),
        ),
        Failure::Refused => Error::new(ErrorCode::Refused, message!("the arm refuses it")),
        Failure::NoIndex => Error::new(
            ErrorCode::BadAnswer,
            message!("the reply to a queued command has no index"),
        ),
        Failure::Stopped => Error::new(
            ErrorCode::Stopped,
            message!("a stop, or a reset of the arm, came first; it was not sent"),
        ),
        Failure::Lost => Error::new(ErrorCode::LineLost, message!("the line to the arm broke")),
        Failure::Draining => Error::new(
            ErrorCode::QueueDraining,
            message!(
                "it was not sent: the queue was cleared, and the command under way has not finished"
            ),
        ),
        Failure::Busy => Error::new(
            ErrorCode::TooManyRequests,
            message!("it was not sent: too many requests wait at once"),
        ),
        // Unreachable in a published build too: the crates depend on each other by exact version.
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}
