//! What the functions do: the verbs that most of them are, and the few that are one of a kind.

use std::ffi::c_int;
use std::thread;
use std::time::Duration;

use magician::commands;
use magician::protocol::{
    Ctrl, Flag, MAX_PARAMS, NoArgs, PoList, Queueable, Readable, Reader, Text as Characters, Wire,
    Writable,
};
use magician::{QueueIndex, Set};

use crate::code::{Code, Fault, Outcome};
use crate::notice;
use crate::pointer::{Buffer, In, Out, Places, Text};
use crate::session::Session;
use crate::structure::{FirmwareParams, PTPCmd, ParallelOutputCmd, Structure, Switching, unfit};

/// Asks for a value and puts it where C wants it. Nothing is touched unless it is there.
///
/// # Errors
/// A null pointer, before anything is asked; what [`magician::blocking::Arm::get`] says.
pub fn get<S>(arm: &Session, place: Out<S>) -> Outcome
where
    S: Structure,
    S::Row: Readable<Query = NoArgs>,
{
    parts(arm, place, |row: S::Row| S::of(&row))
}

/// Asks for a value and puts what C wants of it where C wants it.
///
/// # Errors
/// As [`get`].
pub fn parts<T, P>(arm: &Session, places: P, split: impl FnOnce(T) -> P::Values) -> Outcome
where
    T: Readable<Query = NoArgs>,
    P: Places,
{
    parts_for(arm, &NoArgs, places, split)
}

/// As [`parts`], for a value that depends on something.
///
/// # Errors
/// As [`get`].
pub fn parts_for<T, P>(
    arm: &Session,
    query: &T::Query,
    places: P,
    split: impl FnOnce(T) -> P::Values,
) -> Outcome
where
    T: Readable,
    P: Places,
{
    places.check()?;
    places.fill(split(arm.get_with(query)?));
    Ok(())
}

/// Asks for a value that depends on what C says in the place where it wants it.
///
/// # Errors
/// As [`get`].
pub fn ask<S>(
    arm: &Session,
    place: Out<S>,
    query: impl FnOnce(S::Row) -> <S::Row as Readable>::Query,
) -> Outcome
where
    S: Structure,
    S::Row: Readable,
{
    let query = query(place.read()?.row()?);
    place.put(S::of(&arm.get_with::<S::Row>(&query)?));
    Ok(())
}

