//! Timing: bytes on a serial line, and the arm's clock against the wall clock.
//!
//! A line is modelled by its baud rate alone; [`Wire`] computes when each byte has passed, without
//! rounding drift. The arm's clock is a linear function of the wall clock ([`ArmClock`]), scaled by
//! a [`Speed`]. Full speed ([`Speed::Max`]) is the exception: the clock jumps from event to event
//! while the arm is busy, and runs at wall speed while it is idle, so that scripts and belts wait
//! for the host.

use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;
use std::time::Duration;

use crate::observer::{self, SampleBudget};
use crate::{ArmInstant, Controller, HostInstant, Micros, Observer};

/// Bits on the line for one byte at 8N1: start, eight data bits, stop (document 1.1).
const BITS_PER_BYTE: u64 = 10;
const MICROS_PER_SECOND: u64 = 1_000_000;
/// Largest number of events, or of observed instants, in one call. A choice: the caller does not
/// wait long, and the overhead of a call is negligible.
const JUMP_EVENTS: u32 = 100_000;
/// Shortest wall time between two wake-ups for the observer alone. A choice: 100 wake-ups a second
/// are smooth enough for a display and cheap.
const SAMPLE_WAKEUP_INTERVAL: Duration = Duration::from_millis(10);
/// Longest time to the next event that the clock jumps over at full speed: 100 days, twice the
/// longest WAIT (2^32 ms). At speeds close to zero a motion outlasts any clock; jumping to its end
/// would leave the clock at its maximum.
const MAX_JUMP: Duration = Duration::from_secs(100 * 24 * 3600);

/// Speed of the arm's clock relative to the wall clock.
///
/// Only the arm's clock is scaled. Baud rate, turnaround and the inter-byte timeout belong to the
/// line and stay in wall time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// Motion, WAIT and homing take no wall time.
    ///
    /// After every request the arm's clock jumps from event to event until the arm is no longer
    /// [busy](Controller::busy), so a queued command has finished before the next request is read.
    /// While the arm is idle its clock runs at wall speed. A jog, a belt, a script and a motion of
    /// more than 100 days also run at wall speed, because they wait for the host.
    Max,
    /// Arm seconds per wall second. Zero stops the arm's clock; NaN and negative values count as
    /// zero.
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

/// Error: a text is neither `max` nor a positive number.
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
        // 0 is a valid clock (see `Times`), but as a user's speed it would be an arm that hangs.
        let usable = times.is_finite() && times > 0.0;
        usable.then_some(Self::Times(times)).ok_or(SpeedError)
    }
}

/// Timing of the line between host and arm, in wall time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineTiming {
    /// Bits per second, 8N1, for each direction; `None` or 0: bytes take no time.
    pub baud: Option<u32>,
    /// Time from the last byte of a request to the first byte of its reply.
    pub turnaround: Duration,
}

/// One direction of a line. Computes when its bytes have passed, without rounding drift.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wire {
    baud: Option<NonZeroU32>,
    /// The line is busy until `busy` plus `remainder` / baud microseconds.
    busy: HostInstant,
    remainder: u64,
}

impl Wire {
    pub(crate) fn new(line: LineTiming) -> Self {
        Self {
            baud: line.baud.and_then(NonZeroU32::new),
            busy: HostInstant::ZERO,
            remainder: 0,
        }
    }

    /// Puts `count` bytes on the line at `from`, or as soon as it is free. Returns the microsecond
    /// by which the last byte has passed.
    pub(crate) fn carry(&mut self, from: HostInstant, count: usize) -> HostInstant {
        let Some(baud) = self.baud else {
            return from;
        };
        // The line was idle in between, so no fraction of a microsecond carries over.
        if from > self.busy {
            (self.busy, self.remainder) = (from, 0);
        }
        let baud = u64::from(baud.get());
        let micros_times_baud = BITS_PER_BYTE * MICROS_PER_SECOND * count as u64 + self.remainder;
        self.busy = self.busy.after_micros(micros_times_baud / baud);
        self.remainder = micros_times_baud % baud;
        // A started microsecond counts, so no byte is ever early.
        self.busy.after_micros(u64::from(self.remainder > 0))
    }
}

/// The arm's clock as a linear function of the wall clock, through one known instant.
#[derive(Clone, Copy, Debug)]
pub struct ArmClock {
    speed: Speed,
    wall: HostInstant,
    arm: ArmInstant,
}

impl ArmClock {
    /// Creates a clock that shows `arm` at wall time 0. Speeds below 0 count as 0.
    #[must_use]
    pub fn new(speed: Speed, arm: ArmInstant) -> Self {
        let speed = match speed {
            Speed::Times(times) if times.is_nan() || times < 0.0 => Speed::Times(0.0),
            other => other,
        };
        Self {
            speed,
            wall: HostInstant::ZERO,
            arm,
        }
    }

    pub(crate) fn speed(&self) -> Speed {
        self.speed
    }

    /// Returns the clock at another speed, from the instant where it shows `arm` and the wall clock
    /// `wall`.
    pub(crate) fn at_speed(self, speed: Speed, arm: ArmInstant, wall: HostInstant) -> Self {
        Self {
            wall,
            ..Self::new(speed, arm)
        }
    }

