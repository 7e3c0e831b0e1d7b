//! Numbering of steps and commands.
//!
//! The arm counts commands, but parts and pauses are steps without one. The positions of these
//! silent steps within an iteration are enough to convert either count into the other, over any
//! number of iterations.

use std::sync::Arc;

use crate::Plan;

/// Numbering of steps and commands over all iterations, for programs in which some steps send
/// nothing.
///
/// ```
/// use magician_program::{Action, Origin, Part, Plan, Program};
///
/// let mut plan = Plan::new("two waits, each a part of its own");
/// for n in [1, 2] {
///     plan.push(Action::Part(Box::new(Part { n, ..Part::default() })), Origin::NONE);
///     plan.push(Action::Wait(10), Origin::NONE);
/// }
/// let program = Program::new(plan, Some(2));
/// let steps = program.numbering();
/// assert_eq!([0, 1, 2, 3, 4].map(|commands| steps.steps(commands)), [0, 2, 4, 6, 8]);
/// assert_eq!([0, 1, 2, 3, 8].map(|count| steps.commands(count)), [0, 0, 1, 1, 4]);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StepNumbering {
    /// Indices, within an iteration, of the steps that send nothing; sorted.
    silent: Arc<[u64]>,
    /// Number of steps in an iteration.
    iteration: u64,
}

impl StepNumbering {
    pub(super) fn of(plan: &Plan) -> Self {
        let steps = (0..).zip(&plan.steps);
        let silent = steps.filter(|(_, step)| step.action.is_silent());
        Self {
            silent: silent.map(|(nth, _)| nth).collect(),
            iteration: plan.steps.len() as u64,
        }
    }

    /// Number of commands in the first `steps` steps.
    #[must_use]
    pub fn commands(&self, steps: u64) -> u64 {
        if self.silent.is_empty() {
            return steps;
        }
        let (iterations, within) = (steps / self.iteration, steps % self.iteration);
        let before = self.silent.partition_point(|place| *place < within) as u64;
        iterations * (self.iteration - self.silent.len() as u64) + within - before
    }

    /// Number of steps that this many commands complete. Steps without a command after the last one
    /// do not count.
    #[must_use]
    pub fn steps(&self, commands: u64) -> u64 {
        let each = self.iteration - self.silent.len() as u64;
        if self.silent.is_empty() || commands == 0 || each == 0 {
            return commands;
        }
        let (iterations, nth) = ((commands - 1) / each, (commands - 1) % each);
        // Binary search: number of silent steps before the command.
        let (mut least, mut most) = (0, self.silent.len());
        while least < most {
            let middle = usize::midpoint(least, most);
            let place = self.silent.get(middle).copied().unwrap_or(u64::MAX);
            if place - middle as u64 <= nth {
                least = middle + 1;
            } else {
                most = middle;
            }
        }
        (iterations.saturating_mul(self.iteration))
            .saturating_add(nth + least as u64)
            .saturating_add(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_and_steps_convert_both_ways() {
        for silent in [vec![], vec![0], vec![4], vec![0, 1, 3], vec![2, 3, 4]] {
            let numbering = StepNumbering {
                silent: silent.clone().into(),
                iteration: 5,
            };
            let sends = |step: &u64| !silent.contains(&(step % 5));
            for steps in 0..=23 {
                let count = (0..steps).filter(sends).count() as u64;
                assert_eq!(numbering.commands(steps), count, "{silent:?} {steps}");
            }
            let places = (0..23).filter(sends).map(|step| step + 1);
            for (commands, steps) in (1..).zip(places) {
                assert_eq!(numbering.steps(commands), steps, "{silent:?} {commands}");
            }
            assert_eq!(numbering.steps(0), 0);
        }
    }

    #[test]
    fn silent_plan_has_no_commands() {
        let numbering = StepNumbering {
            silent: vec![0, 1].into(),
            iteration: 2,
        };
        assert_eq!((numbering.commands(2), numbering.commands(5)), (0, 0));
        assert_eq!(numbering.steps(0), 0);
    }
}
