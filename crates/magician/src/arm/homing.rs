//! Homing state of the arm, from this connection and from the record of earlier ones.
//!
//! The protocol has no query for homing. The driver therefore watches for HomeCmd and checks that
//! the arm came to rest at its home point. To know of homings by earlier programs, a front end
//! supplies a [`HomingRecord`]. An entry is valid only for the same power-up, which the arm's
//! uptime counter shows: the record compares it with the time that passed. The clock rate is kept
//! as well, because the clock of a virtual arm may run at another speed.

use std::fmt;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use magician_protocol::commands::{DeviceSn, DeviceTime, HomeCmd, HomeParams, Pose};
use magician_protocol::{Alarm, Frame, Writable};
use tokio::time::Instant;

use super::Arm;
use super::shared::lock;
use crate::message;
use crate::{Action, Error, ErrorCode, Result, Setting, SettingValue};

/// Largest deviation of a controller's crystal, per mille of the elapsed time. Choice, far above
/// any crystal (below 0.1 per mille): a larger deviation means a virtual arm at another speed.
const MAX_CLOCK_DEVIATION_PER_MILLE: f64 = 10.0;
/// Additional error of one clock reading: the controller counts ms, and this process may be
/// scheduled late. Choice.
const CLOCK_READING_ERROR: Duration = Duration::from_millis(50);

/// Largest distance from the home point, mm, at which a homing counts as complete. A homed arm was
/// recorded 0.01 mm from it (model section 11); an aborted homing leaves the arm centimetres away.
const HOME_TOLERANCE: f32 = 2.0;

/// Identity of an arm: its serial number and its port.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ArmIdentity {
    /// Serial number; empty if the arm reports none.
    pub serial: String,
    /// Target as it was given.
    pub port: String,
}

impl ArmIdentity {
    /// Creates the identity from a serial number and a port.
    #[must_use]
    pub fn new(serial: impl Into<String>, port: impl Into<String>) -> Self {
        Self {
            serial: serial.into(),
            port: port.into(),
        }
    }
}

/// Rate of the arm's clock compared with the clock of this computer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ClockRate {
    /// Rate of a crystal, or not measured.
    #[default]
    Steady,
    /// Faster than any crystal: a virtual arm.
    Faster,
    /// Slower than any crystal: a virtual arm.
    Slower,
}

/// Record of homings that outlives the connection. An arm stays homed until it is switched off,
/// while programs come and go.
///
/// The driver calls the methods from its tasks, so they must not block for long.
pub trait HomingRecord: fmt::Debug + Send + Sync {
    /// Called when the arm has completed a homing; `uptime` is its time since power-up.
    fn keep(&self, arm: &ArmIdentity, uptime: Duration, rate: ClockRate);

    /// Called when homing begins: until it completes, the arm is not homed.
    fn forget(&self, arm: &ArmIdentity);

    /// Returns true if this arm was homed since its power-up, `uptime` ago. Returns false if the
    /// arm cannot be distinguished from another arm, or this power-up from another.
    fn is_homed(&self, arm: &ArmIdentity, uptime: Duration) -> bool;
}

/// Readings of the arm that identify it in the record.
#[derive(Debug, Default)]
pub(super) struct IdentityCache {
    identity: Option<ArmIdentity>,
    /// First clock reading since the arm was reset.
    first: Option<ClockReading>,
}

#[derive(Clone, Copy, Debug)]
struct ClockReading {
    asked: Instant,
    heard: Instant,
    uptime: Duration,
}

impl IdentityCache {
    /// Discards the readings: the arm was reset, or another one may be on the line.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    pub(super) fn identity(&self) -> Option<&ArmIdentity> {
        self.identity.as_ref()
    }
}

impl ClockReading {
    /// Returns the clock rate between this reading and a later one.
    ///
    /// The true time of a reading lies between request and reply, so the elapsed time is known only
    /// as an interval. The rate counts as off only if no elapsed time in this interval explains it.
    fn rate_until(&self, later: &Self) -> ClockRate {
        let least = later.asked.saturating_duration_since(self.heard);
        let most = later.heard.saturating_duration_since(self.asked);
        // A clock that went backwards counts as no elapsed time: the arm was reset, which the
        // driver detects elsewhere.
        let ran = later.uptime.saturating_sub(self.uptime);
        if ran > most.mul_f64(1.0 + MAX_CLOCK_DEVIATION_PER_MILLE / 1000.0) + CLOCK_READING_ERROR {
            ClockRate::Faster
        } else if ran + CLOCK_READING_ERROR
            < least.mul_f64(1.0 - MAX_CLOCK_DEVIATION_PER_MILLE / 1000.0)
        {
            ClockRate::Slower
        } else {
            ClockRate::Steady
        }
    }
}

