//! The arm's state for any number of onlookers, at the price of one.

use std::sync::Arc;
use std::time::Duration;

use magician_protocol::AlarmSet;
use magician_protocol::commands::Pose;
use tokio::sync::watch;
use tokio::time::{Instant, sleep_until};

use super::driver::Message;
use super::shared::held;
use super::{Arm, Link, Shared};
use crate::{ArmSnapshot, Error, Level, Pin, QueueIndex, Result};

/// Readings a second that can be asked for.
const RATES: std::ops::RangeInclusive<f64> = 0.01..=1000.0;
/// EIO addresses of the pins (document 1.15).
const PINS: std::ops::RangeInclusive<u8> = 1..=20;

/// The state of an arm as it was read last.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Status {
    /// Where the tool point is, and the joints.
    pub pose: Pose,
    /// The queued command that was finished last.
    pub current: QueueIndex,
    /// Free places in the queue.
    pub left_space: u32,
    /// The alarms that stand.
    pub alarms: AlarmSet,
    /// Whether the arm is homed: [`Homing::is_homed`](super::Homing::is_homed), by what was seen so far.
    pub homed: Option<bool>,
    /// Levels of the watched pins, in no order.
    pub pins: Arc<[Level]>,
    /// Whether there is a line; while there is none the rest is of before.
    pub link: Link,
    /// When the pose was read. The rest was read within one period of it; while no command ends, free places and alarms within two of them
    /// from 20 readings a second on.
    pub at: std::time::Instant,
}

impl Status {
    /// The value of a pin, if it is watched: 0 or 1, counts (4095 at 3.3 V) for an analog one.
    #[must_use]
    pub fn level(&self, pin: Pin) -> Option<u16> {
        let level = self.pins.iter().find(|level| level.pin == pin);
        level.map(|level| level.value)
    }
}

/// What a [`StateWatch`] is to see, and how often.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StateOptions {
    /// Whole readings a second, 0.01 to 1000.
    pub rate: f64,
    /// Pins to read as well. Each must have been given its function (`build::multiplex`).
    pub pins: Vec<Pin>,
}

impl StateOptions {
    /// So many whole readings a second.
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
            return Err(Error::invalid(format!(
                "the rate is {} readings a second, it must be {} to {}",
                self.rate,
                RATES.start(),
                RATES.end()
            )));
        }
        let wrong = self.pins.iter().find(|pin| !PINS.contains(&pin.address()));
        if let Some(pin) = wrong {
            return Err(Error::invalid(format!(
                "unknown pin {}: EIO addresses are {} to {}",
                pin.address(),
                PINS.start(),
                PINS.end()
            )));
        }
        Ok(Duration::from_secs_f64(self.rate.recip()))
    }
}

impl Shared {
    /// The state by what was read so far; `None` before all of it was.
    pub(super) fn status_now(&self) -> Option<Status> {
        let watched = held(&self.watches).pins();
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

/// The watches, for the task that reads for them.
#[derive(Debug, Default)]
pub(super) struct Watches {
    wanted: Vec<(u64, Duration, Vec<Pin>)>,
    next: u64,
}

impl Watches {
    /// The shortest period that is wanted.
    pub(super) fn period(&self) -> Option<Duration> {
        self.wanted.iter().map(|(_, period, _)| *period).min()
    }

    /// Every pin that is wanted, once.
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

/// The arm's state, kept up to date. All watches share one set of reads: at the highest rate that any of them asks for,
/// one read at a time and evenly spread (pose, index, space, alarms, then the pins), and less often when the line is
/// busy. Dropping the last watch ends the reads. It does not keep the connection.
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
    /// Not told again before.
    next: Instant,
}

impl StateWatch {
    /// The state as it was read last, by this watch or another one; `None` before the first whole reading.
    #[must_use]
    pub fn latest(&self) -> Option<Status> {
        self.status.borrow().clone()
    }

    /// Waits for the next reading, for as long as it takes, and not sooner than this watch's own rate says. A line that
    /// is lost or found counts as one.
    ///
    /// # Errors
    /// [`ErrorKind::Closed`](crate::ErrorKind::Closed) when the connection has ended.
    pub async fn changed(&mut self) -> Result<Status> {
        sleep_until(self.next).await;
        loop {
            tokio::select! {
                biased;
                ended = self.link.wait_for(|link| *link == Link::Closed) => {
                    drop(ended);
                    return Err(Error::closed());
                }
                changed = self.status.changed() => changed.map_err(|_| Error::closed())?,
            }
            let status = self.status.borrow_and_update().clone();
            if let Some(status) = status {
                // Readings of a common pace are not to be missed by a hair.
                self.next = Instant::now() + self.period.mul_f64(0.9);
                return Ok(status);
            }
        }
    }
}

impl Drop for StateWatch {
    fn drop(&mut self) {
        let mut watches = held(&self.shared.watches);
        watches.wanted.retain(|(id, ..)| *id != self.id);
        if watches.wanted.is_empty() {
            // The next watch must not see old values.
            self.shared.status.send_replace(None);
        }
    }
}

impl Arm {
    /// Returns the state by the answers that have come over this connection, of whoever asked; `None` before all of it was
    /// read. No frame is sent.
    #[must_use]
    pub fn status(&self) -> Option<Status> {
        self.inner.shared.status_now()
    }

    /// Keeps an eye on the arm: pose, queue, alarms and link, so many times a second.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for a rate outside of 0.01 to 1000 a second.
    pub fn state(&self, rate: f64) -> Result<StateWatch> {
        self.state_with(StateOptions::at(rate))
    }

    /// As [`state`](Self::state), with pins.
    ///
    /// # Errors
    /// As [`state`](Self::state), and for a pin whose address is not 1 to 20.
    pub fn state_with(&self, options: StateOptions) -> Result<StateWatch> {
        let period = options.check()?;
        let shared = Arc::clone(&self.inner.shared);
        let id = {
            let mut watches = held(&shared.watches);
            watches.next += 1;
            let id = watches.next;
            watches.wanted.push((id, period, options.pins));
            id
        };
        // A task with so many messages before it is awake, and looks.
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
