//! A server that owns one or more Dobot Magician arms and shares them among many programs: many
//! clients watch, one moves, anyone stops.
//!
//! [`Station`] is the core: a state machine without I/O and without a clock. A caller feeds it the
//! JSON-RPC text of each socket, the instant at which it arrived, and the reports of the arms
//! ([`ArmReport`]). It returns text and binary frames for the sockets ([`Outgoing`]), orders for
//! the arms ([`ArmOrder`]), and what has to be written to disk.
//!
//! Three layers surround the core:
//!
//! * [`ArmEngine`] carries out the orders of one arm over the async driver ([`magician::Arm`]).
//! * [`RunningStation`] joins station, engines and a clock on a tokio runtime.
//! * `http` (a feature) serves [`RunningStation`] over WebSocket and HTTP; `link` (a feature)
//!   serves programs written for the vendor's DobotLink.
//!
//! [`control`] alone decides who may move an arm: leases, turns, jogs, jobs. All other modules ask
//! it. `client` (a feature) is the other end: a client of a station elsewhere.
//!
//! A station is a convenience, not a safety function. The emergency stop of the arm is its power
//! switch.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod api;
#[cfg(feature = "class")]
pub mod class;
#[cfg(feature = "client")]
pub mod client;
pub mod control;
mod digest;
mod disk_writer;
mod engine;
mod fair;
mod fence;
mod files;
mod frame;
mod frames;
#[cfg(feature = "http")]
pub mod http;
mod job;
mod job_store;
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
pub use files::{FilePreparation, FilePreparer, LocalPreparer, PendingAnswer};
pub use frame::{FRAME_FIELDS, FRAME_SIZE, FrameError, StateFrame};
pub use frames::{FrameRing, RingPosition, TrafficPiece};
pub use job::{
    ConversionResult, FormatReader, PendingResult, ProgramReading, Reader, ReadingArm, Source,
    SourceBytes,
};
pub use job_store::{JobStore, NoJobStore, StoredRun};
pub use library::{
    LibraryAct, LibraryError, LibraryOrder, LibraryQuotas, LibraryUse, MAX_PROGRAM_SIZE,
    NoPrograms, OverQuota, OverwritePolicy, ProgramEntry, ProgramName, ProgramStore, Upload,
};
pub use names::{MAX_NAME_LENGTH, is_name};
pub use order::{
    ArmAct, ArmOrder, ArmRead, ArmReport, Fault, JobEnd, JobOrder, JobStart, JobUpdate, Outcome,
    WorldAct,
};
pub use presets::PresetAct;
pub use reading::{ArmReading, STATE_FIELDS, ToolReading};
pub use recording::{
    NoRecordings, Note, RecordOrder, RecordReport, RecordingFile, RecordingStore, Sample,
};
#[cfg(feature = "class")]
pub use roster::Roster;
pub use running::{Client, JournalSink, RunningStation};
pub use station::{
    ArmEntry, CloseCode, EndReport, FileSnapshot, ForcedStop, Grant, JobsSnapshot, JournalLine,
    LIST_INTERVAL, MAX_MESSAGE_SIZE, MAX_MESSAGES_PER_SECOND, MAX_REQUESTS_IN_FLIGHT, MAX_SOCKETS,
    MAX_VIEWERS, Next, Outbox, Outgoing, Peer, RateVerdict, SocketId, Station, StationConfig,
    StationSize, TeachAct, Throttle, check_jobs, damaged_jobs,
};
pub use surface::{ArmSurface, KnownSurface, MemorySurfaces, SurfaceStore};

/// Size of a socket's read buffer, bytes. The WebSocket library zeroes the whole buffer on each
/// read. Its default of 128 KiB made that cost as high as all other work of an idle station.
#[cfg(any(feature = "http", feature = "client", feature = "link"))]
pub(crate) const READ_BUFFER: usize = 4096;

/// Compiles the program in the README as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
