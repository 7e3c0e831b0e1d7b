//! Journal of a station as a rotating file with one JSON object per line.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, UNIX_EPOCH};

use serde_json::json;

use crate::station::JournalLine;

/// Size at which a new file is started, bytes.
const MAX_FILE_SIZE: u64 = 10 * 1024 * 1024;
/// Number of older files that are kept. With 10 MiB each the journal takes about 60 MiB.
const OLDER_FILES: u32 = 5;

/// Journal file `journal.jsonl`, readable by its owner alone. Older files are `journal.1.jsonl`
/// (the newest of them) to `journal.5.jsonl`.
#[derive(Debug)]
pub struct JournalFile {
    path: PathBuf,
    open: Mutex<Option<(File, u64)>>,
}

impl JournalFile {
    /// Uses this path; the file need not exist.
    #[must_use]
    pub fn at(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            open: Mutex::new(None),
        }
    }

    /// Writes a line. If the disk is full or read-only the line is lost with a warning; nothing
    /// else fails.
    pub fn write(&self, line: &JournalLine) {
        if let Err(error) = self.try_write(line) {
            tracing::warn!(%error, path = %self.path.display(), "the journal is not written");
        }
    }

    fn try_write(&self, line: &JournalLine) -> io::Result<()> {
        let mut text = json!({
            "time": rfc3339(line.t),
            "session": line.session,
            "name": line.name,
            "role": line.role,
            "peer": line.peer,
            "arm": line.arm,
            "method": line.method,
            "params": line.params,
            "result": line.result,
            "ms": line.ms,
        })
        .to_string();
        text.push('\n');
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        // Taken out, so that after an error the next line opens the file again: the disk may be
        // available again by then.
        let (mut file, size) = match open.take() {
            Some(open) if open.1 < MAX_FILE_SIZE => open,
            Some(_) => {
                self.rotate()?;
                self.begin()?
            }
            None => self.begin()?,
        };
        file.write_all(text.as_bytes())?;
        *open = Some((file, size + text.len() as u64));
        Ok(())
    }

    fn begin(&self) -> io::Result<(File, u64)> {
        if let Some(folder) = self.path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut options = OpenOptions::new();
        options.append(true).create(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let file = options.open(&self.path)?;
        // The file of an earlier station is continued.
        let size = file.metadata()?.len();
        Ok((file, size))
    }

    fn rotate(&self) -> io::Result<()> {
        let older = |number: u32| self.path.with_extension(format!("{number}.jsonl"));
        // Oldest first, so that only the oldest file is overwritten.
        for number in (1..OLDER_FILES).rev() {
            match fs::rename(older(number), older(number + 1)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                // Renamed, or there was no such file yet.
                _ => {}
            }
        }
        fs::rename(&self.path, older(1))
    }
}

/// Formats Unix seconds as RFC 3339 in UTC, with milliseconds.
fn rfc3339(t: f64) -> String {
    let since = Duration::try_from_secs_f64(t).unwrap_or_default();
    humantime::format_rfc3339_millis(UNIX_EPOCH + since).to_string()
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    #[test]
    fn times_match_the_calendar() {
        for (t, text) in [
            (0.0, "1970-01-01T00:00:00.000Z"),
            (951_782_399.5, "2000-02-28T23:59:59.500Z"),
            (951_782_400.0, "2000-02-29T00:00:00.000Z"),
            (1_795_437_296.25, "2026-11-23T12:34:56.250Z"),
            (4_107_542_400.0, "2100-03-01T00:00:00.000Z"),
        ] {
            assert_eq!(rfc3339(t), text);
        }
    }

    #[test]
    fn large_journal_rotates_and_keeps_five_older_files() {
        let folder = tempfile::tempdir().unwrap();
        let journal = JournalFile::at(folder.path().join("station/journal.jsonl"));
        let line = |number: u64| JournalLine {
            t: 0.0,
            session: None,
            name: String::new(),
            role: None,
            peer: String::new(),
            arm: None,
            method: "arm.set".to_owned(),
            params: json!({"fields": "x".repeat(1024 * 1024), "number": number}),
            result: "ok".to_owned(),
            ms: 0.0,
        };
        for number in 0..80 {
            journal.write(&line(number));
        }
        let mut files: Vec<_> = fs::read_dir(folder.path().join("station"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        let older = (1..=5).map(|number| format!("journal.{number}.jsonl"));
        assert_eq!(
            files,
            older
                .chain(["journal.jsonl".to_owned()])
                .collect::<Vec<_>>()
        );
        let newest = fs::read_to_string(folder.path().join("station/journal.jsonl")).unwrap();
        let number = |name: &str| {
            let text = fs::read_to_string(folder.path().join("station").join(name)).unwrap();
            let last: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
            last["params"]["number"].as_u64().unwrap()
        };
        assert!(newest.len() < 11 * 1024 * 1024);
        // The newest file has no number; 1 is the newest of the older ones.
        let names = (1..=5).map(|number| format!("journal.{number}.jsonl"));
        let numbers: Vec<_> = [number("journal.jsonl")]
            .into_iter()
            .chain(names.map(|name| number(&name)))
            .collect();
        assert_eq!(numbers[0], 79);
        assert!(
            numbers.windows(2).all(|pair| pair[0] > pair[1]),
            "{numbers:?}"
        );
    }
}
