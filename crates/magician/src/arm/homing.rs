//! The arm's homing: what this connection has seen of it, and the record of earlier connections.

use std::fmt;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use magician_protocol::commands::{DeviceSn, DeviceTime, HomeCmd, HomeParams, Pose};
use magician_protocol::{Alarm, Frame, Writable};
use tokio::time::Instant;

use super::Arm;
use super::shared::held;
use crate::message;
use crate::{Action, Error, ErrorCode, Given, Result, Setting};

/// A controller's crystal is better than this, per mille of the time that has passed: a clock that is further off is a virtual
/// arm's, at another speed than real time.
const CRYSTAL: f64 = 10.0;
/// A reading of the clock may be off by this much more: the controller counts ms, and this program is scheduled.
const READING: Duration = Duration::from_millis(50);

/// Distance from the home point, mm, within which a homing has ended there. A homed arm was recorded 0.01 mm from it (model
/// section 11); a homing that was broken off stands some centimetres away.
const AT_HOME: f32 = 2.0;

/// An arm, as far as it can be told from others.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ArmIdentity {
    /// Serial number; empty if the arm reports none.
    pub serial: String,
    /// Port: the target as it was given.
    pub port: String,
}

impl ArmIdentity {
    /// The arm of this serial number at this port.
    #[must_use]
    pub fn new(serial: impl Into<String>, port: impl Into<String>) -> Self {
        Self {
            serial: serial.into(),
            port: port.into(),
        }
    }
}

/// Rate of the arm's clock against the clock of this computer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ClockRate {
    /// The rate of a crystal, or not measured.
    #[default]
    Steady,
    /// Faster than any crystal: a virtual arm.
    Faster,
    /// Slower than any crystal: a virtual arm.
    Slower,
}

/// Memory of homings that outlives the connection. An arm is homed until it is switched off, and programs come and go.
///
/// The methods are called from the tasks of the connection and must not block for long.
pub trait HomingRecord: fmt::Debug + Send + Sync {
    /// The arm was seen to home, and has been switched on for `uptime` now.
    fn keep(&self, arm: &ArmIdentity, uptime: Duration, rate: ClockRate);

    /// Homing begins: until it has ended the arm is not homed.
    fn forget(&self, arm: &ArmIdentity);

    /// True if this arm, which has been switched on for `uptime` now, was homed since. What cannot be told apart from another arm,
    /// or from another power-up, is false.
    fn is_homed(&self, arm: &ArmIdentity, uptime: Duration) -> bool;
}

/// Readings of an arm for its record.
#[derive(Debug, Default)]
pub(super) struct Remembered {
    identity: Option<ArmIdentity>,
    /// The first reading of the arm's clock since it was reset.
    first: Option<ClockReading>,
}

#[derive(Clone, Copy, Debug)]
struct ClockReading {
    asked: Instant,
    heard: Instant,
    uptime: Duration,
}

impl Remembered {
    /// The arm was reset, or another one may be at the line.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    pub(super) fn identity(&self) -> Option<&ArmIdentity> {
        self.identity.as_ref()
    }
}

impl ClockReading {
    /// Returns the rate from this reading to a later one.
    fn rate_until(&self, later: &Self) -> ClockRate {
        let least = later.asked.saturating_duration_since(self.heard);
        let most = later.heard.saturating_duration_since(self.asked);
        let ran = later.uptime.saturating_sub(self.uptime);
        if ran > most.mul_f64(1.0 + CRYSTAL / 1000.0) + READING {
            ClockRate::Faster
        } else if ran + READING < least.mul_f64(1.0 - CRYSTAL / 1000.0) {
            ClockRate::Slower
        } else {
            ClockRate::Steady
        }
    }
}

/// The alarms were read for a program that moves nothing.
pub(super) const ASKED: u8 = 1;
/// They were read for one that moves the arm, which was warned, or the arm homes.
pub(super) const WARNED: u8 = 2;

/// True if this request homes the arm.
pub(super) fn homes(request: &Frame<'_>) -> bool {
    request.ctrl().write() && request.id() == HomeCmd::ROW.id
}

/// Homing of an arm: whether it was homed since power-up, which the protocol has no query for. [`Arm::homing`] hands it out;
/// [`Arm::home`] homes the arm.
#[derive(Clone, Copy, Debug)]
pub struct Homing<'a> {
    arm: &'a Arm,
}

