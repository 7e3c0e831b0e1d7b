//! Files that others may be reading.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write as _};
use std::path::Path;

/// Writes a file, and its directory, so that a reader finds the old or the new one, never half of it. A link stays a link.
///
/// # Errors
/// What the system reports; then the old one is there.
pub fn replace(path: &Path, text: &str) -> io::Result<()> {
    make_directory(path)?;
    let mut options = File::options();
    rewrite(path, text, options.write(true).create(true).truncate(true))
}

/// As [`replace`], a file that its owner alone may read, where the system knows owners.
///
/// # Errors
/// As [`replace`].
pub fn replace_private(path: &Path, text: &str) -> io::Result<()> {
    make_directory(path)?;
    rewrite_private(path, text)
}

/// As [`replace_private`], in a directory that is there.
///
/// # Errors
/// As [`replace`].
pub fn rewrite_private(path: &Path, text: &str) -> io::Result<()> {
    let mut options = File::options();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    rewrite(path, text, &options)
}

fn make_directory(path: &Path) -> io::Result<()> {
    path.parent().map_or(Ok(()), fs::create_dir_all)
}

fn rewrite(path: &Path, text: &str, options: &OpenOptions) -> io::Result<()> {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.new", std::process::id()));
    let fresh = path.with_file_name(name);
    let written = options.open(&fresh).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.sync_all()
    });
    let done = written.and_then(|()| fs::rename(&fresh, &path));
    if done.is_err() {
        // What is left of it is of no use.
        let _ = fs::remove_file(&fresh);
    }
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_as_a_whole_and_through_a_link() {
        let place = tempfile::tempdir().expect("a directory");
        let path = place.path().join("new/config.toml");
        replace(&path, "a = 1\n").expect("written");
        replace(&path, "a = 2\n").expect("written again");
        assert_eq!(fs::read_to_string(&path).expect("read"), "a = 2\n");
        let files = fs::read_dir(path.parent().expect("its place")).expect("read");
        assert_eq!(files.count(), 1);
    }
}
