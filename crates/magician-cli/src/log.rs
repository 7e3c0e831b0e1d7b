//! What the crates below have to say, on stderr: warnings, and with `-v` more. Nothing with
//! `--json` unless asked for, because stderr then belongs to the error object.

use std::fmt;

use magician_protocol::visible_lines;
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::registry::LookupSpan;

use crate::options::Global;
use crate::paint::Paint;
use crate::terminal::LogWriter;

/// Begins to listen.
pub(crate) fn begin(global: &Global) {
    let level = match (global.verbose, global.json) {
        (0, true) => LevelFilter::OFF,
        (0, false) => LevelFilter::WARN,
        (1, _) => LevelFilter::INFO,
        (2, _) => LevelFilter::DEBUG,
        _ => LevelFilter::TRACE,
    };
    let lines = tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(|| LogWriter)
        // The colours are ours.
        .with_ansi(false)
        .event_format(LineFormat(Paint::for_stderr()));
    // Only a second start could fail, and there is none.
    let _ = lines.try_init();
}

/// `warning: what happened name=value`.
struct LineFormat(Paint);

impl<S, N> FormatEvent<S, N> for LineFormat
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
{
    fn format_event(
        &self,
        context: &FmtContext<'_, S, N>,
        mut writer: Writer<'_>,
        event: &Event<'_>,
    ) -> fmt::Result {
        let paint = self.0;
        match *event.metadata().level() {
            Level::ERROR => write!(writer, "{} ", paint.error("error:"))?,
            Level::WARN => write!(writer, "{} ", paint.note("warning:"))?,
            _ => write!(writer, "{} ", paint.dim("log:"))?,
        }
        let mut fields = String::new();
        context.format_fields(Writer::new(&mut fields), event)?;
        writeln!(writer, "{}", visible_lines(fields))
    }
}
