//! What the driver says (`tracing`), for Python's `logging`: the logger `magician`.

use std::fmt::{self, Write as _};

use pyo3::prelude::*;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Metadata, Subscriber, span};

use crate::runtime::{News, tell};

/// A line for the log.
pub(crate) struct Record {
    level: u8,
    message: String,
}

impl Record {
    /// Hands it to `logging`. A handler that fails is `logging`'s to report.
    pub(crate) fn write(&self, py: Python<'_>) {
        let logged = py.import("logging").and_then(|logging| {
            let logger = logging.call_method1("getLogger", ("magician",))?;
            logger.call_method1("log", (self.level, "%s", &self.message))
        });
        drop(logged);
    }
}

/// Takes what the driver says from `DEBUG` up; single frames (`TRACE`) are not for it.
struct Log;

impl Subscriber for Log {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() <= Level::DEBUG && metadata.target().starts_with("magician")
    }

    fn max_level_hint(&self) -> Option<tracing::level_filters::LevelFilter> {
        Some(tracing::level_filters::LevelFilter::DEBUG)
    }

    fn new_span(&self, _: &span::Attributes<'_>) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record<'_>) {}

    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}

    fn event(&self, event: &Event<'_>) {
        let mut line = Line::default();
        event.record(&mut line);
        let level = match *event.metadata().level() {
            Level::ERROR => 40,
            Level::WARN => 30,
            Level::INFO => 20,
            _ => 10,
        };
        tell(News::Log(Record {
            level,
            message: line.message + &line.rest,
        }));
    }

    fn enter(&self, _: &span::Id) {}

    fn exit(&self, _: &span::Id) {}
}

/// The message, and then the fields as `name=value`.
#[derive(Default)]
struct Line {
    message: String,
    rest: String,
}

impl Visit for Line {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        let _ = match field.name() {
            "message" => write!(self.message, "{value:?}"),
            name => write!(self.rest, " {name}={value:?}"),
        };
    }
}

/// From now on. Another listener to `tracing` in this process keeps listening, alone.
pub(crate) fn begin() {
    let _ = tracing::subscriber::set_global_default(Log);
}
