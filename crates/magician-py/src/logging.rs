//! Forwards the driver's `tracing` events to Python's `logging`, as logger `magician`.

use std::fmt::{self, Write as _};

use pyo3::prelude::*;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Metadata, Subscriber, span};

use crate::runtime::{Notification, notify};

/// Log record.
pub(crate) struct Record {
    level: u8,
    message: String,
}

impl Record {
    /// Passes the record to `logging`, which itself reports handlers that fail.
    pub(crate) fn write(&self, py: Python<'_>) {
        let logged = py.import("logging").and_then(|logging| {
            let logger = logging.call_method1("getLogger", ("magician",))?;
            logger.call_method1("log", (self.level, "%s", &self.message))
        });
        drop(logged);
    }
}

/// Subscriber for events of level `DEBUG` and above. Single frames (`TRACE`) are left out: too many
/// for Python.
struct Log;

impl Subscriber for Log {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        // Events of other crates would surprise users of the `magician` logger.
        *metadata.level() <= Level::DEBUG && metadata.target().starts_with("magician")
    }

    fn max_level_hint(&self) -> Option<tracing::level_filters::LevelFilter> {
        Some(tracing::level_filters::LevelFilter::DEBUG)
    }

    fn new_span(&self, _: &span::Attributes<'_>) -> span::Id {
        // Spans are not recorded, so one id serves all.
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record<'_>) {}

    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}

    fn event(&self, event: &Event<'_>) {
        let mut line = Line::default();
        event.record(&mut line);
        // Numeric levels of `logging`.
        let level = match *event.metadata().level() {
            Level::ERROR => 40,
            Level::WARN => 30,
            Level::INFO => 20,
            _ => 10,
        };
        notify(Notification::Log(Record {
            level,
            message: line.message + &line.rest,
        }));
    }

    fn enter(&self, _: &span::Id) {}

    fn exit(&self, _: &span::Id) {}
}

/// Message followed by the fields as `name=value`.
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

/// Installs the subscriber. If the process already has one, that one stays and Python gets no
/// events.
pub(crate) fn begin() {
    let _ = tracing::subscriber::set_global_default(Log);
}
