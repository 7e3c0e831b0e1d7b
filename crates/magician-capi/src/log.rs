//! Log on stderr. `MAGICIAN_LOG` sets its level; the default is warnings.

use std::fmt;
use std::sync::Once;

use magician::protocol::visible_lines;
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::registry::LookupSpan;
use tracing_subscriber::util::SubscriberInitExt;

/// Variable with the level: `off`, `error`, `warn`, `info`, `debug` or `trace`, or levels of
/// modules such as `warn,magician=debug`.
const VARIABLE: &str = "MAGICIAN_LOG";
const DEFAULT: LevelFilter = LevelFilter::WARN;

/// Installs the log, once. In a Rust program that has its own subscriber, that one stays.
pub(crate) fn install() {
    static INSTALLED: Once = Once::new();
    INSTALLED.call_once(|| {
        let levels = std::env::var(VARIABLE).unwrap_or_default();
        let levels = Some(levels.trim()).filter(|text| !text.is_empty());
        let (filter, parse_error) = match levels.map(parse_filter).transpose() {
            Ok(filter) => (filter, None),
            Err(error) => (None, Some(error)),
        };
        let filter = filter.unwrap_or_else(|| Targets::new().with_default(DEFAULT));
        let lines = tracing_subscriber::fmt()
            .with_max_level(LevelFilter::TRACE)
            .with_writer(std::io::stderr)
            .with_ansi(false)
            // `tracing-subscriber` would report its own errors to stderr, and panic if that is
            // closed.
            .log_internal_errors(false)
            .event_format(EventFormat)
            .finish()
            .with(filter);
        let _ = lines.try_init();
        if let Some(error) = parse_error {
            tracing::warn!("{VARIABLE} is invalid: {error}");
        }
    });
}

/// Parses comma-separated levels, each global or for a module (`magician=debug`).
fn parse_filter(text: &str) -> Result<Targets, String> {
    let is_module = |name: &str| {
        !name.is_empty()
            && name
                .chars()
                .all(|c| c.is_alphanumeric() || "_:".contains(c))
    };
    let mut filter = Targets::new();
    for word in text.split(',').map(str::trim) {
        let (module, level) = match word.split_once('=') {
            Some((module, level)) => (Some(module), level),
            None => (None, word),
        };
        // `tracing` would accept an empty word as a level.
        let level = Some(level).filter(|level| !level.is_empty());
        let level = level.and_then(|level| level.parse::<LevelFilter>().ok());
        filter = match (module, level) {
            (None, Some(level)) => filter.with_default(level),
            (Some(module), Some(level)) if is_module(module) => filter.with_target(module, level),
            _ => {
                return Err(format!(
                    "unknown level {word}: expected off, error, warn, info, debug or trace"
                ));
            }
        };
    }
    Ok(filter)
}

/// Formats an event as `DobotDll: warning: message name=value`.
struct EventFormat;

impl<S, N> FormatEvent<S, N> for EventFormat
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
        let level = match *event.metadata().level() {
            Level::ERROR => "error: ",
            Level::WARN => "warning: ",
            _ => "",
        };
        write!(writer, "DobotDll: {level}")?;
        // Fields may quote text of an arm, which could contain control characters.
        let mut fields = String::new();
        context.format_fields(Writer::new(&mut fields), event)?;
        writeln!(writer, "{}", visible_lines(fields))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_level_keeps_the_log_enabled() {
        for valid in [
            "off",
            "WARN",
            "debug",
            "magician=trace",
            "warn,magician_capi=debug",
        ] {
            assert!(parse_filter(valid).is_ok(), "{valid}");
        }
        for invalid in [
            "warning", "verbose", "true", "[", "=", "magician", "a b=warn", "warn,",
        ] {
            assert!(parse_filter(invalid).is_err(), "{invalid}");
        }
    }
}
