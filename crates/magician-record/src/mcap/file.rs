//! The MCAP file: topics with their schemas, and messages in chunks.

use std::collections::BTreeMap;
use std::io::{self, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};
use serde::Serialize;

use super::Micros;
use super::message::Time;

/// Most bytes of a chunk. It is closed every second in any case, so this only bounds the memory of
/// busy seconds.
const MAX_CHUNK_BYTES: u64 = 256 * 1024;

/// Topic of a message.
#[derive(Clone, Copy)]
pub(super) enum Topic {
    Pose,
    Joints,
    Transforms,
    Scene,
    Queue,
    Io,
    Alarms,
    Status,
    Frames,
    Events,
}

macro_rules! schema {
    ($name:literal) => {
        ($name, include_str!(concat!("schema/", $name, ".json")))
    };
}

impl Topic {
    const ALL: [Self; 10] = [
        Self::Pose,
        Self::Joints,
        Self::Transforms,
        Self::Scene,
        Self::Queue,
        Self::Io,
        Self::Alarms,
        Self::Status,
        Self::Frames,
        Self::Events,
    ];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Pose => "/pose",
            Self::Joints => "/joints",
            Self::Transforms => "/tf",
            Self::Scene => "/scene",
            Self::Queue => "/queue",
            Self::Io => "/io",
            Self::Alarms => "/alarms",
            Self::Status => "/status",
            Self::Frames => "/frames",
            Self::Events => "/events",
        }
    }

    /// Name and text of the schema.
    const fn schema(self) -> (&'static str, &'static str) {
        match self {
            Self::Pose => schema!("foxglove.PoseInFrame"),
            Self::Joints => schema!("foxglove.JointStates"),
            Self::Transforms => schema!("foxglove.FrameTransform"),
            Self::Scene => schema!("foxglove.SceneUpdate"),
            Self::Queue => schema!("magician.Queue.v1"),
            Self::Io => schema!("magician.Io.v1"),
            Self::Alarms => schema!("magician.Alarms.v1"),
            Self::Status => schema!("magician.Status.v1"),
            Self::Frames => schema!("magician.Frame.v1"),
            Self::Events => schema!("foxglove.Log"),
        }
    }
}

/// A recording being written.
pub(super) struct File<W: Write> {
    writer: Writer<NoSeek<W>>,
    epoch: u64,
    channels: [Channel; Topic::ALL.len()],
    /// Buffer of one message, reused.
    text: Vec<u8>,
}

#[derive(Clone, Copy, Default)]
struct Channel {
    id: u16,
    sequence: u32,
}

impl<W: Write> File<W> {
    /// Begins a file. Header and metadata (name of the clock, its epoch, samples per second) are
    /// written at once, topics with the first messages.
    pub(super) fn begin(out: W, clock: &str, epoch: u64, rate: &str) -> io::Result<Self> {
        // Chunks are written in one piece, so a killed program leaves no half chunk in the middle.
        let options = WriteOptions::new()
            .compression(None)
            .disable_seeking(true)
            .chunk_size(Some(MAX_CHUNK_BYTES))
            .library(concat!("magician ", env!("CARGO_PKG_VERSION")));
        let mut writer = options.create(NoSeek::new(out)).map_err(io_error)?;
        let metadata = Metadata {
            name: "magician".to_owned(),
            metadata: BTreeMap::from([
                ("clock".to_owned(), clock.to_owned()),
                ("epoch_ns".to_owned(), epoch.to_string()),
                ("samples_per_second".to_owned(), rate.to_owned()),
            ]),
        };
        writer.write_metadata(&metadata).map_err(io_error)?;
        writer.flush().map_err(io_error)?;
        let mut channels = [Channel::default(); Topic::ALL.len()];
        for topic in Topic::ALL {
            let (name, text) = topic.schema();
            let schema = writer.add_schema(name, "jsonschema", text.as_bytes());
            let schema = schema.map_err(io_error)?;
            let id = writer.add_channel(schema, topic.name(), "json", &BTreeMap::new());
            channels[topic as usize].id = id.map_err(io_error)?;
        }
        Ok(Self {
            writer,
            epoch,
            channels,
            text: Vec::new(),
        })
    }

    /// Writes a message for an instant of the clock.
    pub(super) fn write<M: Serialize>(
        &mut self,
        topic: Topic,
        now: Micros,
        message: impl FnOnce(Time) -> M,
    ) -> io::Result<()> {
        let log_time = now.saturating_mul(1000).saturating_add(self.epoch);
        self.text.clear();
        serde_json::to_writer(&mut self.text, &message(Time::at(log_time)))?;
        let channel = &mut self.channels[topic as usize];
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.sequence,
            log_time,
            publish_time: log_time,
        };
        channel.sequence = channel.sequence.wrapping_add(1);
        let written = self.writer.write_to_known_channel(&header, &self.text);
        written.map_err(io_error)
    }

    /// Length of the last message, bytes.
    pub(super) const fn bytes(&self) -> usize {
        self.text.len()
    }

    /// Closes the chunk and flushes the writer.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.writer.flush().map_err(io_error)
    }

    /// Writes summary and index.
    pub(super) fn finish(mut self) -> io::Result<W> {
        self.writer.finish().map_err(io_error)?;
        let mut out = self.writer.into_inner().into_inner();
        out.flush()?;
        Ok(out)
    }
}

fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
