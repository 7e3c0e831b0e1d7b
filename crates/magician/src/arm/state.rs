//! Shared state readings: any number of watches at the cost of one.
//!
//! A [`StateWatch`] asks for a rate and a set of pins. The driver task polls at the highest rate
//! that any watch asks for, reads the union of their pins, and publishes one [`Status`] to all.
//! [`Arm::status`] returns the same from the answers that have arrived anyway, without a frame.

use std::sync::Arc;
use std::time::Duration;

use magician_protocol::AlarmSet;
use magician_protocol::commands::Pose;
use tokio::sync::watch;
use tokio::time::{Instant, sleep_until};

use super::driver::Message;
use super::shared::lock;
use super::{Arm, Link, Shared};
use crate::{ArmSnapshot, Error, Level, Pin, QueueIndex, Result, message};

/// Allowed readings a second. Choice: no line carries more than 1000, and below 0.01 a single read
/// serves as well.
const RATES: std::ops::RangeInclusive<f64> = 0.01..=1000.0;
/// EIO addresses of the pins (document 1.15).
const PINS: std::ops::RangeInclusive<u8> = 1..=20;

/// State of an arm at its last reading.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Status {
    /// Pose of the tool tip, and joint angles.
    pub pose: Pose,
    /// Index of the queued command that finished last.
    pub current: QueueIndex,
    /// Free places in the queue.
    pub left_space: u32,
    /// Active alarms.
    pub alarms: AlarmSet,
    /// True if the arm is homed; see [`Homing::is_homed`](super::Homing::is_homed). `None` if not
    /// known.
    pub homed: Option<bool>,
    /// Levels of the watched pins, in any order.
    pub pins: Arc<[Level]>,
    /// State of the line. While it is lost, the other fields hold the last readings.
    pub link: Link,
    /// Time of the pose reading.
    ///
    /// The other fields were read within one period of it. From 20 readings a second on, free
    /// places and alarms are read within two periods while no command finishes.
    pub at: std::time::Instant,
}

impl Status {
    /// Returns the level of a watched pin: 0 or 1, or counts for an analog pin (4095 at 3.3 V).
    #[must_use]
    pub fn level(&self, pin: Pin) -> Option<u16> {
        let level = self.pins.iter().find(|level| level.pin == pin);
        level.map(|level| level.value)
    }
}

/// Rate and pins of a [`StateWatch`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StateOptions {
    /// Complete readings a second, 0.01 to 1000.
    pub rate: f64,
    /// Pins to read as well. Each must already have its function (`build::multiplex`).
    pub pins: Vec<Pin>,
}

impl StateOptions {
    /// Creates options for `rate` complete readings a second and no pins.
    #[must_use]
    pub fn at(rate: f64) -> Self {
        Self {
            rate,
            pins: Vec::new(),
        }
    }

    /// Sets [`pins`](Self::pins).
    #[must_use]
    pub fn pins(mut self, pins: impl IntoIterator<Item = Pin>) -> Self {
        self.pins = pins.into_iter().collect();
        self
    }

    fn check(&self) -> Result<Duration> {
        if !RATES.contains(&self.rate) {
            return Err(Error::invalid(message!(
                "the rate is {rate} readings a second, it must be {least} to {most}",
                rate = self.rate,
                least = RATES.start(),
                most = RATES.end()
            )));
        }
        let wrong = self.pins.iter().find(|pin| !PINS.contains(&pin.address()));
        if let Some(pin) = wrong {
            return Err(Error::invalid(message!(
                "unknown pin {address}: EIO addresses are {least} to {most}",
                address = pin.address(),
                least = PINS.start(),
                most = PINS.end()
            )));
        }
        Ok(Duration::from_secs_f64(self.rate.recip()))
    }
}

impl Shared {
    /// Returns the state from the answers so far; `None` until every field has been read once.
    pub(super) fn status_now(&self) -> Option<Status> {
        let watched = lock(&self.watches).pins();
        let ArmSnapshot {
            readings, homed, ..
        } = self.picture().snapshot();
        let readings = readings?;
        let pins = readings.pins.into_iter();
        Some(Status {
            pose: readings.pose,
            current: readings.current,
            left_space: readings.left_space,
            homed,
            alarms: readings.alarms,
            pins: pins.filter(|level| watched.contains(&level.pin)).collect(),
            link: self.link.borrow().clone(),
            at: (self.begun + Duration::from_micros(readings.at)).into_std(),
        })
    }
}