/// Asks for text and puts as much of it where C wants it as fits, ended by a NUL.
///
/// # Errors
/// As [`get`].
pub fn get_text<T>(
    arm: &Session,
    place: Buffer,
    fits: u32,
    text: impl FnOnce(T) -> Characters,
) -> Outcome
where
    T: Readable<Query = NoArgs>,
{
    place.check()?;
    place.put(text(arm.get::<T>()?).as_bytes(), fits as usize);
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

/// Sets text: the bytes before the NUL, whatever they are.
///
/// # Errors
/// A null pointer, text that fits no frame; as [`set`].
pub fn set_text<T: Writable>(
    arm: &Session,
    text: Text,
    row: impl FnOnce(Characters) -> T,
) -> Outcome {
    let bytes = text.read()?;
    if bytes.len() > Characters::CAPACITY {
        let (long, most) = (bytes.len(), Characters::CAPACITY);
        return Err(Fault::invalid(format!(
            "the text has {long} bytes, limit {most}"
        )));
    }
    let text = Characters::read(&mut Reader::new(&bytes)).map_err(unfit)?;
    set(arm, &row(text))
}

/// What the vendor's library was seen to make of the caller's `isQueued`.
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

/// As [`queue_in`], for what goes out as another command than its structure is named after.
///
/// # Errors
/// As [`queue_in`].
pub fn queue_as<S, T>(
    arm: &Session,
    value: In<S>,
    command: impl FnOnce(S::Row) -> T,
    queued: Queued,
    index: Out<u64>,
) -> Outcome
where
    S: Structure,
    T: Queueable + Copy + Into<Set>,
{
    queue(arm, &command(value.read()?.row()?), queued, index)
}

/// Does nothing for what this arm does not have: what C gets is zero, and the log says so once.
///
/// # Errors
/// None: wrappers would try again for ever.
pub fn neutral(function: &'static str, places: impl Places) -> Outcome {
    notice::once(function, "this arm does not support it; nothing was done");
    places.clear();
    Ok(())
}

/// A flag as C wants it, where it may only be 0 or 1.
#[must_use]
pub fn truth(flag: Flag) -> u8 {
    flag.is_on().into()
}

/// What a C enum says: its low byte travels.
#[must_use]
pub fn choice<E: From<u8>>(value: c_int) -> E {
    let [low, ..] = value.to_le_bytes();
    low.into()
}

/// What travelled, as a C enum.
#[must_use]
pub fn number(value: impl Into<u8>) -> c_int {
    value.into().into()
}

/// The alarms that stand: how many bytes they are, and those that fit.
///
/// # Errors
/// As [`get`].
pub fn alarms(arm: &Session, state: Out<u8>, length: Out<u32>, fits: u32) -> Outcome {
    (state, length).check()?;
    let commands::AlarmsState { alarms_state } = arm.get()?;
    let bytes = alarms_state.as_bytes();
    state.put_bytes(bytes, fits as usize);
    length.put(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
    Ok(())
}

/// The index of the command that ended last.
///
/// # Errors
/// As [`get`].
pub fn current_index(arm: &Session, place: Out<u64>) -> Outcome {
    place.check()?;
    place.put(arm.current_index()?);
    Ok(())
}

/// How long a move would take.
///
/// # Errors
/// A null pointer; as [`get`].
pub fn ptp_time(arm: &Session, value: In<PTPCmd>, place: Out<u32>) -> Outcome {
    place.check()?;
    let commands::PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    } = value.read()?.row()?;
    let query = commands::GetPtpTime {
        ptp_mode,
        x,
        y,
        z,
        r,
    };
    parts_for(arm, &query, place, |row: commands::PtpTime| row.ptp_time)
}

/// Queues a move that switches outputs on its way.
///
/// # Errors
/// A null pointer, more outputs than fit a frame; as [`queue`].
pub fn queue_switching<S>(
    arm: &Session,
    value: In<S>,
    outputs: In<ParallelOutputCmd>,
    count: c_int,
    index: Out<u64>,
) -> Outcome
where
    S: Switching,
    S::With: Queueable + Copy + Into<Set>,
{
    let row = value.read()?.row()?;
    let most = (MAX_PARAMS - size_of::<S>()) / size_of::<ParallelOutputCmd>();
    let count = usize::try_from(count)
        .ok()
        .filter(|count| *count <= most)
        .ok_or_else(|| Fault::invalid(format!("{count} outputs to switch, limit {most}")))?;
    let outputs = outputs.several(count)?;
    let bytes: Vec<u8> = outputs.into_iter().flat_map(|output| output.0).collect();
    let outputs = PoList::read(&mut Reader::new(&bytes)).map_err(unfit)?;
    queue(arm, &S::with(row, outputs), Queued::Always, index)
}

/// A segment whose last number is the laser's power.
#[must_use]
pub fn burning(segment: commands::CpCmd) -> commands::CpLeCmd {
    let commands::CpCmd {
        cp_mode,
        x,
        y,
        z,
        velocity_or_power,
    } = segment;
    commands::CpLeCmd {
        cp_mode,
        x,
        y,
        z,
        velocity_or_power,
    }
}

/// A circle through the two points that arcs are given by.
#[must_use]
pub fn once_round(arc: commands::ArcCmd) -> commands::CircleCmd {
    let commands::ArcCmd {
        cir_point,
        to_point,
    } = arc;
    commands::CircleCmd {
        cir_point,
        to_point,
        count: 1,
    }
}

/// Switches to another firmware, with the frame that the vendor's library sends: a read that carries the mode.
///
/// # Errors
/// A null pointer; as [`set`].
pub fn switch_firmware(arm: &Session, value: In<FirmwareParams>) -> Outcome {
    let FirmwareParams(mode) = value.read()?;
    let row = <commands::FirmwareSwitch as Writable>::ROW;
    arm.raw(row.id, Ctrl::GET, &mode)?;
    Ok(())
}

/// There are no messages of the vendor's to switch.
#[must_use]
pub fn debug(_on: u8) -> c_int {
    Code::NoError as c_int
}

/// Waits.
#[must_use]
pub fn sleep(milliseconds: u32) -> c_int {
    thread::sleep(Duration::from_millis(milliseconds.into()));
    Code::NoError as c_int
}
