//! Files with the saved settings of arms: one for each process and arm, present while something is
//! to be restored.
//!
//! The process that owes the restore holds a lock on its file, so its end, even by a crash, unlocks
//! the file. If several processes save the same setting, each keeps the value from before the first
//! change.

use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::time::SystemTime;

use magician::{Ctrl, FrameBuf, Set, SettingsBackup};
use magician_protocol::Row;
use serde::{Deserialize, Serialize};

use crate::files::WholeFile;

/// Version of the file format.
const VERSION: u32 = 1;
/// Largest size that is read, bytes; longer files are damaged.
const MAX_FILE_SIZE: u64 = 1 << 16;
/// Extension of complete files; others are being written.
const EXTENSION: &str = "json";

/// Directory of the files.
#[derive(Clone, Debug)]
pub(super) struct Ledger(PathBuf);

/// File of this process for one arm. Dropping it unlocks the file but keeps it, so that another
/// process restores the settings.
#[derive(Debug)]
pub(super) struct Entry {
    path: PathBuf,
    serial: String,
    /// Held open to keep the lock.
    _lock: File,
}

/// Files that earlier processes left for an arm.
#[derive(Debug, Default)]
pub(super) struct ClaimedEntries {
    /// Entries with their settings; `None` if the file is damaged.
    pub(super) entries: Vec<(Entry, Option<SettingsBackup>)>,
    /// True if a live process also has settings of the arm to restore.
    pub(super) others: bool,
}

/// Content of a file.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct LedgerFile {
    version: u32,
    serial: String,
    settings: Vec<StoredSetting>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct StoredSetting {
    name: String,
    params: Vec<u8>,
}

impl Ledger {
    pub(super) fn at(path: PathBuf) -> Self {
        Self(path)
    }

    /// True if there are no files. Does not open any file.
    pub(super) fn is_empty(&self) -> bool {
        self.files().next().is_none()
    }

    /// Records that this process has to restore `saved` on the arm with this serial number. Values
    /// in files of other processes take precedence: they are from before the first change.
    pub(super) fn store(
        &self,
        serial: &str,
        saved: &SettingsBackup,
        before: Option<Entry>,
    ) -> io::Result<Entry> {
        let own = before.as_ref().map(|entry| entry.path.clone());
        let older = self
            .files_of(serial)
            .filter(|path| Some(path) != own.as_ref());
        let older: Vec<Set> = older
            .filter_map(|path| read(&mut File::open(path).ok()?, serial))
            .flat_map(|saved| saved.settings().to_vec())
            .collect();
        let mut settings: Vec<Set> = Vec::new();
        for setting in saved.settings() {
            let same = |other: &&Set| other.row().id == setting.row().id;
            if settings.iter().find(same).is_none() {
                settings.push(*older.iter().find(same).unwrap_or(setting));
            }
        }
        let path = own.unwrap_or_else(|| {
            let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
            let now = now.map_or(0, |now| now.as_nanos());
            let name = format!("{}-{}-{now}.{EXTENSION}", file_stem(serial), process::id());
            self.0.join(name)
        });
        let content = LedgerFile {
            version: VERSION,
            serial: serial.to_owned(),
            settings: settings
                .iter()
                .map(StoredSetting::of)
                .collect::<io::Result<_>>()?,
        };
        fs::create_dir_all(&self.0)?;
        let mut file = WholeFile::create(&path)?;
        // Locked before it gets its final name: no other process ever sees it unlocked.
        file.try_lock()?;
        file.write_all(&serde_json::to_vec(&content)?)?;
        let lock = file.finish_open()?;
        Ok(Entry {
            path,
            serial: serial.to_owned(),
            _lock: lock,
        })
    }

    /// Claims the files left for an arm. They belong to this process from now on.
    pub(super) fn claim(&self, serial: &str) -> ClaimedEntries {
        let mut left = ClaimedEntries::default();
        for path in self.files_of(serial) {
            let Ok(mut lock) = File::open(&path) else {
                continue;
            };
            match lock.try_lock() {
                Ok(()) => {}
                // If the lock is in doubt, assume that the process is alive.
                Err(TryLockError::WouldBlock | TryLockError::Error(_)) => {
                    left.others = true;
                    continue;
                }
            }
            // Another process restored the settings, and removed the file, before this one had the
            // lock.
            if !path.exists() {
                continue;
            }
            let saved = read(&mut lock, serial);
            let serial = serial.to_owned();
            let entry = Entry {
                path,
                serial,
                _lock: lock,
            };
            left.entries.push((entry, saved));
        }
        left
    }

    /// Files that may belong to this arm. The content decides: different serial numbers can share a
    /// file name.
    fn files_of(&self, serial: &str) -> impl Iterator<Item = PathBuf> {
        let prefix = format!("{}-", file_stem(serial));
        let mut files: Vec<PathBuf> = self
            .files()
            .filter(|path| {
                let name = path.file_name().and_then(OsStr::to_str);
                let digits = name
                    .and_then(|name| name.strip_prefix(&prefix))
                    .and_then(|rest| rest.strip_suffix(&format!(".{EXTENSION}")));
                // Excludes longer serial numbers that begin with this one.
                digits.is_some_and(|rest| rest.split('-').count() == 2)
            })
            .collect();
        files.sort();
        files.into_iter()
    }

    fn files(&self) -> impl Iterator<Item = PathBuf> + use<> {
        let files = fs::read_dir(&self.0).into_iter().flatten();
        let files = files.filter_map(|file| Some(file.ok()?.path()));
        files.filter(|path| path.extension() == Some(OsStr::new(EXTENSION)))
    }
}