    /// Advances the arm to the wall time `wall`.
    ///
    /// If the observer wants more instants than fit into one call, the arm's clock falls behind and
    /// continues from there.
    pub fn pass<O: Observer>(
        &mut self,
        controller: &mut Controller,
        observer: &mut O,
        wall: HostInstant,
    ) {
        let budget = &mut SampleBudget::new(JUMP_EVENTS);
        if self.speed != Speed::Max {
            if !observer::advance(controller, observer, self.arm_at(wall), budget) {
                (self.wall, self.arm) = (wall, controller.now());
            }
            return;
        }
        // Event by event, because the end of an unbounded motion may start work that the clock has
        // to jump through.
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

    /// At full speed, runs through everything that keeps the arm busy, in no wall time.
    pub fn jump<O: Observer>(
        &mut self,
        controller: &mut Controller,
        observer: &mut O,
        wall: HostInstant,
    ) {
        if self.speed != Speed::Max {
            return;
        }
        let budget = &mut SampleBudget::new(JUMP_EVENTS);
        for _ in 0..JUMP_EVENTS {
            match Self::jump_target(controller) {
                Some(event) => {
                    if !observer::advance(controller, observer, event, budget) {
                        break;
                    }
                }
                None => break,
            }
        }
        // Re-anchor the clock after a jump: from here on it runs at wall speed again.
        if controller.now() != self.arm_at(wall) {
            (self.wall, self.arm) = (wall, controller.now());
        }
    }

    /// Next event, if the arm is busy with something that has an end.
    pub(crate) fn jump_target(controller: &Controller) -> Option<ArmInstant> {
        let event = controller.poll_timeout()?;
        // The bound is on the next event alone: many short events may take longer in total.
        let endless = event - controller.now() > MAX_JUMP;
        (!endless && controller.busy()).then_some(event)
    }

    /// Wall time of the controller's next event; `wall` is the present.
    pub(crate) fn next(&self, controller: &Controller, wall: HostInstant) -> Option<HostInstant> {
        let event = controller.poll_timeout()?;
        // At full speed the event takes no wall time: it is due at once.
        if self.speed == Speed::Max && Self::jump_target(controller).is_some() {
            return Some(wall);
        }
        self.wall_at(event)
    }

    /// Wall time at which to show an instant of the arm's clock to an observer; `wall` is the
    /// present.
    ///
    /// Instants that follow each other quickly share a wake-up.
    pub(crate) fn next_sample(&self, sample: ArmInstant, wall: HostInstant) -> Option<HostInstant> {
        Some(self.wall_at(sample)?.max(wall + SAMPLE_WAKEUP_INTERVAL))
    }

    fn arm_at(&self, wall: HostInstant) -> ArmInstant {
        let passed = wall.micros_since(self.wall);
        let passed = match self.speed {
            // A speed of 1 avoids the detour over `f64`, which has no exact microseconds beyond
            // 2^53.
            Speed::Times(times) if times != 1.0 => (passed as f64 * times) as Micros,
            _ => passed,
        };
        self.arm.after_micros(passed)
    }

    /// First wall microsecond at which the arm's clock shows `arm` or more.
    fn wall_at(&self, arm: ArmInstant) -> Option<HostInstant> {
        let left = arm.micros_since(self.arm);
        let Speed::Times(times) = self.speed else {
            return Some(self.wall.after_micros(left));
        };
        if times == 0.0 {
            return None;
        }
        // The division may round either way: step back two microseconds, then search forward.
        let guess = (left as f64 / times).ceil() as Micros;
        let mut wall = self.wall.after_micros(guess.saturating_sub(2));
        // Two steps back and two for rounding; a longer search would only hide an error.
        for _ in 0..4 {
            if self.arm_at(wall) >= arm {
                break;
            }
            wall = wall.after_micros(1);
        }
        Some(wall)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(micros: u64) -> HostInstant {
        HostInstant::from_micros(micros)
    }

    #[test]
    fn a_second_of_bytes_takes_a_second() {
        for baud in [9_600, 57_600, 115_200, 230_400, 1_000_000] {
            let line = LineTiming {
                baud: Some(baud),
                turnaround: Duration::ZERO,
            };
            let mut wire = Wire::new(line);
            let bytes = baud / 10;
            let last = (0..bytes).fold(at(0), |_, _| wire.carry(at(0), 1));
            assert_eq!(last, at(1_000_000), "{baud}");
        }
    }

    #[test]
    fn bytes_wait_for_the_line_and_the_line_for_bytes() {
        let mut wire = Wire::new(LineTiming {
            baud: Some(115_200),
            turnaround: Duration::ZERO,
        });
        assert_eq!(wire.carry(at(0), 6), at(521));
        assert_eq!(wire.carry(at(100), 6), at(1042));
        assert_eq!(wire.carry(at(5_000), 6), at(5_521));
    }

    #[test]
    fn without_a_baud_rate_bytes_take_no_time() {
        for baud in [None, Some(0)] {
            let mut wire = Wire::new(LineTiming {
                baud,
                turnaround: Duration::from_micros(9),
            });
            assert_eq!(wire.carry(at(7), 4096), at(7));
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
            let line = LineTiming { baud: Some(baud), turnaround: Duration::ZERO };
            let (mut whole, mut cut) = (Wire::new(line), Wire::new(line));
            let total = cuts.iter().sum();
            let pieces = cuts.iter().fold(at(0), |_, count| cut.carry(at(10), *count));
            prop_assert_eq!(whole.carry(at(10), total), pieces);
        }

        #[test]
        fn an_arm_instant_is_reached_when_the_clock_says_and_not_before(
            times in 0.001f64..1e4,
            start in 0u64..1 << 40,
            left in 1u64..1 << 36,
        ) {
            let clock = ArmClock { speed: Speed::Times(times), wall: at(start), arm: ArmInstant::from_micros(17) };
            let then = ArmInstant::from_micros(17 + left);
            let wall = clock.wall_at(then).unwrap();
            prop_assert!(clock.arm_at(wall) >= then);
            prop_assert!(clock.arm_at(wall - Duration::from_micros(1)) < then);
        }
    }
}