/// The alarms were read for a program without motion.
pub(super) const READ_WITHOUT_MOTION: u8 = 1;
/// The alarms were read for a program with motion, and a warning was given if due; or the arm is
/// homing.
pub(super) const READ_FOR_MOTION: u8 = 2;

/// True if this request homes the arm.
pub(super) fn homes(request: &Frame<'_>) -> bool {
    request.ctrl().write() && request.id() == HomeCmd::ROW.id
}

/// Homing state of an arm, returned by [`Arm::homing`]. [`Arm::home`] homes the arm.
#[derive(Clone, Copy, Debug)]
pub struct Homing<'a> {
    arm: &'a Arm,
}

impl Homing<'_> {
    /// Returns whether the arm is homed since power-up; `None` if unknown, because the protocol has
    /// no query for it.
    ///
    /// Homings over this connection count, and earlier ones in the record
    /// [`Options::homings`](super::Options::homings). Clearing alarm 0x00 does not home an arm.
    ///
    /// # Errors
    /// Same as [`get`](Arm::get), for reading the alarms.
    pub async fn is_homed(self) -> Result<Option<bool>> {
        // The picture evaluates alarm 0x00 of the answer.
        self.arm.alarms().await?;
        if !self.arm.is_virtual() {
            self.recall().await;
        }
        self.settle().await;
        Ok(self.arm.picture().homed())
    }

    /// Refuses a real arm unless it is known to be [homed](Self::is_homed), because it would draw,
    /// burn, play or be taught in the wrong place.
    ///
    /// A [virtual arm](Arm::is_virtual) passes: its positions are right without homing.
    /// [`allowing_unhomed`](Arm::allowing_unhomed) skips the check.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) with [`ErrorCode::NotHomed`] if
    /// it is not homed; else as [`get`](Arm::get).
    pub async fn check(self) -> Result<()> {
        if self.arm.allows_unhomed || self.arm.is_virtual() {
            return Ok(());
        }
        let message = match self.is_homed().await? {
            Some(true) => return Ok(()),
            Some(false) => message!(
                "the arm was not homed since power-up (alarm 0x00), so its positions may be wrong; \
                    nothing was sent"
            ),
            None => message!(
                "it is not known whether the arm was homed since power-up: this computer saw no homing, \
                    so its positions may be wrong; nothing was sent"
            ),
        };
        Err(Error::new(ErrorCode::NotHomed, message)
            .remedy(Action::Home, "homes it")
            .remedy((Setting::Unhomed, SettingValue::On), "goes on anyway"))
    }

    /// Prepares for a homing command: reads what later decides if the homing counts, and the
    /// identity of the arm.
    pub(super) async fn expect(self) {
        if self.arm.is_virtual() || self.arm.inner.options.homings.is_none() {
            return;
        }
        // An arm that answers neither also fails the homing, whose error says more.
        let _ = self.arm.alarms().await;
        let _ = self.read_identity().await;
    }

    /// Records a homing that completed during the program that has just ended.
    pub(super) async fn settle(self) {
        let needs_alarms = self.arm.picture().homing().needs_alarms();
        if needs_alarms && self.arm.alarms().await.is_err() {
            return;
        }
        if self.arm.picture().homing().needs_place() {
            let Ok(at_home) = self.stands_at_home().await else {
                return;
            };
            self.arm.picture().stood_at_home(at_home);
        }
        if !self.arm.picture().take_new_homing() || self.arm.is_virtual() {
            return;
        }
        let Some(record) = &self.arm.inner.options.homings else {
            return;
        };
        match self.read_identity().await {
            Ok((identity, uptime, rate)) => record.keep(&identity, uptime, rate),
            Err(error) => tracing::info!(
                %error,
                "{}: the homing cannot be remembered beyond this program",
                self.arm.name()
            ),
        }
    }

    /// True if the arm is at its home point: the default of the firmware, or the last one set.
    async fn stands_at_home(self) -> Result<bool> {
        let pose = self.arm.get::<Pose>().await?;
        // Another read may have updated the picture meanwhile, so that the place is no longer
        // needed.
        if !self.arm.picture().homing().needs_place() {
            return Ok(true);
        }
        let home = self.arm.get::<HomeParams>().await?;
        let away = [pose.x - home.x, pose.y - home.y, pose.z - home.z];
        Ok(away.iter().map(|axis| axis * axis).sum::<f32>() <= HOME_TOLERANCE * HOME_TOLERANCE)
    }

    /// Returns an error if the homing just waited for did not end at the home point.
    pub(super) fn check_ended(self) -> Result<()> {
        if self.arm.picture().homing().is_homed() {
            return Ok(());
        }
        let message = message!(
            "the arm did not come to its home point: a stop, or another program, broke the \
            homing off"
        );
        Err(Error::new(ErrorCode::NotHomed, message).remedy(Action::Home, "homes it"))
    }

    /// Looks in the record for a homing before this connection. The uptime shows if the arm was
    /// reset since.
    async fn recall(self) {
        let Some(record) = &self.arm.inner.options.homings else {
            return;
        };
        let Ok((identity, uptime, _)) = self.read_identity().await else {
            return;
        };
        let is_homed = self.arm.picture().homing().is_homed();
        if !is_homed && record.is_homed(&identity, uptime) {
            self.arm.picture().remember_homing();
        }
    }

    /// Reads identity, uptime and clock rate of the arm.
    async fn read_identity(self) -> Result<(ArmIdentity, Duration, ClockRate)> {
        let serial = self.arm.get::<DeviceSn>().await?.device_sn.to_string();
        let identity = ArmIdentity::new(serial.trim(), self.arm.name());
        let asked = Instant::now();
        let ms = self.arm.get::<DeviceTime>().await?.g_systick;
        let reading = ClockReading {
            asked,
            heard: Instant::now(),
            uptime: Duration::from_millis(ms.into()),
        };
        let mut cache = self.arm.inner.shared.identity_cache();
        cache.identity = Some(identity.clone());
        let first = *cache.first.get_or_insert(reading);
        Ok((identity, reading.uptime, first.rate_until(&reading)))
    }

    /// Warns once per connection if the arm does not seem to be homed since power-up.
    ///
    /// A virtual arm in this process always has just been powered up, and its positions are right;
    /// the alarms are read all the same, so that it receives the same frames as a real one. A
    /// program without motion (only a belt, say) reads the alarms as well, and warns of nothing.
    pub(super) async fn warn_if_not_homed(self, moves: bool) -> Result<()> {
        let asks = if moves {
            READ_FOR_MOTION
        } else {
            READ_WITHOUT_MOTION
        };
        // Clones may ask at the same time; only the first of them reads.
        if self.arm.inner.reset_asked.fetch_max(asks, Ordering::SeqCst) >= asks {
            return Ok(());
        }
        if self.arm.alarms().await?.contains(Alarm::ResetOccurred)
            && moves
            && !self.arm.is_virtual()
            && !self.arm.picture().homing().is_homed()
        {
            tracing::warn!(
                "{}: the arm reports a reset that was not cleared since; unless it was homed, its \
                    positions are wrong: home it",
                self.arm.name()
            );
        }
        Ok(())
    }
}