impl Entry {
    /// Removes the file: its settings are restored.
    pub(super) fn remove(self) -> io::Result<()> {
        // The lock is still held, so no other process can claim the file.
        fs::remove_file(&self.path)
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn is_of(&self, serial: &str) -> bool {
        self.serial == serial
    }
}

impl StoredSetting {
    fn of(setting: &Set) -> io::Result<Self> {
        let frame = FrameBuf::set(setting, Ctrl::SET).map_err(io::Error::other)?;
        Ok(Self {
            name: setting.row().name.to_owned(),
            params: frame.frame().params().to_vec(),
        })
    }

    fn setting(&self) -> Option<Set> {
        let row = Row::find_writable(&self.name).ok()?;
        Set::decode(row.id, &self.params).ok()
    }
}

/// Reads the settings saved for this arm; `None` if the file is damaged or of another arm.
fn read(file: &mut File, serial: &str) -> Option<SettingsBackup> {
    let mut text = Vec::new();
    file.take(MAX_FILE_SIZE).read_to_end(&mut text).ok()?;
    let content: LedgerFile = serde_json::from_slice(&text).ok()?;
    if content.version != VERSION || content.serial != serial {
        return None;
    }
    SettingsBackup::from_saved(
        content
            .settings
            .iter()
            .map(StoredSetting::setting)
            .collect::<Option<_>>()?,
    )
}

/// Serial number as part of a file name.
fn file_stem(serial: &str) -> String {
    let plain = |sign: char| {
        if sign.is_ascii_alphanumeric() {
            sign
        } else {
            '_'
        }
    };
    serial.chars().map(plain).take(60).collect()
}

#[cfg(test)]
mod tests {
    use magician::build;

    use super::*;

    fn saved(settings: &[Set]) -> SettingsBackup {
        SettingsBackup::from_saved(settings.to_vec()).expect("settings that are saved")
    }

    fn of(left: &ClaimedEntries) -> Vec<Option<Vec<Set>>> {
        let settings =
            |saved: &Option<SettingsBackup>| saved.as_ref().map(|saved| saved.settings().to_vec());
        left.entries
            .iter()
            .map(|(_, saved)| settings(saved))
            .collect()
    }

    #[test]
    fn entries_of_a_process_can_be_claimed_after_its_end() {
        let dir = tempfile::tempdir().expect("directory");
        let ledger = Ledger::at(dir.path().join("debts"));
        assert!(ledger.is_empty());
        let (slow, fast) = (build::speed(20.0, 20.0), build::path_speed(90.0, 100.0));
        let entry = ledger.store("A1", &saved(&[slow]), None).expect("kept");
        let entry = ledger.store("A1", &saved(&[slow, fast]), Some(entry));
        let entry = entry.expect("kept again");
        assert!(!ledger.is_empty());
        let left = ledger.claim("A1");
        assert!(left.others && left.entries.is_empty());
        drop(entry);
        for other in ["A", "A1-1", "A2", ""] {
            assert_eq!(of(&ledger.claim(other)), [], "{other}");
        }
        let left = ledger.claim("A1");
        assert_eq!(of(&left), [Some(vec![slow, fast])]);
        // Only one of two simultaneous claims succeeds.
        assert!(ledger.claim("A1").others);
        for (entry, _) in left.entries {
            entry.remove().expect("removed");
        }
        assert!(ledger.is_empty());
    }

    #[test]
    fn second_process_keeps_the_values_before_the_first() {
        let dir = tempfile::tempdir().expect("directory");
        let ledger = Ledger::at(dir.path().into());
        let (first, second) = (build::speed(50.0, 50.0), build::speed(20.0, 20.0));
        let line = build::path_speed(90.0, 100.0);
        let one = ledger.store("A1", &saved(&[first]), None).expect("kept");
        let two = ledger
            .store("A1", &saved(&[second, line]), None)
            .expect("kept");
        one.remove().expect("removed");
        drop(two);
        assert_eq!(of(&ledger.claim("A1")), [Some(vec![first, line])]);
    }

    #[test]
    fn damaged_file_restores_nothing() {
        let dir = tempfile::tempdir().expect("directory");
        let ledger = Ledger::at(dir.path().into());
        let speed = build::speed(50.0, 50.0);
        let entry = ledger.store("A1", &saved(&[speed]), None).expect("kept");
        let (path, whole) = (entry.path.clone(), fs::read(&entry.path).expect("read"));
        drop(entry);
        let text = String::from_utf8(whole.clone()).expect("UTF-8");
        let long = " ".repeat(1 << 17) + &text;
        for bytes in [
            b"".to_vec(),
            b"\xff\x00[[[[".to_vec(),
            whole[..whole.len() / 2].to_vec(),
            long.into_bytes(),
            text.replace("\"version\":1", "\"version\":2").into_bytes(),
            text.replace("\"A1\"", "\"A2\"").into_bytes(),
            text.replace("PTPCommonParams", "EndEffectorLaser")
                .into_bytes(),
            text.replace("PTPCommonParams", "PTPCmd").into_bytes(),
        ] {
            fs::write(&path, &bytes).expect("written");
            assert_eq!(of(&ledger.claim("A1")), [None], "{:?}", bytes.get(..40));
        }
        fs::write(&path, &whole).expect("written");
        assert_eq!(of(&ledger.claim("A1")), [Some(vec![speed])]);
    }
}
