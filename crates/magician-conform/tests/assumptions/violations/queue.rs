//! Violations of the assumptions about the queue.

use std::cell::Cell;

use magician_protocol::commands::*;
use magician_protocol::{FrameBuf, Request};
use magician_sim::fidelity::Assumption as A;

use super::{
    after, current_index, ignores, ignores_ids, profile, replies, reports, requests, sets,
};
use crate::arm::{Fate, Violation, tell};

pub(super) fn violation(assumption: A) -> Option<Violation> {
    Some(match assumption {
        // Every other index is skipped.
        A::Indices => replies(|_, reply| renumbered(reply, |index| 2 * index)),
        A::FirstIndex => profile(|profile| profile.queue.first_index = 1),
        // The index of the running command.
        A::CurrentIndex => current_index(|arm, index| {
            *index = arm.state().queue.running.unwrap_or(*index);
        }),
        A::CurrentAtFirst => current_index(|_, index| *index = (*index).max(1)),
        A::IndexAfterClear => {
            let cleared = Cell::new(0);
            let last = Cell::new(0);
            replies(move |_, reply| {
                if reply.frame().id() == 245 {
                    cleared.set(last.get());
                }
                renumbered(reply, |index| {
                    last.set(index);
                    index - cleared.get()
                })
            })
        }
        A::QueueDepth => profile(|profile| profile.queue.depth = 16),
        A::RunningPlace => reports::<QueuedCmdLeftSpace>(|arm, left| {
            left.left_space += u32::from(arm.state().queue.running.is_some());
        }),
        A::FullQueue => requests(|arm, frame| {
            let queue = arm.state().queue;
            let full = queue.waiting + usize::from(queue.running.is_some()) == queue.capacity;
            match Request::decode(&frame.frame()) {
                Ok(Request::Queue(_)) if full => Fate::Unanswered,
                _ => Fate::Taken,
            }
        }),
        A::Start => ignores_ids(&[240]),
        A::QueueStopped => profile(|profile| profile.power_up.queue_started = true),
        A::StartAgain => ignores(|arm, set, _| {
            matches!(set, Set::QueuedCmdStartExec(_)) && arm.state().queue.started
        }),
        A::StopFinishes => sets(|_, set, _| {
            if let Set::QueuedCmdStopExec(_) = set {
                *set = Set::QueuedCmdForceStopExec(QueuedCmdForceStopExec {});
            }
        }),
        A::StopCutsWait => ignores(|arm, set, _| {
            let waits = matches!(arm.state().queue.running_id, Some(110 | 120));
            matches!(set, Set::QueuedCmdStopExec(_)) && waits
        }),
        A::ForceStop => profile(|profile| profile.stop.force_factor = 1.5),
        A::ForceStopStops => after(|arm, request| {
            if let Request::Set(Set::QueuedCmdForceStopExec(_)) = request {
                tell(arm, &Set::QueuedCmdStartExec(QueuedCmdStartExec {}));
            }
        }),
        A::Clear => ignores_ids(&[245]),
        A::ClearWhileMoving => profile(|profile| profile.queue.clear_ends_motion = false),
        _ => return None,
    })
}

/// Changes the index in the answer to a queued command.
fn renumbered(reply: FrameBuf, number: impl FnOnce(u64) -> u64) -> FrameBuf {
    let frame = reply.frame();
    let index = <[u8; 8]>::try_from(frame.params()).map(u64::from_le_bytes);
    match index {
        Ok(index) if frame.ctrl().queued() && frame.id() < 240 => {
            let params = number(index).to_le_bytes();
            FrameBuf::new(frame.id(), frame.ctrl(), &params).expect("as long as before")
        }
        _ => reply,
    }
}
