//! Recording as readings, in any of the formats for data.

use std::io::{self, BufWriter};
use std::path::Path;
use std::time::SystemTime;

use magician::Event;
use magician_program::Tool;
use magician_record::csv::Csv;
use magician_record::jsonl::JsonLines;
use magician_record::{Reading, WriteReadings, mcap};

use super::sink::{Format, RecordingStart, Sink};
use super::{RecordError, unwritable};
use crate::files::WholeFile;

type Writer = Box<dyn WriteReadings + Send>;

/// Writer and file until it is complete. An incomplete file does not replace an existing one.
pub(super) struct Readings(Option<(Writer, WholeFile)>);

impl Readings {
    pub(super) fn open(
        path: &Path,
        format: Format,
        start: &RecordingStart,
    ) -> Result<Self, RecordError> {
        let mut file = WholeFile::grow(path).map_err(unwritable(path))?;
        let out = BufWriter::new(file.writer());
        let writer: Writer = match format {
            Format::Csv => Box::new(Csv::new(out, start.began, start.counts_steps, start.units)?),
            Format::Jsonl => Box::new(JsonLines::new(out)),
            _ => {
                let readings = mcap::Readings::new(out, unix(start.began), start.rate)?;
                Box::new(match start.paper {
                    None => readings,
                    Some(paper) => readings.on_paper(mcap::Plane {
                        height: paper.height,
                        slope: paper.slope,
                    }),
                })
            }
        };
        Ok(Self(Some((writer, file))))
    }

    fn writer(&mut self) -> io::Result<&mut Writer> {
        match &mut self.0 {
            Some((writer, _)) => Ok(writer),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }
}

/// Nanoseconds since 1970; 0 for earlier times.
fn unix(time: SystemTime) -> u64 {
    let since_1970 = time
        .duration_since(SystemTime::UNIX_EPOCH)
        .unwrap_or_default();
    u64::try_from(since_1970.as_nanos()).unwrap_or_default()
}

impl Sink for Readings {
    fn write(&mut self, reading: &Reading, _: Tool) -> Result<(), RecordError> {
        Ok(self.writer()?.write(reading)?)
    }

    fn note(&mut self, t: f64, event: &Event) -> Result<(), RecordError> {
        let warning = matches!(
            event,
            Event::AlarmRaised { .. }
                | Event::LinkLost { .. }
                | Event::Reset { .. }
                | Event::Missed { .. }
        );
        Ok(self.writer()?.note(t, warning, &event.to_string())?)
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        Ok(self.writer()?.flush()?)
    }

    fn finish(&mut self) -> Result<Option<usize>, RecordError> {
        if let Some((writer, file)) = self.0.take() {
            writer.finish()?;
            file.finish()?;
        }
        Ok(None)
    }
}
