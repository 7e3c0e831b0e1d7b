//! Picture of everything that pen and laser have drawn, written at the end.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use magician::serve::{self, Handle};
use magician_job::files::{check_writable, write_whole};
use magician_picture::{DrawingOptions, PictureError, drawing_png, drawing_svg, fitting};
use magician_sim::world::Drawing;

use crate::failure::Failure;

/// Resolution of PNG files: 254 dots per inch. Laser lines 0.2 mm apart are whole pixels then,
/// which avoids moiré.
const PIXELS_PER_MM: f64 = 10.0;

/// Number of names tried for a picture that cannot be written to its own path.
const MAX_NAME_ATTEMPTS: u32 = 100;

/// Path and format of a picture.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    path: PathBuf,
    format: Format,
}

#[derive(Clone, Copy, Debug)]
enum Format {
    Svg,
    Png,
}

impl Picture {
    /// Creates a picture whose format follows from the extension. Fails for others.
    pub(crate) fn at(path: PathBuf) -> Result<Self, &'static str> {
        let end = path.extension().map(|end| end.to_ascii_lowercase());
        let format = match end.as_deref().and_then(|end| end.to_str()) {
            Some("svg") => Format::Svg,
            Some("png") => Format::Png,
            _ => return Err("a picture must be a .svg or .png file"),
        };
        Ok(Self { path, format })
    }

    /// Checks that the files can be written, before an hour of drawing makes an error expensive.
    /// `arms` is the number of arms if their files are numbered.
    pub(crate) fn check(&self, arms: Option<u32>) -> Result<(), Failure> {
        match arms {
            None => probe(&self.path),
            Some(count) => (1..=count).try_for_each(|number| probe(&self.numbered(number))),
        }
    }

    /// Writes the drawings of all arms. A file that cannot be written to its path is saved
    /// elsewhere.
    pub(super) async fn write(
        &self,
        arms: &[Handle],
        numbered: bool,
        options: &DrawingOptions,
    ) -> Result<(), Failure> {
        let mut outcome = Ok(());
        for (number, arm) in (1..).zip(arms) {
            let drawing = arm.with(|runner| runner.controller().drawing());
            // The end of an arm that is no longer served has been reported already.
            let Ok(drawing) = drawing.await else {
                continue;
            };
            let path = if numbered {
                self.numbered(number)
            } else {
                self.path.clone()
            };
            // After an error the other arms' drawings are still written.
            outcome = outcome.and(self.save(&drawing, options, &path));
        }
        outcome
    }

    /// Writes a drawing.
    pub(crate) fn write_one(
        &self,
        drawing: &Drawing,
        options: &DrawingOptions,
    ) -> Result<(), Failure> {
        self.save(drawing, options, &self.path)
    }

    fn save(
        &self,
        drawing: &Drawing,
        options: &DrawingOptions,
        path: &Path,
    ) -> Result<(), Failure> {
        let bytes = self
            .bytes(drawing, options)
            .map_err(|error| Failure::unwritable(path, &error))?;
        write_whole(path, &bytes).map_err(|error| {
            let failure = Failure::unwritable(path, &error);
            match save_in_temp_folder(&std::env::temp_dir(), path, &bytes) {
                Ok(saved) => failure.hint(format!("the drawing is in {}", saved.display())),
                Err(_) => failure,
            }
        })
    }

    /// Returns `drawing.3.svg` for arm 3; the extension stays last.
    fn numbered(&self, number: u32) -> PathBuf {
        let end = self.path.extension().unwrap_or_default();
        let mut name = serve::numbered(&self.path.with_extension(""), number).into_os_string();
        name.push(".");
        name.push(end);
        name.into()
    }

    fn bytes(&self, drawing: &Drawing, options: &DrawingOptions) -> Result<Vec<u8>, PictureError> {
        let Format::Png = self.format else {
            return Ok(drawing_svg(drawing, options).into_bytes());
        };
        // Drawings along a rail may be too large for full resolution.
        let too_large = |error: &_| matches!(error, PictureError::Size(_));
        fitting(PIXELS_PER_MM, too_large, |scale| {
            drawing_png(drawing, scale, options)
        })
    }
}

/// Saves a file into a shared temporary folder as a new file. Never follows or replaces anything
/// that exists there, such as a link planted by another user.
fn save_in_temp_folder(folder: &Path, path: &Path, bytes: &[u8]) -> io::Result<PathBuf> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    for attempt in 0..MAX_NAME_ATTEMPTS {
        let path = folder.join(format!("{}-{attempt}-{name}", std::process::id()));
        match options.open(&path) {
            Ok(mut file) => {
                let written = file.write_all(bytes);
                if written.is_err() {
                    // An incomplete picture is useless.
                    let _ = std::fs::remove_file(&path);
                }
                return written.map(|()| path);
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

fn probe(path: &Path) -> Result<(), Failure> {
    check_writable(path).map_err(|error| Failure::unwritable(path, &error))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn picture_saved_in_the_temp_folder_follows_no_link_and_replaces_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("somebody's file");
        std::fs::write(&target, "theirs").unwrap();
        let first = folder
            .path()
            .join(format!("{}-0-x.svg", std::process::id()));
        std::os::unix::fs::symlink(&target, &first).unwrap();
        let saved =
            save_in_temp_folder(folder.path(), Path::new("/nowhere/x.svg"), b"ours").unwrap();
        assert_ne!(saved, first);
        assert_eq!(std::fs::read(&saved).unwrap(), b"ours");
        assert_eq!(std::fs::read(&target).unwrap(), b"theirs");
        let again = save_in_temp_folder(folder.path(), Path::new("x.svg"), b"more").unwrap();
        assert_eq!(std::fs::read(&saved).unwrap(), b"ours");
        assert_ne!(again, saved);
    }
}
