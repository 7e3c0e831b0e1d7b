//! What a run knows of its commands before it sends them.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::task::{Context, Poll, Waker, ready};
use std::time::Duration;

use magician_motion::Fence;
use magician_protocol::Set;

use super::{CommandSource, Run};
use crate::arm::Arm;
use crate::arm::driver::micros;
use crate::arm::fence::Turn as FenceTurn;
use crate::arm::known::place;
use crate::connection::Micros;
use crate::preflight::{Guards, Preflight, pose_of};
use crate::stream::{Beginning, Item};
use crate::{Error, ErrorCode, Result};
use magician_host::raises_laser_pin;

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
pub(super) enum Planned {
    /// From the caller.
    Fresh(Set),
    /// Given back by the task, with what was known of it.
    Item(Item),
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
        let ahead: Vec<Set> = self.pending.iter().map(Planned::command).collect();
        self.arm.permit(&ahead)?;
        // What burns is cut by its time, however few there are.
        let burns = ahead.iter().any(|command| self.arm.burns(command));
        if self.pending.len() <= ALWAYS && !burns {
            return Ok(());
        }
        let course = match self.pending.len() < AHEAD {
            true => self.arm.preflight_for(&ahead).await?,
            false => self.arm.preflight().await?,
        };
        self.course = Some(course.guards(Guards::NONE).fence(Fence::default()));
        Ok(())
    }

    /// What is known of the arm before anything is sent, so that it is not asked once more.
    pub(super) async fn beginning(&mut self) -> Result<Option<Beginning>> {
        let Some(look) = self.look.take() else {
            return Ok(None);
        };
        // What waits there changes until it is begun.
        if look.waiting() > 0 || !look.is_fresh() {
            return Ok(None);
        }
        let planned = self.course.as_ref().and_then(Preflight::arm);
        let planned = planned.map(|at| at.pose.to_array());
        let known = || self.arm.standing(&look).as_ref().map(place);
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
        let end = self.course.as_ref().and_then(Preflight::arm);
        if let (Some(end), Some(last)) = (end, self.ran.last) {
            self.arm.note_standing(last.0, pose_of(end));
        }
        if self.lasts < Micros::MAX {
            let should = Duration::from_micros(self.lasts);
            self.arm.note_pace(should, took);
        }
    }

    /// Takes the right to run by the arm's fence, if it has one. One that goes on does so from where it was.
    pub(super) async fn within_fence<'a>(
        &mut self,
        arm: &'a Arm,
        begins: bool,
    ) -> Result<Option<FenceTurn<'a>>> {
        let Some(mut turn) = arm.hold_run(begins).await? else {
            return Ok(None);
        };
        let start = turn.start();
        let place = |check: &Preflight| check.arm().map(|at| at.pose.to_array());
        if let Some(start) = start {
            let stands = place(&start);
            if self.leftover.is_some() && self.begins_at != stands {
                return Err(Error::new(
                    ErrorCode::RunOver,
                    "the arm is not where this run should begin; begin a new one",
                ));
            }
            if self.leftover.is_none() {
                (self.fenced, self.begins_at) = (Some(start), stands);
            }
        }
        Ok(Some(turn))
    }

    /// What is known of the beginning is checked before anything is sent.
    pub(super) fn check_ahead(&self) -> Result<()> {
        let Some(mut fenced) = self.fenced.clone() else {
            return Ok(());
        };
        let fresh = self.pending.iter().filter_map(|planned| match planned {
            Planned::Fresh(command) => Some(command),
            Planned::Item(_) => None,
        });
        for command in fresh {
            fenced.check(command)?;
        }
        Ok(())
    }

    /// Waits until the source has told something, or its end; it is kept for later.
    pub(super) async fn come(&mut self) {
        if self.pending.is_empty()
            && let Some(command) = poll_fn(|cx| self.poll_source(cx)).await
        {
            self.pending.push_back(Planned::Fresh(command));
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
        let moves = |planned: &Planned| planned.command().row().effect.moves_arm();
        !self.ended || self.pending.is_empty() || self.pending.iter().any(moves)
    }

    /// What the source has by now.
    fn look_ahead(&mut self, count: usize) {
        let mut cx = Context::from_waker(Waker::noop());
        while self.pending.len() < count
            && let Poll::Ready(Some(command)) = self.poll_source(&mut cx)
        {
            self.pending.push_back(Planned::Fresh(command));
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
                    Some(command) => Planned::Fresh(command),
                    None => return Poll::Ready(None),
                }
            }
        };
        let command = planned.command();
        if let Err(error) = self.permits(&planned, &command) {
            self.refused = Some(error);
            self.commands.close();
            return Poll::Ready(None);
        }
        self.light.note(&command, self.arm.burns(&command));
        let item = match planned {
            Planned::Item(item) => item,
            Planned::Fresh(command) => {
                let item = item(self.course.as_mut(), command);
                self.lasts = self.lasts.saturating_add(item.time);
                item
            }
        };
        if self.options.lead.is_some() {
            self.ahead.note(item.time);
        }
        Poll::Ready(Some(item))
    }

    fn permits(&mut self, planned: &Planned, command: &Set) -> Result<()> {
        self.arm.permit([command])?;
        if let Planned::Item(_) = planned {
            return Ok(());
        }
        if let Some(checks) = &mut self.checks {
            let step = self.checked;
            self.checked += 1;
            let pins = self.arm.burns(command) && raises_laser_pin(command);
            let refused = match pins {
                true => Err(Error::invalid(
                    "a laser that is lit through its pins would burn on while the program has nothing to do",
                )
                .with_command(command.row().set_name)),
                false => checks.check(command).map(drop),
            };
            refused.map_err(|error| error.at_step(step))?;
        }
        match &mut self.fenced {
            Some(fenced) => fenced.check(command).map(drop),
            None => Ok(()),
        }
    }
}

impl Planned {
    pub(super) fn command(&self) -> Set {
        match self {
            Self::Fresh(command) => *command,
            Self::Item(item) => item.command,
        }
    }
}

/// What is known of a command beforehand.
fn item(course: Option<&mut Preflight>, command: Set) -> Item {
    let unknown = Item {
        command,
        time: u64::MAX,
        end: None,
        laser: true,
    };
    let Some(Ok(step)) = course.map(|course| course.check(&command)) else {
        return unknown;
    };
    let pose = step.end.map(|end| end.pose);
    Item {
        command,
        time: micros(step.time),
        end: pose.map(|pose| [pose.x, pose.y, pose.z, pose.r]),
        laser: step.laser,
    }
}
