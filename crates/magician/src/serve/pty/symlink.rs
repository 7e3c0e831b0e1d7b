//! Symlink under which clients find a terminal.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::super::ServeError;
use super::claim::{Claim, server_of};

/// Path of the symlink.
#[derive(Clone)]
pub(super) struct LinkPath {
    /// Path as given.
    given: PathBuf,
    /// Absolute path, independent of the working directory.
    absolute: PathBuf,
}

impl LinkPath {
    pub(super) fn new(path: &Path) -> Result<Self, ServeError> {
        let absolute = std::path::absolute(path);
        let absolute = absolute.map_err(|source| ServeError::at(path.display(), LOOK, source))?;
        Ok(Self {
            given: path.to_owned(),
            absolute,
        })
    }

    pub(super) fn given(&self) -> &Path {
        &self.given
    }

    /// Claims the path for this server, unless another one has it.
    pub(super) fn claim(&self) -> Result<Claim, ServeError> {
        Claim::take(&self.absolute).ok_or_else(|| ServeError::Served {
            path: self.given.clone(),
            process: server_of(&self.absolute),
        })
    }

    /// Returns true if a symlink exists; an error if something else does.
    pub(super) fn check(&self) -> Result<bool, ServeError> {
        match fs::symlink_metadata(&self.absolute) {
            Ok(found) if found.is_symlink() => Ok(true),
            Ok(_) => Err(ServeError::Occupied {
                path: self.given.clone(),
            }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
            Err(error) => Err(ServeError::at(self, LOOK, error)),
        }
    }
}

impl fmt::Display for LinkPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.given.display().fmt(f)
    }
}

const LOOK: &str = "look at the path";

/// Checks for predictable errors of a symlink at `path`.
pub(in super::super) fn check(path: &Path) -> Result<(), ServeError> {
    let way = LinkPath::new(path)?;
    way.check()?;
    way.claim().map(drop)
}

/// Symlink to the terminal; removed on drop.
pub(super) struct Symlink {
    way: LinkPath,
    device: PathBuf,
}

impl Symlink {
    /// Creates a symlink to `device`, replacing an existing symlink.
    pub(super) fn announce(way: &LinkPath, device: &Path) -> Result<Self, ServeError> {
        let failed = |source| ServeError::at(way, "make the symlink", source);
        if way.check()? {
            fs::remove_file(&way.absolute).map_err(failed)?;
        }
        // Not by renaming over it: a file created there since the check must not be replaced.
        std::os::unix::fs::symlink(device, &way.absolute).map_err(failed)?;
        Ok(Self {
            way: way.clone(),
            device: device.to_owned(),
        })
    }
}

impl fmt::Display for Symlink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.way.fmt(f)
    }
}

impl Drop for Symlink {
    fn drop(&mut self) {
        let path = &self.way.absolute;
        if fs::read_link(path).is_ok_and(|target| target == self.device) {
            // If it cannot be removed, it dangles, and the next server replaces it.
            let _ = fs::remove_file(path);
        }
    }
}
