//! Program: a plan with its number of iterations, its start step, and the settings sent first.
//!
//! ```text
//! Program --remaining(step, start)--> RemainingProgram --check--> Report      result for an arm in this state
//!                                     --commands--> Arm::start
//!                                     --timetable--> Timetable   time left after a number of steps
//!                                     --stands_after             true if the arm stands where those steps end
//! ```
//!
//! Steps are counted over all iterations, from 0.
//! [`resume::StepCounter`](crate::resume::StepCounter) maps the index of the arm's queue to a step.

mod iterations;
mod numbering;
mod remaining;
mod timetable;

use std::sync::Arc;

use magician_host::message;
use magician_host::preflight::Preflight;
use magician_host::{Ctrl, FrameBuf, Set, burns};

pub use numbering::StepNumbering;
pub use remaining::{BurnPlace, RemainingProgram};
pub use timetable::Timetable;

use crate::yielding::{NeverYield, STEPS_PER_SLICE, Yield, run_to_end};
use crate::{Diagnostic, Plan};

/// Largest start step of an endless program: counts from there never overflow 64 bits.
const MAX_START_STEP: u64 = i64::MAX.unsigned_abs();

/// Plan that runs once, several times or endlessly.
///
/// ```
/// use magician_host::{JointAngles, ToolBias, preflight::Preflight};
/// use magician_program::{Action, Origin, Plan, Program, Travel};
///
/// let mut plan = Plan::new("to and fro");
/// for y in [0.0, 40.0] {
///     plan.push(Action::Move { to: [220.0, y, 20.0, 0.0], by: Travel::Line }, Origin::NONE);
/// }
/// let program = Program::new(plan, Some(3));
/// let rest = program.remaining(2, Preflight::at(JointAngles::HOME, ToolBias::NONE))?;
/// assert_eq!(rest.commands().count(), 4);
/// let report = rest.check();
/// let left = rest.timetable(&report).left(4);
/// assert!(report.is_good() && left.is_some_and(|left| left.is_zero()));
/// # Ok::<(), magician_program::Diagnostic>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    pub(crate) plan: Arc<Plan>,
    pub(crate) settings: Vec<Set>,
    pub(crate) iterations: Option<u64>,
    /// True if the program ends with the pen down.
    pub(crate) pen_stays_down: bool,
    pub(crate) leading: u64,
    pub(crate) numbering: StepNumbering,
}

impl Program {
    /// Creates a program of this many iterations; endless if `None`.
    #[must_use]
    pub fn new(plan: impl Into<Arc<Plan>>, iterations: Option<u64>) -> Self {
        let plan = plan.into();
        Self {
            numbering: StepNumbering::of(&plan),
            plan,
            settings: Vec::new(),
            iterations,
            pen_stays_down: false,
            leading: 0,
        }
    }

    /// Sets the number of iterations; endless if `None`.
    #[must_use]
    pub fn repeated(mut self, iterations: Option<u64>) -> Self {
        self.iterations = iterations;
        self
    }

    /// Sets commands to send before the first step: settings, which take no time.
    #[must_use]
    pub fn with_settings(mut self, settings: Vec<Set>) -> Self {
        self.settings = settings;
        self
    }

    /// Leaves the pen down at the end: omits the lift after the last line of a drawing.
    #[must_use]
    pub fn pen_stays_down(mut self, stays: bool) -> Self {
        self.pen_stays_down = stays && self.plan.ends_with_lift();
        self
    }

    /// Sets the number of leading steps of an iteration that depend on the arm's position at the
    /// start. Later steps do not depend on it.
    #[must_use]
    pub fn with_leading(mut self, steps: usize) -> Self {
        self.leading = steps as u64;
        self
    }

    /// True if starting at this step requires the arm's position at the beginning of the program.
    #[must_use]
    pub fn depends_on_start(&self, step: u64) -> bool {
        let nth = step.checked_rem(self.steps_per_iteration()).unwrap_or(0);
        step > 0 && nth < self.leading
    }

    /// True if the program, from this step on, homes the arm before it moves or burns, or neither
    /// moves nor burns.
    ///
    /// ```
    /// use magician_program::{Action, Origin, Plan, Program};
    ///
    /// let mut plan = Plan::new("homes in its middle");
    /// for action in [Action::Wait(10), Action::Home, Action::Path { to: [220.0, 0.0, 20.0] }] {
    ///     plan.push(action, Origin::NONE);
    /// }
    /// let program = Program::new(plan, Some(2));
    /// let homes = [0, 1, 2, 3].map(|step| program.homes_first(step));
    /// assert_eq!(homes, [true, true, false, true]);
    /// ```
    #[must_use]
    pub fn homes_first(&self, step: u64) -> bool {
        let each = self.plan.steps.len();
        let nth = usize::try_from(step.checked_rem(self.steps_per_iteration()).unwrap_or(0));
        let (before, rest) = self.plan.steps.split_at(nth.unwrap_or(0).min(each));
        let mut commands = { rest.iter().chain(before) }.filter_map(|step| step.action.command());
        let homes = |command: &Set| matches!(command, Set::HomeCmd(_));
        let needs_homed = |command: &Set| command.row().effect.moves_arm() || burns(command, true);
        commands
            .find(|command| homes(command) || needs_homed(command))
            .is_none_or(|first| homes(&first))
    }

    /// True if all steps depend on the position at the start.
    #[must_use]
    pub fn depends_throughout(&self) -> bool {
        self.leading > 0 && self.leading >= self.steps_per_iteration()
    }

    /// Plan of one iteration.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Plan of one iteration, consuming the program.
    #[must_use]
    pub fn into_plan(self) -> Plan {
        Arc::unwrap_or_clone(self.plan)
    }

