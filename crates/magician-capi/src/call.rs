//! The verbs that most functions are: get, set, and put into the queue.

use magician::commands;
use magician::protocol::{NoArgs, Queueable, Readable, Writable};
use magician::{QueueIndex, Set};

use crate::code::Outcome;
use crate::pointer::{In, Out};
use crate::session::Session;
use crate::structure::Structure;

/// Asks for a value and puts it where C wants it. Nothing is touched unless it is there.
///
/// # Errors
/// A null pointer, before anything is asked; what [`magician::blocking::Arm::get`] says.
pub fn get<S>(arm: &Session, place: Out<S>) -> Outcome
where
    S: Structure,
    S::Row: Readable<Query = NoArgs>,
{
    place.check()?;
    place.put(S::of(&arm.get::<S::Row>()?));
    Ok(())
}

/// Sets a value, or orders an action, at once.
///
/// # Errors
/// What [`magician::blocking::Arm::set`] says; a dangerous command that was not allowed.
pub fn set<T: Writable>(arm: &Session, value: &T) -> Outcome {
    arm.set(value)
}

/// Sets what C hands in.
///
/// # Errors
/// A null pointer; as [`set`].
pub fn put<S>(arm: &Session, value: In<S>) -> Outcome
where
    S: Structure,
    S::Row: Writable,
{
    set(arm, &value.read()?.row()?)
}

/// What the vendor's library makes of the caller's `isQueued` (symbols, section 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Queued {
    /// It is not looked at: the command is always queued.
    Always,
    /// The low byte of what the caller said.
    Said(u8),
}

/// Sends a command at once or through the queue; its index goes where C wants it, if it was queued and there is a place.
///
/// # Errors
/// What [`magician::blocking::Arm::enqueue`] and [`set`](magician::blocking::Arm::set) say.
pub fn queue<T>(arm: &Session, value: &T, queued: Queued, index: Out<u64>) -> Outcome
where
    T: Queueable + Copy + Into<Set>,
{
    if queued == Queued::Said(0) {
        return set(arm, value);
    }
    let QueueIndex(number) = arm.enqueue(value)?;
    index.put(number);
    Ok(())
}

/// As [`queue`], for what C hands in.
///
/// # Errors
/// A null pointer; as [`queue`].
pub fn queue_in<S>(arm: &Session, value: In<S>, queued: Queued, index: Out<u64>) -> Outcome
where
    S: Structure,
    S::Row: Queueable + Copy + Into<Set>,
{
    queue(arm, &value.read()?.row()?, queued, index)
}

/// Index of the command that ended last.
///
/// # Errors
/// As [`get`].
pub fn current_index(arm: &Session, place: Out<u64>) -> Outcome {
    place.check()?;
    let commands::QueuedCmdCurrentIndex {
        queued_cmd_current_index,
    } = arm.get()?;
    place.put(queued_cmd_current_index);
    Ok(())
}
