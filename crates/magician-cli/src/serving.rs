//! Parts shared by the verbs that serve other programs: `sim`, `proxy`, `serve`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use magician::serve::{Endpoint, ServeError};
use magician_job::files::WholeFile;

use crate::failure::{Failure, Kind};

/// Hint for a server without an endpoint.
pub(crate) const NO_ENDPOINT_HINT: &str = if cfg!(unix) {
    "give one or more of --pty PATH, --udp HOST[:PORT], --tcp HOST:PORT"
} else {
    "give --udp HOST[:PORT], --tcp HOST:PORT, or both"
};

/// Parser for the path of a new pseudo-terminal. Fails on systems that have none.
pub(crate) fn pty() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        if cfg!(unix) {
            Ok(path)
        } else {
            Err("this system has no pseudo-terminals; use --tcp or --udp")
        }
    })
}

/// Returns the line that announces an endpoint.
pub(crate) fn serving(endpoint: &Endpoint) -> String {
    match endpoint {
        #[cfg(unix)]
        Endpoint::Pty { path, device } => {
            format!("serving {} ({})", path.display(), device.display())
        }
        endpoint => format!("serving {endpoint}"),
    }
}

/// Creates or extends a trace or recording of the user. Fails if another program is writing it.
pub(crate) fn open_growing(path: &Path) -> Result<WholeFile, Failure> {
    WholeFile::grow(path).map_err(|error| Failure::unwritable(path, &error))
}

/// Prints `ready`, for a parent process that waits for it. An unwritable stdout is ignored.
pub(crate) fn print_ready() {
    let mut stdout = io::stdout().lock();
    let _ = writeln!(stdout, "ready").and_then(|()| stdout.flush());
}

impl From<ServeError> for Failure {
    fn from(error: ServeError) -> Self {
        Self::new(Kind::Driver(error.kind()), error.to_string())
    }
}

/// Returns the time since 1970 by this machine's clock.
pub(crate) fn unix_time() -> std::time::Duration {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.unwrap_or_default()
}
