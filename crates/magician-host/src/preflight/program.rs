//! A checked program, with the results of the check for each command.

use std::time::Duration;

use magician_motion::{ArmState, MotionError};
use magician_protocol::Set;

use super::{Preflight, Step};
use crate::Result;
use crate::stream::Item;

/// Commands that passed a check, with duration and end of each, so that a run need not compute them
/// again.
///
/// ```
/// use magician_host::build;
/// use magician_host::preflight::Preflight;
/// use magician_host::{JointAngles, ToolBias};
///
/// let there_and_back = [build::line_by(0.0, 100.0, 0.0, 0.0), build::line_by(0.0, -100.0, 0.0, 0.0)];
/// let check = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
/// let program = check.program(&there_and_back)?;
/// assert_eq!(program.time().as_millis(), 2 * 2000);
/// assert_eq!(program.items().len(), 2);
/// # Ok::<(), magician_host::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct CheckedProgram {
    check: Preflight,
    start: Option<ArmState>,
    items: Vec<Item>,
    doubt: Option<MotionError>,
}

impl CheckedProgram {
    /// Creates an empty program that begins where `check` is.
    #[must_use]
    pub fn begin(check: Preflight) -> Self {
        Self {
            start: check.arm().copied(),
            check,
            items: Vec::new(),
            doubt: None,
        }
    }

    /// Checks a command and adds it.
    ///
    /// # Errors
    /// Same as [`Preflight::check`].
    pub fn add(&mut self, command: &Set) -> Result<()> {
        let step = self.check.check(command)?;
        self.doubt = self.doubt.or(step.doubt);
        self.items.push(Item::of(command, &step));
        Ok(())
    }

    /// Checks commands and adds them, up to the first refused one.
    ///
    /// # Errors
    /// Same as [`add`](Self::add), with the [step](crate::Error::step) counted from the beginning
    /// of the program.
    pub fn extend(&mut self, commands: &[Set]) -> Result<()> {
        self.items.reserve(commands.len());
        for command in commands {
            let step = self.items.len();
            self.add(command).map_err(|error| error.at_step(step))?;
        }
        Ok(())
    }

    /// Checks that the program may end here.
    ///
    /// # Errors
    /// Same as [`Preflight::finish`].
    pub fn finish(&self) -> Result<()> {
        self.check.finish()
    }

    /// Returns the commands, with duration and end of each.
    #[must_use]
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// Returns the commands, as [`items`](Self::items).
    #[must_use]
    pub fn into_items(self) -> Vec<Item> {
        self.items
    }

    /// Returns the state of the arm before the first command. `None` if unknown.
    #[must_use]
    pub fn start(&self) -> Option<&ArmState> {
        self.start.as_ref()
    }

    /// Returns the state of the arm after the last command. `None` if unknown.
    #[must_use]
    pub fn end(&self) -> Option<&ArmState> {
        self.check.arm()
    }

    /// Returns the check after the last command.
    #[must_use]
    pub fn into_check(self) -> Preflight {
        self.check
    }

    /// Returns the bound exceeded by the first motion that not every arm can execute. `None` if
    /// there is no such motion.
    #[must_use]
    pub fn doubt(&self) -> Option<&MotionError> {
        self.doubt.as_ref()
    }

    /// Returns the duration of all commands. [`Duration::MAX`] if one of them has no known end.
    #[must_use]
    pub fn time(&self) -> Duration {
        let times = self.items.iter().map(|item| item.time);
        match times.fold(0, u64::saturating_add) {
            // Saturated by a command without a known end.
            u64::MAX => Duration::MAX,
            time => Duration::from_micros(time),
        }
    }
}

impl Preflight {
    /// Checks a whole program, including its end, from here.
    ///
    /// # Errors
    /// Same as [`check`](Self::check), with the [step](crate::Error::step), and
    /// [`finish`](Self::finish).
    pub fn program(self, commands: &[Set]) -> Result<CheckedProgram> {
        let mut program = CheckedProgram::begin(self);
        program.extend(commands)?;
        program.finish()?;
        Ok(program)
    }
}

impl Item {
    /// Creates an item from a command and the result of its check.
    #[must_use]
    pub fn of(command: &Set, step: &Step) -> Self {
        let pose = step.end.map(|end| end.pose);
        Self {
            command: *command,
            time: u64::try_from(step.time.as_micros()).unwrap_or(u64::MAX),
            end: pose.map(|pose| [pose.x, pose.y, pose.z, pose.r]),
            laser: step.laser,
        }
    }

    /// Creates an item from a command of which nothing is known; it counts as endless and burning.
    #[must_use]
    pub fn unknown(command: &Set) -> Self {
        Self {
            command: *command,
            // Without a check the worst is assumed: an unknown time fills the horizon.
            time: u64::MAX,
            end: None,
            laser: true,
        }
    }
}
