//! Replay: sends the requests of a recorded session to a virtual arm, and compares the answers.
//!
//! A [`Replay`] is a [trace](crate::trace) in memory. [`Replay::against`] sends its requests to a
//! [`Controller`] in the trace's own time and returns a [`Report`]. The arm's time is virtual, so
//! an hour's session is replayed in far less. A trace attached to a bug report becomes a test:
//!
//! ```
//! use magician_sim::Controller;
//! use magician_record::replay::Replay;
//!
//! # let file = tempfile::NamedTempFile::new()?;
//! # let path = file.path();
//! # {
//! #     use magician_protocol::Direction::{Reply, Request};
//! #     use magician_record::trace::TraceWriter;
//! #     let mut trace = TraceWriter::new(std::fs::File::create(path)?)?;
//! #     let link = trace.link("arm")?;
//! #     trace.record(link, 1, Request, &[0xAA, 0xAA, 0x04, 0x03, 0x01, 0x01, 0x00, 0xFB])?;
//! #     trace.record(link, 2, Reply, &[0xAA, 0xAA, 0x02, 0x03, 0x01, 0xFC])?;
//! # }
//! // In a test: let path = "tests/reports/the_arm_forgot_its_rail.pcapng";
//! let trace = std::fs::read(path)?;
//! let report = Replay::new(&trace)?.against(&mut Controller::default());
//! assert_eq!(report.differences, []);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Equality of answers
//!
//! * Queue indices are rebased: the first answer with an index gives the distance between both
//!   sessions, and only an index that breaks the sequence is a difference. The current index is
//!   compared with the same distance.
//! * The arm's clock (`DeviceTime`) is rebased too: from one reading to the next both must advance
//!   by the same time, within [`Tolerances::time_ms`]. If the trace has a reading within the first
//!   hour of uptime, the virtual arm starts with the same uptime.
//! * Floats of values that can only be read (`Pose`, `PoseL`, ...) are measurements and may differ
//!   by [`Tolerances::measured`]. Settings must be equal bit for bit.
//! * Commands and fields named by [`Replay::ignoring`] are not compared.
//! * A request that has no answer in both sessions is equal, and so is a request whose answer would
//!   come after the end of the trace.
//!
//! Answers are matched to requests by link, id, Ctrl and order. A request is given up after 3 s, so
//! a lost answer does not shift all later ones.
//!
//! # State at the start
//!
//! The virtual arm starts as passed in. [`Replay::beginning`] puts it where the recorded arm stood.
//! [`Replay::fitted`] finds the phase of its 20 ms periods, in steps of 1 ms, because a trace does
//! not contain it. The pose of a neighbouring period counts as equal if it was read within 5 ms of
//! the boundary ([`Report::late`]); at any other time it is a difference
//! ([`DifferenceKind::Period`]). Settings made before the trace began are unknown: pass an arm
//! whose profile has them. A replay never sends to a real arm.

use std::collections::BTreeMap;
use std::time::Duration;

use magician_protocol::{Direction, Frame, Layout, Readable, Row, TABLE, commands};
use thiserror::Error;

use crate::trace::{Packet, TraceError, read_trace};
use magician_sim::{ArmInstant, Controller, HostInstant, Speed};

mod beginning;
mod compare;
mod fit;
mod play;
mod report;
mod residue;
mod saved;

#[cfg(feature = "mcap")]
pub(crate) use play::JITTER;
pub use play::{Play, ReplayedPacket};
pub use report::{Difference, DifferenceKind, Report, Residue};
#[cfg(feature = "mcap")]
pub(crate) use residue::values_of;
pub use saved::ReplayWriter;

pub use crate::trace::LINE_OF_ARM;

/// Longest accepted trace. A longer one contains a jump of the clock.
const LONGEST: Duration = Duration::from_secs(31 * 24 * 3600);

/// Reason why a trace cannot be replayed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The trace cannot be read.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// The trace has no packets.
    #[error("the trace is empty")]
    Empty,
    /// No packet is marked as sent to the arm.
    #[error(
        "the trace has no requests: none of its {packets} packets is marked as sent to the arm"
    )]
    NoRequests {
        /// Number of packets.
        packets: usize,
    },
    /// The trace has no link with this name.
    #[error("the trace has no link '{name}'; it has {known}")]
    NoLink {
        /// The name.
        name: String,
        /// Existing links, as text.
        known: String,
    },
    /// Times went back within one direction of a link.
    #[error(
        "the trace's packets are out of order: packet {packet} was {by} us before the one before it on link '{link}'"
    )]
    Order {
        /// Number of the packet, from 1.
        packet: usize,
        /// The link.
        link: String,
        /// Step back, us.
        by: u64,
    },
    /// The trace is longer than a month: a clock was set while it was recorded.
    #[error("the trace covers {days} days, limit 31: was a clock changed while it was recorded?")]
    Span {
        /// Length in days.
        days: u64,
    },
    /// No command or field has this name.
    #[error("'{name}' is neither a command, a COMMAND.FIELD nor a field")]
    NoSuchField {
        /// The name.
        name: String,
    },
}

