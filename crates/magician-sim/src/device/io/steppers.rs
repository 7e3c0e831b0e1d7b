//! The two stepper outputs: they turn steadily until they are told otherwise, or for a number of pulses.

use crate::Micros;
use crate::convert::micros;
use crate::device::Device;
use crate::device::dispatch::Step;
use crate::device::queue::Busy;

/// Pulses that move the vendor's conveyor belt by 1 mm: 16,000 a turn of its roller, 34 mm across (model section 13).
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
    pub ends: Option<Micros>,
}

/// One output, as a function of time since it was told last.
#[derive(Clone, Copy, Debug, Default)]
struct Motor {
    rate: f64,
    since: Micros,
    /// Pulses up to then.
    counted: f64,
    run: Option<Run>,
}

/// A number of pulses and no more.
#[derive(Clone, Copy, Debug)]
struct Run {
    ends: Micros,
    /// Pulses counted at its end.
    counted: f64,
}

impl Motor {
    fn state(&self, now: Micros) -> StepperState {
        let seconds = now.saturating_sub(self.since) as f64 / 1e6;
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

impl Steppers {
    /// When one next comes to rest by itself.
    pub(crate) fn next_event(&self) -> Option<Micros> {
        let ends = |motor: &Motor| motor.run.map(|run| run.ends);
        self.motors.iter().filter_map(ends).min()
    }
}

impl Device {
    /// Turns an output at a rate from now on, for so many pulses if it is told. A command of the queue that it was busy
    /// with has finished.
    pub(crate) fn turn(&mut self, output: usize, rate: f64, pulses: Option<u32>) -> Step {
        let rate = rate.clamp(-FASTEST, FASTEST);
        let nothing = rate == 0.0 || pulses == Some(0);
        let now = self.now;
        let Some(motor) = self.steppers.motors.get_mut(output) else {
            return Step::Done;
        };
        let counted = motor.state(now).pulses;
        let run = pulses.filter(|_| !nothing).map(|pulses| {
            let pulses = f64::from(pulses);
            Run {
                ends: now.saturating_add(micros(pulses / rate.abs())),
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
        if changed {
            self.world.stepper(now, output, rate);
        }
        self.finish_turning(output);
        if run.is_some() {
            Step::Turning(output)
        } else {
            Step::Done
        }
    }

    /// Outputs that have put out their pulses come to rest.
    pub(crate) fn steppers_event(&mut self) {
        let now = self.now;
        for output in 0..self.steppers.motors.len() {
            let run = self.steppers.motors.get(output).and_then(|motor| motor.run);
            if let Some(Run { counted, .. }) = run.filter(|run| run.ends <= now) {
                self.turn(output, 0.0, None);
                if let Some(motor) = self.steppers.motors.get_mut(output) {
                    motor.counted = counted;
                }
            }
        }
    }

    /// The queue's running command ends on the spot if it counts pulses, and its motor with it.
    pub(crate) fn cut_turning(&mut self) {
        if let Some(Busy::Turning(output)) = self.queue.running.map(|running| running.busy) {
            self.turn(output, 0.0, None);
        }
    }

    /// Both outputs come to rest.
    pub(crate) fn rest_steppers(&mut self) {
        for output in 0..self.steppers.motors.len() {
            self.turn(output, 0.0, None);
        }
    }

    fn finish_turning(&mut self, output: usize) {
        if self.queue.running.map(|running| running.busy) == Some(Busy::Turning(output)) {
            self.finish_running();
        }
    }
}

impl crate::Controller {
    /// The stepper outputs, 1 and 2.
    #[must_use]
    pub fn steppers(&self) -> [StepperState; 2] {
        let now = self.core.now;
        self.core.steppers.motors.map(|motor| motor.state(now))
    }
}
