//! Runner of cases on a target.

use std::time::Duration;

use magician::commands::TABLE;
use magician::{Ctrl, Error, FrameBuf, Result};
use magician_protocol::{Chapter, Direction, Row};
use magician_sim::World;

use crate::case::{Begin, Case};
use crate::report::{Outcome, in_words};
use crate::session::{CaseStop, Session};
use crate::step::{self, Action, Step};
use crate::suite::SuiteError;
use crate::target::Target;

const BEGIN: &str = include_str!("../cases/begin.steps");
const BEGIN_MOVES: &str = include_str!("../cases/begin_moves.steps");

/// Runs cases on an arm one by one, each from the same initial state.
///
/// [`begin`](Self::begin) saves the arm's parameters, [`run`](Self::run) runs a case,
/// [`end`](Self::end) restores the parameters. If the work is aborted in between, `end` still
/// leaves the arm at rest and as it was.
pub struct Runner<T> {
    session: Session<T>,
    ready: Vec<Step>,
    ready_to_move: Vec<Step>,
    /// Requests that restore the arm's parameters.
    saved: Vec<FrameBuf>,
}

impl<T: Target> Runner<T> {
    /// Creates a runner for this target; an answer may take up to `patience`.
    ///
    /// # Errors
    /// [`SuiteError`], but never in a build whose tests pass.
    pub fn new(target: T, patience: Duration) -> std::result::Result<Self, SuiteError> {
        let read = |file: &str, text| {
            step::read_all(text, 1).map_err(|(line, message)| SuiteError {
                file: file.to_owned(),
                line,
                message,
            })
        };
        Ok(Self {
            session: Session::new(target, patience),
            ready: read("begin.steps", BEGIN)?,
            ready_to_move: read("begin_moves.steps", BEGIN_MOVES)?,
            saved: Vec::new(),
        })
    }

    /// Checks that an arm answers, and saves its parameters. Changes nothing.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`](magician::ErrorKind::Timeout) if nothing answers; errors of a lost
    /// line.
    pub async fn begin(&mut self) -> Result<()> {
        self.session.begin().await?;
        // A stepped arm is replaced for each case, so there is nothing to save.
        if self.session.target.stepped().is_some() {
            return Ok(());
        }
        if self.session.value(2).await?.is_none() {
            let message = "nothing answers GetDeviceVersion; is the arm switched on?";
            return Err(Error::new(magician::ErrorCode::NoAnswer, message));
        }
        for row in TABLE.iter().filter(|row| is_kept(row)) {
            // A parameter that this firmware does not know cannot be changed by the cases either.
            if let Some(params) = self.session.value(row.id).await? {
                self.saved.push(FrameBuf::new(row.id, Ctrl::SET, &params)?);
            }
        }
        Ok(())
    }

    /// Runs a case.
    ///
    /// # Errors
    /// Errors of a lost line.
    pub async fn run(&mut self, case: &Case) -> Result<Outcome> {
        if let Some(reason) = self.skip_reason(case) {
            return Ok(Outcome::Skipped(reason));
        }
        let done = match self.prepare(case).await {
            Ok(()) => self.session.run(&case.steps).await,
            stopped => stopped,
        };
        match done {
            Ok(()) => Ok(Outcome::Passed),
            Err(CaseStop::Mismatch(mismatch)) => Ok(Outcome::Failed(mismatch)),
            Err(CaseStop::Line(error)) => Err(error),
        }
    }

    /// Returns the reason why a case is skipped on this target.
    fn skip_reason(&self, case: &Case) -> Option<String> {
        if self.session.target.stepped().is_some() {
            return None;
        }
        let happens = |step: &Step| matches!(step.action, Action::Happens(_));
        let looks = |step: &Step| matches!(step.action, Action::Sees(_));
        let selects = |step: &Step| matches!(step.action, Action::Link(_));
        if let Some(reason) = &case.hurts {
            return Some(format!("not on a real arm: {reason}"));
        }
        if let Some(reason) = &case.sim_only {
            return Some(format!("only inside this program: {reason}"));
        }
        match case {
            case if case.begin == Begin::PowerUp => Some("it begins with a power-up".to_owned()),
            case if case.world.is_some() => Some("it needs a world around the arm".to_owned()),
            case if case.exact => Some("it needs a clock under its control".to_owned()),
            case if case.steps.iter().any(happens) => Some("it needs a hand at the arm".to_owned()),
            case if case.steps.iter().any(looks) => Some("it needs to observe the arm".to_owned()),
            case if case.steps.iter().any(selects) => Some("it needs a second link".to_owned()),
            _ => None,
        }
    }

    async fn prepare(&mut self, case: &Case) -> std::result::Result<(), CaseStop> {
        let world = case.world.as_ref().map(World::from_scenario);
        self.session.target.power_up(world.unwrap_or_default());
        self.session.begin().await?;
        if case.begin == Begin::PowerUp {
            return Ok(());
        }
        self.session.prepare(&self.ready).await?;
        if case.moves {
            self.session.prepare(&self.ready_to_move).await?;
        }
        Ok(())
    }

    /// Returns the arm.
    pub fn target(&mut self) -> &mut T {
        &mut self.session.target
    }

    /// Leaves the arm at rest, its queue empty and stopped, its tools off, and its parameters
    /// restored.
    ///
    /// # Errors
    /// Errors of a lost line; [`ErrorKind::Unexpected`](magician::ErrorKind::Unexpected) if the arm
    /// refuses its parameters.
    pub async fn end(&mut self) -> Result<()> {
        if self.session.target.stepped().is_some() {
            return Ok(());
        }
        self.session.begin().await?;
        let quiet = Duration::from_millis(300);
        // An aborted case may have left replies in flight.
        while !self.session.target.receive(quiet).await?.is_empty() {}
        let rested = self.session.prepare(&self.ready).await;
        for frame in std::mem::take(&mut self.saved) {
            if !self.session.acknowledged(&frame).await? {
                let name = in_words(&frame, Direction::Request);
                let message = format!("a parameter of the arm was not restored: {name}");
                return Err(Error::new(magician::ErrorCode::BadAnswer, message));
            }
        }
        match rested {
            Ok(()) => Ok(()),
            Err(CaseStop::Line(error)) => Err(error),
            Err(CaseStop::Mismatch(mismatch)) => {
                let message = format!(
                    "the arm could not be restored: {}: {}",
                    mismatch.step, mismatch.got
                );
                Err(Error::new(magician::ErrorCode::BadAnswer, message))
            }
        }
    }
}

/// True if the value of a row is saved and restored: it is set in the form in which it is read,
/// without side effects.
fn is_kept(row: &Row) -> bool {
    let same = row
        .value
        .zip(row.set)
        .is_some_and(|(value, set)| value.name == set.name);
    let asked = row.query.is_some_and(|query| !query.fields.is_empty());
    // Pins are left out: restoring a level could switch on what is connected to them.
    same && !asked && !row.dangerous && row.chapter != Chapter::Io
}
