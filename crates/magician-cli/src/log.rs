//! What the crates below have to say, on stderr: warnings, and with `-v` more. Nothing with
//! `--json` unless asked for, because stderr then belongs to the error object; but for a verb that
//! serves, whose stderr has its lines as text with `--json` too.

use std::fmt;

use magician_protocol::visible_lines;
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::registry::LookupSpan;
use tracing_subscriber::util::SubscriberInitExt;

use crate::options::Global;
use crate::paint::Paint;
use crate::terminal::LogWriter;

/// Begins to listen. `serves`: [`Cli::serves`](crate::args::Cli::serves).
pub(crate) fn begin(global: &Global, serves: bool) {
    let level = match (global.verbose, global.json && !serves) {
        (0, true) => LevelFilter::OFF,
        (0, false) => LevelFilter::WARN,
        (1, _) => LevelFilter::INFO,
        (2, _) => LevelFilter::DEBUG,
        _ => LevelFilter::TRACE,
    };
    // Where many stations come at once Zenoh drops states that come before their keys, and tells each: the next ones follow.
    let known = (global.verbose == 0).then_some([
        ("zenoh::api::session", LevelFilter::OFF),
        ("zenoh::net::routing", LevelFilter::OFF),
        ("zenoh::net::runtime", LevelFilter::ERROR),
        // Who has signed a certificate counts; the name in it is not compared with an address.
        ("zenoh_link_tls", LevelFilter::ERROR),
    ]);
    let shown = Targets::new()
        .with_default(level)
        .with_targets(known.into_iter().flatten());
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(|| LogWriter)
        // The colours are ours.
        .with_ansi(false)
        .event_format(LineFormat(Paint::for_stderr()))
        .with_filter(shown);
    // Only a second start could fail, and there is none.
    let _ = tracing_subscriber::registry().with(lines).try_init();
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
