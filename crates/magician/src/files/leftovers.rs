//! Removal of temporary files that killed processes left beside their targets.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Targets remembered as swept; beyond that they are swept again. Choice.
const MOST_SWEPT: usize = 1000;
/// Age after which a process has certainly locked its file. Choice: creating and locking takes
/// microseconds, unless the process is suspended between.
const STUMP_AGE: Duration = Duration::from_secs(60);

/// Removes temporary files beside a target: those old enough to be locked by their process, and not
/// locked. Each target is examined once per process.
pub(super) fn sweep(target: &Path) {
    static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    {
        let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if swept.len() >= MOST_SWEPT {
            swept.clear();
        }
        if !swept.insert(target.to_owned()) {
            return;
        }
    }
    let (Some(folder), Some(name)) = (target.parent(), target.file_name()) else {
        return;
    };
    let here = folder.as_os_str().is_empty();
    let folder = if here { Path::new(".") } else { folder };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let other = entry.file_name();
        let is_left = is_stump_of(&name.to_string_lossy(), &other.to_string_lossy())
            && entry.metadata().is_ok_and(|about| {
                // A file from the future, after a clock change, has no age and stays.
                let age = about.modified().ok().and_then(|time| time.elapsed().ok());
                about.is_file() && age.is_some_and(|age| age >= STUMP_AGE)
            })
            && File::options()
                .append(true)
                .open(entry.path())
                .is_ok_and(|file| file.try_lock().is_ok());
        if is_left {
            // Another process may have removed it first.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// True for `NAME.PID-N.new`.
fn is_stump_of(name: &str, other: &str) -> bool {
    let numbers = { other.strip_prefix(name) }.and_then(|rest| {
        rest.strip_prefix('.')?
            .strip_suffix(".new")?
            .split_once('-')
    });
    numbers.is_some_and(|(process, number)| {
        let is_number = |text: &str| text.parse::<u32>().is_ok();
        is_number(process) && is_number(number)
    })
}
