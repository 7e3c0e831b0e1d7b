//! `arm.wasm`: a station with its arms in one WebAssembly module without thread, socket, file or clock of its own. A worker of a page turns
//! it by hand; what a client of a station says over a socket elsewhere it says here by [`PageStation::rpc`].
//!
//! # The module
//!
//! | export | does |
//! |---|---|
//! | `alloc(n) -> p`, `free(p, n)` | memory for what is handed in; 0 where no more can be had. It may be given back when the call is over |
//! | `station_open(p, n) -> h` | opens a station by its [configuration](config) (JSON); 0 if something is wrong with it: `station_out(0)` says what |
//! | `station_rpc(h, session, p, n)` | text of a session, 1 to 65535. A new number opens one; without text (`n` 0) it ends, and its number is free |
//! | `station_turn(h, now) -> next` | does what is due at `now`, us of any clock that does not go back; when it wants to be turned next, on the same clock; -1: never |
//! | `station_out(h) -> p << 32 \| n` | what comes out, until 0: a byte for its kind, the session (two bytes, little endian), then the payload. It lies there until the next call |
//! | `line_in(h, p, n)`, `line_lost(h)`, `line_found(h)` | the line to a real arm |
//! | `file_in(h, id, p, n)` | what came of a file that was to be read; nothing (`n` 0) where the reader failed |
//! | `program_in(h, name, m, p, n) -> p << 32 \| n` | keeps a program in the library without a message, which has room for small ones only, or the preset NAME as `preset+NAME.toml`; why not, or 0 |
//! | `program_out(h, name, m) -> p << 32 \| n` | shows one; 0 if there is none |
//!
//! Kinds that come out: 0 text, 1 a binary frame, 2 bytes for the line, 3 the end of a session with its close code (two bytes), 4 a trace, 5 a file to
//! be read: its id (four bytes), then what `files.wasm` takes; nothing behind the id where it is wanted no more. Text of session 0 is the station's
//! own: `{"ready":true,"arms":[..]}` when all arms are connected, `{"error":{"kind","message"}}` if that went wrong, after which nothing comes
//! but traces.
//!
//! The text `trace` to session 0 asks for what passed between driver and arms lately, as a file (`.pcapng`, [`trace`]): it comes out as kind 4, also
//! where no arm answered.
//!
//! Text, bytes and the state of the line are taken at once and acted upon by the next turn: turn behind each call. The clock is put
//! forward before text is read, so that a page that was asleep finds its jog ended and its lease gone.
//!
//! Memory of the module may grow with every call: make views on it anew. `node/shim.mjs` is what it imports, and all of this as functions; `build`
//! makes both modules.
//!
//! # The other module
//!
//! `files.wasm` (feature `files`) is the readers of `magician-formats`, which would block the worker that must hear a stop. It has no imports,
//! and exports `alloc`, `free` as above and `read(p, n) -> p << 32 | n`: a request in, its answer out, which lies there until the next call.

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
