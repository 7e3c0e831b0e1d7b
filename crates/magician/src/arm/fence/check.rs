//! Checks of what is about to be sent against the fence.

use magician_host::picture::{is_near, place};
use magician_protocol::commands::{Pose, QueuedCmdStartExec};
use magician_protocol::{Frame, Row, Set, Writable};
use tokio::time::{Instant, sleep, timeout_at};

use super::{Held, Sort, Turn};
use crate::arm::Arm;
use crate::arm::disruptions::Disruptions;
use crate::arm::halt::APART;
use crate::preflight::{Guards, Needs, Preflight, Readings};
use crate::{Action, Error, ErrorCode, Result};

/// An arm and its fence.
#[derive(Clone, Copy)]
pub(in crate::arm) struct FenceCheck<'a> {
    pub(super) arm: &'a Arm,
    pub(super) held: &'a Held,
}

impl<'a> FenceCheck<'a> {
    fn disruptions(self) -> &'a Disruptions {
        &self.arm.inner.shared.disruptions
    }

    /// What was followed ends here: the arm has to be read again.
    fn forget(self) {
        self.disruptions().depart();
    }

    /// What a frame does to the fence: refused, or with the right to send it now.
    pub(in crate::arm) async fn hold_frame(
        self,
        frame: &Frame<'_>,
        deadline: Instant,
    ) -> Result<Option<Turn<'a>>> {
        let turn = match Sort::of(frame) {
            Sort::Free => self.check_power(frame).map(|()| None),
            Sort::Ends => {
                self.forget();
                Ok(None)
            }
            Sort::Unknown(_) | Sort::Releases if !self.held.bounds_motion() => Ok(None),
            Sort::Unknown(why) => Err(refused(why)),
            Sort::Releases => self.hold_release(frame, deadline).await.map(Some),
            Sort::Governs(command) => {
                self.check_power(frame)?;
                if self.held.bounds_motion() {
                    let queued = frame.ctrl().queued();
                    let turn = self.hold_command(&command, queued, deadline).await;
                    turn.map(Some)
                } else {
                    Ok(None)
                }
            }
        };
        turn.map_err(|error| match error.command() {
            Some(_) => error,
            None => error.with_command(crate::arm::driver::command_name(frame)),
        })
    }

    /// How strong the laser would burn: that depends on nothing else.
    fn check_power(self, frame: &Frame<'_>) -> Result<()> {
        let ctrl = frame.ctrl();
        let burns = self.held.fence().and_then(|fence| fence.strongest_laser());
        if burns.is_none() || !(ctrl.write() || ctrl.queued()) {
            return Ok(());
        }
        let may = Row::with_id(frame.id()).is_some_and(|row| row.may_burn);
        match Set::decode(frame.id(), frame.params()) {
            Ok(command) => self
                .arm
                .fenced(Preflight::new(&Readings::default()))
                .check_power(&command),
            Err(_) if may => Err(refused("its parameters cannot be read")),
            Err(_) => Ok(()),
        }
    }

    async fn take(self, deadline: Instant) -> Result<Turn<'a>> {
        let prediction = timeout_at(deadline, self.held.prediction.lock()).await;
        let prediction = prediction.map_err(|_| {
            let message =
                "a run is under way, or another call is being checked against the arm's fence";
            Error::new(ErrorCode::NotSent, message)
        })?;
        Ok(Turn {
            disruptions: self.disruptions(),
            prediction,
            then: None,
            first: false,
            breaks: self.disruptions().total(),
        })
    }

    /// A motion, or what one depends on.
    async fn hold_command(
        self,
        command: &Set,
        queued: bool,
        deadline: Instant,
    ) -> Result<Turn<'a>> {
        let mut turn = self.take(deadline).await?;
        let mut check = if queued {
            self.course_end(&mut turn).await?
        } else {
            self.read_standing(&mut turn).await?
        };
        check.check(command)?;
        if queued {
            turn.then = Some(check);
        } else {
            // It is not seen to end.
            self.forget();
        }
        Ok(turn)
    }

    /// Where the arm is when all that waits was done.
    async fn course_end(self, turn: &mut Turn<'_>) -> Result<Preflight> {
        if turn.prediction.breaks == turn.breaks
            && let Some(end) = turn.prediction.end.clone()
            && self.waits_in_order(turn).await?
        {
            return Ok(end);
        }
        self.read_standing(turn).await
    }

    /// Whether what was followed still waits, or runs, and nothing else does.
    async fn waits_in_order(self, turn: &mut Turn<'_>) -> Result<bool> {
        let waiting = u64::from(self.arm.queue().waiting().await?);
        let ours = turn
            .prediction
            .waiting(self.arm.queue().current_index().await?.0);
        // The command under way may count as waiting or not.
        Ok(ours > 0 && waiting <= ours)
    }

    /// All that a motion depends on, of an arm that stands with an empty queue.
    async fn read_standing(self, turn: &mut Turn<'_>) -> Result<Preflight> {
        self.arm.come_to_rest().await?;
        let look = self.arm.known().read_queue().await?;
        if look.waiting() > 0 {
            return Err(refused(
                "its queue has unchecked commands, waiting or running; wait until they have \
                    finished",
            )
            .remedy(Action::Stop, DROPS));
        }
        if self.arm.moving() {
            self.arm.wait_still().await?;
        }
        let on_rail = (self
            .arm
            .known()
            .setting::<magician_protocol::commands::DeviceWithL>()
            .await)
            .is_ok_and(|rail| rail.with_l.is_on());
        let check = self.arm.read(Needs::all(on_rail), on_rail, &look).await?;
        let Some(start) = check.arm().map(|start| start.pose.to_array()) else {
            return Err(refused("it moves; wait until it has stopped"));
        };
        turn.first = true;
        turn.prediction.end = None;
        turn.prediction.last = look.current;
        turn.prediction.stations.clear();
        turn.prediction
            .stations
            .push_back((look.current, Some(start)));
        Ok(check.guards(Guards::NONE.reach(true).unknown_start(true)))
    }

    /// What lets a queue run: only what was checked from where the arm stands may wait there.
    async fn hold_release(self, frame: &Frame<'_>, deadline: Instant) -> Result<Turn<'a>> {
        let turn = self.take(deadline).await?;
        let waiting = self.arm.queue().waiting().await?;
        if waiting == 0 {
            if frame.id() != QueuedCmdStartExec::ROW.id {
                self.forget();
            }
            return Ok(turn);
        }
        let current = self.arm.queue().current_index().await?.0;
        let known = turn.prediction.breaks == turn.breaks && turn.prediction.end.is_some();
        let ours = turn.prediction.waiting(current);
        if !known || u64::from(waiting) > ours {
            let (commands, were) = match waiting {
                1 => ("1 command waits", "was"),
                _ => ("commands wait", "were"),
            };
            return Err(refused(&format!(
                "{commands} in its queue that {were} not checked from its position"
            ))
            .remedy(Action::Stop, DROPS));
        }
        if frame.id() == QueuedCmdStartExec::ROW.id {
            if self.arm.picture().motion().stopped() {
                self.stands_at_station(&turn, current).await?;
            }
            return Ok(turn);
        }
        // What an alarm has ended counts as finished, wherever the arm was.
        if self.arm.alarms().await?.blocking() {
            return Err(refused(
                "an alarm holds commands in its queue that were planned from another position",
            )
            .remedy(Action::Stop, DROPS));
        }
        let before: Pose = self.arm.get().await?;
        sleep(2 * APART).await;
        if self.arm.get::<Pose>().await? == before {
            self.stands_at_station(&turn, current).await?;
        }
        Ok(turn)
    }

    /// A queue at rest: the arm was not moved meanwhile.
    async fn stands_at_station(self, turn: &Turn<'_>, current: u64) -> Result<()> {
        let mut stations = turn.prediction.stations.iter().rev();
        let station = stations.find(|(index, _)| *index <= current);
        let station = station.and_then(|(_, pose)| *pose);
        let stands = place(&self.arm.get().await?);
        let is_there = station.is_some_and(|station| is_near(station, stands));
        if is_there {
            Ok(())
        } else {
            let why = "it is not where its last command left it";
            Err(refused(why).remedy(Action::Stop, DROPS))
        }
    }

    /// The right to jog, and where from.
    pub(in crate::arm) async fn hold_jog(
        self,
        deadline: Instant,
    ) -> Result<Option<(Turn<'a>, Preflight)>> {
        if !self.held.bounds_motion() {
            return Ok(None);
        }
        let mut turn = self.take(deadline).await?;
        let check = self.read_standing(&mut turn).await?;
        self.forget();
        Ok(Some((turn, check)))
    }

    /// The right to run a program, with where it begins.
    pub(in crate::arm) async fn hold_run(self, begins: bool) -> Result<Option<Turn<'a>>> {
        if !self.held.bounds_motion() {
            return Ok(None);
        }
        let mut turn = self.take(self.arm.call_deadline()).await?;
        if begins {
            turn.then = Some(self.course_end(&mut turn).await?);
        }
        Ok(Some(turn))
    }
}

/// What a stop does to the queue.
const DROPS: &str = "drops the waiting commands";

/// What a fence cannot be held against.
fn refused(why: &str) -> Error {
    Error::guarded(
        "fence",
        format!("this arm has a fence, and {why}; nothing was sent"),
    )
}
