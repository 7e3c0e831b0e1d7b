//! Classification of requests.

use magician_protocol::commands::{
    JogCmd, QueuedCmdClear, QueuedCmdForceStopExec, QueuedCmdStopExec,
};
use magician_protocol::{Ctrl, Frame, FrameBuf, JogCommand, Layout, Row, Writable};

/// True if a request stops something, so that it overtakes waiting requests. The queued stop of a
/// jog is part of a program and waits its turn.
pub(super) fn stops(frame: &Frame<'_>) -> bool {
    const STOPS: [u8; 3] = [
        QueuedCmdStopExec::ROW.id,
        QueuedCmdForceStopExec::ROW.id,
        QueuedCmdClear::ROW.id,
    ];
    let at_once = frame.ctrl().write() && !frame.ctrl().queued();
    match Row::with_id(frame.id()) {
        // Stop commands act at once whatever the queued bit says.
        Some(row) if row.sets(frame.ctrl()) && STOPS.contains(&row.id) => true,
        _ => at_once && jog(frame).is_some_and(|jog| jog.cmd == JogCommand::Stop),
    }
}

/// True if one reply may serve several clients. False for a get of a pin without an address: its
/// reply depends on the previous request (errata E39).
pub(super) fn can_be_shared(frame: &Frame<'_>) -> bool {
    Row::with_id(frame.id()).is_some_and(|row| {
        let complete = row.query.is_none_or(|query| query.fields.is_empty());
        // An empty query of a row with an address has no fixed meaning.
        row.only_looks(frame.ctrl()) && (complete || !frame.params().is_empty())
    })
}

/// True if a request may change something.
pub(super) fn changes(frame: &Frame<'_>) -> bool {
    !Row::with_id(frame.id()).is_some_and(|row| row.only_looks(frame.ctrl()))
}

/// Jog command in a request, starting or stopping. `None` for other requests.
fn jog(frame: &Frame<'_>) -> Option<JogCmd> {
    let sets = frame.id() == JogCmd::ROW.id && JogCmd::ROW.sets(frame.ctrl());
    let jog = sets.then(|| JogCmd::decode(frame.params()));
    jog?.ok()
}

/// Request that ends the jog which this request starts. `None` if it starts none. A queued jog runs
/// on until it is stopped, too (hosts 9).
pub(super) fn end_of_jog(frame: &Frame<'_>) -> Option<FrameBuf> {
    let begun = jog(frame).filter(|jog| jog.cmd != JogCommand::Stop)?;
    let end = JogCmd {
        is_joint: begun.is_joint,
        cmd: JogCommand::Stop,
    };
    FrameBuf::encode(JogCmd::ROW.id, Ctrl::SET, &end).ok()
}

/// True if a request ends any jog once it is executed.
pub(super) fn ends_jog(frame: &Frame<'_>) -> bool {
    stops(frame) && [JogCmd::ROW.id, QueuedCmdForceStopExec::ROW.id].contains(&frame.id())
}
