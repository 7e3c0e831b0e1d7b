//! The two stepper outputs: they run at a constant rate until the next command, or for a number of
//! pulses.
//!
//! The position is a closed-form function of time, as for the arm. A counted run ends on its exact
//! number of pulses, which rounding to microseconds would miss.

use crate::ArmInstant;
use crate::convert::micros;

/// Pulses per mm of the vendor's conveyor belt: 16,000 per turn of a roller 34 mm across (model
/// section 13).
pub const CONVEYOR_PULSES_PER_MM: f64 = 16_000.0 / (34.0 * std::f64::consts::PI);

/// Highest rate, pulses/s; higher ones are clamped. A choice that keeps positions finite.
const MAX_PULSE_RATE: f64 = 1e6;

/// A stepper output at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StepperState {
    /// Rate in pulses per second; the sign is the direction, 0 is rest.
    pub pulses_per_second: f64,
    /// Pulses since power-up; backward pulses count negative.
    pub pulses: f64,
    /// Instant at which it stops by itself; `None` without a count.
    pub ends: Option<ArmInstant>,
}

/// A stepper output, as a function of the time since its last command.
#[derive(Clone, Copy, Debug, Default)]
struct Motor {
    rate: f64,
    since: ArmInstant,
    /// Pulse count at the instant of the last command.
    counted: f64,
    run: Option<Run>,
}

/// A run of a given number of pulses.
#[derive(Clone, Copy, Debug)]
struct Run {
    ends: ArmInstant,
    /// Pulse count, since power-up, at its end.
    counted: f64,
}

impl Motor {
    fn state(&self, now: ArmInstant) -> StepperState {
        let seconds = now.micros_since(self.since) as f64 / 1e6;
        StepperState {
            pulses_per_second: self.rate,
            pulses: self.counted + self.rate * seconds,
            ends: self.run.map(|run| run.ends),
        }
    }
}

/// The two outputs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Steppers {
    motors: [Motor; 2],
}

/// Result of a command for an output.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepperChange {
    /// New rate, if it has changed.
    pub(crate) rate: Option<f64>,
    /// True if it counts pulses from now on.
    pub(crate) counts: bool,
}

impl Steppers {
    pub(crate) const COUNT: usize = 2;

    pub(crate) fn states(&self, now: ArmInstant) -> [StepperState; Self::COUNT] {
        self.motors.map(|motor| motor.state(now))
    }

    /// Next instant at which an output stops by itself.
    pub(crate) fn next_event(&self) -> Option<ArmInstant> {
        let ends = |motor: &Motor| motor.run.map(|run| run.ends);
        self.motors.iter().filter_map(ends).min()
    }

    /// Runs an output at a rate, for a number of pulses if given. `None` if there is no such
    /// output.
    pub(crate) fn turn(
        &mut self,
        now: ArmInstant,
        output: usize,
        rate: f64,
        pulses: Option<u32>,
    ) -> Option<StepperChange> {
        // Both signs: the sign is the direction.
        let rate = rate.clamp(-MAX_PULSE_RATE, MAX_PULSE_RATE);
        // Neither a standing motor nor zero pulses may block the queue.
        let nothing = rate == 0.0 || pulses == Some(0);
        let motor = self.motors.get_mut(output)?;
        let counted = motor.state(now).pulses;
        let run = pulses.filter(|_| !nothing).map(|pulses| {
            let pulses = f64::from(pulses);
            Run {
                ends: now.after_micros(micros(pulses / rate.abs())),
                counted: counted + pulses.copysign(rate),
            }
        });
        let rate = if nothing { 0.0 } else { rate };
        let changed = rate != motor.rate;
        *motor = Motor {
            rate,
            since: now,
            counted,
            run,
        };
        Some(StepperChange {
            rate: changed.then_some(rate),
            counts: run.is_some(),
        })
    }

    /// Pulses at which an output has stopped, if its count has been reached by now.
    pub(crate) fn due(&self, now: ArmInstant, output: usize) -> Option<f64> {
        let run = self.motors.get(output)?.run?;
        (run.ends <= now).then_some(run.counted)
    }

    /// Sets the exact count of an output that has stopped, without the rounding of its end to a
    /// microsecond.
    pub(crate) fn set_counted(&mut self, output: usize, counted: f64) {
        if let Some(motor) = self.motors.get_mut(output) {
            motor.counted = counted;
        }
    }
}