/// Largest differences at which two answers count as equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Difference of measured floats, in their own unit (mm, deg, ...).
    pub measured: f32,
    /// Difference of the time between two readings of the arm's clock, ms.
    pub time_ms: u32,
}

impl Default for Tolerances {
    /// 0.01 mm or deg, and 100 ms.
    fn default() -> Self {
        // A pose is printed to 0.01 by most hosts; 100 ms are above any delay of an answer.
        // Choices.
        Self {
            measured: 0.01,
            time_ms: 100,
        }
    }
}

/// A recorded session, ready to be replayed.
#[derive(Clone, Debug)]
pub struct Replay<'a> {
    /// Packets in order of time.
    packets: Vec<Packet<'a>>,
    tolerances: Tolerances,
    ignored: Vec<Ignored>,
    clock: Speed,
    /// Additional uptime of the arm when the session begins.
    shift: Duration,
}

/// Exclusion from the comparison: a command, a field of a command, or a field of all commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Ignored {
    id: Option<u8>,
    field: Option<&'static str>,
}

impl<'a> Replay<'a> {
    /// Parses a trace file.
    ///
    /// # Errors
    /// [`ReplayError`] if it is not a trace, is damaged, empty or out of order, or has no request.
    pub fn new(trace: &'a [u8]) -> Result<Self, ReplayError> {
        if trace.is_empty() {
            return Err(ReplayError::Empty);
        }
        let mut packets = Vec::new();
        let mut foreign = None;
        for packet in read_trace(trace) {
            match packet {
                Ok(packet) => packets.push(packet),
                // Links of another type do not matter.
                Err(error @ TraceError::LinkType { .. }) => foreign = foreign.or(Some(error)),
                Err(error) => return Err(error.into()),
            }
        }
        if let (true, Some(error)) = (packets.is_empty(), foreign) {
            return Err(error.into());
        }
        in_order(&packets)?;
        // Bytes that never became a frame are written late, with their own time.
        packets.sort_by_key(|packet| packet.time);
        let replay = Self {
            packets,
            tolerances: Tolerances::default(),
            ignored: Vec::new(),
            clock: Speed::default(),
            shift: Duration::ZERO,
        };
        replay.check()?;
        Ok(replay)
    }

    fn check(&self) -> Result<(), ReplayError> {
        let requests = |packet: &Packet<'_>| packet.direction == Some(Direction::Request);
        if self.packets.is_empty() {
            return Err(ReplayError::Empty);
        }
        if !self.packets.iter().any(requests) {
            let packets = self.packets.len();
            return Err(ReplayError::NoRequests { packets });
        }
        if self.span() > LONGEST {
            let days = self.span().as_secs() / (24 * 3600);
            return Err(ReplayError::Span { days });
        }
        Ok(())
    }

    /// Restricts the replay to the link of this name, or of this number in the file, from 0.
    ///
    /// # Errors
    /// [`ReplayError::NoLink`], and [`ReplayError::NoRequests`] if it has none.
    pub fn only_link(mut self, name: &str) -> Result<Self, ReplayError> {
        let links = self.links();
        let named = |(number, link): &(u32, String)| link == name || number.to_string() == name;
        let wanted: Vec<u32> = (links.iter().filter(|link| named(link)))
            .map(|(number, _)| *number)
            .collect();
        if wanted.is_empty() {
            let known: Vec<String> = links.iter().map(|(_, name)| format!("'{name}'")).collect();
            return Err(ReplayError::NoLink {
                name: name.to_owned(),
                known: known.join(", "),
            });
        }
        self.packets.retain(|packet| wanted.contains(&packet.link));
        self.check()?;
        Ok(self)
    }

    /// Excludes a command (`GetPose`, `Pose`, `10`), a field of one (`Pose.joint_angle`) or a field
    /// of any command (`queued_cmd_index`) from the comparison.
    ///
    /// # Errors
    /// [`ReplayError::NoSuchField`] if the name is unknown.
    pub fn ignoring(mut self, name: &str) -> Result<Self, ReplayError> {
        let found = Ignored::named(name).ok_or_else(|| ReplayError::NoSuchField {
            name: name.to_owned(),
        })?;
        self.ignored.push(found);
        Ok(self)
    }

    /// Sets the tolerances.
    #[must_use]
    pub fn tolerances(mut self, tolerances: Tolerances) -> Self {
        self.tolerances = tolerances;
        self
    }

    /// Sets the speed of the recorded arm's clock; real time by default. A trace of
    /// `magician sim --speed 20` needs 20.
    #[must_use]
    pub fn clock(mut self, clock: Speed) -> Self {
        self.clock = clock;
        self
    }

    /// Links, by number and name.
    #[must_use]
    pub fn links(&self) -> Vec<(u32, String)> {
        let links = self.packets.iter();
        let links = links.map(|packet| (packet.link, packet.link_name.to_string()));
        links.collect::<BTreeMap<_, _>>().into_iter().collect()
    }

