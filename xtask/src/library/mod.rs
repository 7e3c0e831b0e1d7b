//! Installable replacement for the vendor's library, for programs in C, C++ and Python.

mod import;
mod stage;

use std::error::Error;
use std::path::Path;

pub(crate) use stage::{PYTHON, stage, stage_release, write_headers, write_python};

/// `vendor-library [--target TRIPLE] [DIR]`: builds the libraries and lays them out. `--imports
/// TRIPLE DIR` only writes the import libraries.
pub(crate) fn run(words: &[String], root: &Path) -> Result<(), Box<dyn Error>> {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let (target, folder) = match words.as_slice() {
        ["--target", target] => (Some(*target), None),
        ["--target", target, folder] => (Some(*target), Some(*folder)),
        ["--imports", target, folder] => return stage::imports(target, Path::new(folder)),
        [] => (None, None),
        [folder] if !folder.starts_with('-') => (None, Some(*folder)),
        _ => return Err("vendor-library [--target TRIPLE] [DIR]".into()),
    };
    let folder = stage(root, target, folder.map(Path::new))?;
    println!("{}", folder.display());
    Ok(())
}
