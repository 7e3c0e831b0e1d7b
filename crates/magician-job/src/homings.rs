//! Records of homings seen by this computer, as files: one for each serial number and port.
//!
//! The protocol does not say if an arm was homed since it was switched on. A record holds the time
//! at which the arm was switched on, computed from its own clock. Later, an arm with the same
//! serial number and port counts as homed if its clock gives the same time again, within the drift
//! of two crystals.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use magician::{ArmIdentity, ClockRate, HomingRecord};
use serde::{Deserialize, Serialize};
use tracing::warn;

/// Version of the file format.
const VERSION: u32 = 1;
/// Largest relative drift between the arm's crystal and this computer's: 100 ppm each, which is 17
/// s a day. A power cycle shifts the computed time by at least the time that the arm had been on
/// before, and that is no less than a homing takes.
const MAX_RELATIVE_DRIFT: f64 = 200e-6;
/// Longest age of a record, s. The arm's clock (32 bits of ms) wraps after 49.7 days.
const MAX_RECORD_AGE: f64 = 50.0 * 86400.0;
/// Error of a single reading, s: the arm may take this long to answer, or the computer's clock may
/// be adjusted by as much.
const MAX_READING_ERROR: f64 = 2.0;

/// Homing records in the user's state directory, for
/// [`Options::homings`](magician::Options::homings).
///
/// `None` if the system has no such directory.
#[must_use]
pub fn homings() -> Option<Arc<dyn HomingRecord>> {
    let place = crate::dirs::state()?.join("homed");
    Some(Arc::new(HomingFiles { place }))
}

/// Homing records as files. An arm counts as homed if its serial number and port match a file, and
/// it was switched on at the time that the file states.
#[derive(Debug)]
struct HomingFiles {
    place: PathBuf,
}

/// Content of a file. Times are seconds since 1970.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Homing {
    version: u32,
    serial: String,
    port: String,
    /// Time at which the arm was switched on, by its own clock.
    powered_up: f64,
    /// Time at which its clock was read for that.
    seen: f64,
    /// Rate of the arm's clock relative to this computer's.
    clock: Clock,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Clock {
    Steady,
    Faster,
    Slower,
}

impl HomingRecord for HomingFiles {
    fn keep(&self, arm: &ArmIdentity, uptime: Duration, rate: ClockRate) {
        self.store_at(arm, uptime, rate, now());
    }

    fn forget(&self, arm: &ArmIdentity) {
        let path = self.path(arm);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                warn!(%error, "{} cannot be removed: the arm may count as homed while it is not", path.display());
            }
            // Removed, or never there.
            _ => {}
        }
    }

    fn is_homed(&self, arm: &ArmIdentity, uptime: Duration) -> bool {
        self.is_homed_at(arm, uptime, now())
    }
}

impl HomingFiles {
    fn store_at(&self, arm: &ArmIdentity, uptime: Duration, rate: ClockRate, now: f64) {
        // Without a serial number the record would fit every arm that has none.
        if arm.serial.is_empty() {
            return;
        }
        let homing = Homing {
            version: VERSION,
            serial: arm.serial.clone(),
            port: port(arm),
            powered_up: now - uptime.as_secs_f64(),
            seen: now,
            clock: match rate {
                ClockRate::Faster => Clock::Faster,
                ClockRate::Slower => Clock::Slower,
                // Real arms, and virtual ones in real time.
                _ => Clock::Steady,
            },
        };
        if let Err(error) = self.write(&self.path(arm), &homing) {
            warn!(%error, "the homing cannot be remembered: the next program takes the arm for not homed");
        }
    }

    fn is_homed_at(&self, arm: &ArmIdentity, uptime: Duration, now: f64) -> bool {
        let path = self.path(arm);
        // Only a regular file is read: a pipe would block.
        let read = path.is_file().then(|| fs::read(path).ok()).flatten();
        let homing = read.and_then(|text| serde_json::from_slice::<Homing>(&text).ok());
        let Some(homing) = homing else {
            return false;
        };
        let same = homing.version == VERSION && homing.serial == arm.serial;
        if !same || arm.serial.is_empty() || homing.port != port(arm) {
            return false;
        }
        homing.is_of_this_power_up(uptime.as_secs_f64(), now)
    }

