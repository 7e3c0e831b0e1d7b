use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::ServeError;

/// The path under which clients find the terminal; gone when dropped.
pub(super) struct Symlink {
    /// As it was given.
    path: PathBuf,
    /// The same, whatever the working directory becomes.
    absolute: PathBuf,
    device: PathBuf,
}

impl Symlink {
    /// Makes `path` a symlink to `device`, in the place of a symlink that is there.
    pub(super) fn announce(path: &Path, device: &Path) -> Result<Self, ServeError> {
        let failed = |source| ServeError::at(path.display(), "make the symlink", source);
        if check(path)? {
            fs::remove_file(path).map_err(failed)?;
        }
        // Not by renaming over it: what has come there since is not ours to replace.
        std::os::unix::fs::symlink(device, path).map_err(failed)?;
        Ok(Self {
            path: path.to_owned(),
            absolute: std::path::absolute(path).map_err(failed)?,
            device: device.to_owned(),
        })
    }

    /// The path as it was given.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

impl fmt::Display for Symlink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.path.display().fmt(f)
    }
}

impl Drop for Symlink {
    fn drop(&mut self) {
        if fs::read_link(&self.absolute).is_ok_and(|target| target == self.device) {
            // If it cannot be removed, it dangles; the next server replaces it.
            let _ = fs::remove_file(&self.absolute);
        }
    }
}

/// Whether a symlink stands at `path`; an error if something else does.
pub(in super::super) fn check(path: &Path) -> Result<bool, ServeError> {
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_symlink() => Ok(true),
        Ok(_) => Err(ServeError::Occupied {
            path: path.to_owned(),
        }),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(ServeError::at(path.display(), "look at the path", error)),
    }
}