impl Homing<'_> {
    /// True if the arm is homed. Homing seen over this connection counts, and what
    /// [`Options::homings`](super::Options::homings) remembers of earlier ones; clearing alarm 0x00 does not home an arm. `None`
    /// if it is not known: the protocol has no query for it.
    ///
    /// # Errors
    /// As [`get`](Arm::get), for the alarms.
    pub async fn is_homed(self) -> Result<Option<bool>> {
        // The picture takes alarm 0x00 of the answer.
        self.arm.alarms().await?;
        if !self.arm.is_virtual() {
            self.recall().await;
        }
        self.settle().await;
        Ok(self.arm.picture().homed())
    }

    /// Refuses a real arm that is not known to be [homed](Self::is_homed): it would draw, burn, play or be taught in the wrong place.
    /// A [virtual arm](Arm::is_virtual) stands where it believes. [`allowing_unhomed`](Arm::allowing_unhomed) goes on.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) with [`ErrorCode::NotHomed`]; else as [`get`](Arm::get).
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
            .remedy((Setting::Unhomed, Given::On), "goes on anyway"))
    }

    /// A homing command is about to be sent: reads what is needed to tell whether it counts, and of which arm.
    pub(super) async fn expect(self) {
        if self.arm.is_virtual() || self.arm.inner.options.homings.is_none() {
            return;
        }
        // An arm that answers none of these fails in the homing too, which says it better.
        let _ = self.arm.alarms().await;
        let _ = self.meet().await;
    }

    /// A program has ended: a homing of it that has finished is written down.
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
        match self.meet().await {
            Ok((identity, uptime, rate)) => record.keep(&identity, uptime, rate),
            Err(error) => tracing::info!(
                %error,
                "{}: the homing cannot be remembered beyond this program",
                self.arm.name()
            ),
        }
    }

    /// True if the arm stands at its home point: that of the firmware, or the one that was set.
    async fn stands_at_home(self) -> Result<bool> {
        let pose = self.arm.get::<Pose>().await?;
        if !self.arm.picture().homing().needs_place() {
            return Ok(true);
        }
        let home = self.arm.get::<HomeParams>().await?;
        let away = [pose.x - home.x, pose.y - home.y, pose.z - home.z];
        Ok(away.iter().map(|axis| axis * axis).sum::<f32>() <= AT_HOME * AT_HOME)
    }

    /// Returns an error if the homing that was just waited for did not end at the home point.
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

    /// Looks whether the arm was homed before this connection, and whether it was reset since: its clock tells.
    async fn recall(self) {
        let Some(record) = &self.arm.inner.options.homings else {
            return;
        };
        let Ok((identity, uptime, _)) = self.meet().await else {
            return;
        };
        let is_homed = self.arm.picture().homing().is_homed();
        if !is_homed && record.is_homed(&identity, uptime) {
            self.arm.picture().remember_homing();
        }
    }

    /// Reads identity, uptime and clock rate of the arm.
    async fn meet(self) -> Result<(ArmIdentity, Duration, ClockRate)> {
        let serial = self.arm.get::<DeviceSn>().await?.device_sn.to_string();
        let identity = ArmIdentity::new(serial.trim(), self.arm.name());
        let asked = Instant::now();
        let ms = self.arm.get::<DeviceTime>().await?.g_systick;
        let reading = ClockReading {
            asked,
            heard: Instant::now(),
            uptime: Duration::from_millis(ms.into()),
        };
        let mut remembered = self.arm.inner.shared.remembered();
        remembered.identity = Some(identity.clone());
        let first = *remembered.first.get_or_insert(reading);
        Ok((identity, reading.uptime, first.rate_until(&reading)))
    }

    /// Warns, once, that the arm was not homed since it was switched on, as far as can be told. A virtual arm in the process
    /// has always just been switched on, and stands where it believes; it is asked all the same, so that it hears the frames
    /// that a real one does.
    ///
    /// A program that moves no joint, a belt for one, reads the alarms as others do and warns of nothing.
    pub(super) async fn warn_if_not_homed(self, moves: bool) -> Result<()> {
        let asks = if moves { WARNED } else { ASKED };
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
    /// What is known of its homing.
    #[must_use]
    pub const fn homing(&self) -> Homing<'_> {
        Homing { arm: self }
    }

    /// A handle of the same connection that takes an arm which is not known to be homed as it is: see
    /// [`Homing::check`].
    #[must_use]
    pub fn allowing_unhomed(&self) -> Self {
        Self {
            allows_unhomed: true,
            ..self.clone()
        }
    }
}

/// The record of a connection, for the task that sends.
#[derive(Debug, Default)]
pub(super) struct Homings {
    pub(super) record: Option<Arc<dyn HomingRecord>>,
    remembered: Mutex<Remembered>,
}

impl Homings {
    pub(super) fn new(record: Option<Arc<dyn HomingRecord>>) -> Self {
        Self {
            record,
            remembered: Mutex::default(),
        }
    }

    pub(super) fn remembered(&self) -> MutexGuard<'_, Remembered> {
        held(&self.remembered)
    }

    /// A homing command goes out.
    pub(super) fn begins(&self) {
        if let (Some(record), Some(identity)) = (&self.record, self.remembered().identity()) {
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
            // The answer was late: nothing is known.
            (reading(10, 3_000, 8_000), ClockRate::Steady),
            (reading(10, 3_000, 5_010), ClockRate::Steady),
        ] {
            assert_eq!(first.rate_until(&later), rate, "{later:?}");
        }
    }
}
