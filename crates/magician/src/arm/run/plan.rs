//! Planning of a run: durations and positions of its commands before they are sent.
//!
//! The stream needs the duration of each command to keep the horizon, and a laser run its position.
//! Both come from a [`Preflight`] that follows the commands. Reading its start costs some frames,
//! so it is skipped for runs so short that nothing depends on it.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::task::{Context, Poll, Waker, ready};
use std::time::Duration;

use magician_host::picture::place;
use magician_host::raises_laser_pin;
use magician_motion::{ArmState, Fence};
use magician_protocol::Set;

use super::{CommandSource, Run};
use crate::arm::Arm;
use crate::arm::driver::micros;
use crate::arm::fence::SendPermit as FenceTurn;
use crate::connection::Micros;
use crate::message;
use crate::preflight::{CheckedProgram, Guards, Preflight, pose_of};
use crate::stream::{Beginning, Item};
use crate::{Error, ErrorCode, Result};

/// Commands always queued regardless of duration, so their durations are not computed.
const MIN_QUEUED: usize = 2;
/// Commands inspected in advance, to read only the settings they depend on. Choice: a full queue.
const INSPECTED_COMMANDS: usize = 32;
/// Commands always handed on before the arm has taken them: a line carries several at once. Choice.
const MIN_BACKLOG: usize = 4;
/// Upper bound of a duration in sums; unknown durations count as an hour.
const MAX_COUNTED_DURATION: Micros = 3_600_000_000;

/// Laser state left by a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LaserTracker {
    /// True if it has burnt.
    burnt: bool,
    /// True if the last laser command switched it on: the caller left it on deliberately.
    left_on: bool,
}

impl LaserTracker {
    fn note(&mut self, command: &Set, burns: bool) {
        self.burnt |= burns;
        if let Set::SetEndEffectorLaser(_) = command {
            self.left_on = burns;
        }
        self.left_on |= burns && raises_laser_pin(command);
    }

    /// True if the run has to switch the laser off at its end.
    pub(super) fn must_switch_off(self) -> bool {
        self.burnt && !self.left_on
    }
}

/// Commands handed on that the arm has not taken.
#[derive(Debug, Default)]
pub(super) struct Backlog {
    times: VecDeque<Micros>,
    /// Sum of `times`.
    lasts: Micros,
    /// Number of commands handed on.
    handed: u64,
}

impl Backlog {
    fn note(&mut self, time: Micros) {
        let time = time.min(MAX_COUNTED_DURATION);
        self.handed += 1;
        self.lasts += time;
        self.times.push_back(time);
    }

    /// True if more than a few are ahead and last at least `lead`, after the arm has taken `taken`.
    pub(super) fn is_long(&mut self, taken: u64, lead: Duration) -> bool {
        // More than memory holds cannot be in flight, so the bound is never reached.
        let left = usize::try_from(self.handed.saturating_sub(taken)).unwrap_or(usize::MAX);
        while self.times.len() > left {
            self.lasts -= self.times.pop_front().unwrap_or_default();
        }
        self.times.len() >= MIN_BACKLOG && self.lasts >= micros(lead)
    }
}

/// Command waiting in the run.
#[derive(Debug)]
pub(super) struct Planned {
    command: Set,
    /// Command with its duration and end position, if checked before.
    item: Option<Item>,
    /// True if it passed the fence from the start of the run.
    in_fence: bool,
    /// True if the task returned it: it was counted, and passed all checks.
    given_back: bool,
}

impl Planned {
    fn fresh(command: Set) -> Self {
        Self {
            command,
            item: None,
            in_fence: false,
            given_back: false,
        }
    }

    pub(super) fn known(item: Item) -> Self {
        Self {
            item: Some(item),
            ..Self::fresh(item.command)
        }
    }

    pub(super) fn given_back(item: Item) -> Self {
        Self {
            given_back: true,
            in_fence: true,
            ..Self::known(item)
        }
    }

    pub(super) fn command(&self) -> &Set {
        &self.command
    }
}

/// Positions along a run.
#[derive(Debug)]
pub(super) enum Route {
    Unknown,
    /// Each command is planned as it comes.
    Planned(Box<Preflight>),
    /// All commands were planned: start and end.
    Checked([Option<ArmState>; 2]),
}

