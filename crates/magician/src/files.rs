//! Files that others may be reading.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Writes a file, and its directory, so that a reader finds the old or the new one, never half of it. A link stays a link.
///
/// # Errors
/// What the system reports; then the old one is there.
pub fn replace(path: &Path, text: &str) -> io::Result<()> {
    make_directory(path)?;
    let mut options = File::options();
    rewrite(path, text, options.write(true).create(true).truncate(true))
}

/// Writes a file in a directory that is there, so that it is whole or, after an error, as it was: a full
/// disk leaves the old file, and nothing beside it. Anything that is no plain file (a pipe, a device)
/// is written to as it is.
///
/// # Errors
/// What the system reports.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let there = fs::metadata(path).ok();
    if there.as_ref().is_some_and(|there| !there.is_file()) {
        return fs::write(path, bytes);
    }
    // A file that may not be written is not replaced either, whatever its directory allows.
    if there.is_some() {
        File::options().append(true).open(path)?;
    }
    let mut options = File::options();
    options.write(true).create(true).truncate(true);
    let permissions = there.map(|there| there.permissions());
    rewrite_as(path, bytes, &options, permissions)
}

/// Checks that [`write_whole`] can write a file there, as far as possible before there is anything to
/// write, and leaves everything as it is.
///
/// # Errors
/// What the system reports.
pub fn check_writable(path: &Path) -> io::Result<()> {
    let there = fs::metadata(path).ok();
    if there.is_some() {
        File::options().append(true).open(path)?;
    }
    if there.is_some_and(|there| !there.is_file()) {
        return Ok(());
    }
    let fresh = beside(path);
    File::options()
        .write(true)
        .create(true)
        .truncate(true)
        .open(&fresh)?;
    fs::remove_file(&fresh)
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

/// The name under which a file is written until it is whole: in its own directory, so that it can be
/// renamed.
fn beside(path: &Path) -> PathBuf {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.new", std::process::id()));
    path.with_file_name(name)
}

fn rewrite(path: &Path, text: &str, options: &OpenOptions) -> io::Result<()> {
    rewrite_as(path, text.as_bytes(), options, None)
}

fn rewrite_as(
    path: &Path,
    bytes: &[u8],
    options: &OpenOptions,
    permissions: Option<Permissions>,
) -> io::Result<()> {
    let fresh = beside(path);
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let written = options.open(&fresh).and_then(|mut file| {
        file.write_all(bytes)?;
        if let Some(permissions) = permissions {
            file.set_permissions(permissions)?;
        }
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

    #[cfg(unix)]
    #[test]
    fn whole_file_keeps_its_mode_and_link_and_no_device_is_replaced() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};
        let place = tempfile::tempdir().expect("a directory");
        let (path, link) = (place.path().join("a.svg"), place.path().join("b.svg"));
        write_whole(&path, b"one").expect("written");
        fs::set_permissions(&path, Permissions::from_mode(0o640)).expect("set");
        symlink(&path, &link).expect("linked");
        check_writable(&link).expect("it can be");
        write_whole(&link, b"two").expect("written again");
        assert_eq!(fs::read(&path).expect("read"), b"two");
        let mode = fs::metadata(&path).expect("there").permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
        let device = Path::new("/dev/null");
        check_writable(device).expect("it can be");
        write_whole(device, b"gone").expect("written");
        assert!(!fs::metadata(device).expect("there").is_file());
        let nowhere = place.path().join("none/a.svg");
        assert!(check_writable(&nowhere).is_err() && write_whole(&nowhere, b"x").is_err());
        assert_eq!(fs::read_dir(place.path()).expect("read").count(), 2);
    }

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
