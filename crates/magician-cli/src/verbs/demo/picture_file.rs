//! Output file of the demo's picture.

use std::path::Path;

use magician_job::files::{check_writable, write_whole};

use crate::failure::Failure;

/// File for the picture. Checked to be writable before the arm moves; left unchanged if there is no
/// picture.
pub(super) struct PictureFile<'p> {
    path: &'p Path,
}

impl<'p> PictureFile<'p> {
    pub(super) fn open(path: &'p Path) -> Result<Self, Failure> {
        check_writable(path).map_err(|error| Failure::unwritable(path, &error))?;
        Ok(Self { path })
    }

    pub(super) fn fill(self, picture: &str) -> Result<(), Failure> {
        let written = write_whole(self.path, picture.as_bytes());
        written.map_err(|error| Failure::unwritable(self.path, &error))
    }
}