impl Route {
    /// Follows the commands from the position of `check`, without refusing any.
    pub(super) fn along(check: Preflight) -> Self {
        let check = check.guards(Guards::NONE).fence(Fence::default());
        Self::Planned(Box::new(check))
    }

    pub(super) fn of(program: &CheckedProgram) -> Self {
        Self::Checked([program.start(), program.end()].map(Option::<&ArmState>::copied))
    }

    /// Returns the state before the first command.
    fn start(&self) -> Option<&ArmState> {
        match self {
            Self::Unknown => None,
            Self::Planned(check) => check.arm(),
            Self::Checked([start, _]) => start.as_ref(),
        }
    }

    /// Returns the state after the last command.
    fn end(&self) -> Option<&ArmState> {
        match self {
            Self::Unknown => None,
            Self::Planned(check) => check.arm(),
            Self::Checked([_, end]) => end.as_ref(),
        }
    }

    /// Returns the next command with its duration and end position, as far as known.
    fn item(&mut self, command: &Set) -> Item {
        match self {
            Self::Planned(check) => match check.check(command) {
                Ok(step) => Item::of(command, &step),
                // The plan refuses it: it is sent with an unknown duration, and the arm decides.
                Err(_) => Item::unknown(command),
            },
            // Without a plan the duration is unknown, and the stream sends what the queue takes.
            _ => Item::unknown(command),
        }
    }
}

impl<C: CommandSource> Run<C> {
    /// Reads the settings that durations depend on, unless there are too few commands to matter.
    pub(super) async fn plan(&mut self) -> Result<()> {
        // Planned already, by `along`, `start_checked` or an earlier `wait`.
        if std::mem::replace(&mut self.planned, true) {
            if self.pending.is_empty() {
                self.look_ahead(1);
            }
            return Ok(());
        }
        self.look_ahead(INSPECTED_COMMANDS);
        let ahead: Vec<Set> = { self.pending.iter() }
            .map(|planned| planned.command)
            .collect();
        self.arm.permission().check(&ahead)?;
        // Burning commands are split by duration, so they need one however few there are.
        let burns = ahead.iter().any(|command| self.arm.laser().burns(command));
        if self.pending.len() <= MIN_QUEUED && !burns {
            return Ok(());
        }
        let course = if self.pending.len() < INSPECTED_COMMANDS {
            self.arm.preflight_for(&ahead).await?
        } else {
            self.arm.preflight().await?
        };
        self.route = Route::along(course);
        Ok(())
    }

    /// Returns the known state of the arm before the first command, so that the stream need not
    /// read it.
    pub(super) async fn beginning(&mut self) -> Result<Option<Beginning>> {
        let Some(look) = self.queue_at_start.take() else {
            return Ok(None);
        };
        // With commands in the queue the state changes before the run begins.
        if look.waiting() > 0 || !look.is_fresh(self.arm.clock()) {
            return Ok(None);
        }
        let planned = self.route.start().map(|at| at.pose.to_array());
        let now = self.arm.clock();
        let known = || {
            let standing = self.arm.picture().standing().pose(now, &look);
            standing.as_ref().map(place)
        };
        let pose = match planned.or_else(known) {
            Some(pose) => pose,
            None => place(&self.arm.get().await?),
        };
        Ok(Some(Beginning {
            left: look.left,
            current: look.current,
            pose,
        }))
    }

    /// Notes the end of a completed run: the arm is at rest at its end position.
    pub(super) fn note_end(&self, took: Duration) {
        if let (Some(end), Some(last)) = (self.route.end(), self.summary.last) {
            self.arm.known().note_standing(last.0, pose_of(end));
        }
        // A single unknown duration makes the sum meaningless.
        if self.planned_time < Micros::MAX {
            let should = Duration::from_micros(self.planned_time);
            self.arm.picture().note_pace(should, took);
        }
    }

