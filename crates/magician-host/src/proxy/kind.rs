//! What a request is to the proxy.

use magician_protocol::commands::{
    JogCmd, QueuedCmdClear, QueuedCmdForceStopExec, QueuedCmdStopExec,
};
use magician_protocol::{Ctrl, Frame, FrameBuf, JogCommand, Layout, Row, Writable};

/// Whether a request stops something: such a one overtakes what waits. A jog's end that is to be
/// queued is a part of a program and takes its turn.
pub(super) fn stops(frame: &Frame<'_>) -> bool {
    const STOPS: [u8; 3] = [
        QueuedCmdStopExec::ROW.id,
        QueuedCmdForceStopExec::ROW.id,
        QueuedCmdClear::ROW.id,
    ];
    let at_once = frame.ctrl().write() && !frame.ctrl().queued();
    match Row::with_id(frame.id()) {
        Some(row) if row.sets(frame.ctrl()) && STOPS.contains(&row.id) => true,
        _ => at_once && jog(frame).is_some_and(|jog| jog.cmd == JogCommand::Stop),
    }
}

/// Whether one answer will do for several clients. Without its address the answer to a get of a
/// pin depends on what was asked before (errata E39).
pub(super) fn can_be_shared(frame: &Frame<'_>) -> bool {
    Row::with_id(frame.id()).is_some_and(|row| {
        let complete = row.query.is_none_or(|query| query.fields.is_empty());
        row.only_looks(frame.ctrl()) && (complete || !frame.params().is_empty())
    })
}

/// Whether a request may change something.
pub(super) fn changes(frame: &Frame<'_>) -> bool {
    !Row::with_id(frame.id()).is_some_and(|row| row.only_looks(frame.ctrl()))
}

/// The jog that a request begins or, with a stop in it, ends.
fn jog(frame: &Frame<'_>) -> Option<JogCmd> {
    let sets = frame.id() == JogCmd::ROW.id && JogCmd::ROW.sets(frame.ctrl());
    let jog = sets.then(|| JogCmd::decode(frame.params()));
    jog?.ok()
}

/// The jog that a request begins, as the request that ends it; queued jogs run on as well (hosts 9).
pub(super) fn end_of_jog(frame: &Frame<'_>) -> Option<FrameBuf> {
    let begun = jog(frame).filter(|jog| jog.cmd != JogCommand::Stop)?;
    let end = JogCmd {
        is_joint: begun.is_joint,
        cmd: JogCommand::Stop,
    };
    FrameBuf::encode(JogCmd::ROW.id, Ctrl::SET, &end).ok()
}

/// Whether a request, once obeyed, ends any jog.
pub(super) fn ends_jog(frame: &Frame<'_>) -> bool {
    stops(frame) && [JogCmd::ROW.id, QueuedCmdForceStopExec::ROW.id].contains(&frame.id())
}