/// Registered watches, read by the driver task.
#[derive(Debug, Default)]
pub(super) struct Watches {
    wanted: Vec<(u64, Duration, Vec<Pin>)>,
    next: u64,
}

impl Watches {
    /// Returns the shortest period of all watches.
    pub(super) fn period(&self) -> Option<Duration> {
        self.wanted.iter().map(|(_, period, _)| *period).min()
    }

    /// Returns the pins of all watches, each once.
    pub(super) fn pins(&self) -> Vec<Pin> {
        let mut pins: Vec<Pin> = Vec::new();
        for pin in self.wanted.iter().flat_map(|(.., pins)| pins) {
            if !pins.contains(pin) {
                pins.push(*pin);
            }
        }
        pins
    }
}

/// Watch on the arm's state.
///
/// All watches share one set of reads, at the highest rate that any of them asks for. The reads are
/// sent one at a time and evenly spread (pose, index, space, alarms, then the pins), and less often
/// when the line is busy. Dropping the last watch ends the reads. A watch does not keep the
/// connection open.
///
/// ```
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> magician::Result<()> {
/// let arm = magician::Arm::connect("sim").await?;
/// let mut state = arm.state(20.0)?;
/// let seen = state.changed().await?;
/// assert_eq!(seen.left_space, 32);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct StateWatch {
    shared: Arc<Shared>,
    id: u64,
    status: watch::Receiver<Option<Status>>,
    link: watch::Receiver<Link>,
    period: Duration,
    /// Earliest time of the next report.
    next: Instant,
}

impl StateWatch {
    /// Returns the last state, read for this watch or another one; `None` before the first complete
    /// reading.
    #[must_use]
    pub fn latest(&self) -> Option<Status> {
        self.status.borrow().clone()
    }

    /// Waits for the next reading, without a timeout, and returns no faster than this watch's own
    /// rate. A line that is lost or found again also counts as a reading.
    ///
    /// # Errors
    /// [`ErrorKind::Closed`](crate::ErrorKind::Closed) when the connection has ended.
    pub async fn changed(&mut self) -> Result<Status> {
        sleep_until(self.next).await;
        loop {
            tokio::select! {
                // The end first: the last state of a closed connection is not a new one.
                biased;
                ended = self.link.wait_for(|link| *link == Link::Closed) => {
                    drop(ended);
                    return Err(Error::closed());
                }
                changed = self.status.changed() => changed.map_err(|_| Error::closed())?,
            }
            let status = self.status.borrow_and_update().clone();
            if let Some(status) = status {
                // With exactly one period, a reading of the common pace that comes slightly early
                // would be skipped.
                self.next = Instant::now() + self.period.mul_f64(0.9);
                return Ok(status);
            }
        }
    }
}

impl Drop for StateWatch {
    fn drop(&mut self) {
        let mut watches = lock(&self.shared.watches);
        watches.wanted.retain(|(id, ..)| *id != self.id);
        if watches.wanted.is_empty() {
            // The next watch must not return values from before it was created.
            self.shared.status.send_replace(None);
        }
    }
}

impl Arm {
    /// Returns the state from the answers that have arrived over this connection, whichever call
    /// requested them; `None` until every field has been read once. Sends no frame.
    #[must_use]
    pub fn status(&self) -> Option<Status> {
        self.inner.shared.status_now()
    }

    /// Watches pose, queue, alarms and link at `rate` readings a second.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for a rate outside 0.01 to 1000
    /// a second.
    pub fn state(&self, rate: f64) -> Result<StateWatch> {
        self.state_with(StateOptions::at(rate))
    }

    /// Watches the state as [`state`](Self::state) does, and pins as well.
    ///
    /// # Errors
    /// Same as [`state`](Self::state), and for a pin whose address is not 1 to 20.
    pub fn state_with(&self, options: StateOptions) -> Result<StateWatch> {
        let period = options.check()?;
        let shared = Arc::clone(&self.inner.shared);
        let id = {
            let mut watches = lock(&shared.watches);
            watches.next += 1;
            let id = watches.next;
            watches.wanted.push((id, period, options.pins));
            id
        };
        // If the inbox is full, the task is awake anyway and notices the new watch.
        let _ = self.inner.messages.try_send(Message::Wake);
        Ok(StateWatch {
            status: shared.status.subscribe(),
            link: shared.link.subscribe(),
            shared,
            id,
            period,
            next: Instant::now(),
        })
    }
}
