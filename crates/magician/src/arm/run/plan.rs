//! What a run knows of its commands before it sends them.

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
use crate::arm::fence::Turn as FenceTurn;
use crate::connection::Micros;
use crate::message;
use crate::preflight::{CheckedProgram, Guards, Preflight, pose_of};
use crate::stream::{Beginning, Item};
use crate::{Error, ErrorCode, Result};

/// So few are in the arm whatever they take: their times are of no use.
const ALWAYS: usize = 2;
/// So many are looked at beforehand, to read only what they depend on.
const AHEAD: usize = 32;
/// So many are always handed on before the arm has taken them: a line carries several at a time.
const A_FEW: usize = 4;
/// A longer or unknown duration counts as an hour.
const UNKNOWN: Micros = 3_600_000_000;

/// What a run has done with the laser.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Light {
    /// It has burnt.
    burnt: bool,
    /// The laser was switched on last and stays on: the caller left it on deliberately.
    left_on: bool,
}

impl Light {
    fn note(&mut self, command: &Set, burns: bool) {
        self.burnt |= burns;
        if let Set::SetEndEffectorLaser(_) = command {
            self.left_on = burns;
        }
        self.left_on |= burns && raises_laser_pin(command);
    }

    /// Whether the laser is to be off now.
    pub(super) fn goes_out(self) -> bool {
        self.burnt && !self.left_on
    }
}

/// Commands that were handed on and that the arm has not taken.
#[derive(Debug, Default)]
pub(super) struct Ahead {
    times: VecDeque<Micros>,
    /// Their sum.
    lasts: Micros,
    /// All that were handed on.
    handed: u64,
}

impl Ahead {
    fn note(&mut self, time: Micros) {
        let time = time.min(UNKNOWN);
        self.handed += 1;
        self.lasts += time;
        self.times.push_back(time);
    }

    /// Whether they last so long, and are more than a few, when the arm has taken so many.
    pub(super) fn is_long(&mut self, taken: u64, lead: Duration) -> bool {
        let left = usize::try_from(self.handed.saturating_sub(taken)).unwrap_or(usize::MAX);
        while self.times.len() > left {
            self.lasts -= self.times.pop_front().unwrap_or_default();
        }
        self.times.len() >= A_FEW && self.lasts >= micros(lead)
    }
}

/// A command that waits.
#[derive(Debug)]
pub(super) struct Planned {
    command: Set,
    /// The command with its time and end, if it was checked before.
    item: Option<Item>,
    /// It has passed the fence, from where the run begins.
    in_fence: bool,
    /// The task had it, and has given it back: it was counted and passed all checks.
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

/// Where a run leads.
#[derive(Debug)]
pub(super) enum Route {
    Unknown,
    /// Each command is planned as it comes.
    Planned(Box<Preflight>),
    /// All of it was planned: where it begins and ends.
    Checked([Option<ArmState>; 2]),
}

impl Route {
    /// Follows the commands from where `check` is, whatever it would refuse.
    pub(super) fn along(check: Preflight) -> Self {
        let check = check.guards(Guards::NONE).fence(Fence::default());
        Self::Planned(Box::new(check))
    }

    pub(super) fn of(program: &CheckedProgram) -> Self {
        Self::Checked([program.start(), program.end()].map(Option::<&ArmState>::copied))
    }

    /// Where the arm stands before the first command.
    fn start(&self) -> Option<&ArmState> {
        match self {
            Self::Unknown => None,
            Self::Planned(check) => check.arm(),
            Self::Checked([start, _]) => start.as_ref(),
        }
    }

    /// Where the arm stands after the last command.
    fn end(&self) -> Option<&ArmState> {
        match self {
            Self::Unknown => None,
            Self::Planned(check) => check.arm(),
            Self::Checked([_, end]) => end.as_ref(),
        }
    }

    /// What is known of the next command.
    fn item(&mut self, command: &Set) -> Item {
        match self {
            Self::Planned(check) => match check.check(command) {
                Ok(step) => Item::of(command, &step),
                Err(_) => Item::unknown(command),
            },
            _ => Item::unknown(command),
        }
    }
}

impl<C: CommandSource> Run<C> {
    /// Reads what the times of the commands depend on, unless they are too few to matter.
    pub(super) async fn plan(&mut self) -> Result<()> {
        if std::mem::replace(&mut self.planned, true) {
            if self.pending.is_empty() {
                self.look_ahead(1);
            }
            return Ok(());
        }
        self.look_ahead(AHEAD);
        let ahead: Vec<Set> = { self.pending.iter() }
            .map(|planned| planned.command)
            .collect();
        self.arm.permission().check(&ahead)?;
        // What burns is cut by its time, however few there are.
        let burns = ahead.iter().any(|command| self.arm.laser().burns(command));
        if self.pending.len() <= ALWAYS && !burns {
            return Ok(());
        }
        let course = if self.pending.len() < AHEAD {
            self.arm.preflight_for(&ahead).await?
        } else {
            self.arm.preflight().await?
        };
        self.route = Route::along(course);
        Ok(())
    }

    /// What is known of the arm before anything is sent, so that it is not asked once more.
    pub(super) async fn beginning(&mut self) -> Result<Option<Beginning>> {
        let Some(look) = self.look.take() else {
            return Ok(None);
        };
        // What waits there changes until it is begun.
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

    /// All of it is done, and nothing holds the arm: it stands where it was led.
    pub(super) fn note_end(&self, took: Duration) {
        if let (Some(end), Some(last)) = (self.route.end(), self.ran.last) {
            self.arm.known().note_standing(last.0, pose_of(end));
        }
        if self.lasts < Micros::MAX {
            let should = Duration::from_micros(self.lasts);
            self.arm.picture().note_pace(should, took);
        }
    }

    /// Takes the right to run by the arm's fence, if it has one. One that goes on does so from where it was.
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

    /// What is known of the beginning is checked before anything is sent.
    pub(super) fn check_ahead(&mut self) -> Result<()> {
        let Some(fenced) = &mut self.fenced else {
            return Ok(());
        };
        let first = self.pending.iter_mut().take(AHEAD);
        for planned in first.filter(|planned| !planned.in_fence) {
            fenced.check(&planned.command)?;
            planned.in_fence = true;
        }
        Ok(())
    }

    /// Waits until the source has told something, or its end; it is kept for later.
    pub(super) async fn come(&mut self) {
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

    /// True unless all there is are commands that do not move the arm, those of a belt for one.
    pub(super) fn may_move_arm(&mut self) -> bool {
        // A source that is planned already keeps what it has not given: its speed may still change.
        if !self.planned {
            self.look_ahead(AHEAD);
        }
        let moves = |planned: &Planned| planned.command.row().effect.moves_arm();
        !self.ended || self.pending.is_empty() || self.pending.iter().any(moves)
    }

    /// What the source has by now.
    fn look_ahead(&mut self, count: usize) {
        let mut cx = Context::from_waker(Waker::noop());
        while self.pending.len() < count
            && let Poll::Ready(Some(command)) = self.poll_source(&mut cx)
        {
            self.pending.push_back(Planned::fresh(command));
        }
    }

    /// The next command, if the source has it, unless the laser may not burn and it would, or it is refused: then the run ends
    /// before it.
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
        self.light.note(command, self.arm.laser().burns(command));
        let item = planned.item.unwrap_or_else(|| self.route.item(command));
        if !planned.given_back {
            self.lasts = self.lasts.saturating_add(item.time);
        }
        if self.options.lead.is_some() {
            self.ahead.note(item.time);
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
            _ => Ok(()),
        }
    }
}