    /// Name of the line to the arm in the trace of a proxy; `None` in other traces.
    ///
    /// Such a trace also has the lines of the programs. Replaying both would execute everything
    /// twice.
    #[must_use]
    pub fn line_of_arm(&self) -> Option<String> {
        let mut links = self.links().into_iter().map(|(_, name)| name);
        links.find(|name| name.starts_with(LINE_OF_ARM))
    }

    /// Packets to replay, in order of time.
    #[must_use]
    pub fn packets(&self) -> &[Packet<'a>] {
        &self.packets
    }

    /// Time from the first packet to the last.
    #[must_use]
    pub fn span(&self) -> Duration {
        self.packets.last().map_or(Duration::ZERO, |last| {
            self.time(last.time) - HostInstant::ZERO
        })
    }

    /// Time of a packet on the host's clock, which shows 0 at the first packet.
    fn time(&self, since_1970: u64) -> HostInstant {
        let begin = self.packets.first().map_or(0, |packet| packet.time);
        HostInstant::from_micros(since_1970.saturating_sub(begin))
    }

    /// Uptime of the recorded arm when the trace began; `None` if unknown.
    fn uptime(&self) -> Option<ArmInstant> {
        let row = commands::DeviceTime::ROW;
        let mut asked = None;
        let mut readings = self.packets.iter().filter_map(|packet| {
            let frame = Frame::new(packet.bytes).filter(|frame| frame.id() == row.id)?;
            match packet.direction? {
                Direction::Request => {
                    asked = Some(packet.time);
                    None
                }
                Direction::Reply => {
                    let read = commands::DeviceTime::decode(frame.params()).ok()?;
                    // The arm reads its clock when the request arrives. The time of the answer
                    // would give too low an uptime, and would move a command in the first
                    // microseconds of a period into the previous one.
                    Some((asked.unwrap_or(packet.time), read))
                }
            }
        });
        let (time, reading) = readings.next()?;
        let Speed::Times(times) = self.clock else {
            return None;
        };
        let since = (self.time(time).as_micros() as f64 * times) as u64;
        let uptime = (u64::from(reading.g_systick) * 1000).checked_sub(since)?;
        Some(ArmInstant::from_micros(uptime))
    }

    /// Serial number of the recorded arm if it was a virtual one, derived from its path or address.
    fn virtual_serial(&self) -> Option<String> {
        let row = commands::DeviceSn::ROW;
        self.packets.iter().find_map(|packet| {
            let frame = Frame::new(packet.bytes)?;
            let reply = packet.direction == Some(Direction::Reply) && frame.id() == row.id;
            let read = reply.then(|| commands::DeviceSn::decode(frame.params()))?;
            let serial = read.ok()?.device_sn.to_string();
            serial.starts_with("SIM").then_some(serial)
        })
    }

    /// Starts a replay on this arm, for callers that observe each step.
    pub fn play<'r>(&'r self, arm: &'r mut Controller) -> Play<'r, 'a> {
        Play::new(self, arm)
    }

    /// Replays everything on this arm.
    pub fn against(&self, arm: &mut Controller) -> Report {
        let mut play = self.play(arm);
        while play.step().is_some() {}
        play.finish()
    }
}

/// Checks that times never go back within one direction of a link. Elsewhere they may, because an
/// incomplete frame is written last.
fn in_order(packets: &[Packet<'_>]) -> Result<(), ReplayError> {
    let mut last = BTreeMap::new();
    for (at, packet) in packets.iter().enumerate() {
        let reply = packet
            .direction
            .map(|direction| direction == Direction::Reply);
        let before = last.insert((packet.link, reply), packet.time);
        if let Some(by) = before.and_then(|time| time.checked_sub(packet.time))
            && by > 0
        {
            return Err(ReplayError::Order {
                packet: at + 1,
                link: packet.link_name.to_string(),
                by,
            });
        }
    }
    Ok(())
}

impl Ignored {
    fn named(name: &str) -> Option<Self> {
        if let Some((command, field)) = name.split_once('.') {
            let row = Row::find(command).ok()?;
            let layouts = [row.value, Some(magician_protocol::QueuedCmdIndex::INFO)];
            let field = layouts.into_iter().flatten().find_map(|l| l.field(field))?;
            return Some(Self {
                id: Some(row.id),
                field: Some(field.name),
            });
        }
        if let Ok(row) = Row::find(name) {
            let id = Some(row.id);
            return Some(Self { id, field: None });
        }
        let index = std::iter::once(magician_protocol::QueuedCmdIndex::INFO);
        let layouts = TABLE.iter().filter_map(|row| row.value).chain(index);
        let field = layouts.filter_map(|layout| layout.field(name)).next()?;
        Some(Self {
            id: None,
            field: Some(field.name),
        })
    }

    fn covers(&self, id: u8, field: Option<&str>) -> bool {
        self.id.is_none_or(|own| own == id) && self.field.is_none_or(|own| Some(own) == field)
    }
}
