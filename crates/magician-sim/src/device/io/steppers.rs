//! The two stepper outputs: they turn steadily until they are told otherwise, or for a number of
//! pulses.

use crate::ArmInstant;
use crate::convert::micros;

/// Pulses that move the vendor's conveyor belt by 1 mm: 16,000 a turn of its roller, 34 mm across
/// (model section 13).
pub const CONVEYOR_PULSES_PER_MM: f64 = 16_000.0 / (34.0 * std::f64::consts::PI);

/// No stepper follows faster pulses, pulses/s; more counts as this.
const FASTEST: f64 = 1e6;

/// A stepper output at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StepperState {
    /// Pulses a second; the sign is the direction, 0 is rest.
    pub pulses_per_second: f64,
    /// Pulses since power-up, those backwards taken off.
    pub pulses: f64,
    /// When it comes to rest by itself.
    pub ends: Option<ArmInstant>,
}

/// One output, as a function of time since it was told last.
#[derive(Clone, Copy, Debug, Default)]
struct Motor {
    rate: f64,
    since: ArmInstant,
    /// Pulses up to then.
    counted: f64,
    run: Option<Run>,
}

/// A number of pulses and no more.
#[derive(Clone, Copy, Debug)]
struct Run {
    ends: ArmInstant,
    /// Pulses counted at its end.
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

/// The outputs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Steppers {
    motors: [Motor; 2],
}

/// What a command has made of an output.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turned {
    /// Its new rate, if that is another one.
    pub(crate) rate: Option<f64>,
    /// Whether it counts pulses from now on.
    pub(crate) counts: bool,
}

impl Steppers {
    pub(crate) const COUNT: usize = 2;

    pub(crate) fn states(&self, now: ArmInstant) -> [StepperState; Self::COUNT] {
        self.motors.map(|motor| motor.state(now))
    }

    /// When one next comes to rest by itself.
    pub(crate) fn next_event(&self) -> Option<ArmInstant> {
        let ends = |motor: &Motor| motor.run.map(|run| run.ends);
        self.motors.iter().filter_map(ends).min()
    }

    /// Turns an output at a rate from now on, for so many pulses if that is given; `None` where
    /// there is no output.
    pub(crate) fn turn(
        &mut self,
        now: ArmInstant,
        output: usize,
        rate: f64,
        pulses: Option<u32>,
    ) -> Option<Turned> {
        let rate = rate.clamp(-FASTEST, FASTEST);
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
        Some(Turned {
            rate: changed.then_some(rate),
            counts: run.is_some(),
        })
    }

    /// The pulses at which an output has come to rest by now, if it has counted what it was to.
    pub(crate) fn due(&self, now: ArmInstant, output: usize) -> Option<f64> {
        let run = self.motors.get(output)?.run?;
        (run.ends <= now).then_some(run.counted)
    }

    /// What an output that has come to rest has counted: exactly what it was to, without what
    /// rounding its end to a microsecond made of it.
    pub(crate) fn set_counted(&mut self, output: usize, counted: f64) {
        if let Some(motor) = self.motors.get_mut(output) {
            motor.counted = counted;
        }
    }
}
