//! The Dobot Magician protocol (V1.1.3 and later additions): frames, the command table, alarms.
//!
//! A codec and nothing else: bytes to values and values to bytes. There is no I/O, no clock, no
//! allocation and no dependency (`serde` is behind the feature of that name), so the crate also
//! runs in firmware.
//!
//! * [`Deframer`] finds frames in a byte stream that may be cut anywhere or damaged;
//!   [`Frame`] borrows a frame's bytes, [`FrameBuf`] owns them.
//! * [`commands`] is the protocol: one table with a row for each command. A row's layouts are
//!   structs ([`commands::Pose`], [`commands::PtpCmd`], ...) that implement [`Layout`].
//! * [`Request`] is a decoded request frame; [`Row`] and [`LayoutInfo`] describe a command to
//!   programs that discover its fields at run time (command line, JSON, documentation).
//! * [`Alarm`] and [`AlarmSet`] name the controller's alarms, with cause and remedy.
//! * [`ArmInstant`] and [`HostInstant`] are instants of the arm's clock and of the host's clock.
//!
//! Lengths are mm and angles degrees throughout. "Document" in a comment means the vendor's
//! description of the protocol; numbers such as E37 are its errata, listed in `docs/reference/ERRATA.md` of
//! the repository.
//!
//! ```
//! use magician_protocol::{Ctrl, Deframer, Event, FrameBuf, Layout, commands::Pose};
//!
//! // Ask for the pose ...
//! let request = FrameBuf::get(&magician_protocol::NoArgs, Pose::ROW)?;
//! assert_eq!(request.bytes(), [0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6]);
//!
//! // ... and read the answer that a real arm gave.
//! let answer = [
//!     0xAA, 0xAA, 0x22, 0x0A, 0x00, 0xB0, 0x0A, 0x42, 0x43, 0x36, 0x85, 0x95, 0x42, 0x94, 0xE8,
//!     0x06, 0x43, 0xA0, 0x90, 0xA8, 0x41, 0xA0, 0x90, 0xA8, 0x41, 0x00, 0xB6, 0xBD, 0xBC, 0x98,
//!     0x0C, 0x12, 0x3D, 0x00, 0x00, 0x00, 0x00, 0x0C,
//! ];
//! let mut deframer = Deframer::new();
//! let mut input = &answer[..];
//! let Some(Event::Frame { frame, .. }) = deframer.next(&mut input) else { panic!() };
//! let pose = Pose::decode(frame.params())?;
//! assert_eq!(pose.x, 194.04175);
//! # use magician_protocol::Readable;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(test)]
extern crate std;

mod alarm;
mod check;
mod clock;
mod deframer;
mod describe;
mod enums;
mod error;
mod frame;
mod layout;
mod list;
mod message;
mod motor;
mod parse;
mod range;
mod row;
#[cfg(feature = "serde")]
mod serialize;
#[macro_use]
mod table;
mod text;
mod tool;
mod visible;
mod wire;

pub mod commands;

pub use alarm::{Alarm, AlarmGroup, AlarmSet};
pub use check::{Number, RangeError};
pub use clock::{ArmInstant, HostInstant};
pub use commands::{Get, Set, TABLE};
pub use deframer::{Deframer, Event, Rejection};
pub use describe::{Description, Direction, MAX_NOTES, describe};
pub use enums::{
    CpMode, Flag, Handedness, IoFunction, JogCommand, Port, PtpMode, RailVersion, SensorVersion,
    Stepper, TeachTrigger, TriggerCondition, TriggerMode,
};
pub use error::{DecodeError, EncodeError};
#[cfg(feature = "counters")]
#[doc(hidden)]
pub use frame::ENCODED;
pub use frame::{
    BAUD_RATE, Ctrl, Frame, FrameBuf, HEADER, INTER_BYTE_TIMEOUT_MS, MAX_FRAME, MAX_PARAMS,
    UDP_PORT, checksum,
};
pub use layout::{Field, FieldValue, Fields, Form, FormKind, LayoutInfo, Normalised};
pub use list::{PoCmd, PoList};
pub use message::{QueuedCmdIndex, Request};
pub use parse::{ParseError, encode_text};
pub use range::{Bounds, Case, Range};
pub use row::{Chapter, Confidence, Effect, NameError, Row, Source};
pub use text::{Bytes, Text};
pub use visible::{Markup, Visible, is_deceptive, markup, visible, visible_lines};
pub use wire::{EnumInfo, FieldType, Layout, NoArgs, Reader, Scalar, Variant, Wire, Writer};
pub use wire::{Queueable, Readable, Writable};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