    /// Acquires the right to run within the fence, if any. A resumed run continues from its
    /// predicted position.
    pub(super) async fn within_fence<'a>(
        &mut self,
        arm: &'a Arm,
        begins: bool,
    ) -> Result<Option<FenceTurn<'a>>> {
        let Some(mut turn) = arm.fence_check().hold_run(begins).await? else {
            return Ok(None);
        };
        let start = turn.start();
        let place = |check: &Preflight| check.arm().map(|at| at.pose.to_array());
        if let Some(start) = start {
            let stands = place(&start);
            if self.leftover.is_some() && self.begins_at != stands {
                return Err(Error::new(
                    ErrorCode::RunOver,
                    message!("the arm is not where this run should begin; begin a new one"),
                ));
            }
            if self.leftover.is_none() {
                (self.fenced, self.begins_at) = (Some(start), stands);
                for planned in &mut self.pending {
                    planned.in_fence = false;
                }
            }
        }
        Ok(Some(turn))
    }

    /// Checks the first commands against the fence before anything is sent.
    pub(super) fn check_ahead(&mut self) -> Result<()> {
        let Some(fenced) = &mut self.fenced else {
            return Ok(());
        };
        let first = self.pending.iter_mut().take(INSPECTED_COMMANDS);
        for planned in first.filter(|planned| !planned.in_fence) {
            fenced.check(&planned.command)?;
            planned.in_fence = true;
        }
        Ok(())
    }

    /// Waits until the source has a command or ends; the command is kept.
    pub(super) async fn wait_for_command(&mut self) {
        if self.pending.is_empty()
            && let Some(command) = poll_fn(|cx| self.poll_source(cx)).await
        {
            self.pending.push_back(Planned::fresh(command));
        }
    }

    fn poll_source(&mut self, cx: &mut Context<'_>) -> Poll<Option<Set>> {
        if self.ended {
            return Poll::Ready(None);
        }
        let next = ready!(self.commands.poll_next(cx));
        self.ended = next.is_none();
        Poll::Ready(next)
    }

    /// False if the commands are known to be few and none moves the arm, like those of a belt.
    pub(super) fn may_move_arm(&mut self) -> bool {
        // A planned source keeps its commands: their speed may still change.
        if !self.planned {
            self.look_ahead(INSPECTED_COMMANDS);
        }
        let moves = |planned: &Planned| planned.command.row().effect.moves_arm();
        !self.ended || self.pending.is_empty() || self.pending.iter().any(moves)
    }

    /// Takes the commands that the source has ready.
    fn look_ahead(&mut self, count: usize) {
        let mut cx = Context::from_waker(Waker::noop());
        while self.pending.len() < count
            && let Poll::Ready(Some(command)) = self.poll_source(&mut cx)
        {
            self.pending.push_back(Planned::fresh(command));
        }
    }

    /// Returns the next command, if the source has it. Ends the run before a command that is
    /// refused or burns without permission.
    pub(super) fn next(&mut self) -> Poll<Option<Item>> {
        let planned = match self.pending.pop_front() {
            Some(planned) => planned,
            None => {
                let mut cx = Context::from_waker(Waker::noop());
                match ready!(self.poll_source(&mut cx)) {
                    Some(command) => Planned::fresh(command),
                    None => return Poll::Ready(None),
                }
            }
        };
        if let Err(error) = self.permits(&planned) {
            self.refused = Some(error);
            self.commands.close();
            return Poll::Ready(None);
        }
        let command = &planned.command;
        self.laser.note(command, self.arm.laser().burns(command));
        let item = planned.item.unwrap_or_else(|| self.route.item(command));
        if !planned.given_back {
            self.planned_time = self.planned_time.saturating_add(item.time);
        }
        if self.options.lead.is_some() {
            self.backlog.note(item.time);
        }
        Poll::Ready(Some(item))
    }

    fn permits(&mut self, planned: &Planned) -> Result<()> {
        let command = &planned.command;
        self.arm.permission().check([command])?;
        if planned.given_back {
            return Ok(());
        }
        if let Some(checks) = &mut self.checks {
            let step = self.checked;
            self.checked += 1;
            let pins = self.arm.laser().burns(command) && raises_laser_pin(command);
            let refused = if pins {
                Err(Error::invalid(
                    message!("a laser that is lit through its pins would burn on while the program has nothing to do"),
                )
                .with_command(command.row().set_name))
            } else {
                checks.check(command).map(drop)
            };
            refused.map_err(|error| error.at_step(step))?;
        }
        match &mut self.fenced {
            Some(fenced) if !planned.in_fence => fenced.check(command).map(drop),
            // Checked before the start of the run, or no fence at all.
            _ => Ok(()),
        }
    }
}
