//! How long bytes take on a serial line, and how the arm's clock follows the wall clock.

use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;

use crate::observer::{self, SampleBudget};
use crate::{Controller, Micros, Observer};

/// Bits on the line for one byte at 8N1: start, eight data bits, stop (document 1.1).
const BITS_PER_BYTE: u64 = 10;
const MICROS_PER_SECOND: u64 = 1_000_000;
/// Events, or instants shown to an observer, that one jump runs through before the caller gets a word in.
const JUMP_EVENTS: u32 = 100_000;
/// Wall time between two wake-ups for nothing but an observer.
const LOOK_APART: Micros = 10_000;
/// What takes longer has no end to jump to: 100 days, twice the longest WAIT. Speeds next to zero make motions that
/// outlast the clock.
const ENDLESS: Micros = 100 * 24 * 3600 * MICROS_PER_SECOND;

/// How fast the arm's clock runs against the wall clock.
///
/// Only the arm's clock is scaled. Baud pacing, turnaround and the inter-byte timeout are the
/// line's and stay in wall time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// Motion, WAIT and homing take no wall time: after every request the arm's clock jumps from
    /// event to event until the arm is no longer [busy](Controller::busy), so a queued command has
    /// finished before the next request is read. While the arm has nothing to do its clock runs at
    /// wall speed, and so do a jog, a belt, what a scenario does, and a motion of more than 100 days: they wait for the
    /// host.
    Max,
    /// Arm seconds per wall second. Zero stops the arm's clock; what is not a number or is
    /// negative counts as zero.
    Times(f64),
}

impl Default for Speed {
    /// Real time.
    fn default() -> Self {
        Self::Times(1.0)
    }
}

impl fmt::Display for Speed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Max => f.write_str("max"),
            Self::Times(times) => times.fmt(f),
        }
    }
}

/// A word that is neither `max` nor a positive number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpeedError;

impl fmt::Display for SpeedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "a speed must be 'max' or a positive number (1 is real time, 10 ten times \
            faster)",
        )
    }
}

impl std::error::Error for SpeedError {}

impl FromStr for Speed {
    type Err = SpeedError;

    fn from_str(text: &str) -> Result<Self, SpeedError> {
        if text.eq_ignore_ascii_case("max") {
            return Ok(Self::Max);
        }
        let times: f64 = text.parse().map_err(|_| SpeedError)?;
        let usable = times.is_finite() && times > 0.0;
        usable.then_some(Self::Times(times)).ok_or(SpeedError)
    }
}

/// The line between the host and the arm, in wall time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineTiming {
    /// Bits per second, 8N1, each direction on its own; `None` (or 0): bytes take no time.
    pub baud: Option<u32>,
    /// Microseconds from the last byte of a request to the first byte of its reply.
    pub turnaround: Micros,
}

/// One direction of a line: when the bytes put on it have passed, without rounding drift.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wire {
    baud: Option<NonZeroU32>,
    /// The line is busy until `busy` + `part` / baud microseconds.
    busy: Micros,
    part: u64,
}

impl Wire {
    pub(crate) fn new(line: LineTiming) -> Self {
        Self {
            baud: line.baud.and_then(NonZeroU32::new),
            busy: 0,
            part: 0,
        }
    }

    /// Puts `count` bytes on the line at `from` or when it falls free; returns the microsecond by
    /// which the last has passed.
    pub(crate) fn carry(&mut self, from: Micros, count: usize) -> Micros {
        let Some(baud) = self.baud else {
            return from;
        };
        if from > self.busy {
            (self.busy, self.part) = (from, 0);
        }
        let baud = u64::from(baud.get());
        let micros_times_baud = BITS_PER_BYTE * MICROS_PER_SECOND * count as u64 + self.part;
        self.busy = self.busy.saturating_add(micros_times_baud / baud);
        self.part = micros_times_baud % baud;
        self.busy.saturating_add(u64::from(self.part > 0))
    }
}

/// The arm's clock as a function of the wall clock: a straight line through one known instant.
#[derive(Clone, Copy, Debug)]
pub struct ArmClock {
    speed: Speed,
    wall: Micros,
    arm: Micros,
}

impl ArmClock {
    /// A clock that shows `arm` when the wall clock, which begins there, shows 0. A speed below 0 stands.
    #[must_use]
    pub fn new(speed: Speed, arm: Micros) -> Self {
        let speed = match speed {
            Speed::Times(times) if times.is_nan() || times < 0.0 => Speed::Times(0.0),
            other => other,
        };
        Self {
            speed,
            wall: 0,
            arm,
        }
    }

    pub(crate) fn speed(&self) -> Speed {
        self.speed
    }

    /// The same clock at another speed from the instant on at which it shows `arm` and the wall clock `wall`.
    pub(crate) fn at_speed(self, speed: Speed, arm: Micros, wall: Micros) -> Self {
        Self {
            wall,
            ..Self::new(speed, arm)
        }
    }

    /// Lets the arm's time pass until the wall clock shows `wall`. If that shows the observer more than can be shown in
    /// one go, the arm's clock stays behind and goes on from there.
    pub fn pass<O: Observer>(
        &mut self,
        controller: &mut Controller,
        observer: &mut O,
        wall: Micros,
    ) {
        let budget = &mut SampleBudget::new(JUMP_EVENTS);
        if self.speed != Speed::Max {
            if !observer::advance(controller, observer, self.arm_at(wall), budget) {
                (self.wall, self.arm) = (wall, controller.now());
            }
            return;
        }
        // Event by event: what ends an unbounded motion is where the jumps begin again.
        for _ in 0..JUMP_EVENTS {
            let end = self.arm_at(wall);
            match controller.poll_timeout() {
                Some(event) if event <= end => {
                    observer::advance(controller, observer, event, budget);
                }
                _ => {
                    observer::advance(controller, observer, end, budget);
                    break;
                }
            }
            let at = self.wall_at(controller.now()).unwrap_or(wall).min(wall);
            self.jump(controller, observer, at);
        }
        self.jump(controller, observer, wall);
    }

