//! Bodies of the functions: generic reads and writes, which most functions are, and the few special
//! ones.
//!
//! Reads check the pointers for their results before they send anything, so that a call with a null
//! pointer has no effect. Results are written only on success.

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
use crate::structure::{
    FirmwareParams, PTPCmd, ParallelOutputCmd, Structure, Switching, decode_fault,
};

/// Reads a value and writes it to `place`. On failure `place` stays unchanged.
///
/// # Errors
/// A null pointer, before anything is sent; errors of [`magician::blocking::Arm::get`].
pub fn get<S>(arm: &Session, place: Out<S>) -> Outcome
where
    S: Structure,
    S::Row: Readable<Query = NoArgs>,
{
    parts(arm, place, |row: S::Row| S::of(&row))
}

/// Reads a value and writes its parts to `places`.
///
/// # Errors
/// Those of [`get`].
pub fn parts<T, P>(arm: &Session, places: P, split: impl FnOnce(T) -> P::Values) -> Outcome
where
    T: Readable<Query = NoArgs>,
    P: Places,
{
    parts_for(arm, &NoArgs, places, split)
}

/// Like [`parts`], for a value that takes a query.
///
/// # Errors
/// Those of [`get`].
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

/// Reads a value whose query is in `place` itself, where the caller also expects the result.
///
/// # Errors
/// Those of [`get`].
pub fn get_by_query<S>(
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

/// Reads text and writes it to `place`, truncated to `fits` bytes including the final NUL.
///
/// # Errors
/// Those of [`get`].
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

/// Sends a write command for immediate execution.
///
/// # Errors
/// Errors of [`magician::blocking::Arm::set`]; a dangerous command that was not allowed.
pub fn set<T: Writable>(arm: &Session, value: &T) -> Outcome {
    arm.set(value)
}

/// Sends a write command with a structure of the caller.
///
/// # Errors
/// A null pointer; those of [`set`].
pub fn put<S>(arm: &Session, value: In<S>) -> Outcome
where
    S: Structure,
    S::Row: Writable,
{
    set(arm, &value.read()?.row()?)
}

/// Sends a write command with text: all bytes before the NUL, in any encoding.
///
/// # Errors
/// A null pointer; text that is too long for a frame; those of [`set`].
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
    let text = Characters::read(&mut Reader::new(&bytes)).map_err(decode_fault)?;
    set(arm, &row(text))
}

/// Treatment of the caller's `isQueued`, as observed with the vendor's library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Queued {
    /// The argument is ignored: the command is always queued.
    Always,
    /// Low byte of the argument.
    Argument(u8),
}

/// Sends a command, queued or immediate. The index of a queued one is written to `index`, unless
/// that is null.
///
/// # Errors
/// Errors of [`magician::blocking::Arm::enqueue`] and [`set`](magician::blocking::Arm::set).
pub fn queue<T>(arm: &Session, value: &T, queued: Queued, index: Out<u64>) -> Outcome
where
    T: Queueable + Copy + Into<Set>,
{
    if queued == Queued::Argument(0) {
        return set(arm, value);
    }
    let QueueIndex(number) = arm.enqueue(value)?;
    index.put(number);
    Ok(())
}

/// Like [`queue`], with a structure of the caller.
///
/// # Errors
/// A null pointer; those of [`queue`].
pub fn queue_in<S>(arm: &Session, value: In<S>, queued: Queued, index: Out<u64>) -> Outcome
where
    S: Structure,
    S::Row: Queueable + Copy + Into<Set>,
{
    queue(arm, &value.read()?.row()?, queued, index)
}

/// Like [`queue_in`], for a structure that is sent as a different command than its name says.
///
/// # Errors
/// Those of [`queue_in`].
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

/// Does nothing, for functions that this arm does not support. Zeroes the results and logs a
/// warning once.
///
/// # Errors
/// Never fails: stock wrappers would retry forever.
pub fn neutral(function: &'static str, places: impl Places) -> Outcome {
    notice::warn_once(function, "this arm does not support it; nothing was done");
    places.clear();
    Ok(())
}

/// Converts a flag to exactly 0 or 1.
#[must_use]
pub fn to_flag(flag: Flag) -> u8 {
    flag.is_on().into()
}

/// Converts a C enum to a protocol enum. Only the low byte is sent.
#[must_use]
pub fn to_protocol_enum<E: From<u8>>(value: c_int) -> E {
    let [low, ..] = value.to_le_bytes();
    low.into()
}

/// Converts a protocol enum to a C enum.
#[must_use]
pub fn number(value: impl Into<u8>) -> c_int {
    value.into().into()
}

/// Reads the active alarms. Writes their number of bytes to `length`, and as many bytes as fit to
/// `state`.
///
/// # Errors
/// Those of [`get`].
pub fn alarms(arm: &Session, state: Out<u8>, length: Out<u32>, fits: u32) -> Outcome {
    (state, length).check()?;
    let commands::AlarmsState { alarms_state } = arm.get()?;
    let bytes = alarms_state.as_bytes();
    state.write_truncated(bytes, fits as usize);
    length.put(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
    Ok(())
}

/// Reads the index of the command that finished last.
///
/// # Errors
/// Those of [`get`].
pub fn current_index(arm: &Session, place: Out<u64>) -> Outcome {
    place.check()?;
    place.put(arm.current_index()?);
    Ok(())
}

/// Reads the estimated duration of a move.
///
/// # Errors
/// A null pointer; those of [`get`].
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
/// A null pointer; more outputs than fit a frame; those of [`queue`].
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
    let outputs = PoList::read(&mut Reader::new(&bytes)).map_err(decode_fault)?;
    queue(arm, &S::with(row, outputs), Queued::Always, index)
}

/// Converts a segment to one with laser power: the last field is the power.
#[must_use]
pub fn with_laser_power(segment: commands::CpCmd) -> commands::CpLeCmd {
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

/// Converts an arc to a full circle through the same two points.
#[must_use]
pub fn as_circle(arc: commands::ArcCmd) -> commands::CircleCmd {
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

/// Switches to another firmware with the frame of the vendor's library: a read that carries the
/// mode.
///
/// # Errors
/// A null pointer; those of [`set`].
pub fn switch_firmware(arm: &Session, value: In<FirmwareParams>) -> Outcome {
    let FirmwareParams(mode) = value.read()?;
    let row = <commands::FirmwareSwitch as Writable>::ROW;
    arm.raw(row.id, Ctrl::GET, &mode)?;
    Ok(())
}

/// Accepts `SetDebugEnable` and ignores it: there are no messages of the vendor's to switch.
#[must_use]
pub fn debug(_on: u8) -> c_int {
    Code::NoError as c_int
}

/// Sleeps on the calling thread.
#[must_use]
pub fn sleep(milliseconds: u32) -> c_int {
    thread::sleep(Duration::from_millis(milliseconds.into()));
    Code::NoError as c_int
}