impl Arm {
    /// Returns the homing state.
    #[must_use]
    pub const fn homing(&self) -> Homing<'_> {
        Homing { arm: self }
    }

    /// Returns a handle of the same connection that accepts an arm not known to be homed; see
    /// [`Homing::check`].
    #[must_use]
    pub fn allowing_unhomed(&self) -> Self {
        Self {
            allows_unhomed: true,
            ..self.clone()
        }
    }
}

/// Record of homings, shared with the driver task.
#[derive(Debug, Default)]
pub(super) struct Homings {
    pub(super) record: Option<Arc<dyn HomingRecord>>,
    identity_cache: Mutex<IdentityCache>,
}

impl Homings {
    pub(super) fn new(record: Option<Arc<dyn HomingRecord>>) -> Self {
        Self {
            record,
            identity_cache: Mutex::default(),
        }
    }

    pub(super) fn identity_cache(&self) -> MutexGuard<'_, IdentityCache> {
        lock(&self.identity_cache)
    }

    /// Invalidates the record when a homing command is sent.
    pub(super) fn begins(&self) {
        if let (Some(record), Some(identity)) = (&self.record, self.identity_cache().identity()) {
            record.forget(identity);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clock_rate_is_steady_unless_no_crystal_explains_it() {
        let begun = Instant::now();
        let reading = |asked: u64, heard: u64, uptime: u64| ClockReading {
            asked: begun + Duration::from_millis(asked),
            heard: begun + Duration::from_millis(heard),
            uptime: Duration::from_millis(uptime),
        };
        let first = reading(0, 10, 5_000);
        for (later, rate) in [
            (reading(20_000, 20_010, 25_005), ClockRate::Steady),
            (reading(20_000, 20_010, 25_100), ClockRate::Steady),
            (reading(20_000, 20_010, 24_900), ClockRate::Steady),
            (reading(100, 110, 25_000), ClockRate::Faster),
            (reading(20_000, 20_010, 405_000), ClockRate::Faster),
            (reading(20_000, 20_010, 15_000), ClockRate::Slower),
            // A late reply makes the interval so wide that it proves nothing.
            (reading(10, 3_000, 8_000), ClockRate::Steady),
            (reading(10, 3_000, 5_010), ClockRate::Steady),
        ] {
            assert_eq!(first.rate_until(&later), rate, "{later:?}");
        }
    }
}