    fn write(&self, path: &Path, homing: &Homing) -> io::Result<()> {
        crate::files::replace(path, &serde_json::to_string(homing)?)
    }

    /// File of an arm. The name is for people; the content decides.
    fn path(&self, arm: &ArmIdentity) -> PathBuf {
        let name: String = format!("{}-{}", arm.serial, port(arm))
            .chars()
            .map(|sign| {
                if sign.is_ascii_alphanumeric() {
                    sign
                } else {
                    '_'
                }
            })
            .collect();
        // Keep the end of a long name: it is the most specific part.
        let from = name.len().saturating_sub(120);
        self.place
            .join(OsString::from(format!("{}.json", &name[from..])))
    }
}

impl Homing {
    /// True if an arm that has been on for `uptime` seconds at `now` was switched on at the
    /// recorded time.
    fn is_of_this_power_up(&self, uptime: f64, now: f64) -> bool {
        let passed = now - self.seen;
        if !(-MAX_READING_ERROR..=MAX_RECORD_AGE).contains(&passed) {
            // The computer's clock was set back, or the record is damaged: nothing can be
            // concluded.
            return false;
        }
        let slack = MAX_READING_ERROR + passed.max(0.0) * MAX_RELATIVE_DRIFT;
        let later = now - uptime - self.powered_up;
        match self.clock {
            // A clock that is ahead belongs to another arm.
            Clock::Steady => later.abs() <= slack,
            // A virtual arm may run faster than real time, so only falling behind shows a restart.
            Clock::Faster => later <= slack,
            // A slow clock only proves that the arm has been on for longer than at the record.
            Clock::Slower => uptime >= self.seen - self.powered_up,
        }
    }
}

/// Port under its canonical name, so that all of its names match.
fn port(arm: &ArmIdentity) -> String {
    match fs::canonicalize(&arm.port) {
        Ok(path) => path.display().to_string(),
        Err(_) => arm.port.clone(),
    }
}

