//! Log of the crates below, on stderr: warnings, and more with `-v`.
//!
//! With `--json` nothing is logged unless asked for, because stderr then belongs to the error
//! object. Servers are the exception: they log text with `--json` too.

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

/// Installs the subscriber. `serves`: see [`Cli::serves`](crate::args::Cli::serves).
pub(crate) fn begin(global: &Global, serves: bool) {
    let level = match (global.verbose, global.json && !serves) {
        (0, true) => LevelFilter::OFF,
        (0, false) => LevelFilter::WARN,
        (1, _) => LevelFilter::INFO,
        (2, _) => LevelFilter::DEBUG,
        _ => LevelFilter::TRACE,
    };
    // When many stations join at once, Zenoh drops states that arrive before their keys and warns
    // for each. That is harmless: the next states follow.
    let known = (global.verbose == 0).then_some([
        ("zenoh::api::session", LevelFilter::OFF),
        ("zenoh::net::routing", LevelFilter::OFF),
        ("zenoh::net::runtime", LevelFilter::ERROR),
        // The site checks the signer of a certificate and not its name against an address, which
        // this library warns about.
        ("zenoh_link_tls", LevelFilter::ERROR),
    ]);
    let shown = Targets::new()
        .with_default(level)
        .with_targets(known.into_iter().flatten());
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(|| LogWriter)
        // `LineFormat` colours the lines itself.
        .with_ansi(false)
        .event_format(LineFormat(Paint::for_stderr()))
        .with_filter(shown);
    // Fails only if a subscriber is already installed, which nothing else here does.
    let _ = tracing_subscriber::registry().with(lines).try_init();
}

/// Format of a log line: `warning: what happened name=value`.
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
