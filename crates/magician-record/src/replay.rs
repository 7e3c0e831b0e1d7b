//! Recorded sessions on a virtual arm: what hosts sent is sent again, and the answers are compared.
//!
//! A [`Replay`] is a [trace](crate::trace) that has been read; [`Replay::against`] hands its requests to a
//! [`Controller`] in the trace's own time, which costs what the motions cost and not what they take, and gives a
//! [`Report`]. So a trace that came with a bug report becomes a test:
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
//! # What counts as the same
//!
//! * Queue indices are rebased: the first answer with an index says how far the two sessions are apart, and only an
//!   index that breaks the row is a difference. The current index is held against the same distance.
//! * The arm's clock (`DeviceTime`) is rebased too: from one reading to the next both must have gone on by as much,
//!   within [`Tolerances::time_ms`]. If the trace holds a reading in its first hour of uptime, the virtual arm has been
//!   on for as long when the replay begins.
//! * Floats of values that can only be read (`Pose`, `PoseL`, ...) are measured: they may differ by
//!   [`Tolerances::measured`]. Settings must be equal bit for bit.
//! * What [`Replay::ignoring`] names is not looked at.
//! * A request that is unanswered in both is the same, and so is one that the trace ends too early for.
//!
//! Which answer belongs to which request is known by link, id, Ctrl and order; one that has waited for 3 s is given up,
//! so that a lost answer does not shift all that follow.
//!
//! The virtual arm begins as it is handed in. [`Replay::beginning`] makes it stand where the recorded one stood;
//! [`Replay::fitted`] finds where its periods of 20 ms begin, in steps of 1 ms: a trace does not tell. A pose of the
//! period before or after that was asked for within 5 ms of its end counts as the same ([`Report::late`]); at any other
//! time it is a difference ([`What::Period`]). What was set before the trace began is not known: give the
//! arm a profile that has it. Nothing here sends to a real arm.

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
pub use play::{Moment, Play};
pub use report::{Difference, Report, Residue, What};
#[cfg(feature = "mcap")]
pub(crate) use residue::values_of;
pub use saved::ReplayWriter;

pub use crate::trace::LINE_OF_ARM;

/// A longer trace has a clock that jumped.
const LONGEST: Duration = Duration::from_secs(31 * 24 * 3600);

/// Why a trace cannot be replayed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// It cannot be read.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// There is nothing in it.
    #[error("the trace is empty")]
    Empty,
    /// There is no packet that says it went to the arm.
    #[error(
        "the trace has no requests: none of its {packets} packets is marked as sent to the arm"
    )]
    NoRequests {
        /// Packets that there are.
        packets: usize,
    },
    /// No link has this name.
    #[error("the trace has no link '{name}'; it has {known}")]
    NoLink {
        /// The name.
        name: String,
        /// Those that there are, in words.
        known: String,
    },
    /// The clock went back on one direction of a link.
    #[error(
        "the trace's packets are out of order: packet {packet} was {by} us before the one before it on link '{link}'"
    )]
    Order {
        /// Number of the packet, from 1.
        packet: usize,
        /// The link.
        link: String,
        /// How far back.
        by: u64,
    },
    /// It is longer than a month: a clock has been set meanwhile.
    #[error("the trace covers {days} days, limit 31: was a clock changed while it was recorded?")]
    Span {
        /// How many days.
        days: u64,
    },
    /// Nothing has this name.
    #[error("'{name}' is neither a command, a COMMAND.FIELD nor a field")]
    NoSuchField {
        /// The name.
        name: String,
    },
}

/// How far two answers may be apart and still count as the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// For floats that are measured, in their own unit (mm, deg, ...).
    pub measured: f32,
    /// For what has passed between two readings of the arm's clock, ms.
    pub time_ms: u32,
}

impl Default for Tolerances {
    /// 0.01 mm or deg, and 100 ms.
    fn default() -> Self {
        Self {
            measured: 0.01,
            time_ms: 100,
        }
    }
}

/// A recorded session, ready to be replayed.
#[derive(Clone, Debug)]
pub struct Replay<'a> {
    /// In the order of time.
    packets: Vec<Packet<'a>>,
    tolerances: Tolerances,
    ignored: Vec<Ignored>,
    clock: Speed,
    /// How much longer the arm has been on when the session begins.
    shift: Duration,
}

