//! Violation of each assumption.

mod alarms;
mod frames;
pub(crate) mod mistakes;
mod motion;
mod queue;
mod settings;
mod tools;

use magician_protocol::commands::*;
use magician_protocol::{FrameBuf, Readable, Request};
use magician_sim::fidelity::Assumption;
use magician_sim::{Controller, ExternalEvent, Profile};

use crate::arm::{Fate, Violation};

/// Returns the violation of an assumption.
pub(crate) fn violation(assumption: Assumption) -> Violation {
    let modules = [
        settings::violation,
        frames::violation,
        alarms::violation,
        motion::violation,
        tools::violation,
        queue::violation,
    ];
    let found = modules
        .iter()
        .find_map(|violation_in| violation_in(assumption));
    found.unwrap_or_else(|| panic!("nothing violates {assumption:?}"))
}

fn profile(change: fn(&mut Profile)) -> Violation {
    Violation::Profile(change)
}

fn requests(decide: impl FnMut(&mut Controller, &FrameBuf) -> Fate + 'static) -> Violation {
    Violation::Request(Box::new(decide))
}

fn after(act: impl FnMut(&mut Controller, &Request) + 'static) -> Violation {
    Violation::After(Box::new(act))
}

fn time(act: impl FnMut(&mut Controller) + 'static) -> Violation {
    Violation::Time(Box::new(act))
}

fn events(act: impl FnMut(&mut Controller, ExternalEvent) -> bool + 'static) -> Violation {
    Violation::Event(Box::new(act))
}

fn replies(change: impl FnMut(&mut Controller, FrameBuf) -> FrameBuf + 'static) -> Violation {
    Violation::Reply(Box::new(change))
}

/// Alters the reply to a read.
fn reports<L: Readable>(change: impl Fn(&mut Controller, &mut L) + 'static) -> Violation {
    replies(move |arm, reply| {
        let frame = reply.frame();
        let value = (frame.id() == L::ROW.id && !frame.params().is_empty())
            .then(|| frame.read::<L>().ok())
            .flatten();
        let Some(mut value) = value else {
            return reply;
        };
        change(arm, &mut value);
        FrameBuf::encode(frame.id(), frame.ctrl(), &value).expect("as long as before")
    })
}

/// Alters the index of the last finished command.
fn current_index(change: impl Fn(&mut Controller, &mut u64) + 'static) -> Violation {
    reports::<QueuedCmdCurrentIndex>(move |arm, index| {
        change(arm, &mut index.queued_cmd_current_index);
    })
}

/// Never reports these alarms.
fn hides(codes: &'static [u8]) -> Violation {
    reports::<AlarmsState>(|_, alarms| {
        let others = alarms
            .alarms_state
            .codes()
            .filter(|code| !codes.contains(code));
        alarms.alarms_state = others.collect();
    })
}

/// Alters a command. `change` gets true for a queued command, false for an immediate one.
fn sets(change: impl Fn(&mut Controller, &mut Set, bool) + 'static) -> Violation {
    requests(move |arm, frame| {
        let ctrl = frame.frame().ctrl();
        let (mut set, queued) = match Request::decode(&frame.frame()) {
            Ok(Request::Set(set)) => (set, false),
            Ok(Request::Queue(set)) => (set, true),
            _ => return Fate::Taken,
        };
        change(arm, &mut set, queued);
        Fate::Replaced(FrameBuf::set(&set, ctrl).expect("fits"))
    })
}

/// Answers commands without executing them.
fn ignores(which: impl Fn(&mut Controller, &Set, bool) -> bool + 'static) -> Violation {
    requests(move |arm, frame| match Request::decode(&frame.frame()) {
        Ok(Request::Set(set)) if which(arm, &set, false) => Fate::Ignored,
        Ok(Request::Queue(set)) if which(arm, &set, true) => Fate::Ignored,
        _ => Fate::Taken,
    })
}

/// Answers commands with these ids without executing them.
fn ignores_ids(ids: &'static [u8]) -> Violation {
    ignores(|_, set, _| ids.contains(&set.row().id))
}

/// Returns an empty answer to a frame.
fn empty(frame: &FrameBuf) -> Fate {
    let frame = frame.frame();
    Fate::Answered(FrameBuf::new(frame.id(), frame.ctrl(), &[]).expect("fits"))
}

/// Returns the point-to-point move of a command. `None` for other commands.
fn ptp(set: &mut Set) -> Option<&mut PtpCmd> {
    match set {
        Set::PtpCmd(ptp) => Some(ptp),
        _ => None,
    }
}