    /// At full speed, runs through all that the arm is busy with in no wall time.
    pub fn jump<O: Observer>(
        &mut self,
        controller: &mut Controller,
        observer: &mut O,
        wall: Micros,
    ) {
        if self.speed != Speed::Max {
            return;
        }
        let budget = &mut SampleBudget::new(JUMP_EVENTS);
        for _ in 0..JUMP_EVENTS {
            match Self::jump_to(controller) {
                Some(event) => {
                    if !observer::advance(controller, observer, event, budget) {
                        break;
                    }
                }
                None => break,
            }
        }
        if controller.now() != self.arm_at(wall) {
            (self.wall, self.arm) = (wall, controller.now());
        }
    }

    /// The next event, if it is the end of something that has one.
    pub(crate) fn jump_to(controller: &Controller) -> Option<Micros> {
        let event = controller.poll_timeout()?;
        let endless = event.saturating_sub(controller.now()) > ENDLESS;
        (!endless && controller.busy()).then_some(event)
    }

    /// When the controller's next event is due by the wall clock, which shows `wall`.
    pub(crate) fn next(&self, controller: &Controller, wall: Micros) -> Option<Micros> {
        let event = controller.poll_timeout()?;
        if self.speed == Speed::Max && Self::jump_to(controller).is_some() {
            return Some(wall);
        }
        self.wall_at(event)
    }

    /// When an instant of the arm's clock is to be shown to an observer: when it has come by the wall clock, which shows
    /// `wall`, but not for each of many in a short time.
    pub(crate) fn next_sample(&self, look: Micros, wall: Micros) -> Option<Micros> {
        Some(self.wall_at(look)?.max(wall.saturating_add(LOOK_APART)))
    }

    fn arm_at(&self, wall: Micros) -> Micros {
        let passed = wall.saturating_sub(self.wall);
        let passed = match self.speed {
            Speed::Times(times) if times != 1.0 => (passed as f64 * times) as Micros,
            _ => passed,
        };
        self.arm.saturating_add(passed)
    }

    /// The first wall microsecond at which the arm's clock shows `arm` or more.
    fn wall_at(&self, arm: Micros) -> Option<Micros> {
        let left = arm.saturating_sub(self.arm);
        let Speed::Times(times) = self.speed else {
            return Some(self.wall.saturating_add(left));
        };
        if times == 0.0 {
            return None;
        }
        // The division may round either way by a hair; step back, then forward to the first.
        let guess = (left as f64 / times).ceil() as Micros;
        let mut wall = self.wall.saturating_add(guess.saturating_sub(2));
        for _ in 0..4 {
            if self.arm_at(wall) >= arm {
                break;
            }
            wall = wall.saturating_add(1);
        }
        Some(wall)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_second_of_bytes_takes_a_second() {
        for baud in [9_600, 57_600, 115_200, 230_400, 1_000_000] {
            let line = LineTiming {
                baud: Some(baud),
                turnaround: 0,
            };
            let mut wire = Wire::new(line);
            let bytes = baud / 10;
            let last = (0..bytes).fold(0, |_, _| wire.carry(0, 1));
            assert_eq!(last, 1_000_000, "{baud}");
        }
    }

    #[test]
    fn bytes_wait_for_the_line_and_the_line_for_bytes() {
        let mut wire = Wire::new(LineTiming {
            baud: Some(115_200),
            turnaround: 0,
        });
        assert_eq!(wire.carry(0, 6), 521);
        assert_eq!(wire.carry(100, 6), 1042);
        assert_eq!(wire.carry(5_000, 6), 5_521);
    }

    #[test]
    fn without_a_baud_rate_bytes_take_no_time() {
        for baud in [None, Some(0)] {
            let mut wire = Wire::new(LineTiming {
                baud,
                turnaround: 9,
            });
            assert_eq!(wire.carry(7, 4096), 7);
        }
    }

    #[test]
    fn speeds_read_back() {
        for text in ["max", "1", "0.25", "1000"] {
            let speed: Speed = text.parse().unwrap();
            assert_eq!(speed.to_string(), text);
        }
        for text in ["", "0", "-1", "inf", "NaN", "fast", "1x"] {
            assert_eq!(text.parse::<Speed>(), Err(SpeedError), "{text}");
        }
    }

    proptest! {
        #[test]
        fn cutting_does_not_change_when_bytes_pass(
            baud in 300u32..2_000_000,
            cuts in prop::collection::vec(1usize..300, 1..20),
        ) {
            let line = LineTiming { baud: Some(baud), turnaround: 0 };
            let (mut whole, mut cut) = (Wire::new(line), Wire::new(line));
            let total = cuts.iter().sum();
            let pieces = cuts.iter().fold(0, |_, count| cut.carry(10, *count));
            prop_assert_eq!(whole.carry(10, total), pieces);
        }

        #[test]
        fn an_arm_instant_is_reached_when_the_clock_says_and_not_before(
            times in 0.001f64..1e4,
            start in 0u64..1 << 40,
            left in 1u64..1 << 36,
        ) {
            let clock = ArmClock { speed: Speed::Times(times), wall: start, arm: 17 };
            let wall = clock.wall_at(17 + left).unwrap();
            prop_assert!(clock.arm_at(wall) >= 17 + left);
            prop_assert!(clock.arm_at(wall - 1) < 17 + left);
        }
    }
}
