//! Violations of the assumptions about frames.

use magician_protocol::{Ctrl, FrameBuf, QueuedCmdIndex, Request, Row, checksum};
use magician_sim::fidelity::Assumption as A;

use super::{empty, requests};
use crate::arm::{Fate, Violation};

pub(super) fn violation(assumption: A) -> Option<Violation> {
    Some(match assumption {
        // Foreign bytes also damage the bytes received with them.
        A::ForeignBytes => Violation::Bytes(Box::new(|bytes| match bytes {
            [0xAA, ..] => bytes.to_vec(),
            _ => Vec::new(),
        })),
        A::DamagedFrame => Violation::Bytes(Box::new(|bytes| {
            let mut bytes = bytes.to_vec();
            if let [0xAA, 0xAA, count, ..] = bytes[..] {
                let end = 3 + usize::from(count);
                if let Some(body) = bytes.get(3..end) {
                    let right = checksum(body);
                    if let Some(sum) = bytes.get_mut(end) {
                        *sum = right;
                    }
                }
            }
            bytes
        })),
        A::UnknownId => requests(|_, frame| match Row::with_id(frame.frame().id()) {
            None => empty(frame),
            Some(_) => Fate::Taken,
        }),
        A::WrongCount => requests(|_, frame| match Request::decode(&frame.frame()) {
            Err(_) => Fate::Unanswered,
            Ok(_) => Fate::Taken,
        }),
        // Bit 1 of Ctrl (isQueued) counts only together with bit 0 (rw).
        A::QueuedBitAlone => requests(|_, frame| match frame.frame().ctrl() {
            ctrl if ctrl.queued() && !ctrl.write() => empty(frame),
            _ => Fate::Taken,
        }),
        A::SteeringQueued => requests(|_, frame| {
            let (id, ctrl) = (frame.frame().id(), frame.frame().ctrl());
            let steers =
                Row::with_id(id).is_some_and(|row| row.set.is_some() && row.steers_queue());
            if steers && ctrl.queued() {
                return Fate::Answered(
                    FrameBuf::encode(id, ctrl, &QueuedCmdIndex(1)).expect("fits"),
                );
            }
            Fate::Taken
        }),
        A::SetOnlyRead => requests(|_, frame| match Request::decode(&frame.frame()) {
            Ok(Request::Nothing) => {
                let done = FrameBuf::new(frame.frame().id(), Ctrl::SET, frame.frame().params());
                Fate::Replaced(done.expect("fits"))
            }
            _ => Fate::Taken,
        }),
        A::GetOnlyWritten => requests(|_, frame| match Request::decode(&frame.frame()) {
            Ok(Request::Get(_)) if frame.frame().ctrl().write() => Fate::Unanswered,
            _ => Fate::Taken,
        }),
        A::DestinationBits => requests(|_, frame| {
            let ctrl = frame.frame().ctrl();
            let elsewhere = ctrl.destination() != 0 || ctrl.slave() != 0;
            if elsewhere {
                Fate::Unanswered
            } else {
                Fate::Taken
            }
        }),
        _ => return None,
    })
}