    /// Number of iterations; `None` if endless.
    #[must_use]
    pub fn iterations(&self) -> Option<u64> {
        self.iterations
    }

    /// Number of steps in all iterations; `None` if endless.
    #[must_use]
    pub fn steps(&self) -> Option<u64> {
        let all = self.iterations?.saturating_mul(self.steps_per_iteration());
        Some(all.saturating_sub(u64::from(self.pen_stays_down)))
    }

    /// Numbering of the steps, some of which send nothing.
    #[must_use]
    pub fn numbering(&self) -> &StepNumbering {
        &self.numbering
    }

    /// Number of steps in one iteration.
    fn steps_per_iteration(&self) -> u64 {
        self.plan.steps.len() as u64
    }

    /// Checks that the program has steps from this one on. Step 0 is always accepted, since even an
    /// empty program sets the tool. An endless program must begin well before its step numbers
    /// overflow.
    ///
    /// # Errors
    /// [`Diagnostic`] that names the last step.
    pub fn check_step(&self, step: u64) -> Result<(), Diagnostic> {
        let steps = self.steps().unwrap_or(u64::MAX).min(MAX_START_STEP);
        if step == 0 || step < steps {
            return Ok(());
        }
        let step = step.saturating_add(1);
        let message = message!("there is no step {step}: the last is {steps}", step, steps);
        Err(Diagnostic::of_file(message))
    }

    /// Returns one command of each kind. `Arm::preflight_for` derives from them what to read from
    /// an arm.
    #[must_use]
    pub fn kinds(&self) -> Vec<Set> {
        let mut kinds = self.settings.clone();
        kinds.extend(self.plan.kinds());
        kinds
    }

    /// Returns the rest of the program from a step on, for an arm in the state of `start`.
    ///
    /// # Errors
    /// Same as [`check_step`](Self::check_step) and
    /// [`Continuation::from_step`](crate::Continuation::from_step).
    pub fn remaining(&self, from: u64, start: Preflight) -> Result<RemainingProgram, Diagnostic> {
        self.remaining_within(from, None, start)
    }

    /// Like [`remaining`](Self::remaining), for a run that may have stopped within the step: if the
    /// step moves straight through `at`, it continues from there, otherwise it starts over.
    /// [`RemainingProgram::resume_place`] computes step and place.
    ///
    /// # Errors
    /// Same as [`remaining`](Self::remaining).
    pub fn remaining_within(
        &self,
        from: u64,
        at: Option<[f64; 3]>,
        start: Preflight,
    ) -> Result<RemainingProgram, Diagnostic> {
        self.check_step(from)?;
        RemainingProgram::of(self, from, at, start)
    }

    /// Key of the program: equal for programs that do the same, whatever their titles.
    #[must_use]
    pub fn key(&self) -> String {
        run_to_end(self.key_yielding(&NeverYield))
    }

    /// Like [`key`](Self::key), yielding to other tasks between slices.
    pub async fn key_yielding(&self, yields: &impl Yield) -> String {
        // FNV-1a, 128 bits.
        let mut hash: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
        let mut take = |bytes: &[u8]| {
            for byte in bytes {
                hash = (hash ^ u128::from(*byte)).wrapping_mul(0x0100_0000_0000_0000_0000_013b);
            }
        };
        take(&self.iterations.unwrap_or(0).to_le_bytes());
        // Steps that differ with the start position are left out, unless all do.
        let leading = usize::try_from(self.leading).unwrap_or(usize::MAX);
        let skipped = if leading < self.plan.steps.len() {
            leading
        } else {
            0
        };
        // Steps that send nothing count too.
        let mut take_step = |command: Option<Set>, name: &str| match command {
            Some(command) => {
                if let Ok(frame) = FrameBuf::set(&command, Ctrl::QUEUED) {
                    take(frame.bytes());
                }
            }
            None => take(name.as_bytes()),
        };
        if let Some(tool) = self.plan.preamble() {
            take_step(Some(tool), "");
        }
        for slice in self
            .plan
            .steps
            .get(skipped..)
            .unwrap_or_default()
            .chunks(STEPS_PER_SLICE)
        {
            for step in slice {
                take_step(step.action.command(), step.action.name());
            }
            yields.yield_now().await;
        }
        format!("{hash:032x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Action, Origin};

    fn program(waits: u32, iterations: Option<u64>) -> Program {
        let mut plan = Plan::new("waits");
        (1..=waits).for_each(|each| plan.push(Action::Wait(each), Origin::NONE));
        Program::new(plan, iterations)
    }

    #[test]
    fn steps_are_counted_across_iterations() {
        let program = program(3, Some(2));
        assert_eq!(program.steps(), Some(6));
        assert!(program.check_step(5).is_ok());
        let diagnostic = program.check_step(6).expect_err("there are six");
        assert_eq!(diagnostic.to_string(), "there is no step 7: the last is 6");
        let endless = super::tests::program(3, None);
        assert!(endless.check_step(1 << 62).is_ok());
        assert!(endless.check_step(u64::MAX).is_err() && endless.check_step(1 << 63).is_err());
        assert!(super::tests::program(0, Some(1)).check_step(0).is_ok());
    }

    #[test]
    fn key_depends_on_commands_only() {
        let same = program(3, Some(2)).key();
        let mut named = Plan::clone(program(3, Some(2)).plan());
        "another".clone_into(&mut named.title);
        assert_eq!(Program::new(named, Some(2)).key(), same);
        for other in [program(3, Some(1)), program(3, None), program(2, Some(2))] {
            assert_ne!(other.key(), same);
        }
    }
}
