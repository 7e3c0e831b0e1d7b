use std::fs::{self, OpenOptions};
use std::path::Path;

use crate::failure::Failure;

/// Where the picture goes: known to be writable before the arm moves, and left as it was if there
/// is nothing to draw.
pub(super) struct PictureFile<'p> {
    path: &'p Path,
    fresh: bool,
}

impl<'p> PictureFile<'p> {
    pub(super) fn open(path: &'p Path) -> Result<Self, Failure> {
        let fresh = !path.exists();
        let opened = OpenOptions::new().create(true).append(true).open(path);
        opened.map_err(|error| Failure::unwritable(path, &error))?;
        Ok(Self { path, fresh })
    }

    pub(super) fn fill(mut self, picture: &str) -> Result<(), Failure> {
        self.fresh = false;
        fs::write(self.path, picture).map_err(|error| Failure::unwritable(self.path, &error))
    }
}

impl Drop for PictureFile<'_> {
    fn drop(&mut self) {
        if self.fresh {
            // An empty file that stays is a nuisance, not a failure.
            let _ = fs::remove_file(self.path);
        }
    }
}