/// What is not looked at: a field of a command, or either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Ignored {
    id: Option<u8>,
    field: Option<&'static str>,
}

impl<'a> Replay<'a> {
    /// Reads a trace file.
    ///
    /// # Errors
    /// [`ReplayError`] when it is no trace, damaged, empty, out of order, or holds no request.
    pub fn new(trace: &'a [u8]) -> Result<Self, ReplayError> {
        if trace.is_empty() {
            return Err(ReplayError::Empty);
        }
        let mut packets = Vec::new();
        let mut foreign = None;
        for packet in read_trace(trace) {
            match packet {
                Ok(packet) => packets.push(packet),
                // A link that carries something else has no part in this.
                Err(error @ TraceError::LinkType { .. }) => foreign = foreign.or(Some(error)),
                Err(error) => return Err(error.into()),
            }
        }
        if let (true, Some(error)) = (packets.is_empty(), foreign) {
            return Err(error.into());
        }
        in_order(&packets)?;
        // A run that never became a frame is written late, with the time at which it passed.
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

    /// Only what passed on the link of this name, or of this number in the file, from 0.
    ///
    /// # Errors
    /// [`ReplayError::NoLink`], and [`ReplayError::NoRequests`] when there is none on it.
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

    /// Leaves out a command (`GetPose`, `Pose`, `10`), a field of one (`Pose.joint_angle`) or every field of a name
    /// (`queued_cmd_index`).
    ///
    /// # Errors
    /// [`ReplayError::NoSuchField`].
    pub fn ignoring(mut self, name: &str) -> Result<Self, ReplayError> {
        let found = Ignored::named(name).ok_or_else(|| ReplayError::NoSuchField {
            name: name.to_owned(),
        })?;
        self.ignored.push(found);
        Ok(self)
    }

    /// How far answers may be apart.
    #[must_use]
    pub fn tolerances(mut self, tolerances: Tolerances) -> Self {
        self.tolerances = tolerances;
        self
    }

    /// How fast the recorded arm's clock ran: real time unless given. A trace of `magician sim --speed 20` wants 20.
    #[must_use]
    pub fn clock(mut self, clock: Speed) -> Self {
        self.clock = clock;
        self
    }

    /// The links, by number and name.
    #[must_use]
    pub fn links(&self) -> Vec<(u32, String)> {
        let links = self.packets.iter();
        let links = links.map(|packet| (packet.link, packet.link_name.to_string()));
        links.collect::<BTreeMap<_, _>>().into_iter().collect()
    }

    /// The arm's own line in the trace of a proxy, which has what its programs said beside it: sent as well, that would be done
    /// twice.
    #[must_use]
    pub fn line_of_arm(&self) -> Option<String> {
        let mut links = self.links().into_iter().map(|(_, name)| name);
        links.find(|name| name.starts_with(LINE_OF_ARM))
    }

    /// The packets that are replayed, in the order of time.
    #[must_use]
    pub fn packets(&self) -> &[Packet<'a>] {
        &self.packets
    }

    /// From the first packet to the last.
    #[must_use]
    pub fn span(&self) -> Duration {
        self.packets.last().map_or(Duration::ZERO, |last| {
            self.time(last.time) - HostInstant::ZERO
        })
    }

    /// The host's clock when a packet passed, which showed 0 at the first.
    fn time(&self, since_1970: u64) -> HostInstant {
        let begin = self.packets.first().map_or(0, |packet| packet.time);
        HostInstant::from_micros(since_1970.saturating_sub(begin))
    }

    /// What the recorded arm's clock showed when the trace began, if it tells.
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
                    // The arm read its clock when it was asked: at the answer that would show less than it did, and a command
                    // of the first microseconds would belong to the period before.
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

    /// Serial number of the recorded arm, if that was a virtual one that had it from its path or address.
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

    /// Begins to replay on this arm, for callers that look on as it goes.
    pub fn play<'r>(&'r self, arm: &'r mut Controller) -> Play<'r, 'a> {
        Play::new(self, arm)
    }

    /// Replays all on this arm.
    pub fn against(&self, arm: &mut Controller) -> Report {
        let mut play = self.play(arm);
        while play.step().is_some() {}
        play.finish()
    }
}

/// Times may only go back between directions and links: what waits for the rest of its frame is written last.
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