fn now() -> f64 {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    now.map_or(0.0, |now| now.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR: f64 = 3600.0;
    /// Time at which the arm of these tests was homed.
    const HOMED_AT: f64 = 1.8e9;
    /// Time for which it had been on by then, s.
    const UPTIME: f64 = 60.0;

    fn seconds(seconds: f64) -> Duration {
        Duration::from_secs_f64(seconds)
    }

    fn files(rate: ClockRate) -> (tempfile::TempDir, HomingFiles, ArmIdentity) {
        let dir = tempfile::tempdir().expect("directory");
        let files = HomingFiles {
            place: dir.path().join("homed"),
        };
        let arm = ArmIdentity::new("A1", "tcp:here:1");
        files.store_at(&arm, seconds(UPTIME), rate, HOMED_AT);
        (dir, files, arm)
    }

    #[test]
    fn arm_of_the_same_power_up_is_homed_within_clock_drift() {
        let (_dir, files, arm) = files(ClockRate::Steady);
        for passed in [0.0, 1.0, HOUR, 24.0 * HOUR, 40.0 * 24.0 * HOUR] {
            for drift in [-150e-6, 0.0, 150e-6] {
                let uptime = UPTIME + passed * (1.0 + drift);
                let homed = files.is_homed_at(&arm, seconds(uptime), HOMED_AT + passed);
                assert!(homed, "{passed} {drift}");
            }
        }
    }

    #[test]
    fn power_cycled_arm_is_not_homed() {
        let (_dir, files, arm) = files(ClockRate::Steady);
        for off in [1.0, 20.0, HOUR, 24.0 * HOUR] {
            for on in [0.5, 30.0, HOUR, 24.0 * HOUR] {
                let homed = files.is_homed_at(&arm, seconds(on), HOMED_AT + off + on);
                assert!(!homed, "off for {off} s, on for {on} s");
            }
        }
    }

    #[test]
    fn ambiguous_arm_is_not_homed() {
        let (_dir, files, arm) = files(ClockRate::Steady);
        let homed = |serial: &str, port: &str, uptime, now| {
            files.is_homed_at(&ArmIdentity::new(serial, port), seconds(uptime), now)
        };
        assert!(homed("A1", "tcp:here:1", UPTIME + 5.0, HOMED_AT + 5.0));
        assert!(
            !homed("A1", "tcp:here:2", UPTIME + 5.0, HOMED_AT + 5.0),
            "port"
        );
        assert!(
            !homed("A2", "tcp:here:1", UPTIME + 5.0, HOMED_AT + 5.0),
            "serial"
        );
        assert!(
            !homed("", "tcp:here:1", UPTIME + 5.0, HOMED_AT + 5.0),
            "no serial"
        );
        assert!(
            !homed("A1", "tcp:here:1", HOUR, HOMED_AT + 5.0),
            "on for longer"
        );
        assert!(
            !homed("A1", "tcp:here:1", UPTIME, HOMED_AT - HOUR),
            "clock set back"
        );
        files.store_at(
            &ArmIdentity::new("", "tcp:here:3"),
            seconds(UPTIME),
            ClockRate::Steady,
            HOMED_AT,
        );
        assert!(
            !homed("", "tcp:here:3", UPTIME, HOMED_AT),
            "kept without a serial"
        );
        files.forget(&arm);
        assert!(
            !homed("A1", "tcp:here:1", UPTIME + 5.0, HOMED_AT + 5.0),
            "forgotten"
        );
    }

    #[test]
    fn similar_names_have_separate_files() {
        let (_dir, files, _) = files(ClockRate::Steady);
        let alike = ArmIdentity::new("A1", "tcp-here-1");
        assert!(!files.is_homed_at(&alike, seconds(UPTIME), HOMED_AT));
    }

    #[test]
    fn restarted_virtual_arm_is_detected_by_its_clock() {
        let (_dir, fast, arm) = files(ClockRate::Faster);
        assert!(fast.is_homed_at(&arm, seconds(UPTIME + 20.0 * HOUR), HOMED_AT + HOUR));
        assert!(fast.is_homed_at(&arm, seconds(UPTIME + HOUR), HOMED_AT + HOUR));
        assert!(!fast.is_homed_at(&arm, seconds(HOUR), HOMED_AT + HOUR));
        let (_dir, slow, arm) = files(ClockRate::Slower);
        assert!(slow.is_homed_at(&arm, seconds(UPTIME + 1.0), HOMED_AT + HOUR));
        assert!(!slow.is_homed_at(&arm, seconds(UPTIME - 1.0), HOMED_AT + HOUR));
    }

    #[test]
    fn damaged_file_counts_as_not_homed() {
        let (_dir, files, arm) = files(ClockRate::Steady);
        let path = files.path(&arm);
        let whole = fs::read_to_string(&path).expect("read");
        for text in [
            "",
            "{}",
            &whole[..whole.len() / 2],
            &whole.replace("\"version\":1", "\"version\":2"),
        ] {
            fs::write(&path, text).expect("written");
            assert!(
                !files.is_homed_at(&arm, seconds(UPTIME), HOMED_AT),
                "{text}"
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn names_of_the_same_port_share_a_record() {
        let (dir, files, _) = files(ClockRate::Steady);
        let (device, link) = (dir.path().join("tty"), dir.path().join("arm"));
        fs::write(&device, "").expect("written");
        std::os::unix::fs::symlink(&device, &link).expect("linked");
        let at = |path: &Path| ArmIdentity::new("A1", path.display().to_string());
        files.store_at(&at(&link), seconds(UPTIME), ClockRate::Steady, HOMED_AT);
        assert!(files.is_homed_at(&at(&device), seconds(UPTIME), HOMED_AT));
    }
}
