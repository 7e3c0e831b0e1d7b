//! The replayed session as a trace.

use std::collections::BTreeMap;
use std::io::{self, Write};

use magician_protocol::Direction;

use super::{Replay, ReplayedPacket};
use crate::trace::{TraceLink, TraceWriter};

/// Writes a replayed session as a trace: the requests as recorded, with the new answers.
pub struct ReplayWriter<W: Write> {
    writer: TraceWriter<W>,
    links: BTreeMap<u32, TraceLink>,
}

impl<W: Write> ReplayWriter<W> {
    /// Writes the header and the links of this replay.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn new(out: W, replay: &Replay<'_>) -> io::Result<Self> {
        let mut writer = TraceWriter::new(out)?;
        let mut links = BTreeMap::new();
        for (number, name) in replay.links() {
            links.insert(number, writer.link(&name)?);
        }
        Ok(Self { writer, links })
    }

    /// Writes a replayed packet.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write(&mut self, moment: &ReplayedPacket<'_>) -> io::Result<()> {
        let packet = moment.packet;
        let Some(link) = self.links.get(&packet.link) else {
            return Ok(());
        };
        if packet.direction == Some(Direction::Request) {
            (self.writer).record(*link, packet.time, Direction::Request, packet.bytes)?;
        }
        for reply in &moment.replies {
            (self.writer).record(*link, packet.time, Direction::Reply, reply.bytes())?;
        }
        Ok(())
    }
}
