//! `arm.wasm`: a station with its arms in one WebAssembly module, without threads, sockets, files
//! or its own clock.
//!
//! A worker of a page drives it in turns. The page passes to [`PageStation::rpc`] the text that it
//! would send to another station over a socket.
//!
//! # The module
//!
//! | export | effect |
//! |---|---|
//! | `alloc(n) -> p`, `free(p, n)` | memory for arguments; 0 if out of memory. The caller may free it after the call |
//! | `station_open(p, n) -> h` | opens a station by its [configuration](config) (JSON); 0 on an error, which `station_out(0)` returns |
//! | `station_rpc(h, session, p, n)` | text of a session, 1 to 65535. A new number opens a session; an empty text (`n` 0) ends it and frees its number |
//! | `station_turn(h, now) -> next` | runs everything due at `now`, us of any clock that never goes back; returns when the next turn is due, on the same clock; -1: never |
//! | `station_out(h) -> p << 32 \| n` | next output: a byte for its kind, the session (two bytes, little endian), the payload. Valid until the next call; call again until 0 (no output) |
//! | `line_in(h, p, n)`, `line_lost(h)`, `line_found(h)` | the line to a real arm |
//! | `file_in(h, id, p, n)` | result of reading a file; empty (`n` 0) if the reader failed |
//! | `program_in(h, name, m, p, n) -> p << 32 \| n` | stores a program in the library, or the preset NAME if `name` is `preset+NAME.toml`; returns the error, or 0. Messages have room for small programs only |
//! | `program_out(h, name, m) -> p << 32 \| n` | returns a program; 0 if absent |
//!
//! Kinds of output: 0 text, 1 a binary frame, 2 bytes for the line, 3 the end of a session with its
//! close code (two bytes), 4 a trace, 5 a file to read: its id (four bytes), then the input of
//! `files.wasm`; without anything after the id the request is cancelled. Text of session 0 is from
//! the station itself: `{"ready":true,"arms":[..]}` once all arms are connected, or
//! `{"error":{"kind","message"}}` if that failed, after which only traces follow.
//!
//! The text `trace` to session 0 requests the recent traffic between driver and arms as a file
//! (`.pcapng`, [`trace`]). It is output as kind 4, even if no arm answered.
//!
//! Text, bytes and the state of the line are accepted at once and processed by the next turn, so
//! call `station_turn` after each. The clock advances before text is processed, so a page that was
//! suspended finds its jog stopped and its lease expired.
//!
//! Any call may grow the module's memory, which invalidates views on it: create them anew.
//! `node/shim.mjs` provides the module's imports and wraps its exports as functions of text and
//! bytes. `cargo xtask generate modules` builds both modules.
//!
//! # The other module
//!
//! `files.wasm` (feature `files`) contains the readers of `magician-formats`. They would block the
//! worker, which must always be able to receive a stop. It has no imports and exports `alloc` and
//! `free` as above, and `read(p, n) -> p << 32 | n`: it takes a request and returns its answer,
//! valid until the next call.

#[cfg(feature = "module")]
mod clock;
#[cfg(feature = "module")]
pub mod config;
#[cfg(all(feature = "module", target_family = "wasm"))]
mod exports;
#[cfg(feature = "module")]
mod files;
#[cfg(feature = "module")]
mod line;
#[cfg(feature = "module")]
mod page;
#[cfg(all(feature = "files", not(feature = "module"), target_family = "wasm"))]
mod readers;
#[cfg(feature = "module")]
mod stores;
#[cfg(feature = "module")]
pub mod table;
#[cfg(feature = "module")]
pub mod trace;

#[cfg(feature = "module")]
pub use page::PageStation;
