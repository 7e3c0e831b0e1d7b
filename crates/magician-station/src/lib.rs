//! One Dobot Magician arm, many programs: a station owns arms by name, lets many look, one move, and anybody stop.
//!
//! [`Station`] is the whole of it without I/O and clock: JSON-RPC text of clients goes in, text and frames for them come out,
//! and orders for the arms ([`ArmOrder`]), whose reports ([`ArmReport`]) go in again. Who may move an arm is decided in
//! [`control`] alone. [`ArmEngine`] carries the orders out on arms of the driver.
//!
//! This is a convenience, not a safety function: the arm has a power switch.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod api;
#[cfg(feature = "class")]
pub mod class;
#[cfg(feature = "client")]
pub mod client;
pub mod control;
mod engine;
mod fair;
mod fence;
mod files;
mod frame;
mod frames;
#[cfg(feature = "http")]
pub mod http;
mod job;
mod keeper;
mod library;
#[cfg(feature = "link")]
pub mod link;
mod names;
mod order;
mod presets;
mod reading;
mod recording;
#[cfg(feature = "class")]
mod roster;
mod running;
mod secret;
mod station;
mod surface;

pub use api::Role;
pub use engine::ArmEngine;
pub use files::{AnswerToCome, FilePreparation, FilePreparer, PrepareHere};
pub use frame::{FRAME, FRAME_FIELDS, FrameError, StateFrame};
pub use frames::{FrameRing, Mark, PassedBytes};
pub use job::{
    Converting, FormatReader, JobStore, KeptRun, NoStore, ProgramReading, Reader, ReadingArm,
    Source, SourceBytes, ToCome,
};
pub use library::{
    LARGEST_PROGRAM, LibraryAct, LibraryError, LibraryOrder, LibraryQuotas, LibraryUse, NoPrograms,
    OverQuota, ProgramEntry, ProgramName, ProgramStore, Upload,
};
pub use names::{LONGEST_NAME, is_name};
pub use order::{
    ArmAct, ArmOrder, ArmRead, ArmReport, Fault, JobEnd, JobNews, JobOrder, JobStart, Outcome,
    WorldAct,
};
pub use presets::PresetAct;
pub use reading::{ArmReading, FIELDS, ToolReading};
pub use recording::{
    NoRecordings, Note, RecordOrder, RecordReport, RecordingFile, RecordingStore, Sample,
};
#[cfg(feature = "class")]
pub use roster::Roster;
pub use running::{Client, JournalSink, RunningStation};
pub use station::{
    ArmEntry, CloseCode, CutOff, FileToKeep, Grant, JobsToKeep, JournalLine, LIST_INTERVAL,
    MESSAGE, Next, Outbox, Outgoing, Pace, Peer, RATE, RunsEnd, SOCKETS, SocketId, Station,
    StationConfig, StationSize, Throttle, UNDER_WAY, VIEWERS, check_jobs, damaged_jobs,
};
pub use surface::{ArmSurface, KnownSurface, MemorySurfaces, SurfaceStore};

/// Bytes that a socket reads at once. The WebSocket library clears as many each time it looks whether
/// there is anything, and its own 128 KiB cost as much as all else that a station at rest does.
#[cfg(any(feature = "http", feature = "client", feature = "link"))]
pub(crate) const READ_BUFFER: usize = 4096;

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
