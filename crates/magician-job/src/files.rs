//! Files that users name: written completely or not at all, and never over a file being read.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use magician::files::Target;
pub use magician::files::{
    WholeFile, check_writable, replace, replace_locked, replace_private, replace_unsynced,
    write_whole,
};

/// Reads a text of at most `largest` bytes; `None` if the file is larger. The size is counted while
/// reading, because the metadata of a device or a pipe does not give the number of bytes to come.
#[cfg(feature = "settings")]
pub(crate) fn read_text(path: &Path, largest: u64) -> io::Result<Option<String>> {
    use std::io::Read as _;

    let mut bytes = Vec::new();
    let file = std::fs::File::open(path)?;
    let count = file.take(largest + 1).read_to_end(&mut bytes)?;
    if count as u64 <= largest {
        io::read_to_string(bytes.as_slice()).map(Some)
    } else {
        Ok(None)
    }
}

/// Error: a command would write over a file that it reads, or write one file twice.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SameFile {
    /// Output path as given.
    pub output: PathBuf,
    /// Other name of the same file.
    pub other: PathBuf,
    /// True if the other one is an input, false if it is an output.
    pub is_input: bool,
}

impl fmt::Display for SameFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (output, other) = (self.output.display(), self.other.display());
        match (self.is_input, self.output == self.other) {
            (true, true) => write!(f, "{output} is both read and written"),
            (true, false) => write!(f, "{output} would be written over {other}, which is read"),
            (false, true) => write!(f, "{output} is written twice"),
            (false, false) => write!(f, "{output} and {other} are one file, written twice"),
        }
    }
}

impl std::error::Error for SameFile {}

/// Checks that every output of a command is a separate file: different from all inputs and other
/// outputs, through symbolic and hard links too. Pipes and devices may be named twice.
///
/// # Errors
/// [`SameFile`] for the first output that repeats a file.
pub fn check_distinct<'p>(
    inputs: impl IntoIterator<Item = &'p Path>,
    outputs: impl IntoIterator<Item = &'p Path>,
) -> Result<(), SameFile> {
    let mut known: Vec<(Identity, &Path, bool)> = Vec::new();
    let inputs = inputs.into_iter().map(|path| (path, true));
    for (path, is_input) in inputs.chain(outputs.into_iter().map(|path| (path, false))) {
        let Some(identity) = Identity::of(path) else {
            continue;
        };
        let same = known.iter().find(|(other, ..)| *other == identity);
        if let (Some((_, other, is_read)), false) = (same, is_input) {
            return Err(SameFile {
                output: path.to_path_buf(),
                other: other.to_path_buf(),
                is_input: *is_read,
            });
        }
        known.push((identity, path, is_input));
    }
    Ok(())
}

/// Identity of a file, equal under all of its names.
#[derive(PartialEq, Eq)]
enum Identity {
    /// Device and inode of an existing file.
    #[cfg(unix)]
    Node(u64, u64),
    /// Path with links resolved, for a file that may not exist yet.
    Path(PathBuf),
}

impl Identity {
    /// `None` if the path is not a regular file, or cannot be written anyway.
    fn of(path: &Path) -> Option<Self> {
        let Target::File(path) = Target::of(path).ok()? else {
            return None;
        };
        #[cfg(unix)]
        if let Ok(there) = path.metadata() {
            use std::os::unix::fs::MetadataExt as _;
            return Some(Self::Node(there.dev(), there.ino()));
        }
        Self::canonical(&path).ok()
    }

    fn canonical(path: &Path) -> io::Result<Self> {
        if let Ok(path) = path.canonicalize() {
            return Ok(Self::Path(path));
        }
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            // A bare file name has an empty parent.
            _ => Path::new("."),
        };
        let name = path.file_name().unwrap_or_default();
        Ok(Self::Path(folder.canonicalize()?.join(name)))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn output_equal_to_an_input_or_output_is_found_by_any_name() {
        let place = tempfile::tempdir().expect("a directory");
        let at = |name: &str| place.path().join(name);
        fs::create_dir(at("folder")).expect("made");
        fs::write(at("a.svg"), "a").expect("written");
        fs::write(at("b.svg"), "a").expect("written");
        let mut same = vec![
            ("a.svg", "a.svg"),
            ("a.svg", "folder/../a.svg"),
            ("new.svg", "./folder/../new.svg"),
        ];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("a.svg", at("link.svg")).expect("linked");
            std::os::unix::fs::symlink("new.svg", at("dangling.svg")).expect("linked");
            fs::hard_link(at("a.svg"), at("hard.svg")).expect("linked");
            same.extend([
                ("a.svg", "link.svg"),
                ("hard.svg", "link.svg"),
                ("new.svg", "dangling.svg"),
            ]);
        }
        for (one, other) in same {
            let (one, other) = (at(one), at(other));
            for (one, other) in [(&*one, &*other), (&other, &one)] {
                let found = check_distinct([one], [other]).expect_err("the same");
                assert!(found.is_input && found.output == other && found.other == one);
                let found = check_distinct([], [one, other]).expect_err("the same");
                assert!(!found.is_input && found.output == other);
                assert_eq!(check_distinct([one, other], []), Ok(()));
            }
        }
        let [a, b, new] = ["a.svg", "b.svg", "new.svg"].map(at);
        assert_eq!(check_distinct([&*a], [&*b, &new]), Ok(()));
        let null = Path::new("/dev/null");
        assert_eq!(check_distinct([null], [null, null]), Ok(()));
    }
}
