//! Trace of a proxy.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::time::SystemTime;

use magician_protocol::Direction;
use magician_record::trace::{TraceLink, TraceWriter};

/// Trace with an interface for each client and for the arm's line, by name.
pub(super) struct ProxyTrace {
    writer: TraceWriter<Box<dyn Write + Send>>,
    places: BTreeMap<String, TraceLink>,
}

impl ProxyTrace {
    pub(super) fn new(out: impl Write + Send + 'static) -> io::Result<Self> {
        let out: Box<dyn Write + Send> = Box::new(out);
        Ok(Self {
            writer: TraceWriter::new(out)?,
            places: BTreeMap::new(),
        })
    }

    pub(super) fn record(
        &mut self,
        name: &str,
        time: u64,
        direction: Direction,
        bytes: &[u8],
    ) -> io::Result<()> {
        let place = match self.places.get(name) {
            Some(place) => *place,
            None => {
                let place = self.writer.link(name)?;
                self.places.insert(name.to_owned(), place);
                place
            }
        };
        self.writer.record(place, time, direction, bytes)
    }

    /// Ends the interface of a client. The rest of an unfinished frame is written as it is.
    pub(super) fn close(&mut self, name: &str) -> io::Result<()> {
        let place = self.places.get(name);
        place.map_or(Ok(()), |place| self.writer.close(*place))
    }
}

/// Returns the microseconds since 1970.
pub(super) fn wall_clock() -> u64 {
    let since = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
    u64::try_from(since.as_micros()).unwrap_or(u64::MAX)
}
