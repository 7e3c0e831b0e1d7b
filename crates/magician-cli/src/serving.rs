//! What the verbs that serve others have in common: `sim` and `proxy`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use magician::serve::{Endpoint, ServeError};
use magician_job::files::WholeFile;

use crate::failure::{Failure, Kind};

/// What to do about having no door.
pub(crate) const DOORS: &str = if cfg!(unix) {
    "give one or more of --pty PATH, --udp HOST[:PORT], --tcp HOST:PORT"
} else {
    "give --udp HOST[:PORT], --tcp HOST:PORT, or both"
};

/// The path of a new pseudo-terminal, where there are such things.
pub(crate) fn pty() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        if cfg!(unix) {
            Ok(path)
        } else {
            Err("this system has no pseudo-terminals; use --tcp or --udp")
        }
    })
}

/// Says where something is served.
pub(crate) fn serving(endpoint: &Endpoint) -> String {
    match endpoint {
        #[cfg(unix)]
        Endpoint::Pty { path, device } => {
            format!("serving {} ({})", path.display(), device.display())
        }
        endpoint => format!("serving {endpoint}"),
    }
}

/// A trace or recording of the person's that begins; one that another program is writing stays as it is.
pub(crate) fn grow(path: &Path) -> Result<WholeFile, Failure> {
    WholeFile::grow(path).map_err(|error| Failure::unwritable(path, &error))
}

/// A parent that does not listen is no reason to stop serving.
pub(crate) fn say_ready() {
    let mut stdout = io::stdout().lock();
    let _ = writeln!(stdout, "ready").and_then(|()| stdout.flush());
}

impl From<ServeError> for Failure {
    fn from(error: ServeError) -> Self {
        Self::new(Kind::Driver(error.kind()), error.to_string())
    }
}

/// Time since 1970, by the clock of this machine.
pub(crate) fn unix_time() -> std::time::Duration {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.unwrap_or_default()
}
