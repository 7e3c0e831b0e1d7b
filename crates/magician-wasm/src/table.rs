//! Stations of the module by handle: the exports in safe Rust. A call with an unknown handle has no
//! effect.

use std::cell::RefCell;

use crate::PageStation;
use crate::page::failure;

#[derive(Default)]
struct Table {
    /// Leaked, because a station lasts as long as the module. A test could not drop a station when
    /// its thread ends either: the station's runtime is not usable then.
    stations: Vec<&'static mut PageStation>,
    /// Error of the last failed opening.
    last_error: Option<String>,
    last_output: Vec<u8>,
}

thread_local! {
    static TABLE: RefCell<Table> = RefCell::default();
}

fn with_station<T>(handle: u32, act: impl FnOnce(&mut PageStation) -> T) -> Option<T> {
    TABLE.with_borrow_mut(|table| {
        let at = usize::try_from(handle.checked_sub(1)?).ok()?;
        table.stations.get_mut(at).map(|station| act(station))
    })
}

/// Opens a station; 0 if its configuration is invalid.
#[must_use]
pub fn station_open(config: &[u8]) -> u32 {
    TABLE.with_borrow_mut(|table| match PageStation::open(config) {
        Ok(station) => {
            table.stations.push(Box::leak(Box::new(station)));
            u32::try_from(table.stations.len()).unwrap_or(0)
        }
        Err(why) => {
            table.last_error = Some(failure("invalid-input", &why).to_string());
            0
        }
    })
}

/// Passes text of a session to the station.
pub fn station_rpc(handle: u32, session: u32, text: &[u8]) {
    if let Ok(session) = u16::try_from(session) {
        with_station(handle, |station| station.rpc(session, text));
    }
}

/// Runs everything due at `now`, us. Returns when the next turn is due, or -1.
#[must_use]
pub fn station_turn(handle: u32, now: f64) -> f64 {
    with_station(handle, |station| station.turn(now))
        .flatten()
        .unwrap_or(-1.0)
}

/// Passes the next output to `show`; `None` without output. The output of handle 0 is the error of
/// the last failed opening.
pub fn station_out<T>(handle: u32, show: impl FnOnce(&[u8]) -> T) -> Option<T> {
    if handle > 0 {
        return with_station(handle, |station| station.out().map(show)).flatten();
    }
    TABLE.with_borrow_mut(|table| {
        let why = table.last_error.take()?;
        table.last_output = [&[0; 3], why.as_bytes()].concat();
        Some(show(&table.last_output))
    })
}

/// Passes bytes from the real arm of a station.
pub fn line_in(handle: u32, bytes: &[u8]) {
    with_station(handle, |station| station.line_in(bytes));
}

/// Reports that the line to the real arm broke.
pub fn line_lost(handle: u32) {
    with_station(handle, PageStation::line_lost);
}

/// Reports that the line is back.
pub fn line_found(handle: u32) {
    with_station(handle, PageStation::line_found);
}

/// Passes the result of reading a file to the station.
pub fn file_in(handle: u32, id: u32, answer: &[u8]) {
    with_station(handle, |station| station.file_in(id, answer));
}

/// Stores a program in the library of a station; on failure, passes the error to `show`.
pub fn program_in<T>(
    handle: u32,
    name: &[u8],
    bytes: &[u8],
    show: impl FnOnce(&[u8]) -> T,
) -> Option<T> {
    let stored = with_station(handle, |station| station.program_in(name, bytes));
    let why = stored.unwrap_or_else(|| Err("there is no such station".to_owned()));
    TABLE.with_borrow_mut(|table| {
        table.last_output = why.err()?.into_bytes();
        Some(show(&table.last_output))
    })
}

/// Passes a program from the library of a station to `show`; `None` if it does not exist.
pub fn program_out<T>(handle: u32, name: &[u8], show: impl FnOnce(&[u8]) -> T) -> Option<T> {
    with_station(handle, |station| station.program_out(name).map(show)).flatten()
}
