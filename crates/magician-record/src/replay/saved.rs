//! The new session as a trace.

use std::collections::BTreeMap;
use std::io::{self, Write};

use magician_protocol::Direction;

use super::{Moment, Replay};
use crate::trace::{TraceLink, TraceWriter};

/// Writes the session that a replay makes as a trace: the requests as they were, the answers that came now.
pub struct ReplayWriter<W: Write> {
    writer: TraceWriter<W>,
    links: BTreeMap<u32, TraceLink>,
}

impl<W: Write> ReplayWriter<W> {
    /// Begins the file, with the links of this replay.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn new(out: W, replay: &Replay<'_>) -> io::Result<Self> {
        let mut writer = TraceWriter::new(out)?;
        let mut links = BTreeMap::new();
        for (number, name) in replay.links() {
            links.insert(number, writer.link(&name)?);
        }
        Ok(Self { writer, links })
    }

    /// Writes a packet that has been replayed.
    ///
    /// # Errors
    /// What the writer reports.
    pub fn write(&mut self, moment: &Moment<'_>) -> io::Result<()> {
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
